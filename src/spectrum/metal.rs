//! Fresnel reflectance of metals, and its fit by colour channel.

use super::observer::{daylight_at, integrate};
use super::{Spectrum, srgb_from_xyz};

/// Number of cosines at which a metal is fitted.
const ANGLES: usize = 32;

/// Returns the fraction of unpolarised light that a metal of index `eta` + i `k` reflects at an
/// angle of incidence of cosine `cos` (Born & Wolf 1999, 14.2).
pub fn fresnel(cos: f64, eta: f64, k: f64) -> f64 {
    let (cos2, eta2, k2) = (cos * cos, eta * eta, k * k);
    let sin2 = 1.0 - cos2;
    let difference = eta2 - k2 - sin2;
    let sum = difference.hypot(2.0 * eta * k);
    let real = (0.5 * (sum + difference)).max(0.0).sqrt();
    let s = (sum + cos2 - 2.0 * cos * real) / (sum + cos2 + 2.0 * cos * real);
    let (even, odd) = (cos2 * sum + sin2 * sin2, 2.0 * cos * real * sin2);
    0.5 * s * (1.0 + (even - odd) / (even + odd))
}

/// Returns the linear sRGB of daylight (D65) that a metal of these spectra reflects at an angle of
/// incidence of cosine `cos`. Saturated metals have channels above 1: gold's red is 1.02.
pub fn metal_reflectance(eta: &Spectrum, k: &Spectrum, cos: f64) -> [f64; 3] {
    srgb_from_xyz(integrate(|nm| {
        // Both are 0 only at wavelengths without data.
        daylight_at(nm) * fresnel(cos, eta.index_at(nm).max(1e-3), k.index_at(nm))
    }))
}

/// The refractive index of a metal by channel of linear sRGB.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChannelMetal {
    /// Real part of the refractive index.
    pub eta: [f32; 3],
    /// Extinction coefficient.
    pub k: [f32; 3],
    /// Factor of Fresnel's reflectance at normal incidence, which falls linearly with the cosine to
    /// 1 at grazing angles. It is above 1 if a colour is more saturated than sRGB: gold's red is
    /// 1.02.
    pub tint: [f32; 3],
}

/// Fits one real index and one extinction coefficient to each channel of linear sRGB, by least
/// squares of the difference between Fresnel's formula and the reflectance of daylight over all
/// angles.
///
/// The error for pbrt's metals is below 0.004, except for gold's red: 0.008 at the cosine 0.24.
pub fn fit_metal(eta: &Spectrum, k: &Spectrum) -> ChannelMetal {
    let cosines: [f64; ANGLES] = std::array::from_fn(|i| (i + 1) as f64 / ANGLES as f64);
    let colours = cosines.map(|cos| metal_reflectance(eta, k, cos));
    let mut fitted = ChannelMetal { eta: [0.0; 3], k: [0.0; 3], tint: [1.0; 3] };
    for channel in 0..3 {
        let tint = colours[ANGLES - 1][channel].max(1.0);
        let reflectance =
            |i: usize| (colours[i][channel] / (1.0 + (tint - 1.0) * cosines[i])).clamp(0.0, 1.0);
        let goal: [(f64, f64); ANGLES] = std::array::from_fn(|i| (cosines[i], reflectance(i)));
        let [eta, k] = fit(&goal);
        fitted.eta[channel] = eta as f32;
        fitted.k[channel] = k as f32;
        fitted.tint[channel] = tint as f32;
    }
    fitted
}

/// Returns the index and the coefficient that fit best to pairs of a cosine and a reflectance: the
/// best of a grid, improved by the Levenberg-Marquardt method in their logarithms.
fn fit(goal: &[(f64, f64); ANGLES]) -> [f64; 2] {
    let residual = |p: [f64; 2]| goal.map(|(cos, r)| fresnel(cos, p[0].exp(), p[1].exp()) - r);
    let square = |r: [f64; ANGLES]| r.iter().map(|r| r * r).sum::<f64>();
    let grid =
        |i: u32, n: u32, low: f64, high: f64| low + (high - low) * f64::from(i) / f64::from(n - 1);
    let starts = (0..12 * 14).map(|i| [grid(i % 12, 12, -3.0, 2.0), grid(i / 12, 14, -6.0, 3.0)]);
    let Some(mut best) =
        starts.min_by(|a, b| square(residual(*a)).total_cmp(&square(residual(*b))))
    else {
        return [1.0, 0.0];
    };
    let mut error = square(residual(best));
    let mut damping = 1e-3;
    for _ in 0..100 {
        let (mut normal, mut gradient) = ([[0.0; 2]; 2], [0.0; 2]);
        let slope = [0, 1].map(|i| {
            let moved = |by: f64| {
                let mut p = best;
                p[i] += by;
                residual(p)
            };
            let (up, down) = (moved(1e-5), moved(-1e-5));
            std::array::from_fn::<f64, ANGLES, _>(|j| (up[j] - down[j]) / 2e-5)
        });
        let now = residual(best);
        for j in 0..ANGLES {
            for a in 0..2 {
                gradient[a] += slope[a][j] * now[j];
                for b in 0..2 {
                    normal[a][b] += slope[a][j] * slope[b][j];
                }
            }
        }
        for a in 0..2 {
            normal[a][a] *= 1.0 + damping;
            normal[a][a] += 1e-14;
        }
        let determinant = normal[0][0] * normal[1][1] - normal[0][1] * normal[1][0];
        let step = [
            (normal[0][1] * gradient[1] - normal[1][1] * gradient[0]) / determinant,
            (normal[1][0] * gradient[0] - normal[0][0] * gradient[1]) / determinant,
        ];
        let next = [0, 1].map(|i| (best[i] + step[i]).clamp(-12.0, 5.0));
        let next_error = square(residual(next));
        if next_error < error {
            (best, error) = (next, next_error);
            damping /= 3.0;
        } else {
            damping *= 4.0;
        }
    }
    best.map(f64::exp)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::named_spectrum;

    fn spectra(metal: &str) -> [Spectrum; 2] {
        ["eta", "k"].map(|of| named_spectrum(&format!("metal-{metal}-{of}")).unwrap())
    }

    #[test]
    fn metals_have_their_published_colours() {
        // Linear sRGB at normal incidence (Hoffman 2019, "Fresnel equations considered harmful",
        // and Lagarde 2013; rounded, from various samples).
        let published = [
            ("Ag", [0.972, 0.960, 0.915]),
            ("Al", [0.913, 0.922, 0.924]),
            ("Au", [1.000, 0.782, 0.344]),
            ("Cu", [0.955, 0.638, 0.538]),
        ];
        for (name, expected) in published {
            let [eta, k] = spectra(name);
            let found = metal_reflectance(&eta, &k, 1.0);
            for channel in 0..3 {
                let off = (found[channel].min(1.0) - expected[channel]).abs();
                assert!(off < 0.002, "{name}: {found:?}");
            }
        }
    }

    #[test]
    fn the_fitted_index_reflects_as_the_spectra_at_every_angle() {
        for name in ["Ag", "Al", "Au", "Cu", "CuZn", "MgO", "TiO2"] {
            let spectra = spectra(name);
            let ChannelMetal { eta, k, tint } = fit_metal(&spectra[0], &spectra[1]);
            for cos in (1..=100).map(|i| f64::from(i) / 100.0) {
                let exact = metal_reflectance(&spectra[0], &spectra[1], cos);
                for channel in 0..3 {
                    let found = (1.0 + (f64::from(tint[channel]) - 1.0) * cos)
                        * fresnel(cos, f64::from(eta[channel]), f64::from(k[channel]));
                    let off = (found - exact[channel]).abs();
                    let within = if (name, channel) == ("Au", 0) { 0.009 } else { 0.004 };
                    assert!(off < within, "{name}, cos {cos}, channel {channel}: off by {off}");
                }
            }
        }
    }

    #[test]
    fn a_constant_index_is_recovered() {
        let ChannelMetal { eta, k, tint } =
            fit_metal(&Spectrum::Constant(0.8), &Spectrum::Constant(2.5));
        for channel in 0..3 {
            assert_eq!(tint[channel], 1.0);
            assert!((eta[channel] - 0.8).abs() < 1e-3 && (k[channel] - 2.5).abs() < 1e-3);
        }
    }

    #[test]
    fn reflectances_are_from_0_to_1_for_every_index_and_angle() {
        for eta in [0.0, 1e-3, 0.1, 1.0, 1.5, 10.0, 1e3] {
            for k in [0.0, 1e-6, 0.1, 1.0, 10.0, 1e3] {
                if eta + k == 0.0 {
                    continue;
                }
                for cos in (1..=50).map(|i| f64::from(i) / 50.0) {
                    let r = fresnel(cos, eta, k);
                    assert!((-1e-12..=1.0 + 1e-12).contains(&r), "{eta} {k} {cos}: {r}");
                }
            }
        }
        // Glass at normal incidence: ((n - 1) / (n + 1))^2.
        assert!((fresnel(1.0, 1.5, 0.0) - 0.04).abs() < 1e-12);
    }
}
