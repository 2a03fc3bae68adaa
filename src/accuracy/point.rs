//! One picture of one rung, measured.

use std::time::Duration;

use super::bias::{Bias, bias};
use super::pace::median;
use super::quarters::Parts;
use crate::image::{Exposure, Picture};
use crate::metric::{Metric, measure};
use crate::stats::{Stage, Stats};

/// One picture of one rung: what it took, and how far it is from the reference.
#[derive(Clone, Debug, Default)]
pub struct Point {
    /// The rung's place in the ladder.
    pub rung: usize,
    /// Samples a pixel.
    pub samples: u32,
    /// What rendering took on all cores together, s: four times the median of the quarters of its
    /// samples, which what else the machine did moves little.
    pub seconds: f64,
    /// What the quarters took that were rendered in turn with those of other rungs, s: all but those
    /// of the first pass.
    pub turns: [f64; 4],
    /// The same by stage, added up over cores, s, in the order of [`Stage::ALL`].
    pub stages: [f64; 8],
    /// Rays through the lens and the scene, a second.
    pub rays: f64,
    /// Mean squared error, noise and all, in the units of [`Reference`].
    pub error: f64,
    /// Mean squared error, noise and all ([`Metric::Mse`]).
    pub mse: f64,
    /// The same, relative ([`Metric::RelMse`]).
    pub relmse: f64,
    /// What an observer would notice of the pictures as the report shows them ([`Metric::Flip`]).
    pub flip: f64,
    /// What of `error` is noise of this picture: its variance.
    pub noise: f64,
    /// What of it is the model's own; of the richest model there is nothing.
    pub bias: Option<Bias>,
    /// Whether none takes less time and is as exact.
    pub on_frontier: bool,
}

impl Point {
    /// The lens's share of the time, as cores spent theirs, s.
    pub fn lens_seconds(&self) -> f64 {
        let cpu: f64 = self.stages.iter().sum();
        self.seconds * self.stages[Stage::Lens as usize] / cpu.max(1e-9)
    }
}

/// What a rung has done so far.
#[derive(Clone, Debug, Default)]
pub(super) struct Work {
    pub time: Duration,
    pub stats: Stats,
    /// By quarter, s.
    quarters: [f64; 4],
    /// The same without the first pass.
    turns: [f64; 4],
}

impl Work {
    pub fn add(&mut self, time: Duration, stats: &Stats) {
        self.time += time;
        self.stats.add(stats);
    }

    /// The same for a quarter of a rung's samples.
    pub fn add_quarter(&mut self, part: usize, time: Duration, stats: &Stats, first_pass: bool) {
        self.add(time, stats);
        self.quarters[part] += time.as_secs_f64();
        if !first_pass {
            self.turns[part] += time.as_secs_f64();
        }
    }

    fn rays(&self) -> u64 {
        let stages = [Stage::Lens, Stage::Intersect, Stage::Occlude, Stage::Ghosts];
        stages.iter().map(|&stage| self.stats.stage(stage).rays).sum()
    }
}

/// The best picture there is, and what errors are measured in.
///
/// A squared error counts by 1 / (v^2 + m^2), where v is the reference's pixel and channel and m the
/// mean over all: so it is a share of the pixel's light, but in the dark of the picture's. The
/// exposure does not matter, a lamp counts no more than its surroundings, and light where there
/// should be none counts by how much it is seen.
#[derive(Clone, Debug)]
pub struct Reference {
    /// The picture.
    pub picture: Picture,
    /// Samples a pixel.
    pub samples: u32,
    /// What rendering took, s.
    pub seconds: f64,
    /// Its own noise.
    pub noise: f64,
    /// What pictures are multiplied by to be shown.
    pub exposure: f32,
    /// What squared errors of pixels and channels count.
    pub(super) weight: Vec<[f32; 3]>,
}

impl Reference {
    pub(super) fn new(parts: &Parts<2>, seconds: f64) -> Self {
        let picture = parts.picture();
        let sum: f64 = picture.pixels.iter().flatten().map(|&v| f64::from(v)).sum();
        let mean = (sum / (3 * picture.pixels.len()).max(1) as f64) as f32;
        let floor = (mean * mean).max(f32::MIN_POSITIVE);
        let weight: Vec<[f32; 3]> =
            picture.pixels.iter().map(|p| p.map(|v| 1.0 / (v * v + floor))).collect();
        let noise = parts.noise(&weight);
        let exposure = Exposure::Auto.factor(&picture);
        Self { samples: parts.samples(), seconds, noise, exposure, weight, picture }
    }

    /// Mean squared error of a picture.
    fn error(&self, picture: &Picture) -> f64 {
        let pixels = picture.pixels.iter().zip(&self.picture.pixels).zip(&self.weight);
        let one = |((a, b), weight): ((&[f32; 3], &[f32; 3]), &[f32; 3])| {
            let part = |c: usize| f64::from(weight[c]) * f64::from(a[c] - b[c]).powi(2);
            (0..3).map(part).sum::<f64>()
        };
        pixels.map(one).sum::<f64>() / (3 * self.weight.len()).max(1) as f64
    }

    /// A picture as the report shows it, 0 to 1.
    pub(super) fn shown(&self, picture: &Picture) -> Picture {
        let shown = |p: &[f32; 3]| p.map(|v| (v * self.exposure).clamp(0.0, 1.0));
        Picture { size: picture.size, pixels: picture.pixels.iter().map(shown).collect() }
    }

    /// Measures a picture of a rung against this one, and its model against the richest, of whose
    /// picture these are the parts with the same seeds.
    pub(super) fn point(
        &self,
        rung: usize,
        parts: &Parts<4>,
        richest: Option<&Parts<4>>,
        work: &Work,
    ) -> Point {
        let picture = parts.picture();
        let of = |metric| measure(metric, &picture, &self.picture, true).0;
        let [shown, reference] = [&picture, &self.picture].map(|picture| self.shown(picture));
        let seconds = 4.0 * median(work.quarters);
        Point {
            rung,
            samples: parts.samples(),
            seconds,
            turns: work.turns,
            stages: work.stats.stages.map(|stage| stage.time.as_secs_f64()),
            rays: work.rays() as f64 / seconds.max(1e-9),
            error: self.error(&picture),
            mse: of(Metric::Mse),
            relmse: of(Metric::RelMse),
            flip: measure(Metric::Flip, &shown, &reference, false).0,
            noise: parts.noise(&self.weight),
            bias: richest
                .map(|other| bias(parts.means.each_ref(), other.means.each_ref(), &self.weight)),
            on_frontier: false,
        }
    }
}
