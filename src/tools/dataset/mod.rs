//! Data sets of paired pictures: a clean and a degraded one of the same view, with its data.
//!
//! A [`DatasetSpec`] says what is drawn for each pair: scene, lens, focus, stop, light and viewpoint.
//! A [`Draw`] is a function of the specification's seed and the pair's number, so pairs can be
//! rendered in any order and on any machine. [`prepare_pair`] makes the two jobs, which have the
//! same seed: their samples fall on the same points of film and pupil. [`write_pair`] renders them,
//! and [`Manifest`] lists what is finished.
//!
//! # Exposure
//!
//! All pictures of a scene have the exposure of its own lens at its own stop: the irradiance in the
//! middle of the film, for a radiance of 1, is measured by tracing rays, and the exposure makes up
//! for its change. A draw of the stop thus changes the blur and not the brightness. Light levels
//! change only the noise of the sensor.

mod draw;
mod manifest;
mod objects;
mod pair;
mod row;
mod spec;
mod spec_checks;
mod trajectory;

pub use draw::Draw;
pub use manifest::{Manifest, ManifestRow};
pub use pair::{DatasetScene, Pair, prepare_pair, write_pair};
pub use spec::{CleanCamera, CleanSpec, DatasetSpec, DegradedSpec, DrawSpec, DrawnFrom, Range};
pub use trajectory::{StampedPose, Trajectory};

use std::io;
use std::path::{Path, PathBuf};

use petzval_base::io::{OutputError, ReadError, path_excerpt};
use petzval_image::ImageError;
use petzval_render::RenderError;
use petzval_render::prepare::PrepareError;
use petzval_scene_formats::pbrt::SceneErrors;

/// Error of a data set.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DatasetError {
    /// The specification cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The specification is not sound.
    #[error("{}: {problem}", path_excerpt(path))]
    Spec {
        /// The file of the specification.
        path: PathBuf,
        /// The place and the fault.
        problem: String,
    },
    /// A scene cannot be read.
    #[error(transparent)]
    Scene(#[from] SceneErrors),
    /// A pair cannot be photographed as it was drawn.
    #[error("pair {pair} ({draw}): {source}")]
    Prepare {
        /// The pair's number.
        pair: u32,
        /// The parameters of the pair.
        draw: String,
        /// The error of the preparation.
        source: Box<PrepareError>,
    },
    /// The scene cannot be photographed as it is, so its exposure is unknown.
    #[error("{}, as it is: {source}", path_excerpt(scene))]
    OwnCamera {
        /// The scene file.
        scene: PathBuf,
        /// The error of the preparation.
        source: Box<PrepareError>,
    },
    /// The point spreads of a pair's lens cannot be computed.
    #[error("pair {pair}: psf = true: {problem}")]
    PointSpreads {
        /// The pair's number.
        pair: u32,
        /// The fault.
        problem: String,
    },
    /// The mosaic of a pair cannot be developed.
    #[error("pair {pair}: develop: {problem}")]
    Develop {
        /// The pair's number.
        pair: u32,
        /// The fault.
        problem: String,
    },
    /// A pair's scene has no real lens.
    #[error(
        "pair {pair}: the camera of {} has no lens file, so it has no blur to learn; expected a \
         realistic camera",
        path_excerpt(scene)
    )]
    NoLens {
        /// The pair's number.
        pair: u32,
        /// The scene file.
        scene: PathBuf,
    },
    /// The render failed, or was stopped.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A picture cannot be written.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// A file of the data set is an input of it.
    #[error("{0}; choose another folder for the data set")]
    Output(#[from] OutputError),
    /// Another file cannot be written or read.
    #[error("cannot {verb} {}: {source}", path_excerpt(path))]
    Io {
        /// "read" or "write".
        verb: &'static str,
        /// The file.
        path: PathBuf,
        /// The error of the system.
        source: io::Error,
    },
    /// The manifest is not of this data set.
    #[error("{}:{line}: {problem}", path_excerpt(path))]
    Manifest {
        /// The manifest.
        path: PathBuf,
        /// Line number, from 1.
        line: usize,
        /// The fault and its remedy.
        problem: String,
    },
}

impl DatasetError {
    fn io(verb: &'static str, path: &Path) -> impl FnOnce(io::Error) -> Self {
        move |source| Self::Io { verb, path: path.to_owned(), source }
    }
}
