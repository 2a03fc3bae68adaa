//! Plan of effects: decides which effects a picture needs.
//!
//! An effect is simulated if its absence would be visible, and costs nothing if it is not. The plan
//! records each decision with its source and reason.

mod decision;
mod diffraction;
mod dispersion;
mod effect;
mod fresnel;
mod ghosts;
mod image_motion;
mod iris;
mod media;
mod motion;
mod rolling_shutter;
mod selection;
mod sensor;
mod spectra;
mod tilt_shift;

pub use decision::{Cost, Decision, LightTracingDecision, OmissionError, Plan};
pub use effect::DecidedBy;
pub use image_motion::MotionInput;
pub use selection::{EffectSelection, VisibilityThreshold};
pub use tilt_shift::Misalignment;

use std::sync::{Arc, OnceLock};

use rayon::prelude::*;

use crate::diffraction::Diffraction;
use crate::light_tracing::ghosts::GhostEstimate;
use crate::sensor::Sensor;
use effect::{Finder, effects};
use petzval_lens::{Camera, LensModel};
use petzval_spectrum::LightBand;

// A new effect adds its line here: `Effect = "name" by finder`.
effects! {
    /// Dispersion: the refractive index depends on the wavelength.
    Dispersion = "dispersion" by LensOfGlass(dispersion::find),
    /// Fresnel losses: surfaces of the lens reflect a part of the light.
    Fresnel = "fresnel" by LensOfGlass(fresnel::find),
    /// Ghosts: light that is reflected twice inside the lens.
    Ghosts = "ghosts" by LensOfGlass(|input, _| ghosts::find(input)),
    /// The shape of the stop.
    Iris = "iris" by LensOfGlass(iris::find),
    /// Diffraction at the stop.
    Diffraction = "diffraction" by LensOfGlass(diffraction::find),
    /// Motion blur: objects or the camera move while the shutter is open.
    Motion = "motion" by AnyCamera(motion::find),
    /// Rolling shutter: the rows of the sensor are read one after another.
    RollingShutter = "rolling_shutter" by AnyCamera(rolling_shutter::find),
    /// Noise, saturation and quantization of the sensor.
    Sensor = "sensor" by AnyCamera(sensor::find),
    /// Tilt and shift of the film, and decentred or tilted lens elements.
    TiltShift = "tilt_shift" by AnyCamera(tilt_shift::find),
    /// Participating media, such as fog, smoke and clouds.
    Media = "media" by AnyCamera(media::find),
    /// Spectra: paths carry wavelengths in place of red, green and blue.
    Spectra = "spectra" by AnyCamera(spectra::find),
}

/// Data that the decisions are based on.
#[derive(Clone, Copy, Debug)]
pub struct PlanInput<'a> {
    /// The camera without effects.
    pub camera: &'a Camera,
    /// The width and height of the picture (pixels).
    pub resolution: [u32; 2],
    /// The spectral bands of a lens with dispersion.
    pub bands: &'a [LightBand],
    /// Whether the film sees a narrow band of light.
    pub narrow_band: bool,
    /// The point spreads of the whole picture, once the price of diffraction was asked for.
    pub diffraction: &'a OnceLock<Arc<Diffraction>>,
    /// The source of the wish for buckets of wavelength, if the film has any.
    pub buckets: Option<DecidedBy>,
    /// Whether unknown dispersion is guessed.
    pub assumed_dispersion: bool,
    /// Whether the command line names a coating.
    pub coating_given: bool,
    /// The estimated ghosts of the scene's lights, if there are any.
    pub ghosts: Option<&'a GhostEstimate>,
    /// The estimated brightness and cost of the picture.
    pub pilot: PilotEstimate,
    /// The sensor of the command line.
    pub sensor: Option<&'a Sensor>,
    /// The number of samples per pixel.
    pub samples: u32,
    /// The moving parts of the scene and the times of samples.
    pub motion: MotionInput<'a>,
    /// The misalignment of lens and film, simulated or not.
    pub misalignment: Option<&'a Misalignment>,
    /// The effect selection of the command line.
    pub selection: &'a EffectSelection,
    /// The error above which an effect counts as visible.
    pub threshold: VisibilityThreshold,
}

/// Brightness (luminance) and cost of a picture without effects, estimated from a small one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PilotEstimate {
    /// The mean without the brightest tenth of the pixels: a veil of light is not seen on lights and
    /// their reflections.
    pub mean: f64,
    /// The light of the brightest spot above the mean [pixels of luminance 1].
    pub highlight: f64,
    /// The cost of a film sample (ns), computed from counts of rays rather than measured times, so
    /// that plans are reproducible.
    pub ns_per_sample: f64,
    /// The number of rays through the scene per film sample, including shadow rays.
    pub rays_per_sample: f64,
}

impl PilotEstimate {
    /// Returns a veil of light relative to the mean (percent); 100 in a black picture.
    fn percent(&self, light: f64) -> f64 {
        let percent = match self.mean > 0.0 {
            true => 100.0 * light / self.mean,
            false if light > 0.0 => 100.0,
            false => 0.0,
        };
        // An overflow tells nothing about the light.
        if percent.is_finite() { percent } else { 0.0 }
    }
}

/// Data about an effect on which its decision is based.
struct Finding {
    by: DecidedBy,
    reason: String,
    error: Option<OmissionError>,
    /// Whether it can be simulated here.
    possible: bool,
    /// Whether it is simulated by default.
    by_default: bool,
    cost: Option<Cost>,
}

impl Finding {
    fn unavailable(by: DecidedBy, reason: &str) -> Self {
        Self {
            by,
            reason: reason.to_owned(),
            error: None,
            possible: false,
            by_default: false,
            cost: None,
        }
    }
}

/// Decides about all effects.
pub fn plan(input: &PlanInput) -> Plan {
    Plan {
        effects: Effect::ALL.into_par_iter().map(|effect| decide(effect, input)).collect(),
        light_paths: LightTracingDecision::default(),
    }
}

fn decide(effect: Effect, input: &PlanInput) -> Decision {
    let Finding { by, reason, error, possible, by_default, cost } = find(effect, input);
    let (on, by, reason) = match input.selection.of(effect) {
        Some(true) if possible => (true, DecidedBy::Flag, format!("asked for; {reason}")),
        Some(false) if possible => (false, DecidedBy::Flag, format!("not wanted; {reason}")),
        None if possible && !by_default => match error {
            Some(error) if !error.is_visible(input.threshold) => {
                let limit = error.limit(input.threshold);
                (false, by, format!("{reason}; below {limit}, so not visible"))
            }
            _ => (false, by, reason),
        },
        _ => (by_default && possible, by, reason),
    };
    Decision { effect, on, by, reason, error, cost }
}

fn find(effect: Effect, input: &PlanInput) -> Finding {
    match (effect.finder(), &input.camera.model) {
        (Finder::AnyCamera(find), _) => find(input),
        (Finder::LensOfGlass(find), LensModel::Real(lens)) => find(input, lens),
        (Finder::LensOfGlass(_), _) => {
            Finding::unavailable(DecidedBy::Scene, "the camera has no lens of glass")
        }
    }
}

/// Returns the cost of an effect that takes this long for a film sample (ns).
fn cost(input: &PlanInput, ns_per_ray: f64) -> Option<Cost> {
    let all = input.pilot.ns_per_sample + ns_per_ray;
    let percent = if all > 0.0 { 100.0 * ns_per_ray / all } else { 0.0 };
    Some(Cost { ns_per_ray, percent })
}

/// Returns the number of pixels per micrometre on the film, along the shorter side of a pixel.
fn pixels_per_um(input: &PlanInput) -> f64 {
    let pitch = |i: usize| 1e3 * input.camera.film[i] / f64::from(input.resolution[i]);
    1.0 / pitch(0).min(pitch(1))
}
