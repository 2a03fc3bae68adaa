//! Where the rays of a wave would come from on the film in another light: a stage.
//!
//! What the lens makes of a film point in one band, a ray in the world, could as well have been made
//! in another band from another film point: that to which the lens takes this ray's light in the
//! other band. Surfaces turn light around without a trace, so it is found by tracing from the scene.

use glam::{DAffine3, DVec3};

use super::band::Band;
use super::camera::{Camera, LensColumns, Model, RealLens};
use super::refract::{Kernel, LensRay};
use super::trace::{settle, settle_lossy, trace, trace_lossy};
use super::turn::{Turn, TurnLanes};
use crate::lanes::Real;
use crate::plan::EFFECTS;
use crate::rays::{Column, LandingBatch, LensBatch};

/// The columns of rays on their way back.
#[derive(Clone, Debug, Default)]
pub(super) struct LandingColumns {
    batch: LensBatch<f32>,
    /// Where rays end is counted for those from the film only.
    blocked: Vec<u64>,
}

impl LensColumns {
    /// What the rays of the last wave count on the film, without the camera's imaging ratio and the
    /// band's response.
    pub fn exposure(&self) -> &Column<f32> {
        &self.batch.weight
    }

    /// What the lens has let through of each of so many rays of the last wave, where its light is in
    /// bands: a share.
    pub fn passed(&self, rays: usize, share: &mut Column<f32>) {
        for i in 0..rays {
            share[i] = self.batch.weight[i] / self.launched[i];
        }
    }
}

impl Camera {
    /// Takes the rays that [`Camera::expose`] last made of a wave back to the film, in another band.
    pub fn land<R: Real<Scalar = f32>>(
        &self,
        band: usize,
        columns: &mut LensColumns,
        landing: &mut LandingBatch,
    ) {
        let Model::Real(lens) = &self.model else { return };
        let band = &lens.bands[band];
        let LensColumns { batch, landing: back, .. } = columns;
        back.blocked.resize(lens.prescription.rows.len(), 0);
        back.turn_around::<R>(batch);
        if lens.double {
            back.doubt_all();
        }
        back.trace::<R>(band, EFFECTS && lens.fresnel, lens.double, batch);
        lens.meet_film::<R>(&back.batch, landing);
    }
}

impl LandingColumns {
    /// Starts rays where others came out, in the direction that they came from.
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
        let alive = out.x.packets::<R>(len).iter().map(|x| R::bits(x.same(*x)).count_ones());
        (back.len, back.living) = (len, alive.sum::<u32>() as usize);
    }

    /// Leaves all rays to f64.
    fn doubt_all(&mut self) {
        let LensBatch { len, x, doubtful, .. } = &mut self.batch;
        doubtful.clear();
        doubtful.extend((0..*len as u32).filter(|&i| !x[i as usize].is_nan()));
        x[..*len].fill(f32::NAN);
    }

    fn trace<R: Real<Scalar = f32>>(
        &mut self,
        band: &Band,
        fresnel: bool,
        double: bool,
        out: &LensBatch<f32>,
    ) {
        let Self { batch, blocked } = self;
        // In air a direction is of length 1, as exactly as f64 has it.
        let start = |i: usize| {
            let direction = DVec3::from_array([-out.tx[i], -out.ty[i], out.tz[i]].map(f64::from));
            let point = [out.x[i], out.y[i], -out.z[i]].map(f64::from);
            LensRay::new(point, direction.normalize().to_array())
        };
        if fresnel {
            if !double {
                trace_lossy::<R>(batch, &band.back, blocked);
            }
            settle_lossy::<R>(batch, &band.back_exact, blocked, start);
        } else {
            if !double {
                trace::<R>(batch, &band.back, blocked);
            }
            settle::<R>(batch, &band.back_exact, blocked, start);
        }
    }
}

impl RealLens {
    /// Where rays behind the rear vertex meet the film.
    fn meet_film<R: Real<Scalar = f32>>(&self, batch: &LensBatch<f32>, landing: &mut LandingBatch) {
        let middle = DAffine3::from_translation(DVec3::new(0.0, 0.0, self.film_distance));
        let film = Turn::new::<R>(&(middle * self.film_pose.motion()).inverse());
        let film = (!self.film_pose.is_square()).then(|| TurnLanes::<R>::of(&film));
        let (zero, distance) = (R::constant(0.0), R::constant(self.film_distance));
        let len = batch.len;
        let [x, y, z] = [&batch.x, &batch.y, &batch.z].map(|column| column.packets::<R>(len));
        let [tx, ty, tz] = [&batch.tx, &batch.ty, &batch.tz].map(|c| c.packets::<R>(len));
        let weight = batch.weight.packets::<R>(len);
        let [to_x, to_y] = landing.film.each_mut().map(|column| column.packets_mut::<R>(len));
        let share = landing.share.packets_mut::<R>(len);
        for i in 0..share.len() {
            let (p, t) = ([x[i], y[i], z[i]], [tx[i], ty[i], tz[i]]);
            // In the film's own frame.
            let ([x, y, z], [tx, ty, tz]) = match &film {
                None => ([p[0], p[1], p[2] - distance], t),
                Some(turn) => {
                    let ray = turn.cross(LensRay::new(p, t)).ray;
                    (ray.p, ray.t)
                }
            };
            let s = -(z / tz);
            // No light comes through its back.
            let lands = x.same(x) & zero.lt(tz);
            to_x[i] = R::select(lands, s.mul_add(tx, x), zero);
            to_y[i] = R::select(lands, s.mul_add(ty, y), zero);
            share[i] = R::select(lands, weight[i], zero);
        }
    }
}
