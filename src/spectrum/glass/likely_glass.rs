//! Choice of a likely glass for a medium whose dispersion is unknown.

use super::CatalogueGlass;
use super::catalogue::all;

/// Tolerance of the index, wide enough to contain a crown and a flint.
const TOLERANCE: f64 = 1e-2;

/// Returns the most likely catalogue glass of an element of index `nd`. Among the glasses of about
/// this index, it is the one of least dispersion for a converging element and of most for a
/// diverging one, because lenses correct colour in this way. Without such a glass it is the one of
/// nearest index.
pub(crate) fn likely_glass(nd: f64, converging: bool) -> Option<&'static CatalogueGlass> {
    let difference = |glass: &CatalogueGlass| (glass.nd() - nd).abs();
    let same = all().filter(|glass| difference(glass) <= TOLERANCE);
    let by_vd = |a: &&CatalogueGlass, b: &&CatalogueGlass| a.vd().total_cmp(&b.vd());
    let best = if converging { same.max_by(by_vd) } else { same.min_by(by_vd) };
    best.or_else(|| all().min_by(|a, b| difference(a).total_cmp(&difference(b))))
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
        assert!(all().all(|glass| glass.nd() <= far.nd()));
    }
}
