//! Lights at one point: bare, spot, by a goniometric diagram, or projecting a picture. The
//! definitions are pbrt-v4's.

use std::f32::consts::PI;
use std::sync::Arc;

use glam::{Mat3, Vec2, Vec3};

use super::bounds::Bounds;
use super::cone::Cone;
use super::{mean, square};
use crate::image::Picture;

/// A light at one point.
#[derive(Clone, Debug)]
pub struct Lamp {
    /// Where it is, world space.
    pub position: Vec3,
    /// World space to the lamp's own, in which it points along +z.
    pub light_from_world: Mat3,
    /// Radiant intensity, or what a picture is multiplied by; linear RGB.
    pub intensity: [f32; 3],
    /// Where it goes.
    pub beam: Beam,
}

/// How the intensity of a lamp changes with direction.
#[derive(Clone, Debug)]
pub enum Beam {
    /// Not at all.
    Bare,
    /// A cone with a soft rim.
    Spot {
        /// Cosines of the angles from the axis at which the light ends, and begins to fade.
        cosines: [f32; 2],
    },
    /// By the mean of the channels of a square picture of all directions, equal areas on equal
    /// areas (Clarberg 2008). A pixel has one colour.
    Diagram(Arc<Picture>),
    /// A picture thrown through a pinhole, upright where y is up. A pixel has one colour.
    Projection {
        /// The picture.
        picture: Arc<Picture>,
        /// Tangent of half the angle under which its shorter side is seen.
        tangent: f32,
    },
}

/// Hermite's cubic between 0 and 1, as pbrt-v4 evaluates it where the two ends coincide.
fn smooth_step(x: f32, [zero, one]: [f32; 2]) -> f32 {
    if zero == one {
        return if x < zero { 0.0 } else { 1.0 };
    }
    let t = ((x - zero) / (one - zero)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// The pixel at a point of the unit square.
fn pixel(picture: &Picture, uv: Vec2) -> [f32; 3] {
    let [width, height] = picture.size;
    let place = |c: f32, n: usize| ((c * n as f32) as usize).min(n - 1);
    picture.pixels[place(uv.y, height) * width + place(uv.x, width)].map(|c| c.max(0.0))
}

/// Half the width and the height of a projected picture in a plane at distance 1, over the
/// tangent of half the field of view.
fn screen(picture: &Picture) -> Vec2 {
    let aspect = picture.size[0] as f32 / picture.size[1] as f32;
    if aspect > 1.0 { Vec2::new(aspect, 1.0) } else { Vec2::new(1.0, 1.0 / aspect) }
}

impl Beam {
    /// The factor of the intensity in a direction of the lamp's space.
    fn at(&self, d: Vec3) -> [f32; 3] {
        match self {
            Self::Bare => [1.0; 3],
            Self::Spot { cosines } => [smooth_step(d.z, *cosines); 3],
            Self::Diagram(picture) => [mean(pixel(picture, square::from_sphere(d))); 3],
            Self::Projection { picture, tangent } => {
                let half = screen(picture);
                let at = Vec2::new(d.x, -d.y) / (d.z * *tangent);
                // pbrt-v4 lets nothing pass that is this close to the plane of the pinhole.
                let passes = d.z >= 1e-3 && at.abs().cmple(half).all();
                if passes { pixel(picture, (at / half + 1.0) / 2.0) } else { [0.0; 3] }
            }
        }
    }

    /// The power, over that of a lamp of intensity 1, by which pbrt-v4 fulfils a wish for a
    /// power: the integral of the factor over all directions, in luminance for a projected
    /// picture.
    pub fn power(&self) -> f32 {
        match self {
            Self::Bare => 4.0 * PI,
            Self::Spot { cosines: [end, start] } => {
                2.0 * PI * ((1.0 - start) + (start - end) / 2.0)
            }
            Self::Diagram(picture) => 4.0 * PI * average(picture, |_, _, pixel| mean(pixel)),
            Self::Projection { picture, tangent } => {
                let half = screen(picture) * *tangent;
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

/// Luminance of linear sRGB (ITU-R BT.709).
pub fn luminance([r, g, b]: [f32; 3]) -> f32 {
    0.212_64 * r + 0.715_17 * g + 0.072_19 * b
}

/// The mean of a function of all pixels.
fn average(picture: &Picture, f: impl Fn(usize, usize, [f32; 3]) -> f32) -> f32 {
    let width = picture.size[0];
    let pixels = picture.pixels.iter().enumerate();
    let sum: f64 = pixels.map(|(i, &pixel)| f64::from(f(i % width, i / width, pixel))).sum();
    (sum / picture.pixels.len() as f64) as f32
}

impl Lamp {
    /// The intensity that goes from the lamp in a direction of world space.
    pub fn towards(&self, direction: Vec3) -> [f32; 3] {
        let factor = self.beam.at((self.light_from_world * direction).normalize());
        [0, 1, 2].map(|i| self.intensity[i] * factor[i])
    }

    /// What the light tree knows of it; `None` where it sends nothing.
    pub(super) fn bounds(&self) -> Option<Bounds> {
        let strength = mean(self.intensity.map(|i| i.max(0.0)));
        let axis = (self.light_from_world.inverse() * Vec3::Z).try_normalize();
        // A matrix that does not only turn makes a cone of another form.
        let turns = (self.light_from_world * self.light_from_world.transpose())
            .abs_diff_eq(Mat3::IDENTITY, 1e-4);
        let (factor, normals, cos_beyond) = match (&self.beam, axis) {
            (Beam::Bare, _) | (_, None) => (1.0, Cone::ALL, 0.0),
            (Beam::Spot { cosines: [end, start] }, Some(axis)) => {
                let (end, start) = (end.clamp(-1.0, 1.0).acos(), start.clamp(-1.0, 1.0).acos());
                let beyond = (end - start).clamp(1e-2, PI / 2.0);
                let spread = if turns { (end - beyond).max(start).max(0.0) } else { PI };
                (1.0, Cone { axis, angle: spread }, beyond.cos())
            }
            (Beam::Diagram(picture), _) => (average(picture, |_, _, p| mean(p)), Cone::ALL, 0.0),
            (Beam::Projection { picture, tangent }, Some(axis)) => {
                let corner = (screen(picture).length() * tangent).atan();
                let spread = if turns { corner } else { PI };
                (average(picture, |_, _, p| mean(p)), Cone { axis, angle: spread }, 0.999)
            }
        };
        let intensity = strength * factor;
        let shines = intensity > 0.0 && intensity.is_finite();
        shines.then_some(Bounds {
            low: self.position,
            high: self.position,
            normals,
            cos_beyond,
            intensity,
            two_sided: false,
        })
    }
}
