//! Work on a thread of its own, during which Python answers to Ctrl-C.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::mpsc;
use std::time::Duration;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

/// How often work is asked whether Ctrl-C ends it, and for its progress.
const PULSE: Duration = Duration::from_millis(50);
/// Stack of the thread: that of a program's main thread.
const STACK: usize = 8 << 20;

/// The process in which work was begun; 0 before.
static PROCESS: AtomicU32 = AtomicU32::new(0);

/// Returns an error in a process that was forked from one in which work was begun: it has no threads,
/// so that work would never end.
pub fn check_process() -> PyResult<()> {
    let here = std::process::id();
    match PROCESS.compare_exchange(0, here, Ordering::Relaxed, Ordering::Relaxed) {
        Err(other) if other != here => Err(PyRuntimeError::new_err(
            "this process was forked from one that has used petzval, and has none of its threads; \
             start processes by multiprocessing.get_context(\"spawn\"), or fork before the first use",
        )),
        _ => Ok(()),
    }
}

/// Runs `work` without the interpreter's lock. Some 20 times a second it calls `pulse`, and sets
/// `stop` if that fails or if the user presses Ctrl-C.
pub fn run<T: Send>(
    py: Python<'_>,
    stop: &AtomicBool,
    pulse: impl Fn(Python<'_>) -> PyResult<()> + Send + Sync,
    work: impl FnOnce() -> T + Send,
) -> PyResult<T> {
    check_process()?;
    let interrupt: Mutex<Option<PyErr>> = Mutex::new(None);
    let lock = || interrupt.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    let look = || {
        let outcome = Python::attach(|py| py.check_signals().and_then(|()| pulse(py)));
        if let Err(error) = outcome {
            stop.store(true, Ordering::Relaxed);
            lock().get_or_insert(error);
        }
    };
    let result = py.detach(|| {
        let (done, wait) = mpsc::channel::<()>();
        std::thread::scope(|scope| {
            let work = || {
                // The sender is dropped with the thread, also by a panic.
                let _done = done;
                work()
            };
            let worker = std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, work)?;
            while let Err(mpsc::RecvTimeoutError::Timeout) = wait.recv_timeout(PULSE) {
                look();
            }
            worker.join().map_err(|panic| panicked(&*panic))
        })
    });
    match lock().take() {
        Some(error) => Err(error),
        None => result,
    }
}

/// Runs `work` that cannot be stopped on a thread that Ctrl-C leaves to itself: it ends in the
/// background, and its result is dropped. `abandoned` is called then.
pub fn run_or_abandon<T: Send + 'static>(
    py: Python<'_>,
    abandoned: impl FnOnce(),
    work: impl FnOnce() -> T + Send + 'static,
) -> PyResult<T> {
    check_process()?;
    let (send, receive) = mpsc::sync_channel(1);
    let work = move || {
        // Nobody may be left to take it.
        let _ = send.send(catch_unwind(AssertUnwindSafe(work)));
    };
    std::thread::Builder::new().stack_size(STACK).spawn(work)?;
    let receive = Mutex::new(receive);
    loop {
        let received = py.detach(|| {
            receive.lock().unwrap_or_else(|poison| poison.into_inner()).recv_timeout(PULSE)
        });
        if let Err(interrupt) = py.check_signals() {
            abandoned();
            return Err(interrupt);
        }
        match received {
            Ok(result) => return result.map_err(|panic| panicked(&*panic)),
            Err(mpsc::RecvTimeoutError::Timeout) => {}
            Err(mpsc::RecvTimeoutError::Disconnected) => return Err(panicked(&"")),
        }
    }
}

/// Runs `work` that cannot be stopped; Ctrl-C counts after it.
pub fn run_whole<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    run(py, &AtomicBool::new(false), |_| Ok(()), work)
}

/// Runs short `work` without the interpreter's lock, on the thread of the caller.
pub fn caught<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    check_process()?;
    let result = py.detach(|| catch_unwind(AssertUnwindSafe(work)));
    result.map_err(|panic| panicked(&*panic))
}

/// Returns the exception of a panic, which is an error in petzval.
fn panicked(panic: &(dyn Any + Send)) -> PyErr {
    let said = panic.downcast_ref::<String>().map(String::as_str);
    let said = said.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("");
    PyRuntimeError::new_err(format!("an error in petzval; please report it: {said}"))
}
