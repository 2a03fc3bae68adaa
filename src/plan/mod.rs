//! Which effects a picture needs: each is simulated if leaving it out could be seen, and costs
//! nothing if not. The plan says what was decided, by whom, and why.

mod decision;
mod diffraction;
mod dispersion;
mod effect;
mod fresnel;
mod ghosts;
mod iris;
mod motion;
mod rolling_shutter;
mod sensor;
mod tilt_shift;
mod travel;
mod view;
mod wanted;

pub use decision::{Cost, Decision, Harm, Plan};
pub use effect::{By, Effect};
pub use tilt_shift::Posed;
pub use travel::Moves;
pub use wanted::{Visible, Wanted};

use crate::ghosts::Sighting;
use crate::lens::{Camera, Model};
use crate::sensor::Sensor;
use crate::spectrum::LightBand;

/// Whether effects are in the program at all: not if it was built with the feature `bare`. Where an
/// effect has a branch in a hot stage, the branch asks this too, so that both builds can be compared.
pub const EFFECTS: bool = cfg!(not(feature = "bare"));

/// What the decisions are made from.
#[derive(Clone, Copy, Debug)]
pub struct Question<'a> {
    /// The camera, without effects.
    pub camera: &'a Camera,
    /// Width and height of the picture, pixels.
    pub resolution: [u32; 2],
    /// The light, as a lens that disperses takes it apart.
    pub bands: &'a [LightBand],
    /// Whether dispersion was guessed where it is not known.
    pub assumed: bool,
    /// Whether the command line names a coating.
    pub coated: bool,
    /// What ghosts the lens makes of the scene's lights, if any.
    pub ghosts: Option<&'a Sighting>,
    /// How bright the picture will be.
    pub level: Level,
    /// The sensor that the command line asks for.
    pub sensor: Option<&'a Sensor>,
    /// Samples a pixel.
    pub samples: u32,
    /// What moves, and when.
    pub moves: Moves<'a>,
    /// What does not stand square, in the camera or set square in it.
    pub posed: Option<&'a Posed>,
    /// What the command line asks for.
    pub wanted: &'a Wanted,
    /// What counts as visible.
    pub visible: Visible,
}

/// How bright a picture will be, in luminance, and what it takes without effects; by a small one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Level {
    /// Its mean without its brightest tenth: lamps and their reflections are not what a veil of light
    /// is seen on.
    pub mean: f64,
    /// What the brightest spot of the small picture adds to that, as light of so many pixels of 1.
    pub lamp: f64,
    /// What a film sample takes, ns: by what is counted, not by a clock, so that a plan is always the
    /// same.
    pub sample: f64,
    /// Rays through the scene for a film sample, shadow rays among them.
    pub rays: f64,
}

impl Level {
    /// A veil of light, percent of the picture's mean. Light in a black picture is all there is.
    fn percent(&self, light: f64) -> f64 {
        let percent = match self.mean > 0.0 {
            true => 100.0 * light / self.mean,
            false if light > 0.0 => 100.0,
            false => 0.0,
        };
        // Of a lamp beyond all numbers nothing can be told.
        if percent.is_finite() { percent } else { 0.0 }
    }
}

/// From which share of the picture's brightness on, percent, a veil of light can be seen: the
/// threshold of contrast of the eye (Weber's fraction, 1 to 2 %).
const VEIL: f64 = 1.0;

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
    let possible = possible && EFFECTS;
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
            Effect::Motion => motion::find(question),
            Effect::Sensor => sensor::find(question),
            Effect::RollingShutter => rolling_shutter::find(question),
            Effect::TiltShift => tilt_shift::square(),
            _ => Finding::not_called_for(By::Scene, "the camera has no lens of glass"),
        };
    };
    match effect {
        Effect::Dispersion => dispersion::find(question, lens),
        Effect::Diffraction => diffraction::find(question, lens),
        Effect::Iris => iris::find(question, lens),
        Effect::Fresnel => fresnel::find(question, lens),
        Effect::Ghosts => ghosts::find(question),
        Effect::Motion => motion::find(question),
        Effect::Sensor => sensor::find(question),
        Effect::RollingShutter => rolling_shutter::find(question),
        Effect::TiltShift => tilt_shift::find(question, lens),
    }
}

/// What an effect costs: ns of a film sample, and their share of all that one takes with it.
fn cost(question: &Question, ns_per_ray: f64) -> Option<Cost> {
    let all = question.level.sample + ns_per_ray;
    let percent = if all > 0.0 { 100.0 * ns_per_ray / all } else { 0.0 };
    Some(Cost { ns_per_ray, percent })
}

/// Pixels a micrometre on the film, along the narrower side of a pixel.
fn pixels_per_um(question: &Question) -> f64 {
    let pitch = |i: usize| 1e3 * question.camera.film[i] / f64::from(question.resolution[i]);
    1.0 / pitch(0).min(pitch(1))
}
