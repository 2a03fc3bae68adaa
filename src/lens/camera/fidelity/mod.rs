//! Fidelity of the camera model: from a pinhole to every surface traced in f64.

mod double;
mod gaussian;
mod polynomial;
mod simulate;
mod thin;

pub use simulate::on_axis_irradiance;

use std::fmt;

pub use double::{F64Columns, launched};
pub use gaussian::PupilPoint;

/// Fidelity of the lens model, from the crudest.
///
/// All models use the same film points and random numbers, and are exposed so that the middle of
/// the film gets the light that the real lens gives it. Pictures differ by the model alone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum Fidelity {
    /// A point in place of the entrance pupil.
    Pinhole,
    /// A disk in place of the entrance pupil, in perfect focus on one plane.
    Thin,
    /// Principal planes and pupils: perspective by first-order optics.
    Thick,
    /// First-order optics surface by surface, with every rim.
    Paraxial,
    /// A polynomial fitted to traced rays.
    Polynomial,
    /// Every surface traced in f32: the model of renders.
    #[default]
    Single,
    /// Every surface traced in f64.
    Double,
}

impl Fidelity {
    /// All models, from the crudest.
    pub const ALL: [Self; 7] = [
        Self::Pinhole,
        Self::Thin,
        Self::Thick,
        Self::Paraxial,
        Self::Polynomial,
        Self::Single,
        Self::Double,
    ];

    /// Returns a short name, for tables and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pinhole => "pinhole",
            Self::Thin => "thin",
            Self::Thick => "thick",
            Self::Paraxial => "paraxial",
            Self::Polynomial => "polynomial",
            Self::Single => "single",
            Self::Double => "double",
        }
    }

    /// Returns a description of the model and of what it leaves out.
    pub fn sentence(self) -> &'static str {
        match self {
            Self::Pinhole => {
                "A pinhole in the entrance pupil: no defocus, aberration, vignetting or fall-off."
            }
            Self::Thin => {
                "A disk in the entrance pupil, sharp on one plane: no aberration, vignetting or \
                 fall-off."
            }
            Self::Thick => {
                "Principal planes and a stop between them: fall-off, but no aberration, and no rim \
                 vignettes but the stop's."
            }
            Self::Paraxial => {
                "First-order optics surface by surface: every rim vignettes, but there is no \
                 aberration."
            }
            Self::Polynomial => {
                "A polynomial of low degree fitted to traced rays: aberrations as far as it goes; \
                 no dispersion, no losses."
            }
            Self::Single => "Every surface traced in f32, to a micrometre.",
            Self::Double => "Every surface traced in f64.",
        }
    }
}

impl fmt::Display for Fidelity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
