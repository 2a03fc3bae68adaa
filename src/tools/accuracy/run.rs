//! The measurements of a ladder, and the budget that they are made within.

use std::time::{Duration, Instant};

use super::ladder::Ladder;
use super::monitor::RunMonitor;
use super::point::{Point, Reference};
use super::runner::LadderRunner;
use super::split_picture::SplitPicture;
use crate::metric::SizeMismatch;
use petzval_render::RenderError;

/// Time kept for writing the report.
const WRITING: Duration = Duration::from_millis(800);

/// How the run of a ladder ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RunEnd {
    /// It used its budget as planned.
    Planned,
    /// The time was over before every rung had a picture.
    Early,
    /// The user stopped it.
    Interrupted,
}

/// The limits of a run.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    /// Start of the allowed time, which includes reading the scene.
    pub begun: Instant,
    /// Allowed time, which includes writing the report.
    pub time: Duration,
    /// Most samples per pixel.
    pub samples: u32,
}

impl Budget {
    /// Returns when rendering and measuring must end.
    pub(super) fn end(&self) -> Instant {
        self.begun + self.time - WRITING.min(self.time / 4)
    }
}

/// Why a ladder could not be run.
#[derive(Debug, thiserror::Error)]
pub enum LadderError {
    /// A picture could not be rendered.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// Pictures could not be compared.
    #[error(transparent)]
    Size(#[from] SizeMismatch),
}

/// The measurements of a ladder.
#[derive(Clone, Debug)]
pub struct LadderRun {
    /// All points, by rung and number of samples.
    pub points: Vec<Point>,
    /// The reference of the errors; `None` if there was no time for it.
    pub reference: Option<Reference>,
    /// How the run ended.
    pub end: RunEnd,
    /// Time that the run took (s).
    pub seconds: f64,
    /// The last picture of every rung.
    pub(super) pictures: Vec<SplitPicture<4>>,
    /// The picture of the richest rung before its last level.
    pub(super) before: Option<SplitPicture<4>>,
}

impl LadderRun {
    /// Returns the last picture of a rung, and the richest rung's with as many samples and the same
    /// seeds.
    pub fn pair(&self, rung: usize) -> Option<[&SplitPicture<4>; 2]> {
        let own = self.pictures.get(rung).filter(|picture| picture.count > 0)?;
        let richest = self.pictures.last()?;
        Some([own, with_count(own.count, richest, self.before.as_ref())?])
    }

    /// Returns the number of rungs.
    pub fn rungs(&self) -> usize {
        self.pictures.len()
    }

    /// Returns the last point of a rung.
    pub fn last(&self, rung: usize) -> Option<&Point> {
        self.points.iter().rfind(|point| point.rung == rung)
    }
}

/// Returns the richest rung's picture that has this many samples in a quarter.
pub(super) fn with_count<'a>(
    count: u32,
    now: &'a SplitPicture<4>,
    before: Option<&'a SplitPicture<4>>,
) -> Option<&'a SplitPicture<4>> {
    [Some(now), before].into_iter().flatten().find(|picture| picture.count == count)
}

/// Renders and measures a ladder within a budget.
///
/// # Errors
/// Returns an error if threads cannot be started.
pub fn run_ladder(
    ladder: &mut Ladder,
    budget: &Budget,
    monitor: &RunMonitor,
) -> Result<LadderRun, LadderError> {
    monitor.until(budget.end(), || {
        let mut runner = LadderRunner::new(ladder, budget, monitor);
        match runner.run() {
            Ok(()) | Err(LadderError::Render(RenderError::Stopped)) => runner.finish(),
            Err(other) => Err(other),
        }
    })
}
