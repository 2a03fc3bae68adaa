//! Naive twin of the hair BSDF in f64, from angles. It sums sixty lobes.
#![allow(dead_code, reason = "each test file uses its own part")]

use std::f64::consts::PI;

use petzval_render::shade::bsdf::HairParameters;

/// A hair.
pub struct NaiveHair {
    absorption: [f64; 3],
    eta: f64,
    offset: f64,
    tilt: f64,
    variance: f64,
    spread: f64,
}

/// Returns e^-x I0(x), by the integral of Bessel.
fn scaled_bessel(x: f64) -> f64 {
    let steps = 40.0 + (40.0 * x.sqrt()).floor();
    let point = |i: u32| (x * ((PI * (f64::from(i) + 0.5) / steps).cos() - 1.0)).exp();
    (0..steps as u32).map(point).sum::<f64>() / steps
}

/// Returns the share of light that the surface of glass reflects, from the angles of incidence and
/// refraction (Fresnel 1823).
fn fresnel(cos: f64, eta: f64) -> f64 {
    let i = cos.min(1.0 - 1e-12).acos();
    let t = (i.sin() / eta).asin();
    let s = (i - t).sin() / (i + t).sin();
    let p = (i - t).tan() / (i + t).tan();
    (s * s + p * p) / 2.0
}

impl NaiveHair {
    pub fn new(hair: &HairParameters<f32>) -> Self {
        let (m, n) = (f64::from(hair.beta_m), f64::from(hair.beta_n));
        Self {
            absorption: hair.absorption.map(f64::from),
            eta: f64::from(hair.eta),
            offset: f64::from(hair.offset),
            tilt: f64::from(hair.tilt).to_radians(),
            variance: (0.726 * m + 0.812 * m * m + 3.7 * m.powi(20)).powi(2),
            spread: (PI / 8.0).sqrt() * (0.265 * n + 1.194 * n * n + 5.372 * n.powi(22)),
        }
    }

    /// Returns the same hair at another offset from its axis.
    pub fn at(&self, offset: f64) -> Self {
        Self { offset, ..*self }
    }

    /// Returns f |cos wi| by colour channel.
    pub fn value(&self, o: [f64; 3], i: [f64; 3]) -> [f64; 3] {
        let (eta, h, s) = (self.eta, self.offset, self.spread);
        let (theta_o, theta_i) = (o[0].clamp(-1.0, 1.0).asin(), i[0].clamp(-1.0, 1.0).asin());
        let phi = i[2].atan2(i[1]) - o[2].atan2(o[1]);
        // The ray inside a tilted cylinder is that inside a circle of another index.
        let bent = (eta * eta - theta_o.sin().powi(2)).sqrt() / theta_o.cos();
        let (gamma_o, gamma_t) = (h.asin(), (h / bent).asin());
        let theta_t = (theta_o.sin() / eta).asin();
        let path = 2.0 * gamma_t.cos() / theta_t.cos();
        let f = fresnel(theta_o.cos() * gamma_o.cos(), eta);
        let mut sum = [0.0; 3];
        for lobe in 0..4 {
            let turned = [-2.0, 1.0, 4.0, 0.0][lobe] * self.tilt;
            let a = 1.0 / ([1.0, 0.25, 4.0, 4.0][lobe] * self.variance);
            let mirrored = theta_o + turned;
            let x = theta_i.cos() * mirrored.cos().abs() * a;
            let growth = (x - theta_i.sin() * mirrored.sin() * a - a).exp();
            let longitudinal = growth * scaled_bessel(x) * a / (1.0 - (-2.0 * a).exp());
            let azimuthal = if lobe < 3 {
                let p = lobe as f64;
                let exit = 2.0 * p * gamma_t - 2.0 * gamma_o + p * PI;
                let away = (phi - exit + PI).rem_euclid(2.0 * PI) - PI;
                let density = 1.0 / (4.0 * s * (away / (2.0 * s)).cosh().powi(2));
                density / (PI / (2.0 * s)).tanh()
            } else {
                0.5 / PI
            };
            for channel in 0..3 {
                let passes = (-self.absorption[channel] * path).exp();
                let share = |p: i32| (1.0 - f).powi(2) * f.powi(p - 1) * passes.powi(p);
                let share = match lobe {
                    0 => f,
                    3 => (3..60).map(share).sum(),
                    _ => share(lobe as i32),
                };
                sum[channel] += share * longitudinal * azimuthal;
            }
        }
        sum
    }
}
