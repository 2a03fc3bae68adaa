//! Decision about losses, from the light that the surfaces of a lens reflect and its glass absorbs.

use super::{DecidedBy, Finding, OmissionError, PlanInput, cost};
use petzval_lens::{Coating, RealLens};

/// Cost at each interface between media, for bare glass and for a layer of MgF2 [ns per film sample].
/// Measured by `cargo bench --bench effects -- fresnel`.
const NS: [f64; 2] = [0.5, 0.95];
/// Cost of a layer of a stack, measured likewise.
const LAYER_NS: f64 = 3.7;

/// The assumption about coatings, in words.
pub(super) const ASSUMPTION: &str = "no coating is known, a layer of MgF2 is assumed";

/// Calls for the loss if it is visible. With known coatings the whole loss counts. Without, the
/// exposure of the scene does not contain it, so that an even loss is a matter of exposure: only its
/// unevenness over the film counts.
pub(super) fn find(input: &PlanInput, lens: &RealLens) -> Finding {
    let rows = &lens.prescription.rows;
    let Some(through) = lens.throughput(input.camera.half_diagonal()) else {
        return Finding::unavailable(DecidedBy::Lens, "no light comes through the lens");
    };
    let loss = 100.0 * (1.0 - through.mean);
    let [least, most] = through.range.map(|share| 100.0 * (1.0 - share));
    let (low, high) = (least.min(most), least.max(most));
    let losers = match rows.iter().any(|row| row.glass.absorbs()) {
        true => "surfaces reflect and glass absorbs",
        false => "surfaces reflect",
    };
    let reflected =
        format!("{losers} {loss:.1} % of the light, {low:.1} to {high:.1} over the film");
    let (error, reason) = match lens.prescription.assumed_coating {
        true => {
            let uneven = 100.0 * through.unevenness;
            let reason = format!(
                "{reflected} ({ASSUMPTION}); an even loss is exposure, so only the unevenness of \
                 {uneven:.1} % rms counts"
            );
            (uneven, reason)
        }
        false => (loss, reflected),
    };
    let (mut interfaces, mut layers) = ([0.0; 2], 0);
    for (i, row) in rows.iter().enumerate() {
        let [before, behind] = lens.prescription.indices(i);
        if before != behind {
            interfaces[usize::from(row.coating == Some(Coating::Mgf2))] += 1.0;
            layers += row.coating.as_ref().map_or(0, Coating::layers);
        }
    }
    let ns = NS[0] * interfaces[0] + NS[1] * interfaces[1] + LAYER_NS * f64::from(layers);
    let error = OmissionError::Signal(error);
    Finding {
        by: if input.coating_given { DecidedBy::Flag } else { DecidedBy::Lens },
        reason,
        error: Some(error),
        possible: true,
        by_default: error.is_visible(input.threshold),
        cost: cost(input, ns),
    }
}
