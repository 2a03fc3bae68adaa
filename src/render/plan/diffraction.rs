//! Decision about diffraction, from the width of the point spread.

use std::sync::Arc;

use super::{Cost, DecidedBy, Effect, Finding, OmissionError, PlanInput, cost, pixels_per_um};
use crate::diffraction::{Diffraction, DiffractionWork, PointSpread};
use crate::film::Frame;
use petzval_lens::{ExitPupil, RealLens, Wavefront};

/// A wavelength in the middle of the visible range (um).
const GREEN: f64 = 0.55;
/// Cost on one core (ns): of a zone, of a table of light that is spread far, and of one that is spread near,
/// and of a pixel of the planes of near and of far zones. Measured by
/// `cargo bench --bench effects -- diffraction`.
const NS: [f64; 5] = [4e7, 3.3e8, 3e7, 60.0, 100.0];
/// Largest rms error of a diffraction-limited wavefront (waves) (Marechal 1943).
const GOOD: f64 = 1.0 / 14.0;

/// Distance from a light at which its spread counts, relative to the shorter side of the picture.
/// Closer to the light, its glare hides the spread.
const AWAY: f64 = 0.1;

/// Calls for diffraction if the radius of the Airy disc (to its first zero, in the middle of the film,
/// by the traced pupil) would be visible, or if the brightest spot of the picture would make a
/// visible star or glow at [`AWAY`].
pub(super) fn find(input: &PlanInput, lens: &RealLens) -> Finding {
    let Some(pupil) = ExitPupil::trace(lens, [0.0; 2]) else {
        return Finding::unavailable(DecidedBy::Lens, "no light comes to the middle of the film");
    };
    let per_um = pixels_per_um(input);
    let um = pupil.airy_radius(GREEN);
    let pixels = um * per_um;
    let error = OmissionError::Blur { um, pixels };
    let blurs = error.is_visible(input.threshold);
    let percent = star(input, &pupil, per_um);
    let shines = OmissionError::Signal(percent).is_visible(input.threshold);
    let working = 0.5 / pupil.numerical_aperture();
    let waves = Wavefront::new(lens, [0.0; 2], &pupil).map(|front| 1e3 * front.rms / GREEN);
    let front = match waves {
        Some(waves) if waves < GOOD => {
            format!(", and the wavefront is good ({waves:.3} waves rms)")
        }
        Some(waves) => format!(", less than aberrations do ({waves:.2} waves rms)"),
        None => String::new(),
    };
    let highlights = match shines {
        true => format!(
            "; the brightest light is spread a tenth of the picture away as {percent:.0} % of its mean"
        ),
        false => String::new(),
    };
    Finding {
        by: if shines && !blurs { DecidedBy::Scene } else { DecidedBy::Lens },
        reason: format!(
            "at f/{working:.1} the Airy disc's radius is {um:.1} um, {pixels:.2} pixels{front}{highlights}"
        ),
        error: Some(error),
        possible: true,
        by_default: blurs || shines,
        cost: price(input, blurs || shines),
    }
}

/// Returns the cost of a film sample, or `None` if the effect stays off: the estimate traces pupils.
fn price(input: &PlanInput, by_default: bool) -> Option<Cost> {
    if !input.selection.of(Effect::Diffraction).unwrap_or(by_default) {
        return None;
    }
    let frame = Frame::whole(input.resolution);
    let traced = || Arc::new(Diffraction::new(input.camera, &frame, input.bands));
    let DiffractionWork { zones, far_tables, near_tables, near, far } =
        input.diffraction.get_or_init(traced).work(input.resolution.map(|n| n as usize));
    let counts = [zones as f64, far_tables as f64, near_tables as f64, near, far];
    let ns: f64 = NS.iter().zip(counts).map(|(ns, count)| ns * count).sum();
    let pixels = input.resolution.map(f64::from).iter().product::<f64>();
    cost(input, ns / pixels / f64::from(input.samples.max(1)))
}

/// Returns the light that the brightest spot spreads to [`AWAY`] in the brightest direction, relative
/// to the picture's mean (percent).
fn star(input: &PlanInput, pupil: &ExitPupil, per_um: f64) -> f64 {
    let [width, height] = input.resolution.map(f64::from);
    let away = AWAY * width.min(height) / per_um;
    let spread = PointSpread::new(pupil, input.bands, away, 1.0 / per_um);
    let directions = (0..DIRECTIONS).map(|i| {
        let (sin, cos) = (std::f64::consts::PI * i as f64 / DIRECTIONS as f64).sin_cos();
        spread.at([away * cos, away * sin])[1]
    });
    let share = directions.fold(0.0, f64::max) / (per_um * per_um);
    input.pilot.percent(share * input.pilot.highlight)
}

/// Number of directions over half a turn that are searched for the rays of a star.
const DIRECTIONS: usize = 720;
