//! Final render: the picture of the settings as `petzval render` makes it, with checkpoints, beside
//! the view.

use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use petzval::render::Progress;
use petzval::scene::pbrt::Description;
use serde_json::{Value, json};

use super::file_name::new_file;
use super::settings::ViewSettings;
use super::state::ViewState;
use crate::cli::arguments::argv::parse_render;
use crate::cli::memory::Memory;
use crate::cli::progress::film_samples;
use crate::cli::render::{RenderTask, checkpoint_name};
use crate::cli::{Failure, Outcome};

/// Time between two reports of the progress.
const INTERVAL: Duration = Duration::from_millis(250);

/// Renders one picture at a time into the current folder.
pub(super) struct FinalRender {
    description: Description,
    state: Arc<ViewState>,
    running: Mutex<Option<Running>>,
}

/// A render in progress.
struct Running {
    progress: Arc<Progress>,
    thread: JoinHandle<()>,
}

impl FinalRender {
    pub fn new(description: Description, state: Arc<ViewState>) -> Self {
        Self { description, state, running: Mutex::new(None) }
    }

    /// Starts the render of these settings into a new file. A checkpoint of that name is resumed.
    ///
    /// # Errors
    /// Returns a message if the name is refused or taken, or if a render is in progress.
    pub fn start(&self, name: &str, settings: &ViewSettings) -> Result<(), String> {
        let mut running = self.running.lock().unwrap_or_else(PoisonError::into_inner);
        if running.as_ref().is_some_and(|running| !running.thread.is_finished()) {
            return Err("a picture is being rendered; cancel it first".to_owned());
        }
        let file = new_file(Path::new(""), name, &["exr", "png", "jpg"])?;
        let mut argv = settings.argv();
        argv.push(format!("--output={}", file.display()));
        let progress = Arc::new(Progress::default());
        let (description, state) = (self.description.clone(), self.state.clone());
        let shared = progress.clone();
        let work = move || run(description, argv, &file, &shared, &state);
        let thread = thread::Builder::new().spawn(work).map_err(|error| error.to_string())?;
        *running = Some(Running { progress, thread });
        Ok(())
    }

    /// Stops the render in progress. It writes a checkpoint.
    pub fn cancel(&self) {
        let running = self.running.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(Running { progress, .. }) = &*running {
            progress.stop.store(true, Ordering::Relaxed);
        }
    }

    /// Stops the render in progress and waits for its files.
    pub fn end(&self) {
        self.cancel();
        let running = self.running.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(Running { thread, .. }) = running {
            // A panic has been reported.
            let _ = thread.join();
        }
    }
}

/// Renders, and tells the clients about it.
fn run(
    description: Description,
    argv: Vec<String>,
    file: &Path,
    progress: &Arc<Progress>,
    state: &ViewState,
) {
    let start = Instant::now();
    let tell = |status: &str, more: Value| {
        let mut message = json!({
            "type": "render",
            "file": file.display().to_string(),
            "status": status,
            "seconds": start.elapsed().as_secs_f64(),
        });
        if let (Some(message), Value::Object(more)) = (message.as_object_mut(), more) {
            message.extend(more);
        }
        state.publish_render(&message);
    };
    tell("preparing", Value::Null);
    let result = render(description, argv, file, progress, &tell);
    let partial: PathBuf = checkpoint_name(file);
    match result {
        Ok(Outcome::Interrupted) => {
            tell("cancelled", json!({ "checkpoint": partial.display().to_string() }));
        }
        Ok(_) => tell("finished", Value::Null),
        Err(failure) => tell("failed", json!({ "problem": failure.to_string() })),
    }
}

fn render(
    description: Description,
    argv: Vec<String>,
    file: &Path,
    progress: &Arc<Progress>,
    tell: &(impl Fn(&str, Value) + Sync),
) -> Result<Outcome, Failure> {
    let mut arguments = parse_render(&argv)?;
    arguments.resume = checkpoint_name(file).exists();
    let memory = Memory::new(arguments.memory);
    let (task, _) = RenderTask::new(&arguments, argv, description, &memory, Instant::now())?;
    let all = film_samples(&task.job);
    let (ended, end) = channel::<()>();
    thread::scope(|scope| {
        // It ends when this one is dropped.
        let _ended = ended;
        scope.spawn(move || {
            while end.recv_timeout(INTERVAL) == Err(RecvTimeoutError::Timeout) {
                let expected = progress.expected.load(Ordering::Relaxed);
                let total = if expected > 0 { expected } else { all };
                let done = progress.samples.load(Ordering::Relaxed);
                tell("running", json!({ "share": done as f64 / total.max(1) as f64 }));
            }
        });
        Ok(task.run(progress, None)?.outcome)
    })
}
