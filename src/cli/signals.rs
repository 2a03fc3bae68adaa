//! Signal handling: Ctrl-C and SIGTERM end every command with one exit code, and a file-size limit
//! becomes a write error, like a full disk.

use std::sync::Mutex;

use super::INTERRUPTED;

/// Asks a command to stop. Returns false if it was asked before.
type Stop = Box<dyn Fn() -> bool + Send>;

/// Stops a command that has results to save; other commands end at once.
static STOP: Mutex<Option<Stop>> = Mutex::new(None);

/// Installs the handlers. Call it before other threads start, as they keep their own signal masks.
pub(super) fn install() {
    // Without a handler, Ctrl-C ends the program at once, by default.
    let _ = ctrlc::set_handler(|| {
        let stops = |stop: &Stop| stop();
        // A second signal ends the program at once.
        if !STOP.lock().is_ok_and(|stop| stop.as_ref().is_some_and(stops)) {
            std::process::exit(i32::from(INTERRUPTED));
        }
    });
    // By default, a write beyond the limit kills the program. With the signal blocked, the write
    // fails and the error names the file.
    #[cfg(unix)]
    {
        use nix::sys::signal::{SigSet, Signal};
        let mut signals = SigSet::empty();
        signals.add(Signal::SIGXFSZ);
        let _ = signals.thread_block();
    }
}

/// Registers how to stop the command: the first signal asks it to stop, the second ends it.
pub(super) fn on_stop(stop: impl Fn() -> bool + Send + 'static) {
    if let Ok(mut slot) = STOP.lock() {
        *slot = Some(Box::new(stop));
    }
}
