//! Starts of light paths: rays from area lights to casters.

use super::Caustics;
use crate::advance::PathColumns;
use crate::light_tracing::light_paths::LightPathInput;
use crate::timing::ArrivalTime;
use petzval_base::rays::{PathFlags, Ray, RayBatch, RayDifferential, SampleBatch, WAVE_SIZE};
use petzval_base::sampler::{Dimension, sample_2d};
use petzval_scene::{SurfacePoint, luminance};

/// Largest difference of a hit from the sampled point, relative to its distance from the light.
const NEAR: f32 = 1e-4;

/// Start of a light path.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PathStart {
    /// Flux (radiance times world units^2 sr) over that of the ray's throughput.
    pub flux: f64,
    /// Luminance of the light.
    pub radiance: f64,
    /// Time of its arrival on the film.
    pub time: ArrivalTime,
    /// Index of the caster.
    pub caster: u32,
    primitive: u32,
}

impl Caustics {
    /// Samples a wave of rays from lights to casters.
    pub(super) fn start(
        &self,
        input: &LightPathInput<'_>,
        samples: &mut SampleBatch,
        rays: &mut RayBatch,
        starts: &mut Vec<PathStart>,
        [key, wave]: [u32; 2],
    ) {
        samples.len = WAVE_SIZE;
        rays.len = 0;
        starts.clear();
        for i in 0..WAVE_SIZE as u32 {
            let number = wave * WAVE_SIZE as u32 + i;
            (samples.key[i as usize], samples.sample[i as usize]) = (key, number);
            let time = input.arrival_time(key, number);
            samples.time[i as usize] = time.scene;
            if let Some((ray, radiance, start)) = self.sample_start(input, key, number, time) {
                push_start(rays, ray, radiance, i);
                starts.push(start);
            } else {
                starts.push(PathStart::default());
            }
        }
    }

    /// Keeps the rays that hit the sampled points of casters.
    pub(super) fn keep_unoccluded(&self, starts: &[PathStart], paths: &mut PathColumns) {
        let PathColumns { rays, hits, .. } = paths;
        let mut kept = 0;
        rays.retain(|rays, i| {
            let (hit, t_max) = (hits[i], rays.t_max[i]);
            let start = &starts[rays.slot[i] as usize];
            let placed = &self.casters[start.caster as usize].placed;
            let unoccluded = hit.shape == placed.shape
                && hit.instance == placed.instance
                && hit.primitive == start.primitive
                && (hit.t * (1.0 + NEAR) - t_max).abs() <= NEAR * t_max;
            if unoccluded {
                hits[kept] = hit;
                kept += 1;
            }
            unoccluded
        });
    }

    /// Samples the ray of a light path. Returns it with its throughput.
    fn sample_start(
        &self,
        input: &LightPathInput<'_>,
        key: u32,
        number: u32,
        time: ArrivalTime,
    ) -> Option<(Ray, [f32; 3], PathStart)> {
        let scene = input.scene;
        let [choice, primitive] = sample_2d(key, number, Dimension::Pupil);
        let chosen = self.choice.sample(choice);
        let caster = &self.casters[chosen];
        let at = sample_2d(key, number, Dimension::Film);
        let on_caster = caster.sample(scene, time.scene, primitive, at)?;
        let from: &SurfacePoint = &on_caster.point;
        let [choice, u] =
            [Dimension::LightChoice(0), Dimension::Light(0)].map(|d| sample_2d(key, number, d));
        let light = scene.sample_light(from, glam::Vec3::ZERO, choice, u)?;
        // A point light or a sky throws caustics that camera paths do not leave out.
        if light.singular || light.t_max.is_infinite() || light.density <= 0.0 {
            return None;
        }
        let origin = from.offset_origin(light.direction) + light.direction;
        let way = from.position - origin;
        let direction = way.try_normalize()?;
        let luminance = f64::from(luminance(light.radiance));
        let brightest = light.radiance.iter().fold(0.0f32, |a, &b| a.max(b));
        if brightest <= 0.0 {
            return None;
        }
        let cos = f64::from(from.normal.dot(direction).abs());
        let start = PathStart {
            flux: cos * f64::from(brightest) / (on_caster.density * f64::from(light.density)),
            radiance: luminance,
            time,
            caster: chosen as u32,
            primitive: on_caster.primitive,
        };
        let t_max = way.length() * (1.0 + NEAR);
        let ray = Ray { origin: origin.to_array(), direction: direction.to_array(), t_max };
        // The largest channel is 1: Russian roulette measures what is left of it.
        Some((ray, light.radiance.map(|l| l / brightest), start))
    }
}

/// Adds the ray of a light path to a batch.
fn push_start(rays: &mut RayBatch, ray: Ray, throughput: [f32; 3], slot: u32) {
    let at = rays.len;
    rays.push(ray, throughput, slot);
    rays.flags[at] = PathFlags::SPECULAR;
    rays.roulette_scale[at] = 1.0;
    rays.set_facing(at, [0.0; 3]);
    rays.differential[at] = RayDifferential::UNKNOWN;
}
