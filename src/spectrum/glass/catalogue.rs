//! Glass catalogue: dispersion formulas, and glasses by name.

use super::{C_LINE, D_LINE, F_LINE, hoya, ohara, other, schott};
use crate::io::nearest_word;

/// A dispersion formula, with L the wavelength (um).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Formula {
    /// n^2 = 1 + the sum of b L^2 / (L^2 - c).
    Sellmeier {
        /// Strengths of the resonances.
        b: [f64; 3],
        /// Squared wavelengths of the resonances [um^2].
        c: [f64; 3],
    },
    /// n^2 = a0 + a1 L^2 + a2 L^-2 + a3 L^-4 + a4 L^-6 + a5 L^-8.
    Schott([f64; 6]),
}

/// A glass (or crystal, or plastic) whose dispersion is published.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CatalogueGlass {
    /// Name in the catalogue.
    pub name: &'static str,
    /// Manufacturer; empty for materials of several.
    pub maker: &'static str,
    /// nd and Vd as published, rounded.
    pub published: [f64; 2],
    /// Dispersion formula.
    pub formula: Formula,
}

/// Range of the formulas (nm); beyond it they have poles.
const TRANSPARENT: [f64; 2] = [300.0, 2500.0];
/// Range of the formulas of plastics (nm) (Zemax catalogue "misc").
const PLASTIC: [f64; 2] = [365.0, 1060.0];
const PLASTICS: &[&str] = &["PMMA", "POLYCARB", "POLYSTYR", "E48R"];

impl CatalogueGlass {
    /// Returns the shortest and the longest wavelength of the published data (nm).
    pub fn range(&self) -> [f64; 2] {
        if PLASTICS.contains(&self.name) { PLASTIC } else { TRANSPARENT }
    }

    /// Returns the index at a wavelength (nm); outside 300 to 2500 nm it is that of the nearer end.
    pub fn index(&self, nm: f64) -> f64 {
        let micrometres = nm.clamp(TRANSPARENT[0], TRANSPARENT[1]) / 1000.0;
        let square = micrometres * micrometres;
        let n2 = match self.formula {
            Formula::Sellmeier { b, c } => {
                1.0 + (0..3).map(|i| b[i] * square / (square - c[i])).sum::<f64>()
            }
            Formula::Schott([a0, a1, a2, a3, a4, a5]) => {
                let inverse = square.recip();
                a0 + a1 * square + inverse * (a2 + inverse * (a3 + inverse * (a4 + inverse * a5)))
            }
        };
        n2.sqrt()
    }

    /// Returns the index at the d line, by the formula.
    pub fn nd(&self) -> f64 {
        self.index(D_LINE)
    }

    /// Returns the Abbe number (nd - 1) / (nF - nC), by the formula.
    pub fn vd(&self) -> f64 {
        (self.nd() - 1.0) / (self.index(F_LINE) - self.index(C_LINE))
    }
}

/// Other names of glasses of the catalogue.
const ALIASES: &[(&str, &str)] = &[
    ("FUSED SILICA", "F_SILICA"),
    ("SILICA", "F_SILICA"),
    ("CALCIUM FLUORIDE", "CAF2"),
    ("FLUORITE", "CAF2"),
    ("ACRYLIC", "PMMA"),
    ("POLYCARBONATE", "POLYCARB"),
    ("POLYSTYRENE", "POLYSTYR"),
    ("ZEONEX E48R", "E48R"),
];

pub(super) fn all() -> impl Iterator<Item = &'static CatalogueGlass> {
    [schott::GLASSES, ohara::GLASSES, hoya::GLASSES, other::GLASSES].into_iter().flatten()
}

/// Returns the glass of a name, which may follow that of its manufacturer, as in "Schott N-BK7".
/// Case is ignored. One glass is never taken for another: "BK7" is not "N-BK7".
pub fn find_glass(name: &str) -> Option<&'static CatalogueGlass> {
    let name = name.trim();
    let same = |word: &str| word.eq_ignore_ascii_case(name);
    let name = ALIASES.iter().find(|(alias, _)| same(alias)).map_or(name, |(_, listed)| listed);
    let (maker, bare) = match name.split_once(char::is_whitespace) {
        Some((maker, rest)) => (Some(maker), rest.trim_start()),
        None => (None, name),
    };
    all().find(|glass| {
        glass.name.eq_ignore_ascii_case(bare)
            && maker.is_none_or(|maker| glass.maker.eq_ignore_ascii_case(maker))
    })
}

/// Returns the listed glass that an unknown name may mean: its lead-free successor ("N-BK7" for
/// "BK7"), or one of similar spelling.
pub fn suggest_glass(name: &str) -> Option<&'static str> {
    let bare = name.trim().rsplit(char::is_whitespace).next().unwrap_or_default();
    let successor = ["N-", "S-", "E-"].iter().find_map(|new| find_glass(&format!("{new}{bare}")));
    successor.map(|glass| glass.name).or_else(|| nearest_word(bare, all().map(|glass| glass.name)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the rounding of a catalogue, or the scatter of the data of plastics.
    fn tolerance(glass: &CatalogueGlass) -> f64 {
        if PLASTICS.contains(&glass.name) { 2e-5 } else { 1e-5 }
    }

    #[test]
    fn every_glass_has_its_published_index_and_abbe_number() {
        for glass in all() {
            let [nd, vd] = glass.published;
            assert!((glass.nd() - nd).abs() < tolerance(glass), "{}: {}", glass.name, glass.nd());
            assert!((glass.vd() - vd).abs() < 0.05, "{}: {}", glass.name, glass.vd());
        }
        assert!(all().count() > 200);
    }

    #[test]
    fn every_glass_has_an_index_at_every_wavelength() {
        for glass in all() {
            for nm in [-1.0, 0.0, 100.0, 300.0, 360.0, 830.0, 2500.0, 1e9, f64::INFINITY] {
                let n = glass.index(nm);
                assert!((1.3..2.7).contains(&n), "{} at {nm} nm: {n}", glass.name);
            }
            let colours: Vec<f64> = (36..=83).map(|nm| glass.index(f64::from(nm * 10))).collect();
            assert!(colours.is_sorted_by(|a, b| a > b), "{} is not normal", glass.name);
        }
    }

    #[test]
    fn names_are_found_in_common_spellings_and_are_listed_once() {
        for name in ["N-BK7", "n-bk7", "SCHOTT N-BK7", " schott  n-bk7 "] {
            assert_eq!(find_glass(name).map(|glass| glass.name), Some("N-BK7"), "{name:?}");
        }
        assert_eq!(find_glass("fused silica").map(|glass| glass.name), Some("F_SILICA"));
        for (alias, listed) in ALIASES {
            assert!(find_glass(listed).is_some() && find_glass(alias) == find_glass(listed));
        }
        for name in ["BK7", "Ohara N-BK7", "", " ", "N-BK7 Schott", "no such glass"] {
            assert_eq!(find_glass(name), None, "{name:?}");
        }
        for glass in all() {
            assert_eq!(find_glass(glass.name), Some(glass));
            assert_eq!(find_glass(&format!("{} {}", glass.maker, glass.name)), Some(glass));
        }
    }

    #[test]
    fn an_unlisted_glass_has_a_suggestion() {
        assert_eq!(suggest_glass("BK7"), Some("N-BK7"));
        assert_eq!(suggest_glass("Schott BK7"), Some("N-BK7"));
        assert_eq!(suggest_glass("NBK7"), Some("N-BK7"));
        assert_eq!(suggest_glass("window glass from the shop"), None);
    }
}
