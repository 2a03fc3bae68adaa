//! Densities: samples of BSDFs follow the densities that evaluations return.

use std::f64::consts::PI;

use petzval_base::lanes::{Real, f32x8};
use petzval_render::shade::bsdf::{Bsdf, ShadingFrame, sample_henyey_greenstein};
use petzval_scene::henyey_greenstein;

use super::scene::{Kind, REFLECTANCE, Random, direction, splat};

const ROWS: usize = 20;
const COLUMNS: usize = 24;
/// Integration points along each side of a cell.
const FINE: usize = 48;

/// Integrates the density over each cell of cosine and azimuth.
pub fn expected(bsdf: &dyn Bsdf<f32x8>, wo: [f32; 3]) -> Vec<f64> {
    let mut cells = vec![0.0; ROWS * COLUMNS];
    let point = 4.0 * PI / (ROWS * COLUMNS * FINE * FINE) as f64;
    for row in 0..ROWS * FINE {
        let cos = 2.0 * (row as f64 + 0.5) / (ROWS * FINE) as f64 - 1.0;
        for column in 0..COLUMNS * FINE / 8 {
            let mut wi = [[0.0; 8]; 3];
            for lane in 0..8 {
                let turn = ((column * 8 + lane) as f64 + 0.5) / (COLUMNS * FINE) as f64;
                let w = direction(cos, 2.0 * PI * turn);
                for axis in 0..3 {
                    wi[axis][lane] = w[axis];
                }
            }
            let (_, pdf) = bsdf.evaluate(splat(wo), wi.map(|axis| f32x8::load(&axis)));
            let sum: f64 = pdf.to_array().iter().map(|&d| f64::from(d)).sum();
            cells[row / FINE * COLUMNS + column * 8 / FINE] += sum * point;
        }
    }
    cells
}

/// Counts the samples in each cell.
pub fn counts(bsdf: &dyn Bsdf<f32x8>, wo: [f32; 3], packets: usize, seed: u64) -> Vec<f64> {
    let mut random = Random::new(seed);
    let mut cells = vec![0.0; ROWS * COLUMNS];
    for _ in 0..packets {
        let u = [random.eight(), random.eight()];
        let draw = bsdf.sample(splat(wo), u, random.eight());
        let valid = f32x8::bits(draw.valid);
        let wi = draw.wi.map(|axis| axis.to_array());
        for lane in (0..8).filter(|lane| valid >> lane & 1 == 1) {
            let turn = (wi[1][lane].atan2(wi[0][lane]) / (2.0 * PI as f32)).rem_euclid(1.0);
            let row = ((wi[2][lane] + 1.0) / 2.0 * ROWS as f32) as usize;
            let column = (turn * COLUMNS as f32) as usize;
            cells[row.min(ROWS - 1) * COLUMNS + column.min(COLUMNS - 1)] += 1.0;
        }
    }
    cells
}

/// Returns Pearson's statistic and its degrees of freedom. Cells with few expected samples are
/// pooled, and failed samples form a cell of their own.
pub fn chi_squared(expected: &[f64], counts: &[f64], n: f64) -> (f64, f64) {
    let (mut statistic, mut cells, mut pool) = (0.0, 0.0, [0.0; 2]);
    let mut add = |e: f64, d: f64| {
        statistic += (d - e) * (d - e) / e;
        cells += 1.0;
    };
    for (&e, &d) in expected.iter().zip(counts) {
        if e * n < 25.0 {
            pool = [pool[0] + e * n, pool[1] + d];
        } else {
            add(e * n, d);
        }
    }
    let failed = [n * (1.0 - expected.iter().sum::<f64>()), n - counts.iter().sum::<f64>()];
    for [e, d] in [pool, failed] {
        if e > 25.0 {
            add(e, d);
        } else {
            assert!(d < 80.0, "{d} samples in a cell, expected {e}");
        }
    }
    (statistic, cells - 1.0)
}

/// Returns a bound that a chi-squared variable exceeds once in ten million (Laurent & Massart 2000,
/// Lemma 1).
pub fn bound(degrees: f64) -> f64 {
    let x = 1e7f64.ln();
    degrees + 2.0 * (degrees * x).sqrt() + 2.0 * x
}

#[test]
fn samples_follow_the_density() {
    // An error of 1 % adds n / 10^4 to the statistic, enough to exceed the bound.
    let packets = 400_000;
    let n = 8.0 * packets as f64;
    let kinds = [
        (Kind::Diffuse, 0.7),
        (Kind::DiffuseTransmission, -0.7),
        (Kind::Conductor([0.1, 0.1]), 0.8),
        (Kind::Conductor([0.2, 0.2]), -0.1),
        (Kind::Conductor([0.5, 0.15]), 0.5),
        (Kind::Conductor([1.0, 1.0]), -0.3),
        (Kind::Dielectric([0.15, 0.15], 1.5), 0.9),
        (Kind::Dielectric([0.15, 0.4], 1.5), -0.75),
        (Kind::Dielectric([0.4, 0.2], 0.7), 0.6),
        (Kind::Dielectric([0.6, 0.6], 1.5), 0.1),
        (Kind::Dielectric([1.0, 1.0], 2.4), -0.4),
        (Kind::Plastic(REFLECTANCE, 0.2, 1.5), 0.4),
        (Kind::Plastic([0.0; 3], 0.3, 1.5), 0.8),
        (Kind::Plastic([0.9; 3], 1.0, 2.4), -0.3),
        (Kind::Coated(REFLECTANCE, 0.5, 0.4, 0.2, 0.7), 0.3),
        (Kind::Specular(0.4, 0.2, 0.6, [2.0, 1.0, 0.1]), 0.5),
        (Kind::Tinted(0.3, 1.5, REFLECTANCE), -0.6),
        (Kind::Coated([1.0; 3], 0.2, 1.0, 0.6, 1.0), -0.6),
    ];
    for (seed, (kind, cos)) in kinds.into_iter().enumerate() {
        let bsdf = kind.build::<f32x8>();
        let wo = direction(cos, 0.9);
        let expected = expected(&*bsdf, wo);
        let total: f64 = expected.iter().sum();
        assert!(total < 1.0 + 1e-4 && total > 0.5, "{kind:?}: {total}");
        let counts = counts(&*bsdf, wo, packets, seed as u64);
        let (statistic, degrees) = chi_squared(&expected, &counts, n);
        assert!(statistic < bound(degrees), "{kind:?}: {statistic} of {degrees}");
        // The test detects a density that is 1 % off.
        let wrong: Vec<f64> = expected.iter().map(|e| e * 0.99).collect();
        let (statistic, degrees) = chi_squared(&wrong, &counts, n);
        assert!(statistic > bound(degrees), "{kind:?}: {statistic} of {degrees}");
    }
}

#[test]
fn densities_integrate_to_the_share_of_valid_samples() {
    // Diffuse samples are always valid; microfacets may reflect into the surface.
    for (kind, cos) in [(Kind::Diffuse, 0.5), (Kind::DiffuseTransmission, 0.1)] {
        let total: f64 = expected(&*kind.build(), direction(cos, 0.2)).iter().sum();
        assert!((total - 1.0).abs() < 1e-5, "{kind:?}: {total}");
    }
    let normal = [0.0, 0.0, 1.0];
    for alpha in [0.3, 0.6] {
        let kind = Kind::Conductor([alpha; 2]);
        let total: f64 = expected(&*kind.build(), normal).iter().sum();
        // From above, samples fail if m is more than 45 degrees off the normal, where tan = 1.
        let a2 = f64::from(alpha).powi(2);
        let exact = 1.0 - a2 / (1.0 + a2);
        assert!((total - exact).abs() < 2e-4, "{kind:?}: {total}, not {exact}");
    }
}

#[test]
fn weights_of_samples_are_values_over_densities() {
    let mut random = Random::new(6);
    for alpha in [[1e-4, 1.1e-3], [2e-3, 2e-3], [0.05, 0.05], [0.3, 0.1], [1.0, 1.0]] {
        // Rounding of the half vector relative to the width of the lobe; D holds its fourth power.
        let blur = 4e-6 / alpha[0].min(alpha[1]);
        for kind in [
            Kind::Diffuse,
            Kind::DiffuseTransmission,
            Kind::Conductor(alpha),
            Kind::Dielectric(alpha, 1.5),
            Kind::Dielectric(alpha, 0.7),
            Kind::Plastic(REFLECTANCE, alpha[0].max(2e-3), 1.5),
            Kind::Coated(REFLECTANCE, 0.5, 0.4, alpha[0].max(2e-3), 0.7),
        ] {
            let bsdf = kind.build::<f32>();
            let mut compared = 0;
            for turn in 0..4000 {
                let mut wo = random.direction();
                wo[2] *= if turn & 1 == 0 { 1.0 } else { -1.0 };
                let u = [random.number(), random.number()];
                let draw = bsdf.sample(wo, u, random.number());
                if !draw.valid || draw.wi[2].abs() < 0.02 || wo[2].abs() < 0.02 {
                    continue;
                }
                assert!(!draw.singular);
                let (value, pdf) = bsdf.evaluate(wo, draw.wi);
                let off = (pdf / draw.pdf - 1.0).abs();
                assert!(off < 1e-3 + blur, "{kind:?} {wo:?}: {pdf} {}", draw.pdf);
                for channel in 0..3 {
                    let weight = value[channel] / pdf;
                    let off = (weight - draw.weight[channel]).abs();
                    assert!(off < 2e-3 * weight, "{kind:?} {wo:?}: {weight} {draw:?}");
                }
                let length2: f32 = draw.wi.iter().map(|x| x * x).sum();
                assert!((length2 - 1.0).abs() < 2e-6, "{kind:?} {wo:?}: {length2}");
                compared += 1;
            }
            assert!(compared > 2000, "{kind:?}: {compared}");
        }
    }
}

#[test]
fn henyey_greenstein_is_normalised_and_its_samples_have_the_mean_cosine() {
    for g in [-0.7f32, 0.0, 0.3, 0.9] {
        let steps = 200_000;
        let mut integral = 0.0;
        for step in 0..steps {
            let cos = 2.0 * (f64::from(step) + 0.5) / f64::from(steps) - 1.0;
            integral += f64::from(henyey_greenstein(cos as f32, g)) * 4.0 * PI / f64::from(steps);
        }
        assert!((integral - 1.0).abs() < 1e-4, "{g}: {integral}");
        let mut random = Random::new(7);
        let n = 400_000;
        let wo = direction(0.3, 2.0);
        let mut mean = [0.0; 3];
        for _ in 0..n {
            let wi = sample_henyey_greenstein(wo, g, [random.number(), random.number()]);
            for axis in 0..3 {
                mean[axis] += f64::from(wi[axis]) / f64::from(n);
            }
        }
        // The mean direction is g times the forward direction; its error is below 1 / sqrt n.
        for axis in 0..3 {
            let exact = -f64::from(g) * f64::from(wo[axis]);
            assert!((mean[axis] - exact).abs() < 5.0 / f64::from(n).sqrt(), "{g}: {mean:?}");
        }
    }
}

#[test]
fn shading_frames_are_orthonormal_and_follow_the_tangent() {
    let mut random = Random::new(8);
    for turn in 0..2000 {
        let mut n = random.direction();
        n[2] *= if turn & 1 == 0 { 1.0 } else { -1.0 };
        let size = [1.0, 1e-25, 1e25, 0.0][turn % 4];
        let t = random.direction().map(|x| x * size);
        // A tangent along the normal gives no direction.
        let t = if turn % 7 == 0 { n } else { t };
        let frame = ShadingFrame::about(n, t);
        let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let ShadingFrame { x, y, z } = frame;
        for (a, b, exact) in
            [(x, x, 1.0), (y, y, 1.0), (z, z, 1.0), (x, y, 0.0), (x, z, 0.0), (y, z, 0.0)]
        {
            assert!((dot(a, b) - exact).abs() < 1e-4, "{n:?} {t:?}: {frame:?}");
        }
        let handed = x[0] * (y[1] * z[2] - y[2] * z[1])
            + x[1] * (y[2] * z[0] - y[0] * z[2])
            + x[2] * (y[0] * z[1] - y[1] * z[0]);
        assert!(handed > 0.99);
        if size > 0.0 && turn % 7 != 0 {
            assert!(dot(x, t) >= 0.0 && dot(y, t).abs() <= 1e-4 * size, "{n:?} {t:?}: {frame:?}");
        }
        let w = random.direction();
        let back = frame.to_world(frame.to_local(w));
        assert!((0..3).all(|axis| (back[axis] - w[axis]).abs() < 1e-4));
        assert_eq!(frame.to_local(n).map(|c| (c * 1e4).round()), [0.0, 0.0, 1e4]);
    }
}
