//! Comparison of one set of rays in every precision of the program with the oracle.

use petzval_base::lanes::{Real, f32x8};
use petzval_base::rays::{LensBatch, WAVE_SIZE};
use petzval_lens::{
    Blocked, LensRay, Prescription, Row, Side, Surface, retrace_in_f64, sequence, trace, trace_one,
};

use super::Random;
use super::oracle::{Exit, Oracle, Outcome, V, dot, unit};

/// Point in the frame of the film, mm, and direction, in numbers that f32 holds exactly.
pub type Start = [V; 2];

/// Initial weight of the rays. It differs from 1 so that openings are seen to multiply it.
const HALF: f64 = 0.5;

/// Rounds a point and a direction of any length to f32.
pub fn start(p: V, towards: V) -> Start {
    [p, unit(towards)].map(|v| v.map(|v| f64::from(v as f32)))
}

/// Returns a lens of these rows. Without a stop among them the first row becomes it.
pub fn lens_of_rows(mut rows: Vec<Row>) -> Prescription {
    if !rows.iter().any(|row| row.stop) {
        rows[0].stop = true;
    }
    Prescription::new("made", rows).expect("one stop")
}

/// Optical bench: a lens and a film `film` mm behind it, prepared for the program and the oracle.
pub struct Bench<'a> {
    pub lens: &'a Prescription,
    pub film: f64,
    pub oracle: Oracle<'a>,
    pub single: Vec<Surface<f32>>,
    pub double: Vec<Surface<f64>>,
}

/// Result of tracing rays in batches.
pub struct Traced {
    /// Bits of position, direction and weight of each ray that leaves the lens.
    pub bits: Vec<Option<[u64; 7]>>,
    pub rays: Vec<Option<Exit>>,
    /// Squared length of the directions.
    pub length2: Vec<f64>,
    pub needs_f64: Vec<usize>,
    pub blocked: Vec<u64>,
}

impl<'a> Bench<'a> {
    pub fn new(lens: &'a Prescription, film: f64) -> Self {
        Self {
            lens,
            film,
            oracle: Oracle::new(lens),
            single: sequence::<f32>(lens, Side::Film(film)),
            double: sequence::<f64>(lens, Side::Film(film)),
        }
    }

    /// Returns the refractive index in front of the film.
    fn index(&self) -> f64 {
        self.lens.rear().index
    }

    /// Returns the ray in f64.
    pub fn exact_ray(&self, [p, d]: Start) -> LensRay<f64> {
        LensRay { weight: HALF, ..LensRay::new(p, unit(d).map(|v| v * self.index())) }
    }

    /// Traces a ray by the oracle.
    pub fn outcome(&self, [p, d]: Start) -> Outcome {
        self.oracle.trace(self.film, p, d)
    }

    /// Returns the largest deviation, um and urad, by errors of f32 at every surface, of 16 trials.
    pub fn rounding_noise(&self, [p, d]: Start, exact: Exit) -> (f64, f64) {
        let mut random = Random::new(99);
        let mut off = (0.0f64, 0.0f64);
        for _ in 0..16 {
            let size = f64::from(f32::EPSILON) / 2.0;
            match self.oracle.trace_with_errors(self.film, p, d, size, &mut random).end {
                Ok(exit) => {
                    off.0 = off.0.max(distance(exit.p, exact.p) * 1e3);
                    off.1 = off.1.max(distance(exit.d, exact.d) * 1e6);
                }
                Err(_) => return (f64::INFINITY, f64::INFINITY),
            }
        }
        off
    }

    /// Traces one ray by the tracer of single rays, in f64.
    pub fn trace_one(&self, ray: Start) -> Result<Exit, Blocked> {
        trace_one::<f64>(self.exact_ray(ray), &self.double).map(|ray| Exit {
            p: ray.p,
            d: unit(ray.t),
            weight: ray.weight / HALF,
        })
    }

    /// Traces rays by the batch tracer in waves. With `retrace`, rays that need f64 are traced again.
    pub fn trace_batch<R: Real>(
        &self,
        rays: &[Start],
        surfaces: &[Surface<R::Scalar>],
        retrace: bool,
    ) -> Traced {
        let mut all = Traced {
            bits: Vec::new(),
            rays: Vec::new(),
            length2: Vec::new(),
            needs_f64: Vec::new(),
            blocked: vec![0; self.lens.rows.len()],
        };
        let mut batch = Box::<LensBatch<R::Scalar>>::default();
        for (wave, chunk) in rays.chunks(WAVE_SIZE).enumerate() {
            for (i, &ray) in chunk.iter().enumerate() {
                // The aiming stage too leaves directions of unit length only up to rounding.
                let LensRay { p, t, .. } = self.exact_ray(ray);
                [batch.x[i], batch.y[i], batch.z[i]] = p.map(R::from_f64);
                [batch.tx[i], batch.ty[i], batch.tz[i]] = t.map(R::from_f64);
                batch.weight[i] = R::from_f64(HALF);
            }
            batch.resize::<R>(chunk.len());
            trace::<R>(&mut batch, surfaces, &mut all.blocked);
            all.needs_f64.extend(batch.needs_f64.iter().map(|&i| wave * WAVE_SIZE + i as usize));
            if retrace {
                retrace_in_f64::<R>(&mut batch, &self.double, &mut all.blocked, |i| {
                    self.exact_ray(chunk[i])
                });
            }
            for i in 0..chunk.len() {
                let p = [batch.x[i], batch.y[i], batch.z[i]].map(R::to_f64);
                let t = [batch.tx[i], batch.ty[i], batch.tz[i]].map(R::to_f64);
                let weight = R::to_f64(batch.weight[i]) / HALF;
                let lives = !p[0].is_nan();
                let [t0, t1, t2] = t;
                let numbers = [p[0], p[1], p[2], t0, t1, t2, weight];
                all.bits.push(lives.then(|| numbers.map(f64::to_bits)));
                all.rays.push(lives.then(|| Exit { p, d: unit(t), weight }));
                all.length2.push(dot(t, t));
            }
        }
        all
    }
}

/// Deviation of rays from the oracle.
#[derive(Clone, Copy, Debug, Default)]
pub struct Deviation {
    pub um: f64,
    pub urad: f64,
    /// Number of rays that both let through.
    pub both: usize,
    /// Number of rays that only one lets through, close to an edge that clips.
    pub at_rims: usize,
    /// Number of rays that only one lets through, away from edges.
    pub disagreed: usize,
    /// Largest difference of weights.
    pub weight: f64,
    /// Ray of the largest deviation.
    pub worst: Option<usize>,
    /// First ray of those in `disagreed`.
    pub first_disagreed: Option<usize>,
}

pub fn distance(a: V, b: V) -> f64 {
    let d = [0, 1, 2].map(|i| a[i] - b[i]);
    dot(d, d).sqrt()
}

impl Deviation {
    /// Adds a ray. Closer to an edge than `rim` mm it may end on either side.
    pub fn add(&mut self, i: usize, ours: Option<Exit>, outcome: &Outcome, rim: f64) {
        match (ours, outcome.end) {
            (Some(ours), Ok(exact)) => {
                self.both += 1;
                let um = distance(ours.p, exact.p) * 1e3;
                let urad = distance(ours.d, exact.d) * 1e6;
                let weight = (ours.weight - exact.weight).abs();
                if outcome.rim > rim {
                    self.weight = self.weight.max(weight);
                }
                if um > self.um || urad > self.urad {
                    self.worst = Some(i);
                }
                assert!(um.is_finite() && urad.is_finite(), "ray {i}: {ours:?}");
                self.um = self.um.max(um);
                self.urad = self.urad.max(urad);
            }
            (None, Err(_)) => {}
            _ if outcome.rim <= rim => self.at_rims += 1,
            _ => {
                self.disagreed += 1;
                self.first_disagreed = self.first_disagreed.or(Some(i));
            }
        }
    }
}

/// Deviations of rays through one lens, in f32, in f32 with retraced rays, and in f64.
pub struct Report {
    pub rays: usize,
    pub single: Deviation,
    pub retraced: Deviation,
    pub double: Deviation,
    /// Number of rays that f32 leaves to f64.
    pub needs_f64: usize,
    /// Number of rays that f64 and the oracle end at different rows or for different reasons, away
    /// from rims.
    pub other_ends: usize,
    /// Largest deviation of the length of a direction from 1: retraced and f64.
    pub length: [f64; 2],
    /// First ray of those in `other_ends`.
    pub first_other_end: Option<(usize, Blocked, Outcome)>,
}

/// Distance from an edge within which a ray may end on either side, mm: the promised micrometre in f32,
/// roundings in f64.
pub const RIM_TOLERANCE: [f64; 2] = [1e-3, 1e-9];

/// Returns whether the rim is the equator of the conic, where a clipped ray may count as a miss.
fn is_equator(row: &Row) -> bool {
    let bend = row.curvature() * row.diameter / 2.0;
    (1.0 - (1.0 + row.conic) * bend * bend).abs() < 1e-9
}

/// Traces rays in all precisions and compares the results with each other and with the oracle.
///
/// # Panics
/// Panics if one lane and eight differ in any bit, if a batch differs from a single ray in f64, or if a
/// ray is missing in the counts.
pub fn compare(name: &str, bench: &Bench, rays: &[Start], rims: [f64; 2]) -> Report {
    let one = bench.trace_batch::<f32>(rays, &bench.single, false);
    let eight = bench.trace_batch::<f32x8>(rays, &bench.single, false);
    assert_eq!(
        one.needs_f64, eight.needs_f64,
        "{name}: rays of one lane and of eight that need f64"
    );
    assert_eq!(one.blocked, eight.blocked, "{name}: blocked rays of one lane and of eight");
    if let Some(i) = (0..rays.len()).find(|&i| one.bits[i] != eight.bits[i]) {
        panic!(
            "{name}: one lane and eight differ for {:?}: {:?} {:?}",
            rays[i], one.rays[i], eight.rays[i]
        );
    }
    let retraced = bench.trace_batch::<f32x8>(rays, &bench.single, true);
    let double = bench.trace_batch::<f64>(rays, &bench.double, true);
    for traced in [&retraced, &double] {
        let out = traced.rays.iter().flatten().count() as u64;
        let ends = traced.blocked.iter().sum::<u64>();
        assert_eq!(out + ends, rays.len() as u64, "{name}: every ray leaves the lens or ends");
    }
    let out = one.rays.iter().flatten().count() + one.needs_f64.len();
    let ends = one.blocked.iter().sum::<u64>() as usize;
    assert_eq!(out + ends, rays.len(), "{name}: rays that leave, end and need f64");
    let mut report = Report {
        rays: rays.len(),
        single: Deviation::default(),
        retraced: Deviation::default(),
        double: Deviation::default(),
        needs_f64: one.needs_f64.len(),
        other_ends: 0,
        length: [0.0; 2],
        first_other_end: None,
    };
    let mut ends = vec![0; bench.lens.rows.len()];
    let needs_f64: std::collections::HashSet<usize> = one.needs_f64.iter().copied().collect();
    for (i, &ray) in rays.iter().enumerate() {
        for (length, traced) in report.length.iter_mut().zip([&retraced, &double]) {
            if let Some(exit) = traced.rays[i] {
                *length = length.max((traced.length2[i].sqrt() - 1.0).abs());
                assert!((0.0..=1.0).contains(&exit.weight), "{name}: weight {}", exit.weight);
            }
        }
        let outcome = bench.outcome(ray);
        if !needs_f64.contains(&i) {
            report.single.add(i, one.rays[i], &outcome, rims[0]);
        }
        report.retraced.add(i, retraced.rays[i], &outcome, rims[0]);
        report.double.add(i, double.rays[i], &outcome, rims[1]);
        let alone = bench.trace_one(ray);
        if let Err(end) = alone {
            ends[end.row] += 1;
        }
        match (alone, double.rays[i]) {
            (Ok(a), Some(b)) => {
                assert!(a.p == b.p && a.d == b.d && a.weight == b.weight, "{name}: alone {ray:?}");
            }
            (Err(_), None) => {}
            // The batch traces rays that need f64 one by one, even in f64.
            _ => panic!("{name}: alone {alone:?}, in a batch {:?}: {ray:?}", double.rays[i]),
        }
        if let (Err(ours), Err(exact)) = (alone, outcome.end)
            && ours != exact
            && outcome.rim > rims[1]
            && !(ours.row == exact.row && is_equator(&bench.lens.rows[ours.row]))
        {
            report.other_ends += 1;
            report.first_other_end = report.first_other_end.or(Some((i, ours, outcome)));
        }
    }
    assert_eq!(ends, double.blocked, "{name}: counts of rays that end, by row");
    report
}

/// Returns random rays from a film of half width `height` to a disk of radius `reach`, `ahead` mm before
/// it.
pub fn random_rays(ahead: f64, height: f64, reach: f64, count: usize, seed: u64) -> Vec<Start> {
    let mut random = Random::new(seed);
    (0..count)
        .map(|_| {
            let p = [random.between(-height, height), random.between(-height, height), 0.0];
            let (r, phi) = (random.next().sqrt() * reach, random.between(0.0, 6.3));
            start(p, [r * phi.cos() - p[0], r * phi.sin() - p[1], ahead])
        })
        .collect()
}

/// Returns rays on both sides of borders: rims, the stop, total internal reflection, tangency. Bisection
/// between two rays of one film point, of which one leaves the lens, finds a border. The rays lie on
/// either side of it, at 1e-3 to 1e-9 of the distance between the two.
pub fn rays_at_borders(
    bench: &Bench,
    ahead: f64,
    [height, reach]: [f64; 2],
    count: usize,
    seed: u64,
) -> Vec<Start> {
    let mut random = Random::new(seed);
    let mut rays = Vec::new();
    for _ in 0..10 * count {
        if rays.len() >= count {
            break;
        }
        let p = [random.between(-height, height), random.between(-height, height), 0.0];
        let p = p.map(|v| f64::from(v as f32));
        let mut aim = || {
            let (r, phi) = (random.next().sqrt() * reach, random.between(0.0, 6.3));
            [r * phi.cos(), r * phi.sin()]
        };
        let (a, b) = (aim(), aim());
        let towards =
            |s: f64| [a[0] + s * (b[0] - a[0]) - p[0], a[1] + s * (b[1] - a[1]) - p[1], ahead];
        let end = |s: f64| {
            bench.outcome([p, towards(s)]).end.map(|_| ()).map_err(|end| (end.row, end.reason))
        };
        let (here, there) = (end(0.0), end(1.0));
        if here.is_ok() == there.is_ok() {
            continue;
        }
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if end(middle).is_ok() == here.is_ok() { low = middle } else { high = middle }
        }
        for step in 0..12 {
            let away = 10f64.powf(-3.0 - 0.5 * f64::from(step));
            rays.extend([low - away, low + away].map(|s| start(p, towards(s))));
        }
    }
    rays
}
