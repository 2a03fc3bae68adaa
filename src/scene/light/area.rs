//! Area lights: the emission of shapes.

use std::f32::consts::PI;
use std::sync::Arc;

use glam::{Vec2, Vec3};

use super::tree::{Cone, LightBounds};
use super::visible_cap::SpherePacket;
use super::{mean, uplifted};
use crate::geometry::DiskPacket;
use crate::texture::ImageMap;
use crate::{Geometry, Mesh};
use petzval_base::rays::Hit;
use petzval_spectrum::Colour;

/// Emission of a shape, as the scene file describes it.
#[derive(Clone, Debug)]
pub struct Emission {
    /// Radiance, or the factor of an image.
    pub radiance: Colour,
    /// Whether both sides emit.
    pub two_sided: bool,
    /// Image of the radiance over the texture coordinates.
    pub image: Option<Arc<ImageMap>>,
    /// Matrix of the colours of the image, if paths carry other channels than RGB.
    pub uplift: Option<[[f32; 3]; 3]>,
    /// Whether the radiance is divided by the area of each triangle, bilinear patch or quadric, so
    /// that each emits as much as a surface of area 1 (as in pbrt-v4).
    pub normalize_by_area: bool,
}

impl Emission {
    /// Returns a constant radiance on the outside.
    pub fn uniform(radiance: impl Into<Colour>) -> Self {
        Self {
            radiance: radiance.into(),
            two_sided: false,
            image: None,
            uplift: None,
            normalize_by_area: false,
        }
    }
}

/// A shape that emits light.
#[derive(Clone, Debug)]
pub struct AreaLight {
    /// Index of the shape.
    pub shape: u32,
    /// Emission.
    pub emission: Emission,
    /// Index of its first triangle, or of the quadric, among the emitters of the scene.
    pub(super) first_emitter: u32,
    /// Area that the radiance of each triangle is divided by; empty without normalization.
    emitter_areas: Arc<[f32]>,
    /// Mean of the image by channel; 1 without an image.
    mean: [f32; 3],
    /// The sphere, if the shape is a whole one.
    pub(super) sphere: Option<SpherePacket<f32>>,
    /// The disk, if the shape is a whole one.
    pub(super) disk: Option<DiskPacket<f32>>,
}

impl AreaLight {
    /// Makes the light of a shape.
    pub fn new(shape: u32, mut emission: Emission, geometry: &Geometry) -> Self {
        if let (Geometry::Quadric(quadric), true) = (geometry, emission.normalize_by_area) {
            emission.radiance = emission.radiance.divided(quadric.area() as f32);
            emission.normalize_by_area = false;
        }
        let emitter_areas = match geometry {
            Geometry::Mesh(mesh) if emission.normalize_by_area => mesh.patch_areas().into(),
            _ => [].into(),
        };
        let mean = emission.image.as_deref().map_or([1.0; 3], image_mean);
        let (sphere, disk) = match geometry {
            Geometry::Quadric(quadric) => (quadric.whole_sphere(), quadric.whole_disk()),
            Geometry::Mesh(_) | Geometry::Patches(_) | Geometry::Curves(_) => (None, None),
        };
        let sphere = sphere.as_ref().map(SpherePacket::from);
        Self { shape, emission, first_emitter: 0, emitter_areas, mean, sphere, disk }
    }

    /// Returns the number of emitters: its triangles, or 1 for a quadric. `SceneBuilder::add_shape`
    /// turns patches and curves that emit into triangles.
    pub(super) fn emitter_count(&self, geometry: &Geometry) -> usize {
        match geometry {
            Geometry::Mesh(mesh) => mesh.triangles.len(),
            Geometry::Patches(_) | Geometry::Curves(_) => 0,
            Geometry::Quadric(_) => 1,
        }
    }

    /// Returns the radiance that a point of a primitive emits.
    pub(super) fn radiance(&self, primitive: u32, uv: Vec2) -> [f32; 3] {
        let emission = &self.emission;
        let mut radiance = emission.radiance.rgb;
        if let Some(image) = &emission.image {
            let texel = uplifted(image.colour(uv).map(|c| c.max(0.0)), &emission.uplift);
            radiance = [0, 1, 2].map(|i| radiance[i] * texel[i]);
        }
        match self.emitter_areas.get(primitive as usize) {
            Some(&area) if area > 0.0 => radiance.map(|r| r / area),
            // A triangle whose area rounds to 0 lights nothing.
            Some(_) => [0.0; 3],
            None => radiance,
        }
    }

    /// Returns the light bounds of a primitive, or `None` if it emits nothing.
    pub(super) fn bounds(&self, geometry: &Geometry, primitive: u32) -> Option<LightBounds> {
        let strength = mean(self.emission.radiance.rgb.map(|r| r.max(0.0))) * mean(self.mean);
        let (low, high, area, normals) = match geometry {
            Geometry::Mesh(mesh) => {
                let [a, b, c] = mesh.corners(primitive);
                let area = mesh.area(primitive);
                let weights = 1.0 / 3.0;
                let middle = Hit { u: weights, v: weights, primitive, ..Hit::MISS };
                let axis = mesh.point(&middle).normal;
                let flat = axis.try_normalize()?;
                // Interpolated shading normals may select the other side at other points.
                let normals = if mesh.normals.is_empty() || self.emission.two_sided {
                    Cone::from_direction(flat)
                } else {
                    normal_cone(mesh, primitive, flat)
                };
                (a.min(b).min(c), a.max(b).max(c), f64::from(area), normals)
            }
            Geometry::Patches(_) | Geometry::Curves(_) => return None,
            Geometry::Quadric(quadric) => {
                let [low, high] = quadric.bounds().map(|corner| corner.as_vec3());
                let area = quadric.area();
                match quadric.flat_normal() {
                    Some(normal) => (low, high, area, Cone::from_direction(normal.as_vec3())),
                    // The mean projected area of a convex body is a quarter of its surface.
                    None => (low, high, area / 4.0, Cone::ALL),
                }
            }
        };
        let area = match self.emitter_areas.get(primitive as usize) {
            Some(&spread) if spread > 0.0 => area / f64::from(spread),
            Some(_) => 0.0,
            None => area,
        };
        let intensity = (f64::from(strength) * area) as f32;
        let seen = intensity > 0.0 && intensity.is_finite();
        let two_sided = self.emission.two_sided;
        seen.then_some(LightBounds { low, high, normals, cos_emission: 0.0, intensity, two_sided })
    }
}

/// Returns the cone of directions into which a triangle with shading normals may emit: about the
/// geometric normal, or all directions if a shading normal is on the other side.
fn normal_cone(mesh: &Mesh, primitive: u32, flat: Vec3) -> Cone {
    let corners = mesh.triangles[primitive as usize];
    let agree = corners.iter().all(|&i| Vec3::from(mesh.normals[i as usize]).dot(flat) > 0.0);
    if agree { Cone::from_direction(flat) } else { Cone { axis: flat, angle: PI } }
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
