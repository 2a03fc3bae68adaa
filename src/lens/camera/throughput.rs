//! Throughput: the light that the surfaces and the glass of a lens transmit, by film point and over the
//! film.

use crate::camera::{LensColumns, RealLens};
use crate::prescription::Row;
use petzval_base::lanes::f32x8;
use petzval_base::rays::{SampleBatch, WAVE_SIZE};
use petzval_base::sampler::{Dimension, sample_2d};
use petzval_base::stats::LensStats;
use petzval_spectrum::LightBand;

/// Sample points of the film.
const POINTS: u32 = 32;
/// Golden angle, which distributes them evenly.
const GOLDEN: f64 = 2.399_963_229_728_653;

/// Transmittance of the surfaces and the glass of a lens, without the effects of rims and stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Throughput {
    /// At the centre of the film, as a mean over the pupil. The f-number over its square root is
    /// the T-stop.
    pub on_axis: f64,
    /// Mean over the film, weighted by the light.
    pub mean: f64,
    /// Root mean square of the relative deviation from the mean over the film, weighted by the
    /// light: what is left of the loss at the same exposure.
    pub unevenness: f64,
    /// Least and largest transmittance of all sample points.
    pub range: [f64; 2],
}

/// Shares of the light to the middle of the film, as means over the pupil.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxialLight {
    /// Share that surfaces and glass transmit.
    pub transmitted: f64,
    /// Share that central obstructions leave.
    pub unobstructed: f64,
}

impl AxialLight {
    /// Returns the losses of the light of one wavelength (nm) for a lens that is focused. `None` if
    /// it is dark.
    pub fn of(lens: &RealLens, nm: f64) -> Option<Self> {
        Some(Self {
            transmitted: lens.transmittance_at([0.0; 2], nm)?,
            unobstructed: lens.unobstructed_share([0.0; 2])?,
        })
    }

    /// Returns the T-number of a lens with this f-number.
    pub fn t_number(&self, f_number: f64) -> f64 {
        f_number / (self.transmitted * self.unobstructed).sqrt()
    }
}

/// Sums of ray weights without losses and with them.
#[derive(Clone, Copy, Default)]
struct WeightSums {
    all: f64,
    left: f64,
}

impl RealLens {
    /// Returns the transmittance of all surfaces and glass for a film point (mm, the film's frame), as a mean
    /// over the visible pupil: a thousand rays, the same ones with losses and without. It does not
    /// matter whether losses are on. `None` if the film point is dark.
    pub fn transmittance(&self, film: [f64; 2]) -> Option<f64> {
        FilmPointTracer::new(self).light(film).share()
    }

    /// Returns [`Self::transmittance`] for light of one wavelength (nm).
    pub fn transmittance_at(&self, film: [f64; 2], wavelength: f64) -> Option<f64> {
        let mut lens = self.clone();
        lens.disperse(&[LightBand { wavelength, response: [1.0; 3] }]);
        lens.transmittance(film)
    }

    /// Returns the share of the light of a film point (mm, the film's frame) that the shape of the
    /// stop and the obstructions of the lens leave, as a mean over the pupil of a round stop without
    /// obstructions; 1 for a lens that has both. `None` if the film point is dark.
    pub fn unobstructed_share(&self, film: [f64; 2]) -> Option<f64> {
        if self.prescription.rows.iter().all(|row| !obstructs(row)) {
            return Some(1.0);
        }
        let mut open = self.prescription.clone();
        for row in &mut open.rows {
            match row.stop {
                true => row.open_all(),
                false => {
                    row.obstruction = 0.0;
                    row.apertures.retain(|aperture| !aperture.obscures);
                }
            }
        }
        let open = Self::with_film(
            open,
            &self.film,
            self.pupil_sampling,
            self.units_per_mm,
            self.front_depth,
        );
        let [all, left] = [&open, self].map(|lens| FilmPointTracer::new(lens).light(film).all);
        (all > 0.0).then(|| left / all)
    }

    /// Returns the transmittance over a film of this radius (mm), from 33 points: the error of
    /// leaving out losses, and its variation. Takes some 2 ms for ten surfaces. `None` if all of
    /// the film is dark.
    pub fn throughput(&self, radius: f64) -> Option<Throughput> {
        let mut probe = FilmPointTracer::new(self);
        let mut sum = WeightSums::default();
        let mut range = [f64::INFINITY, 0.0f64];
        let mut points = Vec::new();
        for i in 0..POINTS {
            let r = radius * ((f64::from(i) + 0.5) / f64::from(POINTS)).sqrt();
            let (sin, cos) = (GOLDEN * f64::from(i)).sin_cos();
            let light = probe.light([r * cos, r * sin]);
            if let Some(share) = light.share() {
                (sum.all, sum.left) = (sum.all + light.all, sum.left + light.left);
                range = [range[0].min(share), range[1].max(share)];
                points.push((light.all, share));
            }
        }
        let mean = sum.share()?;
        let axis = probe.light([0.0; 2]).share().unwrap_or(mean);
        let squares = points.iter().map(|(all, share)| all * (share / mean - 1.0).powi(2));
        let unevenness = (squares.sum::<f64>() / sum.all).sqrt();
        let range = [range[0].min(axis), range[1].max(axis)];
        Some(Throughput { on_axis: axis, mean, unevenness, range })
    }
}

/// Returns whether a row is a stop that is not round, or a part of it is opaque.
fn obstructs(row: &Row) -> bool {
    let obscured = row.obstruction != 0.0 || row.apertures.iter().any(|part| part.obscures);
    obscured || row.stop && !row.is_unobstructed()
}

impl WeightSums {
    fn share(self) -> Option<f64> {
        (self.all > 0.0).then(|| self.left / self.all)
    }
}

/// Traces waves of rays from one film point.
struct FilmPointTracer<'a> {
    lens: &'a RealLens,
    samples: SampleBatch,
    columns: LensColumns,
    stats: LensStats,
}

impl<'a> FilmPointTracer<'a> {
    fn new(lens: &'a RealLens) -> Self {
        let mut samples = SampleBatch { len: WAVE_SIZE, ..SampleBatch::default() };
        for i in 0..WAVE_SIZE {
            let point = sample_2d(0, i as u32, Dimension::Pupil);
            [samples.pupil[0][i], samples.pupil[1][i]] = point;
        }
        let stats = LensStats::default();
        Self { lens, samples, columns: LensColumns::default(), stats }
    }

    fn light(&mut self, film: [f64; 2]) -> WeightSums {
        for axis in 0..2 {
            self.samples.film[axis].fill(film[axis] as f32);
        }
        WeightSums { all: self.weight(false), left: self.weight(true) }
    }

    fn weight(&mut self, fresnel: bool) -> f64 {
        let Self { lens, samples, columns, stats } = self;
        lens.trace_samples::<f32x8>(samples, columns, fresnel, stats);
        columns.batch.total_weight()
    }
}
