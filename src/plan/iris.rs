//! Whether the stop is a circle.

use super::{By, Effect, Finding, Question};
use crate::lens::{Iris, RealLens};

pub(super) fn find(question: &Question, lens: &RealLens) -> Finding {
    let rows = &lens.prescription.rows;
    let shaped = rows.iter().any(|row| row.iris != Iris::Round || row.obstruction > 0.0);
    let reason = match shaped {
        true => "the stop is not a circle",
        false => "the stop is a circle",
    };
    // Where it is not wanted, the camera already has a round stop.
    let possible = shaped || question.wanted.of(Effect::Iris) == Some(false);
    Finding { possible, called_for: shaped, ..Finding::not_called_for(By::Lens, reason) }
}
