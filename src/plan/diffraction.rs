//! How wide the stop spreads a point of light.

use super::{By, Finding, Harm, Question, cost, pixels_per_um};
use crate::lens::{ExitPupil, Iris, RealLens, Wavefront};

/// A wavelength in the middle of the visible light, um.
const GREEN: f64 = 0.55;
/// Of a pixel of the finished picture, ns of all cores together: `cargo bench --bench effects --
/// diffraction`, one zone.
const NS: f64 = 2000.0;
/// Up to this rms error, waves, a wavefront is as good as a flat one (Marechal 1943).
const GOOD: f64 = 1.0 / 14.0;

/// Diffraction is on where the Airy disc's radius to its first zero in the middle of the film, by
/// the traced pupil, could be seen. Whether a bladed stop makes stars around lamps depends on how
/// bright those are, which is not known before the picture is: the reason says what to ask for.
pub(super) fn find(question: &Question, lens: &RealLens) -> Finding {
    let Some(pupil) = ExitPupil::seen(lens, [0.0; 2]) else {
        return Finding::not_called_for(By::Lens, "no light comes to the middle of the film");
    };
    let um = pupil.airy(GREEN);
    let pixels = um * pixels_per_um(question);
    let seen = pixels >= question.visible.pixels;
    let working = 0.5 / pupil.sine();
    let waves = Wavefront::of(lens, [0.0; 2], &pupil).map(|front| 1e3 * front.rms / GREEN);
    let front = match waves {
        Some(waves) if waves < GOOD => {
            format!(", and the wavefront is good ({waves:.3} waves rms)")
        }
        Some(waves) => format!(", less than aberrations do ({waves:.2} waves rms)"),
        None => String::new(),
    };
    let bladed = lens.prescription.rows.iter().any(|row| row.iris != Iris::Round);
    let stars = match bladed && !seen {
        true => "; for stars around lamps: --effects +diffraction",
        false => "",
    };
    let reason = format!(
        "at f/{working:.1} the Airy disc's radius is {um:.1} um, {pixels:.2} pixels{front}{stars}"
    );
    Finding {
        by: By::Lens,
        reason,
        error: Some(Harm::Blur { um, pixels }),
        possible: true,
        called_for: seen,
        cost: cost(NS / f64::from(question.samples.max(1))),
    }
}
