//! Chains of samples: a direction that is sampled from the one before keeps its length.

use petzval_base::lanes::vector::{negate, renormalize};
use petzval_render::shade::bsdf::{ShadingFrame, sample_henyey_greenstein};

use super::hair::BROWN;
use super::scene::{Kind, REFLECTANCE, Random, direction};

/// Steps of a chain.
const STEPS: usize = 10_000;
/// Largest error of the length. One step rounds by about 1.5e-7.
const LENGTH_ERROR: f64 = 5e-7;

fn length_error(w: [f32; 3]) -> f64 {
    let length2: f64 = w.iter().map(|&x| f64::from(x).powi(2)).sum();
    (length2.sqrt() - 1.0).abs()
}

#[test]
fn scattering_keeps_the_length_of_directions() {
    for g in [-0.99, -0.5, 0.0, 0.3, 0.8, 0.99] {
        let mut random = Random::new(7);
        let mut w = [0.6, 0.0, 0.8];
        for step in 0..STEPS {
            let u = [random.number(), random.number()];
            w = negate(sample_henyey_greenstein(w, g, u));
            assert!(length_error(w) < LENGTH_ERROR, "g {g}: {w:?} after {step} steps");
        }
    }
}

#[test]
fn surfaces_keep_the_length_of_directions() {
    let kinds = [
        Kind::Diffuse,
        Kind::DiffuseTransmission,
        Kind::Conductor([0.0; 2]),
        Kind::Conductor([0.3, 0.1]),
        Kind::Dielectric([0.0; 2], 1.5),
        Kind::Dielectric([0.3; 2], 1.5),
        Kind::Thin(1.5, REFLECTANCE),
        Kind::Plastic(REFLECTANCE, 0.2, 1.5),
        Kind::Coated(REFLECTANCE, 0.2, 0.5, 0.0, 0.8),
        Kind::Tinted(0.0, 1.5, REFLECTANCE),
        Kind::Hair(BROWN),
    ];
    for kind in kinds {
        let bsdf = kind.build::<f32>();
        let mut random = Random::new(11);
        let mut wo = [0.6, 0.0, 0.8];
        let mut sampled = 0;
        for step in 0..STEPS {
            // A surface turned anyhow, whose normal is a unit vector but for its rounding errors.
            let [cos, turn] = [2.0 * random.number() - 1.0, random.number()];
            let normal = direction(f64::from(cos), std::f64::consts::TAU * f64::from(turn));
            let frame = ShadingFrame::about(normal, [0.0; 3]);
            let u = [random.number(), random.number()];
            let sample = bsdf.sample(frame.to_local(wo), u, random.number());
            if !sample.valid {
                continue;
            }
            sampled += 1;
            // As `Vertices::evaluate` stores the next direction.
            wo = negate(renormalize(frame.to_world(sample.wi)));
            assert!(length_error(wo) < LENGTH_ERROR, "{kind:?}: {wo:?} after {step} steps");
        }
        assert!(sampled > STEPS / 3, "{kind:?}: {sampled}");
    }
}
