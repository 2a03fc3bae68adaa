//! Light that enters a lens.

use glam::{DVec3, Vec3};

use crate::distribution::Distribution;
use crate::lanes::Real;
use crate::lens::{RealLens, Surface, trace_ghost};
use crate::rays::{Column, LensBatch, Ray, RayBatch, WAVE};
use crate::render::Job;
use crate::sampler::{Dimension, pair};
use crate::scene::{SurfacePoint, TraversalStack, gamma, luminance};

/// A wave of light paths: from lights to the front surface, and on through the lens.
#[derive(Clone, Debug, Default)]
pub(super) struct Photons {
    /// On the front surface.
    start: LensBatch<f32>,
    /// Behind the rear one.
    batch: LensBatch<f32>,
    /// Back from the front surface to the light, each with the flux that it carries: radiance
    /// times mm^2 sr, over the density of its choice.
    rays: RayBatch,
    entry: Vec<[f32; 2]>,
    /// When each arrives, where things move.
    times: Column<f32>,
    shadows: RayBatch,
    stack: TraversalStack,
    arrived: [Column<f32>; 3],
}

impl Photons {
    /// Samples lights from points of the front surface, a wave of them: uniformly spread over
    /// the square about it, or by a density. The surface may stand askew; the square does as it.
    pub fn sample(&mut self, job: &Job, lens: &RealLens, key: u32, entry: Option<&Distribution>) {
        let front = &lens.prescription.rows[0];
        let half = front.diameter / 2.0;
        let placed = lens.prescription.placements()[0];
        let world = job.camera.world_from_camera;
        let camera = world.matrix3.inverse();
        self.entry.clear();
        self.rays.len = 0;
        for i in 0..WAVE as u32 {
            let u = pair(key, i, Dimension::Pupil);
            let (uv, density) = match entry {
                Some(entry) => {
                    let chosen = entry.sample(u);
                    (chosen.uv, chosen.density)
                }
                None => (u, 1.0),
            };
            let [x, y] = uv.map(|u| (2.0 * f64::from(u) - 1.0) * half);
            if x.hypot(y) > half {
                continue;
            }
            let [gx, gy] = front.gradient(x, y);
            // From the surface's own frame to that of the front vertex, and on to the camera's, whose z
            // is to the scene.
            let point = placed.transform_point3(DVec3::new(x, y, front.sag_at(x, y)));
            let normal = placed.transform_vector3(DVec3::new(gx, gy, -1.0));
            let outward = DVec3::new(normal.x, normal.y, -normal.z);
            let [right, up, back] = (point * lens.unit).to_array();
            let place = world.transform_point3(DVec3::new(right, up, lens.front - back));
            // Normals turn with the inverse transposed; its length does not matter.
            let normal = (camera.transpose() * outward).normalize().as_vec3();
            let position = place.as_vec3();
            let error = position.abs() * gamma(4) + Vec3::splat(f32::MIN_POSITIVE);
            let from = SurfacePoint { position, error, normal, shading: normal };
            let [choice, at] = [Dimension::Choice(0), Dimension::Light(0)].map(|d| pair(key, i, d));
            let Some(light) = job.scene.sample_light(&from, choice, at) else { continue };
            let towards = (camera * light.direction.as_dvec3()).normalize();
            // Its front half only: the kernels take rays that travel along the axis.
            let facing = towards.dot(outward);
            if !(facing > 0.0 && towards.z > 0.0 && light.density > 0.0) {
                continue;
            }
            let area = 4.0 * half * half / f64::from(density);
            let flux = facing * area / f64::from(light.density);
            let k = self.rays.len;
            [self.start.x[k], self.start.y[k], self.start.z[k]] =
                point.to_array().map(|v| v as f32);
            [self.start.tx[k], self.start.ty[k], self.start.tz[k]] =
                [-towards.x, -towards.y, towards.z].map(|v| v as f32);
            self.start.weight[k] = 1.0;
            let origin = from.leave(light.direction);
            let ray = Ray {
                origin: origin.to_array(),
                direction: light.direction.to_array(),
                t_max: light.t_max,
            };
            let carried = light.radiance.map(|l| (f64::from(l) * flux) as f32);
            self.rays.push(ray, carried, k as u32);
            self.times[k] = job
                .timing
                .as_ref()
                .map_or(0.0, |timing| timing.moment(pair(key, i, Dimension::Time)[0]));
            self.entry.push(uv);
        }
    }

    /// How many light paths there are.
    pub fn len(&self) -> usize {
        self.rays.len
    }

    /// What arrives on a film of this size, mm, of the last trace and the last connection: where,
    /// in shares of its width and height; the flux, as luminance; and where in the square about
    /// the front surface it entered.
    pub fn seen(&self, film: [f64; 2]) -> impl Iterator<Item = ([f64; 2], f64, [f32; 2])> {
        (0..self.rays.len).filter_map(move |i| {
            let place =
                [f64::from(self.batch.x[i]) / film[0], f64::from(self.batch.y[i]) / film[1]];
            let place = place.map(|share| share + 0.5);
            let light = f64::from(luminance(self.arrived(i)) * self.batch.weight[i]);
            let inside = place.iter().all(|place| (0.0..1.0).contains(place));
            inside.then_some((place, light, self.entry[i]))
        })
    }

    /// Traces the wave through a sequence of surfaces to the film ([`Self::behind`]), from the
    /// start again each time. Answers whether any path comes through.
    pub fn through<R: Real<Scalar = f32>>(
        &mut self,
        lens: &RealLens,
        surfaces: &[Surface<f32>],
    ) -> bool {
        self.batch.clone_from(&self.start);
        self.batch.resize::<R>(self.rays.len);
        if trace_ghost::<R>(&mut self.batch, surfaces) == 0 {
            return false;
        }
        let batch = &mut self.batch;
        if !lens.film_pose.is_square() {
            for i in 0..batch.len {
                let of = |v: [f32; 3]| v.map(f64::from);
                let p = of([batch.x[i], batch.y[i], batch.z[i]]);
                let t = of([batch.tx[i], batch.ty[i], batch.tz[i]]);
                [batch.x[i], batch.y[i]] = lens.landing(p, t).map(|v| v as f32);
            }
            return true;
        }
        let distance = lens.film_distance as f32;
        for i in 0..batch.len {
            let s = (distance - batch.z[i]) / batch.tz[i];
            batch.x[i] += s * batch.tx[i];
            batch.y[i] += s * batch.ty[i];
        }
        true
    }

    /// Where on the film paths meet it, mm: NaN in x for those that do not, and their weights.
    pub fn behind(&self) -> &LensBatch<f32> {
        &self.batch
    }

    /// Finds out of which of these paths nothing in the scene stands in the way; they may be named
    /// several times.
    pub fn connect<R: Real<Scalar = f32>>(&mut self, job: &Job, paths: impl Iterator<Item = u32>) {
        self.shadows.len = 0;
        let mut asked = [false; WAVE];
        for path in paths {
            asked[path as usize] = true;
        }
        for (i, _) in asked.iter().enumerate().filter(|(_, asked)| **asked) {
            self.arrived.iter_mut().for_each(|column| column[i] = 0.0);
            self.shadows.push(self.rays.ray(i), self.rays.carried(i), i as u32);
        }
        if !job.scene.movers().is_empty() {
            job.scene.occlude_moving::<R>(&mut self.shadows, &self.times, &mut self.stack);
        }
        job.scene.occlude::<R>(&self.shadows, &mut self.stack, &mut self.arrived);
    }

    /// The flux of a path that was asked for in [`Self::connect`]; 0 where it is in shadow.
    pub fn arrived(&self, i: usize) -> [f32; 3] {
        [0, 1, 2].map(|c| self.arrived[c][i])
    }

    /// Ends a path where it starts.
    pub fn block(&mut self, i: usize) {
        self.start.x[i] = f32::NAN;
    }
}
