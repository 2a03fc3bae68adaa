//! Shading: what the surfaces that rays met send towards the film.
//!
//! Light is gathered by sampling the lights at every vertex of a path (next-event
//! estimation); a path that runs into a light by itself counts it only when it comes straight
//! from the camera.

mod dice;

pub use dice::Dice;

use glam::Vec3;

use crate::rays::{Column, Hit, HitBatch, NONE, Ray, RayBatch, SampleBatch};
use crate::scene::{
    Scatters, Scene, Shape, SurfacePoint, Texture, TexturePoint, cosine_hemisphere,
};
use dice::Throw;

/// Which part of a path a shading stage works on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Vertex {
    /// Surfaces that the path has met before.
    pub depth: u32,
    /// Whether the path ends here.
    pub last: bool,
    /// Whether lights are sampled here.
    pub lit: bool,
}

/// Shades the hits of a wave: a stage. Emission goes into `radiance`, what a light would add if
/// nothing were in its way into `shadows`, and the path's next step into `next`.
#[expect(clippy::too_many_arguments, reason = "a stage names every column that it touches")]
pub fn shade(
    scene: &Scene,
    vertex: Vertex,
    rays: &RayBatch,
    hits: &HitBatch,
    samples: &SampleBatch,
    dice: &mut Dice,
    radiance: &mut [Column<f32>; 3],
    shadows: &mut RayBatch,
    next: &mut RayBatch,
) {
    shadows.len = 0;
    next.len = 0;
    dice.throw(vertex, rays, samples);
    for i in 0..rays.len {
        let ray = rays.ray(i);
        let throughput = rays.carried(i);
        let slot = rays.slot[i];
        let direction = Vec3::from(ray.direction);
        let mut receive = |light: [f32; 3]| {
            for channel in 0..3 {
                radiance[channel][slot as usize] += throughput[channel] * light[channel];
            }
        };
        if hits[i].shape == NONE {
            if vertex.depth == 0 {
                for &sky in &scene.lights.skies {
                    receive(scene.sky_radiance(sky, direction));
                }
            }
            continue;
        }
        let (shape, mut point) = scene.surface(&ray, &hits[i]);
        if vertex.depth == 0 && shape.light != NONE {
            receive(scene.emitted(shape.light, point.normal, -direction));
        }
        // Surfaces are two-sided: both normals turn to where the ray came from.
        point.normal = facing(point.normal, -direction);
        point.shading = facing(point.shading, -direction);
        let reflectance = reflectance(scene, shape, &point, &ray, &hits[i]);
        let throughput = [0, 1, 2].map(|c| throughput[c] * reflectance[c]);
        if throughput.iter().all(|&t| t <= 0.0) {
            continue;
        }
        let path =
            Path { scene, point: &point, throughput, dice: &dice.at(i), depth: vertex.depth };
        if vertex.lit
            && let Some((ray, light)) = path.light()
        {
            shadows.push(ray, light, slot);
        }
        if !vertex.last
            && let Some((ray, throughput)) = path.bounce()
        {
            next.push(ray, throughput, slot);
        }
    }
}

/// The share of light that the surface at a hit sends back.
fn reflectance(
    scene: &Scene,
    shape: &Shape,
    point: &SurfacePoint,
    ray: &Ray,
    hit: &Hit,
) -> [f32; 3] {
    match &scene.materials[shape.material as usize].scatters {
        Scatters::Diffuse { reflectance: Texture::Constant(colour) } => *colour,
        Scatters::Diffuse { reflectance } => {
            let uv = scene.patch(ray, hit).uv;
            let SurfacePoint { position, normal, .. } = *point;
            reflectance.at(&TexturePoint { uv, position, normal, footprint: 0.0 })
        }
        _ => [0.5; 3],
    }
}

fn facing(normal: Vec3, towards: Vec3) -> Vec3 {
    if normal.dot(towards) < 0.0 { -normal } else { normal }
}

/// A path at a diffuse surface; the throughput already holds its reflectance.
struct Path<'a> {
    scene: &'a Scene,
    point: &'a SurfacePoint,
    throughput: [f32; 3],
    dice: &'a Throw,
    depth: u32,
}

impl Path<'_> {
    /// A shadow ray to a light, and what it brings to the film if nothing is in its way.
    fn light(&self) -> Option<(Ray, [f32; 3])> {
        let point = self.point;
        let sample = self.scene.sample_light(point, self.dice.choice, self.dice.light)?;
        let towards = sample.direction.normalize();
        let cos = point.shading.dot(towards);
        if cos <= 0.0 || point.normal.dot(towards) <= 0.0 {
            return None;
        }
        let weight = cos / (std::f32::consts::PI * sample.density);
        let carried = [0, 1, 2].map(|c| self.throughput[c] * sample.radiance[c] * weight);
        let origin = point.leave(sample.direction);
        let ray = Ray {
            origin: origin.to_array(),
            direction: sample.direction.to_array(),
            t_max: sample.t_max,
        };
        carried.iter().any(|&c| c > 0.0).then_some((ray, carried))
    }

    /// The next ray of the path and its throughput, if the path goes on.
    fn bounce(&self) -> Option<(Ray, [f32; 3])> {
        let mut throughput = self.throughput;
        if self.depth >= 2 {
            // Russian roulette by how much reflectance the path has left.
            let survives = throughput.iter().fold(0.0f32, |a, &b| a.max(b)).min(0.95);
            if self.dice.roulette >= survives {
                return None;
            }
            throughput = throughput.map(|t| t / survives);
        }
        let (direction, _) = cosine_hemisphere(self.point.shading, self.dice.bounce);
        if self.point.normal.dot(direction) <= 0.0 {
            return None;
        }
        let origin = self.point.leave(direction);
        let ray = Ray {
            origin: origin.to_array(),
            direction: direction.normalize().to_array(),
            t_max: f32::INFINITY,
        };
        Some((ray, throughput))
    }
}
