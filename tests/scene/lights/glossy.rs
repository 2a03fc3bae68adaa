//! Glossy surfaces, for which lights in their lobe are more probable.

use glam::Vec3;
use petzval_render::shade::bsdf::{Bsdf, Conductor, ShadingFrame};
use petzval_scene::{GlossyLobe, Reception, Scene};

use super::facing::{check_densities, small_lights};
use super::{Mean, at};
use crate::support::Random;

const ALPHA: f32 = 0.15;

fn lobe(wo: Vec3, share: f32) -> Option<GlossyLobe> {
    GlossyLobe::new(wo.to_array(), ALPHA * ALPHA, share)
}

/// The light of all lamps that a rough metal reflects, with lights chosen by `reception`.
fn reflected(scene: &Scene, wo: Vec3, reception: impl Fn(Vec3) -> Reception) -> Mean {
    let from = at([0.3, 0.2, 0.1], [0.2, 0.1, 1.0]);
    let frame = ShadingFrame::about(from.normal.to_array(), [0.0; 3]);
    let metal = Conductor::<f32>::new([ALPHA; 2], [0.2; 3], [3.0; 3]);
    let mut random = Random::new(6);
    let (n, mut sum, mut squares) = (400_000, 0.0, 0.0);
    for _ in 0..n {
        let mut pair = || [random.next() as f32, random.next() as f32].map(|u| u.min(0.999_999_94));
        let (choice, u) = (pair(), pair());
        let Some(sample) = scene.sample_light(&from, reception(from.normal), choice, u) else {
            continue;
        };
        let towards = sample.direction.normalize().to_array();
        let (f, _) = metal.evaluate(frame.to_local(wo.to_array()), frame.to_local(towards));
        let value = f64::from(f[0] * sample.radiance[0] / sample.density);
        sum += value;
        squares += value * value;
    }
    let n = f64::from(n);
    let mean = sum / n;
    Mean { mean, error: ((squares / n - mean * mean) / n).sqrt() }
}

#[test]
fn a_rough_metal_reflects_the_same_light_with_less_noise() {
    let scene = small_lights();
    let mut random = Random::new(7);
    let (mut gain, views) = (0.0, 12);
    for _ in 0..views {
        let mut number = || random.between(-1.0, 1.0) as f32;
        let wo = Vec3::new(number(), number(), 0.2 + number().abs()).normalize();
        let wide = reflected(&scene, wo, Vec3::into);
        let glossy = |normal: Vec3| Reception { facing: normal.into(), lobe: lobe(wo, 0.98) };
        let glossy = reflected(&scene, wo, glossy);
        let apart = (wide.mean - glossy.mean).abs();
        assert!(apart < 6.0 * wide.error.hypot(glossy.error), "{wo}: {wide:?} {glossy:?}");
        gain += (wide.error / glossy.error).powi(2).ln() / f64::from(views);
    }
    let gain = gain.exp();
    assert!(gain > 2.0, "{gain} times less variance");
}

#[test]
fn the_density_of_a_hit_knows_the_lobe_of_the_receiver() {
    check_densities(|normal| Reception {
        facing: normal.into(),
        lobe: lobe(Vec3::new(0.7, -0.2, 0.6).normalize(), 0.7),
    });
}

#[test]
fn extreme_lobes_leave_all_lights_that_the_surface_faces() {
    let scene = small_lights();
    let from = at([0.3, 0.2, 0.1], [0.2, 0.1, 1.0]);
    let mut random = Random::new(3);
    let normal = from.normal;
    let grazing = normal.any_orthonormal_vector();
    for wo in [normal, -normal, grazing, Vec3::ZERO] {
        for alpha2 in [1e-6, 0.01, 1.0] {
            for share in [1e-30, 0.5, 0.98] {
                let lobe = GlossyLobe::new(wo.to_array(), alpha2, share);
                let reception = Reception { facing: normal.into(), lobe };
                for _ in 0..300 {
                    let mut pair = || [random.next() as f32, random.next() as f32];
                    let Some(sample) = scene.sample_light(&from, reception, pair(), pair()) else {
                        continue;
                    };
                    let density = sample.density;
                    assert!(density > 0.0 && density.is_finite(), "{reception:?} {sample:?}");
                }
                // Lights outside the lobe are selected as well.
                let above = (0..2000).filter_map(|_| {
                    let mut pair = || [random.next() as f32, random.next() as f32];
                    scene.sampled_light(from.position, reception, pair())
                });
                let mut lights: Vec<u32> = above.collect();
                lights.sort_unstable();
                lights.dedup();
                assert!(lights.len() > 8, "{reception:?}: {} lights", lights.len());
            }
        }
    }
}
