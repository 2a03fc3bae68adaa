//! What may be asked for instead of what a scene file says.

use std::path::PathBuf;

use crate::aov::Aov;
use crate::lens::{Aim, Coating, FocusModel};
use crate::plan::{Visible, Wanted};
use crate::render::Until;
use crate::scene::pbrt::FilmSpec;
use crate::sensor;
use crate::shutter;
use crate::spectrum::Passband;

/// What to focus on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FocusOn {
    /// A distance, metres from the film; infinite is allowed.
    Distance(f64),
    /// What a pixel sees, or the middle of the picture.
    Pixel(Option<[u32; 2]>),
}

/// What may be asked for instead of what the scene file says.
#[derive(Clone, Debug, Default)]
pub struct Changes {
    /// Another lens file.
    pub lens: Option<PathBuf>,
    /// Another distance in focus.
    pub focus: Option<FocusOn>,
    /// Where the film stands for the distance in focus, the scene's or this one.
    pub focus_model: FocusModel,
    /// Another f-number, by the marginal ray ([`crate::lens::Focus::f_number`]).
    pub f_number: Option<f64>,
    /// Another shift of the film, mm, to the right and up in the picture as seen.
    pub film_shift: Option<[f64; 2]>,
    /// Another tilt of the film, degrees, about the horizontal and its own vertical axis
    /// ([`Pose`](crate::lens::Pose)).
    pub film_tilt: Option<[f64; 2]>,
    /// What to coat faces to air with that have no coating of their own; given, surfaces take what
    /// they reflect.
    pub coating: Option<Coating>,
    /// Whether glass of which only the index is known disperses as one of the catalogue.
    pub assume_vd: bool,
    /// The light that the film sees, where it is not all: it sees grey.
    pub passband: Option<Passband>,
    /// Another size of the picture, pixels.
    pub resolution: Option<[u32; 2]>,
    /// Which effects to simulate.
    pub effects: Wanted,
    /// From what on one counts as visible.
    pub visible: Visible,
    /// First pixel, and first pixel not, that is rendered.
    pub crop: Option<[[u32; 2]; 2]>,
    /// Samples a pixel.
    pub samples: Option<u32>,
    /// When the picture is good enough; then `samples` are the most in the mean, and those of the
    /// scene file do not count.
    pub until: Until,
    /// Seed of the random numbers.
    pub seed: Option<u32>,
    /// How film points choose where to aim.
    pub aim: Aim,
    /// Layers beside the colours.
    pub layers: Vec<Aov>,
    /// Whether the picture's format holds layers, so that those of the scene file are wanted.
    pub holds_layers: bool,
    /// Another shutter.
    pub shutter: Option<shutter::Settings>,
    /// How the sensor reads its rows.
    pub rolling: Option<shutter::Rolling>,
    /// A sensor that reads the picture out.
    pub sensor: Option<sensor::Settings>,
}

impl Changes {
    /// The speed that the picture is taken at.
    pub(super) fn iso(&self, film: &FilmSpec) -> f64 {
        self.sensor.and_then(|sensor| sensor.iso).unwrap_or(film.iso)
    }

    /// The option that makes sense with a real lens only, if one is given.
    pub(super) fn needs_lens(&self) -> Option<&'static str> {
        let given = [
            (self.lens.is_some(), "--lens"),
            (self.focus.is_some(), "--focus"),
            (self.focus_model != FocusModel::default(), "--focus-model"),
            (self.f_number.is_some(), "--fstop"),
            (self.coating.is_some(), "--coating"),
            (self.assume_vd, "--assume-vd"),
            (self.film_shift.is_some(), "--film-shift"),
            (self.film_tilt.is_some(), "--film-tilt"),
        ];
        given.into_iter().find(|(given, _)| *given).map(|(_, option)| option)
    }
}
