//! Naive twin of the BSDFs in f64: Walter et al. 2007 for microfacets, and Born & Wolf for the
//! Fresnel equations with complex numbers. It shares no formula with the program.

use std::f64::consts::PI;

use petzval_render::shade::bsdf::{Refraction, conductor_reflectance};

use super::scene::{ETA, K, Kind, Random};

type Complex = [f64; 2];

fn times(a: Complex, b: Complex) -> Complex {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}

fn over(a: Complex, b: Complex) -> Complex {
    let size = b[0] * b[0] + b[1] * b[1];
    times(a, [b[0] / size, -b[1] / size])
}

fn plus(a: Complex, b: Complex, sign: f64) -> Complex {
    [a[0] + sign * b[0], a[1] + sign * b[1]]
}

fn root(a: Complex) -> Complex {
    let (size, angle) = (a[0].hypot(a[1]).sqrt(), a[1].atan2(a[0]) / 2.0);
    [size * angle.cos(), size * angle.sin()]
}

fn size2(a: Complex) -> f64 {
    a[0] * a[0] + a[1] * a[1]
}

/// Returns the Fresnel reflectance for a complex index (k >= 0), by Snell's law for complex angles.
pub fn fresnel(cos: f64, eta: f64, k: f64) -> f64 {
    let index = [eta, k];
    let sin2 = 1.0 - cos * cos;
    let bent = over([sin2, 0.0], times(index, index));
    let cos_t = root(plus([1.0, 0.0], bent, -1.0));
    let (here, there) = ([cos, 0.0], times(index, cos_t));
    let s = over(plus(here, there, -1.0), plus(here, there, 1.0));
    let dense = times(index, here);
    let p = over(plus(dense, cos_t, -1.0), plus(dense, cos_t, 1.0));
    (size2(s) + size2(p)) / 2.0
}

/// Power of the share of light by which glass samples its lobes.
pub const GLASS: f64 = 0.75;
/// Power of the share of light by which a coat samples its reflection.
pub const COAT: f64 = 0.5;

/// Returns the probabilities with which reflection and transmission are sampled.
pub fn chances(reflectance: f64, power: f64) -> [f64; 2] {
    let powers = [reflectance, 1.0 - reflectance].map(|share| share.powf(power));
    powers.map(|p| p / (powers[0] + powers[1]))
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn tan2(m: [f64; 3]) -> f64 {
    let theta = m[2].abs().min(1.0).acos();
    theta.tan() * theta.tan()
}

fn d(m: [f64; 3], alpha: [f64; 2]) -> f64 {
    let phi = m[1].atan2(m[0]);
    let e = tan2(m) * ((phi.cos() / alpha[0]).powi(2) + (phi.sin() / alpha[1]).powi(2));
    1.0 / (PI * alpha[0] * alpha[1] * m[2].powi(4) * (1.0 + e) * (1.0 + e))
}

fn lambda(w: [f64; 3], alpha: [f64; 2]) -> f64 {
    let phi = w[1].atan2(w[0]);
    let a2 = (phi.cos() * alpha[0]).powi(2) + (phi.sin() * alpha[1]).powi(2);
    ((1.0 + a2 * tan2(w)).sqrt() - 1.0) / 2.0
}

/// Returns f |cos wi| of the first channel and the density, for a rough conductor or dielectric.
pub fn scatter(kind: Kind, wo: [f32; 3], wi: [f32; 3]) -> (f64, f64) {
    let (o, i) = (wo.map(f64::from), wi.map(f64::from));
    let same = o[2] * i[2] > 0.0;
    let (alpha, ratio) = match kind {
        Kind::Conductor(alpha) if same => (alpha, 1.0),
        Kind::Conductor(_) => return (0.0, 0.0),
        Kind::Dielectric(alpha, eta) => {
            (alpha, if o[2] > 0.0 { f64::from(eta) } else { 1.0 / f64::from(eta) })
        }
        _ => unreachable!("the twin has conductors and dielectrics only"),
    };
    let alpha = alpha.map(f64::from);
    let bend = if same { 1.0 } else { ratio };
    let half = [0, 1, 2].map(|a| o[a] + bend * i[a]);
    let length = dot(half, half).sqrt();
    let sign = if half[2] * o[2] < 0.0 { -1.0 } else { 1.0 };
    let m = half.map(|h| sign * h / length);
    let (om, im) = (dot(o, m), dot(i, m));
    if om <= 0.0 || (im > 0.0) != same {
        return (0.0, 0.0);
    }
    let (lo, li) = (lambda(o, alpha), lambda(i, alpha));
    let g = 1.0 / (1.0 + lo + li);
    let seen = d(m, alpha) * om / ((1.0 + lo) * o[2].abs());
    if let Kind::Conductor(_) = kind {
        let f = fresnel(om, f64::from(ETA[0]), f64::from(K[0]));
        return (d(m, alpha) * g * f / (4.0 * o[2].abs()), seen / (4.0 * om));
    }
    let f = if 1.0 - om * om >= ratio * ratio { 1.0 } else { fresnel(om, ratio, 0.0) };
    let [reflects, passes] = chances(f, GLASS);
    if same {
        (d(m, alpha) * g * f / (4.0 * o[2].abs()), reflects * seen / (4.0 * om))
    } else {
        let jacobian = im.abs() * ratio * ratio / (om + ratio * im).powi(2);
        let bsdf = d(m, alpha) * g * (1.0 - f) * om * jacobian / o[2].abs();
        // Refraction divides radiance by the squared index.
        (bsdf / (ratio * ratio), passes * seen * jacobian)
    }
}

#[test]
fn conductor_reflectance_agrees_with_complex_arithmetic() {
    // f32 rounding of quantities up to k^2 = 50 over denominators of that size.
    let tolerance = 1e-5;
    for (eta, k) in [(0.05, 4.0), (0.2, 3.58), (1.16, 2.42), (1.0, 0.1), (2.9, 3.1), (1.0, 7.0)] {
        for step in 0..=100 {
            let cos = f64::from(step) / 100.0;
            let ours = f64::from(conductor_reflectance(cos as f32, eta as f32, k as f32));
            let exact = fresnel(cos, eta, k);
            assert!((ours - exact).abs() < tolerance, "{cos} {eta} {k}: {ours}, not {exact}");
        }
    }
}

#[test]
fn a_conductor_without_absorption_reflects_like_a_dielectric() {
    for step in 0..=100 {
        let cos = step as f32 / 100.0;
        for eta in [1.0f32, 1.33, 1.5, 2.4] {
            let glass = Refraction::new(cos, eta).reflectance;
            let metal = conductor_reflectance(cos, eta, 0.0);
            let exact =
                if eta == 1.0 && step > 0 { 0.0 } else { fresnel(cos.into(), eta.into(), 0.0) };
            let exact = if exact.is_nan() { 1.0 } else { exact };
            assert!((f64::from(glass) - exact).abs() < 1e-6, "{cos} {eta}: {glass}, not {exact}");
            // The formula for conductors subtracts squares, which costs accuracy.
            assert!((metal - glass).abs() < 2e-3 || step == 0, "{cos} {eta}: {metal}, {glass}");
        }
    }
}

#[test]
fn reflection_is_total_beyond_the_critical_angle() {
    let critical = (1.0f32 - 1.0 / (1.5 * 1.5)).sqrt();
    let at = |cos| Refraction::new(cos, 1.0 / 1.5).reflectance;
    assert_eq!([at(critical * 0.999), at(0.1), at(0.0)], [1.0; 3]);
    assert!(at(critical * 1.001) < 1.0);
    assert!((at(1.0) - 0.04).abs() < 1e-6);
}

#[test]
fn rough_surfaces_agree_with_the_textbook() {
    // Half vectors have rounding errors of 1e-7, relative to a lobe of width alpha.
    let tolerance = |alpha: [f32; 2]| 1e-5 + 1e-5 / f64::from(alpha[0].min(alpha[1]));
    let mut random = Random::new(1);
    let (mut compared, mut poor) = (0, 0);
    for alpha in [[0.01, 0.01], [0.1, 0.1], [0.3, 0.05], [0.5, 0.5], [0.2, 1.0], [1.0, 1.0]] {
        for kind in
            [Kind::Conductor(alpha), Kind::Dielectric(alpha, 1.5), Kind::Dielectric(alpha, 0.7)]
        {
            let bsdf = kind.build::<f32>();
            for turn in 0..4000 {
                let mut wo = random.direction();
                let u = [random.number(), random.number()];
                if turn & 1 == 1 {
                    wo[2] = -wo[2];
                }
                // Half of the directions are in the lobe, half anywhere.
                let mut wi = bsdf.sample(wo, u, random.number()).wi;
                if turn & 2 == 2 {
                    wi = random.direction();
                    wi[2] *= if random.number() < 0.5 { -1.0 } else { 1.0 };
                }
                let (value, pdf) = bsdf.evaluate(wo, wi);
                let (exact, exact_pdf) = scatter(kind, wo, wi);
                let off = |ours: f32, exact: f64| {
                    ((f64::from(ours) - exact).abs() - 1e-6) / exact.max(1e-30)
                };
                let off = off(value[0], exact).max(off(pdf, exact_pdf));
                assert!(
                    off < 5e-2 || wi[2].abs() < 1e-2 || wo[2].abs() < 1e-2,
                    "{kind:?} {wo:?} {wi:?}: {} {pdf}, not {exact} {exact_pdf}",
                    value[0]
                );
                poor += usize::from(off > tolerance(alpha));
                compared += usize::from(exact > 0.0);
            }
        }
    }
    assert!(compared > 40_000, "{compared}");
    // Near the critical angle of a microfacet, rounding of the directions has an effect.
    assert!(poor * 50 < compared, "{poor} of {compared}");
}
