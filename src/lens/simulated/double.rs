//! A real lens with every ray in f64.

use crate::lens::camera::RealLens;
use crate::lens::refract::LensRay;
use crate::lens::trace::{settle, settle_lossy, trace, trace_lossy};
use crate::rays::LensBatch;
use crate::stats::LensStats;

/// Rays in f64, of cameras that trace them so.
#[derive(Clone, Debug, Default)]
pub(in crate::lens) struct ExactColumns(Option<Box<LensBatch<f64>>>);

impl RealLens {
    /// From launched rays to rays in the plane of the front vertex, rounded to f32 only there.
    /// What is launched is the same, to the bit, as where f32 goes on.
    #[inline(never)]
    pub(in crate::lens) fn pass_double(
        &self,
        band: usize,
        batch: &mut LensBatch<f32>,
        ExactColumns(exact): &mut ExactColumns,
        fresnel: bool,
        stats: &mut LensStats,
    ) {
        let exact = exact.get_or_insert_default();
        let (surfaces, blocked) = (&self.bands[band].exact, &mut stats.blocked);
        let index = self.prescription.rear().index;
        let start = |i| launched(batch, index, i);
        for i in 0..batch.len {
            let ray = start(i);
            [exact.x[i], exact.y[i], exact.z[i]] = ray.p;
            [exact.tx[i], exact.ty[i], exact.tz[i]] = ray.t;
            exact.weight[i] = ray.weight;
        }
        exact.resize::<f64>(batch.len);
        exact.living = batch.living;
        match fresnel {
            false => {
                trace::<f64>(exact, surfaces, blocked);
                settle::<f64>(exact, surfaces, blocked, start);
            }
            true => {
                trace_lossy::<f64>(exact, surfaces, blocked);
                settle_lossy::<f64>(exact, surfaces, blocked, start);
            }
        }
        stats.redone += exact.doubtful.len() as u64;
        for i in 0..batch.len {
            [batch.x[i], batch.y[i], batch.z[i]] = [exact.x[i], exact.y[i], exact.z[i]].map(single);
            [batch.tx[i], batch.ty[i], batch.tz[i]] =
                [exact.tx[i], exact.ty[i], exact.tz[i]].map(single);
            batch.weight[i] = exact.weight[i] as f32;
        }
    }
}

fn single(v: f64) -> f32 {
    v as f32
}

/// The i-th ray of a launched batch, its direction of the index's length in f64.
pub(in crate::lens) fn launched(batch: &LensBatch<f32>, index: f64, i: usize) -> LensRay<f64> {
    let [x, y, z] = [batch.tx[i], batch.ty[i], batch.tz[i]].map(f64::from);
    let scale = index / (x * x + y * y + z * z).sqrt();
    LensRay {
        p: [batch.x[i], batch.y[i], batch.z[i]].map(f64::from),
        t: [x * scale, y * scale, z * scale],
        weight: f64::from(batch.weight[i]),
    }
}
