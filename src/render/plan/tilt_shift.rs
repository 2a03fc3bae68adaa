//! Decision about tilt and shift of the film and of lens elements.

use super::{DecidedBy, Finding, OmissionError, PlanInput, cost, pixels_per_um};
use petzval_lens::{LensModel, Pose, Prescription};

/// Cost [ns per film sample] of shifted film; of tilted film or a misaligned lens; and of each change of
/// frame between surfaces. Measured by `cargo bench --bench effects -- tilt_shift`.
const NS: [f64; 3] = [0.5, 40.0, 0.5];

/// Lens and film of which at least one is tilted, shifted or decentred.
#[derive(Clone, Debug)]
pub struct Misalignment {
    /// The lens.
    pub lens: Prescription,
    /// The pose of the film.
    pub film: Pose,
    /// The source: that of the film if it is misaligned, otherwise that of the lens.
    pub by: DecidedBy,
}

/// Calls for the effect whenever there is a misalignment, which is never the default.
pub(super) fn find(input: &PlanInput) -> Finding {
    let (LensModel::Real(lens), Some(misalignment)) = (&input.camera.model, input.misalignment)
    else {
        let reason = "film and elements are perpendicular to the axis and centred on it";
        return Finding::unavailable(DecidedBy::Scene, reason);
    };
    let Misalignment { lens: misaligned, film, by } = misalignment;
    let um = lens.displacement(misaligned, *film, input.camera.film);
    let pixels = um * pixels_per_um(input);
    let mut parts = Vec::new();
    if !film.is_aligned() {
        let ([x, y], [ax, ay]) = (film.film_shift(), film.tilt);
        parts.push(format!("the film is shifted by {x}, {y} mm and tilted by {ax}, {ay} degrees"));
    }
    if misaligned.is_misaligned() {
        parts.push("elements of the lens are decentred or tilted".to_owned());
    }
    let untilted = film.is_untilted() && misaligned.is_round();
    let ns = NS[usize::from(!untilted)] + NS[2] * misaligned.frame_transforms() as f64;
    Finding {
        by: *by,
        reason: format!("{}: light lands {um:.0} um from where it would", parts.join("; ")),
        error: Some(OmissionError::Blur { um, pixels }),
        possible: true,
        by_default: true,
        cost: cost(input, ns),
    }
}
