//! The CPU time of a thread.

use std::time::Duration;

/// The CPU time that the calling thread has taken: a system call of some 0.3 us.
#[cfg(unix)]
pub(crate) fn thread_time() -> Duration {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Duration::try_from(time).unwrap_or_default()
}

/// The time since the first call, where the system tells no CPU time.
#[cfg(not(unix))]
pub(crate) fn thread_time() -> Duration {
    static FIRST: std::sync::LazyLock<std::time::Instant> =
        std::sync::LazyLock::new(std::time::Instant::now);
    FIRST.elapsed()
}
