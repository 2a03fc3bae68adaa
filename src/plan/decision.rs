//! What was decided, and why.

use std::fmt;

use super::{By, Effect};

/// What leaving an effect out would do to the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Harm {
    /// Light lands so far from where it should, um on the film: root mean square, or as far as
    /// anything goes where things move.
    Blur {
        /// um.
        um: f64,
        /// The same in pixels.
        pixels: f64,
    },
    /// The picture is so much too bright or too dark, in percent.
    Signal(f64),
}

impl fmt::Display for Harm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Blur { um, pixels } => write!(f, "{um:.2} um, {pixels:.2} px"),
            Self::Signal(percent) => write!(f, "{percent:.1} %"),
        }
    }
}

/// What an effect takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cost {
    /// Of a film sample.
    pub ns_per_ray: f64,
    /// Of the time of a frame, percent.
    pub percent: f64,
}

/// One effect of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct Decision {
    /// Which.
    pub effect: Effect,
    /// Whether it is simulated.
    pub on: bool,
    /// Who decided.
    pub by: By,
    /// Why, in a sentence.
    pub reason: String,
    /// Estimate of what leaving it out would do, where that can be told.
    pub error: Option<Harm>,
    /// Estimate of what it takes, where it can be had.
    pub cost: Option<Cost>,
}

/// All effects, decided.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plan {
    /// One for each effect, in their order.
    pub effects: Vec<Decision>,
}

impl Plan {
    /// Whether an effect is simulated.
    pub fn has(&self, effect: Effect) -> bool {
        self.effects.iter().any(|decision| decision.effect == effect && decision.on)
    }

    /// In one line: what is on, and why what is off is off.
    pub fn line(&self) -> String {
        let one = |decision: &Decision| {
            let sign = if decision.on { '+' } else { '-' };
            format!(
                "{sign}{} ({}: {})",
                decision.effect.name(),
                decision.by.name(),
                decision.reason
            )
        };
        self.effects.iter().map(one).collect::<Vec<String>>().join("; ")
    }
}
