//! Subsurface scattering: random walks through a medium behind a refracting boundary.
//!
//! A path enters through the surface as through any dielectric, walks through the medium until it
//! is back at the boundary, and leaves there as from a diffuse surface (Chiang, Kutz & Burley 2016,
//! "Practical and controllable subsurface scattering for production path tracing"). Inside, the
//! boundary reflects diffusely, by the mean of Fresnel's reflectance. Light that leaves has the
//! distribution 1 - F(cos) of Jensen et al. 2001, "A practical model for subsurface light
//! transport", equation 5. Collisions do not count as path depth.

use std::sync::Arc;

use super::colours::MediumColours;
use super::homogeneous::Homogeneous;
use crate::Dispersion;

/// A medium behind a boundary, with which a material describes what is below its surface.
#[derive(Clone, Debug)]
pub struct Subsurface {
    /// The medium; it emits nothing.
    pub medium: Homogeneous,
    /// Its coefficients as colours, if a spectrum is known.
    pub colours: Option<Arc<MediumColours>>,
    /// Asymmetry of its phase function.
    pub g: f32,
    /// Refractive index of the medium over that outside, at the d line.
    pub eta: f32,
    /// The same by wavelength; `None` if it is constant.
    pub dispersion: Dispersion,
}

/// Boundary of a medium in which paths walk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiffuseBoundary {
    /// Refractive index of the medium over that outside.
    pub eta: f32,
    /// Share of diffuse light from the outside that enters.
    pub entering: f32,
    /// Probability with which light is reflected inside.
    pub(super) internal_reflectance: f32,
}

impl DiffuseBoundary {
    /// The boundary of a medium of this relative refractive index.
    pub fn new(eta: f32) -> Self {
        let n = f64::from(eta);
        let entering = 1.0 - diffuse_reflectance(n);
        // Light that enters spreads over n^2 times as much phase space, from which the same share
        // leaves: that keeps a medium in balance with its surroundings.
        let internal_reflectance = (1.0 - entering / (n * n)).clamp(0.0, 1.0) as f32;
        Self { eta, entering: entering as f32, internal_reflectance }
    }

    /// Returns the single-scattering albedo of a medium that reflects a share of diffuse light, by the
    /// dipole of Jensen et al. 2001 (equation 4, integrated over the surface; Jensen & Buhler 2002,
    /// equation 15), for a mean free path that does not matter.
    pub fn albedo_of_reflectance(&self, reflectance: f32) -> f32 {
        let inside = f64::from(self.internal_reflectance);
        let a = (1.0 + inside) / (1.0 - inside).max(1e-6);
        let reflected = |albedo: f64| {
            let root = (3.0 * (1.0 - albedo)).sqrt();
            0.5 * albedo * (1.0 + (-4.0 / 3.0 * a * root).exp()) * (-root).exp()
        };
        let target = f64::from(reflectance).clamp(0.0, 1.0);
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if reflected(middle) < target { low = middle } else { high = middle }
        }
        (0.5 * (low + high)) as f32
    }
}

/// Returns the share of diffuse light that a smooth surface of relative index `n` reflects: the
/// integral of 2 F(cos) cos over cos.
fn diffuse_reflectance(n: f64) -> f64 {
    const STEPS: usize = 4096;
    let at = |i: usize| {
        let cos = (i as f64 + 0.5) / STEPS as f64;
        let square = n * n - 1.0 + cos * cos;
        if square <= 0.0 {
            return 2.0 * cos;
        }
        let inside = square.sqrt();
        let s = (cos - inside) / (cos + inside);
        let p = (n * n * cos - inside) / (n * n * cos + inside);
        (s * s + p * p) * cos
    };
    (0..STEPS).map(at).sum::<f64>() / STEPS as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_reflectances_are_those_of_tables() {
        // Egan & Hilgeman 1979, "Optical properties of inhomogeneous materials", for n = 1.3 and 1.5.
        for (n, expected) in [(1.3, 0.0615), (1.5, 0.0918)] {
            let found = diffuse_reflectance(n);
            assert!((found - expected).abs() < 5e-4, "{n}: {found}");
        }
        assert_eq!(DiffuseBoundary::new(1.0).internal_reflectance, 0.0);
        // Orchard 1969: 0.596 inside glass of 1.5.
        let inside = DiffuseBoundary::new(1.5).internal_reflectance;
        assert!((inside - 0.596).abs() < 1e-3, "{inside}");
    }

    #[test]
    fn albedos_grow_with_the_reflectance() {
        let boundary = DiffuseBoundary::new(1.33);
        let found = [0.0, 0.1, 0.5, 0.9, 1.0].map(|r| boundary.albedo_of_reflectance(r));
        assert!(found.is_sorted() && found[0] < 1e-6 && found[4] > 0.999_99, "{found:?}");
    }
}
