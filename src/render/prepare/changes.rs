//! Changes that the user makes to a scene file.

use std::path::PathBuf;

use super::{PrepareError, Viewpoint};
use crate::aov::Aov;
use crate::job::StopCriteria;
use crate::plan::{EffectSelection, VisibilityThreshold};
use crate::sensor;
use petzval_lens::{Coating, FocusModel, PupilSampling};
use petzval_lens_formats::LensOptions;
use petzval_scene::shutter;
use petzval_scene_formats::pbrt::FilmSpec;
use petzval_spectrum::{Buckets, Passband};

/// Object to focus on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FocusOn {
    /// The distance from the film (m); may be infinite.
    Distance(f64),
    /// The surface that a pixel sees, or the middle of the picture.
    Pixel(Option<[u32; 2]>),
}

/// Changes to a scene file. `None` keeps the value of the file.
#[derive(Clone, Debug, Default)]
pub struct Changes {
    /// The lens file.
    pub lens: Option<PathBuf>,
    /// Choices for the lens file.
    pub lens_options: LensOptions,
    /// The place and the direction of the camera, which then stands still.
    pub viewpoint: Option<Viewpoint>,
    /// The object in focus.
    pub focus: Option<FocusOn>,
    /// The model that places the film for the distance in focus.
    pub focus_model: FocusModel,
    /// The f-number, by the marginal ray ([`petzval_lens::RealRayFocus::f_number`]).
    pub f_number: Option<f64>,
    /// The diagonal of the film (mm).
    pub film_diagonal: Option<f64>,
    /// The shift of the film, to the right and up in the picture as seen (mm).
    pub film_shift: Option<[f64; 2]>,
    /// The tilt of the film about the horizontal and its own vertical axis (degrees)
    /// ([`Pose`](petzval_lens::Pose)).
    pub film_tilt: Option<[f64; 2]>,
    /// The coating of surfaces to air that have none of their own. If given, Fresnel losses are
    /// simulated by default.
    pub coating: Option<Coating>,
    /// Whether glass that is known by its index alone takes the dispersion of a similar catalogue glass.
    pub assume_vd: bool,
    /// The passband of the film, which then records grey.
    pub passband: Option<Passband>,
    /// The size of the picture (pixels).
    pub resolution: Option<[u32; 2]>,
    /// The selection of effects.
    pub effects: EffectSelection,
    /// Whether light paths find images of lamps, and caustics; `None` for where they pay.
    pub light_paths: Option<bool>,
    /// The error above which an effect counts as visible.
    pub threshold: VisibilityThreshold,
    /// The first pixel of the rendered part and its end, exclusive.
    pub crop: Option<[[u32; 2]; 2]>,
    /// The number of samples per pixel.
    pub samples: Option<u32>,
    /// The stop criteria. With one, `samples` is the upper limit of the mean number of samples per
    /// pixel, and the number of the scene file does not apply.
    pub stop_criteria: StopCriteria,
    /// The seed of the random numbers.
    pub seed: Option<u32>,
    /// The sampling of the pupil.
    pub aim: PupilSampling,
    /// The layers besides the colours.
    pub layers: Vec<Aov>,
    /// Whether the format of the picture holds layers, so that those of the scene file are computed.
    pub holds_layers: bool,
    /// The buckets of wavelength of the film; `Some(None)` for none, whatever the scene file asks for.
    /// Buckets call for the effect `spectra`.
    pub buckets: Option<Option<Buckets>>,
    /// Whether the format of the picture holds spectra, so that the buckets of the scene file are filled.
    pub holds_spectra: bool,
    /// The shutter.
    pub shutter: Option<shutter::ShutterSettings>,
    /// The rolling shutter.
    pub rolling: Option<shutter::RollingShutter>,
    /// The sensor that reads the picture out.
    pub sensor: Option<sensor::SensorSettings>,
}

impl Changes {
    /// Returns the shutter of a picture, given that of its scene.
    ///
    /// # Errors
    /// Returns an error if the shutter would close before it opens.
    pub fn shutter_of(&self, scene: &shutter::Shutter) -> Result<shutter::Shutter, PrepareError> {
        let mut shutter = match &self.shutter {
            Some(settings) => settings.apply_to(scene).map_err(shutter_error)?,
            None => scene.clone(),
        };
        shutter.rolling = self.rolling.or(shutter.rolling);
        Ok(shutter)
    }

    /// Returns the ISO speed of the picture, given the pixel pitch of its film (um).
    pub(super) fn iso(&self, film: &FilmSpec, pitch: f64) -> f64 {
        self.sensor.map_or(film.iso, |sensor| sensor.sensor(film.iso, pitch, 0.0).iso)
    }

    /// Returns a setting that is given and needs a real lens, as messages name it.
    pub(super) fn needs_lens(&self) -> Option<&'static str> {
        let given = [
            (self.lens.is_some(), "'lens'"),
            (self.lens_options.zoom.is_some(), "'zoom'"),
            (!self.lens_options.wavelengths.is_empty(), "'wavelengths'"),
            (self.focus.is_some(), "'focus'"),
            (self.focus_model != FocusModel::default(), "'focus_model'"),
            (self.f_number.is_some(), "'fstop'"),
            (self.coating.is_some(), "'coating'"),
            (self.assume_vd, "'assume_vd'"),
            (self.film_diagonal.is_some(), "'film_diagonal'"),
            (self.film_shift.is_some(), "'film_shift'"),
            (self.film_tilt.is_some(), "'film_tilt'"),
        ];
        given.into_iter().find(|(given, _)| *given).map(|(_, option)| option)
    }
}

/// Returns the error of a shutter.
pub(super) fn shutter_error(problem: String) -> PrepareError {
    PrepareError::Request(format!("'shutter': {problem}"))
}
