//! A glass whose dispersion is published.

use std::borrow::Cow;

use super::{Absorption, C_LINE, D_LINE, F_LINE, Formula, G_LINE};

/// A glass (or crystal, plastic or liquid) whose dispersion is published.
#[derive(Clone, Debug, PartialEq)]
pub struct CatalogueGlass {
    /// Name in the catalogue.
    pub name: Cow<'static, str>,
    /// Manufacturer, or name of the catalogue; empty for materials of several.
    pub maker: Cow<'static, str>,
    /// nd and Vd as published, rounded; `None` where the source states none.
    pub published: Option<[f64; 2]>,
    /// Dispersion formula.
    pub formula: Formula,
    /// Shortest and longest wavelength of the data (nm).
    pub range: [f64; 2],
    /// Absorption, if the catalogue states internal transmittances.
    pub absorption: Absorption,
}

impl CatalogueGlass {
    /// Returns whether the data cover a wavelength (nm).
    pub fn covers(&self, nm: f64) -> bool {
        (self.range[0]..=self.range[1]).contains(&nm)
    }

    /// Returns the index at a wavelength (nm); outside the range it is that of the nearer end.
    pub fn index(&self, nm: f64) -> f64 {
        self.formula.index(nm.clamp(self.range[0], self.range[1]))
    }

    /// Returns the index at the d line, by the formula.
    pub fn nd(&self) -> f64 {
        self.index(D_LINE)
    }

    /// Returns the Abbe number (nd - 1) / (nF - nC), by the formula.
    pub fn vd(&self) -> f64 {
        (self.nd() - 1.0) / (self.index(F_LINE) - self.index(C_LINE))
    }

    /// Returns the partial dispersion PgF = (ng - nF) / (nF - nC), by the formula.
    pub fn partial_dispersion(&self) -> f64 {
        let [g, blue, red] = [G_LINE, F_LINE, C_LINE].map(|nm| self.index(nm));
        (g - blue) / (blue - red)
    }

    /// Returns the maker and the name, as in "Schott N-BK7".
    pub fn full_name(&self) -> String {
        format!("{} {}", self.maker, self.name).trim_start().to_owned()
    }
}
