//! Reprojection: the film points from which the rays of a wave would start in another band.
//!
//! A world ray that the lens makes of a film point in one band corresponds in another band to a
//! different film point: the one to which the lens takes light that arrives along that ray. Ray
//! paths are reversible, so that point is found by tracing from the scene.

use glam::{DAffine3, DVec3};

use super::band::Band;
use super::{Camera, LensColumns, LensModel, RealLens};
use crate::trace::frame_transform::{FrameTransform, FrameTransformKernel};
use crate::trace::kernel::{LensRay, SurfaceKernel};
use crate::trace::{retrace_in_f64, retrace_in_f64_lossy, trace, trace_lossy};
use petzval_base::lanes::Real;
use petzval_base::rays::{Column, LensBatch, RayBatch, ReprojectionBatch};

/// Working columns of reprojected rays.
#[derive(Clone, Debug, Default)]
pub(crate) struct ReprojectionColumns {
    batch: LensBatch<f32>,
    /// A sink: blocked rays are counted only on the way from the film.
    blocked: Vec<u64>,
}

impl LensColumns {
    /// Returns the weights of the last wave's rays, without the camera's imaging ratio and the
    /// band's response.
    pub fn exposure(&self) -> &Column<f32> {
        &self.batch.weight
    }

    /// Sets the density of the rays of the last wave: by etendue and area of the film, divided by the
    /// transmittance of the lens.
    pub fn write_densities(&self, rays: &mut RayBatch) {
        for i in 0..rays.len {
            rays.pdf[i] = 1.0 / self.batch.weight[rays.slot[i] as usize];
        }
    }

    /// Writes the transmittance of the lens for each of the first `rays` rays of the last wave.
    /// Only valid with several bands.
    pub fn passed(&self, rays: usize, share: &mut Column<f32>) {
        for i in 0..rays {
            share[i] = self.batch.weight[i] / self.launched[i];
        }
    }
}

impl Camera {
    /// Reprojects the rays that [`Camera::generate_rays`] last made of a wave to the film, in
    /// another band: a stage.
    pub fn reproject<R: Real<Scalar = f32>>(
        &self,
        band: usize,
        columns: &mut LensColumns,
        landing: &mut ReprojectionBatch,
    ) {
        let LensModel::Real(lens) = &self.model else { return };
        let band = &lens.bands[band];
        let LensColumns { batch, landing: back, exact, .. } = columns;
        back.blocked.resize(lens.prescription.rows.len(), 0);
        back.turn_around::<R>(batch);
        let fresnel = lens.fresnel;
        match lens.trace_in_f64 {
            // In air a direction has length 1.
            true => {
                let ReprojectionColumns { batch, blocked } = back;
                exact.trace::<R>(batch, &band.to_film_f64, 1.0, fresnel, blocked);
            }
            false => back.trace::<R>(band, fresnel, batch),
        }
        lens.meet_film::<R>(&back.batch, landing);
    }
}

impl ReprojectionColumns {
    /// Reverses rays that left the lens.
    fn turn_around<R: Real<Scalar = f32>>(&mut self, out: &LensBatch<f32>) {
        let (len, back) = (out.len, &mut self.batch);
        let one = R::constant(1.0);
        let turned: [(&Column<f32>, &mut Column<f32>, R); 6] = [
            (&out.x, &mut back.x, one),
            (&out.y, &mut back.y, one),
            (&out.z, &mut back.z, -one),
            (&out.tx, &mut back.tx, -one),
            (&out.ty, &mut back.ty, -one),
            (&out.tz, &mut back.tz, one),
        ];
        for (from, to, sign) in turned {
            for (to, from) in to.packets_mut::<R>(len).iter_mut().zip(from.packets::<R>(len)) {
                *to = *from * sign;
            }
        }
        back.weight.packets_mut::<R>(len).fill(one);
        let alive = out.x.packets::<R>(len).iter().map(|x| R::bits(x.equals(*x)).count_ones());
        (back.len, back.live) = (len, alive.sum::<u32>() as usize);
    }

    fn trace<R: Real<Scalar = f32>>(&mut self, band: &Band, fresnel: bool, out: &LensBatch<f32>) {
        let Self { batch, blocked } = self;
        // In air a direction has length 1, here to the precision of f64.
        let start = |i: usize| {
            let direction = DVec3::from_array([-out.tx[i], -out.ty[i], out.tz[i]].map(f64::from));
            let point = [out.x[i], out.y[i], -out.z[i]].map(f64::from);
            LensRay::new(point, direction.normalize().to_array())
        };
        if fresnel {
            trace_lossy::<R>(batch, &band.to_film, blocked);
            retrace_in_f64_lossy::<R>(batch, &band.to_film_f64, blocked, start);
        } else {
            trace::<R>(batch, &band.to_film, blocked);
            retrace_in_f64::<R>(batch, &band.to_film_f64, blocked, start);
        }
    }
}

impl RealLens {
    /// Intersects rays behind the rear vertex with the film.
    fn meet_film<R: Real<Scalar = f32>>(
        &self,
        batch: &LensBatch<f32>,
        landing: &mut ReprojectionBatch,
    ) {
        let middle = DAffine3::from_translation(DVec3::new(0.0, 0.0, self.film_distance));
        let film = FrameTransform::new::<R>(&(middle * self.film_pose.transform()).inverse());
        let film = (!self.film_pose.is_aligned()).then(|| FrameTransformKernel::<R>::of(&film));
        let (zero, distance) = (R::constant(0.0), R::constant(self.film_distance));
        let len = batch.len;
        let [x, y, z] = [&batch.x, &batch.y, &batch.z].map(|column| column.packets::<R>(len));
        let [tx, ty, tz] = [&batch.tx, &batch.ty, &batch.tz].map(|c| c.packets::<R>(len));
        let weight = batch.weight.packets::<R>(len);
        let [to_x, to_y] = landing.film.each_mut().map(|column| column.packets_mut::<R>(len));
        let share = landing.transmission.packets_mut::<R>(len);
        for i in 0..share.len() {
            let (p, t) = ([x[i], y[i], z[i]], [tx[i], ty[i], tz[i]]);
            // To the film's own frame.
            let ([x, y, z], [tx, ty, tz]) = match &film {
                None => ([p[0], p[1], p[2] - distance], t),
                Some(turn) => {
                    let ray = turn.cross(LensRay::new(p, t)).ray;
                    (ray.p, ray.t)
                }
            };
            let s = -(z / tz);
            // No light enters through its back.
            let lands = x.equals(x) & zero.lt(tz);
            to_x[i] = R::select(lands, s.mul_add(tx, x), zero);
            to_y[i] = R::select(lands, s.mul_add(ty, y), zero);
            share[i] = R::select(lands, weight[i], zero);
        }
    }
}
