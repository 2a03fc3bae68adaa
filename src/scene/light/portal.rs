//! Light from infinitely far away that a rectangular portal lets through.
//!
//! Bitterli, Wyman, Pharr, Shirley, Lefohn & Jarosz 2015, "Portal-masked environment map sampling":
//! in the rectified image, whose axes are the angles from the portal's normal along its two sides,
//! the directions through the portal from any point are a rectangle.

use std::f32::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use glam::{Mat3, Vec2, Vec3};

use super::sky::SkySample;
use super::windowed_distribution::{Window, WindowedDistribution};
use super::{mean, uplifted};
use petzval_base::equal_area;
use petzval_image::Picture;
use petzval_spectrum::Colour;

/// A light at infinite distance that is seen through a rectangle alone.
///
/// As in pbrt-v4, a point receives light from the directions from it through the portal if it is on
/// the back of the portal, and none if it is on the front. Nothing else than the portal hides the
/// light: walls must do that.
#[derive(Clone, Debug)]
pub struct Portal {
    /// Opposite corners, world space.
    corners: [Vec3; 2],
    /// World space to the frame of the portal: two sides, and the direction of the light's origin.
    portal_from_world: Mat3,
    /// Image over the angles -90 to 90 degrees along the two sides: linear RGB.
    rectified: Arc<Picture>,
    radiance: Colour,
    /// Matrix of the colours of the image, if paths carry other channels than RGB.
    uplift: Option<[[f32; 3]; 3]>,
    distribution: Arc<WindowedDistribution>,
}

/// Why four points are no portal.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("the four points are not the corners of a rectangle, in order")]
pub struct NoRectangle;

/// Largest cosine between sides that are perpendicular.
const PERPENDICULAR: f32 = 1e-3;

impl Portal {
    /// Makes a portal with these corners, world space, before a square image of all directions in
    /// the equal-area mapping of Clarberg 2008, times `radiance`.
    ///
    /// The image is resampled to the rectified one of the same size, as in pbrt-v4.
    ///
    /// # Errors
    /// Returns an error if the corners are not those of a rectangle, in order around it.
    pub fn new(
        corners: [Vec3; 4],
        sky: &Picture,
        light_from_world: Mat3,
        radiance: Colour,
    ) -> Result<Self, NoRectangle> {
        let side = |from: usize, to: usize| (corners[to] - corners[from]).try_normalize();
        let (Some(y), Some(x)) = (side(0, 1), side(0, 3)) else { return Err(NoRectangle) };
        let opposite = (corners[1] + corners[3] - corners[0]).distance(corners[2]);
        let size = (corners[2] - corners[0]).length();
        // A NaN is no rectangle, either.
        if !(x.dot(y).abs() <= PERPENDICULAR && opposite <= PERPENDICULAR * size) {
            return Err(NoRectangle);
        }
        let z = x.cross(y).normalize();
        let portal_from_world = Mat3::from_cols(x, z.cross(x), z).transpose();
        let light_from_portal = light_from_world * portal_from_world.transpose();
        let pixel = |x: usize, y: usize| {
            let uv = Vec2::new(x as f32 + 0.5, y as f32 + 0.5)
                / Vec2::new(sky.size[0] as f32, sky.size[1] as f32);
            let towards = light_from_portal * to_direction(uv);
            let seen = interpolated(sky, equal_area::from_sphere(towards.normalize()));
            seen.map(|c| c.max(0.0))
        };
        let [width, height] = sky.size;
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| pixel(x, y)));
        let rectified = Picture { size: sky.size, pixels: pixels.collect() };
        let distribution = WindowedDistribution::new(sky.size, |x, y| {
            let uv =
                Vec2::new(x as f32 + 0.5, y as f32 + 0.5) / Vec2::new(width as f32, height as f32);
            let brightness = mean(rectified.pixels[y * width + x]);
            f64::from(brightness * solid_angle(to_direction(uv)))
        });
        let corners = [corners[0], corners[2]];
        Ok(Self {
            corners,
            portal_from_world,
            rectified: Arc::new(rectified),
            radiance,
            uplift: None,
            distribution: Arc::new(distribution),
        })
    }

    pub(crate) fn emission(&self) -> &Colour {
        &self.radiance
    }

    pub(crate) fn radiance_mut(&mut self) -> &mut Colour {
        &mut self.radiance
    }

    pub(crate) fn set_uplift(&mut self, matrix: Option<[[f32; 3]; 3]>) {
        self.uplift = matrix;
    }

    /// Returns the directions through the portal from a point; `None` in front of the portal.
    fn window(&self, from: Vec3) -> Option<Window> {
        let [a, b] = [0, 1].map(|i| {
            let towards = self.portal_from_world * (self.corners[i] - from);
            (towards.z > 0.0).then(|| to_uv(towards))
        });
        let (a, b) = (a?, b?);
        Some(Window { low: a.min(b).to_array(), high: a.max(b).to_array() })
    }

    fn at(&self, [x, y]: [usize; 2]) -> [f32; 3] {
        let texel = self.rectified.pixels[y * self.rectified.size[0] + x];
        let texel = uplifted(texel, &self.uplift);
        [0, 1, 2].map(|i| texel[i] * self.radiance.rgb[i])
    }

    /// Returns the radiance at a point, world space, from a unit direction away from it.
    pub fn radiance(&self, from: Vec3, direction: Vec3) -> [f32; 3] {
        self.seen(from, direction).map_or([0.0; 3], |(uv, _)| self.at(self.distribution.cell(uv)))
    }

    /// Returns the point of the rectified image in a direction through the portal, and the window.
    fn seen(&self, from: Vec3, direction: Vec3) -> Option<([f32; 2], Window)> {
        let towards = self.portal_from_world * direction;
        let window = self.window(from)?;
        let uv = to_uv(towards).to_array();
        (towards.z > 0.0 && window.contains(uv)).then_some((uv, window))
    }

    /// Returns whether the portal passes no light.
    pub(super) fn is_dark(&self) -> bool {
        mean(self.radiance.rgb.map(|r| r.max(0.0))) <= 0.0 || self.distribution.is_zero()
    }

    /// Samples a direction through the portal from a point.
    pub(super) fn sample(&self, from: Vec3, u: [f32; 2]) -> Option<SkySample> {
        let chosen = self.distribution.sample(u, &self.window(from)?)?;
        let towards = to_direction(Vec2::from(chosen.uv));
        let direction = self.portal_from_world.transpose() * towards;
        let density = chosen.density / solid_angle(towards);
        let usable = density > 0.0 && density.is_finite();
        usable.then_some(SkySample { direction, radiance: self.at(chosen.cell), density })
    }

    /// Returns the density [1/sr] with which [`Self::sample`] samples a unit direction.
    pub(super) fn density(&self, from: Vec3, direction: Vec3) -> f32 {
        let Some((uv, window)) = self.seen(from, direction) else { return 0.0 };
        let towards = self.portal_from_world * direction;
        let density = self.distribution.density(uv, &window) / solid_angle(towards);
        if density.is_finite() { density } else { 0.0 }
    }
}

/// Returns the point of the rectified image in a direction with z > 0, portal frame.
fn to_uv(towards: Vec3) -> Vec2 {
    let angles = Vec2::new(towards.x.atan2(towards.z), towards.y.atan2(towards.z));
    (angles / PI + 0.5).clamp(Vec2::ZERO, Vec2::ONE)
}

/// Returns the unit direction, portal frame, at a point of the rectified image.
fn to_direction(uv: Vec2) -> Vec3 {
    // Right angles have no tangent.
    let angles = ((uv - 0.5) * PI).clamp(Vec2::splat(-MAX_ANGLE), Vec2::splat(MAX_ANGLE));
    Vec3::new(angles.x.tan(), angles.y.tan(), 1.0).normalize()
}

/// Largest angle from the portal's normal that has a finite tangent.
const MAX_ANGLE: f32 = FRAC_PI_2 - 1e-6;

/// Returns the solid angle per unit of the rectified image's area in a unit direction, portal frame
/// (sr; Bitterli et al. 2015, eq. 5).
fn solid_angle(towards: Vec3) -> f32 {
    let [x, y] = [towards.x, towards.y].map(|c| 1.0 - c * c);
    PI * PI * x * y / towards.z
}

/// Returns an image of all directions, bilinear between its pixels, at a point of the unit square.
/// Beyond an edge it continues where the octahedron does: on the same edge, mirrored.
fn interpolated(sky: &Picture, uv: Vec2) -> [f32; 3] {
    let [width, height] = sky.size.map(|n| n as i64);
    let place = uv * Vec2::new(width as f32, height as f32) - 0.5;
    let (low, fraction) = (place.floor(), place - place.floor());
    let pixel = |x: i64, y: i64| {
        let (mut x, mut y) = (x, y);
        if x < 0 || x >= width {
            (x, y) = (x.clamp(0, width - 1), height - 1 - y);
        }
        if y < 0 || y >= height {
            (x, y) = (width - 1 - x, y.clamp(0, height - 1));
        }
        sky.pixels[(y * width + x) as usize]
    };
    let (x, y) = (low.x as i64, low.y as i64);
    let [top, bottom] = [y, y + 1].map(|y| [pixel(x, y), pixel(x + 1, y)]);
    [0, 1, 2].map(|c| {
        let row = |[a, b]: [[f32; 3]; 2]| a[c] + fraction.x * (b[c] - a[c]);
        row(top) + fraction.y * (row(bottom) - row(top))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Corners of a rectangle at x = 0 whose light comes from x > 0: y is up in its frame.
    const CORNERS: [Vec3; 4] = [
        Vec3::new(0.0, -1.0, -0.5),
        Vec3::new(0.0, -1.0, 1.5),
        Vec3::new(0.0, 2.0, 1.5),
        Vec3::new(0.0, 2.0, -0.5),
    ];

    fn portal(sky: impl Fn(usize, usize) -> [f32; 3]) -> Portal {
        let size = [32, 32];
        let pixels = (0..1024).map(|i| sky(i % 32, i / 32)).collect();
        let turned = Mat3::from_rotation_y(0.3);
        Portal::new(CORNERS, &Picture { size, pixels }, turned, [2.0; 3].into())
            .expect("a rectangle")
    }

    fn uneven() -> Portal {
        portal(|x, y| [0.1 + (x % 7) as f32, 0.1 + (y % 5) as f32, if x > y { 3.0 } else { 0.1 }])
    }

    /// A point behind the portal, and the same point in front of it.
    fn behind_and_before() -> [Vec3; 2] {
        let point = Vec3::new(-0.7, 0.2, 0.3);
        let front = uneven().portal_from_world.transpose() * Vec3::Z;
        let behind = if front.x > 0.0 { point } else { point * Vec3::new(-1.0, 1.0, 1.0) };
        [behind, behind * Vec3::new(-1.0, 1.0, 1.0)]
    }

    /// Returns the mean over uniform directions of a quantity.
    fn mean_over_sphere(of: impl Fn(Vec3) -> f64) -> f64 {
        let n = 1500;
        let sum: f64 = (0..n * n)
            .map(|i| {
                let uv = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
                of(equal_area::to_sphere(uv))
            })
            .sum();
        sum / f64::from(n * n)
    }

    #[test]
    fn the_density_integrates_to_one_behind_the_portal_and_to_zero_before_it() {
        let (portal, [behind, before]) = (uneven(), behind_and_before());
        let integral = |from: Vec3| {
            4.0 * std::f64::consts::PI
                * mean_over_sphere(|direction| f64::from(portal.density(from, direction)))
        };
        assert!((integral(behind) - 1.0).abs() < 0.005, "{}", integral(behind));
        assert_eq!(integral(before), 0.0);
        assert!(portal.sample(before, [0.5; 2]).is_none());
    }

    #[test]
    fn samples_pass_the_portal_and_have_their_density_and_radiance() {
        let (portal, [behind, _]) = (uneven(), behind_and_before());
        let (mut agreeing, mut same) = (0, 0);
        for i in 0..400 {
            let u = [(i % 20) as f32 / 20.0 + 0.02, (i / 20) as f32 / 20.0 + 0.03];
            let sample = portal.sample(behind, u).expect("light");
            let at = behind + sample.direction * (-behind.x / sample.direction.x);
            let inside = (-1.001..2.001).contains(&at.y) && (-0.501..1.501).contains(&at.z);
            assert!(inside, "{at}");
            let density = portal.density(behind, sample.direction);
            agreeing += u32::from((density / sample.density - 1.0).abs() < 1e-3);
            same += u32::from(portal.radiance(behind, sample.direction) == sample.radiance);
        }
        // Rounding may put a direction into the neighbouring texel.
        assert!(agreeing >= 398 && same >= 398, "{agreeing}, {same}");
    }

    #[test]
    fn sampling_finds_the_light_that_directions_show() {
        let (portal, [behind, _]) = (uneven(), behind_and_before());
        let n = 256;
        let mut sampled = 0.0;
        for i in 0..n * n {
            let u = [i % n, i / n].map(|i| (i as f32 + 0.5) / n as f32);
            let sample = portal.sample(behind, u).expect("light");
            sampled += f64::from(mean(sample.radiance) / sample.density) / f64::from(n * n);
        }
        let seen = 4.0
            * std::f64::consts::PI
            * mean_over_sphere(|direction| f64::from(mean(portal.radiance(behind, direction))));
        assert!((sampled / seen - 1.0).abs() < 0.005, "{sampled}, expected {seen}");
    }

    #[test]
    fn a_uniform_sky_fills_the_solid_angle_of_the_portal() {
        let (portal, [behind, _]) = (portal(|_, _| [1.0; 3]), behind_and_before());
        // The solid angle of a rectangle from a point over a corner, by its four quarters.
        let quarter =
            |a: f64, b: f64, d: f64| (a * b / (d * (a * a + b * b + d * d).sqrt())).atan();
        let (y, z, d) = (f64::from(behind.y), f64::from(behind.z), f64::from(behind.x.abs()));
        let sides =
            [(y + 1.0, z + 0.5), (y + 1.0, 1.5 - z), (2.0 - y, z + 0.5), (2.0 - y, 1.5 - z)];
        let expected: f64 = sides.into_iter().map(|(a, b)| quarter(a, b, d)).sum();
        let n = 256;
        let mut found = 0.0;
        for i in 0..n * n {
            let u = [i % n, i / n].map(|i| (i as f32 + 0.5) / n as f32);
            let sample = portal.sample(behind, u).expect("light");
            found += f64::from(sample.radiance[0] / sample.density) / 2.0 / f64::from(n * n);
        }
        assert!((found / expected - 1.0).abs() < 0.003, "{found}, expected {expected}");
    }

    #[test]
    fn other_quadrangles_are_no_portals() {
        let sky = Picture { size: [1, 1], pixels: vec![[1.0; 3]] };
        let make = |corners| Portal::new(corners, &sky, Mat3::IDENTITY, [1.0; 3].into()).is_ok();
        assert!(make(CORNERS));
        let [a, b, c, d] = CORNERS;
        assert!(!make([a, c, b, d]) && !make([a, b, c, a]) && !make([a, b, c, d + Vec3::X]));
        assert!(!make([a, b + Vec3::Y, c, d]) && !make([Vec3::NAN, b, c, d]));
    }
}
