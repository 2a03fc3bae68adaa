//! Values of `--aov`.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use petzval::aov::Aov;

/// Returns the parser of one layer's name.
pub(in crate::cli) fn parser() -> impl TypedValueParser<Value = Aov> {
    let value = |aov: Aov| PossibleValue::new(aov.name()).help(help(aov));
    PossibleValuesParser::new(Aov::ALL.map(value)).try_map(|name| {
        let found = Aov::ALL.into_iter().find(|aov| aov.name() == name);
        found.ok_or_else(|| format!("no layer \"{name}\""))
    })
}

fn help(aov: Aov) -> &'static str {
    match aov {
        Aov::Depth => "Depth of the surfaces, and the share of the pixel that they cover",
        Aov::Position => "Position of the surfaces, world space",
        Aov::Normal => "Shading normals of the surfaces, world space",
        Aov::Albedo => "Share of light that the surfaces reflect or transmit",
        Aov::Object => "Index of the shape, and of its instance",
        Aov::Material => "Index of the material",
        Aov::Variance => "Square of the pixel's standard error",
        Aov::Samples => "Number of samples taken, and of those that passed the lens",
        Aov::Coc => "Diameter of the circle of confusion, um",
        Aov::Vignetting => "Share of the light that each surface of the lens blocks",
    }
}
