//! Smooth reflectances of linear sRGB: sigmoids of quadratic polynomials of the wavelength (Jakob & Hanika
//! 2019, "A low-dimensional function space for efficient spectral upsampling").

use glam::{DMat3, DVec3};

use crate::BandSpectrum;
use crate::lab_from_srgb;
use crate::observer::VISIBLE;
use crate::wavelength_sets::wavelength_bands;

/// Most steps of a fit; most colours need four.
const STEPS: usize = 30;

/// Largest coefficient: beyond, spectra are boxes.
const LARGEST: f64 = 1e3;

/// Coefficients of the polynomial of the wavelength, which goes from -1 to 1.
type Coefficients = DVec3;

/// Returns the reflectance that has a colour in daylight; nearly, if no such spectrum has it. Channels
/// are clamped to 0 and 1.
pub(super) fn fitted(rgb: [f32; 3]) -> BandSpectrum {
    let [r, g, b] = rgb;
    if r == g && g == b {
        return BandSpectrum::of(|_| f64::from(r));
    }
    let target = DVec3::from_array(rgb.map(|c| f64::from(c).clamp(0.0, 1.0)));
    let grey = DVec3::splat((target.element_sum() / 3.0).clamp(0.01, 0.99));
    let mut best = DVec3::new(inverse_sigmoid(grey.x), 0.0, 0.0);
    // From grey to the colour: the fit of one step starts the next.
    for share in [0.25, 0.5, 0.75, 0.9, 1.0] {
        best = fit(best, lab(grey.lerp(target, share)));
    }
    let bands = wavelength_bands();
    BandSpectrum::from_bands(|band| {
        // A mean by Simpson's rule: the spectrum is smooth.
        let [low, high] = bands[band].range;
        let [first, middle, last] = [low, 0.5 * (low + high), high].map(|nm| reflectance(best, nm));
        ((first + 4.0 * middle + last) / 6.0) as f32
    })
}

/// Improves coefficients until their colour is a goal in CIELAB, by the Levenberg-Marquardt method.
fn fit(start: Coefficients, goal: DVec3) -> Coefficients {
    let off = |c: Coefficients| lab(colour(c)) - goal;
    let (mut best, mut damping) = (start, 1e-6);
    let mut error = off(best);
    for _ in 0..STEPS {
        if error.length() < 1e-5 || damping > 1e8 {
            break;
        }
        let slope = |axis: DVec3| {
            let step = 1e-5 * (1.0 + best.dot(axis).abs());
            (off(best + step * axis) - error) / step
        };
        let jacobian = DMat3::from_cols(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z));
        let mut normal = jacobian.transpose() * jacobian;
        for i in 0..3 {
            normal.col_mut(i)[i] += damping * (normal.col(i)[i] + 1e-9);
        }
        let next = best - normal.inverse() * (jacobian.transpose() * error);
        let left = off(next);
        if left.length() < error.length() && next.abs().max_element() < LARGEST {
            (best, error, damping) = (next, left, 0.1 * damping);
        } else {
            damping = 10.0 * damping.max(1e-9);
        }
    }
    best
}

/// Returns the linear sRGB of a reflectance in daylight.
fn colour(c: Coefficients) -> DVec3 {
    let mut rgb = DVec3::ZERO;
    for band in wavelength_bands() {
        rgb += reflectance(c, band.centre) * DVec3::from_array(band.response);
    }
    rgb
}

fn reflectance(c: Coefficients, nm: f64) -> f64 {
    let [low, high] = VISIBLE.map(f64::from);
    let t = (2.0 * nm - low - high) / (high - low);
    let x = c.x + t * (c.y + t * c.z);
    0.5 + 0.5 * x / (1.0 + x * x).sqrt()
}

fn inverse_sigmoid(value: f64) -> f64 {
    (value - 0.5) / (value * (1.0 - value)).sqrt()
}

/// Converts linear sRGB to CIELAB.
fn lab(rgb: DVec3) -> DVec3 {
    DVec3::from_array(lab_from_srgb(rgb.to_array()))
}
