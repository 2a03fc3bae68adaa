//! The same rays through the program, in every precision, and through the oracle.

use petzval::lanes::{Real, f32x8};
use petzval::lens::{
    Blocked, From, LensRay, Prescription, Row, Surface, sequence, settle, trace, trace_one,
};
use petzval::rays::{LensBatch, WAVE};

use super::Random;
use super::oracle::{Exit, Fate, Oracle, V, dot, unit};

/// A point of the film's frame and a direction, in numbers that f32 holds exactly.
pub type Start = [V; 2];

/// The weight that rays start with; what openings multiply.
const HALF: f64 = 0.5;

/// What f32 holds of a ray whose direction has any length.
pub fn start(p: V, towards: V) -> Start {
    [p, unit(towards)].map(|v| v.map(|v| f64::from(v as f32)))
}

/// A lens of rows made by hand. The stop is the row that says so, or else the first.
pub fn made(mut rows: Vec<Row>) -> Prescription {
    if !rows.iter().any(|row| row.stop) {
        rows[0].stop = true;
    }
    Prescription { name: "made".into(), rows, ..Prescription::default() }
}

/// A lens, a film behind it, and all that the program and the oracle need to trace it.
pub struct Bench<'a> {
    pub lens: &'a Prescription,
    pub film: f64,
    pub oracle: Oracle<'a>,
    pub single: Vec<Surface<f32>>,
    pub double: Vec<Surface<f64>>,
}

/// What a batch made of rays.
pub struct Traced {
    /// Bits of position, direction and weight where there is a ray.
    pub bits: Vec<Option<[u64; 7]>>,
    pub rays: Vec<Option<Exit>>,
    /// Squares of the lengths of their directions.
    pub length2: Vec<f64>,
    pub doubtful: Vec<usize>,
    pub blocked: Vec<u64>,
}

impl<'a> Bench<'a> {
    pub fn new(lens: &'a Prescription, film: f64) -> Self {
        Self {
            lens,
            film,
            oracle: Oracle::new(lens),
            single: sequence::<f32>(lens, From::Film(film)),
            double: sequence::<f64>(lens, From::Film(film)),
        }
    }

    /// The index of the medium that the film stands in.
    fn index(&self) -> f64 {
        self.lens.rear().index
    }

    /// A ray as f64 traces it.
    pub fn exact(&self, [p, d]: Start) -> LensRay<f64> {
        LensRay { weight: HALF, ..LensRay::new(p, unit(d).map(|v| v * self.index())) }
    }

    pub fn fate(&self, [p, d]: Start) -> Fate {
        self.oracle.follow(self.film, p, d)
    }

    /// How far, um and urad, roundings to f32 after every surface can take a ray.
    pub fn noise(&self, [p, d]: Start, exact: Exit) -> (f64, f64) {
        let mut random = Random::new(99);
        let mut off = (0.0f64, 0.0f64);
        for _ in 0..16 {
            let size = f64::from(f32::EPSILON) / 2.0;
            match self.oracle.rounded(self.film, p, d, size, &mut random).end {
                Ok(exit) => {
                    off.0 = off.0.max(distance(exit.p, exact.p) * 1e3);
                    off.1 = off.1.max(distance(exit.d, exact.d) * 1e6);
                }
                Err(_) => return (f64::INFINITY, f64::INFINITY),
            }
        }
        off
    }

    pub fn alone(&self, ray: Start) -> Result<Exit, Blocked> {
        trace_one::<f64>(self.exact(ray), &self.double).map(|ray| Exit {
            p: ray.p,
            d: unit(ray.t),
            weight: ray.weight / HALF,
        })
    }

    /// Through the batch tracer, in whole waves; the doubtful ones again in f64 where asked.
    pub fn batch<R: Real>(
        &self,
        rays: &[Start],
        surfaces: &[Surface<R::Scalar>],
        settled: bool,
    ) -> Traced {
        let mut all = Traced {
            bits: Vec::new(),
            rays: Vec::new(),
            length2: Vec::new(),
            doubtful: Vec::new(),
            blocked: vec![0; self.lens.rows.len()],
        };
        let mut batch = Box::<LensBatch<R::Scalar>>::default();
        for (wave, chunk) in rays.chunks(WAVE).enumerate() {
            for (i, &ray) in chunk.iter().enumerate() {
                // In f32 a direction as the aiming stage leaves it, to rounding of unit length.
                let LensRay { p, t, .. } = self.exact(ray);
                [batch.x[i], batch.y[i], batch.z[i]] = p.map(R::scalar);
                [batch.tx[i], batch.ty[i], batch.tz[i]] = t.map(R::scalar);
                batch.weight[i] = R::scalar(HALF);
            }
            batch.resize::<R>(chunk.len());
            trace::<R>(&mut batch, surfaces, &mut all.blocked);
            all.doubtful.extend(batch.doubtful.iter().map(|&i| wave * WAVE + i as usize));
            if settled {
                settle::<R>(&mut batch, &self.double, &mut all.blocked, |i| self.exact(chunk[i]));
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

/// How far rays are from the oracle's.
#[derive(Clone, Copy, Debug, Default)]
pub struct Off {
    pub um: f64,
    pub urad: f64,
    /// Rays that come out of both.
    pub both: usize,
    /// Rays that come out of one only, next to the edge of something that clips or not.
    pub at_rims: usize,
    pub apart: usize,
    /// The largest difference of weights.
    pub weight: f64,
    /// The ray that is farthest off, and the first that only one lets through.
    pub worst: Option<usize>,
    pub odd: Option<usize>,
}

pub fn distance(a: V, b: V) -> f64 {
    let d = [0, 1, 2].map(|i| a[i] - b[i]);
    dot(d, d).sqrt()
}

impl Off {
    /// `rim` is how near to an edge, mm, a ray may end on either side of it.
    pub fn add(&mut self, i: usize, ours: Option<Exit>, fate: &Fate, rim: f64) {
        match (ours, fate.end) {
            (Some(ours), Ok(exact)) => {
                self.both += 1;
                let um = distance(ours.p, exact.p) * 1e3;
                let urad = distance(ours.d, exact.d) * 1e6;
                let weight = (ours.weight - exact.weight).abs();
                if fate.rim > rim {
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
            _ if fate.rim <= rim => self.at_rims += 1,
            _ => {
                self.apart += 1;
                self.odd = self.odd.or(Some(i));
            }
        }
    }
}

/// How rays go through a lens in all precisions, where one lane and eight have been found equal.
pub struct Report {
    pub rays: usize,
    pub single: Off,
    pub settled: Off,
    pub double: Off,
    pub doubtful: usize,
    /// Rays of which f64 and the oracle say that they end, at another place or for another
    /// reason, away from rims.
    pub reasons: usize,
    /// The farthest that the length of a direction is from 1: settled and f64.
    pub length: [f64; 2],
    pub reason: Option<(usize, Blocked, Fate)>,
}

/// How near to an edge a ray may end on either side of it, mm: the micrometre of the promise
/// in f32; roundings in f64.
pub const RIMS: [f64; 2] = [1e-3, 1e-9];

/// Whether the rim is where the conic ends, so that a clipped ray may as well be said to miss.
fn is_equator(row: &Row) -> bool {
    let bend = row.curvature() * row.diameter / 2.0;
    (1.0 - (1.0 + row.conic) * bend * bend).abs() < 1e-9
}

/// Traces rays in all ways and compares what must be equal.
///
/// # Panics
/// Where one lane and eight differ in any bit, or a batch and a lone ray of f64, or where rays
/// are lost from the counts.
pub fn compare(name: &str, bench: &Bench, rays: &[Start], rims: [f64; 2]) -> Report {
    let one = bench.batch::<f32>(rays, &bench.single, false);
    let eight = bench.batch::<f32x8>(rays, &bench.single, false);
    assert_eq!(one.doubtful, eight.doubtful, "{name}: doubtful rays of one lane and of eight");
    assert_eq!(one.blocked, eight.blocked, "{name}: blocked rays of one lane and of eight");
    if let Some(i) = (0..rays.len()).find(|&i| one.bits[i] != eight.bits[i]) {
        panic!(
            "{name}: one lane and eight differ for {:?}: {:?} {:?}",
            rays[i], one.rays[i], eight.rays[i]
        );
    }
    let settled = bench.batch::<f32x8>(rays, &bench.single, true);
    let double = bench.batch::<f64>(rays, &bench.double, true);
    for traced in [&settled, &double] {
        let out = traced.rays.iter().flatten().count() as u64;
        let ends = traced.blocked.iter().sum::<u64>();
        assert_eq!(out + ends, rays.len() as u64, "{name}: every ray comes out or ends somewhere");
    }
    let out = one.rays.iter().flatten().count() + one.doubtful.len();
    let ends = one.blocked.iter().sum::<u64>() as usize;
    assert_eq!(out + ends, rays.len(), "{name}: out, ended and doubtful");
    let mut report = Report {
        rays: rays.len(),
        single: Off::default(),
        settled: Off::default(),
        double: Off::default(),
        doubtful: one.doubtful.len(),
        reasons: 0,
        length: [0.0; 2],
        reason: None,
    };
    let mut ends = vec![0; bench.lens.rows.len()];
    let doubtful: std::collections::HashSet<usize> = one.doubtful.iter().copied().collect();
    for (i, &ray) in rays.iter().enumerate() {
        for (length, traced) in report.length.iter_mut().zip([&settled, &double]) {
            if let Some(exit) = traced.rays[i] {
                *length = length.max((traced.length2[i].sqrt() - 1.0).abs());
                assert!((0.0..=1.0).contains(&exit.weight), "{name}: weight {}", exit.weight);
            }
        }
        let fate = bench.fate(ray);
        if !doubtful.contains(&i) {
            report.single.add(i, one.rays[i], &fate, rims[0]);
        }
        report.settled.add(i, settled.rays[i], &fate, rims[0]);
        report.double.add(i, double.rays[i], &fate, rims[1]);
        let alone = bench.alone(ray);
        if let Err(end) = alone {
            ends[end.row] += 1;
        }
        match (alone, double.rays[i]) {
            (Ok(a), Some(b)) => {
                assert!(a.p == b.p && a.d == b.d && a.weight == b.weight, "{name}: alone {ray:?}");
            }
            (Err(_), None) => {}
            // Where f64 itself is in doubt, the batch asks the lone ray.
            _ => panic!("{name}: alone {alone:?}, in a batch {:?}: {ray:?}", double.rays[i]),
        }
        if let (Err(ours), Err(exact)) = (alone, fate.end)
            && ours != exact
            && fate.rim > rims[1]
            && !(ours.row == exact.row && is_equator(&bench.lens.rows[ours.row]))
        {
            report.reasons += 1;
            report.reason = report.reason.or(Some((i, ours, fate)));
        }
    }
    assert_eq!(ends, double.blocked, "{name}: the rows at which rays end");
    report
}

/// Rays from a film to a disk in a plane `ahead` of it.
pub fn spread(ahead: f64, height: f64, reach: f64, count: usize, seed: u64) -> Vec<Start> {
    let mut random = Random::new(seed);
    (0..count)
        .map(|_| {
            let p = [random.between(-height, height), random.between(-height, height), 0.0];
            let (r, phi) = (random.next().sqrt() * reach, random.between(0.0, 6.3));
            start(p, [r * phi.cos() - p[0], r * phi.sin() - p[1], ahead])
        })
        .collect()
}

/// Rays on both sides of whatever first ends them: a rim, the stop, total reflection, tangency.
/// Two rays of one film point with different fates are brought together by halving; then come
/// rays to either side of the border, from a thousandth to 1e-9 of the way between the two.
pub fn borders(
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
        let end =
            |s: f64| bench.fate([p, towards(s)]).end.map(|_| ()).map_err(|end| (end.row, end.why));
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
