//! `petzval lens --psf`: a picture of how a lens spreads a point of white light.

use std::path::Path;

use petzval::diffraction::Spread;
use petzval::image::{Encoding, Picture, Window};
use petzval::lens::{Aim, ExitPupil, Prescription, RealLens, Wavefront};
use petzval::spectrum::bands;

use super::Failure;

/// Width and height of the picture, pixels.
const SIDE: usize = 768;
/// Radii of the Airy disc from its middle to its edge.
const RADII: f64 = 24.0;
/// Powers of ten from white to black.
const DECADES: f64 = 6.0;
/// A wavelength in the middle of the visible light, um.
const GREEN: f64 = 0.55;

/// Draws the spread of a point of the film (mm, as seen from behind the camera), log-scaled, and
/// says its scale.
pub(super) fn draw(
    path: &Path,
    lens: &Prescription,
    film: f64,
    at: [f64; 2],
) -> Result<String, Failure> {
    let radius = at[0].hypot(at[1]) + 1.0;
    let lens = RealLens::new(lens.clone(), film, radius, Aim::Pupil, 1.0, 0.0);
    let Some(pupil) = ExitPupil::seen(&lens, at) else {
        return Err(format!("--psf: no light comes to {}, {} mm", at[0], at[1]).into());
    };
    let airy = pupil.airy(GREEN);
    let pitch = 2.0 * RADII * airy / SIDE as f64;
    let spread = Spread::new(&pupil, &bands(), RADII * airy * 1.5, pitch);
    let place = |i: usize| (i as f64 + 0.5 - SIDE as f64 / 2.0) * pitch;
    let peak = spread.at([0.0; 2]);
    let pixel = |i: usize| {
        // As pictures are: the film's mirror image in x and upside down.
        let there = spread.at([-place(i % SIDE), place(i / SIDE)]);
        let code = |c: usize| (1.0 + (there[c] / peak[c]).log10() / DECADES).max(0.0);
        // Even steps to the eye for even factors.
        [0, 1, 2].map(|c| petzval::image::srgb_decode(code(c) as f32))
    };
    let picture = Picture { size: [SIDE; 2], pixels: (0..SIDE * SIDE).map(pixel).collect() };
    let window = Window { origin: [0, 0], frame: [SIDE as u32; 2] };
    picture.write(path, window, Encoding::default(), &Vec::new())?;
    let front = Wavefront::of(&lens, at, &pupil).map_or_else(String::new, |front| {
        format!(", wavefront {:.3} waves rms", 1e3 * front.rms / GREEN)
    });
    Ok(format!(
        "{}: the spread of the pupil at ({}, {}) mm, {:.1} um wide, {DECADES} decades from white to \
         black; f/{:.2}, Airy radius {airy:.2} um{front}\n",
        path.display(),
        at[0],
        at[1],
        2.0 * RADII * airy,
        0.5 / pupil.sine(),
    ))
}
