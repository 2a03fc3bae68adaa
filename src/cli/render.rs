//! `petzval render`

use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use petzval::checkpoint::{CheckpointError, Inputs};
use petzval::image::{Encoding, Format, ImageError, Notes};
use petzval::job::{Changes, prepare};
use petzval::memory::{Estimate, Work, machine};
use petzval::render::{Job, Progress, RenderError, Until, render_kept};
use petzval::scene::pbrt::{self, Description};
use petzval::source::Warning;

use super::develop::Development;
use super::inputs::{inputs, words};
use super::kept::{Kept, partial_name, written};
use super::memory::{Memory, say_taken};
use super::message;
use super::outputs::{check_distinct, check_writable};
use super::progress::Bar;
use super::signals::stop_by;
use super::{Failure, Outcome, RenderArguments};

pub(super) fn run(arguments: &RenderArguments) -> Result<Outcome, Failure> {
    if !arguments.sweep.is_empty() {
        return super::sweep::run(arguments);
    }
    let start = Instant::now();
    let memory = Memory::new(arguments.memory);
    let description = pbrt::read(&arguments.picture.scene)?;
    let (shot, warnings) = Shot::new(arguments, words(), description, &memory, start)?;
    message::warnings(&warnings);
    let progress = Arc::new(Progress::default());
    stop_at_signals(progress.clone());
    Ok(shot.take(&progress, None)?.outcome)
}

/// A picture that is made ready to be taken.
pub(super) struct Shot<'a> {
    arguments: &'a RenderArguments,
    words: Vec<String>,
    output: PathBuf,
    pub job: Job,
    notes: Notes,
    /// All that decides about its samples.
    pub inputs: Inputs,
    /// The samples that a pixel has in the end.
    all: u32,
    threads: usize,
    /// The memory that it takes.
    estimate: Estimate,
    start: Instant,
}

/// Of what a picture is one, for what is said about it.
pub(super) struct Among<'a> {
    /// Its number, in words.
    pub number: &'a str,
    /// The command that takes them all.
    pub words: &'a [String],
}

/// What came of a picture.
pub(super) struct Taken {
    pub outcome: Outcome,
    /// Samples a pixel, in the mean.
    pub samples: f64,
    pub noise: Option<f64>,
    pub time: Duration,
}

impl<'a> Shot<'a> {
    /// The picture that these words ask for; and what was noticed on the way.
    pub fn new(
        arguments: &'a RenderArguments,
        words: Vec<String>,
        description: Description,
        memory: &Memory,
        start: Instant,
    ) -> Result<(Self, Vec<Warning>), Failure> {
        let output = output(arguments, &description)?;
        let holds_layers = arguments.is_part() || Format::of(&output)? == Format::Exr;
        if !holds_layers && !arguments.aov.is_empty() {
            return Err(ImageError::NoLayers { path: output }.into());
        }
        // A long render must not end at a name that nothing can be written to.
        check_writable(&output, "-o")?;
        let (mut job, notes, warnings) = job(arguments, description, holds_layers)?;
        check_distinct(written(&output), "-o", &job.files)?;
        if arguments.half && !holds_layers {
            say!("petzval: warning: --half is for EXR; {} has 8 bits", output.display());
        }
        let all = job.samples.len() as u32;
        let inputs = inputs(&words, &job, all)?;
        if let Some(samples) = arguments.part(all)? {
            job.samples = samples;
        }
        let threads = arguments.threads.map_or_else(machine::cores, usize::from);
        let format = if arguments.is_part() { None } else { Some(Format::of(&output)?) };
        let estimate = memory.check(&job, Work::Render { threads }, format)?;
        let shot =
            Self { arguments, words, output, job, notes, inputs, all, threads, estimate, start };
        Ok((shot, warnings))
    }

    /// Takes it, until the end or until somebody stops it.
    pub fn take(self, progress: &Arc<Progress>, among: Option<Among>) -> Result<Taken, Failure> {
        let Self { arguments, words, output, job, notes, inputs, all, threads, .. } = self;
        let Self { estimate, start, .. } = self;
        let mut kept = Kept::new(arguments, &output, words.clone(), inputs, &job, all);
        if let Some(among) = &among {
            kept.again = among.words.to_vec();
        }
        let from = kept.from(&job, arguments.resume)?;
        let read = start.elapsed();

        let earlier = from.as_ref().map_or(0, |saved| saved.head.taken);
        progress.samples.store(earlier, Ordering::Relaxed);
        progress.expected.store(0, Ordering::Relaxed);
        let bar = Bar::start(&job, progress.clone());
        let backend = arguments.backend.into();
        let exposed = render_kept(&job, backend, threads, progress, Some(&kept.keeper), from);
        bar.finish();
        if let Err(RenderError::Checkpoint(CheckpointError::Io { verb: "write", .. })) = &exposed {
            kept.say_unwritten();
        }
        let exposed = exposed?;

        let reached = exposed.reached.as_ref();
        let samples = reached.map(|reached| reached.mean).unwrap_or_else(|| f64::from(all));
        let noise = reached.map(|reached| reached.noise);
        let ended = |outcome| Taken { outcome, samples, noise, time: start.elapsed() };
        let partial = exposed.partial.is_some();
        if arguments.is_part() {
            say_taken(&estimate);
            return kept.end_part(partial, start.elapsed()).map(ended);
        }
        let output = match partial {
            // What stands there may be a whole picture.
            true => partial_name(&output),
            false => output,
        };
        let encoding = Encoding { half: arguments.half, exposure: arguments.exposure };
        let (output, words, among) = (&output, &words, among.map(|among| among.number));
        let alone = among.is_none();
        let development = Development {
            job: &job,
            notes,
            words,
            rendered_by: words,
            among,
            output,
            encoding,
            threads,
            start,
            read,
        };
        if let Err(failure) = development.develop(exposed) {
            kept.say_unwritten();
            return Err(failure);
        }
        if alone {
            say_taken(&estimate);
        }
        kept.end(partial, output).map(ended)
    }
}

/// The job that is asked for, what to write about it into the picture, and what was noticed.
pub(super) fn job(
    arguments: &RenderArguments,
    description: Description,
    holds_layers: bool,
) -> Result<(Job, Notes, Vec<Warning>), Failure> {
    let changes = Changes {
        crop: arguments.crop.map(|[x0, y0, x1, y1]| [[x0, y0], [x1, y1]]),
        aim: arguments.pupil.into(),
        layers: arguments.aov.iter().map(|&aov| aov.into()).collect(),
        holds_layers,
        until: Until { noise: arguments.noise, time: arguments.time },
        ..arguments.picture.changes()
    };
    Ok(prepare(description, &changes)?)
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

pub(super) fn stop_at_signals(progress: Arc<Progress>) {
    stop_by(move || !progress.stop.swap(true, Ordering::Relaxed));
}
