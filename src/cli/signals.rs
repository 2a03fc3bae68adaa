//! Signal handling: Ctrl-C and SIGTERM end every command with one exit code, and a file-size limit
//! becomes a write error, like a full disk.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use tempfile::TempDir;

use super::INTERRUPTED;

/// Asks a command to stop. Returns false if it was asked before.
type Stop = Box<dyn Fn() -> bool + Send>;

/// Stops a command that has results to save; other commands end at once.
static STOP: Mutex<Option<Stop>> = Mutex::new(None);

/// Temporary folders, which a signal removes that ends the program at once.
static FOLDERS: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Temporary folder that is removed when it is dropped, and by a signal that ends the program.
pub(super) struct TemporaryFolder(Option<TempDir>);

impl TemporaryFolder {
    /// Makes a folder.
    ///
    /// # Errors
    /// Returns an error if the system refuses it.
    pub fn new() -> io::Result<Self> {
        let mut folders = FOLDERS.lock().unwrap_or_else(PoisonError::into_inner);
        let folder = tempfile::tempdir()?;
        folders.push(folder.path().to_owned());
        Ok(Self(Some(folder)))
    }

    pub fn path(&self) -> &Path {
        self.0.as_ref().map_or(Path::new(""), TempDir::path)
    }
}

impl Drop for TemporaryFolder {
    fn drop(&mut self) {
        let path = self.path().to_owned();
        drop(self.0.take());
        FOLDERS.lock().unwrap_or_else(PoisonError::into_inner).retain(|other| *other != path);
    }
}

/// Installs the handlers. Call it before other threads start, as they keep their own signal masks.
pub(super) fn install() {
    // Without a handler, Ctrl-C ends the program at once, by default.
    let _ = ctrlc::set_handler(|| {
        let stops = |stop: &Stop| stop();
        // A second signal ends the program at once.
        if !STOP.lock().is_ok_and(|stop| stop.as_ref().is_some_and(stops)) {
            for folder in FOLDERS.lock().unwrap_or_else(PoisonError::into_inner).iter() {
                // Nothing is left to do with an error.
                let _ = fs::remove_dir_all(folder);
            }
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
