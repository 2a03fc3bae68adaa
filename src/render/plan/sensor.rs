//! Decision about the sensor.

use super::{DecidedBy, Finding, OmissionError, PlanInput, cost};

/// Calls for the sensor that the command line asks for. The estimated error is its noise in middle
/// grey.
pub(super) fn find(input: &PlanInput) -> Finding {
    /// Cost of a pixel (ns), and what fixed patterns add to it. Measured by
    /// `cargo bench --bench effects -- sensor`.
    const NS: f64 = 230.0;
    const PATTERNS: f64 = 250.0;
    let Some(sensor) = input.sensor else {
        return Finding::unavailable(DecidedBy::Scene, "the film is ideal, as the scene has it");
    };
    let noise = sensor.relative_noise(0.18);
    let patterns = if sensor.fixed_pattern.is_uniform() { 0.0 } else { PATTERNS };
    Finding {
        by: DecidedBy::Flag,
        reason: format!("a sensor is asked for; middle grey has {noise:.1} % of noise"),
        error: Some(OmissionError::Signal(noise)),
        possible: true,
        by_default: true,
        cost: cost(input, (NS + patterns) / f64::from(input.samples.max(1))),
    }
}
