//! Tracing of every ray of a real lens in f64.

use crate::lanes::{Real, narrow, widen};
use crate::lens::camera::RealLens;
use crate::lens::camera::band::Band;
use crate::lens::trace::kernel::LensRay;
use crate::lens::trace::surface::Surface;
use crate::lens::trace::{retrace_in_f64, retrace_in_f64_lossy, trace, trace_lossy};
use crate::rays::LensBatch;
use crate::stats::LensStats;

/// Rays in f64; allocated by cameras that trace in f64.
#[derive(Clone, Debug, Default)]
pub(crate) struct F64Columns(Option<Box<LensBatch<f64>>>);

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
pub(crate) fn launched(batch: &LensBatch<f32>, index: f64, i: usize) -> LensRay<f64> {
    let [x, y, z] = [batch.tx[i], batch.ty[i], batch.tz[i]].map(f64::from);
    let scale = index / (x * x + y * y + z * z).sqrt();
    LensRay {
        p: [batch.x[i], batch.y[i], batch.z[i]].map(f64::from),
        t: [x * scale, y * scale, z * scale],
        weight: f64::from(batch.weight[i]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::f32x8;
    use crate::lens::{Coating, LensColumns, PupilSampling};
    use crate::rays::{SampleBatch, WAVE_SIZE};
    use crate::sampler::{Dimension, sample_2d};
    use crate::spectrum::LightBand;

    #[test]
    fn eight_lanes_of_f64_trace_the_rays_of_one() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/lenses/fisheye.10mm.dat");
        let mut lens = crate::lens::read(path.as_ref()).expect("a lens");
        lens.coat(Coating::Mgf2);
        let lens = RealLens::new(lens, 23.192, 21.6, PupilSampling::Pupil, 1e-3, 0.0);
        // A wave that does not fill its last packet.
        let mut samples = SampleBatch { len: WAVE_SIZE - 5, ..SampleBatch::default() };
        for i in 0..samples.len {
            for (axis, v) in sample_2d(0, i as u32, Dimension::Film).into_iter().enumerate() {
                samples.film[axis][i] = 30.0 * (v - 0.5);
            }
            let pupil = sample_2d(0, i as u32, Dimension::Pupil);
            [samples.pupil[0][i], samples.pupil[1][i]] = pupil;
        }
        for fresnel in [false, true] {
            let one = traced::<f32>(&lens, &samples, fresnel);
            let eight = traced::<f32x8>(&lens, &samples, fresnel);
            assert!(one.len() > 500, "{} rays", one.len());
            assert_eq!(one, eight, "bit for bit");
        }
    }

    /// A film in glass: rays of every band start with the index of the glass at their wavelength, in f64
    /// as in f32.
    #[test]
    fn the_bands_of_a_film_in_glass_are_those_of_f32() {
        let text = "[[surface]]\nstop = true\ndiameter = 12\nthickness = 5
            [[surface]]\nradius = 60\nthickness = 6\ndiameter = 24\nglass = \"SF5\"
            [[surface]]\nradius = -120\nthickness = 40\ndiameter = 24
            [[surface]]\ndiameter = 24\nglass = \"SF5\"\n";
        let lens = crate::lens::parse_toml("glass.toml".as_ref(), text).expect("a lens");
        let mut lens = RealLens::new(lens, 60.0, 10.0, PupilSampling::Pupil, 1e-3, 0.0);
        let bands = [420.0, 680.0].map(|wavelength| LightBand { wavelength, response: [1.0; 3] });
        lens.disperse(&bands);
        for band in 0..bands.len() {
            let mut samples = SampleBatch { len: WAVE_SIZE, band, ..SampleBatch::default() };
            for i in 0..samples.len {
                samples.film[0][i] = 8.0;
                let pupil = sample_2d(0, i as u32, Dimension::Pupil);
                [samples.pupil[0][i], samples.pupil[1][i]] = pupil;
            }
            let (mut columns, mut stats) = (LensColumns::default(), LensStats::default());
            lens.trace_samples::<f32x8>(&samples, &mut columns, false, &mut stats);
            let single = columns.batch.clone();
            lens.launch::<f32x8>(&samples, &mut columns, &mut stats);
            let LensColumns { batch, exact, .. } = &mut columns;
            lens.trace_batch_f64::<f32x8>(band, batch, exact, false, &mut stats);
            let living: Vec<usize> = (0..batch.len).filter(|&i| !batch.x[i].is_nan()).collect();
            assert!(living.len() > 500, "{} rays", living.len());
            for i in living {
                let off =
                    (batch.tx[i] - single.tx[i]).abs().max((batch.ty[i] - single.ty[i]).abs());
                assert!(off < 1e-5, "band {band}, ray {i}: {off}");
            }
        }
    }

    /// Returns the bits of the rays that leave the lens.
    fn traced<R: Real<Scalar = f32>>(
        lens: &RealLens,
        samples: &SampleBatch,
        fresnel: bool,
    ) -> Vec<[u32; 7]> {
        let (mut columns, mut stats) = (LensColumns::default(), LensStats::default());
        lens.launch::<R>(samples, &mut columns, &mut stats);
        let LensColumns { batch, exact, .. } = &mut columns;
        lens.trace_batch_f64::<R>(0, batch, exact, fresnel, &mut stats);
        let LensBatch { x, y, z, tx, ty, tz, weight, .. } = &*batch;
        let all = [x, y, z, tx, ty, tz, weight];
        let living = (0..batch.len).filter(|&i| !x[i].is_nan());
        living.map(|i| all.map(|column| column[i].to_bits())).collect()
    }
}
