//! What moves while the shutter is open.

use super::{By, Finding, Question};

pub(super) fn find(question: &Question) -> Finding {
    Finding::not_called_for(
        By::Scene,
        match question.moves {
            true => "something moves, which is not simulated yet",
            false => "nothing moves",
        },
    )
}
