//! A guess at how a medium disperses of which only the index is known.

use super::CatalogueGlass;
use super::catalogue::all;

/// How far apart two indices may lie that are taken for the same glass's: wide enough that there
/// is a crown and a flint to choose from.
const SAME: f64 = 1e-2;

/// The glass of the catalogue that an element of index `nd` is likeliest of. Among those of its
/// index, elements that gather light are taken to be of the one that disperses least, those that
/// spread it of the one that disperses most: so do lenses correct their colours. Where no glass
/// has the index, it is the nearest one's.
pub(in crate::lens) fn guess(nd: f64, gathers: bool) -> Option<&'static CatalogueGlass> {
    let off = |glass: &CatalogueGlass| (glass.nd() - nd).abs();
    let same = all().filter(|glass| off(glass) <= SAME);
    let by_vd = |a: &&CatalogueGlass, b: &&CatalogueGlass| a.vd().total_cmp(&b.vd());
    let best = if gathers { same.max_by(by_vd) } else { same.min_by(by_vd) };
    best.or_else(|| all().min_by(|a, b| off(a).total_cmp(&off(b))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crowns_gather_and_flints_spread() {
        for nd in [1.517, 1.6, 1.65, 1.7] {
            let [crown, flint] = [true, false].map(|gathers| guess(nd, gathers).expect("a glass"));
            assert!(crown.vd() > flint.vd(), "{nd}: {} {}", crown.name, flint.name);
            assert!((crown.nd() - nd).abs() <= SAME && (flint.nd() - nd).abs() <= SAME);
        }
        let far = guess(9.0, true).expect("the nearest");
        assert!(all().all(|glass| glass.nd() <= far.nd()));
    }
}
