//! Point lights: isotropic, spot, goniometric, or projecting an image, as pbrt-v4 defines them.

use std::f32::consts::PI;
use std::sync::Arc;

use glam::{Mat3, Vec2, Vec3};

use super::tree::{Cone, LightBounds};
use super::{mean, uplifted};
use petzval_base::equal_area;
use petzval_image::Picture;
use petzval_spectrum::Colour;

/// A light at one position.
#[derive(Clone, Debug)]
pub struct PointLight {
    /// Position, world space.
    pub position: Vec3,
    /// World space to light space, in which the light points along +z.
    pub light_from_world: Mat3,
    /// Radiant intensity, or the factor of an image.
    pub intensity: Colour,
    /// Dependence of the intensity on direction.
    pub distribution: IntensityDistribution,
}

/// Dependence of the intensity of a point light on direction.
#[derive(Clone, Debug)]
pub enum IntensityDistribution {
    /// The same intensity in all directions.
    Isotropic,
    /// A cone with a soft edge.
    Spot {
        /// Cosines of the angles from the axis at which the light ends, and at which it begins to
        /// fade.
        cosines: [f32; 2],
    },
    /// The mean of the channels of a square image of all directions, in the equal-area mapping of
    /// Clarberg 2008, without interpolation between pixels.
    Goniometric(Arc<Picture>),
    /// An image projected through a pinhole, upright if y is up, without interpolation between
    /// pixels.
    Projection {
        /// Image.
        picture: Arc<Picture>,
        /// Matrix of its colours, if paths carry other channels than RGB.
        uplift: Option<[[f32; 3]; 3]>,
        /// Tangent of half the field of view along the shorter side.
        tangent: f32,
    },
}

/// Evaluates Hermite's cubic from 0 to 1 between two ends; a step if the ends coincide, as in
/// pbrt-v4.
fn smooth_step(x: f32, [zero, one]: [f32; 2]) -> f32 {
    if zero == one {
        return if x < zero { 0.0 } else { 1.0 };
    }
    let t = ((x - zero) / (one - zero)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Returns the pixel at a point of the unit square, without negative values.
fn pixel(picture: &Picture, uv: Vec2) -> [f32; 3] {
    let [width, height] = picture.size;
    let index = |c: f32, n: usize| ((c * n as f32) as usize).min(n - 1);
    picture.pixels[index(uv.y, height) * width + index(uv.x, width)].map(|c| c.max(0.0))
}

/// Returns half the width and half the height of a projected image in a plane at distance 1,
/// divided by the tangent of half the field of view.
fn half_size(picture: &Picture) -> Vec2 {
    let aspect = picture.size[0] as f32 / picture.size[1] as f32;
    if aspect > 1.0 { Vec2::new(aspect, 1.0) } else { Vec2::new(1.0, 1.0 / aspect) }
}

impl IntensityDistribution {
    /// Returns the factor of the intensity in a unit direction, light space.
    fn factor(&self, d: Vec3) -> [f32; 3] {
        match self {
            Self::Isotropic => [1.0; 3],
            Self::Spot { cosines } => [smooth_step(d.z, *cosines); 3],
            Self::Goniometric(picture) => [mean(pixel(picture, equal_area::from_sphere(d))); 3],
            Self::Projection { picture, uplift, tangent } => {
                let half = half_size(picture);
                let at = Vec2::new(d.x, -d.y) / (d.z * *tangent);
                // pbrt-v4 blocks directions this close to the plane of the pinhole.
                let passes = d.z >= 1e-3 && at.abs().cmple(half).all();
                match passes {
                    true => uplifted(pixel(picture, (at / half + 1.0) / 2.0), uplift),
                    false => [0.0; 3],
                }
            }
        }
    }

    /// Returns the integral of the factor over all directions (sr), by which pbrt-v4 scales a light
    /// to a requested power; for a projected image, the integral of its luminance.
    pub fn power(&self) -> f32 {
        match self {
            Self::Isotropic => 4.0 * PI,
            Self::Spot { cosines: [end, start] } => {
                2.0 * PI * ((1.0 - start) + (start - end) / 2.0)
            }
            Self::Goniometric(picture) => 4.0 * PI * average(picture, |_, _, pixel| mean(pixel)),
            Self::Projection { picture, tangent, .. } => {
                let half = half_size(picture) * *tangent;
                let [width, height] = picture.size.map(|n| n as f32);
                let seen = average(picture, |x, y, pixel| {
                    let at = Vec2::new((x as f32 + 0.5) / width, (y as f32 + 0.5) / height);
                    let plane = ((at * 2.0 - 1.0) * half).extend(1.0);
                    luminance(pixel) / plane.length().powi(3)
                });
                4.0 * half.x * half.y * seen
            }
        }
    }
}

/// Returns the luminance of a linear sRGB colour (ITU-R BT.709).
pub fn luminance([r, g, b]: [f32; 3]) -> f32 {
    0.212_64 * r + 0.715_17 * g + 0.072_19 * b
}

/// Returns the mean of a function of column, row and colour over all pixels.
fn average(picture: &Picture, f: impl Fn(usize, usize, [f32; 3]) -> f32) -> f32 {
    let width = picture.size[0];
    let pixels = picture.pixels.iter().enumerate();
    let sum: f64 = pixels.map(|(i, &pixel)| f64::from(f(i % width, i / width, pixel))).sum();
    (sum / picture.pixels.len() as f64) as f32
}

impl PointLight {
    /// Returns the intensity in a direction, world space.
    pub fn towards(&self, direction: Vec3) -> [f32; 3] {
        let factor = self.distribution.factor((self.light_from_world * direction).normalize());
        [0, 1, 2].map(|i| self.intensity.rgb[i] * factor[i])
    }

    /// Returns the light bounds, or `None` if the light emits nothing.
    pub(super) fn bounds(&self) -> Option<LightBounds> {
        let strength = mean(self.intensity.rgb.map(|i| i.max(0.0)));
        let axis = (self.light_from_world.inverse() * Vec3::Z).try_normalize();
        // A matrix that is not a rotation distorts the cone.
        let is_rotation = (self.light_from_world * self.light_from_world.transpose())
            .abs_diff_eq(Mat3::IDENTITY, 1e-4);
        let (factor, normals, cos_beyond) = match (&self.distribution, axis) {
            (IntensityDistribution::Isotropic, _) | (_, None) => (1.0, Cone::ALL, 0.0),
            (IntensityDistribution::Spot { cosines: [end, start] }, Some(axis)) => {
                let (end, start) = (end.clamp(-1.0, 1.0).acos(), start.clamp(-1.0, 1.0).acos());
                let fade = (end - start).clamp(1e-2, PI / 2.0);
                let angle = if is_rotation { (end - fade).max(start).max(0.0) } else { PI };
                (1.0, Cone { axis, angle }, fade.cos())
            }
            (IntensityDistribution::Goniometric(picture), _) => {
                (average(picture, |_, _, p| mean(p)), Cone::ALL, 0.0)
            }
            (IntensityDistribution::Projection { picture, tangent, .. }, Some(axis)) => {
                let corner = (half_size(picture).length() * tangent).atan();
                let angle = if is_rotation { corner } else { PI };
                (average(picture, |_, _, p| mean(p)), Cone { axis, angle }, 0.999)
            }
        };
        let intensity = strength * factor;
        let emits = intensity > 0.0 && intensity.is_finite();
        emits.then_some(LightBounds {
            low: self.position,
            high: self.position,
            normals,
            cos_emission: cos_beyond,
            intensity,
            two_sided: false,
        })
    }
}
