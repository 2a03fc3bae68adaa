//! `petzval render`: one picture, or a part of its samples.

mod camera_model;
mod denoising;
mod inputs;
mod log;
mod picture_output;
mod resume;
mod summary;
mod task;

pub(super) use denoising::{
    Denoising, add_guides, bytes as denoising_bytes, check_noisy_files, has_guides,
    has_noisy_picture, noisy_files,
};
pub(super) use inputs::inputs;
pub(super) use picture_output::PictureOutput;
pub(super) use resume::{RenderFiles, checkpoint_name, partial_name, resume_command};
pub(super) use task::{
    RenderTask, SweepItem, TaskResult, job, stop_at_signals, warn_without_spectra,
};

use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use petzval_base::io::ByteSize;
use petzval_render::Progress;
use petzval_render::aov::Aov;
use petzval_render::prepare::settings;

use super::arguments::argv::argv;
use super::arguments::encoding::EncodingArguments;
use super::arguments::values::{
    CheckpointInterval, Shard, checkpoint_interval, range, shard, typed,
};
use super::arguments::{BackendArgument, PictureArguments, PupilArgument, layer};
use super::denoise::Denoiser;
use super::memory::Memory;
use super::sweep::{SweepAxis, sweep_axis};
use super::{Failure, Outcome, message, sweep};

/// Arguments of `petzval render`.
#[derive(Debug, clap::Args)]
pub(super) struct RenderArguments {
    /// Picture to write: .exr, .png, .jpg, .tif, .dng (the mosaic of --bayer) or .npy (an array); by default
    /// the name that the scene gives
    #[arg(short, long, value_name = "FILE", help_heading = "Picture")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub picture: PictureArguments,
    /// Stop when the picture is this exact: the root mean square, over its pixels, of the standard
    /// error over the luminance and a tenth of the picture's mean
    ///
    /// Tiles take as many samples as they need; --spp, if given, is the largest mean. The picture
    /// is the same every time
    #[arg(
        long,
        value_name = "ERROR",
        value_parser = typed(settings::noise),
        allow_hyphen_values = true,
        help_heading = "Picture"
    )]
    pub noise: Option<f64>,
    /// Stop after this time of rendering, without reading, with samples where they are needed;
    /// whichever of --noise, --time and --spp comes first
    ///
    /// Every pixel takes 4 samples, however long that takes; the picture is not the same every time
    #[arg(
        long,
        value_name = "30s",
        value_parser = typed(settings::time),
        allow_hyphen_values = true,
        help_heading = "Picture"
    )]
    pub time: Option<Duration>,
    /// Time between checkpoints, written beside the picture as FILE.checkpoint and removed when the
    /// picture is finished
    ///
    /// Off: never, not even when stopped
    #[arg(
        long,
        value_name = "60s|off",
        value_parser = checkpoint_interval,
        default_value = "60s",
        help_heading = "Large jobs"
    )]
    pub checkpoint: CheckpointInterval,
    /// Continue from that file; the picture is the same as without the interruption, bit for bit
    /// (except with --time)
    ///
    /// Refused if scene, lens, options or version have changed since
    #[arg(long, help_heading = "Large jobs")]
    pub resume: bool,
    /// Render the I-th of N parts of the samples, I from 1, to PART.petzval for petzval merge
    #[arg(
        long,
        value_name = "I/N",
        value_parser = shard,
        conflicts_with = "samples",
        help_heading = "Large jobs"
    )]
    pub shard: Option<Shard>,
    /// Render these samples of every pixel, from 0, B not included, to PART.petzval for petzval
    /// merge
    #[arg(long, value_name = "A..B", value_parser = range, help_heading = "Large jobs")]
    pub samples: Option<Range<u32>>,
    /// Render a picture for each of these values of an option: fstop=2,4,8 or focus=0.5..5:8 (8
    /// values, evenly spaced) or fstop=2..16:4:log (by a factor); separate values that contain
    /// commas with ;
    ///
    /// Repeat the option for all combinations. Scene and BVH are loaded once. The picture's name
    /// has placeholders, such as out/{lens}_{fstop}_{focus}.exr; {{ is a brace. Missing folders are
    /// created
    #[arg(
        long,
        value_name = "NAME=VALUES",
        value_parser = sweep_axis,
        help_heading = "Large jobs"
    )]
    pub sweep: Vec<SweepAxis>,
    /// Contact sheet of a sweep
    ///
    /// .png, .jpg, .tif; the table of its pictures goes beside it, as .csv; by default sweep.png beside
    /// the pictures
    #[arg(long, value_name = "FILE", requires = "sweep", help_heading = "Large jobs")]
    pub contact: Option<PathBuf>,
    /// Number of threads; one per core by default
    ///
    /// The picture is the same for any number
    #[arg(
        long,
        value_name = "N",
        value_parser = clap::value_parser!(u16).range(1..=4096),
        help_heading = "Large jobs"
    )]
    pub threads: Option<u16>,
    /// Largest memory use, such as 8GiB or 500MB
    ///
    /// A picture that is expected to take more, or a scene that declares more, is refused at the
    /// start, with a list of what takes how much. By default the memory of the machine, or of the
    /// group that limits the process (Linux)
    #[arg(long, value_name = "SIZE", help_heading = "Large jobs")]
    pub memory: Option<ByteSize>,
    /// Rays per kernel call: eight lanes or one
    ///
    /// The picture is the same
    #[arg(long, value_enum, default_value_t, help_heading = "Large jobs")]
    pub backend: BackendArgument,
    /// Render only a part of the picture; X1 and Y1 are not included
    #[arg(
        long,
        value_name = "X0,Y0,X1,Y1",
        value_parser = typed(settings::crop),
        help_heading = "Picture"
    )]
    pub crop: Option<[[u32; 2]; 2]>,
    /// Target of rays from the film: the exit pupil, or the rear element's disk as in the course of
    /// 2016
    #[arg(long, value_enum, default_value_t, help_heading = "Lens")]
    pub pupil: PupilArgument,
    /// Layers to add to the picture (EXR)
    #[arg(
        long,
        value_name = "LAYER",
        value_delimiter = ',',
        value_parser = layer::parser(),
        help_heading = "Picture"
    )]
    pub aov: Vec<Aov>,
    #[command(flatten)]
    pub encoding: EncodingArguments,
    /// Remove the noise of the finished picture, before the sensor, by a program: oidnDenoise of
    /// Open Image Denoise or petzval-denoise of the Python package, on PATH, in the environment
    /// variable PETZVAL_DENOISER, or named here
    ///
    /// The noisy picture is kept as the layer "noisy" (EXR) or as FILE.noisy.png
    #[arg(
        long,
        value_name = "PROGRAM",
        num_args = 0..=1,
        require_equals = true,
        help_heading = "Picture"
    )]
    pub denoise: Option<Option<PathBuf>>,
}

impl RenderArguments {
    /// Returns the program that denoises the picture, if that is requested. A part of the samples is
    /// not denoised, but its whole.
    pub fn denoiser(&self) -> Result<Option<Denoiser>, Failure> {
        match (&self.denoise, self.is_part()) {
            (Some(program), false) => Denoiser::new(program.as_deref()).map(Some),
            _ => Ok(None),
        }
    }

    /// Returns whether the command renders a part of the samples, for `petzval merge`.
    fn is_part(&self) -> bool {
        self.shard.is_some() || self.samples.is_some()
    }

    /// Returns the samples to render of `all` samples per pixel, if not all.
    fn part(&self, all: u32) -> Result<Option<Range<u32>>, Failure> {
        let (option, range) = match (self.shard, &self.samples) {
            (Some(Shard { count, .. }), _) if count > all => {
                let problem = format!("--shard: {all} samples a pixel make no {count} shards");
                return Err(problem.into());
            }
            (Some(shard), _) => ("--shard", shard.samples(all)),
            (None, Some(range)) => ("--samples", range.clone()),
            (None, None) => return Ok(None),
        };
        if let Some(other) = [(self.noise.is_some(), "--noise"), (self.time.is_some(), "--time")]
            .into_iter()
            .find_map(|(given, name)| given.then_some(name))
        {
            let problem = format!(
                "{option} with {other}: how many samples a tile needs is known only if all of them \
                 are rendered together; give --spp instead"
            );
            return Err(problem.into());
        }
        match range.end <= all {
            true => Ok(Some(range)),
            false => {
                Err(format!("{option}: the picture has {all} samples a pixel; see --spp").into())
            }
        }
    }
}

pub(super) fn run(arguments: &RenderArguments) -> Result<Outcome, Failure> {
    if !arguments.sweep.is_empty() {
        return sweep::run(arguments);
    }
    let start = Instant::now();
    let denoiser = arguments.denoiser()?;
    let memory = Memory::new(arguments.memory);
    let description = petzval_scene_formats::read_with(&arguments.picture.scene, memory.context())?;
    let (task, warnings) =
        RenderTask::new(arguments, argv(), description, denoiser.as_ref(), &memory, start)?;
    message::warnings(&warnings);
    let progress = Arc::new(Progress::default());
    stop_at_signals(progress.clone());
    Ok(task.run(&progress, denoiser.as_ref(), None)?.outcome)
}
