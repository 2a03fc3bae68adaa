//! What reading a scene may take. Files declare sizes before they are asked for: what would
//! not fit is refused then, also where only the sum of many does not.

use std::sync::atomic::{AtomicU64, Ordering};

use super::Size;

static MOST: AtomicU64 = AtomicU64::new(u64::MAX);
static CLAIMED: AtomicU64 = AtomicU64::new(0);

/// From now on, what is read may take so many bytes in all.
pub fn allow(most: u64) {
    MOST.store(most, Ordering::Relaxed);
    CLAIMED.store(0, Ordering::Relaxed);
}

/// Refuses what would take more bytes, for a time, than there are left.
pub(crate) fn fits(bytes: u64) -> Result<(), String> {
    within(CLAIMED.load(Ordering::Relaxed), bytes)
}

/// Takes bytes for good, or refuses them.
pub(crate) fn claim(bytes: u64) -> Result<(), String> {
    let mut refused = Ok(());
    let add = |taken: u64| {
        refused = within(taken, bytes);
        refused.is_ok().then(|| taken + bytes)
    };
    let _ = CLAIMED.fetch_update(Ordering::Relaxed, Ordering::Relaxed, add);
    refused
}

/// Reads what is dropped again: what was claimed meanwhile is given back. Nobody else may read at the
/// same time.
pub fn lent<T>(read: impl FnOnce() -> T) -> T {
    let before = CLAIMED.load(Ordering::Relaxed);
    let answer = read();
    CLAIMED.store(before, Ordering::Relaxed);
    answer
}

fn within(taken: u64, bytes: u64) -> Result<(), String> {
    let most = MOST.load(Ordering::Relaxed);
    if taken.saturating_add(bytes) <= most {
        return Ok(());
    }
    let before = match taken {
        0 => String::new(),
        _ => format!(" beside the {} read before", Size(taken)),
    };
    Err(format!("it takes {} of memory{before}, and there are {}", Size(bytes), Size(most)))
}
