//! Whether the film or an element stands askew.

use super::{By, Finding, Harm, Question, cost, pixels_per_um};
use crate::lens::{Pose, Prescription, RealLens};

/// Of a film sample: from shifted film; from tilted film or into a lens that stands askew; and for each
/// turn between surfaces, ns: `cargo bench --bench effects -- tilt_shift`.
const NS: [f64; 3] = [0.5, 40.0, 0.5];

/// A lens and a film that do not both stand square.
#[derive(Clone, Debug)]
pub struct Posed {
    /// The lens.
    pub lens: Prescription,
    /// How the film stands.
    pub film: Pose,
    /// Who says so: of the film if that stands askew, else of the lens.
    pub by: By,
}

/// On whenever something stands askew: that is never so by default.
pub(super) fn find(question: &Question, lens: &RealLens) -> Finding {
    let Some(Posed { lens: posed, film, by }) = question.posed else { return square() };
    let um = lens.displacement(posed, *film, question.camera.film);
    let pixels = um * pixels_per_um(question);
    let mut parts = Vec::new();
    if !film.is_square() {
        let ([x, y], [ax, ay]) = (film.film_shift(), film.tilt);
        parts.push(format!("the film is shifted by {x}, {y} mm and tilted by {ax}, {ay} degrees"));
    }
    if posed.is_askew() {
        parts.push("elements of the lens are decentred or tilted".to_owned());
    }
    let level = film.is_level() && posed.is_round();
    let ns = NS[usize::from(!level)] + NS[2] * posed.turns() as f64;
    Finding {
        by: *by,
        reason: format!("{}: light lands {um:.0} um from where it would", parts.join("; ")),
        error: Some(Harm::Blur { um, pixels }),
        possible: true,
        called_for: true,
        cost: cost(question, ns),
    }
}

/// Nothing stands askew.
pub(super) fn square() -> Finding {
    Finding::not_called_for(By::Scene, "film and elements stand square to the axis")
}
