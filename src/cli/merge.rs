//! `petzval merge`: adds up the parts of a picture.

use std::ops::Range;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use petzval_base::io::ByteSize;
use petzval_base::io::{FileLog, Outputs};
use petzval_image::{ImageFormat, SPECTRAL_LAYER};
use petzval_render::checkpoint::{Head, Inputs, SavedRender};
use petzval_render::memory::MemoryTask;
use petzval_render::merge;
use petzval_render::prepare::Prepared;

use super::arguments::argv::{argv, parse_render, shell_line};
use super::arguments::encoding::EncodingArguments;
use super::denoise::Denoiser;
use super::memory::{Memory, log_peak};
use super::outputs::{check_writable, claim};
use super::render::{
    Denoising, PictureOutput, add_guides, check_noisy_files, denoising_bytes, has_guides, inputs,
    job, noisy_files, resume_command, warn_without_spectra,
};
use super::{Failure, Outcome, message};

/// Arguments of `petzval merge`.
#[derive(Debug, clap::Args)]
pub(super) struct MergeArguments {
    /// Parts, in any order: together all samples, each once
    #[arg(required = true, value_name = "PART")]
    parts: Vec<PathBuf>,
    /// Picture to write: .exr, .png, .jpg, .tif, .dng (the mosaic of --bayer) or .npy (an array)
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    #[command(flatten)]
    encoding: EncodingArguments,
    /// Remove the noise, as petzval render does, of parts that were rendered with --denoise
    #[arg(long, value_name = "PROGRAM", num_args = 0..=1, require_equals = true)]
    denoise: Option<Option<PathBuf>>,
    /// Number of threads; one per core by default
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=4096))]
    threads: Option<u16>,
    /// Largest memory use, as for petzval render
    #[arg(long, value_name = "SIZE")]
    memory: Option<ByteSize>,
}

pub(super) fn run(arguments: &MergeArguments) -> Result<Outcome, Failure> {
    let start = Instant::now();
    let MergeArguments { parts, output, encoding, threads, memory, denoise } = arguments;
    let program = denoise.as_ref().map(|program| Denoiser::new(program.as_deref())).transpose()?;
    let memory = Memory::new(*memory);
    let format = ImageFormat::of(output)?;
    check_writable(output, "-o")?;
    let (first, parts) = matching_parts(parts)?;
    let mut files = FileLog::default();
    parts.iter().for_each(|part| files.add(part, None));
    let rendered_by = &first.command_line;
    let render = parse_render(rendered_by)?;
    // Layers, diffraction and the sensor need the scene and the lens.
    let description = petzval_scene_formats::read_with(&render.picture.scene, memory.context())
        .map_err(|error| {
            let command = shell_line(rendered_by);
            format!(
                "{error}\nthe parts were rendered by\n  {command}\nmerge them where its files are"
            )
        })?;
    let Prepared { mut job, notes, warnings } = job(&render, description, None)?;
    let hidden = if render.denoise.is_some() { add_guides(&mut job) } else { Vec::new() };
    if program.is_some() && !has_guides(&job) {
        let problem = "the parts hold no albedo and no normals; render them with --denoise, too";
        return Err(format!("--denoise: {problem}").into());
    }
    files.join(job.files.clone());
    let outputs = Outputs::beside(&files);
    let file = claim(&outputs, output, "-o")?;
    if let Some(program) = &program {
        check_noisy_files(output)?;
        outputs.protect(&program.files());
        let mut noisy = noisy_files(output).to_vec();
        noisy.dedup();
        for noisy in noisy {
            claim(&outputs, noisy, "-o")?;
        }
    }
    encoding.check(output, Some(format), &job)?;
    message::warnings(&warnings);
    // Merging works with any build, but all parts must be of one.
    let build = first.inputs.build.clone();
    let now = Inputs { build, ..inputs(rendered_by, &job, first.total_samples)? };
    let changes = first.inputs.differences(&now);
    if !changes.is_empty() {
        let changes = changes.join("; ");
        return Err(format!("the parts cannot be merged: {changes}").into());
    }
    job.samples = 0..first.total_samples;
    if job.buckets().is_some() && !format.holds(SPECTRAL_LAYER) {
        warn_without_spectra(output);
    }
    let holds_layers = format == ImageFormat::Exr;
    let more = program.as_ref().map(|_| denoising_bytes(&job, holds_layers));
    let estimate = memory.check(&job, MemoryTask::Merge, Some(format), more)?;
    let read = start.elapsed();
    let exposed = merge(&job, &parts)?;
    let encoding = encoding.options(&job, false)?;
    let threads = threads.map_or(0, usize::from);
    let (argv, label, never) = (&argv(), None, AtomicBool::new(false));
    let picture = PictureOutput {
        job: &job,
        notes,
        argv,
        rendered_by,
        label,
        output: &file,
        encoding,
        hidden: &hidden,
        // Ctrl-C ends a merge at once; its parts stay.
        denoising: program.as_ref().map(|denoiser| Denoising { denoiser, stop: &never }),
        threads,
        start,
        read,
    };
    picture.write(exposed)?;
    log_peak(&estimate);
    Ok(Outcome::Done)
}

/// Checks that the parts belong together. Returns a head of them, and their files in the order of
/// their samples.
fn matching_parts(paths: &[PathBuf]) -> Result<(Head, Vec<PathBuf>), Failure> {
    let mut first: Option<Head> = None;
    let mut parts: Vec<(Range<u32>, &PathBuf)> = Vec::new();
    for path in paths {
        let head = SavedRender::open(path)?.head;
        if !head.complete {
            let command = resume_command(&head.command_line);
            let path = path.display();
            return Err(format!("{path} is not finished; continue with\n  {command}").into());
        }
        parts.push((head.samples.clone(), path));
        let Some(first) = &first else {
            first = Some(head);
            continue;
        };
        let changes = first.inputs.differences(&head.inputs);
        if !changes.is_empty() {
            let [one, other] = [&paths[0], path].map(|path| path.display());
            let changes = changes.join("; ");
            return Err(format!("{one} and {other} are of different pictures: {changes}").into());
        }
    }
    let first = first.ok_or("there are no parts to merge")?;
    parts.sort_by_key(|(samples, _)| [samples.start, samples.end]);
    let problems = problems(&parts, first.total_samples);
    match problems.is_empty() {
        true => Ok((first, parts.into_iter().map(|(_, path)| path.clone()).collect())),
        false => Err(problems.join("; ").into()),
    }
}

/// Lists the samples that are missing and those that two parts hold.
fn problems(parts: &[(Range<u32>, &PathBuf)], all: u32) -> Vec<String> {
    let mut problems = Vec::new();
    let missing = |range: Range<u32>| format!("samples {}..{} are missing", range.start, range.end);
    let (mut end, mut last): (u32, Option<&PathBuf>) = (0, None);
    for &(ref samples, path) in parts {
        if samples.start > end {
            problems.push(missing(end..samples.start));
        }
        if let Some(last) = last.filter(|_| samples.start < end) {
            let common = samples.start..end.min(samples.end);
            let [one, other] = [last, path].map(|path| path.display());
            let (start, end) = (common.start, common.end);
            problems.push(format!("{one} and {other} both hold samples {start}..{end}"));
        }
        if samples.end >= end {
            (end, last) = (samples.end, Some(path));
        }
    }
    if end < all {
        problems.push(missing(end..all));
    }
    problems
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_and_doubled_samples_are_listed() {
        let names = ["a", "b", "c"].map(PathBuf::from);
        let found = |ranges: [Range<u32>; 3]| {
            let parts: Vec<_> = ranges.into_iter().zip(&names).collect();
            problems(&parts, 30).join("; ")
        };
        assert_eq!(found([0..10, 10..20, 20..30]), "");
        assert_eq!(
            found([0..10, 12..20, 20..29]),
            "samples 10..12 are missing; samples 29..30 are missing"
        );
        assert_eq!(found([0..10, 5..20, 20..30]), "a and b both hold samples 5..10");
        assert_eq!(
            found([0..30, 5..10, 8..9]),
            "a and b both hold samples 5..10; a and c both hold samples 8..9"
        );
        assert_eq!(found([5..10, 10..20, 20..30]), "samples 0..5 are missing");
    }
}
