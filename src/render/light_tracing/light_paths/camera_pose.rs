//! Pose of the camera at the time of a light path.

use glam::{DAffine3, DMat3, DVec3, Vec3};

use crate::timing::Timing;
use petzval_lens::{Camera, RealLens};
use petzval_scene::{SurfacePoint, gamma};

/// Pose of a camera at one time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CameraPose {
    /// Camera space to world space.
    pub world_from_camera: DAffine3,
    /// World space to camera space.
    pub camera_from_world: DAffine3,
    /// Vectors of the world to camera space.
    pub vector_to_camera: DMat3,
}

impl CameraPose {
    fn new(world_from_camera: DAffine3) -> Self {
        let camera_from_world = world_from_camera.inverse();
        Self { world_from_camera, camera_from_world, vector_to_camera: camera_from_world.matrix3 }
    }

    /// Returns the pose of a camera at a time.
    pub fn at(camera: &Camera, timing: Option<&Timing>, time: f32) -> Self {
        let rest = camera.world_from_camera;
        Self::new(match timing.and_then(|timing| timing.camera_motion.as_ref()) {
            Some(motion) => motion.at(f64::from(time)) * rest,
            None => rest,
        })
    }

    /// Returns the point of the world at a point of the plane of the front vertex (mm).
    pub fn front_point(&self, lens: &RealLens, [x, y]: [f64; 2]) -> Vec3 {
        let [right, up] = [x, y].map(|v| v * lens.units_per_mm);
        let place = DVec3::new(right, up, lens.front_depth);
        self.world_from_camera.transform_point3(place).as_vec3()
    }

    /// Returns the same point as one that faces the scene, from which lights are sampled.
    pub fn front_surface(&self, lens: &RealLens, at: [f64; 2]) -> SurfacePoint {
        let normal = self.world_from_camera.transform_vector3(DVec3::Z).normalize().as_vec3();
        let position = self.front_point(lens, at);
        let error = position.abs() * gamma(4) + Vec3::splat(f32::MIN_POSITIVE);
        SurfacePoint { position, error, normal, shading_normal: normal }
    }

    /// Returns where a ray of the world crosses the plane of the front vertex (mm), and its direction
    /// as a unit vector in the frame of the camera; `None` if it does not come from the lens.
    pub fn crossing(
        &self,
        lens: &RealLens,
        origin: Vec3,
        direction: Vec3,
    ) -> Option<([f64; 2], DVec3)> {
        let camera_from_world = self.camera_from_world;
        let towards = camera_from_world.transform_vector3(direction.as_dvec3()).try_normalize()?;
        let from = camera_from_world.transform_point3(origin.as_dvec3());
        let at = (from + towards * ((lens.front_depth - from.z) / towards.z)) / lens.units_per_mm;
        (towards.z > 0.0).then_some(([at.x, at.y], towards))
    }
}

/// Poses of the camera during the exposure.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CameraPoses<'a> {
    /// The camera.
    pub camera: &'a Camera,
    /// The times of the samples, if anything moves.
    pub timing: Option<&'a Timing>,
    /// Pose of a camera that does not move.
    still: Option<CameraPose>,
}

impl<'a> CameraPoses<'a> {
    /// Prepares the poses of a camera.
    pub fn new(camera: &'a Camera, timing: Option<&'a Timing>) -> Self {
        let moves = timing.is_some_and(|timing| timing.camera_motion.is_some());
        let still = (!moves).then(|| CameraPose::at(camera, None, 0.0));
        Self { camera, timing, still }
    }

    /// Returns the pose at a time.
    pub fn at(&self, time: f32) -> CameraPose {
        self.still.unwrap_or_else(|| CameraPose::at(self.camera, self.timing, time))
    }
}
