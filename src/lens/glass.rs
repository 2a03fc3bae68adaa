//! Media: how a refractive index depends on wavelength.

/// How the index of a medium changes with wavelength.
#[derive(Clone, Debug, PartialEq)]
pub enum Glass {
    /// It does not, as far as the file says.
    Constant,
}

impl Glass {
    /// The index at a wavelength, nm, of a medium whose index at the d line is `nd`.
    pub fn index(&self, nd: f64, _nm: f64) -> f64 {
        match self {
            Self::Constant => nd,
        }
    }
}
