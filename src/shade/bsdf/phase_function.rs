//! Phase function of scattering in a medium.

use std::f32::consts::PI;

use super::shading_frame::ShadingFrame;

/// Largest magnitude of the asymmetry, as in pbrt-v4.
const MAX_G: f32 = 0.99;

/// Returns the phase function of Henyey & Greenstein 1941, by solid angle. `cos` is the cosine
/// between the directions to where light goes and to where it comes from, so forward scattering
/// (`g` > 0) is strongest at -1.
pub fn henyey_greenstein(cos: f32, g: f32) -> f32 {
    let g = g.clamp(-MAX_G, MAX_G);
    let spread = (1.0 + g * g + 2.0 * g * cos).max(f32::MIN_POSITIVE);
    (1.0 - g * g) / (4.0 * PI * spread * spread.sqrt())
}

/// Samples a direction to where light comes from, with the density of [`henyey_greenstein`].
pub fn sample_henyey_greenstein(wo: [f32; 3], g: f32, u: [f32; 2]) -> [f32; 3] {
    let g = g.clamp(-MAX_G, MAX_G);
    let cos = if g.abs() < 1e-3 {
        1.0 - 2.0 * u[0]
    } else {
        let quotient = (1.0 - g * g) / (1.0 + g - 2.0 * g * u[0]);
        -(1.0 + g * g - quotient * quotient) / (2.0 * g)
    };
    let cos = cos.clamp(-1.0, 1.0);
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let (y, x) = (2.0 * PI * u[1]).sin_cos();
    ShadingFrame::about(wo, [0.0; 3]).to_world([sin * x, sin * y, cos])
}
