//! Decisions of a plan, with their reasons.

use std::fmt;

use super::{DecidedBy, Effect, VisibilityThreshold};
use petzval_spectrum::VISIBLE_DIFFERENCE;

/// Estimated error of the picture if an effect is left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OmissionError {
    /// Displacement of light on the film: the root mean square, or the maximum if the effect is
    /// motion.
    Blur {
        /// The displacement (um).
        um: f64,
        /// The displacement (pixels).
        pixels: f64,
    },
    /// Error of the brightness (percent).
    Signal(f64),
    /// Error of a colour.
    Colour {
        /// The error of the channel that is most wrong, of the brightest one (percent).
        percent: f64,
        /// The difference of the colours (CIEDE2000).
        difference: f64,
    },
}

/// Visibility threshold of a change of brightness [percent]: the contrast threshold of the eye
/// (Weber fraction, 1 to 2 %).
pub(super) const VISIBLE_PERCENT: f64 = 1.0;

impl OmissionError {
    /// Returns whether the error can be seen: a blur from the threshold on, a change of brightness
    /// from 1 % on, a colour from a difference of 1 on. Effects that are neither asked for nor excluded are simulated by this rule.
    pub fn is_visible(&self, threshold: VisibilityThreshold) -> bool {
        match self {
            Self::Blur { pixels, .. } => *pixels >= threshold.pixels,
            Self::Signal(percent) => *percent >= VISIBLE_PERCENT,
            Self::Colour { difference, .. } => *difference >= VISIBLE_DIFFERENCE,
        }
    }

    /// Returns the least visible error of the same kind, in words.
    pub(super) fn limit(&self, threshold: VisibilityThreshold) -> String {
        match self {
            Self::Blur { .. } => format!("{} pixels", threshold.pixels),
            Self::Signal(_) => format!("{VISIBLE_PERCENT} %"),
            Self::Colour { .. } => format!("dE2000 {VISIBLE_DIFFERENCE}"),
        }
    }
}

impl fmt::Display for OmissionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Blur { um, pixels } => write!(f, "{um:.2} um, {pixels:.2} px"),
            Self::Signal(percent) => write!(f, "{percent:.1} %"),
            Self::Colour { percent, difference } => {
                write!(f, "{percent:.1} %, dE2000 {difference:.1}")
            }
        }
    }
}

/// Estimated cost of an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cost {
    /// The cost of a film sample (ns).
    pub ns_per_ray: f64,
    /// The share of the render time (percent).
    pub percent: f64,
}

/// Decision about one effect.
#[derive(Clone, Debug, PartialEq)]
pub struct Decision {
    /// The effect.
    pub effect: Effect,
    /// Whether it is simulated.
    pub on: bool,
    /// The source of the decision.
    pub by: DecidedBy,
    /// The reason, in a sentence.
    pub reason: String,
    /// The estimated error without it, if known.
    pub error: Option<OmissionError>,
    /// The estimated cost, if the effect is possible.
    pub cost: Option<Cost>,
}

/// Decision about light tracing: whether light paths find the images of lamps, and caustics. They
/// change the noise of the picture, not its light.
#[derive(Clone, Debug, PartialEq)]
pub struct LightTracingDecision {
    /// Whether light paths are traced.
    pub on: bool,
    /// The source of the decision.
    pub by: DecidedBy,
    /// The reason, in a sentence.
    pub reason: String,
}

impl Default for LightTracingDecision {
    fn default() -> Self {
        Self { on: false, by: DecidedBy::Scene, reason: String::new() }
    }
}

impl fmt::Display for LightTracingDecision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let on = if self.on { "on" } else { "off" };
        write!(f, "{on} ({}: {})", self.by.name(), self.reason)
    }
}

/// Decisions about all effects.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plan {
    /// One decision for each effect, in the order of [`Effect::ALL`].
    pub effects: Vec<Decision>,
    /// The decision about the images of lamps, and caustics.
    pub light_paths: LightTracingDecision,
}

impl Plan {
    /// Returns the plan that simulates these effects alone, without reasons.
    pub fn of(effects: &[Effect]) -> Self {
        let decide = |effect: Effect| Decision {
            effect,
            on: effects.contains(&effect),
            by: DecidedBy::Scene,
            reason: String::new(),
            error: None,
            cost: None,
        };
        Self { effects: Effect::ALL.map(decide).to_vec(), light_paths: Default::default() }
    }

    /// Returns the plan of a picture whose user turns off all effects. Nothing is measured for it.
    pub fn unwanted() -> Self {
        let mut plan = Self::of(&[]);
        for decision in &mut plan.effects {
            (decision.by, decision.reason) = (DecidedBy::Flag, "not wanted".to_owned());
        }
        plan
    }

    /// Returns whether an effect is simulated.
    pub fn has(&self, effect: Effect) -> bool {
        self.effects.iter().any(|decision| decision.effect == effect && decision.on)
    }

    /// Returns all decisions and their reasons in one line.
    pub fn line(&self) -> String {
        let one = |decision: &Decision| {
            let sign = if decision.on { '+' } else { '-' };
            format!("{sign}{} ({}: {})", decision.effect, decision.by.name(), decision.reason)
        };
        self.effects.iter().map(one).collect::<Vec<String>>().join("; ")
    }
}
