//! What the film looks at, for the focus.

use glam::DAffine3;

use super::JobError;
use crate::film::Frame;
use crate::lens::Camera;
use crate::rays::{NONE, RayBatch};
use crate::scene::{Scene, TraversalStack};

/// What the film looks at.
pub(super) struct Place<'a> {
    pub scene: &'a Scene,
    /// When, as a share of the motion.
    pub time: f32,
    pub world_from_camera: DAffine3,
    pub frame: &'a Frame,
    /// How far beyond the picture's edge its samples lie, pixels.
    pub reach: [f64; 2],
}

impl Place<'_> {
    /// How far before the film plane, in camera units, stands what a pixel sees through the
    /// middle of the pupil; infinitely far where it sees nothing.
    pub fn depth(&self, camera: &Camera, pixel: Option<[u32; 2]>) -> Result<f64, JobError> {
        let resolution = self.frame.resolution;
        let pixel = pixel.unwrap_or(resolution.map(|n| n / 2));
        let [x, y] = pixel;
        if (0..2).any(|i| pixel[i] >= resolution[i]) {
            return Err(JobError::Asked(format!(
                "--focus auto@{x},{y}: the picture has {} x {} pixels, counted from 0",
                resolution[0], resolution[1]
            )));
        }
        let mut rays = RayBatch::default();
        camera.principal(pixel, resolution, &mut rays);
        if rays.len == 0 {
            return Err(JobError::Asked(format!(
                "--focus auto@{x},{y}: no light comes through the middle of the lens to this pixel"
            )));
        }
        let ray = rays.ray(0);
        let hit = self.scene.closest_at::<f32>(&ray, self.time, &mut TraversalStack::default());
        let place = [0, 1, 2]
            .map(|i| f64::from(ray.origin[i]) + f64::from(hit.t) * f64::from(ray.direction[i]));
        let depth = self.world_from_camera.inverse().transform_point3(place.into()).z;
        let depth = depth + camera.film_behind();
        Ok(if hit.shape == NONE || depth <= 0.0 { f64::INFINITY } else { depth })
    }
}
