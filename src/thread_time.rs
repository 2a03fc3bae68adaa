//! The CPU time of a thread.

use std::time::Duration;

#[cfg(unix)]
use nix::time::ClockId;

/// The CPU time that the calling thread has taken: a system call of some 0.3 us.
#[cfg(unix)]
pub(crate) fn thread_time() -> Duration {
    let time = ClockId::CLOCK_THREAD_CPUTIME_ID.now();
    time.map_or(Duration::ZERO, Duration::from)
}

/// The time since the first call, where the system tells no CPU time.
#[cfg(not(unix))]
pub(crate) fn thread_time() -> Duration {
    static FIRST: std::sync::LazyLock<std::time::Instant> =
        std::sync::LazyLock::new(std::time::Instant::now);
    FIRST.elapsed()
}
