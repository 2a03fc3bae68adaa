//! Signal handling: Ctrl-C and SIGTERM end every command with one exit code, and a file-size limit
//! becomes a write error, like a full disk.

#![allow(clippy::disallowed_methods, reason = "removes temporary folders")]

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus};
use std::sync::{Mutex, PoisonError};

use tempfile::TempDir;

use super::INTERRUPTED;

/// Asks a command to stop. Returns false if it was asked before.
type Stop = Box<dyn Fn() -> bool + Send>;

/// Stops a command that has results to save; other commands end at once.
static STOP: Mutex<Option<Stop>> = Mutex::new(None);

/// Temporary folders, which a signal removes that ends the program at once.
static FOLDERS: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Programs that run for this one, which a signal ends that ends the program at once.
static PROGRAMS: Mutex<Vec<u32>> = Mutex::new(Vec::new());

/// Program that runs for this one. It ends, with those that it has started, when this is dropped, and
/// by a signal that ends this program.
pub(super) struct ChildProgram {
    child: Child,
    ended: bool,
}

impl ChildProgram {
    /// Starts a program.
    ///
    /// # Errors
    /// Returns an error if it cannot be started.
    pub fn start(command: &mut Command) -> io::Result<Self> {
        // A group of its own, so that the programs that it starts end with it.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(command, 0);
        // A signal waits until the program is on the list.
        let mut programs = PROGRAMS.lock().unwrap_or_else(PoisonError::into_inner);
        let child = command.spawn()?;
        programs.push(child.id());
        Ok(Self { child, ended: false })
    }

    /// Returns the status of a program that has ended.
    ///
    /// # Errors
    /// Returns an error if the system gives no status.
    pub fn ended(&mut self) -> io::Result<Option<ExitStatus>> {
        let status = self.child.try_wait()?;
        if status.is_some() && !self.ended {
            self.ended = true;
            self.unlist();
        }
        Ok(status)
    }

    fn unlist(&self) {
        let id = self.child.id();
        PROGRAMS.lock().unwrap_or_else(PoisonError::into_inner).retain(|other| *other != id);
    }
}

impl Drop for ChildProgram {
    fn drop(&mut self) {
        if !self.ended {
            end_group(self.child.id());
            // Nothing is left to do with an error.
            let _ = self.child.kill();
            let _ = self.child.wait();
            self.unlist();
        }
    }
}

/// Ends a program and those that it has started.
#[cfg(unix)]
fn end_group(leader: u32) {
    use nix::sys::signal::{Signal, killpg};
    if let Ok(leader) = i32::try_from(leader) {
        let _ = killpg(nix::unistd::Pid::from_raw(leader), Signal::SIGKILL);
    }
}

#[cfg(not(unix))]
fn end_group(_: u32) {}

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
            for program in PROGRAMS.lock().unwrap_or_else(PoisonError::into_inner).iter() {
                end_group(*program);
            }
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
