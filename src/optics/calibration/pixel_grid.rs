//! Pixels of a picture and their places on the film.

use glam::DVec3;
use petzval_lens::FilmMap;

/// The pixels of a picture on a film.
///
/// Pixel coordinates are those of OpenCV: x to the right, y down, and the centre of the first pixel
/// at (0, 0). The image on the film is upside down and mirrored: the right of the picture lies at
/// negative x of the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelGrid {
    /// Width and height of the picture (pixels).
    pub resolution: [u32; 2],
    /// Distance from pixel to pixel (mm); pixels are square.
    pub pitch: f64,
}

impl PixelGrid {
    /// Returns the pixels of a film of this width (mm).
    pub fn new(resolution: [u32; 2], width: f64) -> Self {
        Self { resolution, pitch: width / f64::from(resolution[0]) }
    }

    /// Returns the largest part of a sensor (mm) that has the aspect of the picture.
    pub fn used_part(resolution: [u32; 2], sensor: [f64; 2]) -> [f64; 2] {
        let [x, y] = resolution.map(f64::from);
        let pitch = (sensor[0] / x).min(sensor[1] / y);
        [x * pitch, y * pitch]
    }

    /// Returns the coordinates of the picture's centre (pixels).
    pub fn centre(&self) -> [f64; 2] {
        self.resolution.map(|n| (f64::from(n) - 1.0) / 2.0)
    }

    /// Returns the width and height of the film (mm).
    pub fn film_size(&self) -> [f64; 2] {
        self.resolution.map(|n| f64::from(n) * self.pitch)
    }

    /// Returns the map between the film and the picture, whose origin is the corner of the first pixel.
    fn film_map(&self) -> FilmMap {
        FilmMap::new(self.film_size(), self.resolution)
    }

    /// Returns half the diagonal of the film (mm).
    pub fn half_diagonal(&self) -> f64 {
        let [x, y] = self.film_size();
        x.hypot(y) / 2.0
    }

    /// Returns the point of the film (mm from its centre, x to the right and y up as seen from
    /// behind the camera) that a point of the picture (pixels) shows.
    pub fn film_point(&self, pixel: [f64; 2]) -> [f64; 2] {
        self.film_map().film_point(pixel.map(|at| at + 0.5))
    }

    /// Returns the point of the picture (pixels) that shows a point of the film (mm).
    pub fn pixel(&self, film: [f64; 2]) -> [f64; 2] {
        self.film_map().pixel(film).map(|at| at - 0.5)
    }

    /// Returns points of the picture (pixels) on a regular grid from the first pixel to the last,
    /// about `count` along the longer side.
    pub fn sample_points(&self, count: usize) -> Vec<[f64; 2]> {
        let longer = self.resolution[0].max(self.resolution[1]);
        let steps = self.resolution.map(|n| {
            let share = f64::from(n) / f64::from(longer);
            ((share * count as f64).ceil() as usize).max(3)
        });
        let place = |i: usize, axis: usize| {
            let last = f64::from(self.resolution[axis]) - 1.0;
            last * i as f64 / (steps[axis] - 1) as f64
        };
        (0..steps[1]).flat_map(|y| (0..steps[0]).map(move |x| [place(x, 0), place(y, 1)])).collect()
    }
}

/// A line in the scene, in the frame of the camera: mm, x to the right and y down in the picture, z
/// towards the scene from the film plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SightLine {
    /// A point of the line.
    pub point: DVec3,
    /// Unit direction, away from the camera.
    pub direction: DVec3,
}

/// Least cosine to the axis for which a distance is measured along the axis. Rays that are steeper
/// end on a sphere instead.
const STEEPEST: f64 = 0.258_819_045_102_520_76;

impl SightLine {
    /// Returns the direction in which a centre of projection sees the point of the ray at a distance
    /// along the axis (mm from the film plane); that of the ray itself if the distance is infinite.
    /// Points more than 75 degrees from the axis are on a sphere.
    pub fn seen_from(&self, centre: DVec3, distance: f64) -> DVec3 {
        if distance.is_infinite() {
            return self.direction;
        }
        let along = (distance - self.point.z) / self.direction.z.max(STEEPEST);
        (self.point + along * self.direction - centre).normalize()
    }

    /// Returns the angle to the axis (radians).
    pub fn angle(&self) -> f64 {
        self.direction.x.hypot(self.direction.y).atan2(self.direction.z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_right_of_the_picture_is_the_left_of_the_film_and_its_top_the_lower_edge() {
        let pixels = PixelGrid::new([300, 200], 36.0);
        let [x, y] = pixels.film_point([299.0, 0.0]);
        assert!((x + 17.94).abs() < 1e-9 && (y + 11.94).abs() < 1e-9, "{x} {y}");
        let back = pixels.pixel([x, y]);
        assert!((back[0] - 299.0).abs() < 1e-9 && back[1].abs() < 1e-9, "{back:?}");
    }

    #[test]
    fn a_sensor_of_another_aspect_is_cropped_and_not_stretched() {
        let [width, height] = PixelGrid::used_part([1920, 1080], [36.0, 24.0]);
        assert!((width - 36.0).abs() < 1e-12 && (height - 20.25).abs() < 1e-12);
        let [width, height] = PixelGrid::used_part([1000, 1000], [36.0, 24.0]);
        assert!((width - 24.0).abs() < 1e-12 && (height - 24.0).abs() < 1e-12);
    }
}
