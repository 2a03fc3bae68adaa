//! Decision about ghosts: light that is reflected twice inside the lens.

use petzval_lens::LensModel;

use super::{DecidedBy, Effect, Finding, OmissionError, PlanInput, cost};

/// Cost [ns per film sample] of a quarter of a light path through the lens and of its shadow ray.
/// Measured by `cargo bench --bench effects -- ghosts`.
const NS: f64 = 110.0;

/// Returns whether the camera has a real lens with mirrors.
fn has_mirrors(input: &PlanInput) -> bool {
    match &input.camera.model {
        LensModel::Real(lens) => lens.prescription.has_mirrors(),
        _ => false,
    }
}

/// Returns whether the coatings of the lens are assumed.
fn has_assumed_coating(input: &PlanInput) -> bool {
    match &input.camera.model {
        LensModel::Real(lens) => lens.prescription.assumed_coating,
        _ => false,
    }
}

pub(super) fn find(input: &PlanInput) -> Finding {
    let Some(estimate) = input.ghosts else {
        let reason = match input.selection.of(Effect::Ghosts) {
            Some(false) => "not wanted, so not estimated",
            _ if has_mirrors(input) => {
                "the lens has mirrors: light that its glass reflects twice is not simulated"
            }
            _ => "no direct light reaches the film by two reflections",
        };
        return Finding::unavailable(DecidedBy::Scene, reason);
    };
    let percent = input.pilot.percent(estimate.peak);
    let (kept, dropped) = estimate.significant();
    let assumption = match has_assumed_coating(input) {
        true => format!("; {}", super::fresnel::ASSUMPTION),
        false => String::new(),
    };
    let error = OmissionError::Signal(percent);
    Finding {
        by: DecidedBy::Scene,
        reason: format!(
            "where they are brightest they add {percent:.2} % of the picture's mean; {kept} of {} \
             pairs of surfaces, the others make {dropped:.1} % of the ghosts{assumption}",
            estimate.pairs()
        ),
        error: Some(error),
        possible: true,
        by_default: error.is_visible(input.threshold),
        cost: cost(input, NS),
    }
}
