//! Statistics of a render: time, rays and lane occupancy by stage, and where rays ended.

mod clock;

use std::time::Duration;

pub use clock::StageClock;
pub use clock::thread_time;

/// A stage of a wave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Chooses film and pupil points.
    Sample,
    /// Traces rays through the lens.
    Lens,
    /// Finds the nearest surfaces.
    Intersect,
    /// Moves rays through media.
    Media,
    /// Records the features of first surfaces, for layers of the picture.
    Record,
    /// Evaluates materials and samples lights.
    Shade,
    /// Traces shadow rays.
    Occlude,
    /// Adds samples to the film.
    Accumulate,
    /// Traces light from the lights through the lens to the film.
    LightPaths,
}

impl Stage {
    /// All stages, in the order in which a wave passes them.
    pub const ALL: [Self; 9] = [
        Self::Sample,
        Self::Lens,
        Self::Intersect,
        Self::Media,
        Self::Record,
        Self::Shade,
        Self::Occlude,
        Self::Accumulate,
        Self::LightPaths,
    ];

    /// The stage's name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sample => "sample",
            Self::Lens => "lens",
            Self::Intersect => "intersect",
            Self::Media => "media",
            Self::Record => "record",
            Self::Shade => "shade",
            Self::Occlude => "occlude",
            Self::Accumulate => "accumulate",
            Self::LightPaths => "light paths",
        }
    }
}

/// How many lanes of a stage's packets held a ray.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LaneOccupancy {
    /// Lanes that held a ray.
    pub live: u64,
    /// All lanes of the packets, eight each.
    pub all: u64,
}

impl LaneOccupancy {
    /// The occupancy of packets that hold `rays` rays without gaps; only the last is padded.
    pub fn packed(rays: usize) -> Self {
        Self { live: rays as u64, all: rays.next_multiple_of(8) as u64 }
    }

    /// Returns the share of live lanes, or `None` if there were no packets.
    pub fn share(&self) -> Option<f64> {
        (self.all > 0).then(|| self.live as f64 / self.all as f64)
    }

    /// Adds the lanes of more packets.
    pub fn add(&mut self, other: Self) {
        self.live += other.live;
        self.all += other.all;
    }
}

/// Lane occupancy of the stages that extend a path by one surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BounceOccupancy {
    /// Occupancy of [`Stage::Intersect`].
    pub intersect: LaneOccupancy,
    /// Occupancy of [`Stage::Shade`], without coated surfaces, which use no packets.
    pub shade: LaneOccupancy,
    /// Occupancy of [`Stage::Occlude`].
    pub occlude: LaneOccupancy,
}

/// Statistics of one stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StageStats {
    /// CPU time, summed over all workers.
    pub time: Duration,
    /// Rays that entered the stage.
    pub rays: u64,
    /// Lane occupancy of its packets.
    pub occupancy: LaneOccupancy,
}

/// Statistics of a render, or of one worker of it.
#[derive(Clone, Debug, Default)]
pub struct Stats {
    /// Statistics by stage, in the order of [`Stage::ALL`].
    pub stages: [StageStats; Stage::ALL.len()],
    /// Statistics of the rays in the lens.
    pub lens: LensStats,
    /// Lane occupancy by the number of surfaces that the path had met before. The last of at most
    /// 1024 entries also holds all deeper ones.
    pub bounces: Vec<BounceOccupancy>,
}

/// Number of path depths that are counted separately.
const MAX_DEPTHS: usize = 1 << 10;

/// Statistics of the rays in a lens.
///
/// The counters of blocked rays grow to the lens that counts into them, so one value serves any
/// lens; [`LensStats::new`] makes room for all its rows at once.
#[derive(Clone, Debug, Default)]
pub struct LensStats {
    /// Rays sent into the lens. Film points that no light reaches send none.
    pub aimed: u64,
    blocked: Vec<u64>,
    /// Rays that f32 could not trace accurately enough and that were traced again in f64.
    pub retraced: u64,
}

impl LensStats {
    /// Counters of a lens of `rows` rows, all 0.
    pub fn new(rows: usize) -> Self {
        Self { aimed: 0, blocked: vec![0; rows], retraced: 0 }
    }

    /// Counters as a checkpoint holds them.
    pub fn restored(aimed: u64, blocked: Vec<u64>, retraced: u64) -> Self {
        Self { aimed, blocked, retraced }
    }

    /// Rays that ended at each row of the prescription. Rows beyond the end of the slice have
    /// blocked none.
    pub fn blocked(&self) -> &[u64] {
        &self.blocked
    }

    /// Returns one counter of blocked rays for each of the `rows` rows of a prescription.
    pub fn blocked_mut(&mut self, rows: usize) -> &mut [u64] {
        if self.blocked.len() < rows {
            self.blocked.resize(rows, 0);
        }
        &mut self.blocked
    }

    /// Returns the number of rays that ended inside the lens.
    pub fn lost(&self) -> u64 {
        self.blocked.iter().fold(0, |sum: u64, &rays| sum.saturating_add(rays))
    }

    fn add(&mut self, other: &Self) {
        for (one, other) in self.blocked_mut(other.blocked.len()).iter_mut().zip(&other.blocked) {
            *one += other;
        }
        self.aimed += other.aimed;
        self.retraced += other.retraced;
    }
}

impl Stats {
    /// Returns the statistics of a stage.
    pub fn stage(&self, stage: Stage) -> StageStats {
        self.stages[stage as usize]
    }

    /// Adds the packets of the sample and lens stages: those of `samples` samples, of which
    /// `emerging` leave the lens as rays.
    pub fn add_camera_packets(&mut self, samples: usize, emerging: usize) {
        let packed = LaneOccupancy::packed(samples);
        self.stages[Stage::Sample as usize].occupancy.add(packed);
        let emerging = LaneOccupancy { live: emerging as u64, ..packed };
        self.stages[Stage::Lens as usize].occupancy.add(emerging);
    }

    /// Adds the packets of the stages that extend paths which have met `depth` surfaces.
    pub fn add_bounce(&mut self, depth: u32, occupancy: BounceOccupancy) {
        self.stages[Stage::Intersect as usize].occupancy.add(occupancy.intersect);
        self.stages[Stage::Shade as usize].occupancy.add(occupancy.shade);
        self.stages[Stage::Occlude as usize].occupancy.add(occupancy.occlude);
        self.add_at_depth(depth as usize, occupancy);
    }

    fn add_at_depth(&mut self, depth: usize, occupancy: BounceOccupancy) {
        let depth = depth.min(MAX_DEPTHS - 1);
        if self.bounces.len() <= depth {
            self.bounces.resize(depth + 1, BounceOccupancy::default());
        }
        let bounce = &mut self.bounces[depth];
        bounce.intersect.add(occupancy.intersect);
        bounce.shade.add(occupancy.shade);
        bounce.occlude.add(occupancy.occlude);
    }

    /// Returns whether a render through a lens of `rows` rows, with at most `depths` surfaces to a
    /// path, can have these statistics.
    pub fn is_consistent(&self, rows: usize, depths: usize) -> bool {
        let lens = &self.lens;
        lens.blocked.len() <= rows && lens.lost() <= lens.aimed && self.bounces.len() <= depths
    }

    /// Adds the statistics of another worker or part.
    pub fn add(&mut self, other: &Self) {
        for (one, other) in self.stages.iter_mut().zip(&other.stages) {
            one.time += other.time;
            one.rays += other.rays;
            one.occupancy.add(other.occupancy);
        }
        for (depth, occupancy) in other.bounces.iter().enumerate() {
            self.add_at_depth(depth, *occupancy);
        }
        self.lens.add(&other.lens);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounces_beyond_the_last_counted_depth_are_counted_together() {
        let intersect = LaneOccupancy::packed(3);
        let mut stats = Stats::default();
        for depth in [0, 5000, 4_000_000_000] {
            stats.add_bounce(depth, BounceOccupancy { intersect, ..BounceOccupancy::default() });
        }
        assert_eq!(stats.bounces.len(), MAX_DEPTHS);
        let live = |depth: usize| stats.bounces[depth].intersect.live;
        assert_eq!([live(0), live(1), live(MAX_DEPTHS - 1)], [3, 0, 6]);
    }

    #[test]
    fn counters_of_blocked_rays_grow_to_the_lens() {
        let mut stats = LensStats::default();
        stats.blocked_mut(3)[2] += 5;
        stats.blocked_mut(2)[0] += 1;
        assert_eq!((stats.blocked(), stats.lost()), (&[1, 0, 5][..], 6));
        let mut sum = LensStats::new(4);
        sum.add(&stats);
        assert_eq!(sum.blocked(), [1, 0, 5, 0]);
    }
}
