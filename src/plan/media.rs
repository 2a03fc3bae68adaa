//! Decision about participating media.

use super::{DecidedBy, Finding, PlanInput, cost};
use crate::scene::MediumModel;

/// Cost of a ray's way through homogeneous media (ns), and through one that varies. Measured by
/// `cargo bench --bench effects -- media`.
const RAY_NS: [f64; 2] = [30.0, 400.0];

/// Calls for the media of the scene.
pub(super) fn find(input: &PlanInput) -> Finding {
    let media = &input.motion.scene.media;
    if media.is_empty() {
        return Finding::unavailable(DecidedBy::Scene, "there are no participating media");
    }
    let mut kinds: Vec<&str> = media.iter().map(|medium| medium.kind()).collect();
    kinds.dedup();
    let varies = media.iter().any(|medium| matches!(medium.model, MediumModel::Varying(_)));
    let ns = input.pilot.rays_per_sample * RAY_NS[usize::from(varies)];
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
