//! Pixel vignetting: oblique light that misses the photosites behind microlenses.

use petzval_image::Picture;
use petzval_lens::{Camera, ChiefRayFinder, LensModel};
use rayon::prelude::*;

use crate::film::Frame;

/// Points from the axis to the corner of the film that is farthest from it, at which chief rays are traced.
const POINTS: usize = 17;
/// Largest difference between the chief rays of a round lens at equal distances from the axis (degrees).
const ROUND: f64 = 1e-3;

/// Angular response of photosites behind microlenses. A microlens is displaced towards the middle of the sensor so that
/// the chief ray of its place falls on the photosite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Microlenses {
    /// Angle from the best direction (degrees) at which a photosite collects half as much light.
    pub half_angle: f64,
    /// Chief ray angle (degrees) in the corner that the microlenses are made for; in between, in proportion to the distance
    /// from the middle.
    pub corner_angle: f64,
}

/// Reason why the light behind microlenses is unknown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MicrolensError {
    /// The camera has no real lens.
    #[error(
        "'sensor' microlens: light is lost by its angle behind a real lens, and this camera has none; leave out microlens"
    )]
    NoLens,
    /// Chief rays depend on more than the distance from the axis.
    #[error(
        "'sensor' microlens: expected surfaces behind the stop that are round and aligned, and a film that is not tilted; leave out microlens"
    )]
    NotRound,
}

/// Light that photosites collect behind the microlenses of a sensor and the chief rays of a lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelVignetting {
    pub(super) microlenses: Microlenses,
    /// Angles of the chief rays from the axis (degrees), positive away from it, by the distance from the axis in equal
    /// steps.
    angles: [f64; POINTS],
    /// Length of a step (mm).
    step: f64,
    /// The foot of the axis and the middle of the sensor [pixels of the frame].
    axis: [f64; 2],
    middle: [f64; 2],
    /// Width and height of a pixel (mm), and half the diagonal of the sensor (mm).
    pitch: [f64; 2],
    half_diagonal: f64,
}

impl PixelVignetting {
    /// Traces the chief rays of a camera.
    ///
    /// # Errors
    /// Returns an error without a real lens, for chief rays that depend on more than the distance from the axis, and for
    /// a film that is tilted.
    pub fn new(
        microlenses: Microlenses,
        camera: &Camera,
        frame: &Frame,
    ) -> Result<Self, MicrolensError> {
        let LensModel::Real(lens) = &camera.model else { return Err(MicrolensError::NoLens) };
        let [x, y, _] = lens.film_pose.film_point([0.0; 2]);
        let step = (camera.half_diagonal() + x.hypot(y)) / (POINTS - 1) as f64;
        let finder = ChiefRayFinder::new(&lens.prescription);
        // Directions across the axis (degrees) of the chief ray of a film point.
        let direction = |x: f64, y: f64| {
            let ray = finder.of_film_point([x, y, 0.0], lens.film_distance)?;
            let [tx, ty, tz] = ray.film.t;
            Some([tx, ty].map(|across| across.atan2(tz).to_degrees()))
        };
        let mut last = 0.0;
        let mut is_round = lens.film_pose.is_untilted();
        let angles = std::array::from_fn(|i| {
            let radius = step * i as f64;
            // Beyond the last chief ray, the lens vignettes.
            let Some([x, y]) = direction(-radius, 0.0) else { return last };
            let turned = [
                direction(0.0, -radius).map(|[x, y]| [y, x]),
                direction(radius, 0.0).map(|[x, y]| [-x, y]),
            ];
            let is_same = |[u, v]: [f64; 2]| (u - x).abs().max(v.abs()) < ROUND;
            is_round &= y.abs() < ROUND && turned.into_iter().flatten().all(is_same);
            last = -x;
            last
        });
        if !is_round {
            return Err(MicrolensError::NotRound);
        }
        let map = camera.film_map(frame.resolution);
        Ok(Self {
            microlenses,
            angles,
            step,
            axis: map.pixel([-x, -y]),
            middle: map.pixel([0.0; 2]),
            pitch: camera.pixel_pitch(frame.resolution),
            half_diagonal: camera.half_diagonal(),
        })
    }

    /// Returns the share of the light that the photosites of a pixel collect: a Gaussian of the angle between the chief
    /// ray and the direction that the microlens is made for.
    pub(super) fn at(&self, pixel: [u32; 2]) -> f64 {
        let from = |point: [f64; 2]| {
            [0, 1].map(|i| (f64::from(pixel[i]) + 0.5 - point[i]) * self.pitch[i])
        };
        let ([x, y], [u, v]) = (from(self.axis), from(self.middle));
        let radius = x.hypot(y);
        let place = (radius / self.step).min((POINTS - 1) as f64);
        let low = (place as usize).min(POINTS - 2);
        let [near, far] = [self.angles[low], self.angles[low + 1]];
        let angle = near + (far - near) * (place - low as f64);
        let per_mm = if radius > 0.0 { angle / radius } else { 0.0 };
        let made_for = self.microlenses.corner_angle / self.half_diagonal;
        let deviation = (per_mm * x - made_for * u).hypot(per_mm * y - made_for * v);
        (-(deviation / self.microlenses.half_angle).powi(2)).exp2()
    }

    /// Darkens a picture whose first pixel has this place in the frame.
    pub(super) fn darken(&self, picture: &mut Picture, origin: [u32; 2]) {
        let width = picture.size[0].max(1);
        picture.pixels.par_chunks_mut(width).enumerate().for_each(|(row, pixels)| {
            for (column, pixel) in pixels.iter_mut().enumerate() {
                let share = self.at([origin[0] + column as u32, origin[1] + row as u32]) as f32;
                *pixel = pixel.map(|light| light * share);
            }
        });
    }
}
