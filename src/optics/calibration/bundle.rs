//! The bundle of rays of a film point: its centroid in the scene, and its light.

use glam::DVec3;

use super::pixel_grid::SightLine;
use petzval_base::rays::{SampleBatch, WAVE_SIZE};
use petzval_base::sampler::{Dimension, sample_2d};
use petzval_base::stats::LensStats;
use petzval_lens::{LensColumns, RealLens};

/// Fewest rays that make a bundle.
const FEWEST: usize = 16;
/// Least cosine between the rays of a bundle and their mean.
const NARROW: f64 = 0.1;

/// A ray of a bundle.
#[derive(Clone, Copy, Debug)]
pub(super) struct BundleRay {
    pub ray: SightLine,
    /// Share of the light.
    pub weight: f64,
}

/// Traces the rays of film points through the pupil, as a render samples them, in f64.
pub(super) struct BundleTracer<'a> {
    lens: &'a RealLens,
    samples: SampleBatch,
    columns: LensColumns,
    stats: LensStats,
    rays: usize,
}

impl<'a> BundleTracer<'a> {
    /// Makes a tracer of this many rays for each film point. The lens must trace in f64.
    pub fn new(lens: &'a RealLens, rays: usize) -> Self {
        Self {
            lens,
            samples: SampleBatch::default(),
            columns: LensColumns::default(),
            stats: LensStats::default(),
            rays,
        }
    }

    /// Returns the rays of a film point (mm, the film's frame) in a band that leave the lens. Their
    /// weights are those of exposure over the number of all rays: their sum is the irradiance of the
    /// film under a scene of radiance 1.
    pub fn rays(&mut self, film: [f64; 2], band: usize) -> Vec<BundleRay> {
        let Self { lens, samples, columns, stats, rays } = self;
        let depth = lens.prescription.film_position(lens.film_distance);
        let mut bundle = Vec::new();
        for first in (0..*rays).step_by(WAVE_SIZE) {
            samples.len = WAVE_SIZE.min(*rays - first);
            samples.band = band;
            for i in 0..samples.len.next_multiple_of(8).min(WAVE_SIZE) {
                let numbers = sample_2d(0, (first + i) as u32, Dimension::Pupil);
                [samples.pupil[0][i], samples.pupil[1][i]] = numbers;
                (samples.film[0][i], samples.film[1][i]) = (film[0] as f32, film[1] as f32);
            }
            lens.trace_samples::<f32>(samples, columns, false, stats);
            let batch = &columns.batch;
            for i in (0..samples.len).filter(|&i| !batch.x[i].is_nan()) {
                let [x, y, z] = [batch.x[i], batch.y[i], batch.z[i]].map(f64::from);
                let [tx, ty, tz] = [batch.tx[i], batch.ty[i], batch.tz[i]].map(f64::from);
                bundle.push(BundleRay {
                    ray: to_camera([x, y, z], [tx, ty, tz], depth),
                    weight: f64::from(batch.weight[i]) / *rays as f64,
                });
            }
        }
        bundle
    }
}

/// Returns a ray that leaves the lens, relative to the front vertex with y up and z towards the
/// scene, in the frame of the camera; `depth` is that of the front vertex before the film (mm).
pub(super) fn to_camera([x, y, z]: [f64; 3], [tx, ty, tz]: [f64; 3], depth: f64) -> SightLine {
    SightLine {
        point: DVec3::new(x, -y, z + depth),
        direction: DVec3::new(tx, -ty, tz).normalize(),
    }
}

/// Returns the centroid ray of a bundle, and the irradiance.
///
/// The rays are taken as lines over their mean direction. The centroid is the line through the means
/// of their intersections, weighted by light, with any plane across that direction. By the reversal
/// of the paths, the light of a point of the scene on that line has its centre of mass at the film
/// point, to first order in the aberrations.
pub(super) fn centroid(bundle: &[BundleRay]) -> Option<(SightLine, f64)> {
    if bundle.len() < FEWEST {
        return None;
    }
    let light: f64 = bundle.iter().map(|ray| ray.weight).sum();
    let mean = |of: &dyn Fn(&SightLine) -> DVec3| {
        bundle.iter().map(|BundleRay { ray, weight }| *weight * of(ray)).sum::<DVec3>() / light
    };
    let axis = mean(&|ray| ray.direction).normalize();
    let middle = mean(&|ray| ray.point);
    let (mut point, mut slope, mut sum) = (DVec3::ZERO, DVec3::ZERO, 0.0);
    for BundleRay { ray, weight } in bundle {
        let along = ray.direction.dot(axis);
        if along > NARROW {
            let slanted = ray.direction / along;
            point += *weight * (ray.point - (ray.point - middle).dot(axis) * slanted);
            slope += *weight * slanted;
            sum += weight;
        }
    }
    let ray = SightLine { point: point / sum, direction: slope.normalize() };
    let finite = ray.point.is_finite() && ray.direction.is_finite() && light > 0.0;
    finite.then_some((ray, light))
}
