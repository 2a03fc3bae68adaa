//! How wide the stop spreads a point of light.

use super::{By, Finding, Harm, Question, pixels_per_um};
use crate::lens::{Focus, RealLens};

/// A wavelength in the middle of the visible light, um.
const GREEN: f64 = 0.55;

/// Diffraction at the stop: the Airy disc's radius to its first zero, 1.22 lambda N' (Airy 1835),
/// with the working f-number N' of the distance in focus.
pub(super) fn find(question: &Question, lens: &RealLens) -> Finding {
    let prescription = &lens.prescription;
    let f_number = lens.paraxial.f_number();
    let object = Focus::of(prescription).object(lens.film_distance).unwrap_or(f64::INFINITY);
    // Magnification, from the focal length and the distance in focus.
    let magnification = match object.is_finite() {
        true => (lens.paraxial.focal_length / (object - lens.paraxial.focal_length)).abs(),
        false => 0.0,
    };
    let working = f_number * (1.0 + magnification);
    let um = 1.22 * GREEN * working;
    let pixels = um * pixels_per_um(question);
    let seen = pixels >= question.visible.pixels;
    let reason = format!(
        "at f/{working:.1} the Airy disc's radius is {um:.1} um, {pixels:.2} pixels{}",
        if seen { "; it could be seen, but is not simulated yet" } else { "" }
    );
    let error = Some(Harm::Blur { um, pixels });
    Finding { by: By::Lens, reason, error, possible: false, called_for: seen, cost: None }
}
