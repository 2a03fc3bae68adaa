//! When the film is exposed, and where the camera stands meanwhile.

use glam::DAffine3;

use super::{Changes, JobError};
use crate::motion::Motion;
use crate::plan::{By, Effect, Plan};
use crate::scene::Scene;
use crate::scene::pbrt::{CameraSpec, Description, RealisticSpec};
use crate::shutter::{Shutter, Timing};

/// An exposure as the scene file and the command line have it.
pub(super) struct Exposure {
    pub shutter: Shutter,
    /// Who asks for rows to be read one after another.
    pub rolling_by: By,
    /// The share of the light that the shutter lets through.
    pub efficiency: f64,
    /// The camera in the middle of it.
    pub world_from_camera: DAffine3,
    /// With all that moves and rolls.
    pub timing: Timing,
    transform_times: [f64; 2],
}

impl Exposure {
    pub fn new(description: &Description, changes: &Changes) -> Result<Self, JobError> {
        let Description { shutter, transform_times, camera_motion, .. } = description;
        let asked = |problem| JobError::Asked(format!("--shutter: {problem}"));
        let mut shutter = match &changes.shutter {
            Some(settings) => settings.change(shutter).map_err(asked)?,
            None => shutter.clone(),
        };
        shutter.rolling = changes.rolling.or(shutter.rolling);
        let rolling_by = if changes.rolling.is_some() { By::Flag } else { By::Scene };
        let mut timing = Timing::new(&shutter, *transform_times, true, true).map_err(asked)?;
        let mut world_from_camera = description.world_from_camera;
        if camera_motion.as_still().is_none() {
            world_from_camera = camera_motion.at(timing.middle());
            let rest = Motion::still(world_from_camera.inverse());
            timing.ride = Some(camera_motion.then(&rest));
        }
        Ok(Self {
            rolling_by,
            efficiency: shutter.efficiency().map_err(asked)?.mean(),
            world_from_camera,
            timing,
            transform_times: *transform_times,
            shutter,
        })
    }

    /// Lets a camera of a scene file expose its film as long as the shutter is open.
    pub fn set(&self, camera: &mut CameraSpec) {
        match camera {
            CameraSpec::Thin(spec) => spec.exposure_time = self.shutter.time(),
            CameraSpec::Realistic(RealisticSpec::V4 { exposure_time, .. }) => {
                *exposure_time = self.shutter.time();
            }
            // The dialect of 2016 has no exposure.
            CameraSpec::Realistic(RealisticSpec::V2 { .. }) => {}
        }
    }

    /// When samples are taken, as a plan has it, of a scene that is made ready for it; `None`
    /// where all are taken at once.
    pub fn plan(self, plan: &Plan, scene: &mut Scene) -> Result<Option<Timing>, JobError> {
        let (blur, rolls) = (plan.has(Effect::Motion), plan.has(Effect::RollingShutter));
        if !blur && !rolls {
            scene.freeze(self.timing.middle());
            return Ok(None);
        }
        let timing = Timing::new(&self.shutter, self.transform_times, blur, rolls);
        let mut timing = timing.map_err(JobError::Asked)?;
        timing.ride = self.timing.ride;
        scene.expose(timing.range());
        Ok(Some(timing))
    }
}
