//! The built-in glasses: one text file for each maker.

mod parse;

use std::sync::{Arc, LazyLock};

use super::{CatalogueGlass, GlassLibrary};

/// Makers, and the text of their glasses.
const TABLES: &[(&str, &str)] = &[
    ("Schott", include_str!("schott.txt")),
    ("Schott", include_str!("schott_old.txt")),
    ("Ohara", include_str!("ohara.txt")),
    ("Hoya", include_str!("hoya.txt")),
    ("", include_str!("other.txt")),
    ("", include_str!("nominal.txt")),
    ("", include_str!("materials.txt")),
    ("Hikari", include_str!("hikari.txt")),
    ("CDGM", include_str!("cdgm.txt")),
    ("Sumita", include_str!("sumita.txt")),
    ("LZOS", include_str!("lzos.txt")),
    ("AMI", include_str!("ami.txt")),
    ("Vitron", include_str!("vitron.txt")),
    ("LightPath", include_str!("lightpath.txt")),
    ("Corning", include_str!("corning.txt")),
];

/// The glasses of the tables.
struct BuiltIn {
    library: GlassLibrary,
    /// Widespread glasses, among which a likely one is chosen.
    common: Vec<Arc<CatalogueGlass>>,
}

static BUILT_IN: LazyLock<BuiltIn> = LazyLock::new(|| {
    let (mut glasses, mut common) = (Vec::new(), Vec::new());
    for &(maker, text) in TABLES {
        for (glass, is_common) in parse::table(maker, text) {
            let glass = Arc::new(glass);
            if is_common {
                common.push(glass.clone());
            }
            glasses.push(glass);
        }
    }
    BuiltIn { library: GlassLibrary::new(glasses), common }
});

/// Returns the library of the built-in glasses.
pub(super) fn library() -> GlassLibrary {
    BUILT_IN.library.clone()
}

/// Returns the widespread glasses, among which a likely one is chosen.
pub(super) fn common() -> &'static [Arc<CatalogueGlass>] {
    &BUILT_IN.common
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::glass::D_LINE;

    #[test]
    fn every_glass_has_its_published_index_and_abbe_number() {
        let mut compared = 0;
        for glass in library().glasses() {
            let Some([nd, vd]) = glass.published else { continue };
            // Catalogues round to five digits, and a few of molded glass to four.
            let name = glass.full_name();
            assert!((glass.nd() - nd).abs() < 4e-5, "{name}: {} {nd}", glass.nd());
            assert!((glass.vd() / vd - 1.0).abs() < 4e-3, "{name}: {} {vd}", glass.vd());
            compared += 1;
        }
        assert!(compared > 1700, "{compared}");
    }

    #[test]
    fn every_glass_has_a_falling_index_over_its_range() {
        for glass in library().glasses() {
            let [low, high] = glass.range;
            assert!(99.9 <= low && low < high && high < 1e5, "{}", glass.full_name());
            let at = |i: i32| low * (high / low).powf(f64::from(i) / 40.0);
            let indices: Vec<f64> = (0..=40).map(|i| glass.index(at(i))).collect();
            assert!(indices.iter().all(|n| (1.0..4.3).contains(n)), "{}", glass.full_name());
            assert!(indices.is_sorted_by(|a, b| a > b), "{}: {indices:?}", glass.full_name());
            assert_eq!([glass.index(-1.0), glass.index(f64::INFINITY)], [indices[0], indices[40]]);
        }
    }

    #[test]
    fn infrared_materials_have_the_indices_of_the_literature() {
        // Burnett 2016, Salzberg and Villa 1957, Connolly 1979, Malitson 1963 and 1964, Daimon 2007.
        for (name, nm, n) in [
            ("GERMANIUM", 10_000.0, 4.0042),
            ("SILICON", 4000.0, 3.4255),
            ("ZNSE", 10_600.0, 2.4028),
            ("CAF2", 2000.0, 1.4239),
            ("BAF2", D_LINE, 1.4744),
            ("WATER", D_LINE, 1.3334),
        ] {
            let glass = library().find(name, &[]).expect(name).glass;
            let found = glass.index(0.0, nm).unwrap();
            assert!((found - n).abs() < 2e-4, "{name}: {found}");
        }
    }
}
