//! What a render did: time and rays by stage, and where rays ended.

use std::time::{Duration, Instant};

/// The stages of a wave, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Film and pupil points.
    Sample,
    /// Through the lens.
    Lens,
    /// Nearest surfaces.
    Intersect,
    /// What first surfaces are like, for layers of the picture.
    Record,
    /// Materials and lights.
    Shade,
    /// Shadow rays.
    Occlude,
    /// Adding up.
    Accumulate,
}

impl Stage {
    /// All of them, in order.
    pub const ALL: [Self; 7] = [
        Self::Sample,
        Self::Lens,
        Self::Intersect,
        Self::Record,
        Self::Shade,
        Self::Occlude,
        Self::Accumulate,
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sample => "sample",
            Self::Lens => "lens",
            Self::Intersect => "intersect",
            Self::Record => "record",
            Self::Shade => "shade",
            Self::Occlude => "occlude",
            Self::Accumulate => "accumulate",
        }
    }
}

/// What one stage did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StageStats {
    /// Time spent in it, added up over all workers.
    pub time: Duration,
    /// Rays that went into it.
    pub rays: u64,
}

/// What a render, or one worker of it, did.
#[derive(Clone, Debug, Default)]
pub struct Stats {
    /// By stage, in the order of [`Stage::ALL`].
    pub stages: [StageStats; 7],
    /// What became of the rays in the lens.
    pub lens: LensStats,
}

/// What became of rays in a lens.
#[derive(Clone, Debug, Default)]
pub struct LensStats {
    /// Rays sent into the lens: those of film points that light comes to.
    pub aimed: u64,
    /// Rays that ended at each row of the prescription.
    pub blocked: Vec<u64>,
    /// Rays that f32 could not trace exactly enough and f64 did.
    pub redone: u64,
}

impl Stats {
    /// What a stage did.
    pub fn stage(&self, stage: Stage) -> StageStats {
        self.stages[stage as usize]
    }

    /// Adds another worker's part.
    pub fn add(&mut self, other: &Self) {
        for (one, other) in self.stages.iter_mut().zip(&other.stages) {
            one.time += other.time;
            one.rays += other.rays;
        }
        let (lens, other) = (&mut self.lens, &other.lens);
        lens.blocked.resize(lens.blocked.len().max(other.blocked.len()), 0);
        for (one, other) in lens.blocked.iter_mut().zip(&other.blocked) {
            *one += other;
        }
        lens.aimed += other.aimed;
        lens.redone += other.redone;
    }
}

/// Times stages one after another.
#[derive(Debug)]
pub struct Clock {
    last: Instant,
}

impl Clock {
    /// Starts now.
    pub fn start() -> Self {
        Self { last: Instant::now() }
    }

    /// Books the time since the last lap for a stage that these rays went into.
    pub fn lap(&mut self, stats: &mut Stats, stage: Stage, rays: usize) {
        let now = Instant::now();
        let entry = &mut stats.stages[stage as usize];
        entry.time += now - self.last;
        entry.rays += rays as u64;
        self.last = now;
    }
}
