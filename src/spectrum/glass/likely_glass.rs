//! Choice of a likely glass for a medium whose dispersion is unknown.

use std::sync::Arc;

use super::CatalogueGlass;
use super::built_in::common;

/// Tolerance of the index, wide enough to contain a crown and a flint.
const TOLERANCE: f64 = 1e-2;

/// Returns the most likely catalogue glass of an element of index `nd`. Among the widespread glasses
/// of about this index, it is the one of least dispersion for a converging element and of most for a
/// diverging one, because lenses correct colour in this way. Without such a glass it is the one of
/// nearest index.
pub fn likely_glass(nd: f64, converging: bool) -> Option<Arc<CatalogueGlass>> {
    let difference = |glass: &Arc<CatalogueGlass>| (glass.nd() - nd).abs();
    let same = common().iter().filter(|glass| difference(glass) <= TOLERANCE);
    let by_vd = |a: &&Arc<CatalogueGlass>, b: &&Arc<CatalogueGlass>| a.vd().total_cmp(&b.vd());
    let best = if converging { same.max_by(by_vd) } else { same.min_by(by_vd) };
    let nearest = || common().iter().min_by(|a, b| difference(a).total_cmp(&difference(b)));
    best.or_else(nearest).cloned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn converging_elements_are_crowns_and_diverging_ones_flints() {
        for nd in [1.517, 1.6, 1.65, 1.7] {
            let [crown, flint] =
                [true, false].map(|converging| likely_glass(nd, converging).expect("a glass"));
            assert!(crown.vd() > flint.vd(), "{nd}: {} {}", crown.name, flint.name);
            assert!((crown.nd() - nd).abs() <= TOLERANCE && (flint.nd() - nd).abs() <= TOLERANCE);
        }
        let far = likely_glass(9.0, true).expect("the nearest");
        assert!(common().iter().all(|glass| glass.nd() <= far.nd()));
    }
}
