//! Decision about the rolling shutter, from the motion on the film between the first and the last row.

use super::image_motion::image_motion;
use super::{DecidedBy, Finding, OmissionError, PlanInput, cost};

/// Cost of assigning the time of a row [ns per film sample]. Measured by `cargo bench --bench effects --
/// motion`.
const NS: f64 = 3.0;

pub(super) fn find(input: &PlanInput) -> Finding {
    let motion = &input.motion;
    let Some((rolling, by)) = motion.rolling else {
        let reason = "all rows are exposed at once, as the scene has it";
        return Finding::unavailable(DecidedBy::Scene, reason);
    };
    if !motion.any() {
        return Finding::unavailable(by, "rows are read one after another, but nothing moves");
    }
    let rows = [motion.timing.first_row_middle(), motion.timing.last_row_middle()];
    let pixels = image_motion(input, rows);
    let um = pixels * motion.pitch;
    let error = OmissionError::Blur { um, pixels };
    Finding {
        by,
        reason: format!(
            "the last row is read {:.1} ms after the first, {}; meanwhile objects move by {um:.1} um, \
             {pixels:.1} pixels",
            1e3 * rolling.time,
            rolling.direction.name()
        ),
        error: Some(error),
        possible: true,
        by_default: error.is_visible(input.threshold),
        cost: cost(input, NS),
    }
}
