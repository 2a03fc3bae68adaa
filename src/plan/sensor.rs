//! What a sensor's noise does to the picture.

use super::{By, Finding, Harm, Question, cost};

/// A sensor's noise in middle grey.
pub(super) fn find(question: &Question) -> Finding {
    /// Of a pixel, ns: `cargo bench --bench effects -- sensor`.
    const NS: f64 = 230.0;
    let Some(sensor) = question.sensor else {
        return Finding::not_called_for(By::Scene, "the film is ideal, as the scene has it");
    };
    let noise = sensor.relative_noise(0.18);
    Finding {
        by: By::Flag,
        reason: format!("a sensor is asked for; middle grey has {noise:.1} % of noise"),
        error: Some(Harm::Signal(noise)),
        possible: true,
        called_for: true,
        cost: cost(question, NS / f64::from(question.samples.max(1))),
    }
}
