//! Run of a program that Ctrl-C or a time limit ends.

#![allow(
    clippy::disallowed_methods,
    reason = "writes the log of a program into a temporary folder"
)]

use std::ffi::OsStr;
use std::fs::{self, File};
use std::io;
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::sleep;
use std::time::{Duration, Instant};

use super::DenoiseError;
use crate::cli::signals::ChildProgram;

/// Time between looks at whether the program has ended.
const PULSE: Duration = Duration::from_millis(10);
/// Time that a signal may take to arrive here after it has ended the program.
const SIGNAL: Duration = Duration::from_millis(200);
/// Longest text of a program that an error repeats (characters).
const LONGEST: usize = 300;
/// Device of Open Image Denoise, if the user chooses no other: pictures must not depend on the
/// graphics card of a machine.
const DEVICE: (&str, &str) = ("OIDN_DEFAULT_DEVICE", "cpu");

/// Runs a program until it ends. Its output goes to the file `log`.
///
/// # Errors
/// Returns an error if the program fails, or if `stop` is set or the time `limit` is over, which kills
/// it.
pub(super) fn call(
    program: &Path,
    arguments: &[&OsStr],
    log: &Path,
    stop: &AtomicBool,
    limit: Option<Duration>,
) -> Result<(), DenoiseError> {
    let failed =
        |problem: String| DenoiseError::Failed(format!("{} failed: {problem}", program.display()));
    let ended = start(program, arguments, log).and_then(|child| wait(child, stop, limit));
    let status = ended.map_err(|error| failed(error.to_string()))?;
    // Ctrl-C of a terminal goes to the program, too, and may end it first.
    if status.is_some_and(|status| !status.success()) && !stop.load(Ordering::Relaxed) {
        sleep(SIGNAL);
    }
    if stop.load(Ordering::Relaxed) {
        return Err(DenoiseError::Stopped);
    }
    let Some(status) = status else {
        let seconds = limit.unwrap_or_default().as_secs_f64();
        return Err(failed(format!("it did not end within {seconds} s and was stopped")));
    };
    match status.success() {
        true => Ok(()),
        false => Err(failed(match last_line(log) {
            words if words.is_empty() => status.to_string(),
            words => format!("{status}: {words}"),
        })),
    }
}

fn start(program: &Path, arguments: &[&OsStr], log: &Path) -> io::Result<ChildProgram> {
    let log = File::create(log)?;
    let mut command = Command::new(program);
    command.args(arguments).stdin(Stdio::null()).stdout(log.try_clone()?).stderr(log);
    if std::env::var_os(DEVICE.0).is_none() {
        command.env(DEVICE.0, DEVICE.1);
    }
    ChildProgram::start(&mut command)
}

/// Returns the status of a program that ended by itself.
fn wait(
    mut child: ChildProgram,
    stop: &AtomicBool,
    limit: Option<Duration>,
) -> io::Result<Option<ExitStatus>> {
    let start = Instant::now();
    loop {
        if let Some(status) = child.ended()? {
            return Ok(Some(status));
        }
        let late = limit.is_some_and(|limit| start.elapsed() >= limit);
        if late || stop.load(Ordering::Relaxed) {
            return Ok(None);
        }
        sleep(PULSE);
    }
}

/// Returns the last line that a program has printed.
fn last_line(log: &Path) -> String {
    let text = fs::read(log).unwrap_or_default();
    let text = String::from_utf8_lossy(&text);
    // A bar of progress returns to the start of its line.
    let mut lines = text.split(['\n', '\r']).map(str::trim).filter(|line| !line.is_empty());
    let last = lines.next_back().unwrap_or_default();
    last.chars().filter(|c| !c.is_control()).take(LONGEST).collect()
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn a_program_that_hangs_is_stopped_with_those_that_it_started() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = |name: &str| folder.path().join(name);
        // The program waits for another, which would write a file.
        let script = format!("(sleep 1; echo alive > '{}') & wait", path("alive").display());
        let arguments: [&OsStr; 2] = ["-c".as_ref(), script.as_ref()];
        let (stop, limit) = (AtomicBool::new(false), Some(Duration::from_millis(100)));
        let ended = call(Path::new("/bin/sh"), &arguments, &path("log"), &stop, limit);
        let problem = ended.expect_err("a limit").to_string();
        assert!(problem.contains("did not end within 0.1 s"), "{problem}");
        sleep(Duration::from_millis(1500));
        assert!(!path("alive").exists());
    }
}
