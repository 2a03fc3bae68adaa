//! Dispersion of optical media: refractive index by wavelength.

mod absorption;
mod agf;
mod built_in;
mod catalogue;
mod code;
mod error;
mod formula;
mod library;
mod likely_glass;
mod model;
mod shelf;
mod spelling;
mod table;

use std::sync::Arc;

pub use likely_glass::likely_glass;

pub use absorption::{Absorption, InternalTransmittance};
pub use agf::parse as parse_agf;
pub use catalogue::CatalogueGlass;
pub use error::{GlassError, IndexRangeError};
pub use formula::Formula;
pub use library::{GlassLibrary, GlassMatch, find_glass, suggest_glass};

/// The d line of helium, at which catalogues and patents state an index (nm).
pub const D_LINE: f64 = 587.5618;
/// The F line of hydrogen (nm).
pub const F_LINE: f64 = 486.1327;
/// The C line of hydrogen (nm).
pub const C_LINE: f64 = 656.2725;

/// The g line of mercury (nm).
const G_LINE: f64 = 435.8343;

/// Range in which a model of the F, d and C lines stays within 1e-3 of real glass (nm).
const VISIBLE: [f64; 2] = [380.0, 780.0];
/// Range in which that model may be used, with a warning (nm): silicon sensors see no further.
const MODEL: [f64; 2] = [350.0, 1100.0];
/// Share of a wavelength by which it may lie outside stated data, with a warning.
const TOLERANCE: f64 = 0.02;

/// Dispersion of a medium.
#[derive(Clone, Debug, PartialEq)]
pub enum Glass {
    /// No stated dispersion: the index is constant.
    Constant,
    /// Cauchy's n = A + B / lambda^2, with A and B from the index at the d line and the Abbe
    /// number.
    Abbe {
        /// Index at the d line.
        nd: f64,
        /// Abbe number (nd - 1) / (nF - nC).
        vd: f64,
    },
    /// Pairs of wavelength (nm), increasing, and index. Between two entries the index is linear in
    /// 1 / lambda^2.
    Table(Arc<[[f64; 2]]>),
    /// A glass with a formula: of a catalogue, of a lens file, or a model.
    Catalogue(Arc<CatalogueGlass>),
}

impl Glass {
    /// Returns the index at a wavelength (nm). `stated` is the index of a medium without stated
    /// dispersion; every other medium knows its own.
    ///
    /// # Errors
    /// Returns an error outside [`Self::usable_range`].
    pub fn index(&self, stated: f64, nm: f64) -> Result<f64, IndexRangeError> {
        self.check(nm)?;
        let index = match self {
            Self::Catalogue(glass) => glass.formula.index(nm),
            _ => self.nearest_index(stated, nm),
        };
        // A catalogue may state a range in which its formula has a pole.
        if index.is_finite() { Ok(index) } else { Err(self.out_of_range(nm)) }
    }

    /// As [`Self::index`], for light whose wavelengths were checked. Outside the usable range the
    /// index is that of the end of the data, or that of Cauchy's formula.
    pub fn nearest_index(&self, stated: f64, nm: f64) -> f64 {
        match self {
            Self::Constant => stated,
            Self::Abbe { nd, vd } => cauchy(*nd, *vd, nm),
            Self::Table(entries) => table::linear(entries, nm).unwrap_or(stated),
            Self::Catalogue(glass) => self.index(stated, nm).unwrap_or_else(|_| glass.index(nm)),
        }
    }

    /// Returns an error if a wavelength (nm) lies outside [`Self::usable_range`].
    ///
    /// # Errors
    /// The error names the medium, its range and the wavelength.
    pub fn check(&self, nm: f64) -> Result<(), IndexRangeError> {
        let Some([low, high]) = self.usable_range() else { return Ok(()) };
        if (low..=high).contains(&nm) {
            return Ok(());
        }
        Err(self.out_of_range(nm))
    }

    fn out_of_range(&self, nm: f64) -> IndexRangeError {
        let range = self.range().unwrap_or_default();
        IndexRangeError { surface: None, glass: self.to_string(), range, wavelength: nm }
    }

    /// Returns the index at the d line, or at the nearest wavelength of the data; 1 for a medium
    /// without stated dispersion.
    pub fn nd(&self) -> f64 {
        self.nearest_index(1.0, D_LINE)
    }

    /// Returns the shortest and the longest wavelength of the data (nm); `None` for an empty table.
    pub fn range(&self) -> Option<[f64; 2]> {
        match self {
            Self::Constant => Some([D_LINE; 2]),
            Self::Abbe { .. } => Some(VISIBLE),
            Self::Table(entries) => Some([entries.first()?[0], entries.last()?[0]]),
            Self::Catalogue(glass) => Some(glass.range),
        }
    }

    /// Returns the shortest and the longest wavelength (nm) at which [`Self::index`] has a value: 2 %
    /// beyond the data of glasses and tables, 350 to 1100 nm for an Abbe number. `None` if it has
    /// one everywhere.
    pub fn usable_range(&self) -> Option<[f64; 2]> {
        match self {
            Self::Constant => None,
            Self::Abbe { .. } => Some(MODEL),
            Self::Table(_) | Self::Catalogue(_) => {
                self.range().map(|[low, high]| [low * (1.0 - TOLERANCE), high * (1.0 + TOLERANCE)])
            }
        }
    }

    /// Returns the Abbe number (nd - 1) / (nF - nC); `None` without stated dispersion, or if the data
    /// do not cover the three lines.
    pub fn abbe_number(&self) -> Option<f64> {
        if !self.disperses() {
            return None;
        }
        let index = |nm| self.index(1.0, nm).ok();
        let [d, blue, red] = [index(D_LINE)?, index(F_LINE)?, index(C_LINE)?];
        Some((d - 1.0) / (blue - red)).filter(|vd| vd.is_finite())
    }

    /// Returns the name of a glass; `None` for a medium that is given by its index or dispersion.
    pub fn name(&self) -> Option<&str> {
        match self {
            Self::Catalogue(glass) => Some(&glass.name),
            _ => None,
        }
    }

    /// Returns the absorption coefficient (1/mm) at a wavelength (nm); 0 where none is known.
    pub fn absorption(&self, nm: f64) -> f64 {
        match self {
            Self::Catalogue(glass) => glass.absorption.coefficient(nm),
            _ => 0.0,
        }
    }

    /// Returns whether the glass absorbs some light.
    pub fn absorbs(&self) -> bool {
        matches!(self, Self::Catalogue(glass) if glass.absorption.measured().iter().any(|entry| entry.share < 1.0))
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

impl std::fmt::Display for Glass {
    /// Names the medium: the glass, or the kind of data.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Constant => f.write_str("the constant index"),
            Self::Abbe { .. } => f.write_str("the medium given by its Abbe number"),
            Self::Table(_) => f.write_str("the medium given by a table of indices"),
            Self::Catalogue(glass) => f.write_str(&glass.full_name()),
        }
    }
}

impl From<Arc<CatalogueGlass>> for Glass {
    fn from(glass: Arc<CatalogueGlass>) -> Self {
        Self::Catalogue(glass)
    }
}

fn inverse_square(nm: f64) -> f64 {
    (nm * nm).recip()
}

fn cauchy(nd: f64, vd: f64, nm: f64) -> f64 {
    let b = (nd - 1.0) / (vd * (inverse_square(F_LINE) - inverse_square(C_LINE)));
    nd + b * (inverse_square(nm) - inverse_square(D_LINE))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_abbe_number_is_met_exactly() {
        for (nd, vd) in [(1.5168, 64.17), (1.92286, 18.9), (1.43875, 94.9), (1.0, 50.0)] {
            let index = |nm: f64| Glass::Abbe { nd, vd }.index(9.0, nm).unwrap();
            assert_eq!(index(D_LINE), nd);
            assert!((index(F_LINE) - index(C_LINE) - (nd - 1.0) / vd).abs() < 1e-15);
        }
    }

    #[test]
    fn the_model_stays_near_a_real_glass_in_the_visible() {
        let real = find_glass("N-BK7").expect("listed");
        let model = Glass::Abbe { nd: real.nd(), vd: real.vd() };
        for nm in [400.0, 450.0, 500.0, 550.0, 600.0, 650.0, 700.0] {
            assert!((model.index(1.0, nm).unwrap() - real.index(nm)).abs() < 6e-4, "{nm}");
        }
    }

    #[test]
    fn a_table_is_exact_at_its_entries_and_ends_there() {
        let entries = [[450.0, 1.53], [550.0, 1.52], [700.0, 1.51]];
        let glass = Glass::Table(entries.into());
        for [nm, n] in entries {
            assert_eq!(glass.index(0.0, nm), Ok(n));
        }
        assert_eq!(glass.index(0.0, 445.0), Ok(1.53));
        for nm in [300.0, 900.0] {
            assert_eq!(glass.index(0.0, nm).unwrap_err().wavelength, nm);
        }
        // Linear in 1 / lambda^2.
        let middle = (0.5 * (inverse_square(450.0) + inverse_square(550.0))).sqrt().recip();
        assert!((glass.index(0.0, middle).unwrap() - 1.525).abs() < 1e-12);
        assert!(glass.disperses());
        assert!(!Glass::Table([[500.0, 1.5], [600.0, 1.5]].into()).disperses());
    }

    #[test]
    fn a_wavelength_outside_the_data_is_an_error_that_names_the_glass() {
        let glass = Glass::from(find_glass("N-BK7").expect("listed"));
        assert!(glass.index(1.0, 2540.0).is_ok());
        let error = glass.index(1.0, 10_000.0).unwrap_err().to_string();
        assert!(
            error.contains("Schott N-BK7 is known from 300 to 2500 nm, not at 10000"),
            "{error}"
        );
        assert!(glass.index(1.0, f64::NAN).is_err());
    }
}
