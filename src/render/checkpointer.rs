//! Checkpoints of a render: their options, the start from one that exists, and the state that they
//! save.

use std::io;
use std::path::PathBuf;
use std::time::Duration;

use super::checkpoint::{CheckpointError, Head, SavedRender};
use super::splat_accumulator::SplatAccumulator;
use super::wave::TileResult;
use petzval_base::io::OutputFile;
use petzval_base::io::codec::{ChecksumReader, ChecksumWriter};

/// Options of the checkpoints of a render.
#[derive(Clone, Debug)]
pub struct Checkpointer {
    /// The file of the checkpoint.
    pub path: OutputFile,
    /// The time between checkpoints. Without it none are written, not even when the render is stopped.
    pub interval: Option<Duration>,
    /// The file for the sums of a complete render, for merging them with other parts.
    pub part_path: Option<OutputFile>,
    /// The data of the head that are known before the render begins.
    pub head: Head,
    /// The number of film samples in an existing checkpoint of the same picture that is not resumed.
    /// A checkpoint with fewer samples does not replace it.
    pub existing_samples: u64,
    /// Called with the error if a checkpoint cannot be written. The render goes on.
    pub on_error: fn(&CheckpointError),
}

/// Beginning of a render.
#[derive(Debug)]
#[non_exhaustive]
pub enum RenderStart {
    /// No sample is taken yet. The notice is about the file of the checkpoint.
    New(Option<CheckpointNotice>),
    /// The state of the checkpoint.
    Resumed(Box<SavedRender>),
}

/// Notice about the checkpoint of a render that takes no samples from it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CheckpointNotice {
    /// A resume is requested, and there is no checkpoint.
    #[error("there is no {}; rendering from the beginning", path.display())]
    Missing {
        /// The file of the checkpoint.
        path: PathBuf,
    },
    /// The file is unreadable, and is replaced.
    #[error(transparent)]
    Unreadable(CheckpointError),
    /// The checkpoint is of this picture, and stays until the render has as many samples.
    #[error("{} holds a part of this picture; 'resume' would continue from there", path.display())]
    NotResumed {
        /// The file of the checkpoint.
        path: PathBuf,
    },
    /// The checkpoint is of another picture, and is replaced.
    #[error(
        "{} is of another picture ({}); the first checkpoint replaces it",
        path.display(),
        differences.join("; ")
    )]
    OtherPicture {
        /// The file of the checkpoint.
        path: PathBuf,
        /// A sentence for each difference.
        differences: Vec<String>,
    },
}

/// Error of a checkpoint that a render neither resumes nor replaces.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ResumeError {
    /// The file cannot be read.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// The file holds all samples of a part of a picture.
    #[error(
        "{} is a finished part of a picture, not a checkpoint; move it away",
        path.display()
    )]
    FinishedPart {
        /// The file of the checkpoint.
        path: PathBuf,
    },
    /// The checkpoint to resume from is of another picture.
    #[error(
        "cannot resume from {}: {}; without 'resume' the render starts again",
        path.display(),
        differences.join("; ")
    )]
    OtherPicture {
        /// The file of the checkpoint.
        path: PathBuf,
        /// A sentence for each difference.
        differences: Vec<String>,
    },
}

impl Checkpointer {
    /// Opens the checkpoint that exists. With `resume`, the render starts from it. Otherwise it is
    /// replaced; one of the same picture only when the render has as many samples.
    ///
    /// # Errors
    /// Returns an error for a finished part of a picture. With `resume`, returns an error if the
    /// checkpoint is unreadable or of another picture.
    pub fn start(&mut self, resume: bool) -> Result<RenderStart, ResumeError> {
        let path = self.path.path().to_owned();
        let notice = |notice| Ok(RenderStart::New(Some(notice)));
        let found = match SavedRender::open(&path) {
            Err(CheckpointError::Io { source, .. }) if source.kind() == io::ErrorKind::NotFound => {
                let missing = resume.then_some(CheckpointNotice::Missing { path });
                return Ok(RenderStart::New(missing));
            }
            Err(error) if resume => return Err(error.into()),
            Err(error) => return notice(CheckpointNotice::Unreadable(error)),
            Ok(found) if found.head.complete => return Err(ResumeError::FinishedPart { path }),
            Ok(found) => found,
        };
        let differences = self.differences(&found.head);
        match (differences.is_empty(), resume) {
            (true, true) => Ok(RenderStart::Resumed(Box::new(found))),
            (true, false) => {
                self.existing_samples = found.head.film_samples;
                notice(CheckpointNotice::NotResumed { path })
            }
            (false, true) => Err(ResumeError::OtherPicture { path, differences }),
            (false, false) => notice(CheckpointNotice::OtherPicture { path, differences }),
        }
    }

    /// Returns whether there is a checkpoint of this render.
    pub fn is_saved(&self) -> bool {
        SavedRender::open(self.path.path())
            .is_ok_and(|saved| !saved.head.complete && self.differences(&saved.head).is_empty())
    }

    /// Returns a sentence for each difference of a checkpoint from this render.
    fn differences(&self, saved: &Head) -> Vec<String> {
        let mut differences = saved.inputs.differences(&self.head.inputs);
        if saved.samples != self.head.samples {
            let range = |head: &Head| format!("{}..{}", head.samples.start, head.samples.end);
            let (then, now) = (range(saved), range(&self.head));
            differences.push(format!("its samples are {then}, and these {now}"));
        }
        differences
    }
}

/// State of a render that can be saved at any time.
pub(super) trait RenderState: Sync {
    /// Returns whether the result of a work item of the current pass is there, by its number.
    fn is_done(&self, item: usize) -> bool;

    /// Adds the result of a work item of the current pass.
    fn add_result(&self, item: usize, result: TileResult);

    fn splats(&mut self) -> &mut SplatAccumulator;

    fn save(&self, to: &mut ChecksumWriter) -> io::Result<()>;

    /// Adds a saved state to this one.
    fn add_saved(&mut self, from: &mut ChecksumReader) -> io::Result<()>;
}
