//! Decision about participating media.

use super::{DecidedBy, Finding, PlanInput, cost};
use petzval_scene::{Medium, MediumModel};

/// Returns the cost of a ray's way through a medium (ns), also in the mean over rays that pass it by.
/// Measured by `cargo bench --bench effects -- media`.
fn ray_ns(medium: &Medium) -> f64 {
    match &medium.model {
        MediumModel::Homogeneous(_) if medium.boundary.is_some() => 230.0,
        MediumModel::Homogeneous(_) => 60.0,
        MediumModel::Varying(_) => 300.0,
    }
}

/// Calls for the media of the scene.
pub(super) fn find(input: &PlanInput) -> Finding {
    let media = &input.motion.scene.media;
    if media.is_empty() {
        return Finding::unavailable(DecidedBy::Scene, "there are no participating media");
    }
    let mut kinds: Vec<&str> = media.iter().map(|medium| medium.kind()).collect();
    kinds.dedup();
    let ns = media.iter().map(ray_ns).fold(0.0, f64::max) * input.pilot.rays_per_sample;
    let reason = match media.len() {
        1 => format!("a medium absorbs, scatters or emits light: {}", kinds[0]),
        count => format!("{count} media absorb, scatter or emit light: {}", kinds.join(", ")),
    };
    Finding {
        by: DecidedBy::Scene,
        reason,
        error: None,
        possible: true,
        by_default: true,
        cost: cost(input, ns),
    }
}
