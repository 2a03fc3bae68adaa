//! Whether rows are read one after another.

use super::travel::travel;
use super::{By, Finding, Harm, Question, cost};

/// To tell when a row is read: `cargo bench --bench effects -- motion`.
const NS: f64 = 3.0;

pub(super) fn find(question: &Question) -> Finding {
    let moves = &question.moves;
    let Some((rolling, by)) = moves.rolling else {
        let reason = "all rows are exposed at once, as the scene has it";
        return Finding::not_called_for(By::Scene, reason);
    };
    if !moves.any() {
        return Finding::not_called_for(by, "rows are read one after another, but nothing moves");
    }
    let harm = travel(question, [moves.timing.middle(), moves.timing.last_middle()]);
    let Harm::Blur { um, pixels } = harm else {
        return Finding::not_called_for(by, "nothing moves");
    };
    Finding {
        by,
        reason: format!(
            "the last row is read {:.1} ms after the first, {}; meanwhile things go {um:.1} um, \
             {pixels:.1} pixels",
            1e3 * rolling.time,
            rolling.reading.name()
        ),
        error: Some(harm),
        possible: true,
        called_for: pixels >= question.visible.pixels,
        cost: cost(question, NS),
    }
}
