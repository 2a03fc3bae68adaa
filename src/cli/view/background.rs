//! Background work: what takes long beside the view, one piece at a time.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};

/// Runs work on a thread of its own.
#[derive(Default)]
pub(super) struct Background {
    running: Mutex<Option<Running>>,
}

/// Work in progress.
struct Running {
    stop: Box<dyn Fn() + Send>,
    thread: JoinHandle<()>,
}

impl Background {
    fn running(&self) -> MutexGuard<'_, Option<Running>> {
        self.running.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Starts work; `stop` asks it to end.
    ///
    /// # Errors
    /// Returns a message if other work is in progress, or a thread cannot be started.
    pub fn start(
        &self,
        stop: impl Fn() + Send + 'static,
        work: impl FnOnce() + Send + 'static,
    ) -> Result<(), String> {
        let mut running = self.running();
        if running.as_ref().is_some_and(|running| !running.thread.is_finished()) {
            return Err("a picture is being rendered or measured; cancel it first".to_owned());
        }
        let thread = thread::Builder::new().spawn(work).map_err(|error| error.to_string())?;
        *running = Some(Running { stop: Box::new(stop), thread });
        Ok(())
    }

    /// Asks the work in progress to end.
    pub fn cancel(&self) {
        if let Some(Running { stop, .. }) = &*self.running() {
            stop();
        }
    }

    /// Ends the work in progress and waits for its files.
    pub fn end(&self) {
        self.cancel();
        let running = self.running().take();
        if let Some(Running { thread, .. }) = running {
            // A panic has been reported.
            let _ = thread.join();
        }
    }
}
