//! Exposure of a job: the shutter, the times of samples, and the pose of the camera.

use glam::DAffine3;

use super::changes::shutter_error;
use super::{Changes, PrepareError};
use crate::plan::{DecidedBy, Effect, Plan};
use crate::timing::{Timing, TimingEffects};
use petzval_scene::Scene;
use petzval_scene::motion::Motion;
use petzval_scene::shutter::Shutter;
use petzval_scene_formats::pbrt::{CameraSpec, Description, RealisticSpec};

/// The exposure that the scene file and the command line ask for.
pub(super) struct Exposure {
    pub shutter: Shutter,
    /// The source of the rolling shutter.
    pub rolling_by: DecidedBy,
    /// The share of the light that the shutter passes.
    pub efficiency: f64,
    /// The pose of the camera in the middle of the exposure.
    pub world_from_camera: DAffine3,
    /// The times of samples with motion and rolling shutter.
    pub timing: Timing,
    transform_times: [f64; 2],
}

impl Exposure {
    pub fn new(description: &Description, changes: &Changes) -> Result<Self, PrepareError> {
        let Description { shutter, transform_times, camera_motion, .. } = description;
        let shutter = changes.shutter_of(shutter)?;
        let rolling_by = if changes.rolling.is_some() { DecidedBy::Flag } else { DecidedBy::Scene };
        let mut timing =
            Timing::new(&shutter, *transform_times, TimingEffects::ALL).map_err(shutter_error)?;
        let mut world_from_camera = description.world_from_camera;
        if let Some(viewpoint) = changes.viewpoint {
            world_from_camera = viewpoint.world_from_camera(&world_from_camera);
        } else if camera_motion.as_still().is_none() {
            world_from_camera = camera_motion.at(timing.first_row_middle());
            let rest = Motion::still(world_from_camera.inverse());
            timing.camera_motion = Some(camera_motion.compose(&rest));
        }
        Ok(Self {
            rolling_by,
            efficiency: shutter.curve().map_err(shutter_error)?.efficiency(),
            world_from_camera,
            timing,
            transform_times: *transform_times,
            shutter,
        })
    }

    /// Sets the exposure time of a camera to the time that the shutter is open.
    pub fn set_time(&self, camera: &mut CameraSpec) {
        match camera {
            CameraSpec::Thin(spec) => spec.exposure_time = self.shutter.time(),
            CameraSpec::Spherical(spec) => spec.exposure_time = self.shutter.time(),
            CameraSpec::Realistic(RealisticSpec::V4 { exposure_time, .. }) => {
                *exposure_time = self.shutter.time();
            }
            // pbrt-v2's camera has no exposure time.
            CameraSpec::Realistic(RealisticSpec::V2 { .. }) => {}
        }
    }

    /// Returns the times of samples under a plan, or `None` if all are taken at once. Prepares the
    /// scene for them.
    ///
    /// # Errors
    /// Returns an error if the shutter is not sound.
    pub fn timing(self, plan: &Plan, scene: &mut Scene) -> Result<Option<Timing>, PrepareError> {
        let rolling_shutter = plan.has(Effect::RollingShutter);
        let effects = TimingEffects { motion_blur: plan.has(Effect::Motion), rolling_shutter };
        if !effects.motion_blur && !effects.rolling_shutter {
            scene.freeze(self.timing.first_row_middle());
            return Ok(None);
        }
        let timing = self.timing_with(effects)?;
        scene.set_time_range(timing.range());
        Ok(Some(timing))
    }

    /// Returns the times at which the shutter is open under a plan, even if it simulates no motion.
    ///
    /// # Errors
    /// Returns an error if the shutter is not sound.
    pub fn motion_timing(&self, plan: &Plan) -> Result<Timing, PrepareError> {
        let rolling_shutter = plan.has(Effect::RollingShutter);
        self.timing_with(TimingEffects { motion_blur: true, rolling_shutter })
    }

    fn timing_with(&self, effects: TimingEffects) -> Result<Timing, PrepareError> {
        let timing = Timing::new(&self.shutter, self.transform_times, effects);
        let mut timing = timing.map_err(PrepareError::Request)?;
        timing.camera_motion = self.timing.camera_motion.clone();
        Ok(timing)
    }
}
