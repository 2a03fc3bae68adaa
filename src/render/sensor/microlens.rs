//! Pixel vignetting: oblique light that misses the photosites behind microlenses.

use petzval_image::Picture;
use petzval_lens::{Camera, ChiefRayFinder, LensModel};
use rayon::prelude::*;

use crate::film::Frame;

/// Points from the middle of the film to its corner at which chief rays are traced.
const POINTS: usize = 17;

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

/// Light that photosites collect behind the microlenses of a sensor and the chief rays of a lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelVignetting {
    pub(super) microlenses: Microlenses,
    /// Deviation of the chief ray from the best direction (degrees), by the distance from the axis in equal steps.
    deviations: [f64; POINTS],
    /// The foot of the axis [pixels of the frame], and the number of pixels of a step along x and y.
    axis: [f64; 2],
    step: [f64; 2],
}

impl PixelVignetting {
    /// Traces the chief rays of a camera; `None` without a real lens.
    pub fn new(microlenses: Microlenses, camera: &Camera, frame: &Frame) -> Option<Self> {
        let LensModel::Real(lens) = &camera.model else { return None };
        let map = camera.film_map(frame.resolution);
        // The microlenses are made for the middle of the sensor, which a shift takes off the axis.
        let [x, y, _] = lens.film_pose.film_point([0.0; 2]);
        let reach = camera.half_diagonal() + x.hypot(y);
        let finder = ChiefRayFinder::new(&lens.prescription);
        let mut last = 0.0;
        let deviations = std::array::from_fn(|i| {
            let radius = reach * i as f64 / (POINTS - 1) as f64;
            let ray = finder.of_film_point([-radius, 0.0, 0.0], lens.film_distance);
            let angle = ray.map(|ray| {
                let [x, y, z] = ray.film.t;
                x.hypot(y).atan2(z).to_degrees()
            });
            // Beyond the last chief ray, light is vignetted by the lens.
            last = angle.unwrap_or(last);
            let made_for = microlenses.corner_angle * radius / camera.half_diagonal();
            last - made_for
        });
        let steps = reach / (POINTS - 1) as f64;
        let pitch = camera.pixel_pitch(frame.resolution);
        Some(Self {
            microlenses,
            deviations,
            axis: map.pixel([-x, -y]),
            step: pitch.map(|pitch| steps / pitch),
        })
    }

    /// Returns the share of the light that the photosites of a pixel collect: a Gaussian of the deviation.
    pub(super) fn at(&self, pixel: [u32; 2]) -> f64 {
        let [x, y] = [0, 1].map(|i| (f64::from(pixel[i]) + 0.5 - self.axis[i]) / self.step[i]);
        let place = x.hypot(y).min((POINTS - 1) as f64);
        let low = (place as usize).min(POINTS - 2);
        let [near, far] = [self.deviations[low], self.deviations[low + 1]];
        let deviation = near + (far - near) * (place - low as f64);
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
