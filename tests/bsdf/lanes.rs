//! Lanes: BSDFs give the same results bit for bit in one lane and in eight, and all are finite.

use petzval::lanes::{Real, f32x8};
use petzval::shade::bsdf::{Bsdf, Conductor, Dielectric};

use crate::scene::{ETA, K, Kind, splat};

/// Directions that break kernels.
const NASTY: [[f32; 3]; 16] = [
    [0.0, 0.0, 1.0],
    [0.0, 0.0, -1.0],
    [1.0, 0.0, 0.0],
    [0.0, -1.0, 0.0],
    [1.0, 0.0, -0.0],
    [1.0, 0.0, 1e-20],
    [1.0, 0.0, 1e-45],
    [-1.0, 0.0, 1e-7],
    [0.0, 1.0, -1e-4],
    [0.8, 0.0, 0.6],
    [-0.8, 0.0, 0.6],
    [-0.8, 0.0, -0.6],
    [0.48, 0.64, 0.6],
    [0.36, -0.48, -0.8],
    [-0.36, 0.48, 0.8],
    [1e-20, 1e-20, 1.0],
];

const NUMBERS: [f32; 5] = [0.0, 0.25, 0.5, 0.75, 1.0 - f32::EPSILON / 2.0];

const ALPHAS: [[f32; 2]; 8] = [
    [0.0, 0.0],
    [1e-4, 1e-4],
    [0.0, 1e-3],
    [1e-3, 1e-3],
    [0.05, 1e-4],
    [0.3, 0.3],
    [1.0, 0.2],
    [1.0, 1.0],
];

fn kinds() -> Vec<Kind> {
    let mut kinds = vec![Kind::Diffuse, Kind::DiffuseTransmission, Kind::Thin];
    for alpha in ALPHAS {
        kinds.extend([Kind::Conductor(alpha), Kind::Mirror(alpha)]);
        kinds.extend([1.5, 0.7, 1.0, 1.000_000_1, 0.0].map(|eta| Kind::Dielectric(alpha, eta)));
    }
    kinds
}

fn bits<R: Real<Scalar = f32>>(values: impl IntoIterator<Item = R>) -> Vec<[u32; 8]> {
    let lanes = |value: R| {
        let mut to = [0.0; 8];
        value.store(&mut to);
        to.map(f32::to_bits)
    };
    values.into_iter().map(lanes).collect()
}

#[test]
fn evaluations_of_eight_lanes_equal_those_of_one() {
    for kind in kinds() {
        let (one, eight) = (kind.build::<f32>(), kind.build::<f32x8>());
        for wo in NASTY {
            // Eight partners at a time, so that lanes of every outcome share a packet.
            for partners in NASTY.chunks(8) {
                let mut wi = [[0.0; 8]; 3];
                for (lane, w) in partners.iter().enumerate() {
                    for axis in 0..3 {
                        wi[axis][lane] = w[axis];
                    }
                }
                let (value, pdf) = eight.evaluate(splat(wo), wi.map(|a| f32x8::load(&a)));
                let packet = bits(value.into_iter().chain([pdf]));
                for (lane, &w) in partners.iter().enumerate() {
                    let (value, pdf) = one.evaluate(wo, w);
                    for (k, number) in value.into_iter().chain([pdf]).enumerate() {
                        assert_eq!(number.to_bits(), packet[k][lane], "{kind:?} {wo:?} {w:?}");
                        assert!((0.0..f32::INFINITY).contains(&number), "{kind:?} {wo:?} {w:?}");
                    }
                }
            }
        }
    }
}

#[test]
fn samples_of_eight_lanes_equal_those_of_one() {
    for kind in kinds() {
        let (one, eight) = (kind.build::<f32>(), kind.build::<f32x8>());
        for wo in NASTY {
            for (u, v) in NUMBERS.into_iter().flat_map(|u| NUMBERS.map(|v| (u, v))) {
                let choices = [0.0, 0.01, 0.2, 0.4, 0.6, 0.8, 0.95, NUMBERS[4]];
                let draw = eight.sample(splat(wo), splat([u, v]), f32x8::load(&choices));
                let all = draw.wi.into_iter().chain(draw.weight);
                let packet = bits(all.chain([draw.pdf, draw.eta2]));
                let valid = f32x8::bits(draw.valid);
                for (lane, choice) in choices.into_iter().enumerate() {
                    let draw = one.sample(wo, [u, v], choice);
                    let name = format!("{kind:?} {wo:?} {u} {v} {choice}");
                    assert_eq!(draw.valid, valid >> lane & 1 == 1, "{name}");
                    let all = draw.wi.into_iter().chain(draw.weight);
                    for (k, number) in all.chain([draw.pdf, draw.eta2]).enumerate() {
                        assert_eq!(number.to_bits(), packet[k][lane], "{name}");
                        assert!(number.is_finite(), "{name}: {draw:?}");
                    }
                    let unit: f32 = draw.wi.iter().map(|x| x * x).sum();
                    assert!((unit - 1.0).abs() < 1e-5, "{name}: {draw:?}");
                    assert!(draw.weight.iter().all(|&w| w >= 0.0) && draw.pdf >= 0.0);
                    assert!(!draw.valid || wo[2] != 0.0, "{name}");
                }
            }
        }
    }
}

#[test]
fn smooth_and_rough_lanes_can_share_a_packet() {
    let alphas = [0.0, 0.3, 5e-4, 0.1, 0.0, 1.0, 1e-3, 9e-4];
    let packed = [f32x8::load(&alphas); 2];
    let metals = Conductor::new(packed, splat(ETA), splat(K));
    let glasses = Dielectric::new(packed, f32x8::splat(1.5));
    let (wo, wi) = ([0.6, 0.0, 0.8], [-0.48, 0.36, 0.8]);
    let u = [0.3, 0.6];
    for glass in [false, true] {
        let packet: &dyn Bsdf<f32x8> = if glass { &glasses } else { &metals };
        let kind = |alpha| {
            if glass { Kind::Dielectric(alpha, 1.5) } else { Kind::Conductor(alpha) }
        };
        let (value, pdf) = packet.evaluate(splat(wo), splat(wi));
        let draw = packet.sample(splat(wo), splat(u), f32x8::splat(0.9));
        let (singular, smooth) = (f32x8::bits(draw.singular), f32x8::bits(packet.singular()));
        assert_eq!((singular, smooth), (0b1001_0101, 0b1001_0101));
        for (lane, alpha) in alphas.into_iter().enumerate() {
            let one = kind([alpha; 2]).build::<f32>();
            let (lone, lone_pdf) = one.evaluate(wo, wi);
            assert_eq!(lone, value.map(|v| v.to_array()[lane]));
            assert_eq!(lone_pdf, pdf.to_array()[lane]);
            assert_eq!(one.sample(wo, u, 0.9).wi, draw.wi.map(|v| v.to_array()[lane]));
            assert_eq!(one.sample(wo, u, 0.9).pdf > 0.0, singular >> lane & 1 == 0);
        }
    }
}
