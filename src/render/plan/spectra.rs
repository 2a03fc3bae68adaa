//! Decision about spectra.

use super::{DecidedBy, Effect, Finding, OmissionError, PlanInput, cost};
use petzval_scene::{RgbError, RgbErrors};

/// Cost of sorting samples by wavelength [ns per film sample], and of rays of a wave that lie less close to
/// each other, as a share of the time of a sample. Measured by `cargo bench --bench effects -- spectra`.
const SORTING: f64 = 40.0;
const INCOHERENCE: f64 = 0.1;

/// Finds what RGB gets wrong. Spectra are simulated if colours that the scene gives by wavelength look
/// wrong in RGB, if glass of the scene disperses, or if the film has buckets of wavelength.
pub(super) fn find(input: &PlanInput) -> Finding {
    if input.narrow_band {
        let reason = "the film sees a narrow band, as one colour";
        return Finding::unavailable(DecidedBy::Flag, reason);
    }
    let wanted = input.selection.of(Effect::Spectra);
    let scene = input.motion.scene;
    let disperses = scene.disperses();
    let errors = (wanted != Some(false)).then(|| scene.rgb_errors());
    let harm = |error: RgbError| OmissionError::Colour {
        percent: error.percent,
        difference: error.difference,
    };
    let is_visible = |error: RgbError| harm(error).is_visible(input.threshold);
    let by_default = input.buckets.is_some()
        || disperses
        || errors.is_some_and(|errors| is_visible(errors.stated));
    let largest = errors.map(|RgbErrors { stated, guessed }| {
        match is_visible(stated) || stated.difference >= guessed.difference {
            true => (stated, "where it errs most, over all lights, surfaces and media"),
            false => (guessed, "if colours given as RGB have smooth spectra"),
        }
    });
    let mut reason = match largest {
        None => "paths carry red, green and blue".to_owned(),
        Some((error, condition)) if error.difference > 0.0 => describe(error, condition),
        Some(_) => "no light of the scene has another colour than daylight".to_owned(),
    };
    if input.buckets.is_some() {
        reason += "; the film has buckets of wavelength";
    }
    if disperses {
        reason += "; glass of the scene disperses";
    }
    let error = largest.map(|(error, _)| error);
    if wanted.is_none() && !by_default && error.is_some_and(is_visible) {
        reason += "; '+spectra' takes that guess";
    }
    Finding {
        by: input.buckets.unwrap_or(DecidedBy::Scene),
        reason,
        error: error.map(harm),
        possible: true,
        by_default,
        cost: cost(input, SORTING + INCOHERENCE * input.pilot.ns_per_sample),
    }
}

/// Returns an error in words.
fn describe(error: RgbError, condition: &str) -> String {
    let RgbError { difference, percent, channel } = error;
    let channel = ["red", "green", "blue"][channel];
    format!("RGB is off by {percent:.1} % in {channel} (dE2000 {difference:.1}) {condition}")
}
