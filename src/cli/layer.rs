//! The names of layers.

use clap::ValueEnum;
use petzval::aov::Aov;

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum AovArgument {
    /// How far the surfaces are, and which share of a pixel they cover
    Depth,
    /// Where they are, world space
    Position,
    /// Their normals, world space
    Normal,
    /// The share of light that they send back
    Albedo,
    /// The number of the shape, and of the instance
    Object,
    /// The number of the material
    Material,
    /// The square of the pixel's standard error
    Variance,
    /// How many samples were taken, and came through the lens
    Samples,
    /// Diameter of the circle of confusion, um
    Coc,
    /// Which surface of the lens takes which share of the light
    Vignetting,
}

impl From<AovArgument> for Aov {
    fn from(argument: AovArgument) -> Self {
        match argument {
            AovArgument::Depth => Self::Depth,
            AovArgument::Position => Self::Position,
            AovArgument::Normal => Self::Normal,
            AovArgument::Albedo => Self::Albedo,
            AovArgument::Object => Self::Object,
            AovArgument::Material => Self::Material,
            AovArgument::Variance => Self::Variance,
            AovArgument::Samples => Self::Samples,
            AovArgument::Coc => Self::Coc,
            AovArgument::Vignetting => Self::Vignetting,
        }
    }
}
