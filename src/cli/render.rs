//! `petzval render`

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;

use petzval::image::{Encoding, Format, ImageError, Notes};
use petzval::job::{Changes, prepare};
use petzval::lens::Aim;
use petzval::memory::{Work, machine};
use petzval::render::{Backend, Job, Progress, Until, render_kept};
use petzval::scene::pbrt::{self, Description};

use super::develop::Development;
use super::inputs::{inputs, words};
use super::kept::{Kept, partial_name};
use super::memory::{Memory, say_taken};
use super::progress::Bar;
use super::{BackendArgument, Failure, Outcome, PupilArgument, RenderArguments};

pub(super) fn run(arguments: &RenderArguments) -> Result<Outcome, Failure> {
    let start = Instant::now();
    let memory = Memory::new(arguments.memory);
    let description = pbrt::read(&arguments.picture.scene)?;
    let output = output(arguments, &description)?;
    let holds_layers = arguments.is_part() || Format::of(&output)? == Format::Exr;
    if !holds_layers && !arguments.aov.is_empty() {
        return Err(ImageError::NoLayers { path: output }.into());
    }
    // A long render must not end at a name that nothing can be written to.
    check_folder(&output)?;
    let (mut job, notes) = job(arguments, description, holds_layers)?;
    if arguments.half && !holds_layers {
        say!("petzval: warning: --half is for EXR; {} has 8 bits", output.display());
    }
    let words = words();
    let all = job.samples.len() as u32;
    let inputs = inputs(&words, &job, all)?;
    if let Some(samples) = arguments.part(all)? {
        job.samples = samples;
    }
    let mut kept = Kept::new(arguments, &output, words, inputs, &job, all);
    let from = kept.from(arguments.resume)?;
    let backend = match arguments.backend {
        BackendArgument::Simd => Backend::Simd,
        BackendArgument::Scalar => Backend::Scalar,
    };
    let threads = arguments.threads.map_or_else(machine::cores, usize::from);
    let format = if arguments.is_part() { None } else { Some(Format::of(&output)?) };
    let estimate = memory.check(&job, Work::Render { threads }, format)?;
    let read = start.elapsed();

    let progress = Arc::new(Progress::default());
    progress.samples.store(from.as_ref().map_or(0, |saved| saved.head.taken), Ordering::Relaxed);
    stop_at_signals(progress.clone());
    let bar = Bar::start(&job, progress.clone());
    let exposed = render_kept(&job, backend, threads, &progress, Some(&kept.keeper), from);
    bar.finish();
    let exposed = exposed?;

    if arguments.is_part() {
        say_taken(&estimate);
        return kept.end_part(exposed.partial.is_some(), start.elapsed());
    }
    let output = match exposed.partial {
        // What stands there may be a whole picture.
        Some(_) => partial_name(&output),
        None => output,
    };
    let encoding = Encoding { half: arguments.half, exposure: arguments.exposure };
    let output = &output;
    let development = Development { job: &job, notes, output, encoding, threads, start, read };
    let partial = exposed.partial.is_some();
    if let Err(failure) = development.develop(exposed) {
        kept.say_unwritten();
        return Err(failure);
    }
    say_taken(&estimate);
    kept.end(partial, output)
}

/// The job that is asked for, and what to write about it into the picture.
pub(super) fn job(
    arguments: &RenderArguments,
    description: Description,
    holds_layers: bool,
) -> Result<(Job, Notes), Failure> {
    let changes = Changes {
        crop: arguments.crop.map(|[x0, y0, x1, y1]| [[x0, y0], [x1, y1]]),
        aim: match arguments.pupil {
            PupilArgument::Exit => Aim::Pupil,
            PupilArgument::Rear => Aim::RearDisk,
        },
        layers: arguments.aov.iter().map(|&aov| aov.into()).collect(),
        holds_layers,
        until: Until { noise: arguments.noise, time: arguments.time },
        ..arguments.picture.changes()
    };
    let (job, notes, warnings) = prepare(description, &changes)?;
    for warning in &warnings {
        say!("petzval: warning: {warning}");
    }
    Ok((job, notes))
}

impl RenderArguments {
    /// Whether sums are wanted, not a picture.
    fn is_part(&self) -> bool {
        self.shard.is_some() || self.samples.is_some()
    }

    /// Which of so many samples are wanted, if not all.
    fn part(&self, all: u32) -> Result<Option<Range<u32>>, Failure> {
        let (option, [first, end]) = match (self.shard, self.samples) {
            (Some([shard, shards]), _) => {
                if shards > all {
                    let problem = format!("--shard: {all} samples a pixel make no {shards} shards");
                    return Err(problem.into());
                }
                let share = |n: u32| (u64::from(all) * u64::from(n) / u64::from(shards)) as u32;
                ("--shard", [share(shard - 1), share(shard)])
            }
            (None, Some(range)) => ("--samples", range),
            (None, None) => return Ok(None),
        };
        if let Some(other) = [(self.noise.is_some(), "--noise"), (self.time.is_some(), "--time")]
            .into_iter()
            .find_map(|(given, name)| given.then_some(name))
        {
            let problem = format!(
                "{option} with {other}: how many samples a tile needs is known only where all of \
                 them are; give --spp instead"
            );
            return Err(problem.into());
        }
        match end <= all {
            true => Ok(Some(first..end)),
            false => {
                Err(format!("{option}: the picture has {all} samples a pixel; see --spp").into())
            }
        }
    }
}

/// Where the picture, or the part of it, is to be written.
fn output(arguments: &RenderArguments, description: &Description) -> Result<PathBuf, Failure> {
    if arguments.is_part() {
        let sums = |path: &PathBuf| path.extension().is_some_and(|found| found == "petzval");
        let named = arguments.output.clone().filter(sums);
        return named.ok_or("a part of a picture needs a name: -o PART.petzval".into());
    }
    let named = arguments.output.clone().or_else(|| description.film.filename.clone());
    let stem = || PathBuf::from(arguments.picture.scene.file_stem().unwrap_or_default());
    Ok(named.unwrap_or_else(|| stem().with_extension("exr")))
}

fn stop_at_signals(progress: Arc<Progress>) {
    // Where no handler can be had, Ctrl-C ends the program at once, as ever.
    let _ = ctrlc::set_handler(move || {
        // Asked twice, it does not wait for anything.
        if progress.stop.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(super::INTERRUPTED));
        }
    });
}

pub(super) fn check_folder(output: &Path) -> Result<(), Failure> {
    let folder = match output.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    if output.is_dir() {
        return Err(format!("{} is a folder; name a picture in it", output.display()).into());
    }
    match tempfile::tempfile_in(folder) {
        Ok(_) => Ok(()),
        Err(error) => {
            Err(format!("cannot write {}: {error}; name another picture with -o", output.display())
                .into())
        }
    }
}
