//! Values of `--aov`.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use petzval_render::aov::Aov;

/// Returns the parser of one layer's name.
pub(in crate::cli) fn parser() -> impl TypedValueParser<Value = Aov> {
    let value = |aov: Aov| PossibleValue::new(aov.name()).help(aov.description());
    PossibleValuesParser::new(Aov::ALL.map(value)).try_map(|name| name.parse::<Aov>())
}
