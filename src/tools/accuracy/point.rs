//! Measurement of one picture of one rung.

use std::time::Duration;

use super::bias::{Bias, bias};
use super::relative_time::median;
use super::split_picture::SplitPicture;
use crate::metric::{DynamicRange, Metric, SizeMismatch, measure};
use petzval_base::stats::{Stage, Stats};
use petzval_image::{DisplayExposure, Picture};

/// The time and errors of one picture of one rung.
#[derive(Clone, Debug, Default)]
pub struct Point {
    /// Index of the rung in the ladder.
    pub rung: usize,
    /// Samples per pixel.
    pub samples: u32,
    /// Wall-clock time of rendering on all cores (s): four times the median over the quarters of
    /// its samples, which other load on the machine hardly changes.
    pub seconds: f64,
    /// Time of each quarter without the first pass (s). Rungs rendered these in turns.
    pub turns: [f64; 4],
    /// CPU time by stage, summed over cores (s), in the order of [`Stage::ALL`].
    pub stages: [f64; Stage::ALL.len()],
    /// Rays through the lens and the scene per second.
    pub rays: f64,
    /// Mean squared error including noise, weighted as [`Reference`] says.
    pub error: f64,
    /// Mean squared error including noise ([`Metric::Mse`]).
    pub mse: f64,
    /// Relative mean squared error including noise ([`Metric::RelMse`]).
    pub relmse: f64,
    /// FLIP of the pictures as the report shows them ([`Metric::Flip`]).
    pub flip: f64,
    /// Part of `error` that is this picture's noise: its variance.
    pub noise: f64,
    /// Part of `error` that is the model's own; `None` for the richest model.
    pub bias: Option<Bias>,
    /// Whether no other point has as small an error in less time.
    pub on_frontier: bool,
}

impl Point {
    /// Returns the lens's part of `seconds`, by its share of the CPU time (s).
    pub fn lens_seconds(&self) -> f64 {
        let cpu: f64 = self.stages.iter().sum();
        self.seconds * self.stages[Stage::Lens as usize] / cpu.max(1e-9)
    }
}

/// Which pass a render belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pass {
    /// One rung after the other, with every start-up cost.
    First,
    /// All rungs in turns.
    Later,
}

/// Time and statistics of a rung's renders so far.
#[derive(Clone, Debug, Default)]
pub(super) struct RenderCost {
    pub time: Duration,
    pub stats: Stats,
    /// Time by quarter (s).
    quarters: [f64; 4],
    /// Time by quarter without the first pass (s).
    turns: [f64; 4],
}

impl RenderCost {
    pub fn add(&mut self, time: Duration, stats: &Stats) {
        self.time += time;
        self.stats.add(stats);
    }

    /// Adds the render of one quarter of a rung's samples.
    pub fn add_quarter(&mut self, part: usize, time: Duration, stats: &Stats, pass: Pass) {
        self.add(time, stats);
        self.quarters[part] += time.as_secs_f64();
        if pass == Pass::Later {
            self.turns[part] += time.as_secs_f64();
        }
    }

    fn rays(&self) -> u64 {
        let stages = [Stage::Lens, Stage::Intersect, Stage::Occlude, Stage::LightPaths];
        stages.iter().map(|&stage| self.stats.stage(stage).rays).sum()
    }
}

/// The picture that errors are measured against, and their weights.
///
/// The weight of a squared error is 1 / (v^2 + m^2), with v the reference's value at that pixel and
/// channel and m the mean over all of them. So an error counts relative to the pixel's light, and
/// in dark parts relative to the mean. The exposure cancels, a light source counts no more than its
/// surroundings, and stray light in the dark counts by how visible it is.
#[derive(Clone, Debug)]
pub struct Reference {
    /// The picture.
    pub picture: Picture,
    /// Samples per pixel.
    pub samples: u32,
    /// Time of rendering (s).
    pub seconds: f64,
    /// Weighted variance of the picture.
    pub noise: f64,
    /// Factor on pictures in the report.
    pub exposure: f32,
    /// Weight of squared errors by pixel and channel.
    pub weight: Vec<[f32; 3]>,
}

impl Reference {
    pub(super) fn new(split: &SplitPicture<2>, seconds: f64) -> Self {
        let picture = split.picture();
        let sum: f64 = picture.pixels.iter().flatten().map(|&v| f64::from(v)).sum();
        let mean = (sum / (3 * picture.pixels.len()).max(1) as f64) as f32;
        let floor = (mean * mean).max(f32::MIN_POSITIVE);
        let weight: Vec<[f32; 3]> =
            picture.pixels.iter().map(|p| p.map(|v| 1.0 / (v * v + floor))).collect();
        let noise = split.noise(&weight);
        let exposure = DisplayExposure::Auto.factor(&picture);
        Self { samples: split.samples(), seconds, noise, exposure, weight, picture }
    }

    /// Returns the weighted mean squared error of a picture.
    fn error(&self, picture: &Picture) -> f64 {
        let pixels = picture.pixels.iter().zip(&self.picture.pixels).zip(&self.weight);
        let one = |((a, b), weight): ((&[f32; 3], &[f32; 3]), &[f32; 3])| {
            let part = |c: usize| f64::from(weight[c]) * f64::from(a[c] - b[c]).powi(2);
            (0..3).map(part).sum::<f64>()
        };
        pixels.map(one).sum::<f64>() / (3 * self.weight.len()).max(1) as f64
    }

    /// Returns a picture as the report shows it, clipped to 0..1.
    pub fn shown(&self, picture: &Picture) -> Picture {
        let shown = |p: &[f32; 3]| p.map(|v| (v * self.exposure).clamp(0.0, 1.0));
        Picture { size: picture.size, pixels: picture.pixels.iter().map(shown).collect() }
    }

    /// Measures a rung's picture against this one, and its model against `richest`: the richest
    /// rung's picture with as many samples and the same seeds.
    pub(super) fn point(
        &self,
        rung: usize,
        split: &SplitPicture<4>,
        richest: Option<&SplitPicture<4>>,
        cost: &RenderCost,
    ) -> Result<Point, SizeMismatch> {
        let picture = split.picture();
        let hdr = |metric| {
            measure(metric, &picture, &self.picture, DynamicRange::High).map(|found| found.value)
        };
        let [shown, reference] = [&picture, &self.picture].map(|picture| self.shown(picture));
        let seconds = 4.0 * median(cost.quarters);
        Ok(Point {
            rung,
            samples: split.samples(),
            seconds,
            turns: cost.turns,
            stages: cost.stats.stages.map(|stage| stage.time.as_secs_f64()),
            rays: cost.rays() as f64 / seconds.max(1e-9),
            error: self.error(&picture),
            mse: hdr(Metric::Mse)?,
            relmse: hdr(Metric::RelMse)?,
            flip: measure(Metric::Flip, &shown, &reference, DynamicRange::Low)?.value,
            noise: split.noise(&self.weight),
            bias: richest
                .map(|other| bias(split.means.each_ref(), other.means.each_ref(), &self.weight)),
            on_frontier: false,
        })
    }
}
