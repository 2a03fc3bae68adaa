//! Background work: what takes long beside the view, one piece at a time.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};

use serde_json::Value;

use super::state::ViewState;

/// Runs work on a thread of its own.
pub(super) struct Background {
    state: Arc<ViewState>,
    running: Arc<Mutex<Option<Running>>>,
}

/// Work in progress.
struct Running {
    stop: Box<dyn Fn() + Send>,
    /// Whether the work is done. Only its last message may still be on its way.
    done: Arc<AtomicBool>,
    thread: JoinHandle<()>,
}

fn lock(running: &Mutex<Option<Running>>) -> MutexGuard<'_, Option<Running>> {
    running.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Background {
    /// Creates one without work, whose clients are those of a view.
    pub fn new(state: Arc<ViewState>) -> Self {
        Self { state, running: Arc::default() }
    }

    fn running(&self) -> MutexGuard<'_, Option<Running>> {
        lock(&self.running)
    }

    /// Starts work; `stop` asks it to end. The clients receive the message that it returns when the
    /// next work can be started.
    ///
    /// # Errors
    /// Returns a message if other work is in progress, or a thread cannot be started.
    pub fn start(
        &self,
        stop: impl Fn() + Send + 'static,
        work: impl FnOnce() -> Value + Send + 'static,
    ) -> Result<(), String> {
        let mut running = self.running();
        // The thread of work that panics is finished without being done.
        let is_over = |running: &Running| {
            running.done.load(Ordering::Relaxed) || running.thread.is_finished()
        };
        if running.as_ref().is_some_and(|running| !is_over(running)) {
            return Err("a picture is being rendered or measured; cancel it first".to_owned());
        }
        let done = Arc::new(AtomicBool::new(false));
        let (state, all, ended) = (self.state.clone(), self.running.clone(), done.clone());
        let thread = thread::Builder::new().spawn(move || {
            let last = work();
            // Nobody can start work between the two, so that messages keep their order.
            let _running = lock(&all);
            ended.store(true, Ordering::Relaxed);
            state.publish_work(&last);
        });
        let thread = thread.map_err(|error| error.to_string())?;
        *running = Some(Running { stop: Box::new(stop), done, thread });
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
