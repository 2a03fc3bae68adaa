//! Decision about Fresnel losses, from the light that the surfaces of a lens reflect.

use super::{DecidedBy, Finding, OmissionError, PlanInput, cost};
use crate::lens::{Coating, RealLens};

/// Cost at each interface between media, for bare glass and for a layer of MgF2 [ns per film sample].
/// Measured by `cargo bench --bench effects -- fresnel`.
const NS: [f64; 2] = [0.5, 0.95];

/// Calls for the loss if the lens file or the command line names a coating. The exposure of other lens
/// files was never meant to include it.
pub(super) fn find(input: &PlanInput, lens: &RealLens) -> Finding {
    let rows = &lens.prescription.rows;
    let Some(through) = lens.throughput(input.camera.half_diagonal()) else {
        return Finding::unavailable(DecidedBy::Lens, "no light comes through the lens");
    };
    let loss = 100.0 * (1.0 - through.mean);
    let [least, most] = through.range.map(|share| 100.0 * (1.0 - share));
    let named = rows.iter().any(|row| row.coating.is_some());
    let by = if input.coating_given { DecidedBy::Flag } else { DecidedBy::Lens };
    let who = match named {
        true => "",
        false => "; the lens file names no coating",
    };
    let (low, high) = (least.min(most), least.max(most));
    let reason = format!(
        "surfaces reflect {loss:.1} % of the light, {low:.1} to {high:.1} over the film{who}"
    );
    let faces = |layered: bool| {
        let mut count = 0;
        for (i, row) in rows.iter().enumerate() {
            let [before, behind] = lens.prescription.indices(i);
            count += i32::from(before != behind && (row.coating == Some(Coating::Mgf2)) == layered);
        }
        f64::from(count)
    };
    Finding {
        by,
        reason,
        error: Some(OmissionError::Signal(loss)),
        possible: true,
        by_default: input.coating_given || named && loss >= 1.0,
        cost: cost(input, NS[0] * faces(false) + NS[1] * faces(true)),
    }
}
