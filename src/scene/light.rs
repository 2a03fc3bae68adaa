//! Lights, and the choice among them.

use std::f32::consts::PI;

use glam::{Mat3, Vec2, Vec3};

use super::point::SurfacePoint;
use super::texture::ImageMap;
use super::{Geometry, Scene, Shape};
use crate::rays::Hit;

/// Something that emits. Radiances are linear RGB in the units of the scene file.
#[derive(Clone, Debug)]
pub enum Light {
    /// A shape that shines.
    Area(AreaLight),
    /// A point; radiant intensity.
    Point {
        /// Where it is, world space.
        position: Vec3,
        /// Intensity.
        intensity: [f32; 3],
    },
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

/// A shape that shines.
#[derive(Clone, Debug)]
pub struct AreaLight {
    /// Which shape of the scene it is.
    pub shape: u32,
    /// Emitted radiance.
    pub radiance: [f32; 3],
    /// Whether it shines from both sides.
    pub two_sided: bool,
    /// Cumulated areas of the triangles of a mesh, ending in the whole; empty for a quadric.
    pub areas: Vec<f32>,
}

/// Radiance that comes from infinitely far away.
#[derive(Clone, Debug)]
pub struct Sky {
    /// Radiance, or what an image is multiplied by.
    pub radiance: [f32; 3],
    /// An image of all directions.
    pub image: Option<SkyImage>,
}

/// An image of all directions.
#[derive(Clone, Debug)]
pub struct SkyImage {
    /// The pixels.
    pub map: ImageMap,
    /// World space to the light's own.
    pub light_from_world: Mat3,
    /// How the image is laid out.
    pub layout: SkyLayout,
}

/// How an image holds all directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SkyLayout {
    /// Longitude and latitude, twice as wide as high (pbrt-v2).
    Equirectangular,
    /// The square of Clarberg 2008, "Fast equal-area mapping of the (hemi)sphere" (pbrt-v4).
    EqualArea,
}

impl Sky {
    /// The radiance from a direction (unit, world space, away from the scene).
    pub fn radiance(&self, direction: Vec3) -> [f32; 3] {
        let Some(image) = &self.image else { return self.radiance };
        let d = (image.light_from_world * direction).normalize();
        let uv = match image.layout {
            SkyLayout::Equirectangular => {
                let phi = d.y.atan2(d.x);
                let phi = if phi < 0.0 { phi + 2.0 * PI } else { phi };
                Vec2::new(phi / (2.0 * PI), d.z.clamp(-1.0, 1.0).acos() / PI)
            }
            SkyLayout::EqualArea => equal_area_square(d),
        };
        let texel = image.map.at(uv);
        [0, 1, 2].map(|i| texel[i] * self.radiance[i])
    }
}

/// The point of the unit square for a direction (Clarberg 2008).
fn equal_area_square(d: Vec3) -> Vec2 {
    let r = (1.0 - d.z.abs()).max(0.0).sqrt();
    let (x, y) = (d.x.abs(), d.y.abs());
    let phi = if x.max(y) == 0.0 { 0.0 } else { y.atan2(x) * 2.0 / PI };
    let (mut u, mut v) = (r - phi * r, phi * r);
    if d.z < 0.0 {
        (u, v) = (1.0 - v, 1.0 - u);
    }
    Vec2::new((u.copysign(d.x) + 1.0) / 2.0, (v.copysign(d.y) + 1.0) / 2.0)
}

/// All lights of a scene and the probability with which each is sampled.
#[derive(Clone, Debug, Default)]
pub struct Lights {
    /// The lights.
    pub all: Vec<Light>,
    /// Those among them that fill the sky.
    pub skies: Vec<u32>,
    /// Cumulated probabilities, ending in 1; empty where no light has any power.
    cumulated: Vec<f32>,
}

/// The power of a light at a finite place, W for radiances in W / (m^2 sr).
fn power(light: &Light, shapes: &[Shape]) -> f64 {
    let mean = |c: [f32; 3]| f64::from((c[0] + c[1] + c[2]) / 3.0);
    match light {
        Light::Area(light) => {
            let area = match &shapes[light.shape as usize].geometry {
                Geometry::Mesh(_) => f64::from(light.areas.last().copied().unwrap_or(0.0)),
                Geometry::Quadric(quadric) => quadric.area(),
            };
            let sides = if light.two_sided { 2.0 } else { 1.0 };
            sides * std::f64::consts::PI * area * mean(light.radiance)
        }
        Light::Point { intensity, .. } => 4.0 * std::f64::consts::PI * mean(*intensity),
        Light::Distant { .. } | Light::Infinite(_) => 0.0,
    }
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
    /// Whether the light is at one point or in one direction, which no other ray runs into.
    pub singular: bool,
}

impl Lights {
    /// Weighs the lights. Each that is infinitely far away gets as much as all that are near
    /// together: which power a sky has depends on how much empty ground the scene holds. Near
    /// lights share by their power.
    pub fn new(all: Vec<Light>, shapes: &[Shape]) -> Self {
        let far = |light: &Light| matches!(light, Light::Distant { .. } | Light::Infinite(_));
        let near = all.iter().filter(|light| !far(light));
        let near: f64 = near.map(|light| power(light, shapes)).sum();
        let groups = all.iter().filter(|light| far(light)).count() + usize::from(near > 0.0);
        let mut sum = 0.0;
        let mut cumulated: Vec<f32> = all
            .iter()
            .map(|light| {
                let share = if far(light) { 1.0 } else { power(light, shapes) / near };
                // Lights of no power are never chosen, not even where there is nothing else.
                sum += if share.is_nan() { 0.0 } else { share / groups as f64 };
                sum as f32
            })
            .collect();
        // Rounding must leave no gap at the end.
        let whole = cumulated.last().copied().unwrap_or(0.0);
        cumulated.iter_mut().filter(|c| **c == whole).for_each(|c| *c = 1.0);
        if groups == 0 {
            cumulated.clear();
        }
        let skies = (0..all.len() as u32)
            .filter(|&i| matches!(all[i as usize], Light::Infinite(_)))
            .collect();
        Self { all, skies, cumulated }
    }

    /// Chooses a light: which, and with what probability.
    pub fn choose(&self, u: f32) -> Option<(u32, f32)> {
        let i = self.cumulated.partition_point(|&c| c <= u);
        let last = self.cumulated.len().checked_sub(1)?;
        let i = i.min(last);
        let before = if i == 0 { 0.0 } else { self.cumulated[i - 1] };
        Some((i as u32, self.cumulated[i] - before))
    }

    /// With what probability [`Self::choose`] chooses a light.
    pub fn probability(&self, light: u32) -> f32 {
        let at = |i: usize| self.cumulated.get(i).copied().unwrap_or(0.0);
        let i = light as usize;
        at(i) - if i == 0 { 0.0 } else { at(i - 1) }
    }
}

/// A direction by equal shares of the sphere.
fn sphere(u: [f32; 2]) -> Vec3 {
    let z = 1.0 - 2.0 * u[0];
    let (sin, cos) = (2.0 * PI * u[1]).sin_cos();
    let r = (1.0 - z * z).max(0.0).sqrt();
    Vec3::new(r * cos, r * sin, z)
}

impl Scene {
    /// Chooses a light, and a point of it, for a point of a surface: `choice` decides which
    /// light and which part of it, `u` where. `None` where it cannot contribute.
    pub fn sample_light(
        &self,
        from: &SurfacePoint,
        choice: [f32; 2],
        u: [f32; 2],
    ) -> Option<LightSample> {
        let (light, probability) = self.lights.choose(choice[0])?;
        match &self.lights.all[light as usize] {
            Light::Area(area) => {
                let sample = self.sample_area(area, from, u, choice[1])?;
                Some(LightSample { density: sample.density * probability, ..sample })
            }
            Light::Point { position, intensity } => {
                let direction = *position - from.leave(*position - from.position);
                let d2 = direction.length_squared();
                Some(LightSample {
                    direction,
                    t_max: 1.0,
                    radiance: intensity.map(|i| i / d2),
                    density: probability,
                    singular: true,
                })
            }
            Light::Distant { towards, irradiance } => Some(LightSample {
                direction: *towards,
                t_max: f32::INFINITY,
                radiance: *irradiance,
                density: probability,
                singular: true,
            }),
            Light::Infinite(sky) => {
                let direction = sphere(u);
                Some(LightSample {
                    direction,
                    t_max: f32::INFINITY,
                    radiance: sky.radiance(direction),
                    density: probability / (4.0 * PI),
                    singular: false,
                })
            }
        }
    }

    /// The density with which [`Self::sample_light`] chooses, from a point, the direction in
    /// which a ray ran into a surface that shines. `point` is where, `direction` of unit length.
    pub fn emitter_density(
        &self,
        from: Vec3,
        hit: &Hit,
        point: &SurfacePoint,
        direction: Vec3,
    ) -> f32 {
        let light = self.shapes[hit.shape as usize].light;
        let Light::Area(area) = &self.lights.all[light as usize] else { return 0.0 };
        let cos = point.normal.dot(direction).abs();
        let d2 = (point.position - from).length_squared();
        let area = match area.areas.last() {
            Some(&area) => f64::from(area),
            None => 1.0,
        } as f32;
        self.lights.probability(light) * d2 / (cos * area)
    }

    /// The density with which [`Self::sample_light`] chooses a direction of the sky.
    pub fn sky_density(&self, _from: Vec3, sky: u32, _direction: Vec3) -> f32 {
        self.lights.probability(sky) / (4.0 * PI)
    }

    fn sample_area(
        &self,
        area: &AreaLight,
        from: &SurfacePoint,
        u: [f32; 2],
        u_triangle: f32,
    ) -> Option<LightSample> {
        let (point, density) = match &self.shapes[area.shape as usize].geometry {
            Geometry::Quadric(quadric) => quadric.sample(u),
            Geometry::Mesh(mesh) => {
                let whole = *area.areas.last()?;
                let triangle = area.areas.partition_point(|&a| a <= u_triangle * whole);
                let triangle = triangle.min(area.areas.len() - 1) as u32;
                (mesh.sample(triangle, u), 1.0 / whole)
            }
        };
        let start = from.leave(point.position - from.position);
        let end = point.leave(start - point.position);
        let direction = end - start;
        let d2 = direction.length_squared();
        let cos = -point.normal.dot(direction) / d2.sqrt();
        let cos = if area.two_sided { cos.abs() } else { cos };
        (cos > 0.0 && d2 > 0.0).then_some(LightSample {
            direction,
            t_max: 1.0,
            radiance: area.radiance,
            density: density * d2 / cos,
            singular: false,
        })
    }

    /// The radiance of a light that fills the sky, from a direction.
    pub fn sky_radiance(&self, light: u32, direction: Vec3) -> [f32; 3] {
        match &self.lights.all[light as usize] {
            Light::Infinite(sky) => sky.radiance(direction),
            _ => [0.0; 3],
        }
    }

    /// What a surface sends out by itself in a direction.
    pub fn emitted(&self, light: u32, normal: Vec3, direction: Vec3) -> [f32; 3] {
        match &self.lights.all[light as usize] {
            Light::Area(area) if area.two_sided || normal.dot(direction) > 0.0 => area.radiance,
            _ => [0.0; 3],
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
