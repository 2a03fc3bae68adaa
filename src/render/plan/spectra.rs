//! Decision about spectra.

use super::{DecidedBy, Effect, Finding, OmissionError, PlanInput, cost};
use petzval_scene::RgbError;

/// Cost of sorting samples by wavelength [ns per film sample], and of rays of a wave that lie less close to
/// each other, as a share of the time of a sample. Measured by `cargo bench --bench effects -- spectra`.
const SORTING: f64 = 40.0;
const INCOHERENCE: f64 = 0.1;

/// Finds what RGB gets wrong. Only the user turns spectra on: light paths, caustics and ghosts carry RGB.
pub(super) fn find(input: &PlanInput) -> Finding {
    if input.narrow_band {
        let reason = "the film sees a narrow band, as one colour";
        return Finding::unavailable(DecidedBy::Flag, reason);
    }
    let wanted = input.selection.of(Effect::Spectra);
    let scene = input.motion.scene;
    let error = (wanted != Some(false)).then(|| scene.rgb_error());
    let glass = if scene.disperses() { "; glass of the scene disperses" } else { "" };
    let threshold = input.threshold;
    let harm = error.map(|error| OmissionError::Colour {
        percent: error.percent,
        difference: error.difference,
    });
    let advice = match harm {
        Some(harm) if wanted.is_none() && harm.is_visible(threshold) => "; '+spectra' mends that",
        _ => "",
    };
    let reason = match error {
        Some(RgbError { difference, percent, channel }) if difference > 0.0 => {
            let channel = ["red", "green", "blue"][channel];
            format!(
                "RGB is off by {percent:.1} % in {channel} (dE2000 {difference:.1}) where it errs most, \
                 over all lights and surfaces{glass}{advice}"
            )
        }
        Some(_) => format!("no light of the scene has another colour than daylight{glass}"),
        None => format!("paths carry red, green and blue{glass}"),
    };
    Finding {
        by: DecidedBy::Scene,
        reason,
        error: harm,
        possible: true,
        by_default: false,
        cost: cost(input, SORTING + INCOHERENCE * input.pilot.ns_per_sample),
    }
}
