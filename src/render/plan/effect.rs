//! Effects that a plan decides about, and the macro that makes them of their list.

use std::fmt;
use std::str::FromStr;

use super::{Effect, Finding, PlanInput};
use petzval_lens::RealLens;

/// The function that finds the data for the decision about an effect.
#[derive(Clone, Copy)]
pub(super) enum Finder {
    /// For an effect of any camera.
    AnyCamera(fn(&PlanInput) -> Finding),
    /// For an effect of lenses of glass.
    LensOfGlass(fn(&PlanInput, &RealLens) -> Finding),
}

/// Defines [`Effect`] from the list of effects, in the order of reports: `Effect = "name" by finder`.
macro_rules! effects {
    ($($(#[$about:meta])* $effect:ident = $name:literal by $finder:ident($find:expr),)+) => {
        /// Effect beyond rays of one wavelength through an ideal camera at rest.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[non_exhaustive]
        pub enum Effect {
            $($(#[$about])* $effect,)+
        }

        impl Effect {
            /// All effects.
            pub const ALL: [Self; [$(Self::$effect),+].len()] = [$(Self::$effect),+];

            /// Returns the name on the command line and in reports.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$effect => $name,)+
                }
            }

            fn finder(self) -> Finder {
                match self {
                    $(Self::$effect => Finder::$finder($find),)+
                }
            }
        }
    };
}
pub(super) use effects;

impl fmt::Display for Effect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Effect {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|effect| effect.name() == name).ok_or_else(|| {
            let known = Self::ALL.map(Self::name).join(", ");
            format!("no effect \"{name}\"; expected one of {known}")
        })
    }
}

/// Source of a decision.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DecidedBy {
    /// The scene file.
    Scene,
    /// The lens file.
    Lens,
    /// The command line.
    Flag,
}

impl DecidedBy {
    /// Returns the name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Scene => "scene",
            Self::Lens => "lens",
            Self::Flag => "flag",
        }
    }
}
