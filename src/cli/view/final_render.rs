//! Final render: the picture of the settings as `petzval render` makes it, with checkpoints, beside
//! the view.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

use petzval_render::Progress;
use petzval_scene_formats::pbrt::Description;
use serde_json::{Value, json};

use super::background::Background;
use super::file_name::new_file;
use super::settings::ViewSettings;
use super::state::ViewState;
use crate::cli::arguments::argv::parse_render;
use crate::cli::memory::Memory;
use crate::cli::progress::film_samples;
use crate::cli::render::{RenderTask, checkpoint_name, partial_name};
use crate::cli::{Failure, Outcome};

/// Time between two reports of the progress.
const INTERVAL: Duration = Duration::from_millis(250);

/// Renders pictures into the current folder.
pub(super) struct FinalRender {
    pub description: Description,
    pub state: Arc<ViewState>,
    pub background: Arc<Background>,
}

impl FinalRender {
    /// Starts the render of these settings into a new file. A checkpoint of that name is resumed. A
    /// render that is stopped writes a checkpoint.
    ///
    /// # Errors
    /// Returns a message if the name is refused or taken, or if other work is in progress.
    pub fn start(&self, name: &str, settings: &ViewSettings) -> Result<(), String> {
        let file = new_file(Path::new(""), name, &["exr", "png", "jpg", "tif", "dng"])?;
        let partial = partial_name(&file);
        if partial.symlink_metadata().is_ok() && !checkpoint_name(&file).exists() {
            let partial = partial.display();
            return Err(format!("{partial} exists already; choose another name"));
        }
        let mut argv = settings.argv();
        argv.push(format!("--output={}", file.display()));
        let progress = Arc::new(Progress::default());
        let (description, state) = (self.description.clone(), self.state.clone());
        let stopped = progress.clone();
        self.background.start(
            move || stopped.stop.store(true, Ordering::Relaxed),
            move || run(description, argv, &file, &progress, &state),
        )
    }
}

/// Renders, and tells the clients about it. Returns the last message.
fn run(
    description: Description,
    argv: Vec<String>,
    file: &Path,
    progress: &Arc<Progress>,
    state: &ViewState,
) -> Value {
    let start = Instant::now();
    let message = |status: &str, more: Value| {
        let mut message = json!({
            "type": "render",
            "file": file.display().to_string(),
            "status": status,
            "seconds": start.elapsed().as_secs_f64(),
        });
        if let (Some(message), Value::Object(more)) = (message.as_object_mut(), more) {
            message.extend(more);
        }
        message
    };
    let tell = |status: &str, more: Value| state.publish_work(&message(status, more));
    tell("preparing", Value::Null);
    match render(description, argv, file, progress, &tell) {
        Ok(Outcome::Interrupted) => {
            let checkpoint = checkpoint_name(file);
            message("cancelled", json!({ "checkpoint": checkpoint.display().to_string() }))
        }
        Ok(_) => message("finished", Value::Null),
        Err(failure) => message("failed", json!({ "problem": failure.to_string() })),
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
    let (task, _) = RenderTask::new(&arguments, argv, description, None, &memory, Instant::now())?;
    // A file that appears while it renders is another's.
    let task = task.only_new();
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
        Ok(task.run(progress, None, None)?.outcome)
    })
}
