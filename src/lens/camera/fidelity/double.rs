//! Tracing of every ray of a real lens in f64.

use crate::camera::RealLens;
use crate::camera::band::Band;
use crate::trace::kernel::LensRay;
use crate::trace::surface::Surface;
use crate::trace::{retrace_in_f64, retrace_in_f64_lossy, trace, trace_lossy};
use petzval_base::lanes::{Real, narrow, widen};
use petzval_base::rays::LensBatch;
use petzval_base::stats::LensStats;

/// Rays in f64; allocated by cameras that trace in f64.
#[derive(Clone, Debug, Default)]
pub struct F64Columns(Option<Box<LensBatch<f64>>>);

impl RealLens {
    /// Traces launched rays to the front vertex in f64, in as many lanes as `R` has, and rounds them
    /// to f32 only there. The launched rays are the same to the bit as those of f32.
    #[inline(never)]
    pub(crate) fn trace_batch_f64<R: Real<Scalar = f32>>(
        &self,
        band: usize,
        batch: &mut LensBatch<f32>,
        exact: &mut F64Columns,
        fresnel: bool,
        stats: &mut LensStats,
    ) {
        let Band { to_scene_f64: surfaces, film_index, .. } = &self.bands[band];
        let blocked = stats.blocked_mut(self.prescription.rows.len());
        stats.retraced += exact.trace::<R>(batch, surfaces, *film_index, fresnel, blocked);
    }
}

impl F64Columns {
    /// Traces a batch whose rays are in a medium of this index, in f64 and in as many lanes as `R`
    /// has. Returns the number of rays that were traced again one by one.
    #[inline(always)]
    pub(crate) fn trace<R: Real<Scalar = f32>>(
        &mut self,
        batch: &mut LensBatch<f32>,
        surfaces: &[Surface<f64>],
        index: f64,
        fresnel: bool,
        blocked: &mut [u64],
    ) -> u64 {
        let exact = self.0.get_or_insert_default();
        launch_in_f64::<R>(batch, index, exact);
        let start = |i| launched(batch, index, i);
        match fresnel {
            false => {
                trace::<R::Double>(exact, surfaces, blocked);
                retrace_in_f64::<R::Double>(exact, surfaces, blocked, start);
            }
            true => {
                trace_lossy::<R::Double>(exact, surfaces, blocked);
                retrace_in_f64_lossy::<R::Double>(exact, surfaces, blocked, start);
            }
        }
        round_to_f32::<R>(exact, batch);
        exact.needs_f64.len() as u64
    }
}

/// Copies a launched batch to f64, with directions scaled to the index in f64, as [`launched`].
#[inline(always)]
fn launch_in_f64<R: Real<Scalar = f32>>(
    from: &LensBatch<f32>,
    index: f64,
    to: &mut LensBatch<f64>,
) {
    let len = from.len;
    to.resize::<R::Double>(len);
    to.live = from.live;
    let columns = [
        (&from.x, &mut to.x),
        (&from.y, &mut to.y),
        (&from.z, &mut to.z),
        (&from.weight, &mut to.weight),
    ];
    for (from, to) in columns {
        let packets = to.packets_mut::<R::Double>(len).iter_mut();
        packets.zip(from.packets::<R>(len)).for_each(|(to, &from)| *to = widen(from));
    }
    let [x, y, z] = [&from.tx, &from.ty, &from.tz].map(|column| column.packets::<R>(len));
    let index = R::Double::splat(index);
    let (to_x, to_y) = (to.tx.packets_mut::<R::Double>(len), to.ty.packets_mut::<R::Double>(len));
    let to_z = to.tz.packets_mut::<R::Double>(len);
    for i in 0..x.len() {
        let [x, y, z] = [x[i], y[i], z[i]].map(widen);
        let scale = index / (x * x + y * y + z * z).sqrt();
        (to_x[i], to_y[i], to_z[i]) = (x * scale, y * scale, z * scale);
    }
}

/// Copies traced rays to a batch of f32.
#[inline(always)]
fn round_to_f32<R: Real<Scalar = f32>>(from: &LensBatch<f64>, to: &mut LensBatch<f32>) {
    let len = to.len;
    let columns = [
        (&from.x, &mut to.x),
        (&from.y, &mut to.y),
        (&from.z, &mut to.z),
        (&from.tx, &mut to.tx),
        (&from.ty, &mut to.ty),
        (&from.tz, &mut to.tz),
        (&from.weight, &mut to.weight),
    ];
    for (from, to) in columns {
        let packets = to.packets_mut::<R>(len).iter_mut();
        packets.zip(from.packets::<R::Double>(len)).for_each(|(to, &from)| *to = narrow(from));
    }
}

/// Returns ray `i` of a launched batch, with its direction scaled to the index in f64.
pub fn launched(batch: &LensBatch<f32>, index: f64, i: usize) -> LensRay<f64> {
    let [x, y, z] = [batch.tx[i], batch.ty[i], batch.tz[i]].map(f64::from);
    let scale = index / (x * x + y * y + z * z).sqrt();
    LensRay {
        p: [batch.x[i], batch.y[i], batch.z[i]].map(f64::from),
        t: [x * scale, y * scale, z * scale],
        weight: f64::from(batch.weight[i]),
    }
}
