//! Coats: means of their random walks, against closed forms and against each other.

use std::f64::consts::PI;

use petzval_render::shade::bsdf::{
    Bsdf, CoatLayer, Coated, Conductor, Dielectric, Diffuse, MisWeights, ThinDielectric,
};

use super::scene::{ETA, K, REFLECTANCE, Random, direction};
use super::twin::{COAT, chances, fresnel};

fn layer(alpha: f32, eta: f32, thickness: f32) -> CoatLayer<f32> {
    CoatLayer {
        interface: Dielectric::new([alpha; 2], eta),
        thickness,
        albedo: [0.0; 3],
        g: 0.0,
        max_depth: 10.0,
        samples: 1.0,
        weights: MisWeights::Exact,
    }
}

fn diffuse(reflectance: [f32; 3]) -> Diffuse<f32> {
    Diffuse { reflectance }
}

/// A BSDF by the seed of its walks.
type SeededBsdf = Box<dyn Fn(u32) -> Box<dyn Bsdf<f32>>>;

fn seeded<B: Bsdf<f32> + Copy + 'static>(coated: Coated<f32, B>) -> SeededBsdf {
    Box::new(move |seed| Box::new(coated.seeded(seed)))
}

fn unseeded<B: Bsdf<f32> + Copy + 'static>(bsdf: B) -> SeededBsdf {
    Box::new(move |_| Box::new(bsdf))
}

/// Count, sum and sum of squares of values.
#[derive(Default)]
struct Mean([f64; 3]);

impl Mean {
    fn add(&mut self, x: f64) {
        self.0 = [self.0[0] + 1.0, self.0[1] + x, self.0[2] + x * x];
    }

    /// Returns the mean and its standard error.
    fn mean_and_error(&self) -> (f64, f64) {
        let [n, sum, squares] = self.0;
        let mean = sum / n;
        (mean, ((squares / n - mean * mean).max(0.0) / n).sqrt())
    }
}

/// Returns the albedo of a diffuse base under a clear layer of index 1.5, seen from inside the
/// layer: the geometric series of reflections at base and interface.
fn albedo_under_layer(reflectance: f64, thickness: f64) -> f64 {
    let steps = 20_000;
    let mut inside = 0.0;
    for step in 0..steps {
        let cos = (f64::from(step) + 0.5) / f64::from(steps);
        let total = 1.0 - cos * cos >= 1.0 / 2.25;
        let reflected = if total { 1.0 } else { fresnel(cos, 1.0 / 1.5, 0.0) };
        inside += 2.0 * cos * reflected * (-2.0 * thickness / cos).exp() / f64::from(steps);
    }
    reflectance / (1.0 - reflectance * inside)
}

/// Returns the share of light from outside that reaches the base.
fn transmitted_to_base(cos: f64, thickness: f64) -> f64 {
    let inside = (1.0 - (1.0 - cos * cos) / 2.25f64).sqrt();
    (1.0 - fresnel(cos, 1.5, 0.0)) * (-thickness / inside).exp()
}

#[test]
fn values_of_a_clear_coat_over_a_diffuse_base_have_the_closed_form() {
    for (thickness, max_depth) in [(0.0, 60.0), (0.3, 60.0)] {
        let layer = CoatLayer { max_depth, ..layer(0.0, 1.5, thickness) };
        let coated = Coated::new(layer, diffuse(REFLECTANCE));
        let thickness = f64::from(thickness);
        for (cos_o, cos_i) in [(1.0, 0.8), (0.5, 0.9), (0.2, 0.3)] {
            let (wo, wi) = (direction(cos_o, 0.0), direction(cos_i, 2.0));
            let mut means: [Mean; 3] = Default::default();
            for seed in 0..250_000 {
                let value = coated.value(wo, wi, seed);
                (0..3).for_each(|c| means[c].add(f64::from(value[c])));
            }
            for channel in 0..3 {
                let exact = albedo_under_layer(f64::from(REFLECTANCE[channel]), thickness)
                    * transmitted_to_base(cos_o, thickness)
                    * transmitted_to_base(cos_i, thickness)
                    * cos_i
                    / (2.25 * PI);
                let (mean, error) = means[channel].mean_and_error();
                assert!(
                    error < 2.1e-3 * exact,
                    "the estimate is too noisy for the test: {error} of {exact}"
                );
                assert!((mean - exact).abs() < 5.0 * error + 1e-6, "{mean}, not {exact}");
            }
        }
    }
}

#[test]
fn samples_of_a_clear_coat_over_a_diffuse_base_have_the_closed_form() {
    for thickness in [0.0, 0.3] {
        let layer = CoatLayer { max_depth: 60.0, ..layer(0.0, 1.5, thickness) };
        let coated = Coated::new(layer, diffuse(REFLECTANCE));
        let thickness = f64::from(thickness);
        // Share of the light from the base that leaves the layer without a reflection.
        let steps = 20_000;
        let mut leaves = 0.0;
        for step in 0..steps {
            let cos = (f64::from(step) + 0.5) / f64::from(steps);
            if 1.0 - cos * cos < 1.0 / 2.25 {
                let passes = (1.0 - fresnel(cos, 1.0 / 1.5, 0.0)) * (-thickness / cos).exp();
                leaves += 2.0 * cos * passes / f64::from(steps);
            }
        }
        for cos in [1.0, 0.5, 0.1] {
            let wo = direction(cos, 1.0);
            let mut random = Random::new(9);
            let (mut reflected, mut weights) = (0.0, 0.0);
            let mut means = <[Mean; 3]>::default();
            let n = 200_000;
            for seed in 0..n {
                let u = [random.number(), random.number()];
                let draw = coated.sample(wo, u, random.number(), seed);
                let through = draw.valid && !draw.singular;
                if draw.valid && draw.singular {
                    reflected += 1.0 / f64::from(n);
                    weights += f64::from(draw.weight[0]) / f64::from(n);
                }
                for c in 0..3 {
                    means[c].add(if through { f64::from(draw.weight[c]) } else { 0.0 });
                }
            }
            let f = fresnel(cos, 1.5, 0.0);
            let [reflects, passes] = chances(f, COAT);
            assert!((reflected - reflects).abs() < 5.0 * (reflects * passes / f64::from(n)).sqrt());
            assert!((weights - reflected * f / reflects).abs() < 1e-4 * weights);
            for channel in 0..3 {
                let back = albedo_under_layer(f64::from(REFLECTANCE[channel]), thickness);
                let exact = transmitted_to_base(cos, thickness) * back * leaves;
                let (mean, error) = means[channel].mean_and_error();
                assert!((mean - exact).abs() < 5.0 * error, "{cos}: {mean}, not {exact}");
            }
        }
    }
}

/// Checks that samples and evaluations of a coat agree in the moments of the light scattered to
/// `wo`: of 1 and of each component of the direction, in channel 1.
fn assert_samples_agree_with_values<B: Bsdf<f32> + std::fmt::Debug>(
    coated: &Coated<f32, B>,
    wo: [f32; 3],
    n: u32,
) {
    let mut random = Random::new(10);
    let (mut draws, mut values) = (<[Mean; 4]>::default(), <[Mean; 4]>::default());
    let moments = |w: [f32; 3], x: f32| [1.0, w[0], w[1], w[2]].map(|m| f64::from(m * x));
    let add = |means: &mut [Mean; 4], moments: [f64; 4]| {
        (0..4).for_each(|k| means[k].add(moments[k]));
    };
    for seed in 0..n {
        let u = [random.number(), random.number()];
        let draw = coated.sample(wo, u, random.number(), seed);
        let weight = if draw.valid && !draw.singular { draw.weight[1] } else { 0.0 };
        add(&mut draws, moments(draw.wi, weight));
        // Half of the directions follow a wide lobe about the mirror direction, half the cosine.
        let wide = Conductor::new([0.45; 2], [1.0; 3], [100.0; 3]);
        let cosine = diffuse([1.0; 3]);
        let u = [random.number(), random.number()];
        let wi = if random.number() < 0.5 {
            wide.sample(wo, u, 0.0).wi
        } else {
            cosine.sample(wo, u, 0.0).wi
        };
        let pdf = (wide.evaluate(wo, wi).1 + cosine.evaluate(wo, wi).1) / 2.0;
        // The lobe returns the normal if it samples no direction.
        let weight = if wi == [0.0, 0.0, 1.0] {
            0.0
        } else {
            coated.evaluate(wo, wi, seed.wrapping_mul(77)).0[1] / pdf
        };
        add(&mut values, moments(wi, weight));
    }
    for k in 0..4 {
        let ((a, error_a), (b, error_b)) = (draws[k].mean_and_error(), values[k].mean_and_error());
        let error = error_a.hypot(error_b);
        assert!(error < 5e-3, "the estimate is too noisy for the test: {error}");
        assert!((a - b).abs() < 5.0 * error, "{coated:?} {wo:?} moment {k}: {a}, {b} +- {error}");
    }
}

#[test]
fn samples_and_values_of_a_coat_agree() {
    let n = 100_000;
    let wo = direction(0.7, 0.4);
    let hazy =
        |layer: CoatLayer<f32>| CoatLayer { albedo: [0.5, 0.9, 0.2], max_depth: 200.0, ..layer };
    let metal = |alpha: f32| Conductor::new([alpha; 2], ETA, K);
    let long = |layer: CoatLayer<f32>| CoatLayer { max_depth: 100.0, ..layer };
    assert_samples_agree_with_values(
        &Coated::new(long(layer(0.0, 1.5, 0.01)), diffuse(REFLECTANCE)),
        wo,
        n,
    );
    assert_samples_agree_with_values(
        &Coated::new(long(layer(0.3, 1.5, 0.01)), diffuse(REFLECTANCE)),
        wo,
        n,
    );
    assert_samples_agree_with_values(&Coated::new(layer(0.3, 1.5, 0.01), metal(0.4)), wo, n);
    assert_samples_agree_with_values(&Coated::new(layer(0.4, 1.3, 0.1), metal(0.0)), wo, n);
    assert_samples_agree_with_values(&Coated::new(layer(0.0, 1.5, 0.1), metal(0.4)), wo, n);
    assert_samples_agree_with_values(
        &Coated::new(hazy(layer(0.0, 1.5, 0.5)), diffuse(REFLECTANCE)),
        wo,
        n,
    );
    let forward = CoatLayer { g: 0.5, ..hazy(layer(0.4, 1.4, 0.8)) };
    assert_samples_agree_with_values(&Coated::new(forward, diffuse(REFLECTANCE)), wo, n);
    assert_samples_agree_with_values(&Coated::new(forward, metal(0.0)), direction(0.3, 2.0), n);
}

#[test]
fn weights_of_pbrt_differ_only_if_interface_and_base_are_rough() {
    let mean = |layer: CoatLayer<f32>, base: Diffuse<f32>| {
        let coated = Coated::new(layer, base);
        let mut random = Random::new(15);
        let mut mean = Mean::default();
        for seed in 0..100_000 {
            let wi = random.direction();
            mean.add(f64::from(coated.value([0.6, 0.0, 0.8], wi, seed)[1]));
        }
        mean.mean_and_error()
    };
    for (alpha, excess) in [(0.0, 0.0..1e-9), (0.3, 0.03..0.12)] {
        let exact = layer(alpha, 1.5, 0.01);
        let pbrt = CoatLayer { weights: MisWeights::Pbrt, ..exact };
        let base = diffuse(REFLECTANCE);
        let ((exact, _), (pbrt, _)) = (mean(exact, base), mean(pbrt, base));
        assert!(excess.contains(&(pbrt / exact - 1.0)), "{alpha}: {pbrt} {exact}");
    }
}

#[test]
fn a_lossless_coat_returns_all_light() {
    // The interface is smooth, the base white, and the medium only scatters.
    for (eta, g) in [(1.5, -0.4), (1.5, 0.0), (1.5, 0.8), (2.4, 0.0)] {
        let white = CoatLayer { albedo: [1.0; 3], max_depth: 3000.0, g, ..layer(0.0, eta, 0.7) };
        let clear = CoatLayer { max_depth: 3000.0, g, ..layer(0.0, eta, 0.0) };
        for layer in [white, clear] {
            let coated = Coated::new(layer, diffuse([1.0; 3]));
            let mut random = Random::new(11);
            for seed in 0..4000 {
                let mut wo = random.direction();
                wo[2] *= if seed % 2 == 0 { 1.0 } else { -1.0 };
                let u = [random.number(), random.number()];
                let draw = coated.sample(wo, u, random.number(), seed);
                // A walk fails if it would take a step of zero length, once in 16 million.
                assert!(draw.valid && draw.wi[2] * wo[2] > 0.0, "{layer:?} {wo:?}");
                let f = fresnel(f64::from(wo[2].abs()), f64::from(eta), 0.0);
                let [reflects, passes] = chances(f, COAT);
                let expected = if draw.singular { f / reflects } else { (1.0 - f) / passes };
                let off = (f64::from(draw.weight[0]) - expected).abs();
                assert!(off < 1e-3, "{layer:?} {wo:?}: {draw:?}, not {expected}");
                assert_eq!(draw.eta2, 1.0, "the walk enters and leaves the layer");
            }
        }
    }
}

#[test]
fn a_coat_without_effect_equals_its_base() {
    let mut random = Random::new(12);
    let metal = Conductor::new([0.3; 2], ETA, K);
    for seed in 0..2000 {
        let (wo, wi) = (random.direction(), random.direction());
        let nothing = layer(0.0, 1.0, 0.0);
        let (coated, base) =
            (Coated::new(nothing, metal).value(wo, wi, seed), metal.evaluate(wo, wi).0);
        let paint = diffuse(REFLECTANCE);
        let (painted, paint) =
            (Coated::new(nothing, paint).value(wo, wi, seed), paint.evaluate(wo, wi).0);
        for channel in 0..3 {
            assert!((coated[channel] - base[channel]).abs() <= 1e-5 * base[channel]);
            assert!((painted[channel] - paint[channel]).abs() <= 1e-5 * paint[channel]);
        }
    }
}

#[test]
fn a_smooth_coat_over_black_is_singular() {
    let coated = Coated::new(layer(0.0, 1.5, 0.01), diffuse([0.0; 3]));
    assert!(coated.is_singular());
    let wo = direction(0.6, 0.0);
    let n = 4000;
    let mut reflected = 0.0;
    for step in 0..n {
        let draw = coated.sample(wo, [0.3, 0.4], (step as f32 + 0.5) / n as f32, step);
        if draw.valid {
            assert!(draw.singular && draw.wi == [-wo[0], -wo[1], wo[2]]);
            reflected += f64::from(draw.weight[0]) / f64::from(n);
        }
    }
    assert!((reflected - fresnel(0.6, 1.5, 0.0)).abs() < 1.0 / f64::from(n));
}

#[test]
fn both_sides_of_a_coat_are_the_same() {
    let hazy = CoatLayer { albedo: [0.9; 3], ..layer(0.2, 1.5, 0.4) };
    let coated = Coated::new(hazy, diffuse(REFLECTANCE));
    let mut random = Random::new(13);
    for seed in 0..500 {
        let (wo, wi) = (random.direction(), random.direction());
        let turned = |w: [f32; 3]| w.map(|x| -x);
        assert_eq!(coated.evaluate(wo, wi, seed), coated.evaluate(turned(wo), turned(wi), seed));
        let u = [random.number(), random.number()];
        let (above, below) =
            (coated.sample(wo, u, 0.7, seed), coated.sample(turned(wo), u, 0.7, seed));
        assert_eq!(above.valid, below.valid);
        if above.valid {
            assert_eq!((turned(above.wi), above.weight), (below.wi, below.weight));
            assert_eq!(above.pdf, below.pdf);
        }
        // No light is transmitted.
        assert_eq!(coated.value(wo, turned(wi), seed), [0.0; 3]);
    }
}

#[test]
fn multiple_importance_sampling_of_a_coat_is_unbiased() {
    // A sky of radiance 1, by light samples alone and by both techniques, weighted by the power
    // heuristic of the estimated densities.
    let coated = Coated::new(layer(0.25, 1.5, 0.05), diffuse(REFLECTANCE));
    let wo = direction(0.6, 0.0);
    let mut random = Random::new(14);
    let light = 1.0 / (2.0 * std::f32::consts::PI);
    let (mut alone, mut mixed) = (Mean::default(), Mean::default());
    for seed in 0..400_000 {
        let weight = |mine: f32, other: f32| mine * mine / (mine * mine + other * other);
        let (cos, turn) = (f64::from(random.number()), f64::from(random.number()));
        let wi = direction(cos, 2.0 * PI * turn);
        let (value, pdf) = coated.evaluate(wo, wi, seed);
        let received = value[1] / light;
        let mut sum = received * weight(light, pdf);
        let u = [random.number(), random.number()];
        let draw = coated.sample(wo, u, random.number(), seed);
        if draw.valid {
            assert!(!draw.singular && draw.pdf > 0.0);
            sum += draw.weight[1] * weight(draw.pdf, light);
        }
        alone.add(f64::from(received));
        mixed.add(f64::from(sum));
    }
    let ((a, error_a), (b, error_b)) = (alone.mean_and_error(), mixed.mean_and_error());
    assert!((a - b).abs() < 5.0 * error_a.hypot(error_b), "{a} {b}");
    assert!(error_a.hypot(error_b) < 2e-3, "{error_a} {error_b}");
}

#[test]
fn the_density_of_a_coat_counts_how_rarely_its_interface_reflects() {
    let coated = Coated::new(layer(0.05, 1.5, 0.01), diffuse([0.5; 3]));
    for cos in [1.0, 0.6, 0.25] {
        let wo = direction(cos, 0.5);
        let mirror = [-wo[0], -wo[1], wo[2]];
        let in_lobe = |w: [f32; 3]| w[0] * mirror[0] + w[1] * mirror[1] + w[2] * mirror[2] > 0.98;
        let mut random = Random::new(16);
        let (mut sampled, mut integral) = (Mean::default(), Mean::default());
        // The lobe holds all but the tails of the reflection, and little of the rest.
        let solid_angle = 2.0 * PI * 0.02;
        let lobe = Conductor::new([0.05; 2], [1.0; 3], [100.0; 3]);
        for seed in 0..200_000 {
            let u = [random.number(), random.number()];
            let draw = coated.sample(wo, u, random.number(), seed);
            sampled.add(f64::from(u8::from(draw.valid && in_lobe(draw.wi))));
            // Half of the directions follow the lobe, half are uniform in the cone.
            let u = [random.number(), random.number()];
            let wi = if random.number() < 0.5 {
                lobe.sample(wo, u, 0.0).wi
            } else {
                let (z, turn) = (1.0 - 0.02 * random.number(), 2.0 * PI as f32 * u[0]);
                about(mirror, z, turn)
            };
            let counts = in_lobe(wi) && wi[2] > 0.0;
            let pdf = 0.5 * f64::from(lobe.evaluate(wo, wi).1) + 0.5 / solid_angle;
            let density =
                if counts { f64::from(coated.evaluate(wo, wi, seed).1) / pdf } else { 0.0 };
            integral.add(density);
        }
        let ((share, _), (integral, error)) = (sampled.mean_and_error(), integral.mean_and_error());
        assert!(error < 0.01 * share, "{cos}: the estimate is too noisy: {error} of {share}");
        // Multiple reflections and the tenth of uniform samples are the rest.
        assert!((0.8..1.2).contains(&(integral / share)), "{cos}: {integral} for {share}");
    }
}

/// Returns the unit vector at an angle of cosine `z` from `axis`, turned about it.
fn about(axis: [f32; 3], z: f32, turn: f32) -> [f32; 3] {
    let axis = glam::Vec3::from(axis);
    let (x, y) = axis.any_orthonormal_pair();
    let sin = (1.0 - z * z).max(0.0).sqrt();
    (axis * z + (x * turn.cos() + y * turn.sin()) * sin).into()
}

#[test]
fn coats_are_finite_for_extreme_directions() {
    let directions = [
        [0.0, 0.0, 1.0],
        [1.0, 0.0, 0.0],
        [1.0, 0.0, 1e-20],
        [-1.0, 0.0, 1e-6],
        [0.0, 1.0, -1e-4],
        [0.0, 0.6, -0.8],
    ];
    let mut coats: Vec<SeededBsdf> = Vec::new();
    for (alpha, thickness, albedo, g) in [
        (0.0, 0.0, 0.0, 0.0),
        (1e-4, 1e20, 0.0, 0.0),
        (0.002, 1e-30, 0.5, 1.0),
        (1.0, 1e9, 1.0, -1.0),
        (0.3, -1.0, 1.0, 0.0),
    ] {
        let layer = CoatLayer { albedo: [albedo; 3], g, ..layer(alpha, 1.5, thickness) };
        coats.push(seeded(Coated::new(layer, diffuse([1.0; 3]))));
        for alpha in [0.0, 0.3] {
            let metal = Conductor::new([alpha; 2], ETA, K);
            coats.push(seeded(Coated::new(layer, metal)));
        }
    }
    for (i, coat) in coats.iter().enumerate() {
        for (wo, wi) in directions.into_iter().flat_map(|wo| directions.map(|wi| (wo, wi))) {
            for seed in 0..20 {
                let coat = coat(seed);
                let (value, pdf) = coat.evaluate(wo, wi);
                for x in value.into_iter().chain([pdf]) {
                    assert!((0.0..f32::INFINITY).contains(&x), "coat {i} {wo:?} {wi:?}: {x}");
                }
                let choice = seed as f32 / 20.0;
                let draw = coat.sample(wo, [0.1, choice], choice);
                let all = draw.wi.into_iter().chain(draw.weight).chain([draw.pdf]);
                assert!(all.into_iter().all(f32::is_finite), "coat {i} {wo:?}: {draw:?}");
                assert!(!draw.valid || draw.wi[2] * wo[2] > 0.0, "coat {i} {wo:?}: {draw:?}");
            }
        }
    }
}

#[test]
fn is_singular_tells_whether_values_are_zero() {
    let metal = |alpha: f32| Conductor::new([alpha; 2], ETA, K);
    let coat = |alpha: f32, base| seeded(Coated::new(layer(alpha, 1.5, 0.1), base));
    let hazy = CoatLayer { albedo: [0.1; 3], ..layer(0.0, 1.5, 0.1) };
    let cases = [
        (unseeded(diffuse([0.5; 3])), false),
        (unseeded(metal(0.0)), true),
        (unseeded(metal(0.2)), false),
        (unseeded(Dielectric::new([0.0; 2], 1.5)), true),
        (unseeded(Dielectric::new([0.2; 2], 1.5)), false),
        (unseeded(Dielectric::new([0.2; 2], 1.0)), true),
        (unseeded(ThinDielectric::new([1.5; 3])), true),
        (seeded(Coated::new(layer(0.0, 1.5, 0.1), diffuse([0.5; 3]))), false),
        (coat(0.0, metal(0.0)), true),
        (coat(0.2, metal(0.0)), false),
        (coat(0.0, metal(0.2)), false),
        (seeded(Coated::new(hazy, metal(0.0))), false),
    ];
    let (wo, wi) = ([0.6, 0.0, 0.8], [-0.48, 0.36, 0.8]);
    for (i, (bsdf, singular)) in cases.into_iter().enumerate() {
        assert_eq!(bsdf(0).singular(), singular, "case {i}");
        let lit = (0..50).any(|seed| bsdf(seed).evaluate(wo, wi).0 != [0.0; 3]);
        assert_eq!(lit, !singular, "case {i}");
        for seed in 0..50 {
            let draw = bsdf(seed).sample(wo, [0.3, 0.2], seed as f32 / 50.0);
            assert!(!singular || draw.singular || !draw.valid, "case {i}");
        }
    }
}
