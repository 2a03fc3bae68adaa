//! Light tracing: paths that start at the lights of a scene and end on the film.
//!
//! Camera paths hardly ever hit a small light, and by a reflection inside the lens never. Three
//! strategies start at the lights instead: images of lamps, caustics and ghosts. Each traces waves of
//! light paths, and one stage splats them on the film.

pub mod caustics;
mod entry;
pub mod ghosts;
pub mod lamp_images;
pub mod light_paths;
mod ordered_film;
mod splat_stage;

pub use splat_stage::{SplatStage, Strategy};

use caustics::Caustics;
use lamp_images::LampImages;
use light_paths::{LightPathInput, LightPathSelection, SurveyedPicture};

/// Strategies that are worth their time in a picture.
#[derive(Clone, Debug)]
pub struct LightTracingSurvey {
    /// The lamps whose images light paths find.
    pub lamp_images: Option<LampImages>,
    /// The surfaces whose caustics light paths find.
    pub caustics: Option<Caustics>,
    /// The reasons, in a sentence.
    pub reason: String,
}

impl LightTracingSurvey {
    /// Returns the survey of light paths that the user does not want.
    pub fn unwanted() -> Self {
        Self { lamp_images: None, caustics: None, reason: "not wanted".to_owned() }
    }
}

/// Surveys the lamps and the caustics of a picture.
pub fn survey(input: &LightPathInput<'_>, selection: LightPathSelection) -> LightTracingSurvey {
    let picture = SurveyedPicture::new(input, selection);
    let picture = picture.as_ref().map_err(|reason| *reason);
    let (lamp_images, caustics) = rayon::join(
        || picture.and_then(lamp_images::survey),
        || picture.and_then(caustics::survey),
    );
    let of_lamps = match &lamp_images {
        Ok(lamps) => lamps.describe(input.scene),
        Err(reason) => (*reason).to_owned(),
    };
    let of_caustics = match caustics.as_ref().map(Caustics::casters) {
        Ok(1) => "caustics of one surface".to_owned(),
        Ok(count) => format!("caustics of {count} surfaces"),
        Err(reason) => (*reason).to_owned(),
    };
    let reason = match of_lamps == of_caustics {
        true => of_lamps,
        false => format!("{of_lamps}; {of_caustics}"),
    };
    LightTracingSurvey { lamp_images: lamp_images.ok(), caustics: caustics.ok(), reason }
}
