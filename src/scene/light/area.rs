//! Shapes that shine: what they send out, and how points on them are chosen.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

use super::ball::Ball;
use super::bounds::Bounds;
use super::cone::Cone;
use super::spherical::SphericalTriangle;
use super::{LightSample, mean};
use crate::rays::Hit;
use crate::scene::point::SurfacePoint;
use crate::scene::texture::{ImageMap, TexturePoint};
use crate::scene::{Geometry, Mesh, Quadric, Shape};

/// What a shape sends out, as the scene file says it.
#[derive(Clone, Debug)]
pub struct Emission {
    /// Radiance, linear RGB, or what an image is multiplied by.
    pub radiance: [f32; 3],
    /// Whether it shines from both sides.
    pub two_sided: bool,
    /// Radiance by texture coordinates.
    pub image: Option<ImageMap>,
    /// Whether the radiance is that of a surface of area 1, and every triangle (as pbrt-v4 has
    /// it), or the quadric, is as strong as that.
    pub by_area: bool,
}

impl Emission {
    /// The same radiance everywhere, from one side.
    pub fn uniform(radiance: [f32; 3]) -> Self {
        Self { radiance, two_sided: false, image: None, by_area: false }
    }
}

/// A shape that shines.
#[derive(Clone, Debug)]
pub struct AreaLight {
    /// Which shape of the scene it is.
    pub shape: u32,
    /// What it sends out.
    pub emission: Emission,
    /// The number of its first triangle, or of the quadric, among the emitters of the scene.
    pub(super) first: u32,
    /// Mean of the image, by channel.
    mean: [f32; 3],
    /// The sphere that it is, if it is a whole one.
    ball: Option<Ball>,
}

/// A place on an emitter, and the density with which it was chosen.
struct Place {
    point: SurfacePoint,
    uv: Vec2,
    density: Density,
}

/// Per unit of what.
enum Density {
    Area(f32),
    SolidAngle(f32),
}

impl AreaLight {
    /// The light of a shape.
    pub fn new(shape: u32, mut emission: Emission, geometry: &Geometry) -> Self {
        if let (Geometry::Quadric(quadric), true) = (geometry, emission.by_area) {
            emission.radiance = emission.radiance.map(|r| r / quadric.area() as f32);
            emission.by_area = false;
        }
        let mean = emission.image.as_ref().map_or([1.0; 3], image_mean);
        let ball = match geometry {
            Geometry::Quadric(quadric) => quadric.ball(),
            Geometry::Mesh(_) => None,
        };
        Self { shape, emission, first: 0, mean, ball }
    }

    /// How many emitters it is made of.
    pub(super) fn parts(&self, geometry: &Geometry) -> usize {
        match geometry {
            Geometry::Mesh(mesh) => mesh.triangles.len(),
            Geometry::Quadric(_) => 1,
        }
    }

    /// The radiance that leaves a place of a part to where it shines.
    pub(super) fn radiance(&self, geometry: &Geometry, part: u32, uv: Vec2) -> [f32; 3] {
        let emission = &self.emission;
        let mut radiance = emission.radiance;
        if let Some(image) = &emission.image {
            let texel = image.at(uv);
            radiance = [0, 1, 2].map(|i| radiance[i] * texel[i].max(0.0));
        }
        match geometry {
            Geometry::Mesh(mesh) if emission.by_area => {
                // No ray lights anything by a triangle whose area rounds to 0.
                let area = mesh.area(part);
                if area > 0.0 { radiance.map(|r| r / area) } else { [0.0; 3] }
            }
            _ => radiance,
        }
    }

    /// What the tree knows of a part; `None` where it never sends anything.
    pub(super) fn bounds(&self, geometry: &Geometry, part: u32) -> Option<Bounds> {
        let strength = mean(self.emission.radiance.map(|r| r.max(0.0))) * mean(self.mean);
        let (low, high, area, normals) = match geometry {
            Geometry::Mesh(mesh) => {
                let [a, b, c] = mesh.corners(part);
                let area = mesh.area(part);
                let weights = 1.0 / 3.0;
                let middle = Hit { u: weights, v: weights, primitive: part, ..Hit::MISS };
                let axis = mesh.point(&middle).normal;
                let flat = axis.try_normalize()?;
                // Interpolated shading normals may choose another side at other points.
                let normals = if mesh.normals.is_empty() || self.emission.two_sided {
                    Cone::along(flat)
                } else {
                    mesh_sides(mesh, part, flat)
                };
                (a.min(b).min(c), a.max(b).max(c), f64::from(area), normals)
            }
            Geometry::Quadric(quadric) => {
                let [low, high] = quadric.bounds().map(|corner| corner.as_vec3());
                let area = quadric.area();
                match quadric.flat_normal() {
                    Some(normal) => (low, high, area, Cone::along(normal.as_vec3())),
                    // The mean projected area of a convex body is a quarter of its surface.
                    None => (low, high, area / 4.0, Cone::ALL),
                }
            }
        };
        let area = if self.emission.by_area { 1.0 } else { area };
        let intensity = (f64::from(strength) * area) as f32;
        let seen = intensity > 0.0 && intensity.is_finite();
        let two_sided = self.emission.two_sided;
        seen.then_some(Bounds { low, high, normals, cos_beyond: 0.0, intensity, two_sided })
    }

    /// Chooses a point of a part for a point of a surface; the density is by solid angle and
    /// without the probability of the part.
    pub(super) fn sample(
        &self,
        shape: &Shape,
        part: u32,
        from: &SurfacePoint,
        u: [f32; 2],
    ) -> Option<LightSample> {
        let geometry = &shape.geometry;
        let textured = self.emission.image.is_some() || !shape.opaque();
        let Place { point, uv, density } = match geometry {
            Geometry::Mesh(mesh) => self.triangle(mesh, part, from.position, u, textured)?,
            Geometry::Quadric(quadric) => self.quadric(quadric, from.position, u, textured),
        };
        let SurfacePoint { position, normal, .. } = point;
        let shining = shape.shining(&TexturePoint { uv, position, normal, footprint: 0.0 });
        let start = from.leave(point.position - from.position);
        let end = point.leave(start - point.position);
        let direction = end - start;
        let d2 = direction.length_squared();
        let cos = -point.normal.dot(direction) / d2.sqrt();
        let cos = if self.emission.two_sided { cos.abs() } else { cos };
        let density = match density {
            Density::SolidAngle(density) => density,
            Density::Area(density) => density * d2 / cos,
        };
        let usable = cos * shining > 0.0 && d2 > 0.0 && density > 0.0 && density.is_finite();
        usable.then(|| LightSample {
            direction,
            t_max: 1.0,
            radiance: self.radiance(geometry, part, uv).map(|r| r * shining),
            density,
            singular: false,
        })
    }

    fn triangle(
        &self,
        mesh: &Mesh,
        part: u32,
        from: Vec3,
        u: [f32; 2],
        textured: bool,
    ) -> Option<Place> {
        let (hit, density) = match SphericalTriangle::seen(mesh.corners(part), from) {
            Some(seen) => {
                let [v, w] = seen.sample(u)?;
                let hit = Hit { t: 0.0, u: v, v: w, primitive: part, ..Hit::MISS };
                (hit, Density::SolidAngle((1.0 / seen.solid_angle) as f32))
            }
            None => (mesh.sample(part, u), Density::Area(1.0 / mesh.area(part))),
        };
        let uv = if textured { mesh.patch(&hit).uv } else { Vec2::ZERO };
        Some(Place { point: mesh.point(&hit), uv, density })
    }

    fn quadric(&self, quadric: &Quadric, from: Vec3, u: [f32; 2], textured: bool) -> Place {
        let (point, density) = match self.ball.and_then(|ball| ball.seen(from)) {
            Some(disc) => (disc.sample(u), Density::SolidAngle(disc.density())),
            None => {
                let (point, density) = quadric.sample(u);
                (point, Density::Area(density))
            }
        };
        let uv = match textured {
            true => quadric.patch(point.position.as_dvec3()).uv,
            false => Vec2::ZERO,
        };
        Place { point, uv, density }
    }

    /// The density by solid angle with which [`Self::sample`] chooses a point of a part.
    pub(super) fn density(
        &self,
        geometry: &Geometry,
        part: u32,
        from: Vec3,
        point: &SurfacePoint,
        direction: Vec3,
    ) -> f32 {
        let density = match geometry {
            Geometry::Mesh(mesh) => match SphericalTriangle::seen(mesh.corners(part), from) {
                Some(seen) => return (1.0 / seen.solid_angle) as f32,
                None => 1.0 / mesh.area(part),
            },
            Geometry::Quadric(quadric) => match self.ball.and_then(|ball| ball.seen(from)) {
                Some(disc) => return disc.density(),
                None => quadric.density(point.position.as_dvec3()),
            },
        };
        let d2 = (point.position - from).length_squared();
        let density = density * d2 / point.normal.dot(direction).abs();
        if density.is_finite() { density } else { 0.0 }
    }
}

/// The sides on which a triangle with shading normals shines: both, where they disagree.
fn mesh_sides(mesh: &Mesh, part: u32, flat: Vec3) -> Cone {
    let corners = mesh.triangles[part as usize];
    let agree = corners.iter().all(|&i| Vec3::from(mesh.normals[i as usize]).dot(flat) > 0.0);
    if agree { Cone::along(flat) } else { Cone { axis: flat, angle: PI } }
}

fn image_mean(image: &ImageMap) -> [f32; 3] {
    let mut sum = [0.0; 3];
    for pixel in &image.picture.pixels {
        for (sum, value) in sum.iter_mut().zip(pixel) {
            *sum += f64::from(value.max(0.0));
        }
    }
    sum.map(|sum| (sum / image.picture.pixels.len() as f64) as f32)
}
