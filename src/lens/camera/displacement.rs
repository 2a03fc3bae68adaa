//! Displacement of the image by tilts and decentres of film and elements.

use glam::DVec3;

use crate::camera::{LensColumns, RealLens};
use crate::prescription::Prescription;
use crate::prescription::pose::Pose;
use crate::trace::kernel::LensRay;
use crate::trace::sequence::{Side, sequence};
use crate::trace::trace_one;
use crate::vignetting::open_rims::{KeptRims, open_rims};
use petzval_base::lanes::f32x8;
use petzval_base::rays::{SampleBatch, WAVE_SIZE};
use petzval_base::stats::LensStats;

/// Number of rays.
const RAYS: usize = 512;

impl RealLens {
    /// Returns the displacement of the image by the poses of a lens and a film against the centred
    /// lens [um on the film]: the root mean square over a film of this width and height (mm) and
    /// over the pupil. Rays are traced out through the centred lens and back in through the other.
    /// Rims do not block them, because the pupils may differ.
    pub fn displacement(&self, posed: &Prescription, pose: Pose, film: [f64; 2]) -> f64 {
        let distance = self.film_distance;
        let open = open_rims(posed, KeptRims::None);
        let out = sequence::<f64>(&open.centred(), Side::Film(distance));
        let front = &open.rows[0];
        let start = 2.0 * front.sag(front.diameter / 2.0).abs() + front.diameter;
        let back = sequence::<f64>(&open, Side::Scene(start));
        let index = posed.rear().index;
        let (mut sum, mut count) = (0.0f64, 0.0);
        for [from, aim] in self.aimed_rays(film) {
            let way = [aim[0] - from[0], aim[1] - from[1], distance];
            let scale = index / DVec3::from_array(way).length();
            let ray = LensRay::new([from[0], from[1], 0.0], way.map(|v| v * scale));
            let Ok(LensRay { p, t, .. }) = trace_one::<f64>(ray, &out) else { continue };
            if t[2] <= 0.0 {
                continue;
            }
            // The ray returns from the plane in which rays from the scene start.
            let s = (start - p[2]) / t[2];
            let ray = LensRay::new([p[0] + s * t[0], p[1] + s * t[1], 0.0], [-t[0], -t[1], t[2]]);
            let Ok(ray) = trace_one::<f64>(ray, &back) else { continue };
            let [x, y] = film_intersection(ray.p, ray.t, distance, pose);
            let off = (x - from[0]).powi(2) + (y - from[1]).powi(2);
            if off.is_finite() {
                (sum, count) = (sum + off, count + 1.0);
            }
        }
        if count > 0.0 { 1e3 * (sum / count).sqrt() } else { 0.0 }
    }

    /// Returns the film coordinates (mm) at which a ray meets the film, by a point and a direction
    /// relative to the rear vertex, z towards the film.
    pub fn film_intersection(&self, p: [f64; 3], t: [f64; 3]) -> [f64; 2] {
        film_intersection(p, t, self.film_distance, self.film_pose)
    }

    /// Returns film points, each with a point of the rear vertex plane that a ray from there goes
    /// to (mm).
    fn aimed_rays(&self, film: [f64; 2]) -> Vec<[[f64; 2]; 2]> {
        let mut samples = SampleBatch { len: RAYS.min(WAVE_SIZE), ..SampleBatch::default() };
        samples.fill_evenly(film.map(|side| side / 2.0), 0);
        let mut columns = LensColumns::default();
        let mut stats = LensStats::default();
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

/// Returns the coordinates at which a ray meets a film of this pose and distance.
fn film_intersection(p: [f64; 3], t: [f64; 3], distance: f64, pose: Pose) -> [f64; 2] {
    let motion = pose.transform();
    let middle = motion.translation + DVec3::new(0.0, 0.0, distance);
    let normal = motion.matrix3.z_axis;
    let (p, t) = (DVec3::from_array(p), DVec3::from_array(t));
    let met = p + t * ((middle - p).dot(normal) / t.dot(normal));
    let own = motion.matrix3.transpose() * (met - middle);
    [own.x, own.y]
}
