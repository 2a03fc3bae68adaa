//! Effect selection and visibility threshold of the command line.

use std::str::FromStr;

use super::Effect;

/// Effects that the command line asks for.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum EffectSelection {
    /// The visible effects.
    #[default]
    Auto,
    /// All possible effects.
    All,
    /// No effects.
    None,
    /// The visible effects, with these turned on or off.
    Overrides(Vec<(Effect, bool)>),
}

impl FromStr for EffectSelection {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => return Ok(Self::Auto),
            "all" => return Ok(Self::All),
            "none" => return Ok(Self::None),
            _ => {}
        }
        let one = |word: &str| {
            let word = word.trim();
            match (word.strip_prefix('+'), word.strip_prefix('-')) {
                (Some(name), _) => Ok((name.parse()?, true)),
                (_, Some(name)) => Ok((name.parse()?, false)),
                _ => Err(format!(
                    "\"{word}\"; expected auto, all, none, or a list such as +dispersion,-iris"
                )),
            }
        };
        text.split(',').map(one).collect::<Result<_, String>>().map(Self::Overrides)
    }
}

impl EffectSelection {
    /// Returns whether an effect is asked for or excluded; `None` if its visibility decides.
    pub fn of(&self, effect: Effect) -> Option<bool> {
        match self {
            Self::Auto => None,
            Self::All => Some(true),
            Self::None => Some(false),
            Self::Overrides(list) => {
                list.iter().rev().find(|(named, _)| *named == effect).map(|(_, on)| *on)
            }
        }
    }
}

/// Error above which an effect counts as visible.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VisibilityThreshold {
    /// The displacement or blur (pixels).
    pub pixels: f64,
}

impl Default for VisibilityThreshold {
    fn default() -> Self {
        Self { pixels: 0.5 }
    }
}

impl FromStr for VisibilityThreshold {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = text.strip_suffix("px").unwrap_or(text);
        match number.parse() {
            Ok(pixels) if pixels >= 0.0 => Ok(Self { pixels }),
            _ => Err("expected a number of pixels, such as 0.5px".to_owned()),
        }
    }
}
