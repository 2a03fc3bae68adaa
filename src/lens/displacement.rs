//! How far light lands from where it would if film and elements stood otherwise.

use glam::DVec3;

use super::camera::{LensColumns, RealLens};
use super::pose::Pose;
use super::prescription::Prescription;
use super::refract::LensRay;
use super::surface::{From, sequence};
use super::trace::trace_one;
use super::widened::{Keep, widened};
use crate::lanes::f32x8;
use crate::rays::{SampleBatch, WAVE};
use crate::stats::LensStats;

/// Rays that are looked at.
const RAYS: usize = 512;

impl RealLens {
    /// How far, um on the film, light lands with a lens and a film that stand like these from where
    /// it lands with all parts square: root mean square over the film (its width and height, mm) and
    /// the pupil. Rays are traced out through the square lens and back in through the other; rims
    /// do not stop them, because the pupil need not be the same.
    pub fn displacement(&self, posed: &Prescription, pose: Pose, film: [f64; 2]) -> f64 {
        let distance = self.film_distance;
        let open = widened(posed, Keep::Nothing);
        let out = sequence::<f64>(&open.centred(), From::Film(distance));
        let front = &open.rows[0];
        let start = 2.0 * front.sag(front.diameter / 2.0).abs() + front.diameter;
        let back = sequence::<f64>(&open, From::Scene(start));
        let index = posed.rear().index;
        let (mut sum, mut count) = (0.0f64, 0.0);
        for [from, aim] in self.aims(film) {
            let way = [aim[0] - from[0], aim[1] - from[1], distance];
            let scale = index / DVec3::from_array(way).length();
            let ray = LensRay::new([from[0], from[1], 0.0], way.map(|v| v * scale));
            let Ok(LensRay { p, t, .. }) = trace_one::<f64>(ray, &out) else { continue };
            if t[2] <= 0.0 {
                continue;
            }
            // Back from the plane where rays from the scene start.
            let s = (start - p[2]) / t[2];
            let ray = LensRay::new([p[0] + s * t[0], p[1] + s * t[1], 0.0], [-t[0], -t[1], t[2]]);
            let Ok(ray) = trace_one::<f64>(ray, &back) else { continue };
            let [x, y] = landing(ray.p, ray.t, distance, pose);
            let off = (x - from[0]).powi(2) + (y - from[1]).powi(2);
            if off.is_finite() {
                (sum, count) = (sum + off, count + 1.0);
            }
        }
        if count > 0.0 { 1e3 * (sum / count).sqrt() } else { 0.0 }
    }

    /// Where light on its way to the film, from a point relative to the rear vertex and z towards the
    /// film, meets it: mm from the film's own middle.
    pub fn landing(&self, p: [f64; 3], t: [f64; 3]) -> [f64; 2] {
        landing(p, t, self.film_distance, self.film_pose)
    }

    /// Film points, and points of the rear vertex plane that rays from there go to, mm.
    fn aims(&self, film: [f64; 2]) -> Vec<[[f64; 2]; 2]> {
        let mut samples = SampleBatch { len: RAYS.min(WAVE), ..SampleBatch::default() };
        samples.spread(film.map(|side| side / 2.0), 0);
        let mut columns = LensColumns::default();
        let blocked = vec![0; self.prescription.rows.len()];
        let mut stats = LensStats { blocked, ..LensStats::default() };
        self.launch::<f32x8>(&samples, &mut columns, &mut stats);
        let batch = &columns.batch;
        let aim = |i: usize| {
            let of = |v: f32| f64::from(v);
            let s = (self.film_distance - of(batch.z[i])) / of(batch.tz[i]);
            [
                [0, 1].map(|axis| of(samples.film[axis][i])),
                [of(batch.x[i]) + s * of(batch.tx[i]), of(batch.y[i]) + s * of(batch.ty[i])],
            ]
        };
        (0..samples.len).map(aim).filter(|[_, to]| to.iter().all(|v| v.is_finite())).collect()
    }
}

fn landing(p: [f64; 3], t: [f64; 3], distance: f64, pose: Pose) -> [f64; 2] {
    let motion = pose.motion();
    let middle = motion.translation + DVec3::new(0.0, 0.0, distance);
    let normal = motion.matrix3.z_axis;
    let (p, t) = (DVec3::from_array(p), DVec3::from_array(t));
    let met = p + t * ((middle - p).dot(normal) / t.dot(normal));
    let own = motion.matrix3.transpose() * (met - middle);
    [own.x, own.y]
}
