//! Run of a program that Ctrl-C ends.

use std::ffi::OsStr;
use std::fs::{self, File};
use std::io;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::sleep;
use std::time::Duration;

use super::DenoiseError;

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
/// Returns an error if the program fails or if `stop` is set, which kills it.
pub(super) fn call(
    program: &Path,
    arguments: &[&OsStr],
    log: &Path,
    stop: &AtomicBool,
) -> Result<(), DenoiseError> {
    let failed =
        |problem: String| DenoiseError::Failed(format!("{} failed: {problem}", program.display()));
    let ended = start(program, arguments, log).and_then(|child| wait(child, stop));
    let status = ended.map_err(|error| failed(error.to_string()))?;
    // Ctrl-C of a terminal goes to the program, too, and may end it first.
    if !status.success() && !stop.load(Ordering::Relaxed) {
        sleep(SIGNAL);
    }
    if stop.load(Ordering::Relaxed) {
        return Err(DenoiseError::Stopped);
    }
    match status.success() {
        true => Ok(()),
        false => Err(failed(match last_line(log) {
            words if words.is_empty() => status.to_string(),
            words => format!("{status}: {words}"),
        })),
    }
}

fn start(program: &Path, arguments: &[&OsStr], log: &Path) -> io::Result<Child> {
    let log = File::create(log)?;
    let mut command = Command::new(program);
    command.args(arguments).stdin(Stdio::null()).stdout(log.try_clone()?).stderr(log);
    if std::env::var_os(DEVICE.0).is_none() {
        command.env(DEVICE.0, DEVICE.1);
    }
    command.spawn()
}

fn wait(mut child: Child, stop: &AtomicBool) -> io::Result<ExitStatus> {
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(status);
        }
        if stop.load(Ordering::Relaxed) {
            child.kill()?;
            return child.wait();
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
