//! Writes a rendered picture with its layers and notes, and logs how it came about.

use std::time::{Duration, Instant};

use petzval_base::io::OutputFile;
use petzval_image::{
    DisplayExposure, EncodingOptions, ImageFormat, Note, Notes, SPECTRAL_LAYER, WhiteBalance,
};
use petzval_render::aov::Aov;
use petzval_render::film::{DroppedSamples, SampleId};
use petzval_render::job::Job;
use petzval_render::plan::Effect;
use petzval_render::{Convergence, RenderOutput, thread_pool};

use super::camera_model;
use super::denoising::{Denoising, Undenoised, noisy_files, noisy_layer};
use super::log::{log_dropped, log_exposure, log_statistics, reason_for_black};
use super::summary::{RenderSummary, seconds};
use crate::cli::Failure;
use crate::cli::arguments::argv::shell_line;
use crate::cli::plan::{self, Work};
use crate::cli::screen::{columns, is_verbose};

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
    pub output: &'a OutputFile,
    pub encoding: EncodingOptions,
    /// Layers that are not written.
    pub hidden: &'a [Aov],
    /// The denoiser of a complete picture.
    pub denoising: Option<Denoising<'a>>,
    pub threads: usize,
    /// Start of the command.
    pub start: Instant,
    /// Time of reading and preparing the scene.
    pub read: Duration,
}

impl PictureOutput<'_> {
    /// Writes the picture and logs how it came about.
    pub fn write(self, mut exposed: RenderOutput) -> Result<(), Failure> {
        let Self { job, mut notes, argv, rendered_by, label, output, threads, .. } = self;
        let Self { mut encoding, hidden, start, read, .. } = self;
        let denoising = self.denoising.filter(|_| exposed.partial_mean_spp.is_none());
        let rendered = start.elapsed();
        let samples = sample_notes(&exposed);
        notes.retain(|(name, _)| samples.iter().all(|(other, _)| other != name));
        notes.extend(samples);
        notes.extend(dropped_notes(&exposed.film.dropped));
        notes.push(("software", Note::Text(format!("petzval {}", env!("CARGO_PKG_VERSION")))));
        notes.push(("commandLine", Note::Text(shell_line(argv))));
        let format = ImageFormat::of(output.path())?;
        let holds_layers = format == ImageFormat::Exr;
        if holds_layers {
            notes.extend(camera_model::notes(job));
        }
        let window = job.frame.window();
        let pool = thread_pool(threads)?;
        let is_held = job.layers.iter().any(|aov| format.holds(aov.name()))
            || (job.buckets().is_some() && format.holds(SPECTRAL_LAYER));
        let mut layers = match is_held || denoising.is_some() {
            true => pool.install(|| exposed.layers(job)),
            false => Vec::new(),
        };
        let layered = start.elapsed();
        let stats = std::mem::take(&mut exposed.stats);
        let (convergence, partial) = (exposed.convergence.take(), exposed.partial_mean_spp);
        let (dropped, dark) = (std::mem::take(&mut exposed.film.dropped), exposed.film.is_dark());
        let image = pool.install(|| exposed.into_optical_image(job));
        let (mut denoise_time, mut beside) = (None, None);
        let reading = match denoising {
            None => image.read_out(job),
            Some(denoising) => {
                let begun = Instant::now();
                let [noisy_file, undenoised] = noisy_files(output.path());
                let noisy_file = output.renamed(noisy_file)?;
                let undenoised = output.renamed(undenoised)?;
                let (clean, noisy) = match denoising.apply(image, &layers, job) {
                    Ok(pictures) => pictures,
                    Err((cause, noisy)) => {
                        noisy
                            .into_picture(job, &mut layers)
                            .write_with_layers(&layers, &undenoised, window, encoding, &notes)
                            .inspect_err(|_| say!("petzval: {cause}"))?;
                        return Err(
                            Undenoised { cause, noisy: undenoised.path().to_owned() }.into()
                        );
                    }
                };
                denoise_time = Some(begun.elapsed());
                if holds_layers {
                    layers.push(noisy_layer(&noisy, &encoding));
                } else {
                    beside = Some((noisy, noisy_file));
                }
                notes.push(("denoiser", Note::Text(denoising.denoiser.name())));
                clean
            }
        };
        let picture = reading.into_picture(job, &mut layers);
        layers.retain(|layer| {
            format.holds(&layer.name) && hidden.iter().all(|aov| aov.name() != layer.name)
        });
        let developed = start.elapsed();
        let (mut found_stops, mut found_white) = (None, None);
        if !format.is_linear() {
            // A series can be locked to the exposure that is found, and the noisy picture is as bright.
            let by = DisplayExposure::by(encoding.exposure.factor(&picture));
            if let DisplayExposure::Stops(stops) = by {
                found_stops = (encoding.exposure == DisplayExposure::Auto).then_some(stops);
                notes.push(("displayExposure", Note::Number(stops)));
            }
            let white = encoding.white_balance.found(&picture, by.factor(&picture));
            if let WhiteBalance::White([x, y]) = white {
                let is_auto = encoding.white_balance == WhiteBalance::Auto;
                found_white = is_auto.then_some([x, y]);
                notes.push(("displayWhite", Note::Text(format!("{x:.4},{y:.4}"))));
            }
            (encoding.exposure, encoding.white_balance) = (by, white);
        }
        picture.write_with_layers(&layers, output, window, encoding, &notes)?;
        if let Some((noisy, file)) = beside {
            noisy.write_with_layers(&layers, &file, window, encoding, &notes)?;
        }

        if label.is_none() && is_verbose() {
            let table = plan::table(&job.plan, Work::of(job, threads), columns());
            say!("{}", table.trim_end());
            log_statistics(job, &stats);
            log_exposure(job, &notes);
        }
        let samples = match (&convergence, partial) {
            (Some(Convergence { noise, mean_spp: mean, min_spp: least, max_spp: most }), _) => {
                let noise = 100.0 * noise;
                format!("{mean:.1} samples a pixel ({least} to {most}), noise {noise:.3} %")
            }
            (None, Some(mean)) => format!("{mean:.1} samples a pixel"),
            (None, None) => format!("{} samples a pixel", job.samples.end),
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
        let mut parts = vec![("read", read), ("render", rendered - read)];
        if job.plan.has(Effect::Diffraction) || job.sensor.is_some() {
            let time = developed - layered - denoise_time.unwrap_or_default();
            parts.push(("diffraction and sensor", time));
        }
        parts.extend(denoise_time.map(|time| ("denoise", time)));
        if !layers.is_empty() {
            parts.push(("layers", layered - rendered));
        }
        parts.push(("write", start.elapsed() - developed));
        let parts = parts.iter().map(|&(name, time)| format!("{name} {}", seconds(time)));
        let parts = parts.collect::<Vec<String>>().join(", ");
        let time = format!("{} ({parts})", seconds(start.elapsed()));
        let size = picture.size;
        match label {
            Some(label) => {
                let [width, height] = size;
                say!("{label}: {}: {width} x {height} pixels, {samples}, {time}", output.display());
            }
            None => RenderSummary {
                job,
                notes: &notes,
                rendered_by,
                output: output.path(),
                size,
                samples: &samples,
                time: &time,
                encoding,
                found_stops,
                found_white,
            }
            .print(),
        }
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
