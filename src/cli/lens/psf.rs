//! `petzval lens --psf`: picture of a pupil's point spread in white light.

use petzval_base::io::OutputFile;
use petzval_image::{EncodingOptions, Picture, PictureWindow};
use petzval_lens::{ExitPupil, FilmMap, Prescription, PupilSampling, RealLens, Wavefront};
use petzval_render::diffraction::PointSpread;
use petzval_spectrum::bands;

use crate::cli::Failure;

/// Width and height of the picture (pixels).
const SIDE: usize = 768;
/// Half width of the picture [Airy radii].
const RADII: f64 = 24.0;
/// Decades of brightness from white to black.
const DECADES: f64 = 6.0;
/// A wavelength in the middle of the visible light (um).
const GREEN: f64 = 0.55;

/// Draws the point spread at a point of the film (`at`, as seen from behind the camera (mm)), on a
/// logarithmic scale. Returns a line with its scale.
///
/// # Errors
/// Returns an error if no light reaches the point, or the file cannot be written.
pub(super) fn draw(
    file: &OutputFile,
    lens: &Prescription,
    film: f64,
    at: [f64; 2],
) -> Result<String, Failure> {
    let radius = at[0].hypot(at[1]) + 1.0;
    let sampling = if at == [0.0; 2] { PupilSampling::Axis } else { PupilSampling::Pupil };
    let lens = RealLens::new(lens.clone(), film, radius, sampling, 1.0, 0.0);
    let Some(pupil) = ExitPupil::trace(&lens, at) else {
        return Err(format!("--psf: no light reaches the film at {}, {} mm", at[0], at[1]).into());
    };
    let airy = pupil.airy_radius(GREEN);
    let pitch = 2.0 * RADII * airy / SIDE as f64;
    let spread = PointSpread::new(&pupil, &bands(), RADII * airy * 1.5, pitch);
    let map = FilmMap::new([pitch * SIDE as f64; 2], [SIDE as u32; 2]);
    let peak = spread.at([0.0; 2]);
    let pixel = |i: usize| {
        let at = map.film_point([i % SIDE, i / SIDE].map(|at| at as f64 + 0.5));
        let there = spread.at(at);
        let code = |c: usize| (1.0 + (there[c] / peak[c]).log10() / DECADES).max(0.0);
        // Equal factors become equal steps of the display's signal.
        [0, 1, 2].map(|c| petzval_image::srgb_decode(code(c) as f32))
    };
    let picture = Picture { size: [SIDE; 2], pixels: (0..SIDE * SIDE).map(pixel).collect() };
    let window = PictureWindow { origin: [0, 0], frame: [SIDE as u32; 2] };
    picture.write(file, window, EncodingOptions::default(), &Vec::new())?;
    let front = Wavefront::new(&lens, at, &pupil).map_or_else(String::new, |front| {
        format!(", wavefront {:.3} waves rms", 1e3 * front.rms / GREEN)
    });
    Ok(format!(
        "{}: point spread of the pupil at ({}, {}) mm, {:.1} um wide, {DECADES} decades from white to \
         black; f/{:.2}, Airy radius {airy:.2} um{front}\n",
        file.display(),
        at[0],
        at[1],
        2.0 * RADII * airy,
        0.5 / pupil.numerical_aperture(),
    ))
}
