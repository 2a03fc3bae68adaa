//! What a render leaves behind on its way, and where it goes on from.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use petzval::checkpoint::{CheckpointError, Head, Inputs, Saved};
use petzval::image::{sweep, target};
use petzval::render::{Job, Keeper};

use super::inputs::line;
use super::{Failure, Outcome, RenderArguments};

/// The checkpoint of a render, and what stood under its name before.
pub(super) struct Kept {
    pub keeper: Keeper,
    /// The command that goes on with it when `--resume` is added.
    pub again: Vec<String>,
    /// The checkpoint that is there already.
    found: Option<Result<Saved, CheckpointError>>,
    /// The picture or the part that is to come.
    output: PathBuf,
}

impl Kept {
    /// Of a job whose picture has so many samples a pixel in all.
    pub fn new(
        arguments: &RenderArguments,
        output: &Path,
        words: Vec<String>,
        inputs: Inputs,
        job: &Job,
        all: u32,
    ) -> Self {
        let path = checkpoint_name(output);
        for path in written(output) {
            sweep(&path);
        }
        let found = match Saved::open(&path) {
            Err(CheckpointError::Io { source, .. }) if source.kind() == io::ErrorKind::NotFound => {
                None
            }
            found => Some(found),
        };
        let part = arguments.shard.is_some() || arguments.samples.is_some();
        let again = words.clone();
        let head = Head { words, inputs, samples: job.samples.clone(), of: all, ..Head::default() };
        let keeper = Keeper {
            path,
            every: arguments.checkpoint.0,
            part: part.then(|| output.to_owned()),
            head,
            standing: 0,
            tell: |error| say!("petzval: warning: {error}; the render goes on"),
        };
        Self { keeper, again, found, output: output.to_owned() }
    }

    /// What to go on from, if that is wanted and there is something.
    pub fn from(&mut self, job: &Job, resume: bool) -> Result<Option<Saved>, Failure> {
        let path = self.keeper.path.display();
        let found = match (self.found.take(), resume) {
            (None, false) => return Ok(None),
            (None, true) => {
                say!("petzval: there is no {path}; rendering from the beginning");
                return Ok(None);
            }
            (Some(Err(error)), true) => return Err(error.into()),
            (Some(Err(error)), false) => {
                say!("petzval: warning: {error}");
                return Ok(None);
            }
            (Some(Ok(found)), _) if found.head.complete => {
                let problem = "is a finished part of a picture and no checkpoint; move it away";
                return Err(format!("{path} {problem}").into());
            }
            (Some(Ok(found)), _) => found,
        };
        let changes = self.changes(&found.head);
        match (changes.is_empty(), resume) {
            (true, true) => {
                say!("petzval: going on from {path}: {}", done(&found.head, job));
                Ok(Some(found))
            }
            (true, false) => {
                self.keeper.standing = found.head.taken;
                say!(
                    "petzval: warning: {path} holds a part of this picture; --resume would go on \
                     from there"
                );
                Ok(None)
            }
            (false, true) => Err(format!(
                "cannot go on from {path}: {}; without --resume the render begins again",
                changes.join("; ")
            )
            .into()),
            (false, false) => {
                say!(
                    "petzval: warning: {path} is of another picture ({}); the first checkpoint \
                     replaces it",
                    changes.join("; ")
                );
                Ok(None)
            }
        }
    }

    fn changes(&self, head: &Head) -> Vec<String> {
        let own = &self.keeper.head;
        let mut changes = head.inputs.changes(&own.inputs);
        if head.samples != own.samples {
            let range = |head: &Head| format!("{}..{}", head.samples.start, head.samples.end);
            changes.push(format!("its samples are {}, and these {}", range(head), range(own)));
        }
        changes
    }

    /// What becomes of it behind the render, when the picture of this name is written.
    pub fn end(self, partial: bool, picture: &Path) -> Result<Outcome, Failure> {
        if partial {
            self.say_interrupted();
            say!("petzval: {} is what there is of the picture", picture.display());
            return Ok(Outcome::Interrupted);
        }
        self.clear();
        Ok(Outcome::Done)
    }

    /// The end of a render whose sums were wanted.
    pub fn end_part(self, partial: bool, time: Duration) -> Result<Outcome, Failure> {
        if partial {
            self.say_interrupted();
            return Ok(Outcome::Interrupted);
        }
        let head = &self.keeper.head;
        say!(
            "{}: samples {}..{} of {}, {:.2} s",
            self.output.display(),
            head.samples.start,
            head.samples.end,
            head.of,
            time.as_secs_f64()
        );
        self.clear();
        Ok(Outcome::Done)
    }

    fn say_interrupted(&self) {
        let Keeper { path, every, .. } = &self.keeper;
        say!("petzval: interrupted; {} was not written", self.output.display());
        if every.is_none() {
            say!("petzval: there is no checkpoint (--checkpoint off)");
            return;
        }
        say!(
            "petzval: {} holds what is done; go on with\n  {}",
            path.display(),
            resume(&self.again)
        );
    }

    /// What is left of a render whose picture cannot be written.
    pub fn say_unwritten(&self) {
        let Keeper { path, .. } = &self.keeper;
        match self.holds_own() {
            true => {
                let (path, resume) = (path.display(), resume(&self.again));
                say!(
                    "petzval: {path} holds what is done; when there is room, go on with\n  {resume}"
                );
            }
            false => say!(
                "petzval: the samples are lost: there is no checkpoint of what took so short, or \
                 it could not be written either; render again, or to another folder with -o"
            ),
        }
    }

    /// Whether the checkpoint is there, and of this picture.
    fn holds_own(&self) -> bool {
        let own = |saved: Saved| !saved.head.complete && self.changes(&saved.head).is_empty();
        Saved::open(&self.keeper.path).is_ok_and(own)
    }

    /// Removes the checkpoint of a picture that is finished, and the picture of what there was.
    fn clear(&self) {
        let path = &self.keeper.path;
        if self.holds_own() {
            for path in [path, &partial_name(&self.output)] {
                // A file too many is no reason to fail; a link is the user's.
                let _ = target(path).and_then(fs::remove_file);
            }
        }
    }
}

/// How much of a job is done, in words.
fn done(head: &Head, job: &Job) -> String {
    let lit: u64 = job.frame.tiles().iter().map(|tile| job.sampler(tile, 0..1).count()).sum();
    let mean = head.taken as f64 / lit.max(1) as f64;
    match job.until.count_only() {
        true => format!("{mean:.1} of {} samples a pixel are done", job.samples.len()),
        false => format!("{mean:.1} samples a pixel are done"),
    }
}

/// The command that goes on with a render that these words began.
pub(super) fn resume(words: &[String]) -> String {
    if words.iter().any(|word| word.contains(char::REPLACEMENT_CHARACTER)) {
        // It would name other files.
        return "the same command and --resume (it holds what is no UTF-8, and cannot be shown)"
            .into();
    }
    let mut words = words.to_vec();
    if !words.iter().any(|word| word == "--resume") {
        // Behind "--" it would be a name.
        words.insert(words.len().min(2), "--resume".to_owned());
    }
    line(&words)
}

/// The names that a render of this picture or part may write to.
pub(super) fn written(output: &Path) -> [PathBuf; 3] {
    [output.to_owned(), checkpoint_name(output), partial_name(output)]
}

/// The name of a picture's checkpoint.
pub(super) fn checkpoint_name(output: &Path) -> PathBuf {
    let mut name = output.as_os_str().to_owned();
    name.push(".checkpoint");
    PathBuf::from(name)
}

/// The name of what there is of a picture.
pub(super) fn partial_name(output: &Path) -> PathBuf {
    let extension = output.extension().unwrap_or_default().to_string_lossy();
    output.with_extension(format!("partial.{extension}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_render_is_gone_on_with_by_a_command_that_can_be_typed() {
        let said =
            |words: &[&str]| resume(&words.iter().map(|word| (*word).into()).collect::<Vec<_>>());
        assert_eq!(
            said(&["petzval", "render", "--", "-a b.pbrt"]),
            "petzval render --resume -- '-a b.pbrt'"
        );
        let resumed = ["petzval", "render", "a.pbrt", "--resume"];
        assert_eq!(said(&resumed), resumed.join(" "));
        assert!(said(&["petzval", "render", "\u{fffd}.pbrt"]).starts_with("the same command"));
    }
}
