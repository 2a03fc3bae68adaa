//! Hairs: a naive twin in f64, the white furnace, densities, and extreme roughness.

use std::f64::consts::PI;

use petzval_base::lanes::{Real, f32x8};
use petzval_render::shade::bsdf::{Bsdf, Hair, HairParameters};

use super::NaiveHair;
use super::density::{bound, chi_squared, counts, expected};
use super::scene::{Kind, Random, direction, splat};
use super::twin::fresnel;

/// A brown hair of pbrt-v4's defaults.
pub const BROWN: HairParameters<f32> = HairParameters {
    absorption: [0.545, 0.906, 1.781],
    eta: 1.55,
    beta_m: 0.3,
    beta_n: 0.3,
    tilt: 2.0,
    offset: 0.3,
};

/// Returns hairs at the ends of the ranges of their parameters, and beyond.
pub fn extremes() -> impl Iterator<Item = HairParameters<f32>> {
    let roughnesses = [[-1.0, 2.0], [0.0, 0.0], [0.01, 1.0], [1.0, 0.01], [0.3, 0.3], [1.0, 1.0]];
    let offsets = [-1.0, -0.999_999_9, 0.0, 0.5, 1.0, 7.0];
    roughnesses.into_iter().zip(offsets).flat_map(|([beta_m, beta_n], offset)| {
        [(1.55, [0.0; 3], 2.0), (1.0, [1e-9, 1.0, 1e30], -90.0), (0.6, [30.0; 3], 4e3)].map(
            |(eta, absorption, tilt)| HairParameters {
                absorption,
                eta,
                beta_m,
                beta_n,
                tilt,
                offset,
            },
        )
    })
}

/// Returns f |cos wi| of the first channel by the naive twin.
fn naive(hair: &HairParameters<f32>, wo: [f32; 3], wi: [f32; 3]) -> f64 {
    let [o, i] = [wo, wi].map(|w| w.map(f64::from));
    NaiveHair::new(hair).value(o, i)[0]
}

/// Returns a random direction of the whole sphere.
fn anywhere(random: &mut Random) -> [f32; 3] {
    let cos = 2.0 * f64::from(random.number()) - 1.0;
    direction(cos, 2.0 * PI * f64::from(random.number()))
}

#[test]
fn hairs_agree_with_the_naive_twin() {
    let mut random = Random::new(21);
    let mut bright = 0;
    for _ in 0..4000 {
        let mut number = |from: f32, to: f32| from + (to - from) * random.number();
        let hair = HairParameters {
            absorption: [number(0.0, 2.0); 3],
            eta: number(1.2, 1.8),
            beta_m: number(0.1, 1.0),
            beta_n: number(0.1, 1.0),
            tilt: number(-5.0, 5.0),
            offset: number(-0.99, 0.99),
        };
        let (wo, wi) = (anywhere(&mut random), anywhere(&mut random));
        let found = f64::from(Hair::new(hair).evaluate(wo, wi).0[0]);
        let exact = naive(&hair, wo, wi);
        assert!((found - exact).abs() < 2e-4 * exact + 1e-6, "{hair:?}: {found}, not {exact}");
        bright += usize::from(exact > 0.01);
    }
    assert!(bright > 1000, "{bright}");
}

#[test]
fn a_hair_that_absorbs_nothing_reflects_all_light() {
    for (seed, [beta_m, beta_n]) in
        [[0.05, 0.05], [0.1, 0.8], [0.3, 0.3], [0.7, 0.2], [1.0, 1.0]].into_iter().enumerate()
    {
        for (tilt, offset, wo) in [
            (0.0, 0.0, direction(0.9, 0.4)),
            (2.0, 0.7, direction(0.2, 3.0)),
            (-5.0, -0.95, [0.9, 0.3, 0.316_227_77]),
        ] {
            let hair =
                HairParameters { absorption: [0.0; 3], beta_m, beta_n, tilt, offset, ..BROWN };
            let bsdf = Kind::Hair(hair).build::<f32x8>();
            let mut random = Random::new(seed as u64);
            let (mut sum, mut squares, n) = (0.0, 0.0, 200_000);
            for _ in 0..n / 8 {
                let u = [random.eight(), random.eight()];
                let drawn = bsdf.sample(splat(wo), u, random.eight());
                for weight in drawn.weight[0].to_array().map(f64::from) {
                    sum += weight;
                    squares += weight * weight;
                }
            }
            let mean = sum / f64::from(n);
            let error = ((squares / f64::from(n) - mean * mean).max(0.0) / f64::from(n)).sqrt();
            assert!((mean - 1.0).abs() < 5.0 * error + 1e-4, "{hair:?}: {mean} +- {error}");
            assert!(error < 1e-3, "{error}");
        }
    }
}

#[test]
fn samples_of_hairs_follow_the_density() {
    let packets = 100_000;
    for (seed, (beta_m, beta_n, offset, cos)) in
        [(0.4, 0.3, 0.3, 0.8), (0.7, 0.6, -0.8, -0.5), (1.0, 1.0, 0.0, 0.1)].into_iter().enumerate()
    {
        let hair = HairParameters { beta_m, beta_n, offset, ..BROWN };
        let bsdf = Kind::Hair(hair).build::<f32x8>();
        let wo = direction(cos, 0.9);
        let cells = expected(&*bsdf, wo);
        let total: f64 = cells.iter().sum();
        assert!((total - 1.0).abs() < 2e-4, "{hair:?}: {total}");
        let counts = counts(&*bsdf, wo, packets, seed as u64);
        let (statistic, degrees) = chi_squared(&cells, &counts, 8.0 * f64::from(packets as u32));
        assert!(statistic < bound(degrees), "{hair:?}: {statistic} of {degrees}");
    }
}

#[test]
fn weights_of_hair_samples_are_values_over_densities() {
    let mut random = Random::new(8);
    for [beta_m, beta_n] in [[0.05, 0.05], [0.3, 0.3], [1.0, 0.2], [0.2, 1.0]] {
        // Rounding of the angles relative to the width of the narrowest lobe.
        let blur = 2e-5 / (beta_m * beta_m).min(beta_n);
        let mut compared = 0;
        for _ in 0..4000 {
            let offset = 1.98 * random.number() - 0.99;
            let bsdf = Hair::new(HairParameters { beta_m, beta_n, offset, ..BROWN });
            let wo = anywhere(&mut random);
            if wo[0].abs() > 0.99 {
                continue;
            }
            let drawn = bsdf.sample(wo, [random.number(), random.number()], random.number());
            assert!(drawn.valid && !drawn.singular && drawn.eta2 == 1.0);
            let (value, pdf) = bsdf.evaluate(wo, drawn.wi);
            let off = (pdf / drawn.pdf - 1.0).abs();
            assert!(off < 1e-3 + blur, "{beta_m} {beta_n} {wo:?}: {pdf} {}", drawn.pdf);
            for channel in 0..3 {
                let weight = value[channel] / pdf;
                let off = (weight - drawn.weight[channel]).abs();
                assert!(off < (2e-3 + blur) * weight + 1e-6, "{weight} {drawn:?}");
            }
            compared += 1;
        }
        assert!(compared > 3500, "{compared}");
    }
}

#[test]
fn a_dark_hair_reflects_at_its_surface_only() {
    let hair = HairParameters { absorption: [1e3; 3], ..BROWN };
    let bsdf = Kind::Hair(hair).build::<f32x8>();
    let (wo, mut random) = (direction(0.6, 1.0), Random::new(2));
    let mut sum = 0.0;
    for _ in 0..4000 {
        let drawn = bsdf.sample(splat(wo), [random.eight(), random.eight()], random.eight());
        sum += drawn.weight[0].to_array().iter().map(|&w| f64::from(w)).sum::<f64>();
    }
    let cos = (1.0 - f64::from(wo[0]).powi(2)).sqrt() * (1.0f64 - 0.09).sqrt();
    let exact = fresnel(cos, 1.55, 0.0);
    assert!((sum / 32_000.0 - exact).abs() < 1e-4, "{} {exact}", sum / 32_000.0);
}
