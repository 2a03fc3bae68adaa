//! Clocks: the CPU time of a thread, and its division among stages.

use std::time::{Duration, Instant};

#[cfg(unix)]
use nix::time::ClockId;

use super::{Stage, Stats};

/// Measures the time of consecutive stages on one thread.
///
/// The CPU time of a thread takes a system call, which is too slow for every lap. Laps are
/// therefore measured by the wall clock, and the CPU time of all laps is divided among the stages
/// in proportion.
#[derive(Debug)]
pub struct StageClock {
    start: Instant,
    cpu: Duration,
    last: Instant,
    laps: [Duration; Stage::ALL.len()],
}

impl StageClock {
    /// Starts the clock.
    pub fn start() -> Self {
        let now = Instant::now();
        Self { start: now, cpu: thread_time(), last: now, laps: Default::default() }
    }

    /// Assigns the time since the last lap to `stage`, and counts the rays that entered it.
    pub fn lap(&mut self, stats: &mut Stats, stage: Stage, rays: usize) {
        let now = Instant::now();
        self.laps[stage as usize] += now - self.last;
        stats.stages[stage as usize].rays += rays as u64;
        self.last = now;
    }

    /// Adds the CPU time of all laps to the statistics.
    pub fn stop(self, stats: &mut Stats) {
        let wall = self.start.elapsed().as_secs_f64();
        let cpu = thread_time().saturating_sub(self.cpu).as_secs_f64();
        // Both clocks are rounded, so the CPU time may exceed the wall time slightly.
        let share = if wall > 0.0 { (cpu / wall).min(1.0) } else { 0.0 };
        for (stage, lap) in stats.stages.iter_mut().zip(self.laps) {
            stage.time += lap.mul_f64(share);
        }
    }
}

/// Returns the CPU time of the calling thread. The system call takes about 0.3 us.
#[cfg(unix)]
pub fn thread_time() -> Duration {
    let time = ClockId::CLOCK_THREAD_CPUTIME_ID.now();
    time.map_or(Duration::ZERO, Duration::from)
}

/// Returns the wall time since the first call, as this system reports no CPU time of a thread.
#[cfg(not(unix))]
pub fn thread_time() -> Duration {
    static FIRST: std::sync::LazyLock<Instant> = std::sync::LazyLock::new(Instant::now);
    FIRST.elapsed()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn time_asleep_is_not_counted() {
        let (mut stats, mut clock) = (Stats::default(), StageClock::start());
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
}
