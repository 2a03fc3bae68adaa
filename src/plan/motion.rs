//! What moves while the shutter is open.

use super::travel::{share_near, travel};
use super::{By, Effect, Finding, Harm, Question, cost};

/// ns: `cargo bench --bench effects -- motion`. When a sample is taken.
const TIME: f64 = 4.0;
/// A ray of a camera that moves.
const RIDE: f64 = 30.0;
/// A ray against the box around all that moves; and one that comes near to it, where things go
/// straight and where they turn: there the boxes that they pass are wider, and more rays meet one.
const RAY: f64 = 4.0;
const NEAR_RAY: [f64; 2] = [40.0, 110.0];

pub(super) fn find(question: &Question) -> Finding {
    let moves = &question.moves;
    if !moves.any() {
        return Finding::not_called_for(By::Scene, "nothing moves");
    }
    let harm = travel(question, moves.timing.exposure());
    let Harm::Blur { um, pixels } = harm else {
        return Finding::not_called_for(By::Scene, "nothing moves");
    };
    let what = match (moves.scene.movers().is_empty(), moves.timing.ride.is_some()) {
        (false, false) => "things move",
        (false, true) => "things and the camera move",
        _ => "the camera moves",
    };
    let called_for = pixels >= question.visible.pixels;
    let frozen = match question.wanted.of(Effect::Motion).unwrap_or(called_for) {
        true => "",
        false => "; everything stands where it is in the middle of that time",
    };
    Finding {
        by: By::Scene,
        reason: format!(
            "{what} by up to {um:.1} um, {pixels:.1} pixels, while the shutter is open{frozen}"
        ),
        error: Some(harm),
        possible: true,
        called_for,
        cost: cost(question, price(question)),
    }
}

/// ns of a film sample.
fn price(question: &Question) -> f64 {
    let moves = &question.moves;
    let ride = if moves.timing.ride.is_some() { RIDE } else { 0.0 };
    if moves.scene.movers().is_empty() {
        return TIME + ride;
    }
    let turns = moves.scene.movers().iter().any(|mover| mover.motion.turns());
    let near = share_near(question) * NEAR_RAY[usize::from(turns)];
    TIME + ride + question.level.rays * (RAY + near)
}
