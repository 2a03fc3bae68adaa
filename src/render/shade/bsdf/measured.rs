//! Measured surface, for one lane.

use glam::Vec3;

use super::BsdfSample;
use petzval_scene::{MeasuredSample, MeasuredSurface, uplifted};

/// The reflection of a measured surface (Dupuy & Jakob 2018), the same from both sides.
///
/// Its tables have no kernel over lanes: vertices are evaluated one at a time.
#[derive(Clone, Copy, Debug)]
pub struct Measured<'a> {
    /// Table of the surface.
    pub surface: &'a MeasuredSurface,
    /// Matrix of its colours, if paths carry other channels than RGB.
    pub uplift: Option<[[f32; 3]; 3]>,
}

/// Returns the angle from the normal and the azimuth of a unit vector.
fn spherical([x, y, z]: [f32; 3]) -> [f32; 2] {
    [x.hypot(y).atan2(z), y.atan2(x)]
}

/// Turns a pair of directions so that the first is above the surface.
fn upright(wo: [f32; 3], wi: [f32; 3]) -> [[f32; 3]; 2] {
    if wo[2] < 0.0 { [wo, wi].map(|w| w.map(|c| -c)) } else { [wo, wi] }
}

impl Measured<'_> {
    /// Returns f |cos wi| by colour channel, and the density with which [`Self::sample`] samples
    /// `wi`; see [`super::Bsdf::evaluate`].
    pub fn evaluate(&self, wo: [f32; 3], wi: [f32; 3]) -> ([f32; 3], f32) {
        let [wo, wi] = upright(wo, wi).map(Vec3::from);
        let Some(half) = (wo + wi).try_normalize().filter(|_| wo.z > 0.0 && wi.z > 0.0) else {
            return ([0.0; 3], 0.0);
        };
        let viewer = spherical(wo.into());
        let sample = self.surface.sample_of(viewer, spherical(half.into()));
        let density = sample.density(wo.dot(half), half.x.hypot(half.y));
        (self.reflected(viewer, &sample), density)
    }

    fn reflected(&self, viewer: [f32; 2], sample: &MeasuredSample) -> [f32; 3] {
        uplifted(self.surface.reflected(viewer, sample), &self.uplift)
    }

    /// Samples a direction; see [`super::Bsdf::sample`].
    pub fn sample(&self, wo: [f32; 3], u: [f32; 2]) -> BsdfSample<f32> {
        let [up, _] = upright(wo, [0.0; 3]);
        let viewer = spherical(up);
        let ([theta, phi], sample) = self.surface.sample(viewer, u);
        let (sine, cosine) = theta.sin_cos();
        let half = Vec3::new(sine * phi.cos(), sine * phi.sin(), cosine);
        let up = Vec3::from(up);
        let cos = up.dot(half);
        let wi = half * (2.0 * cos) - up;
        let pdf = sample.density(cos, sine);
        let valid = wi.z > 0.0 && up.z > 0.0 && pdf > 0.0;
        let weight = self.reflected(viewer, &sample).map(|f| f / pdf);
        let finite = weight.iter().all(|w| w.is_finite());
        let wi = if wo[2] < 0.0 { -wi } else { wi };
        BsdfSample {
            wi: wi.into(),
            weight,
            pdf,
            singular: false,
            valid: valid && finite,
            eta2: 1.0,
        }
        .only(true)
    }

    /// Returns the share of light that the surface reflects to a viewer on its normal, by channel.
    pub fn albedo(&self) -> [f32; 3] {
        let n = 8;
        let mut sum = [0.0; 3];
        for i in 0..n * n {
            let u = [i % n, i / n].map(|i| (i as f32 + 0.5) / n as f32);
            let sample = self.sample([0.0, 0.0, 1.0], u);
            (0..3).for_each(|c| sum[c] += sample.weight[c] / (n * n) as f32);
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;
    use petzval_base::equal_area;

    fn surface(name: &str) -> MeasuredSurface {
        let path = format!("{}/../../tests/pbrt_language/{name}.bsdf", env!("CARGO_MANIFEST_DIR"));
        MeasuredSurface::read(&std::fs::read(path).expect(name)).expect(name)
    }

    /// Directions to the viewer, on both sides.
    fn viewers() -> [[f32; 3]; 4] {
        [[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [-0.5, 0.7, 0.51], [0.3, -0.4, -0.866]]
            .map(|w| Vec3::from(w).normalize().into())
    }

    const SURFACES: [&str; 2] = ["isotropic", "anisotropic"];

    #[test]
    fn the_density_integrates_to_the_share_of_samples_above_the_surface() {
        for name in SURFACES {
            let surface = surface(name);
            let bsdf = Measured { surface: &surface, uplift: None };
            for wo in viewers() {
                let n = 500;
                let (mut integral, mut above) = (0.0, 0.0);
                for i in 0..n * n {
                    let u = [i % n, i / n].map(|i| (i as f32 + 0.5) / n as f32);
                    let wi = equal_area::to_sphere(Vec2::from(u));
                    integral += f64::from(bsdf.evaluate(wo, wi.into()).1);
                    above += f64::from(u8::from(bsdf.sample(wo, u).valid));
                }
                let integral = integral / f64::from(n * n) * 4.0 * std::f64::consts::PI;
                let above = above / f64::from(n * n);
                assert!((integral / above - 1.0).abs() < 0.01, "{name} {wo:?}: {integral} {above}");
            }
        }
    }

    #[test]
    fn samples_have_the_value_and_the_density_of_their_direction() {
        for name in SURFACES {
            let surface = surface(name);
            let bsdf = Measured { surface: &surface, uplift: None };
            for wo in viewers() {
                let mut valid = 0;
                for i in 0..400 {
                    let u = [(i % 20) as f32 / 20.0 + 0.025, (i / 20) as f32 / 20.0 + 0.025];
                    let sample = bsdf.sample(wo, u);
                    if !sample.valid {
                        continue;
                    }
                    valid += 1;
                    assert!(sample.wi[2] * wo[2] > 0.0, "{name}: {sample:?}");
                    let (value, pdf) = bsdf.evaluate(wo, sample.wi);
                    assert!((pdf / sample.pdf - 1.0).abs() < 0.02, "{name}: {pdf} {sample:?}");
                    for channel in 0..3 {
                        let expected = sample.weight[channel] * sample.pdf;
                        assert!(
                            (value[channel] / expected - 1.0).abs() < 0.02,
                            "{name}: {value:?}"
                        );
                    }
                }
                assert!(valid > 250, "{name} {wo:?}: {valid}");
            }
        }
    }

    #[test]
    fn sampling_reflects_what_evaluation_does() {
        for name in SURFACES {
            let surface = surface(name);
            let bsdf = Measured { surface: &surface, uplift: None };
            for wo in viewers() {
                let n = 400;
                let (mut sampled, mut evaluated) = (0.0, 0.0);
                for i in 0..n * n {
                    let u = [i % n, i / n].map(|i| (i as f32 + 0.5) / n as f32);
                    sampled += f64::from(bsdf.sample(wo, u).weight[0]);
                    let wi = equal_area::to_sphere(Vec2::from(u));
                    evaluated += f64::from(bsdf.evaluate(wo, wi.into()).0[0]);
                }
                let sampled = sampled / f64::from(n * n);
                let evaluated = evaluated / f64::from(n * n) * 4.0 * std::f64::consts::PI;
                assert!((sampled / evaluated - 1.0).abs() < 0.01, "{name}: {sampled} {evaluated}");
            }
        }
    }

    #[test]
    fn an_isotropic_surface_turns_with_the_viewer_and_no_other() {
        let turned = |w: [f32; 3]| glam::Quat::from_rotation_z(1.1) * Vec3::from(w);
        let (wo, wi) = ([0.6, 0.0, 0.8], Vec3::new(-0.3, 0.5, 0.7).normalize().to_array());
        let change = |name: &str| {
            let surface = surface(name);
            let bsdf = Measured { surface: &surface, uplift: None };
            let (here, _) = bsdf.evaluate(wo, wi);
            let (there, _) = bsdf.evaluate(turned(wo).into(), turned(wi).into());
            (here[1] / there[1] - 1.0).abs()
        };
        let (isotropic, anisotropic) = (change("isotropic"), change("anisotropic"));
        assert!(isotropic < 1e-3 && anisotropic > 0.03, "{isotropic}, {anisotropic}");
    }
}
