//! Decision about spectra.

use super::{DecidedBy, Finding, PlanInput, cost};

/// Cost of sorting samples by wavelength and of waves that are not full [ns per film sample].
const SORTING: f64 = 60.0;

/// Lets the user decide.
pub(super) fn find(input: &PlanInput) -> Finding {
    if input.narrow_band {
        return Finding::unavailable(DecidedBy::Flag, "the film sees a narrow band, as one colour");
    }
    Finding {
        by: DecidedBy::Scene,
        reason: "paths carry red, green and blue".to_owned(),
        error: None,
        possible: true,
        by_default: false,
        cost: cost(input, SORTING),
    }
}
