//! How much light the surfaces of a lens let through: by film point, and over the film.

use super::camera::{LensColumns, RealLens};
use crate::lanes::f32x8;
use crate::rays::{SampleBatch, WAVE};
use crate::sampler::{Dimension, pair};
use crate::stats::LensStats;

/// Film points that stand for a film.
const POINTS: u32 = 32;
/// The angle between one of them and the next: the golden one spreads them evenly.
const GOLDEN: f64 = 2.399_963_229_728_653;

/// Shares of the light that the surfaces of a lens let through, rims and stop aside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Throughput {
    /// In the middle of the film, as a mean over the pupil. An f-number over its root is a T-stop.
    pub axis: f64,
    /// Over the film, each point by the light that it gets.
    pub mean: f64,
    /// Of the film points that were looked at, the darkest and the brightest by this share.
    pub range: [f64; 2],
}

/// Sums of ray weights without losses and with.
#[derive(Clone, Copy, Default)]
struct Light {
    all: f64,
    left: f64,
}

impl RealLens {
    /// The share of the light of a film point (mm, the film's frame) that the coatings leave, as
    /// a mean over the pupil it sees: a thousand rays, the same ones with losses and without.
    /// Whether losses are on does not matter. None where the film point is dark.
    pub fn transmittance(&self, film: [f64; 2]) -> Option<f64> {
        Probe::new(self).light(film).share()
    }

    /// The same over a film of this radius, mm, from 33 points: what it costs to leave losses
    /// out, and how that varies. Some 2 ms for ten surfaces. None where all of the film is dark.
    pub fn throughput(&self, radius: f64) -> Option<Throughput> {
        let mut probe = Probe::new(self);
        let mut sum = Light::default();
        let mut range = [f64::INFINITY, 0.0f64];
        for i in 0..POINTS {
            let r = radius * ((f64::from(i) + 0.5) / f64::from(POINTS)).sqrt();
            let (sin, cos) = (GOLDEN * f64::from(i)).sin_cos();
            let light = probe.light([r * cos, r * sin]);
            if let Some(share) = light.share() {
                (sum.all, sum.left) = (sum.all + light.all, sum.left + light.left);
                range = [range[0].min(share), range[1].max(share)];
            }
        }
        let mean = sum.share()?;
        let axis = probe.light([0.0; 2]).share().unwrap_or(mean);
        Some(Throughput { axis, mean, range: [range[0].min(axis), range[1].max(axis)] })
    }
}

impl Light {
    fn share(self) -> Option<f64> {
        (self.all > 0.0).then(|| self.left / self.all)
    }
}

/// Waves of rays from one film point.
struct Probe<'a> {
    lens: &'a RealLens,
    samples: SampleBatch,
    columns: LensColumns,
    stats: LensStats,
}

impl<'a> Probe<'a> {
    fn new(lens: &'a RealLens) -> Self {
        let mut samples = SampleBatch { len: WAVE, ..SampleBatch::default() };
        for i in 0..WAVE {
            let point = pair(0, i as u32, Dimension::Pupil);
            [samples.pupil[0][i], samples.pupil[1][i]] = point;
        }
        let blocked = vec![0; lens.prescription.rows.len()];
        let stats = LensStats { blocked, ..LensStats::default() };
        Self { lens, samples, columns: LensColumns::default(), stats }
    }

    fn light(&mut self, film: [f64; 2]) -> Light {
        for axis in 0..2 {
            self.samples.film[axis].fill(film[axis] as f32);
        }
        Light { all: self.weight(false), left: self.weight(true) }
    }

    fn weight(&mut self, fresnel: bool) -> f64 {
        let Self { lens, samples, columns, stats } = self;
        lens.traced::<f32x8>(samples, columns, fresnel, stats);
        columns.batch.light()
    }
}
