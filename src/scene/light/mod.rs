//! Lights: emission, sampling, and the random selection of a light for a point.

mod area;
mod area_sampling;
mod choose;
mod point;
mod portal;
mod reception;
mod sampler;
mod sky;
mod spherical_triangle;
mod stage;
mod tree;
mod visible_cap;
mod windowed_distribution;

pub use area::{AreaLight, Emission};
pub use point::{IntensityDistribution, PointLight, luminance};
pub use portal::{NoRectangle, Portal};
pub use reception::{GlossyLobe, LobeColumns, Reception};
pub use sampler::Lights;
pub use sky::{Sky, SkyImage, SkyLayout, SkySampling};
pub use stage::{LightColumns, LightInputs, LightSamples};

use glam::{Vec2, Vec3};

use super::{Geometry, Scene, SurfacePoint};
use petzval_base::rays::{Hit, Ray};
use petzval_spectrum::Colour;
use sampler::LightChoice;
use tree::Receiver;

/// A light source. Radiances are in the units of the scene file: linear RGB, and spectra if they are known.
#[derive(Clone, Debug)]
pub enum Light {
    /// A shape that emits light.
    Area(AreaLight),
    /// A light at one position.
    Point(PointLight),
    /// Parallel light from infinitely far away.
    Distant {
        /// Unit vector towards the light, world space.
        towards: Vec3,
        /// Irradiance on a plane perpendicular to the light.
        irradiance: Colour,
    },
    /// Light from infinitely far away in all directions.
    Infinite(Sky),
    /// Light from infinitely far away through a portal.
    Portal(Box<Portal>),
}

/// A sampled direction from a point of a surface to a light.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Vector to the sampled point of the light, or a unit vector if `t_max` is infinite.
    pub direction: Vec3,
    /// End of the shadow ray, in lengths of `direction`.
    pub t_max: f32,
    /// Radiance that arrives from the light; for point and distant lights, the irradiance on a
    /// plane perpendicular to the direction.
    pub radiance: [f32; 3],
    /// Probability density of the light and the direction together [1/sr]; for point and distant
    /// lights, the probability of the light.
    pub density: f32,
    /// Whether BSDF sampling can never hit the light: a point light, a distant light, or a surface
    /// of alpha 0.
    pub singular: bool,
}

/// Returns linear RGB in the channels that paths carry.
#[inline(always)]
pub fn uplifted(texel: [f32; 3], matrix: &Option<[[f32; 3]; 3]>) -> [f32; 3] {
    match matrix {
        None => texel,
        Some(rows) => rows.map(|row| (0..3).map(|c| row[c] * texel[c]).sum()),
    }
}

fn mean([r, g, b]: [f32; 3]) -> f32 {
    (r + g + b) / 3.0
}

impl Scene {
    /// Samples a light for a point of a surface, without tracing a shadow ray. `choice` selects the
    /// light and its triangle, `u` the point on it. The selection depends only on the position and
    /// on how the surface receives light. Every light that reaches the point can be sampled, other
    /// than by the stage [`Self::sample_lights`]. Returns `None` if the sample cannot contribute.
    pub fn sample_light(
        &self,
        from: &SurfacePoint,
        reception: impl Into<Reception>,
        choice: [f32; 2],
        u: [f32; 2],
    ) -> Option<LightSample> {
        let choice = self.lights.choose(&receiver(from.position, reception), choice)?;
        self.sample_choice(choice, from, u, SkySampling::Complete)
    }

    /// Samples a point or a direction of a selected light.
    fn sample_choice(
        &self,
        choice: LightChoice,
        from: &SurfacePoint,
        u: [f32; 2],
        sampling: SkySampling,
    ) -> Option<LightSample> {
        let LightChoice { light, primitive, probability } = choice;
        let sample = match &self.lights.all[light as usize] {
            Light::Area(area) => {
                area.sample(&self.shapes[area.shape as usize], primitive, from, u)?
            }
            Light::Point(point) => {
                let direction = point.position - from.offset_origin(point.position - from.position);
                let d2 = direction.length_squared();
                let towards = direction.try_normalize()?;
                LightSample {
                    direction,
                    t_max: 1.0,
                    radiance: point.towards(-towards).map(|i| i / d2),
                    density: 1.0,
                    singular: true,
                }
            }
            Light::Distant { towards, irradiance } => LightSample {
                direction: *towards,
                t_max: f32::INFINITY,
                radiance: irradiance.rgb,
                density: 1.0,
                singular: true,
            },
            Light::Infinite(_) | Light::Portal(_) => {
                let sample = match &self.lights.all[light as usize] {
                    Light::Portal(portal) => portal.sample(from.position, u)?,
                    Light::Infinite(sky) => sky.sample(u, sampling)?,
                    _ => return None,
                };
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

    /// Returns the index of the light that [`Self::sample_light`] selects for a point.
    pub fn sampled_light(
        &self,
        from: Vec3,
        reception: impl Into<Reception>,
        choice: [f32; 2],
    ) -> Option<u32> {
        self.lights.choose(&receiver(from, reception), choice).map(|choice| choice.light)
    }

    /// Returns the density [1/sr] with which [`Self::sample_light`] samples the unit `direction`
    /// from `from` to a `point` that a ray hit; 0 if the surface emits nothing.
    pub fn area_light_density(
        &self,
        from: Vec3,
        reception: impl Into<Reception>,
        hit: &Hit,
        point: &SurfacePoint,
        direction: Vec3,
    ) -> f32 {
        let Some((light, geometry)) = self.emitter(hit) else { return 0.0 };
        let emitter = light.first_emitter + hit.primitive;
        let probability = self.lights.probability(&receiver(from, reception), emitter);
        if probability <= 0.0 {
            return 0.0;
        }
        probability * light.density(geometry, hit.primitive, from, point, direction)
    }

    /// Returns the indices of all area lights.
    pub fn area_lights(&self) -> Vec<u32> {
        let is_area = |i: &u32| matches!(self.lights.all[*i as usize], Light::Area(_));
        (0..self.lights.all.len() as u32).filter(is_area).collect()
    }

    /// Returns the area of each triangle of an area light, or one number for a quadric or a sky.
    pub fn emitter_areas(&self, light: u32) -> Vec<f64> {
        let Light::Area(area) = &self.lights.all[light as usize] else { return vec![1.0] };
        match &self.shapes[area.shape as usize].geometry {
            Geometry::Mesh(mesh) => mesh.patch_areas().into_iter().map(f64::from).collect(),
            Geometry::Quadric(_) => vec![1.0],
            Geometry::Patches(_) | Geometry::Curves(_) => Vec::new(),
        }
    }

    /// Samples a point of a triangle of an area light or of a quadric, or a direction of a sky, for a
    /// point of a surface. The density [1/sr] does not include the choice of light and triangle.
    pub fn sample_emitter(
        &self,
        light: u32,
        primitive: u32,
        from: &SurfacePoint,
        u: [f32; 2],
    ) -> Option<LightSample> {
        let choice = LightChoice { light, primitive, probability: 1.0 };
        self.sample_choice(choice, from, u, SkySampling::Complete)
    }

    /// Returns the density [1/sr] with which [`Self::sample_emitter`] samples the unit `direction`
    /// from `from` to a `point` that a ray hit; 0 if the surface emits nothing.
    pub fn emitter_density(
        &self,
        hit: &Hit,
        from: Vec3,
        point: &SurfacePoint,
        direction: Vec3,
    ) -> f32 {
        self.emitter(hit).map_or(0.0, |(light, geometry)| {
            light.density(geometry, hit.primitive, from, point, direction)
        })
    }

    /// Returns the density (1/sr) with which a unit direction of a sky is sampled from a point: by
    /// [`Self::sample_light`] if `sampling` is complete, by the stage [`Self::sample_lights`] if it
    /// is compensated.
    pub fn sky_density(&self, sky: u32, from: Vec3, direction: Vec3, sampling: SkySampling) -> f32 {
        self.lights.distant_probability(sky)
            * self.sky_direction_density(sky, from, direction, sampling)
    }

    /// Returns the density (1/sr) with which a unit direction is sampled from a point, among those of
    /// a sky. If `sampling` is complete, it is that of [`Self::sample_emitter`].
    pub fn sky_direction_density(
        &self,
        sky: u32,
        from: Vec3,
        direction: Vec3,
        sampling: SkySampling,
    ) -> f32 {
        match &self.lights.all[sky as usize] {
            Light::Portal(portal) => portal.density(from, direction),
            Light::Infinite(light) => light.density(direction, sampling),
            _ => 0.0,
        }
    }

    /// Returns the radiance of a sky at a point from a unit direction, away from the scene.
    pub fn sky_radiance(&self, light: u32, from: Vec3, direction: Vec3) -> [f32; 3] {
        match &self.lights.all[light as usize] {
            Light::Infinite(sky) => sky.radiance(direction),
            Light::Portal(portal) => portal.radiance(from, direction),
            _ => [0.0; 3],
        }
    }

    /// Returns the radiance that the surface at a hit emits in a direction. `normal` is on the
    /// outside of the shape as the scene file defines it, not on the side of the ray.
    pub fn emitted_radiance(
        &self,
        ray: &Ray,
        hit: &Hit,
        normal: Vec3,
        direction: Vec3,
    ) -> [f32; 3] {
        let Some((light, _)) = self.emitter(hit) else { return [0.0; 3] };
        if !light.emission.two_sided && normal.dot(direction) <= 0.0 {
            return [0.0; 3];
        }
        let uv = match light.emission.image {
            Some(_) => self.surface_derivatives(ray, hit).uv,
            None => Vec2::ZERO,
        };
        light.radiance(hit.primitive, uv)
    }

    /// Returns the area light and the geometry of the shape at a hit.
    fn emitter(&self, hit: &Hit) -> Option<(&AreaLight, &Geometry)> {
        let shape = &self.shapes[hit.shape as usize];
        match self.lights.all.get(shape.light as usize)? {
            Light::Area(light) => Some((light, &shape.geometry)),
            _ => None,
        }
    }
}

/// Returns a point that receives light.
fn receiver(from: Vec3, reception: impl Into<Reception>) -> Receiver<f32> {
    Receiver { position: from.to_array(), reception: reception.into() }
}

/// Samples a direction about a unit normal with density cos / pi. Returns it and its cosine.
pub fn cosine_hemisphere(normal: Vec3, u: [f32; 2]) -> (Vec3, f32) {
    let [x, y] = petzval_base::sampler::concentric_disk(u[0], u[1]);
    let z = (1.0 - x * x - y * y).max(0.0).sqrt();
    let (tangent, bitangent) = normal.any_orthonormal_pair();
    (tangent * x + bitangent * y + normal * z, z)
}
