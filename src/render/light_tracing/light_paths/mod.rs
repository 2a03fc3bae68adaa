//! Light paths: from the lights of a scene into the lens and on to the film.
//!
//! Camera paths hardly ever hit a small light, and by a reflection inside the lens never. A light
//! path starts at the light: a point of the light is sampled from a point before the lens, the ray
//! is traced through the surfaces to the film, and the light that arrives is splatted there. All
//! strategies use them.

mod arrival;
mod camera_pose;
mod camera_view;
mod front;
mod numbers;
mod path_count;
mod survey;
mod wave;
mod wave_light;

pub(crate) use arrival::add_splats;
pub(crate) use camera_pose::{CameraPose, CameraPoses};
pub(crate) use camera_view::CameraView;
#[cfg(test)]
pub(crate) use camera_view::sample_film;
pub(crate) use front::FrontEntry;
pub(crate) use numbers::PathNumbers;
pub(crate) use path_count::PathCount;
pub use survey::LightPathSelection;
pub(crate) use survey::SurveyedPicture;
pub(crate) use wave::{FilmArrival, FilmHit, LightPath, LightPaths};
pub(crate) use wave_light::{PathBand, WaveLight};

use std::sync::atomic::{AtomicBool, Ordering};

use crate::film::{Frame, LightSplit, Response};
use crate::timing::{ArrivalTime, Timing};
use petzval_base::sampler::{Dimension, sample_2d};
use petzval_lens::{Camera, FilmMap, RealLens};
use petzval_scene::{PathLimits, Scene, SpectralScene};

/// Parts of a job that light paths depend on.
#[derive(Clone, Copy, Debug)]
pub struct LightPathInput<'a> {
    /// The scene, with its lights.
    pub scene: &'a Scene,
    /// The same scene by wavelength, if paths carry spectra.
    pub spectral: Option<&'a SpectralScene>,
    /// The division of the light among waves.
    pub split: LightSplit,
    /// The camera.
    pub camera: &'a Camera,
    /// The pixels of the picture.
    pub frame: &'a Frame,
    /// The filter and the colour response of the film.
    pub response: &'a Response,
    /// The times of the samples, if anything moves.
    pub timing: Option<&'a Timing>,
    /// The limits of path length.
    pub path_limits: PathLimits,
    /// Whether splats record their half of the exit pupil.
    pub halves: bool,
    /// Whether the camera does not see the light of a sky.
    pub hides_sky: bool,
    /// The seed of all random numbers.
    pub seed: u32,
    /// Switch that ends the work within a wave of paths. What it has added to a film is then of no
    /// use.
    pub stop: Option<&'a AtomicBool>,
}

impl LightPathInput<'_> {
    /// Returns the map between the film and the whole picture.
    pub(crate) fn film_map(&self) -> FilmMap {
        self.camera.film_map(self.frame.resolution)
    }

    /// Returns the time at which a path arrives, given by the key and the number of its sample.
    pub(crate) fn arrival_time(&self, key: u32, sample: u32) -> ArrivalTime {
        self.timing.map_or_else(ArrivalTime::default, |timing| {
            timing.arrival_time(sample_2d(key, sample, Dimension::Time)[0])
        })
    }

    /// Returns whether a path passed the left half of the exit pupil; false if halves do not matter.
    pub(crate) fn is_left_half(&self, lens: &RealLens, hit: &FilmHit) -> bool {
        self.halves && lens.is_left_half(hit.point, hit.towards)
    }

    /// Returns the density with which the row of a pixel samples a time, relative to that with which
    /// light paths do.
    pub(crate) fn row_exposure(&self, time: ArrivalTime, pixel: [u32; 2]) -> f64 {
        self.timing.map_or(1.0, |timing| timing.row_exposure(time, pixel, self.frame.resolution))
    }

    /// Returns whether the work is to end.
    pub(crate) fn is_stopped(&self) -> bool {
        self.stop.is_some_and(|stop| stop.load(Ordering::Relaxed))
    }
}
