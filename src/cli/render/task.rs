//! One picture to render: prepared, checked against memory and output files, rendered, written.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use petzval_base::io::Warning;
use petzval_image::{ImageError, ImageFormat, Notes, SPECTRAL_LAYER};
use petzval_render::aov::Aov;
use petzval_render::checkpoint::{CheckpointError, Inputs};
use petzval_render::job::{Job, StopCriteria};
use petzval_render::memory::{Estimate, MemoryTask, machine};
use petzval_render::prepare::{Changes, Prepared, prepare};
use petzval_render::{Progress, RenderError, RenderOptions, render_resumable};
use petzval_scene_formats::pbrt::Description;

use super::denoising::{self, Denoising, Undenoised, add_guides, check_noisy_files};
use super::picture_output::PictureOutput;
use super::resume::{RenderFiles, Resume};
use super::{RenderArguments, inputs};
use crate::cli::denoise::{DenoiseError, Denoiser};
use crate::cli::memory::{Memory, log_peak};
use crate::cli::outputs::check_writable;
use crate::cli::progress::RenderBar;
use crate::cli::signals::on_stop;
use crate::cli::{Failure, Outcome};

/// A picture that is ready to render.
pub(in crate::cli) struct RenderTask<'a> {
    arguments: &'a RenderArguments,
    argv: Vec<String>,
    files: RenderFiles,
    pub job: Job,
    notes: Notes,
    /// Everything that determines its samples.
    pub inputs: Inputs,
    /// Samples per pixel of the whole picture.
    all: u32,
    /// Layers that only the denoiser needs.
    hidden: Vec<Aov>,
    threads: usize,
    /// Expected memory use.
    estimate: Estimate,
    start: Instant,
}

/// The sweep that a picture belongs to, for log lines.
pub(in crate::cli) struct SweepItem<'a> {
    /// Number and values of the picture, such as "3 of 8: fstop 4".
    pub label: &'a str,
    /// Command line of the sweep.
    pub argv: &'a [String],
}

/// Outcome and statistics of a task.
pub(in crate::cli) struct TaskResult {
    pub outcome: Outcome,
    /// Mean samples per pixel.
    pub samples: f64,
    /// Relative noise, if measured.
    pub noise: Option<f64>,
    /// Time since the task's start.
    pub time: Duration,
}

impl<'a> RenderTask<'a> {
    /// Prepares the picture that a command line asks for. Returns it with the warnings of its
    /// readers.
    pub fn new(
        arguments: &'a RenderArguments,
        argv: Vec<String>,
        description: Description,
        denoiser: Option<&Denoiser>,
        memory: &Memory,
        start: Instant,
    ) -> Result<(Self, Vec<Warning>), Failure> {
        let output = output(arguments, &description)?;
        // A part of a picture holds all that the picture may.
        let format = match arguments.is_part() {
            true => None,
            false => Some(ImageFormat::of(&output)?),
        };
        let holds = |layer: &str| format.is_none_or(|format| format.holds(layer));
        let buckets = arguments.picture.changes().buckets;
        let wants_spectra = matches!(buckets, Some(Some(_)));
        let holds_spectra = holds(SPECTRAL_LAYER);
        if !arguments.aov.iter().all(|aov| holds(aov.name())) || (wants_spectra && !holds_spectra) {
            return Err(ImageError::NoLayers { path: output }.into());
        }
        let leaves_spectra =
            !holds_spectra && buckets.is_none() && description.film.buckets.is_some();
        // Fail now rather than after a long render.
        check_writable(&output, "-o")?;
        let Prepared { mut job, notes, warnings } = job(arguments, description, format)?;
        if leaves_spectra {
            warn_without_spectra(&output);
        }
        arguments.encoding.check(&output, format, &job)?;
        let denoises = arguments.denoise.is_some();
        if denoises && !arguments.is_part() {
            check_noisy_files(&output)?;
        }
        let outputs = arguments.picture.lens_file.outputs(&job.files);
        denoiser.iter().for_each(|denoiser| outputs.protect(&denoiser.files()));
        let files = RenderFiles::claim(&output, denoises, &outputs)?;
        let hidden = if denoises { add_guides(&mut job) } else { Vec::new() };
        let all = job.samples.len() as u32;
        let inputs = inputs(&argv, &job, all)?;
        if let Some(samples) = arguments.part(all)? {
            job.samples = samples;
        }
        let threads = arguments.threads.map_or_else(machine::cores, usize::from);
        let holds_layers = format == Some(ImageFormat::Exr);
        let more = (denoises && format.is_some()).then(|| denoising::bytes(&job, holds_layers));
        let estimate = memory.check(&job, MemoryTask::Render { threads }, format, more)?;
        let task = Self {
            arguments,
            argv,
            files,
            job,
            notes,
            inputs,
            all,
            hidden,
            threads,
            estimate,
            start,
        };
        Ok((task, warnings))
    }

    /// Returns the task, which then replaces no picture.
    #[must_use]
    pub fn only_new(self) -> Self {
        Self { files: self.files.only_new(), ..self }
    }

    /// Renders and writes the picture, or what there is of it when `progress` is stopped.
    pub fn run(
        self,
        progress: &Arc<Progress>,
        denoiser: Option<&Denoiser>,
        item: Option<SweepItem>,
    ) -> Result<TaskResult, Failure> {
        let Self { arguments, argv, files, job, notes, inputs, all, threads, .. } = self;
        let Self { hidden, estimate, start, .. } = self;
        let mut resume = Resume::new(arguments, files.clone(), argv.clone(), inputs, &job, all);
        if let Some(item) = &item {
            resume.argv = item.argv.to_vec();
        }
        let saved = resume.saved(&job, arguments.resume)?;
        let read = start.elapsed();

        let earlier = saved.as_ref().map_or(0, |saved| saved.head.film_samples);
        progress.samples.store(earlier, Ordering::Relaxed);
        progress.expected.store(0, Ordering::Relaxed);
        let bar = RenderBar::start(&job, progress.clone());
        let backend = arguments.backend.into();
        let options = RenderOptions { backend, threads, progress: Some(progress) };
        let exposed = render_resumable(&job, options, Some(&resume.checkpointer), saved);
        bar.finish();
        if let Err(RenderError::Checkpoint(CheckpointError::Io { verb: "write", .. })) = &exposed {
            resume.say_unwritten();
        }
        let exposed = exposed?;

        let convergence = exposed.convergence.as_ref();
        let samples =
            convergence.map_or_else(|| f64::from(all), |convergence| convergence.mean_spp);
        let noise = convergence.map(|convergence| convergence.noise);
        let result = |outcome| TaskResult { outcome, samples, noise, time: start.elapsed() };
        let partial = exposed.partial_mean_spp.is_some();
        if arguments.is_part() {
            log_peak(&estimate);
            return resume.end_part(partial, start.elapsed()).map(result);
        }
        let output = match partial {
            // The final name may hold a complete picture.
            true => files.partial,
            false => files.output,
        };
        let encoding = arguments.encoding.options(&job, item.is_some())?;
        let (output, argv, label) = (&output, &argv, item.map(|item| item.label));
        let alone = label.is_none();
        let picture = PictureOutput {
            job: &job,
            notes,
            argv,
            rendered_by: argv,
            label,
            output,
            encoding,
            hidden: &hidden,
            denoising: denoiser.map(|denoiser| Denoising { denoiser, stop: &progress.stop }),
            threads,
            start,
            read,
        };
        if let Err(failure) = picture.write(exposed) {
            let Some(undenoised) = failure.downcast_ref::<Undenoised>() else {
                resume.say_unwritten();
                return Err(failure);
            };
            resume.say_undenoised();
            return match undenoised.cause {
                DenoiseError::Stopped => {
                    say!("petzval: {failure}");
                    Ok(result(Outcome::Interrupted))
                }
                DenoiseError::Failed(_) | DenoiseError::Unwritable { .. } => Err(failure),
            };
        }
        if alone {
            log_peak(&estimate);
        }
        resume.end(partial, output.path()).map(result)
    }
}

/// Warns that a file does not hold the spectra of the scene's film.
pub(in crate::cli) fn warn_without_spectra(output: &Path) {
    say!(
        "petzval: warning: the film of the scene has buckets of wavelength, and {} shows the colours \
         alone; name a picture.exr, or an array .npy",
        output.display()
    );
}

/// Prepares the job of a command, for a picture of a format or for a part of a picture.
pub(in crate::cli) fn job(
    arguments: &RenderArguments,
    description: Description,
    format: Option<ImageFormat>,
) -> Result<Prepared, Failure> {
    let changes = Changes {
        crop: arguments.crop,
        aim: arguments.pupil.into(),
        layers: arguments.aov.clone(),
        holds_layers: format.is_none_or(|format| format == ImageFormat::Exr),
        holds_spectra: format.is_none_or(|format| format.holds(SPECTRAL_LAYER)),
        stop_criteria: StopCriteria { noise: arguments.noise, time: arguments.time },
        ..arguments.picture.changes()
    };
    Ok(prepare(description, &changes)?)
}

/// Returns the name of the picture, or of the part of it.
fn output(arguments: &RenderArguments, description: &Description) -> Result<PathBuf, Failure> {
    if arguments.is_part() {
        let is_part = |path: &PathBuf| path.extension().is_some_and(|found| found == "petzval");
        let named = arguments.output.clone().filter(is_part);
        return named.ok_or("a part of a picture needs a name: -o PART.petzval".into());
    }
    let named = arguments.output.clone().or_else(|| description.film.filename.clone());
    let stem = || PathBuf::from(arguments.picture.scene.file_stem().unwrap_or_default());
    Ok(named.unwrap_or_else(|| stem().with_extension("exr")))
}

/// Stops a render at Ctrl-C or SIGTERM.
pub(in crate::cli) fn stop_at_signals(progress: Arc<Progress>) {
    on_stop(move || !progress.stop.swap(true, Ordering::Relaxed));
}
