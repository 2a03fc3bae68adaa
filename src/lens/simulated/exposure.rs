//! What the middle of the film gets of a uniform scene.

use crate::lanes::f32x8;
use crate::lens::camera::{LensColumns, RealLens};
use crate::rays::{SampleBatch, WAVE};
use crate::sampler::{Dimension, pair};
use crate::stats::LensStats;

/// Waves of rays whose mean it is.
const WAVES: usize = 16;

/// The mean weight of a sample where the axis meets the film, over the pupil and over the bands
/// of light: irradiance for a radiance of 1. Some 16,000 rays.
pub(super) fn on_axis(lens: &RealLens) -> f64 {
    let mut samples = SampleBatch { len: WAVE, ..SampleBatch::default() };
    for axis in 0..2 {
        samples.film[axis].fill(-lens.film_pose.decentre[axis] as f32);
    }
    let mut columns = LensColumns::default();
    let blocked = vec![0; lens.prescription.rows.len()];
    let mut stats = LensStats { blocked, ..LensStats::default() };
    let mut sum = 0.0;
    for wave in 0..WAVES {
        for i in 0..WAVE {
            let point = pair(0, (wave * WAVE + i) as u32, Dimension::Pupil);
            [samples.pupil[0][i], samples.pupil[1][i]] = point;
        }
        samples.band = wave % lens.bands.len();
        lens.traced::<f32x8>(&samples, &mut columns, lens.fresnel, &mut stats);
        sum += columns.batch.light();
    }
    sum / (WAVES * WAVE) as f64
}
