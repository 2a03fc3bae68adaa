//! Glasses by name.

use super::{C_LINE, D_LINE, F_LINE, hoya, ohara, other, schott};
use crate::source::nearest;

/// A dispersion formula; wavelengths in micrometres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Formula {
    /// n^2 = 1 + the sum of b L^2 / (L^2 - c).
    Sellmeier {
        /// Strengths.
        b: [f64; 3],
        /// Squares of the resonances' wavelengths.
        c: [f64; 3],
    },
    /// n^2 = a0 + a1 L^2 + a2 L^-2 + a3 L^-4 + a4 L^-6 + a5 L^-8.
    Schott([f64; 6]),
}

/// A glass (or crystal, or plastic) whose dispersion is published.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CatalogueGlass {
    /// Its name in the catalogue.
    pub name: &'static str,
    /// Who makes it; empty for what many make.
    pub maker: &'static str,
    /// nd and Vd as published, rounded as there.
    pub published: [f64; 2],
    /// Its dispersion.
    pub formula: Formula,
}

/// The formulas are for light that the media let through; beyond, they have poles.
const TRANSPARENT: [f64; 2] = [300.0, 2500.0];
/// The formulas of plastics are fitted to less (Zemax catalogue "misc").
const PLASTIC: [f64; 2] = [365.0, 1060.0];
const PLASTICS: &[&str] = &["PMMA", "POLYCARB", "POLYSTYR", "E48R"];

impl CatalogueGlass {
    /// The shortest and the longest wavelength of the published data, nm.
    pub fn range(&self) -> [f64; 2] {
        if PLASTICS.contains(&self.name) { PLASTIC } else { TRANSPARENT }
    }

    /// The index at a wavelength, nm; outside 300 to 2500 nm it is that of the nearer end.
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

    /// The index at the d line, by the formula.
    pub fn nd(&self) -> f64 {
        self.index(D_LINE)
    }

    /// The Abbe number (nd - 1) / (nF - nC), by the formula.
    pub fn vd(&self) -> f64 {
        (self.nd() - 1.0) / (self.index(F_LINE) - self.index(C_LINE))
    }
}

/// Other words for what the catalogue has.
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

/// The glass of a name, which may stand behind its maker's, as in "Schott N-BK7". Capitals do not
/// matter. One glass is never taken for another: "BK7" is not "N-BK7".
pub fn catalogue(name: &str) -> Option<&'static CatalogueGlass> {
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

/// The listed glass that a misspelt name may mean: its successor without lead ("N-BK7" for
/// "BK7"), or what is spelt alike.
pub fn nearest_glass(name: &str) -> Option<&'static str> {
    let bare = name.trim().rsplit(char::is_whitespace).next().unwrap_or_default();
    let successor = ["N-", "S-", "E-"].iter().find_map(|new| catalogue(&format!("{new}{bare}")));
    successor.map(|glass| glass.name).or_else(|| nearest(bare, all().map(|glass| glass.name)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a catalogue rounds to, and the plastics are scattered by.
    fn rounding(glass: &CatalogueGlass) -> f64 {
        if PLASTICS.contains(&glass.name) { 2e-5 } else { 1e-5 }
    }

    #[test]
    fn every_glass_has_its_published_index_and_abbe_number() {
        for glass in all() {
            let [nd, vd] = glass.published;
            assert!((glass.nd() - nd).abs() < rounding(glass), "{}: {}", glass.name, glass.nd());
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
    fn names_are_found_as_people_write_them_and_are_listed_once() {
        for name in ["N-BK7", "n-bk7", "SCHOTT N-BK7", " schott  n-bk7 "] {
            assert_eq!(catalogue(name).map(|glass| glass.name), Some("N-BK7"), "{name:?}");
        }
        assert_eq!(catalogue("fused silica").map(|glass| glass.name), Some("F_SILICA"));
        for (alias, listed) in ALIASES {
            assert!(catalogue(listed).is_some() && catalogue(alias) == catalogue(listed));
        }
        for name in ["BK7", "Ohara N-BK7", "", " ", "N-BK7 Schott", "no such glass"] {
            assert_eq!(catalogue(name), None, "{name:?}");
        }
        for glass in all() {
            assert_eq!(catalogue(glass.name), Some(glass));
            assert_eq!(catalogue(&format!("{} {}", glass.maker, glass.name)), Some(glass));
        }
    }

    #[test]
    fn a_glass_that_is_not_listed_has_a_neighbour() {
        assert_eq!(nearest_glass("BK7"), Some("N-BK7"));
        assert_eq!(nearest_glass("Schott BK7"), Some("N-BK7"));
        assert_eq!(nearest_glass("NBK7"), Some("N-BK7"));
        assert_eq!(nearest_glass("window glass from the shop"), None);
    }
}
