//! Light that rays find without a shadow ray: that of the surfaces they hit, and of skies.

use glam::Vec3;

use super::spawn::max_component;
use super::{LightSource, ShadeInputs};
use petzval_base::rays::{Column, Hit, NO_INDEX, PathFlags, RayBatch, SampleBatch};
use petzval_base::sampler::mis::power_heuristic;
use petzval_scene::{GlossyLobe, Reception, SkySampling};

impl ShadeInputs<'_> {
    /// Adds the light of the surfaces and skies that the rays found to the radiance of their
    /// samples.
    pub(super) fn add_emitted_light(&self, samples: &SampleBatch, radiance: &mut [Column<f32>; 3]) {
        let Self { scene, rays, hits, .. } = self;
        for i in 0..rays.len {
            let hit = &hits[i];
            if hit.shape == NO_INDEX {
                if self.hides_sky && self.vertex.depth == 0 {
                    continue;
                }
                let ray = rays.ray(i);
                let (origin, direction) = (Vec3::from(ray.origin), Vec3::from(ray.direction));
                for &sky in &scene.lights.skies {
                    let light = scene.sky_radiance(sky, origin, direction);
                    if light == [0.0; 3] {
                        continue;
                    }
                    let compensated = SkySampling::Compensated;
                    let pdf = || scene.sky_density(sky, origin, direction, compensated);
                    let source = LightSource::Sky(sky);
                    let weight = self.camera_weight(samples, i, source);
                    let weight = weight.unwrap_or_else(|| self.weight(i, pdf));
                    self.add(i, light, weight, radiance);
                }
            } else if hit.shape != Hit::IN_MEDIUM
                && scene.shapes[hit.shape as usize].light != NO_INDEX
            {
                let ray = rays.ray(i);
                let (origin, direction) = (Vec3::from(ray.origin), Vec3::from(ray.direction));
                let (_, point) = scene.surface(&ray, hit);
                let light = scene.emitted_radiance(&ray, hit, point.normal, -direction);
                if light != [0.0; 3] && !self.ends_caustic(i) {
                    let weight = self.camera_weight(samples, i, LightSource::Shape(hit, &point));
                    let weight = weight.unwrap_or_else(|| {
                        self.weight(i, || {
                            let reception = self.reception(i);
                            scene.area_light_density(origin, reception, hit, &point, direction)
                        })
                    });
                    self.add(i, light, weight, radiance);
                }
            }
        }
    }

    /// Returns the weight of light that the i-th ray found, if that is a camera ray and light paths find
    /// images of lamps too.
    fn camera_weight(&self, samples: &SampleBatch, i: usize, source: LightSource) -> Option<f32> {
        let weights = self.lamp_weights.filter(|_| self.vertex.depth == 0)?;
        let time = samples.time[self.rays.slot[i] as usize];
        Some(weights.camera_weight(self.scene, self.rays, i, time, source))
    }

    /// Returns how the surface that the i-th ray left receives light.
    fn reception(&self, i: usize) -> Reception {
        let RayBatch { wo, gloss: [alpha2, share], .. } = self.rays;
        let wo = [wo[0][i], wo[1][i], wo[2][i]];
        let lobe = GlossyLobe::new(wo, alpha2[i], share[i]);
        Reception { facing: self.rays.facing(i).to_array(), lobe }
    }

    /// Returns whether the i-th ray ends a path that light paths find as a caustic: from a surface
    /// that receives caustics, at last by way of a mirror or clear glass, to a surface that emits.
    fn ends_caustic(&self, i: usize) -> bool {
        self.flags(i).contains(PathFlags::FROM_RECEIVER | PathFlags::SPECULAR)
    }

    /// Returns the weight of light that the i-th ray found. Sampling of lights would have found it
    /// with the density `light_pdf`.
    #[inline(always)]
    fn weight(&self, i: usize, light_pdf: impl FnOnce() -> f32) -> f32 {
        // Only the lens can choose the direction of a camera ray.
        let sampled = self.vertex.depth > 0 && !self.flags(i).contains(PathFlags::SPECULAR);
        if sampled { power_heuristic(self.rays.pdf[i], light_pdf()) } else { 1.0 }
    }

    /// Adds light that the i-th ray found, times a weight, to its sample.
    #[inline(always)]
    fn add(&self, i: usize, light: [f32; 3], weight: f32, radiance: &mut [Column<f32>; 3]) {
        let rays = self.rays;
        let slot = rays.slot[i] as usize;
        let throughput = rays.throughput(i);
        for channel in 0..3 {
            radiance[channel][slot] += throughput[channel] * light[channel] * weight;
        }
    }

    /// Returns the i-th ray's scale of the throughput for Russian roulette.
    pub(super) fn roulette_scale(&self, i: usize) -> f32 {
        match self.vertex.depth {
            0 => 1.0 / max_component(self.rays.throughput(i)).max(f32::MIN_POSITIVE),
            _ => self.rays.roulette_scale[i],
        }
    }
}
