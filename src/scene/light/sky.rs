//! Light from infinitely far away in all directions: uniform, or from an image.

use std::f32::consts::PI;
use std::sync::Arc;

use glam::{Mat3, Vec2, Vec3};

use super::point::luminance;
use super::{mean, uplifted};
use crate::texture::ImageMap;
use petzval_base::distribution::Distribution;
use petzval_base::equal_area;
use petzval_spectrum::Colour;

/// A light at infinite distance in all directions.
#[derive(Clone, Debug)]
pub struct Sky {
    /// Radiance, or the factor of an image.
    pub radiance: Colour,
    /// Image of all directions; `None` for a uniform sky.
    pub image: Option<Arc<SkyImage>>,
    /// Matrix of the colours of the image, if paths carry other channels than RGB.
    pub uplift: Option<[[f32; 3]; 3]>,
}

/// Image of all directions, with the distribution that samples it.
#[derive(Clone, Debug)]
pub struct SkyImage {
    map: ImageMap,
    light_from_world: Mat3,
    world_from_light: Mat3,
    layout: SkyLayout,
    /// Distribution over the pixels by brightness; `None` if all are black.
    complete: Option<Distribution>,
    /// Distribution over the pixels by what their brightness has over the mean; `None` if all are
    /// the same, and then the complete one serves.
    compensated: Option<Distribution>,
}

/// Choice of the directions of a sky that are sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SkySampling {
    /// In proportion to brightness: every direction that has light is found.
    Complete,
    /// In proportion to what the brightness has over its mean. Directions darker than the mean are
    /// left to BSDF sampling, with multiple importance sampling of both (Karlik et al. 2019, "MIS
    /// compensation: optimizing sampling techniques in multiple importance sampling").
    Compensated,
}

/// Mapping of all directions onto an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SkyLayout {
    /// Longitude and latitude (pbrt-v2), with interpolation between pixels.
    Equirectangular,
    /// Equal-area mapping to a square (pbrt-v4; Clarberg 2008, "Fast equal-area mapping of the
    /// (hemi)sphere"), without interpolation between pixels.
    EqualArea,
}

/// A sampled direction of a sky.
#[derive(Clone, Copy, Debug)]
pub(super) struct SkySample {
    /// Unit vector, world space.
    pub(super) direction: Vec3,
    pub(super) radiance: [f32; 3],
    /// Probability density [1/sr].
    pub(super) density: f32,
}

impl SkyLayout {
    fn to_uv(self, d: Vec3) -> Vec2 {
        match self {
            Self::Equirectangular => {
                let phi = d.y.atan2(d.x);
                let phi = if phi < 0.0 { phi + 2.0 * PI } else { phi };
                Vec2::new(phi / (2.0 * PI), d.x.hypot(d.y).atan2(d.z) / PI)
            }
            Self::EqualArea => equal_area::from_sphere(d),
        }
    }

    fn to_direction(self, uv: Vec2) -> Vec3 {
        match self {
            Self::Equirectangular => {
                let (sin_phi, cos_phi) = (uv.x * 2.0 * PI).sin_cos();
                let (sin, cos) = (uv.y * PI).sin_cos();
                Vec3::new(sin * cos_phi, sin * sin_phi, cos)
            }
            Self::EqualArea => equal_area::to_sphere(uv),
        }
    }

    /// Returns the brightness of a pixel as [`SkyImage::at`] interpolates it, on average over the
    /// pixel.
    fn brightness(self, map: &ImageMap, x: usize, y: usize) -> f64 {
        let size = map.picture.size;
        let bright = |x: usize, y: usize| {
            f64::from(mean(map.picture.pixels[y * size[0] + x].map(|c| c.max(0.0))))
        };
        if self == Self::EqualArea {
            return bright(x, y);
        }
        let near = |i: usize, n: usize| [i.saturating_sub(1), i, (i + 1).min(n - 1)];
        let weights = [0.125, 0.75, 0.125];
        let mut sum = 0.0;
        for (y, wy) in near(y, size[1]).into_iter().zip(weights) {
            for (x, wx) in near(x, size[0]).into_iter().zip(weights) {
                sum += bright(x, y) * wx * wy;
            }
        }
        sum
    }

    /// Returns the share of the sphere that a pixel of a row covers, up to a common factor.
    fn row_weight(self, map: &ImageMap, y: usize) -> f64 {
        match self {
            Self::EqualArea => 1.0,
            Self::Equirectangular => {
                let rows = map.picture.size[1] as f64;
                (std::f64::consts::PI * (y as f64 + 0.5) / rows).sin()
            }
        }
    }

    /// Returns the mean brightness over all directions.
    fn mean_brightness(self, map: &ImageMap) -> f64 {
        let [width, height] = map.picture.size;
        let (mut sum, mut weight) = (0.0, 0.0);
        for y in 0..height {
            let row = self.row_weight(map, y);
            weight += row * width as f64;
            sum += row * (0..width).map(|x| self.brightness(map, x, y)).sum::<f64>();
        }
        sum / weight
    }

    /// Returns the distribution over the pixels by what their brightness has over a level.
    fn distribution(self, map: &ImageMap, level: f64) -> Option<Distribution> {
        Distribution::new(map.picture.size, |x, y| {
            (self.brightness(map, x, y) - level).max(0.0) * self.row_weight(map, y)
        })
    }

    /// Returns the solid angle per unit of image area at a point of the unit square (sr).
    fn solid_angle(self, uv: Vec2) -> f32 {
        match self {
            Self::Equirectangular => 2.0 * PI * PI * (uv.y * PI).sin(),
            Self::EqualArea => 4.0 * PI,
        }
    }
}

impl SkyImage {
    /// Makes the image of a sky. Returns `None` if the matrix from world space to light space
    /// cannot be inverted.
    pub fn new(map: ImageMap, light_from_world: Mat3, layout: SkyLayout) -> Option<Self> {
        let world_from_light = light_from_world.inverse();
        if !(light_from_world.is_finite() && world_from_light.is_finite()) {
            return None;
        }
        let complete = layout.distribution(&map, 0.0);
        // Pixels of the mean brightness have no weight, however it is rounded.
        let level = layout.mean_brightness(&map) * (1.0 + 1e-9);
        let compensated = layout.distribution(&map, level);
        Some(Self { map, light_from_world, world_from_light, layout, complete, compensated })
    }

    fn distribution(&self, sampling: SkySampling) -> Option<&Distribution> {
        match sampling {
            SkySampling::Complete => self.complete.as_ref(),
            SkySampling::Compensated => self.compensated.as_ref().or(self.complete.as_ref()),
        }
    }

    /// Returns the illuminance of a surface that faces +z of light space, by which pbrt-v4 scales a
    /// sky to a requested illuminance. Like pbrt-v4, it counts every pixel with half its solid
    /// angle, so that skies have the same brightness.
    pub fn illuminance(&self) -> f32 {
        let [width, height] = self.map.picture.size;
        let mut sum = 0.0;
        for (i, &pixel) in self.map.picture.pixels.iter().enumerate() {
            let at = Vec2::new((i % width) as f32 + 0.5, (i / width) as f32 + 0.5);
            let uv = at / Vec2::new(width as f32, height as f32);
            let cos = self.layout.to_direction(uv).z.max(0.0);
            sum += f64::from(luminance(pixel) * cos * self.layout.solid_angle(uv) / 2.0);
        }
        (sum / self.map.picture.pixels.len() as f64) as f32
    }

    /// Returns the mean colour of its pixels.
    pub(crate) fn mean_colour(&self) -> [f32; 3] {
        let pixels = &self.map.picture.pixels;
        let mut sum = [0.0; 3];
        for pixel in pixels {
            (0..3).for_each(|c| sum[c] += f64::from(pixel[c].max(0.0)));
        }
        sum.map(|sum| (sum / pixels.len() as f64) as f32)
    }

    fn at(&self, uv: Vec2) -> [f32; 3] {
        let size = self.map.picture.size;
        let texel = match self.layout {
            SkyLayout::Equirectangular => self.map.colour(uv),
            SkyLayout::EqualArea => {
                let [x, y] = [0, 1].map(|i| ((uv[i] * size[i] as f32) as usize).min(size[i] - 1));
                self.map.picture.pixels[y * size[0] + x]
            }
        };
        texel.map(|c| c.max(0.0))
    }

    /// Returns the point of the image for a direction, world space, and the ratio of solid angles
    /// in light space to those in world space: 1 if the matrix is a rotation.
    fn locate(&self, direction: Vec3) -> (Vec2, f32) {
        let d = self.light_from_world * direction;
        let length = d.length();
        let solid_angle_ratio = self.light_from_world.determinant().abs() / length.powi(3);
        (self.layout.to_uv(d / length), solid_angle_ratio)
    }

    fn density(&self, direction: Vec3, sampling: SkySampling) -> f32 {
        let Some(distribution) = self.distribution(sampling) else { return 0.0 };
        let (uv, solid_angle_ratio) = self.locate(direction);
        let density = distribution.density(uv.to_array());
        let density = density * solid_angle_ratio / self.layout.solid_angle(uv);
        if density.is_finite() { density } else { 0.0 }
    }

    fn sample(&self, u: [f32; 2], sampling: SkySampling) -> Option<SkySample> {
        let chosen = self.distribution(sampling)?.sample(u);
        let uv = Vec2::from(chosen.uv);
        let size = self.map.picture.size;
        let radiance = match self.layout {
            SkyLayout::Equirectangular => self.at(uv),
            SkyLayout::EqualArea => {
                let [x, y] = chosen.cell;
                self.map.picture.pixels[y * size[0] + x].map(|c| c.max(0.0))
            }
        };
        let d = self.world_from_light * self.layout.to_direction(uv);
        let direction = d.normalize();
        let solid_angle_ratio = self.light_from_world.determinant().abs() * d.length().powi(3);
        let density = chosen.density * solid_angle_ratio / self.layout.solid_angle(uv);
        let usable = density > 0.0 && density.is_finite();
        usable.then_some(SkySample { direction, radiance, density })
    }
}

impl Sky {
    /// A sky of the same radiance in all directions.
    pub fn uniform(radiance: impl Into<Colour>) -> Self {
        Self { radiance: radiance.into(), image: None, uplift: None }
    }

    /// Returns the radiance from a unit direction, world space, away from the scene.
    pub fn radiance(&self, direction: Vec3) -> [f32; 3] {
        let Some(image) = &self.image else { return self.radiance.rgb };
        self.scaled(image.at(image.locate(direction).0))
    }

    fn scaled(&self, texel: [f32; 3]) -> [f32; 3] {
        let texel = uplifted(texel, &self.uplift);
        [0, 1, 2].map(|i| texel[i] * self.radiance.rgb[i])
    }

    /// Returns whether the sky emits nothing.
    pub(super) fn is_dark(&self) -> bool {
        let dark = |image: &SkyImage| image.complete.is_none();
        mean(self.radiance.rgb.map(|r| r.max(0.0))) <= 0.0
            || self.image.as_deref().is_some_and(dark)
    }

    /// Samples a direction of the image. Returns `None` without an image.
    pub(super) fn sample(&self, u: [f32; 2], sampling: SkySampling) -> Option<SkySample> {
        let sample = self.image.as_ref()?.sample(u, sampling)?;
        Some(SkySample { radiance: self.scaled(sample.radiance), ..sample })
    }

    /// Returns the density [1/sr] with which [`Self::sample`] samples a direction.
    pub(super) fn density(&self, direction: Vec3, sampling: SkySampling) -> f32 {
        self.image.as_ref().map_or(0.0, |image| image.density(direction, sampling))
    }
}
