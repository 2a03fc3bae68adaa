//! Writes a rendered picture with its layers and notes, and logs how it came about.

use std::path::Path;
use std::time::{Duration, Instant};

use petzval::aov::Aov;
use petzval::film::{DroppedSamples, SampleId};
use petzval::io::image::{EncodingOptions, ImageFormat, Note, Notes};
use petzval::job::Job;
use petzval::plan::Effect;
use petzval::render::{Convergence, RenderOutput, thread_pool};

use super::camera_model;
use super::log::{log_dropped, log_exposure, log_statistics, reason_for_black};
use crate::cli::arguments::argv::shell_line;
use crate::cli::{Failure, plan};

/// A rendered picture on its way to a file.
pub(in crate::cli) struct PictureOutput<'a> {
    pub job: &'a Job,
    /// Metadata for the file.
    pub notes: Notes,
    /// The command line that writes it.
    pub argv: &'a [String],
    /// The command line that rendered it, or its parts.
    pub rendered_by: &'a [String],
    /// Number and values of a picture of a sweep, which is logged in one line.
    pub label: Option<&'a str>,
    pub output: &'a Path,
    pub encoding: EncodingOptions,
    pub threads: usize,
    /// Start of the command.
    pub start: Instant,
    /// Time of reading and preparing the scene.
    pub read: Duration,
}

impl PictureOutput<'_> {
    /// Writes the picture and logs how it came about.
    pub fn write(self, mut exposed: RenderOutput) -> Result<(), Failure> {
        let Self { job, mut notes, argv, rendered_by, label, output, encoding, threads, .. } = self;
        let Self { start, read, .. } = self;
        let rendered = start.elapsed();
        let samples = sample_notes(&exposed);
        notes.retain(|(name, _)| samples.iter().all(|(other, _)| other != name));
        notes.extend(samples);
        notes.extend(dropped_notes(&exposed.film.dropped));
        notes.push(("software", Note::Text(format!("petzval {}", env!("CARGO_PKG_VERSION")))));
        notes.push(("commandLine", Note::Text(shell_line(argv))));
        if ImageFormat::of(output)? == ImageFormat::Exr {
            notes.extend(camera_model::notes(job));
        }
        let window = job.frame.window();
        let pool = thread_pool(threads)?;
        let layers = match ImageFormat::of(output)? {
            ImageFormat::Exr => pool.install(|| exposed.layers(job)),
            _ => Vec::new(),
        };
        let layered = start.elapsed();
        let stats = std::mem::take(&mut exposed.stats);
        let (convergence, partial) = (exposed.convergence.take(), exposed.partial_mean_spp);
        let (dropped, dark) = (std::mem::take(&mut exposed.film.dropped), exposed.film.is_dark());
        let picture = pool.install(|| exposed.into_picture(job));
        let developed = start.elapsed();
        picture.write_with_layers(&layers, output, window, encoding, &notes)?;

        if label.is_none() {
            say!("{}", plan::table(&job.plan).trim_end());
            log_statistics(job, &stats);
            log_exposure(job, &notes);
        }
        let samples = match (&convergence, partial) {
            (Some(Convergence { noise, mean_spp: mean, min_spp: least, max_spp: most }), _) => {
                say!("noise: {:.3} %; samples a pixel: {least} to {most}", 100.0 * noise);
                format!("{mean:.1}")
            }
            (None, Some(mean)) => format!("{mean:.1}"),
            (None, None) => job.samples.end.to_string(),
        };
        log_dropped(&dropped, rendered_by, job.seed);
        if dark && partial.is_none() {
            say!("petzval: warning: {}", reason_for_black(job, &stats));
        }
        if partial.is_some() && job.layers.contains(&Aov::Variance) {
            say!(
                "petzval: warning: {} has no variance layer: an unfinished render has no \
                 estimate of it yet",
                output.display()
            );
        }
        let mut also = String::new();
        if job.plan.has(Effect::Diffraction) || job.sensor.is_some() {
            let seconds = (developed - layered).as_secs_f64();
            also += &format!(", diffraction and sensor {seconds:.2}");
        }
        if !layers.is_empty() {
            also += &format!(", layers {:.2}", (layered - rendered).as_secs_f64());
        }
        say!(
            "{}{}: {} x {} pixels, {samples} samples, {:.2} s (read {:.2}, render {:.2}{also}, \
             write {:.2})",
            label.map_or_else(String::new, |label| format!("{label}: ")),
            output.display(),
            picture.size[0],
            picture.size[1],
            start.elapsed().as_secs_f64(),
            read.as_secs_f64(),
            (rendered - read).as_secs_f64(),
            (start.elapsed() - developed).as_secs_f64(),
        );
        Ok(())
    }
}

/// Returns notes on the samples and the noise of a picture whose number of samples was not fixed.
fn sample_notes(exposed: &RenderOutput) -> Notes {
    let number = |name, value| (name, Note::Number(value));
    let adaptive = exposed.convergence.iter().flat_map(Convergence::notes);
    let partial = exposed
        .partial_mean_spp
        .into_iter()
        .flat_map(|mean| [number("samplesPerPixel", mean), number("complete", 0.0)]);
    adaptive.chain(partial).collect()
}

/// Returns notes on the samples that were dropped.
fn dropped_notes(dropped: &DroppedSamples) -> Notes {
    if dropped.count() == 0 {
        return Notes::new();
    }
    let name = |name: &SampleId| {
        let ([x, y], SampleId { sample, seed, .. }) = (name.pixel(), name);
        format!("pixel {x},{y} sample {sample} seed {seed}")
    };
    let names: Vec<String> = dropped.first().iter().map(name).collect();
    vec![
        ("droppedSamples", Note::Number(dropped.count() as f64)),
        ("firstDropped", Note::Text(names.join("; "))),
    ]
}
