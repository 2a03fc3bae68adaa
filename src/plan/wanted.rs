//! What the command line says about effects.

use std::str::FromStr;

use super::Effect;

/// What the command line asks for.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Wanted {
    /// What can be seen.
    #[default]
    Auto,
    /// All that can be simulated.
    All,
    /// Nothing.
    None,
    /// What can be seen, but for these.
    But(Vec<(Effect, bool)>),
}

impl FromStr for Wanted {
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
        text.split(',').map(one).collect::<Result<_, String>>().map(Self::But)
    }
}

impl Wanted {
    /// What is asked of an effect; `None` where what can be seen decides.
    pub fn of(&self, effect: Effect) -> Option<bool> {
        match self {
            Self::Auto => None,
            Self::All => Some(true),
            Self::None => Some(false),
            Self::But(list) => {
                list.iter().rev().find(|(named, _)| *named == effect).map(|(_, on)| *on)
            }
        }
    }
}

/// From what on an effect counts as visible.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Visible {
    /// Displacement or blur, pixels.
    pub pixels: f64,
}

impl Default for Visible {
    fn default() -> Self {
        Self { pixels: 0.5 }
    }
}

impl FromStr for Visible {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = text.strip_suffix("px").unwrap_or(text);
        match number.parse() {
            Ok(pixels) if pixels >= 0.0 => Ok(Self { pixels }),
            _ => Err("expected a number of pixels, such as 0.5px".to_owned()),
        }
    }
}
