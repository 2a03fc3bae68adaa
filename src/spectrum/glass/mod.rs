//! Dispersion of optical media: refractive index by wavelength.

mod catalogue;
mod hoya;
mod likely_glass;
mod ohara;
mod other;
mod schott;

use std::sync::Arc;

pub(crate) use likely_glass::likely_glass;

pub use catalogue::{CatalogueGlass, Formula, find_glass, suggest_glass};

/// The d line of helium, at which catalogues and patents state an index (nm).
pub const D_LINE: f64 = 587.5618;
/// The F line of hydrogen (nm).
pub const F_LINE: f64 = 486.1327;
/// The C line of hydrogen (nm).
pub const C_LINE: f64 = 656.2725;

/// Range in which a model of the F, d and C lines stays within 1e-3 of real glass (nm).
const VISIBLE: [f64; 2] = [380.0, 780.0];

/// Dispersion of a medium.
#[derive(Clone, Debug, PartialEq)]
pub enum Glass {
    /// No stated dispersion: the index is constant.
    Constant,
    /// Cauchy's n = A + B / lambda^2, with A and B from the index at the d line and the Abbe
    /// number.
    Abbe {
        /// Abbe number (nd - 1) / (nF - nC).
        vd: f64,
    },
    /// Pairs of wavelength (nm), increasing, and index. Between two entries the index is linear in
    /// 1 / lambda^2; beyond the ends it is that of the end.
    Table(Arc<[[f64; 2]]>),
    /// A glass of the catalogue.
    Catalogue(&'static CatalogueGlass),
}

impl Glass {
    /// Returns the index at a wavelength (nm) of a medium whose index at the d line is `nd`.
    pub fn index(&self, nd: f64, nm: f64) -> f64 {
        match self {
            Self::Constant => nd,
            Self::Abbe { vd } => cauchy(nd, *vd, nm),
            Self::Table(entries) => interpolate(entries, nm).unwrap_or(nd),
            Self::Catalogue(glass) => glass.index(nm),
        }
    }

    /// Returns the shortest and the longest wavelength of the data (nm); `None` for an empty table.
    pub fn range(&self) -> Option<[f64; 2]> {
        match self {
            Self::Constant => Some([D_LINE; 2]),
            Self::Abbe { .. } => Some(VISIBLE),
            Self::Table(entries) => Some([entries.first()?[0], entries.last()?[0]]),
            Self::Catalogue(glass) => Some(glass.range()),
        }
    }

    /// Returns whether the index is known to change with wavelength.
    pub fn disperses(&self) -> bool {
        match self {
            Self::Constant => false,
            Self::Abbe { .. } | Self::Catalogue(_) => true,
            Self::Table(entries) => entries.windows(2).any(|pair| pair[0][1] != pair[1][1]),
        }
    }
}

fn inverse_square(nm: f64) -> f64 {
    (nm * nm).recip()
}

fn cauchy(nd: f64, vd: f64, nm: f64) -> f64 {
    let b = (nd - 1.0) / (vd * (inverse_square(F_LINE) - inverse_square(C_LINE)));
    nd + b * (inverse_square(nm) - inverse_square(D_LINE))
}

fn interpolate(entries: &[[f64; 2]], nm: f64) -> Option<f64> {
    let after = entries.partition_point(|entry| entry[0] <= nm);
    let Some(before) = after.checked_sub(1) else { return entries.first().map(|entry| entry[1]) };
    let [low, n] = entries[before];
    let Some(&[high, n_high]) = entries.get(after) else { return Some(n) };
    let share =
        (inverse_square(low) - inverse_square(nm)) / (inverse_square(low) - inverse_square(high));
    Some(n + share * (n_high - n))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_abbe_number_is_met_exactly() {
        for (nd, vd) in [(1.5168, 64.17), (1.92286, 18.9), (1.43875, 94.9), (1.0, 50.0)] {
            let glass = Glass::Abbe { vd };
            assert_eq!(glass.index(nd, D_LINE), nd);
            let spread = glass.index(nd, F_LINE) - glass.index(nd, C_LINE);
            assert!((spread - (nd - 1.0) / vd).abs() < 1e-15);
        }
    }

    #[test]
    fn the_model_stays_near_a_real_glass_in_the_visible() {
        let real = find_glass("N-BK7").expect("listed");
        let model = Glass::Abbe { vd: real.vd() };
        for nm in [400.0, 450.0, 500.0, 550.0, 600.0, 650.0, 700.0] {
            assert!((model.index(real.nd(), nm) - real.index(nm)).abs() < 6e-4, "{nm}");
        }
    }

    #[test]
    fn a_table_is_exact_at_its_entries_and_flat_beyond() {
        let entries = [[450.0, 1.53], [550.0, 1.52], [700.0, 1.51]];
        let glass = Glass::Table(entries.into());
        for [nm, n] in entries {
            assert_eq!(glass.index(0.0, nm), n);
        }
        assert_eq!(glass.index(0.0, 300.0), 1.53);
        assert_eq!(glass.index(0.0, 900.0), 1.51);
        // Linear in 1 / lambda^2.
        let middle = (0.5 * (inverse_square(450.0) + inverse_square(550.0))).sqrt().recip();
        assert!((glass.index(0.0, middle) - 1.525).abs() < 1e-12);
        assert!(glass.disperses());
        assert!(!Glass::Table([[500.0, 1.5], [600.0, 1.5]].into()).disperses());
    }
}
