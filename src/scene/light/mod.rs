//! Lights: what they send out, how they are sampled, and the choice among them.

mod area;
mod ball;
mod bounds;
mod choice;
mod cone;
mod lamp;
mod sky;
mod spherical;
mod split;
mod square;
mod tree;

pub use area::{AreaLight, Emission};
pub use ball::Ball;
pub use choice::Lights;
pub use lamp::{Beam, Lamp, luminance};
pub use sky::{Sky, SkyImage, SkyLayout};

use glam::{Vec2, Vec3};

use super::point::SurfacePoint;
use super::{Geometry, Scene};
use crate::rays::{Hit, Ray};
use choice::Choice;

/// Something that emits. Radiances are linear RGB in the units of the scene file.
#[derive(Clone, Debug)]
pub enum Light {
    /// A shape that shines.
    Area(AreaLight),
    /// A light at one point.
    Lamp(Lamp),
    /// Parallel light from infinitely far away; irradiance across the beam.
    Distant {
        /// Unit vector towards the light, world space.
        towards: Vec3,
        /// Irradiance.
        irradiance: [f32; 3],
    },
    /// The sky on all sides.
    Infinite(Sky),
}

/// A light as one point of a surface sees it.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Direction to the light: to its very point, or of unit length if `t_max` is infinite.
    pub direction: Vec3,
    /// Where the shadow ray ends.
    pub t_max: f32,
    /// Radiance that arrives from there; irradiance across the beam where `singular`.
    pub radiance: [f32; 3],
    /// Density of the choice, of the light and of the direction together, per unit of solid
    /// angle; the probability of the light alone where `singular`.
    pub density: f32,
    /// Whether no other ray runs into the light: it is at one point, in one direction, or a
    /// surface of alpha 0.
    pub singular: bool,
}

fn mean([r, g, b]: [f32; 3]) -> f32 {
    (r + g + b) / 3.0
}

impl Scene {
    /// Chooses a light, and a point of it, for a point of a surface: `choice` decides which
    /// light and which triangle of it, `u` where on it. `None` where it cannot contribute. The
    /// choice depends on the position of the point only, and no ray is traced.
    pub fn sample_light(
        &self,
        from: &SurfacePoint,
        choice: [f32; 2],
        u: [f32; 2],
    ) -> Option<LightSample> {
        let Choice { light, part, probability } = self.lights.choose(from.position, choice)?;
        let sample = match &self.lights.all[light as usize] {
            Light::Area(area) => area.sample(&self.shapes[area.shape as usize], part, from, u)?,
            Light::Lamp(lamp) => {
                let direction = lamp.position - from.leave(lamp.position - from.position);
                let d2 = direction.length_squared();
                let towards = direction.try_normalize()?;
                LightSample {
                    direction,
                    t_max: 1.0,
                    radiance: lamp.towards(-towards).map(|i| i / d2),
                    density: 1.0,
                    singular: true,
                }
            }
            Light::Distant { towards, irradiance } => LightSample {
                direction: *towards,
                t_max: f32::INFINITY,
                radiance: *irradiance,
                density: 1.0,
                singular: true,
            },
            Light::Infinite(sky) => {
                let sample = sky.sample(u)?;
                LightSample {
                    direction: sample.direction,
                    t_max: f32::INFINITY,
                    radiance: sample.radiance,
                    density: sample.density,
                    singular: false,
                }
            }
        };
        Some(LightSample { density: sample.density * probability, ..sample })
    }

    /// The light that [`Self::sample_light`] chooses for a point by these numbers, by index.
    pub fn chosen_light(&self, from: Vec3, choice: [f32; 2]) -> Option<u32> {
        self.lights.choose(from, choice).map(|choice| choice.light)
    }

    /// The density with which [`Self::sample_light`] chooses, from a point, the direction in
    /// which a ray ran into a surface: 0 where it does not shine. `point` is where, `direction`
    /// of unit length.
    pub fn emitter_density(
        &self,
        from: Vec3,
        hit: &Hit,
        point: &SurfacePoint,
        direction: Vec3,
    ) -> f32 {
        let Some((light, geometry)) = self.emitter(hit) else { return 0.0 };
        let probability = self.lights.probability(from, light.first + hit.primitive);
        if probability <= 0.0 {
            return 0.0;
        }
        probability * light.density(geometry, hit.primitive, from, point, direction)
    }

    /// The density with which [`Self::sample_light`] chooses a direction (unit) of a sky.
    pub fn sky_density(&self, _from: Vec3, sky: u32, direction: Vec3) -> f32 {
        match &self.lights.all[sky as usize] {
            Light::Infinite(light) => self.lights.far_probability(sky) * light.density(direction),
            _ => 0.0,
        }
    }

    /// The radiance of a light that fills the sky, from a direction.
    pub fn sky_radiance(&self, light: u32, direction: Vec3) -> [f32; 3] {
        match &self.lights.all[light as usize] {
            Light::Infinite(sky) => sky.radiance(direction),
            _ => [0.0; 3],
        }
    }

    /// What the surface that a ray hit sends out by itself in a direction; `normal` is on the
    /// side that the scene file calls outside, not turned to the ray.
    pub fn emitted(&self, ray: &Ray, hit: &Hit, normal: Vec3, direction: Vec3) -> [f32; 3] {
        let Some((light, _)) = self.emitter(hit) else { return [0.0; 3] };
        if !light.emission.two_sided && normal.dot(direction) <= 0.0 {
            return [0.0; 3];
        }
        let uv = match light.emission.image {
            Some(_) => self.patch(ray, hit).uv,
            None => Vec2::ZERO,
        };
        light.radiance(hit.primitive, uv)
    }

    /// The light that a ray hit.
    fn emitter(&self, hit: &Hit) -> Option<(&AreaLight, &Geometry)> {
        let shape = &self.shapes[hit.shape as usize];
        match self.lights.all.get(shape.light as usize)? {
            Light::Area(light) => Some((light, &shape.geometry)),
            _ => None,
        }
    }
}

/// A direction about a unit normal with density cos / pi, and its cosine.
pub fn cosine_hemisphere(normal: Vec3, u: [f32; 2]) -> (Vec3, f32) {
    let [x, y] = crate::sampler::disk(u[0], u[1]);
    let z = (1.0 - x * x - y * y).max(0.0).sqrt();
    let (tangent, bitangent) = normal.any_orthonormal_pair();
    (tangent * x + bitangent * y + normal * z, z)
}
