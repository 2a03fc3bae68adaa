//! How wide the stop spreads a point of light.

use super::{By, Cost, Effect, Finding, Harm, Question, VEIL, cost, pixels_per_um};
use crate::diffraction::{Diffraction, Spread};
use crate::film::Frame;
use crate::lens::{ExitPupil, RealLens, Wavefront};

/// A wavelength in the middle of the visible light, um.
const GREEN: f64 = 0.55;
/// What a zone takes, ns of one core: for each pixel of the picture, and for its table. `cargo bench
/// --bench effects -- diffraction`.
const NS: [f64; 2] = [900.0, 3.5e8];
/// Up to this rms error, waves, a wavefront is as good as a flat one (Marechal 1943).
const GOOD: f64 = 1.0 / 14.0;

/// How far from a lamp, as a share of the picture's shorter side, its light must still be seen for
/// it to count: nearer, what is bright hides it.
const AWAY: f64 = 0.1;

/// Diffraction is on where the Airy disc's radius to its first zero in the middle of the film, by
/// the traced pupil, could be seen; or where the brightest spot of the picture would make a star, or
/// a glow, that could be seen well away from it.
pub(super) fn find(question: &Question, lens: &RealLens) -> Finding {
    let Some(pupil) = ExitPupil::seen(lens, [0.0; 2]) else {
        return Finding::not_called_for(By::Lens, "no light comes to the middle of the film");
    };
    let per_um = pixels_per_um(question);
    let um = pupil.airy(GREEN);
    let pixels = um * per_um;
    let blurs = pixels >= question.visible.pixels;
    let percent = star(question, &pupil, per_um);
    let shines = percent >= VEIL;
    let working = 0.5 / pupil.sine();
    let waves = Wavefront::of(lens, [0.0; 2], &pupil).map(|front| 1e3 * front.rms / GREEN);
    let front = match waves {
        Some(waves) if waves < GOOD => {
            format!(", and the wavefront is good ({waves:.3} waves rms)")
        }
        Some(waves) => format!(", less than aberrations do ({waves:.2} waves rms)"),
        None => String::new(),
    };
    let lamps = match shines {
        true => format!(
            "; the brightest lamp is spread a tenth of the picture away as {percent:.0} % of its mean"
        ),
        false => String::new(),
    };
    Finding {
        by: if shines && !blurs { By::Scene } else { By::Lens },
        reason: format!(
            "at f/{working:.1} the Airy disc's radius is {um:.1} um, {pixels:.2} pixels{front}{lamps}"
        ),
        error: Some(Harm::Blur { um, pixels }),
        possible: true,
        called_for: blurs || shines,
        cost: price(question, blurs || shines),
    }
}

/// What it takes by film sample, where it may well be on: pupils are traced for that.
fn price(question: &Question, called_for: bool) -> Option<Cost> {
    if !question.wanted.of(Effect::Diffraction).unwrap_or(called_for) {
        return None;
    }
    let frame = Frame::whole(question.resolution);
    let zones = Diffraction::new(question.camera, &frame, question.bands).zones() as f64;
    let pixels = question.resolution.map(f64::from).iter().product::<f64>();
    let samples = f64::from(question.samples.max(1));
    cost(question, zones * (NS[0] + NS[1] / pixels) / samples)
}

/// The light of the brightest spot in the brightest direction at some distance, percent of the
/// picture's mean.
fn star(question: &Question, pupil: &ExitPupil, per_um: f64) -> f64 {
    let [width, height] = question.resolution.map(f64::from);
    let away = AWAY * width.min(height) / per_um;
    let spread = Spread::new(pupil, question.bands, away, 1.0 / per_um);
    let around = (0..DIRECTIONS).map(|i| {
        let (sin, cos) = (std::f64::consts::PI * i as f64 / DIRECTIONS as f64).sin_cos();
        spread.at([away * cos, away * sin])[1]
    });
    let share = around.fold(0.0, f64::max) / (per_um * per_um);
    question.level.percent(share * question.level.lamp)
}

/// Directions over half a turn in which a star's rays are looked for.
const DIRECTIONS: usize = 720;
