//! Motion vectors: displacements of the images of points while the shutter is open.

use std::sync::Arc;

use glam::{DAffine3, DVec3};

use crate::film_projection::FilmProjection;
use crate::timing::Timing;
use petzval_lens::Camera;
use petzval_scene::motion::Motion;
use petzval_scene::{AnimatedInstance, Scene};

/// Distance of points that stand for directions [camera units].
const FAR: f64 = 1e12;

/// Motion of all points of a scene, and of the camera, as pictures show it.
#[derive(Clone, Debug)]
pub struct MotionVectors {
    projection: FilmProjection,
    resolution: [u32; 2],
    camera_from_world: DAffine3,
    /// Times of exposure, with the motion of the camera.
    timing: Timing,
    /// Number of instances at rest, which the moving ones follow.
    resting: u32,
    moving: Arc<[AnimatedInstance]>,
}

/// A point that a camera path sees.
#[derive(Clone, Copy, Debug)]
pub(super) enum SeenPoint {
    /// A point in world space that moves with an instance, or rests if that does.
    Surface(DVec3, u32),
    /// A point of space that rests, in world space.
    Space(DVec3),
    /// A direction, in world space.
    Direction(DVec3),
}

impl MotionVectors {
    /// Returns the motion of a scene before its motion is stopped, if it is, under a camera at rest in the middle
    /// of the exposure.
    pub(crate) fn new(
        scene: &Scene,
        camera: &Camera,
        resolution: [u32; 2],
        timing: &Timing,
    ) -> Self {
        Self {
            projection: FilmProjection::of(camera, resolution),
            resolution,
            camera_from_world: camera.world_from_camera.inverse(),
            timing: timing.clone(),
            resting: scene.resting_instance_count(),
            moving: scene.shared_animated_instances(),
        }
    }

    /// Returns the same motion as another camera sees it.
    pub(crate) fn seen_by(&self, camera: &Camera, resolution: [u32; 2]) -> Self {
        Self {
            projection: FilmProjection::of(camera, resolution),
            resolution,
            camera_from_world: camera.world_from_camera.inverse(),
            ..self.clone()
        }
    }

    /// Returns the displacement (pixels, x to the right, y down) of a point that a pixel sees at a time, from the beginning of
    /// the pixel's exposure to its end; `None` if its image is unknown at either. A scene whose motion is stopped is seen in
    /// the middle of the first row's exposure.
    pub(super) fn vector(
        &self,
        point: SeenPoint,
        time: Option<f32>,
        pixel: [u32; 2],
    ) -> Option<[f64; 2]> {
        let time = time.map_or_else(|| self.timing.first_row_middle(), f64::from);
        let motion = match point {
            SeenPoint::Surface(_, instance) => self.motion_of(instance),
            SeenPoint::Space(_) | SeenPoint::Direction(_) => None,
        };
        let place = |at: f64| {
            let camera_from_world = match &self.timing.camera_motion {
                Some(camera) => self.camera_from_world * camera.at(at).inverse(),
                None => self.camera_from_world,
            };
            match point {
                SeenPoint::Surface(point, _) => {
                    let moved = motion.map_or(DAffine3::IDENTITY, |motion| {
                        motion.at(at) * motion.at(time).inverse()
                    });
                    camera_from_world.transform_point3(moved.transform_point3(point))
                }
                SeenPoint::Space(point) => camera_from_world.transform_point3(point),
                SeenPoint::Direction(direction) => {
                    camera_from_world.transform_vector3(direction).normalize_or_zero() * FAR
                }
            }
        };
        if motion.is_none() && self.timing.camera_motion.is_none() {
            return Some([0.0; 2]);
        }
        if matches!(point, SeenPoint::Direction(_)) && self.projection.is_parallel() {
            // Parallel rays see one direction in all pixels.
            return None;
        }
        let start = pixel.map(|at| f64::from(at) + 0.5);
        let [from, to] = self
            .timing
            .exposure_of(pixel, self.resolution)
            .map(|at| self.projection.pixel(place(at), Some(start)));
        Some(self.projection.displacement(from?, to?))
    }

    fn motion_of(&self, instance: u32) -> Option<&Motion> {
        let moving = instance.checked_sub(self.resting)?;
        self.moving.get(moving as usize).map(|instance| &instance.motion)
    }
}
