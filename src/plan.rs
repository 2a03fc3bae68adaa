//! Which effects a picture needs: each is simulated if leaving it out could be seen, and costs
//! nothing if not. The plan says what was decided, by whom, and why.

mod diffraction;
mod dispersion;
mod fresnel;

use std::fmt;
use std::str::FromStr;

use crate::lens::{Camera, Iris, Model};
use crate::sensor::Sensor;

/// What a picture may need beyond rays of one wavelength through a still, perfect camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Effect {
    /// Glass bends blue light more than red.
    Dispersion,
    /// Surfaces of glass mirror a part of the light.
    Fresnel,
    /// Light that was mirrored twice inside the lens.
    Ghosts,
    /// The shape of the stop.
    Iris,
    /// Light bends at the stop.
    Diffraction,
    /// Things or the camera move while the shutter is open.
    Motion,
    /// Rows of the sensor are read one after another.
    RollingShutter,
    /// Noise, full wells and steps of the sensor.
    Sensor,
    /// The film or an element stands askew.
    TiltShift,
}

impl Effect {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::Dispersion,
        Self::Fresnel,
        Self::Ghosts,
        Self::Iris,
        Self::Diffraction,
        Self::Motion,
        Self::RollingShutter,
        Self::Sensor,
        Self::TiltShift,
    ];

    /// Its name on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Dispersion => "dispersion",
            Self::Fresnel => "fresnel",
            Self::Ghosts => "ghosts",
            Self::Iris => "iris",
            Self::Diffraction => "diffraction",
            Self::Motion => "motion",
            Self::RollingShutter => "rolling_shutter",
            Self::Sensor => "sensor",
            Self::TiltShift => "tilt_shift",
        }
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

/// Who decided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum By {
    /// What the scene file says, or does not.
    Scene,
    /// What the lens file says, or does not.
    Lens,
    /// The command line.
    Flag,
}

impl By {
    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Scene => "scene",
            Self::Lens => "lens",
            Self::Flag => "flag",
        }
    }
}

/// What leaving an effect out would do to the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Harm {
    /// Light lands so far from where it should, um on the film, root mean square.
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

/// What the decisions are made from.
#[derive(Clone, Copy, Debug)]
pub struct Question<'a> {
    /// The camera, without effects.
    pub camera: &'a Camera,
    /// Width and height of the picture, pixels.
    pub resolution: [u32; 2],
    /// Whether the command line names a coating.
    pub coated: bool,
    /// The sensor that the command line asks for.
    pub sensor: Option<&'a Sensor>,
    /// Samples a pixel.
    pub samples: u32,
    /// Whether something in the scene file moves.
    pub moves: bool,
    /// What the command line asks for.
    pub wanted: &'a Wanted,
    /// What counts as visible.
    pub visible: Visible,
}

/// What is known of an effect before anybody decides.
struct Finding {
    by: By,
    reason: String,
    error: Option<Harm>,
    /// Whether it can be simulated here.
    possible: bool,
    /// Whether it should be, if nobody says anything.
    called_for: bool,
    cost: Option<Cost>,
}

impl Finding {
    fn not_called_for(by: By, reason: &str) -> Self {
        Self {
            by,
            reason: reason.to_owned(),
            error: None,
            possible: false,
            called_for: false,
            cost: None,
        }
    }
}

/// Decides effect by effect.
pub fn plan(question: &Question) -> Plan {
    Plan { effects: Effect::ALL.map(|effect| decide(effect, question)).to_vec() }
}

fn decide(effect: Effect, question: &Question) -> Decision {
    let Finding { by, reason, error, possible, called_for, cost } = find(effect, question);
    let (on, by, reason) = match question.wanted.of(effect) {
        Some(true) if possible => (true, By::Flag, format!("asked for; {reason}")),
        Some(false) if possible => (false, By::Flag, format!("not wanted; {reason}")),
        _ => (called_for && possible, by, reason),
    };
    Decision { effect, on, by, reason, error, cost }
}

fn find(effect: Effect, question: &Question) -> Finding {
    let Model::Real(lens) = &question.camera.model else {
        return match effect {
            Effect::Motion => motion(question),
            Effect::Sensor => sensor(question),
            Effect::RollingShutter | Effect::TiltShift => unasked(effect),
            _ => Finding::not_called_for(By::Scene, "the camera has no lens of glass"),
        };
    };
    match effect {
        Effect::Dispersion => dispersion::find(question, lens),
        Effect::Diffraction => diffraction::find(question, lens),
        Effect::Iris => {
            let rows = &lens.prescription.rows;
            let shaped = rows.iter().any(|row| row.iris != Iris::Round || row.obstruction > 0.0);
            let reason = match shaped {
                true => "the stop is not a circle",
                false => "the stop is a circle",
            };
            // Where it is not wanted, the camera already has a round stop.
            let possible = shaped || question.wanted.of(effect) == Some(false);
            Finding { possible, called_for: shaped, ..Finding::not_called_for(By::Lens, reason) }
        }
        Effect::Fresnel => fresnel::find(question, lens),
        Effect::Ghosts => Finding::not_called_for(By::Lens, "not simulated yet"),
        Effect::Motion => motion(question),
        Effect::Sensor => sensor(question),
        Effect::RollingShutter | Effect::TiltShift => unasked(effect),
    }
}

/// A sensor's noise in middle grey.
fn sensor(question: &Question) -> Finding {
    /// Of a pixel, ns: `cargo bench --bench effects -- sensor`.
    const NS: f64 = 230.0;
    let Some(sensor) = question.sensor else {
        return Finding::not_called_for(By::Scene, "the film is ideal, as the scene has it");
    };
    let noise = sensor.relative_noise(0.18);
    Finding {
        by: By::Flag,
        reason: format!("a sensor is asked for; middle grey has {noise:.1} % of noise"),
        error: Some(Harm::Signal(noise)),
        possible: true,
        called_for: true,
        cost: cost(NS / f64::from(question.samples.max(1))),
    }
}

fn motion(question: &Question) -> Finding {
    Finding::not_called_for(
        By::Scene,
        match question.moves {
            true => "something moves, which is not simulated yet",
            false => "nothing moves",
        },
    )
}

fn unasked(effect: Effect) -> Finding {
    let reason = match effect {
        Effect::RollingShutter => "all rows are exposed at once, as the scene has it",
        _ => "film and elements stand square to the axis",
    };
    Finding::not_called_for(By::Scene, reason)
}

/// What an effect costs: ns of a film sample, and the share of a frame in which one takes this long
/// in all (`cargo bench --bench render`, the double Gauss).
fn cost(ns_per_ray: f64) -> Option<Cost> {
    const SAMPLE: f64 = 520.0;
    Some(Cost { ns_per_ray, percent: 100.0 * ns_per_ray / (SAMPLE + ns_per_ray) })
}

/// Pixels a micrometre on the film, along the narrower side of a pixel.
fn pixels_per_um(question: &Question) -> f64 {
    let pitch = |i: usize| 1e3 * question.camera.film[i] / f64::from(question.resolution[i]);
    1.0 / pitch(0).min(pitch(1))
}
