//! Checkpoints of a running render: their options, and the state that they save.

use std::io;
use std::time::Duration;

use super::checkpoint::{CheckpointError, Head};
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
