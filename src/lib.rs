//! Photographs 3-D scenes through real, multi-element camera lenses.
//!
//! Petzval reads scenes in the language of pbrt-v4 and lenses as tables of radii, thicknesses, glasses
//! and diameters. It traces every ray through every surface of the lens, so depth of field, bokeh,
//! vignetting, distortion and aberrations are those of the lens; dispersion, ghosts, diffraction, motion
//! and the sensor are simulated where a picture shows them. It writes OpenEXR, PNG and JPEG.
//!
//! ```
//! use std::path::Path;
//!
//! use petzval::image::{Encoding, Window};
//! use petzval::job::{Changes, prepare};
//! use petzval::render::{Backend, Progress, render};
//! use petzval::scene::pbrt;
//!
//! # let folder = tempfile::tempdir()?;
//! // Read the scene, make it ready with 4 samples a pixel, and render it with a thread for each core.
//! let description = pbrt::read(Path::new("scenes/dgauss.pbrt"))?;
//! let changes =
//!     Changes { samples: Some(4), resolution: Some([120, 120]), ..Changes::default() };
//! let (job, notes, _warnings) = prepare(description, &changes)?;
//! let exposed = render(&job, Backend::Simd, 0, &Progress::default())?;
//!
//! let window = Window { origin: job.frame.low, frame: job.frame.resolution };
//! let file = folder.path().join("dgauss.exr");
//! exposed.into_picture(&job).write(&file, window, Encoding::default(), &notes)?;
//! # assert!(file.metadata()?.len() > 0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`scene::pbrt::read`] reads a scene, [`job::prepare`] adds the lens, its focus and the plan of
//! effects, [`render::render`] renders, and [`image::Picture`] writes. [`lens`] traces rays through a
//! lens alone, and [`metric`] compares pictures. The folder `examples/` has a small program for each.
//!
//! # Goals
//!
//! 1. Show what accuracy costs in time.
//! 2. Hard cases stay numerically stable, and tests prove it.
//! 3. Only the effects that a scene calls for are simulated; what is off costs nothing.
//!
//! # What flows
//!
//! A *wave* is about a thousand rays in structure-of-arrays columns ([`rays`]), owned by one
//! worker. It moves through stages, eight lanes at a time, and nothing allocates inside it:
//!
//! | module | stage | from, to |
//! |---|---|---|
//! | [`film`] | `sample` | pixels, to film and pupil points |
//! | [`shutter`] | `tell` | samples, to times; where something moves |
//! | [`lens`] | `expose`: aim, trace, emerge | film points, to rays in the world; vignetted rays are left out |
//! | [`lens`], [`film`] | `land`, `add`, `tint` | rays, to their colours; where bands of the light share them |
//! | [`scene`] | `intersect` | rays, to nearest hits |
//! | [`shade`] | `shade` | hits, to shadow rays and the next rays of the paths |
//! | [`scene`] | `occlude` | shadow rays, to radiance |
//! | [`film`] | `accumulate` | radiance, to the sums of the tile that the worker owns |
//! | [`diffraction`] | `spread` | the finished picture, by the shape of the pupil; where planned |
//! | [`sensor`] | `read_out` | the finished picture, to what photosites record; where asked for |
//!
//! [`render`] is the only module that knows this order. Stages do not call each other; shading
//! reads the scene's data. [`job`] turns what a scene file asks for into what `render` needs.
//! [`accuracy`] renders a scene by a ladder of camera models, and says what each costs and gets wrong;
//! [`contact`] lays the pictures of a sweep side by side.
//!
//! # Decisions
//!
//! **One source for one lane and for eight.** Kernels are generic over [`lanes::Real`] and
//! compiled for `f32`, `f64` and `f32x8`; lanes round as lone floats do, so the scalar and SIMD
//! pictures are the same bit for bit, and that is a test. The tests' oracle is another source.
//!
//! **x86-64-v3, never native.** `wide` chooses its instructions when it is compiled, so the whole
//! build asks for AVX2 and FMA in `.cargo/config.toml`. The command looks at the CPU first.
//!
//! **Surfaces from their vertices.** A sphere is a curvature, not a centre: planes are nothing
//! special and a radius of 1e9 mm loses nothing ([`lens::trace`]).
//!
//! **A kernel a kind.** Spheres, conics, cylinders, aspheres and openings are monomorphised apart,
//! one stage over the batch each: a lens of spheres pays nothing for aspheres. An asphere approaches
//! its surface in stages of its own, which hide the latency of Newton's iteration.
//!
//! **What stands askew is turned to.** Between surfaces that do not stand square to each other a turn
//! is one more stage, so no kernel knows of poses; film that is tilted is a parameter of the loop that
//! aims, and its pupils are found by spokes about the axis ([`lens::Pose`]).
//!
//! **Doubt is noted, and settled in f64.** One comparison, which total reflection needs anyway,
//! tells the rays that f32 cannot trace exactly enough ([`lens::settle`]).
//!
//! **Cruder models are lenses too.** An ideal lens is a row of a prescription, a polynomial a kind of
//! surface: stop, rims, pupils and film stay what they are, so a picture differs by the model alone
//! ([`lens::Fidelity`]).
//!
//! **The pupil is a fan of triangles** of equal area, found by tracing and mixed across the film:
//! samples cost a look-up of two corners and no trigonometry, and 98 % of the rays come through
//! ([`lens::PupilBound`]).
//!
//! **Four bands share a ray.** Where a lens takes the light apart, each ray is traced for a hero among
//! 32 bands, and taken back to the film in three others; the balance heuristic of the four needs
//! only the pixel's filter where they land, for a lens keeps etendue ([`film::Colours`]).
//!
//! **Compact once, after the lens.** Lost rays are poisoned by a NaN on the way, which no
//! comparison lets through.
//!
//! **Columns of 63 cache lines.** With 64 they all begin in the same set of the L1 cache, and
//! the lens stage takes twice as long ([`rays::WAVE`]).
//!
//! **Samples are functions.** A random number depends on pixel, sample index, dimension and
//! seed, and on nothing else ([`sampler`]); a picture does not depend on threads or tiles.
//!
//! **Sums are added in one order.** What a tile receives from some of its samples is a share; shares
//! are done in any order and added in one. So a render that was interrupted ends with the same picture
//! bit for bit, and a checkpoint is the sums so far and the shares that are done ([`checkpoint`]).
//!
//! **obvhs builds the tree, we walk it.** Its triangle test leaks and takes one ray against one
//! triangle; ours is watertight and takes eight. Rays of one octant walk in bundles of eight until
//! they part, and what a ray meets does not depend on its bundle. Quadrics are exact, in f64.
//!
//! **Lights by a tree of triangles.** Each emitting triangle is a leaf of its own, eight branches
//! are weighed at once, and the choice sees only where a point is: so a ray that runs into a light
//! finds again how likely it was sampled. Triangles and balls are sampled by solid angle in f64.
//!
//! **What moves is apart.** Moving copies of objects are not in the tree of the world but in a few
//! trees of the boxes they pass, each for a part of the exposure, and rays meet them in stages of
//! their own at the time of their sample ([`shutter::Timing`]). Where nothing moves there are no such
//! stages; a camera that moves is one at rest whose rays are carried on ([`motion::Motion::carry`]).
//!
//! **Shading by kind of surface.** Hits are sorted by kind, and the scattering functions of a
//! kind are evaluated eight at a time; only varnish, a random walk, goes one by one. Light is
//! gathered by light samples and by what the next ray meets, weighed by the power heuristic.
//! Uniform skies are left to the next ray; a diffuse surface at the end of a path needs none
//! where there is no sky ([`shade`]).
//!
//! **Filters place samples.** A sample belongs to one pixel and lies where its filter is large:
//! tiles need no borders ([`film::filter`]).
//!
//! **Our own readers** for pbrt's language and PLY: every error names file, line and column, and
//! what is known but unsupported is a row in a table that says what is done instead.
//!
//! # Units and frames
//!
//! Lens space is in millimetres with its axis along z. Camera space has +z to the scene, x to the
//! right and y up (left-handed, as in pbrt). World space is the scene file's. Public items say
//! which they mean.

pub mod accuracy;
pub mod aov;
pub mod checkpoint;
pub mod contact;
pub mod diffraction;
mod distribution;
pub mod film;
pub mod ghosts;
pub mod image;
pub mod job;
pub mod lanes;
pub mod lens;
pub mod memory;
pub mod metric;
pub mod motion;
pub mod plan;
pub mod rays;
pub mod render;
pub mod sampler;
pub mod scene;
pub mod sensor;
pub mod shade;
pub mod shutter;
pub mod source;
pub mod spectrum;
pub mod stats;
mod svg;
mod thread_time;
