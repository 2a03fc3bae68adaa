//! Whether light that is mirrored twice inside the lens can be seen.

use super::{By, Effect, Finding, Harm, Question, VEIL, cost};

/// Of a film sample: a quarter of a light path through the lens and back, and of its shadow ray;
/// `cargo bench --bench effects -- ghosts`.
const NS: f64 = 110.0;

pub(super) fn find(question: &Question) -> Finding {
    let Some(sighting) = question.ghosts else {
        let reason = match question.wanted.of(Effect::Ghosts) {
            Some(false) => "not wanted, and not looked for",
            _ => "no light that comes straight from a lamp gets to the film by two mirrorings",
        };
        return Finding::not_called_for(By::Scene, reason);
    };
    let percent = question.level.percent(sighting.peak);
    let (kept, dropped) = sighting.kept();
    let taken = match sighting.coated {
        true => "",
        false => "; no coating is known, a layer of MgF2 is taken",
    };
    Finding {
        by: By::Scene,
        reason: format!(
            "where they are brightest they add {percent:.2} % of the picture's mean; {kept} of {} \
             pairs of surfaces, the others make {dropped:.1} % of the ghosts{taken}",
            sighting.pairs()
        ),
        error: Some(Harm::Signal(percent)),
        possible: true,
        called_for: percent >= VEIL,
        cost: cost(question, NS),
    }
}
