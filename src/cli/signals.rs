//! Signals: Ctrl-C and SIGTERM end every command with one exit code, and a limit of file sizes is an
//! error like a full disk.

use std::sync::Mutex;

use super::INTERRUPTED;

/// Asks a command to stop; false where it was asked before.
type Stop = Box<dyn Fn() -> bool + Send>;

/// How the command stops that has something to save; without one it ends at once.
static STOP: Mutex<Option<Stop>> = Mutex::new(None);

/// Takes the signals over. Threads that run already keep their own masks.
pub(super) fn install() {
    // Where no handler can be had, Ctrl-C ends the program at once, as ever.
    let _ = ctrlc::set_handler(|| {
        let stops = |stop: &Stop| stop();
        // Asked twice, it does not wait for anything.
        if !STOP.lock().is_ok_and(|stop| stop.as_ref().is_some_and(stops)) {
            std::process::exit(i32::from(INTERRUPTED));
        }
    });
    // By default a write beyond the limit kills the program. With the signal blocked the write fails,
    // and the command says which file it was.
    #[cfg(unix)]
    {
        use nix::sys::signal::{SigSet, Signal};
        let mut signals = SigSet::empty();
        signals.add(Signal::SIGXFSZ);
        let _ = signals.thread_block();
    }
}

/// From now on the first signal asks the command to stop, and only the second ends it.
pub(super) fn stop_by(stop: impl Fn() -> bool + Send + 'static) {
    if let Ok(mut place) = STOP.lock() {
        *place = Some(Box::new(stop));
    }
}
