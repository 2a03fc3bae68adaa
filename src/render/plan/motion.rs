//! Decision about motion blur, from the motion on the film while the shutter is open.

use super::image_motion::{image_motion, share_near};
use super::{DecidedBy, Effect, Finding, OmissionError, PlanInput, cost};

/// Cost of assigning a time to a sample (ns). These costs are measured by `cargo bench --bench effects
/// -- motion`.
const TIME_NS: f64 = 4.0;
/// Cost of a ray of a moving camera (ns).
const CAMERA_RAY_NS: f64 = 30.0;
/// Cost of testing a ray against the box around all moving objects (ns).
const RAY_NS: f64 = 4.0;
/// Cost of a ray that meets this box (ns), if objects move straight and if they rotate. The boxes that
/// rotating objects sweep are wider, so more rays meet one.
const NEAR_RAY_NS: [f64; 2] = [40.0, 110.0];

pub(super) fn find(input: &PlanInput) -> Finding {
    let motion = &input.motion;
    if !motion.any() {
        return Finding::unavailable(DecidedBy::Scene, "nothing moves");
    }
    let pixels = image_motion(input, motion.timing.first_row_range());
    let um = pixels * motion.pitch;
    let objects_move = !motion.scene.animated_instances().is_empty();
    let subject = match (objects_move, motion.timing.camera_motion.is_some()) {
        (true, false) => "objects move",
        (true, true) => "objects and the camera move",
        _ => "the camera moves",
    };
    let error = OmissionError::Blur { um, pixels };
    let by_default = error.is_visible(input.threshold);
    let frozen = match input.selection.of(Effect::Motion).unwrap_or(by_default) {
        true => "",
        false => "; everything stays where it is in the middle of that time",
    };
    Finding {
        by: DecidedBy::Scene,
        reason: format!(
            "{subject} by up to {um:.1} um, {pixels:.1} pixels, while the shutter is open{frozen}"
        ),
        error: Some(error),
        possible: true,
        by_default,
        cost: cost(input, cost_ns(input)),
    }
}

/// Returns the cost [ns per film sample].
fn cost_ns(input: &PlanInput) -> f64 {
    let motion = &input.motion;
    let camera_ray = if motion.timing.camera_motion.is_some() { CAMERA_RAY_NS } else { 0.0 };
    if motion.scene.animated_instances().is_empty() {
        return TIME_NS + camera_ray;
    }
    let rotates =
        motion.scene.animated_instances().iter().any(|instance| instance.motion.rotates());
    let near = share_near(input) * NEAR_RAY_NS[usize::from(rotates)];
    TIME_NS + camera_ray + input.pilot.rays_per_sample * (RAY_NS + near)
}
