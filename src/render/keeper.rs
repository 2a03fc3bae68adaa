//! Writing down what a render has come to.

use std::io;
use std::path::PathBuf;
use std::time::Duration;

use super::haunt::Haunt;
use crate::aov::Features;
use crate::checkpoint::{CheckpointError, Head, Reader, Writer};
use crate::film::TileSums;

/// Where a render writes down what it has come to, and how often.
#[derive(Clone, Debug)]
pub struct Keeper {
    /// The checkpoint.
    pub path: PathBuf,
    /// Time between checkpoints; without one there are none, not even when the render is stopped.
    pub every: Option<Duration>,
    /// Where the sums of a finished render go, to be added to others.
    pub part: Option<PathBuf>,
    /// What is known about the render before it begins.
    pub head: Head,
    /// Film samples in a checkpoint of the same picture that stands there and is not gone on from.
    /// One that knows less does not replace it.
    pub standing: u64,
    /// Hears of a checkpoint that cannot be written; the render goes on.
    pub tell: fn(&CheckpointError),
}

/// What a share has received.
pub(super) type Received = (TileSums, Option<Features>);

/// A render that can be written down at any time.
pub(super) trait Keep: Sync {
    /// Whether a share of the present step is entered, by its number.
    fn has(&self, share: usize) -> bool;

    /// Enters what a share of the present step has received.
    fn enter(&self, share: usize, received: Received);

    /// The ghosts so far.
    fn haunt(&mut self) -> &mut Haunt;

    fn save(&self, to: &mut Writer) -> io::Result<()>;

    /// Adds what was saved to what is there.
    fn receive(&mut self, from: &mut Reader) -> io::Result<()>;
}
