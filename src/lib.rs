//! Renderer that photographs 3-D scenes through real, multi-element camera lenses.
//!
//! Petzval reads scenes in the language of pbrt-v4, and lenses as tables of radii, thicknesses,
//! glasses and diameters. It traces every ray through every surface of the lens, so depth of field,
//! bokeh, vignetting, distortion and aberrations are those of the lens. It simulates dispersion,
//! ghosts, diffraction, motion and the sensor if a picture shows them. It writes OpenEXR, PNG and
//! JPEG.
//!
//! ```
//! use std::path::Path;
//!
//! use petzval::{
//!     Changes, EncodingOptions, OutputFile, Prepared, RenderOptions, prepare, read_scene, render,
//! };
//!
//! # let folder = tempfile::tempdir()?;
//! // Read the scene, prepare it with 4 samples per pixel, and render it on all cores.
//! let description = read_scene(Path::new("scenes/dgauss.pbrt"))?;
//! let changes =
//!     Changes { samples: Some(4), resolution: Some([120, 120]), ..Changes::default() };
//! let Prepared { job, notes, .. } = prepare(description, &changes)?;
//! let output = render(&job, RenderOptions::default())?;
//!
//! let file = folder.path().join("dgauss.exr");
//! let encoding = EncodingOptions::default();
//! // An output is none of the files that the picture was read from.
//! let output_file = OutputFile::new(&file, &job.files)?;
//! output.into_picture(&job).write(&output_file, job.frame.window(), encoding, &notes)?;
//! # assert!(file.metadata()?.len() > 0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`read_scene`] reads a scene. [`prepare`](prepare()) adds the lens, its focus and the plan of
//! effects. [`render`](render()) renders, and [`Picture`] writes. [`read_lens`] and [`trace_one`] trace
//! rays through a lens alone, and [`measure`] compares pictures. The folder `examples/` has a small
//! program for each.
//!
//! The items below are the common interface. They come from the crates of this workspace, each with a
//! front page of its own; a program may add one of them alone:
//!
//! | crate | holds |
//! |---|---|
//! | [`petzval_base`] | lanes, rays, random numbers, statistics, files |
//! | [`petzval_spectrum`] | bands, colour spaces, illuminants, metals, glass catalogues |
//! | [`petzval_image`] | pictures and their files |
//! | [`petzval_lens`] | prescription, trace, pupil, focus, camera |
//! | [`petzval_lens_formats`] | readers and writers of lens files |
//! | [`petzval_optics`] | image quality, calibration, tolerances, optimisation |
//! | [`petzval_scene`] | geometry, BVH, lights, textures, media, materials |
//! | [`petzval_scene_formats`] | pbrt-v4, glTF, PLY, NanoVDB |
//! | [`petzval_render`] | stages, effects, plan, job, the loop |
//! | [`petzval_tools`] | accuracy ladder, metrics, data sets, rates |
//! | `petzval_report` | plots, drawings of lenses, reports (feature `report`) |
//!
//! # Features
//!
//! | feature | adds |
//! |---|---|
//! | `cli` (default) | dependencies of the command |
//! | `report` (default) | dependencies of its drawings, plots and reports |
//!
//! A program that uses the library alone needs none of them: `default-features = false`. It should
//! compile for AVX2 and FMA, with `-C target-cpu=x86-64-v3` in its own `.cargo/config.toml`; the
//! portable build takes 1.5 times as long for a picture, and 3 times for rays through a lens.
//!
//! # Goals
//!
//! 1. Show what accuracy costs in time.
//! 2. Keep hard cases numerically stable, and prove it by tests.
//! 3. Simulate only the effects that a scene calls for. An effect that is off costs nothing.
//!
//! # Data flow
//!
//! A *wave* is a batch of about a thousand rays in structure-of-arrays columns (`rays`). Each worker
//! owns one, and uses it again and again. It moves through stages, eight lanes at a time:
//!
//! | module | stage | input, output |
//! |---|---|---|
//! | `film` | `sample` | pixels, to points on film and pupil |
//! | `shutter` | `assign_times` | samples, to times, if anything moves |
//! | `lens` | `find_pupil_halves` | samples, to the halves of the pupil that they pass, for dual pixels |
//! | `lens` | `generate_rays` | film points, to rays in the world, without the vignetted rays |
//! | `lens`, `film` | `disperse` | rays, to the weights of their wavelengths, if the lens disperses |
//! | `scene` | `intersect` | rays, to nearest hits |
//! | `shade` | `shade` | hits, to shadow rays and the next rays of the paths |
//! | `scene` | `occlude` | shadow rays, to radiance |
//! | `film` | `accumulate` | radiance, to the sums of the worker's tile |
//! | `diffraction` | `spread` | finished picture, blurred by the point spread of the pupil, if planned |
//! | `sensor` | `read_out` | finished picture, to photosite values, if a sensor is given |
//!
//! `wave` and `advance` of `petzval_render` are the only modules that know this order. The paths of caustics
//! and replays of a sample advance by the same function. Stages do not call each other. `prepare` turns a
//! scene file and the changes of the user into a [`Job`], which is plain data; `plan` decides which effects
//! it needs. `accuracy` renders a scene with a ladder of camera models and measures what each costs and gets
//! wrong. Cargo enforces that crates import downwards only.
//!
//! # Decisions
//!
//! **One source for one lane and for eight.** Kernels are generic over `lanes::Real` and compiled for
//! `f32`, `f64`, `f32x8` and `f64x8`. Lanes round as single floats do, so the scalar and the SIMD
//! picture are equal bit for bit. The tests compare kernels with naive twins in f64.
//!
//! **x86-64-v3, not native.** `wide` selects its instructions at compile time, so
//! `.cargo/config.toml` asks for AVX2 and FMA. The command checks the CPU before it runs.
//!
//! **Surfaces are relative to their vertices.** A sphere is a curvature, not a centre. A plane is not a
//! special case, and a radius of 1e9 mm loses no precision.
//!
//! **One kernel per kind of surface.** Spheres, conics, cylinders, aspheres and stops are separate
//! monomorphised stages over the batch, so a lens of spheres pays nothing for aspheres. An asphere
//! approaches its surface in several stages, which hide the latency of Newton's iteration.
//!
//! **Tilted and decentred elements are frame changes.** A change of frame between two surfaces is a
//! stage of its own, so no kernel handles poses. The tilt of the film is a parameter of the aiming
//! stage.
//!
//! **Doubtful rays are traced again in f64.** One comparison, which total reflection needs anyway,
//! finds the rays that f32 cannot trace exactly enough.
//!
//! **Simpler camera models are lenses too.** An ideal lens is one row of a prescription, and a
//! polynomial is a kind of surface. Stop, rims, pupil and film stay the same, so pictures differ only
//! by the model ([`Fidelity`]).
//!
//! **The pupil is a fan of triangles** of equal area, found by tracing and interpolated over the film.
//! A sample costs one look-up of two corners and no trigonometry, and 98 % of the rays pass the lens.
//!
//! **Four wavelengths share a ray.** If a lens disperses, a ray is traced at a hero wavelength of 32
//! bands and reprojected to the film in three others. The balance heuristic over the four needs only
//! the values of the pixel filter, because a lens conserves etendue (Wilkie et al. 2014).
//!
//! **Rays are compacted once, after the lens.** Inside the lens a NaN marks a blocked ray, and no
//! comparison accepts it.
//!
//! **Columns of 63 cache lines.** Columns of 64 lines would all start in the same set of the L1
//! cache, which doubles the time of the lens stage.
//!
//! **Samples are functions.** A random number depends only on pixel, sample index, dimension and seed.
//! The picture does not depend on threads or tiles.
//!
//! **Sums have one order.** Workers finish work items in any order, and their results are added in one
//! order. An interrupted render therefore ends with the same picture bit for bit. A checkpoint holds
//! the sums and the completed items.
//!
//! **obvhs builds the BVH; our code traverses it.** The triangle test of obvhs leaks at edges and takes
//! one ray and one triangle. Ours is watertight and takes eight. Rays of one octant traverse in
//! packets of eight until they diverge, and hits do not depend on the packet. Quadrics are intersected
//! in f64.
//!
//! **A light tree over triangles.** Each emitting triangle is a leaf, and eight branches are weighed at
//! once. The weights depend only on the shading point and the side from which it receives light, so
//! the density of a light that a BSDF ray hits is known. Triangles and spheres are sampled by solid
//! angle, in f32 without cancellation. Of a sky with a picture, directions brighter than the mean are
//! sampled; BSDF sampling finds the others.
//!
//! **Vertices are sorted by material, and shaded eight at a time.** Each stage of shading fills
//! columns: surface points, texture look-ups, lights, BSDFs, next rays. One copy of the mathematics
//! serves one lane and eight, which give the same bits.
//!
//! **Animated instances are separate.** They are not in the BVH of the world but in a few BVHs of their
//! swept bounds, one for each part of the exposure. Static scenes have no such stage. A moving camera
//! is a static one whose rays are transformed by its motion.
//!
//! **Shading by kind of material.** Hits are sorted by kind, and the BSDFs of one kind are evaluated
//! eight at a time; the random walks of layered coatings go in step. Direct light combines
//! light samples and BSDF samples by the power heuristic (Veach 1995).
//!
//! **Filters place samples.** A sample belongs to one pixel and is distributed by the pixel filter, so
//! tiles need no borders.
//!
//! **Readers of our own** for pbrt's language and for PLY: every error names file, line and column.
//! Features that are known but unsupported are rows of a table that says what happens instead.
//!
//! # Units and frames
//!
//! Lens space is in millimetres, with the optical axis along z. Camera space has +z towards the scene,
//! x to the right and y up (left-handed, as in pbrt). World space is that of the scene file. Public
//! items state their units and frame.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub use petzval_base::io::{OutputFile, ReadContext};
pub use petzval_image::{DisplayExposure, EncodingOptions, ImageError, Picture};
pub use petzval_lens::{
    Fidelity, LensError, LensRay, Paraxial, Prescription, RealRayFocus, Side, sequence, trace_one,
};
pub use petzval_lens_formats::read as read_lens;
pub use petzval_render::aov::Aov;
pub use petzval_render::job::{Job, StopCriteria};
pub use petzval_render::plan::{Effect, EffectSelection};
pub use petzval_render::prepare::{Changes, FocusOn, PrepareError, Prepared, prepare};
pub use petzval_render::{Progress, RenderError, RenderOptions, RenderOutput, render};
pub use petzval_scene_formats::pbrt::{Description, SceneError, SceneErrors};
pub use petzval_scene_formats::read as read_scene;
pub use petzval_tools::metric::{Measurement, Metric, measure};
