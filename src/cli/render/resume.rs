//! Checkpoint of a render: where it resumes from, and the messages about it.

use std::path::{Path, PathBuf};
use std::time::Duration;

use petzval_base::io::{OutputFile, Outputs};
use petzval_render::checkpoint::{Head, Inputs, SavedRender};
use petzval_render::job::Job;
use petzval_render::{CheckpointNotice, Checkpointer, RenderStart};

use super::RenderArguments;
use super::denoising::noisy_files;
use crate::cli::arguments::argv::{is_faithful, shell_line};
use crate::cli::outputs::claim;
use crate::cli::{Failure, Outcome};

/// The checkpoint that a render writes, and the one that it may resume from.
pub(super) struct Resume {
    pub checkpointer: Checkpointer,
    /// Command line to repeat with `--resume`.
    pub argv: Vec<String>,
    /// The files that the render may write.
    files: RenderFiles,
}

/// The files that a render may write, none of which is an input.
#[derive(Clone, Debug)]
pub(in crate::cli) struct RenderFiles {
    /// The picture or the part.
    pub output: OutputFile,
    /// The unfinished picture.
    pub partial: OutputFile,
    checkpoint: OutputFile,
    noisy: Vec<OutputFile>,
}

impl RenderFiles {
    /// Names the files of a picture or part.
    ///
    /// # Errors
    /// Returns an error if one of them is an input.
    pub fn claim(output: &Path, denoises: bool, outputs: &Outputs) -> Result<Self, Failure> {
        let claim = |path: PathBuf| claim(outputs, path, "-o");
        let mut noisy: Vec<PathBuf> = Vec::new();
        if denoises {
            noisy = noisy_files(output).into();
            noisy.dedup();
        }
        Ok(Self {
            output: claim(output.to_owned())?,
            checkpoint: claim(checkpoint_name(output))?,
            partial: claim(partial_name(output))?,
            noisy: noisy.into_iter().map(claim).collect::<Result<_, _>>()?,
        })
    }

    /// Returns the files of which no picture replaces another.
    #[must_use]
    pub fn only_new(self) -> Self {
        // The unfinished picture of a render that is resumed is replaced, as its checkpoint is.
        let resumed = self.checkpoint.path().exists();
        let new = |file: OutputFile| if resumed { file } else { file.only_new() };
        Self {
            output: self.output.only_new(),
            partial: new(self.partial),
            noisy: self.noisy.into_iter().map(new).collect(),
            checkpoint: self.checkpoint,
        }
    }

    fn all(&self) -> impl Iterator<Item = &OutputFile> {
        [&self.output, &self.checkpoint, &self.partial].into_iter().chain(&self.noisy)
    }
}

impl Resume {
    /// Removes what is left of earlier writes. `all` is the number of samples per pixel of the whole
    /// picture.
    pub fn new(
        arguments: &RenderArguments,
        files: RenderFiles,
        argv: Vec<String>,
        inputs: Inputs,
        job: &Job,
        all: u32,
    ) -> Self {
        files.all().for_each(OutputFile::remove_stale);
        let part = arguments.shard.is_some() || arguments.samples.is_some();
        let head = Head {
            command_line: argv.clone(),
            inputs,
            samples: job.samples.clone(),
            total_samples: all,
            ..Head::default()
        };
        let checkpointer = Checkpointer {
            path: files.checkpoint.clone(),
            interval: arguments.checkpoint.0,
            part_path: part.then(|| files.output.clone()),
            head,
            existing_samples: 0,
            on_error: |error| say!("petzval: warning: {error}; the render continues"),
        };
        Self { checkpointer, argv, files }
    }

    /// Returns the state to resume from, if requested and available.
    ///
    /// # Errors
    /// Returns an error if a resume is requested and the checkpoint is unreadable or of another
    /// picture.
    pub fn saved(&mut self, job: &Job, resume: bool) -> Result<Option<SavedRender>, Failure> {
        match self.checkpointer.start(resume)? {
            RenderStart::Resumed(saved) => {
                let path = self.checkpointer.path.display();
                say!("petzval: resuming from {path}: {}", done(&saved.head, job));
                return Ok(Some(*saved));
            }
            RenderStart::New(Some(notice @ CheckpointNotice::Missing { .. })) => {
                say!("petzval: {notice}");
            }
            RenderStart::New(Some(notice)) => say!("petzval: warning: {notice}"),
            _ => {}
        }
        Ok(None)
    }

    /// Ends a render whose picture is written under this name.
    pub fn end(self, partial: bool, picture: &Path) -> Result<Outcome, Failure> {
        if partial {
            self.say_interrupted();
            say!("petzval: {} is the unfinished picture", picture.display());
            return Ok(Outcome::Interrupted);
        }
        self.clear();
        Ok(Outcome::Done)
    }

    /// Ends a render of a part, whose file is written.
    pub fn end_part(self, partial: bool, time: Duration) -> Result<Outcome, Failure> {
        if partial {
            self.say_interrupted();
            return Ok(Outcome::Interrupted);
        }
        let head = &self.checkpointer.head;
        say!(
            "{}: samples {}..{} of {}, {:.2} s",
            self.files.output.display(),
            head.samples.start,
            head.samples.end,
            head.total_samples,
            time.as_secs_f64()
        );
        self.clear();
        Ok(Outcome::Done)
    }

    fn say_interrupted(&self) {
        let Checkpointer { path, interval: every, .. } = &self.checkpointer;
        say!("petzval: interrupted; {} was not written", self.files.output.display());
        if every.is_none() {
            say!("petzval: there is no checkpoint (--checkpoint off)");
            return;
        }
        say!(
            "petzval: {} holds the state of the render; continue with\n  {}",
            path.display(),
            resume_command(&self.argv)
        );
    }

    /// Says what is left of a render whose picture cannot be written.
    pub fn say_unwritten(&self) {
        let Checkpointer { path, .. } = &self.checkpointer;
        match self.checkpointer.is_saved() {
            true => {
                let (path, command) = (path.display(), resume_command(&self.argv));
                say!(
                    "petzval: {path} holds the state of the render; when there is room, continue \
                     with\n  {command}"
                );
            }
            false => say!(
                "petzval: the samples are lost: the render was too short to checkpoint, or its \
                 checkpoint could not be written either; render again, or to another folder with -o"
            ),
        }
    }

    /// Says how to go on with a picture that was rendered but not denoised.
    pub fn say_undenoised(&self) {
        if self.checkpointer.is_saved() {
            let (path, command) = (self.checkpointer.path.display(), resume_command(&self.argv));
            say!("petzval: {path} holds all samples; denoise again with\n  {command}");
        }
    }

    /// Removes the checkpoint and the unfinished picture of a finished render.
    fn clear(&self) {
        if self.checkpointer.is_saved() {
            for file in [&self.files.checkpoint, &self.files.partial] {
                // A file that cannot be removed is harmless. A link is the user's and stays.
                let _ = file.remove();
            }
        }
    }
}

/// Describes how much of a job is done.
fn done(head: &Head, job: &Job) -> String {
    let lit: u64 = job.tiles().iter().map(|tile| job.sampler(tile, 0..1).count()).sum();
    let mean = head.film_samples as f64 / lit.max(1) as f64;
    match job.stop_criteria.count_only() {
        true => format!("{mean:.1} of {} samples a pixel are done", job.samples.len()),
        false => format!("{mean:.1} samples a pixel are done"),
    }
}

/// Returns the command that resumes a render with this command line.
pub(in crate::cli) fn resume_command(argv: &[String]) -> String {
    if !is_faithful(argv) {
        return "the same command and --resume (it is not UTF-8 and cannot be shown)".into();
    }
    let mut words = argv.to_vec();
    if !words.iter().any(|word| word == "--resume") {
        // After "--" it would be a file name.
        words.insert(words.len().min(2), "--resume".to_owned());
    }
    shell_line(&words)
}

/// Returns the name of a picture's checkpoint.
pub(in crate::cli) fn checkpoint_name(output: &Path) -> PathBuf {
    let mut name = output.as_os_str().to_owned();
    name.push(".checkpoint");
    PathBuf::from(name)
}

/// Returns the name of an unfinished picture.
pub(in crate::cli) fn partial_name(output: &Path) -> PathBuf {
    let extension = output.extension().unwrap_or_default().to_string_lossy();
    output.with_extension(format!("partial.{extension}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_resume_command_can_be_typed() {
        let said = |words: &[&str]| {
            let argv: Vec<String> = words.iter().map(|&word| word.into()).collect();
            resume_command(&argv)
        };
        assert_eq!(
            said(&["petzval", "render", "--", "-a b.pbrt"]),
            "petzval render --resume -- '-a b.pbrt'"
        );
        let resumed = ["petzval", "render", "a.pbrt", "--resume"];
        assert_eq!(said(&resumed), resumed.join(" "));
        assert!(said(&["petzval", "render", "\u{fffd}.pbrt"]).starts_with("the same command"));
    }
}
