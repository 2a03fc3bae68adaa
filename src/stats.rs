//! What a render did: time and rays by stage, and where rays ended.

use std::time::{Duration, Instant};

use crate::thread_time::thread_time;

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
    /// Light that is mirrored twice inside the lens, from lights to the film.
    Ghosts,
}

impl Stage {
    /// All of them, in order.
    pub const ALL: [Self; 8] = [
        Self::Sample,
        Self::Lens,
        Self::Intersect,
        Self::Record,
        Self::Shade,
        Self::Occlude,
        Self::Accumulate,
        Self::Ghosts,
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
            Self::Ghosts => "ghosts",
        }
    }
}

/// How full the packets of a stage were.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Lanes {
    /// Lanes that held a ray.
    pub live: u64,
    /// All lanes of the packets, of eight each.
    pub all: u64,
}

impl Lanes {
    /// Rays that stand one after the other, the last packet padded.
    pub fn packed(rays: usize) -> Self {
        Self { live: rays as u64, all: rays.next_multiple_of(8) as u64 }
    }

    /// The share of live lanes; `None` where no packet was worked on.
    pub fn share(&self) -> Option<f64> {
        (self.all > 0).then(|| self.live as f64 / self.all as f64)
    }

    /// Adds more packets.
    pub fn add(&mut self, other: Self) {
        self.live += other.live;
        self.all += other.all;
    }
}

/// The packets of the stages that follow a path, at one of its surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BounceLanes {
    /// Of [`Stage::Intersect`].
    pub intersect: Lanes,
    /// Of [`Stage::Shade`]; coats, which are walked through one by one, are not counted.
    pub shade: Lanes,
    /// Of [`Stage::Occlude`].
    pub occlude: Lanes,
}

/// What one stage did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StageStats {
    /// CPU time spent in it, added up over all workers.
    pub time: Duration,
    /// Rays that went into it.
    pub rays: u64,
    /// How full its packets were.
    pub lanes: Lanes,
}

/// What a render, or one worker of it, did.
#[derive(Clone, Debug, Default)]
pub struct Stats {
    /// By stage, in the order of [`Stage::ALL`].
    pub stages: [StageStats; 8],
    /// What became of the rays in the lens.
    pub lens: LensStats,
    /// Packets by how many surfaces the path had met before; the last of 1024 counts all
    /// that had met more.
    pub bounces: Vec<BounceLanes>,
}

/// Depths of paths that are counted apart from each other.
const MOST_BOUNCES: usize = 1 << 10;

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

    /// Books the packets of the stages before a path, which carry samples, and how many of them
    /// leave the lens.
    pub fn aim(&mut self, samples: usize, leave: usize) {
        let packed = Lanes::packed(samples);
        self.stages[Stage::Sample as usize].lanes.add(packed);
        self.stages[Stage::Lens as usize].lanes.add(Lanes { live: leave as u64, ..packed });
    }

    /// Books the packets of a path's stages at one depth.
    pub fn bounce(&mut self, depth: u32, lanes: BounceLanes) {
        self.stages[Stage::Intersect as usize].lanes.add(lanes.intersect);
        self.stages[Stage::Shade as usize].lanes.add(lanes.shade);
        self.stages[Stage::Occlude as usize].lanes.add(lanes.occlude);
        self.add_bounce(depth as usize, lanes);
    }

    fn add_bounce(&mut self, depth: usize, lanes: BounceLanes) {
        let depth = depth.min(MOST_BOUNCES - 1);
        if self.bounces.len() <= depth {
            self.bounces.resize(depth + 1, BounceLanes::default());
        }
        let of = &mut self.bounces[depth];
        of.intersect.add(lanes.intersect);
        of.shade.add(lanes.shade);
        of.occlude.add(lanes.occlude);
    }

    /// Whether a render through so many rows of a lens, along paths of at most so many surfaces,
    /// can have done this.
    pub fn fits(&self, rows: usize, depths: usize) -> bool {
        let LensStats { aimed, blocked, .. } = &self.lens;
        let lost = blocked.iter().fold(0, |sum: u64, &rays| sum.saturating_add(rays));
        blocked.len() <= rows && lost <= *aimed && self.bounces.len() <= depths
    }

    /// Adds another worker's part.
    pub fn add(&mut self, other: &Self) {
        for (one, other) in self.stages.iter_mut().zip(&other.stages) {
            one.time += other.time;
            one.rays += other.rays;
            one.lanes.add(other.lanes);
        }
        for (depth, lanes) in other.bounces.iter().enumerate() {
            self.add_bounce(depth, *lanes);
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

/// Times stages one after another, on one thread.
///
/// A system call tells the CPU time of a thread, which is too slow for every lap. So laps go by the
/// wall clock, and the CPU time of them all is divided among the stages in proportion.
#[derive(Debug)]
pub struct Clock {
    start: Instant,
    cpu: Duration,
    last: Instant,
    laps: [Duration; Stage::ALL.len()],
}

impl Clock {
    /// Starts now.
    pub fn start() -> Self {
        let now = Instant::now();
        Self { start: now, cpu: thread_time(), last: now, laps: Default::default() }
    }

    /// Counts the time since the last lap for a stage, and books the rays that went into it.
    pub fn lap(&mut self, stats: &mut Stats, stage: Stage, rays: usize) {
        let now = Instant::now();
        self.laps[stage as usize] += now - self.last;
        stats.stages[stage as usize].rays += rays as u64;
        self.last = now;
    }

    /// Books the CPU time of all laps.
    pub fn stop(self, stats: &mut Stats) {
        let wall = self.start.elapsed().as_secs_f64();
        let cpu = thread_time().saturating_sub(self.cpu).as_secs_f64();
        // Both clocks have their rounding.
        let share = if wall > 0.0 { (cpu / wall).min(1.0) } else { 0.0 };
        for (stage, lap) in stats.stages.iter_mut().zip(self.laps) {
            stage.time += lap.mul_f64(share);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn time_in_which_another_program_has_the_cpu_is_not_counted() {
        let (mut stats, mut clock) = (Stats::default(), Clock::start());
        let begun = thread_time();
        let mut work = 1u64;
        while thread_time() - begun < Duration::from_millis(5) {
            work = work.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        }
        clock.lap(&mut stats, Stage::Lens, work as usize % 2);
        std::thread::sleep(Duration::from_millis(100));
        clock.lap(&mut stats, Stage::Shade, 1);
        clock.stop(&mut stats);
        let all: Duration = stats.stages.iter().map(|stage| stage.time).sum();
        assert!(all > Duration::from_millis(4) && all < Duration::from_millis(50), "{all:?}");
    }

    #[test]
    fn deep_paths_are_counted_together() {
        let lanes = BounceLanes { intersect: Lanes::packed(3), ..BounceLanes::default() };
        let mut stats = Stats::default();
        for depth in [0, 5000, 4_000_000_000] {
            stats.bounce(depth, lanes);
        }
        assert_eq!(stats.bounces.len(), MOST_BOUNCES);
        let live = |depth: usize| stats.bounces[depth].intersect.live;
        assert_eq!([live(0), live(1), live(MOST_BOUNCES - 1)], [3, 0, 6]);
    }
}
