//! Renderer: from a scene and a lens to a picture.
//!
//! [`prepare`](prepare::prepare) turns a scene file and the changes of the user into a [`job`]; [`plan`]
//! decides which effects it needs; [`render`](render()) renders it. `advance` and `wave`
//! are the only modules that know the order of the stages.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod aov;
pub mod diffraction;
pub mod film;
pub mod job;
pub mod light_tracing;
pub mod plan;
pub mod prepare;
pub mod sensor;
pub mod shade;
pub mod timing;

mod adaptive;
mod advance;
mod checkpointer;
mod deferred;
mod disperse;
mod film_projection;
mod film_state;
mod optical_image;
mod progressive;
mod replay;
mod splat_accumulator;
mod uniform;
mod wave;
mod workers;

pub mod checkpoint;
pub mod memory;

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64};

use crate::aov::FeatureFilm;
use crate::film::FilmSums;
use crate::job::Job;
use checkpoint::{CheckpointError, SavedRender};
use petzval_base::lanes::{Real, f32x8};
use petzval_base::stats::Stats;
use petzval_image::{ImageLayer, Note, Notes, Picture};
use workers::Workers;

pub use checkpointer::{CheckpointNotice, Checkpointer, RenderStart, ResumeError};
pub use disperse::{DisperseColumns, disperse};
pub use optical_image::{OpticalImage, ReadPicture};
pub use progressive::ProgressiveRender;
pub use replay::{Collision, PathStage, PathStep, Replay, ShadowRay, SharedBand, replay};

/// Number of rays that a kernel takes at a time. The picture is the same bit for bit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Backend {
    /// Eight lanes.
    #[default]
    Simd,
    /// One lane.
    Scalar,
}

/// Options of a render that do not change its picture.
#[derive(Clone, Copy, Debug, Default)]
pub struct RenderOptions<'a> {
    /// The number of rays that a kernel takes at a time.
    pub backend: Backend,
    /// The number of threads; 0 means one for each core.
    pub threads: usize,
    /// Counters for an observer of the render, and its switch to stop it.
    pub progress: Option<&'a Progress>,
}

/// Progress of a render, shared with its observers.
#[derive(Debug, Default)]
pub struct Progress {
    /// Film samples taken.
    pub samples: AtomicU64,
    /// Film samples expected in total, as far as is known; 0 if the number of samples of the job
    /// determines it.
    pub expected: AtomicU64,
    /// Switch that stops the workers at their next wave.
    pub stop: AtomicBool,
}

/// Result of a render.
#[derive(Clone, Debug)]
pub struct RenderOutput {
    /// The light on the film.
    pub film: FilmSums,
    /// The features of the first surfaces, if a layer needs them.
    pub features: Option<FeatureFilm>,
    /// Counts and times of the stages.
    pub stats: Stats,
    /// The quality of the picture, if another criterion than the number of samples could end the
    /// render.
    pub convergence: Option<Convergence>,
    /// The mean number of samples per pixel of a render that was stopped; `None` if it is complete.
    pub partial_mean_spp: Option<f64>,
}

/// Quality of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Convergence {
    /// The estimated noise, as [`StopCriteria::noise`](crate::job::StopCriteria::noise) defines it.
    pub noise: f64,
    /// The mean number of samples per pixel, over the pixels that light reaches.
    pub mean_spp: f64,
    /// The smallest number of samples per pixel.
    pub min_spp: u32,
    /// The largest number of samples per pixel.
    pub max_spp: u32,
}

impl Convergence {
    /// Returns the notes for the metadata of the picture.
    pub fn notes(&self) -> Notes {
        let number = |name, value| (name, Note::Number(value));
        vec![
            number("noise", self.noise),
            number("samplesPerPixel", self.mean_spp),
            number("leastSamplesPerPixel", f64::from(self.min_spp)),
            number("mostSamplesPerPixel", f64::from(self.max_spp)),
        ]
    }
}

/// Stack of a thread (bytes). Columns of a wave are made on the stack before they are boxed, and the
/// 2 MB that threads have by default do not hold them in every build.
const STACK: usize = 8 << 20;

/// Returns threads that render; 0 is one for each core.
///
/// # Errors
/// Returns an error if they cannot be started.
pub fn thread_pool(threads: usize) -> Result<rayon::ThreadPool, rayon::ThreadPoolBuildError> {
    rayon::ThreadPoolBuilder::new().num_threads(threads).stack_size(STACK).build()
}

impl RenderOutput {
    /// Returns the picture of this job: the light on the film, after diffraction if that is planned,
    /// and read out by the sensor if there is one.
    pub fn picture(&self, job: &Job) -> Picture {
        let samples = job.samples.end - job.samples.start;
        let image = OpticalImage::of_film(&self.film, samples);
        image.diffracted(job).read_out(job).picture
    }

    /// Returns the same as [`RenderOutput::picture`], in less memory.
    pub fn into_picture(self, job: &Job) -> Picture {
        self.into_optical_image(job).read_out(job).picture
    }

    /// Returns the picture of this job and all its layers: those of [`RenderOutput::layers`], and those of a dual
    /// pixel, which are spread and read out as the picture is.
    pub fn into_picture_with_layers(self, job: &Job) -> (Picture, Vec<ImageLayer>) {
        let mut layers = self.layers(job);
        let picture = self.into_optical_image(job).read_out(job).into_picture(job, &mut layers);
        (picture, layers)
    }

    /// Returns the light on the film after diffraction, which the sensor has not read out yet:
    /// [`OpticalImage::read_out`] makes the picture of it.
    pub fn into_optical_image(self, job: &Job) -> OpticalImage {
        let Self { film, features, .. } = self;
        drop(features);
        OpticalImage::from_film(film, job.samples.end - job.samples.start).diffracted(job)
    }

    /// Returns the layers of this job, and that of the spectra of a spectral film. They describe the light
    /// on the film, before diffraction and sensor. Those of a dual pixel come with the picture that is read out.
    pub fn layers(&self, job: &Job) -> Vec<ImageLayer> {
        let samples = job.samples.end - job.samples.start;
        let request = job.layer_request();
        let mut layers = aov::layers(&request, samples, &self.film, self.features.as_ref());
        job.convert_layers(&mut layers);
        layers.extend(self.film.spectrum(samples));
        layers
    }
}

/// Error of a render that ends without a picture.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// [`Progress::stop`] was set.
    #[error("stopped before the picture was complete")]
    Stopped,
    /// The threads could not be started.
    #[error("cannot start the render threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// A checkpoint could not be read or written.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
}

/// Renders a picture.
///
/// The picture depends on the job alone: not on threads, backend or the order of the work.
///
/// # Errors
/// Returns an error if the render is stopped or its threads cannot be started.
pub fn render(job: &Job, options: RenderOptions<'_>) -> Result<RenderOutput, RenderError> {
    let output = render_resumable(job, options, None, None)?;
    match output.partial_mean_spp {
        None => Ok(output),
        Some(_) => Err(RenderError::Stopped),
    }
}

/// Renders a picture, resumes it from a saved state, and writes checkpoints.
///
/// A render that is stopped writes a last checkpoint and returns its partial picture.
///
/// The picture is the same bit for bit whether the render was interrupted or not, except for one
/// that ends by time.
///
/// # Errors
/// Returns an error if threads cannot be started, the saved state does not belong to this job, or the
/// last file cannot be written.
pub fn render_resumable(
    job: &Job,
    options: RenderOptions<'_>,
    checkpointer: Option<&Checkpointer>,
    resumed: Option<SavedRender>,
) -> Result<RenderOutput, RenderError> {
    let unobserved = Progress::default();
    let progress = options.progress.unwrap_or(&unobserved);
    let pool = thread_pool(options.threads)?;
    pool.install(|| {
        let workers =
            Workers::new(job, progress, checkpointer, resumed.as_ref().map(|saved| &saved.head));
        match options.backend {
            Backend::Simd => render_with::<f32x8>(&workers, resumed),
            Backend::Scalar => render_with::<f32>(&workers, resumed),
        }
    })
}

fn render_with<R: Real<Scalar = f32>>(
    workers: &Workers,
    resumed: Option<SavedRender>,
) -> Result<RenderOutput, RenderError> {
    match workers.job.stop_criteria.count_only() {
        true => uniform::render::<R>(workers, resumed),
        false => adaptive::render::<R>(workers, resumed),
    }
}

/// Adds up parts of a picture that were rendered separately. Their sample numbers, one part after
/// the other, must be all of the job's.
///
/// # Errors
/// Returns an error if a part cannot be read or does not belong to this job.
pub fn merge(job: &Job, parts: &[PathBuf]) -> Result<RenderOutput, CheckpointError> {
    uniform::merge(job, parts.iter().map(|path| SavedRender::open(path)))
}
