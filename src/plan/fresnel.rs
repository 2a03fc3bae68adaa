//! How much of the light the surfaces of a lens reflect.

use super::{By, Finding, Harm, Question, cost};
use crate::lens::{Coating, RealLens};

/// Of a film sample at each face between media, for bare glass and for a layer of MgF2, ns:
/// `cargo bench --bench effects -- fresnel`.
const NS: [f64; 2] = [0.5, 0.95];

/// The loss is simulated where the lens file or the command line says what its glass is coated with:
/// files that do not are of lenses for which exposure was never meant to count it.
pub(super) fn find(question: &Question, lens: &RealLens) -> Finding {
    let rows = &lens.prescription.rows;
    let Some(through) = lens.throughput(question.camera.half_diagonal()) else {
        return Finding::not_called_for(By::Lens, "no light comes through the lens");
    };
    let loss = 100.0 * (1.0 - through.mean);
    let [least, most] = through.range.map(|share| 100.0 * (1.0 - share));
    let named = rows.iter().any(|row| row.coating.is_some());
    let by = if question.coated { By::Flag } else { By::Lens };
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
        error: Some(Harm::Signal(loss)),
        possible: true,
        called_for: question.coated || named && loss >= 1.0,
        cost: cost(question, NS[0] * faces(false) + NS[1] * faces(true)),
    }
}
