//! Tracing of every ray of a real lens in f64.

use crate::lens::camera::RealLens;
use crate::lens::trace::kernel::LensRay;
use crate::lens::trace::{retrace_in_f64, retrace_in_f64_lossy, trace, trace_lossy};
use crate::rays::LensBatch;
use crate::stats::LensStats;

/// Rays in f64; allocated by cameras that trace in f64.
#[derive(Clone, Debug, Default)]
pub(crate) struct F64Columns(Option<Box<LensBatch<f64>>>);

impl RealLens {
    /// Traces launched rays to the front vertex in f64 and rounds them to f32 only there. The
    /// launched rays are the same to the bit as those of f32.
    #[inline(never)]
    pub(crate) fn trace_batch_f64(
        &self,
        band: usize,
        batch: &mut LensBatch<f32>,
        F64Columns(exact): &mut F64Columns,
        fresnel: bool,
        stats: &mut LensStats,
    ) {
        let exact = exact.get_or_insert_default();
        let surfaces = &self.bands[band].to_scene_f64;
        let blocked = stats.blocked_mut(self.prescription.rows.len());
        let index = self.prescription.rear().index;
        let start = |i| launched(batch, index, i);
        for i in 0..batch.len {
            let ray = start(i);
            [exact.x[i], exact.y[i], exact.z[i]] = ray.p;
            [exact.tx[i], exact.ty[i], exact.tz[i]] = ray.t;
            exact.weight[i] = ray.weight;
        }
        exact.resize::<f64>(batch.len);
        exact.live = batch.live;
        match fresnel {
            false => {
                trace::<f64>(exact, surfaces, blocked);
                retrace_in_f64::<f64>(exact, surfaces, blocked, start);
            }
            true => {
                trace_lossy::<f64>(exact, surfaces, blocked);
                retrace_in_f64_lossy::<f64>(exact, surfaces, blocked, start);
            }
        }
        stats.retraced += exact.needs_f64.len() as u64;
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

/// Returns ray `i` of a launched batch, with its direction scaled to the index in f64.
pub(crate) fn launched(batch: &LensBatch<f32>, index: f64, i: usize) -> LensRay<f64> {
    let [x, y, z] = [batch.tx[i], batch.ty[i], batch.tz[i]].map(f64::from);
    let scale = index / (x * x + y * y + z * z).sqrt();
    LensRay {
        p: [batch.x[i], batch.y[i], batch.z[i]].map(f64::from),
        t: [x * scale, y * scale, z * scale],
        weight: f64::from(batch.weight[i]),
    }
}
