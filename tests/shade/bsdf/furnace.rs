//! Energy and reciprocity: no surface adds light, lossless surfaces lose none, and values are
//! symmetric in the two directions.

use petzval_base::lanes::{Real, f32x8};
use petzval_render::shade::bsdf::{Bsdf, Dielectric, Diffuse};

use super::scene::{ETA, K, Kind, REFLECTANCE, Random, TRANSMITTANCE, direction, splat};
use super::twin::{GLASS, chances, fresnel};
use crate::support::reference::by_tier;

const ALPHAS: [[f32; 2]; 6] =
    [[0.002, 0.002], [0.05, 0.05], [0.3, 0.1], [0.5, 0.5], [0.1, 1.0], [1.0, 1.0]];
const COSINES: [f64; 5] = [1.0, 0.8, 0.5, 0.2, 0.05];

/// Returns the mean weight of `count` samples in the first two channels, without the change of
/// radiance by refraction, and the standard error of the first.
fn mean_weight(kind: Kind, wo: [f32; 3], count: usize, seed: u64) -> ([f64; 2], f64) {
    // The choices of lobes are all multiples of 1 / count, in the order of a prime step.
    const STEP: usize = 7919;
    let choice = |at: usize| ((at * STEP % count) as f32 + 0.5) / count as f32;
    let bsdf = kind.build::<f32x8>();
    let mut random = Random::new(seed);
    let (mut sum, mut squares) = ([0.0; 2], 0.0);
    for packet in 0..count / 8 {
        let u = [random.eight(), random.eight()];
        let choices: [f32; 8] = std::array::from_fn(|lane| choice(8 * packet + lane));
        let drawn = bsdf.sample(splat(wo), u, f32x8::load(&choices));
        for channel in 0..2 {
            let weights = (drawn.weight[channel] * drawn.eta2).to_array();
            sum[channel] += weights.iter().map(|&w| f64::from(w)).sum::<f64>();
            if channel == 0 {
                squares += weights.iter().map(|&w| f64::from(w) * f64::from(w)).sum::<f64>();
            }
        }
    }
    let n = count as f64;
    let mean = sum.map(|s| s / n);
    (mean, ((squares / n - mean[0] * mean[0]).max(0.0) / n).sqrt())
}

/// Integrates f |cos wi| over all directions in the first two channels, without the change of
/// radiance by refraction.
fn integral(kind: Kind, wo: [f32; 3]) -> [f64; 2] {
    let bsdf = kind.build::<f32x8>();
    let (cosines, azimuths) = (800, 800);
    let cell = 4.0 * std::f64::consts::PI / f64::from(cosines * azimuths);
    let expand = f64::from(kind.ratio(wo)).powi(2);
    let mut sum = [0.0; 2];
    for row in 0..cosines {
        let cos = 2.0 * (f64::from(row) + 0.5) / f64::from(cosines) - 1.0;
        let scale = if cos * f64::from(wo[2]) < 0.0 { expand } else { 1.0 };
        for column in 0..azimuths / 8 {
            let mut wi = [[0.0; 8]; 3];
            for lane in 0..8 {
                let turn = (f64::from(column * 8 + lane) + 0.5) / f64::from(azimuths);
                let w = direction(cos, 2.0 * std::f64::consts::PI * turn);
                for axis in 0..3 {
                    wi[axis][lane as usize] = w[axis];
                }
            }
            let (value, _) = bsdf.evaluate(splat(wo), wi.map(|axis| f32x8::load(&axis)));
            for channel in 0..2 {
                let values = value[channel].to_array();
                let values: f64 = values.iter().map(|&v| f64::from(v)).sum();
                sum[channel] += values * scale * cell;
            }
        }
    }
    sum
}

#[test]
fn a_diffuse_surface_reflects_its_albedo() {
    for wo in [[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.0, 0.6, -0.8]] {
        let (mean, _) = mean_weight(Kind::Diffuse, wo, 8000, 1);
        let both = integral(Kind::Diffuse, wo);
        for channel in 0..2 {
            assert!((mean[channel] - f64::from(REFLECTANCE[channel])).abs() < 1e-3);
            assert!((both[channel] - f64::from(REFLECTANCE[channel])).abs() < 1e-4);
        }
        let (mean, error) = mean_weight(Kind::DiffuseTransmission, wo, 800_000, 2);
        let both = integral(Kind::DiffuseTransmission, wo);
        for channel in 0..2 {
            let all = f64::from(REFLECTANCE[channel] + TRANSMITTANCE[channel]);
            assert!((both[channel] - all).abs() < 1e-4);
            assert!((mean[channel] - all).abs() < 5.0 * error + 1e-3);
        }
    }
}

#[test]
fn smooth_glass_is_lossless_and_divides_light_by_the_fresnel_equations() {
    let steps = 4000;
    for eta in [1.0f32, 1.0 / 1.5, 1.33, 1.5, 2.4] {
        let glass = Dielectric::<f32>::new([0.0; 2], eta);
        assert!(glass.singular());
        for cos in COSINES {
            for side in [1.0f64, -1.0] {
                let mut wo = direction(cos, 0.3);
                wo[2] *= side as f32;
                let relative = f64::from(if side > 0.0 { eta } else { 1.0 / eta });
                let total = 1.0 - cos * cos >= relative * relative;
                let exact = if total { 1.0 } else { fresnel(cos, relative, 0.0) };
                let [reflects, passes] = chances(exact, GLASS);
                let (mut weights, mut reflected) = ([0.0; 2], 0.0);
                for step in 0..steps {
                    let choice = (step as f32 + 0.5) / steps as f32;
                    let drawn = glass.sample(wo, [0.3, 0.7], choice);
                    assert!(drawn.valid && drawn.singular, "{wo:?} {eta}");
                    let weight = f64::from(drawn.weight[0] * drawn.eta2);
                    if drawn.wi[2] * wo[2] > 0.0 {
                        reflected += 1.0;
                        weights[0] = weight;
                        assert!((weight * reflects / exact - 1.0).abs() < 1e-4, "{wo:?} {eta}");
                        assert_eq!(
                            [drawn.wi[0], drawn.wi[1], drawn.wi[2]],
                            [-wo[0], -wo[1], wo[2]]
                        );
                        assert_eq!(drawn.eta2, 1.0);
                    } else {
                        let expected = (1.0 - exact) / passes;
                        weights[1] = weight;
                        assert!((weight / expected - 1.0).abs() < 1e-4, "{wo:?} {eta}");
                        for axis in 0..2 {
                            let snell = -f64::from(wo[axis]) / relative;
                            assert!((f64::from(drawn.wi[axis]) - snell).abs() < 1e-6);
                        }
                        assert!((f64::from(drawn.eta2) - relative * relative).abs() < 1e-5);
                    }
                }
                let n = f64::from(steps);
                let all = reflects * weights[0] + passes * weights[1];
                assert!((all - 1.0).abs() < 1e-6, "{wo:?} {eta}: {all}");
                assert!((reflected / n - reflects).abs() < 1.0 / n, "{wo:?} {eta}");
            }
        }
    }
}

#[test]
fn an_interface_between_equal_media_has_no_effect() {
    for alpha in [0.0, 0.4] {
        let nothing = Dielectric::<f32>::new([alpha; 2], 1.0);
        for cos in [1.0, 0.5, 0.01, 1e-5] {
            for choice in [0.0, 0.5, 0.999_999] {
                let wo = direction(cos, 2.0);
                let drawn = nothing.sample(wo, [0.9, 0.1], choice);
                assert!(drawn.valid && drawn.singular);
                assert_eq!((drawn.wi, drawn.weight), (wo.map(|x| -x), [1.0; 3]));
            }
        }
    }
}

#[test]
fn a_thin_sheet_reflects_at_both_sides() {
    let steps = 4000;
    for cos in COSINES {
        let once = fresnel(cos, 1.5, 0.0);
        // Light that enters, is reflected 2 n + 1 times inside, and leaves.
        let series: f64 = (0..60).map(|n| (1.0 - once).powi(2) * once.powi(2 * n + 1)).sum();
        let pane = Kind::Thin(1.5, REFLECTANCE).build::<f32>();
        let wo = direction(cos, 1.0);
        let [reflects, passes] = chances(once + series, GLASS);
        let mut reflected = 0.0;
        for step in 0..steps {
            let drawn = pane.sample(wo, [0.5; 2], (step as f32 + 0.5) / steps as f32);
            assert!(drawn.valid && drawn.singular);
            assert_eq!(drawn.wi.map(f32::abs), wo.map(f32::abs));
            let back = drawn.wi[2] > 0.0;
            for (weight, tint) in drawn.weight.into_iter().zip(REFLECTANCE) {
                let expected = match back {
                    true => (once + series) / reflects,
                    false => f64::from(tint) * (1.0 - once - series) / passes,
                };
                assert!((f64::from(weight) - expected).abs() < 1e-6, "{cos}: {expected}");
            }
            reflected += if back { 1.0 } else { 0.0 };
            assert_eq!(drawn.eta2, 1.0);
        }
        assert!((reflected / f64::from(steps) - reflects).abs() < 1.0 / f64::from(steps));
    }
}

#[test]
fn rough_surfaces_add_no_light_and_nearly_smooth_ones_lose_little() {
    for alpha in ALPHAS {
        for (cos, kind) in COSINES.into_iter().flat_map(|cos| {
            [Kind::Mirror(alpha), Kind::Dielectric(alpha, 1.5), Kind::Dielectric(alpha, 0.7)]
                .map(|kind| (cos, kind))
        }) {
            for side in [1.0, -1.0] {
                let mut wo = direction(cos, 0.7);
                wo[2] *= side;
                let narrow = alpha[0].max(alpha[1]) < 0.01;
                let count = if narrow { 400_000 } else { 40_000 };
                let (mean, error) = mean_weight(kind, wo, count, 3);
                assert!(mean[0] <= 1.0 + 5.0 * error + 1e-5, "{kind:?} {wo:?}: {mean:?}");
                if narrow && cos > 0.1 {
                    assert!(mean[0] > 0.9999, "{kind:?} {wo:?}: {mean:?}");
                }
            }
        }
    }
}

#[test]
fn mean_weights_of_samples_equal_the_integral_of_values() {
    // The lobes are wide enough for the integral's grid. An error of 1 % is at least 20 standard
    // errors.
    for alpha in [[0.1, 0.1], [0.3, 0.1], [0.5, 0.5], [1.0, 1.0]] {
        for kind in [Kind::Conductor(alpha), Kind::Mirror(alpha), Kind::Dielectric(alpha, 1.5)] {
            for (cos, side) in [(0.9, 1.0), (0.4, -1.0), (0.15, 1.0)] {
                let mut wo = direction(cos, 0.7);
                wo[2] *= side;
                let (mean, error) = mean_weight(kind, wo, 400_000, 4);
                let exact = integral(kind, wo);
                for channel in 0..2 {
                    let off = (mean[channel] - exact[channel]).abs();
                    assert!(off < 5.0 * error + 2e-3 * exact[channel], "{kind:?} {wo:?}: {off}");
                }
            }
        }
    }
}

#[test]
fn a_smooth_metal_reflects_each_channel_by_its_own_index() {
    let metal = Kind::Conductor([0.0; 2]).build::<f32>();
    assert!(metal.singular());
    for cos in COSINES {
        let wo = direction(cos, 1.0);
        let drawn = metal.sample(wo, [0.2, 0.3], 0.5);
        assert!(drawn.valid && drawn.singular);
        assert_eq!(drawn.wi, [-wo[0], -wo[1], wo[2]]);
        for channel in 0..3 {
            let exact = fresnel(cos, f64::from(ETA[channel]), f64::from(K[channel]));
            assert!((f64::from(drawn.weight[channel]) - exact).abs() < 1e-5);
        }
    }
}

#[test]
fn values_are_reciprocal() {
    let mut random = Random::new(5);
    for alpha in [[0.05, 0.05], [0.3, 0.1], [1.0, 0.4]] {
        for kind in [
            Kind::Diffuse,
            Kind::DiffuseTransmission,
            Kind::Conductor(alpha),
            Kind::Dielectric(alpha, 1.5),
            Kind::Dielectric(alpha, 0.7),
            Kind::Plastic(REFLECTANCE, alpha[0], 1.5),
            Kind::Coated(REFLECTANCE, alpha[1], 0.4, alpha[0], 0.7),
        ] {
            let bsdf = kind.build::<f32>();
            let (mut compared, mut poor) = (0, 0);
            for turn in 0..2000 {
                let (mut a, mut b) = (random.direction(), random.direction());
                a[2] *= if turn & 1 == 0 { 1.0 } else { -1.0 };
                b[2] *= if turn & 2 == 0 { 1.0 } else { -1.0 };
                let (there, back) = (bsdf.evaluate(a, b).0, bsdf.evaluate(b, a).0);
                // f / n^2 is symmetric, where n is the index on the side of the light.
                let n2 = if a[2] * b[2] < 0.0 { kind.ratio(a).powi(2) } else { 1.0 };
                for channel in 0..3 {
                    let one = there[channel] / b[2].abs() * n2;
                    let other = back[channel] / a[2].abs();
                    let off = (one - other).abs() - 1e-6;
                    assert!(off <= 5e-2 * one.max(other), "{kind:?} {a:?} {b:?}: {one} {other}");
                    compared += usize::from(one > 0.0);
                    poor += usize::from(off > 1e-3 * one.max(other));
                }
            }
            // Near the critical angle of a microfacet, rounding of the directions has an effect.
            assert!(poor * 50 < compared, "{kind:?}: {poor} of {compared}");
            assert!(compared > 500, "{kind:?}: {compared}");
        }
    }
}

#[test]
fn a_white_base_below_an_interface_loses_no_light_and_gains_none() {
    // The error of linear interpolation in the table of the interface's albedo.
    const INTERPOLATION: f64 = 4e-3;
    for alpha in [0.0, 0.003, 0.04, 0.25, 0.6, 1.0] {
        for eta in [1.1, 1.5, 2.4] {
            for cos in COSINES {
                let wo = direction(cos, 0.7);
                let name = format!("alpha {alpha}, index {eta}, cosine {cos}");
                let (mean, error) = mean_weight(
                    Kind::Plastic([1.0; 3], alpha, eta),
                    wo,
                    by_tier(100_000, 400_000),
                    8,
                );
                let off = (mean[0] - 1.0).abs();
                assert!(off < INTERPOLATION + 5.0 * error, "{name}: {mean:?}");
                // A darker base absorbs the light that reaches it, once.
                let (half, error) = mean_weight(
                    Kind::Plastic([0.5, 0.0, 0.0], alpha, eta),
                    wo,
                    by_tier(100_000, 400_000),
                    9,
                );
                let expected = (1.0 + half[1]) / 2.0;
                assert!((half[0] - expected).abs() < INTERPOLATION + 5.0 * error, "{name}");
                // The grid does not resolve narrower lobes.
                if alpha > 0.2 {
                    let sum = integral(Kind::Plastic([1.0; 3], alpha, eta), wo)[0];
                    assert!((sum - 1.0).abs() < 2.0 * INTERPOLATION, "{name}: {sum}");
                }
            }
        }
    }
}

#[test]
fn a_smooth_interface_reflects_what_schlick_says_at_its_own_angle() {
    for cos in COSINES {
        let smooth = Kind::Plastic([0.0; 3], 0.0, 1.5).build::<f32>();
        let wo = direction(cos, 0.2);
        let drawn = smooth.sample(wo, [0.3, 0.6], 0.1);
        assert!(drawn.singular && drawn.valid && smooth.singular());
        assert_eq!(drawn.wi, [-wo[0], -wo[1], wo[2]]);
        let schlick = 0.04 + 0.96 * (1.0 - cos).powi(5);
        assert!((f64::from(drawn.weight[0]) - schlick).abs() < 1e-6, "{cos}");
    }
}

#[test]
fn a_coat_over_metal_adds_no_light_and_covers_its_share() {
    for (alpha, coat) in [(0.0, 0.0), (0.3, 0.0), (0.0, 0.2), (0.5, 0.5), (1.0, 0.05)] {
        for cos in COSINES {
            let wo = direction(cos, 0.7);
            let at = |base: f32, coverage: f32| {
                let kind = Kind::Coated([base; 3], alpha, 1.0, coat, coverage);
                mean_weight(kind, wo, 400_000, 8)
            };
            let name = format!("alpha {alpha}, coat {coat}, cosine {cos}");
            let (white, error) = at(1.0, 1.0);
            assert!(white[0] < 1.0 + 4e-3 + 5.0 * error, "{name}: {white:?}");
            // Below a black metal, Schlick's reflectance is left at grazing incidence.
            let (bare, _) = at(0.5, 0.0);
            let (half, _) = at(0.5, 0.5);
            let (whole, error) = at(0.5, 1.0);
            let between = (bare[0] + whole[0]) / 2.0;
            assert!((half[0] - between).abs() < 0.02 + 5.0 * error, "{name}: {half:?}");
            assert!(whole[0] > bare[0] - 0.1, "{name}: {whole:?} {bare:?}");
        }
    }
}

#[test]
fn black_surfaces_are_singular() {
    let black = Diffuse { reflectance: [0.0f32; 3] };
    assert!(black.singular());
    assert_eq!(black.evaluate([0.0, 0.0, 1.0], [0.6, 0.0, 0.8]).0, [0.0; 3]);
    assert!(!Diffuse { reflectance: [0.0f32, 0.1, 0.0] }.singular());
}
