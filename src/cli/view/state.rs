//! State that the engine and the clients share: the settings, the last frame, and the state of the
//! panel.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use petzval_render::Progress;
use serde_json::{Map, Value};
use tungstenite::{Bytes, Utf8Bytes};

use super::frame::ViewFrame;
use super::lens_bench::LensBench;
use super::settings::ViewSettings;
use crate::cli::option_names::with_option_names;

/// State of the view.
pub(super) struct ViewState {
    inner: Mutex<Shared>,
    changed: Condvar,
    /// The switch that stops the engine's work when the settings change.
    pub progress: Progress,
    /// Whether pictures are not refined, so that a measurement has the machine for itself. Drafts
    /// follow the hand all the same.
    pub refining_paused: AtomicBool,
}

/// The parts behind the lock.
pub(super) struct Shared {
    pub settings: ViewSettings,
    /// The number of the settings; each change adds one.
    pub generation: u64,
    pub stopped: bool,
    frame: Option<Arc<ViewFrame>>,
    /// The message of the frame, and the number of frames so far.
    pub frame_message: (u64, Bytes),
    /// The message of the panel, and the number of such messages so far.
    pub panel_message: (u64, Utf8Bytes),
    /// The message of the blur map, empty without one, and the number of such messages so far.
    pub blur_message: (u64, Bytes),
    /// The message of the background work, empty before the first one, and the number of such messages
    /// so far.
    pub work_message: (u64, Utf8Bytes),
    /// The camera of the last picture or draft.
    bench: Option<Arc<LensBench>>,
    /// The distance in focus of a generation (m).
    focus: Option<(u64, f64)>,
}

impl ViewState {
    /// Returns the state before the first frame.
    pub fn new(settings: ViewSettings) -> Self {
        let inner = Shared {
            settings,
            generation: 1,
            stopped: false,
            frame: None,
            frame_message: (0, Bytes::new()),
            panel_message: (0, Utf8Bytes::default()),
            blur_message: (0, Bytes::new()),
            work_message: (0, Utf8Bytes::default()),
            bench: None,
            focus: None,
        };
        let (progress, refining_paused) = Default::default();
        Self { inner: Mutex::new(inner), changed: Condvar::new(), progress, refining_paused }
    }

    fn lock(&self) -> MutexGuard<'_, Shared> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns whether the view has ended.
    pub fn is_stopped(&self) -> bool {
        self.lock().stopped
    }

    /// Changes the settings and stops the work for the old ones. Returns the new generation.
    pub fn set(&self, changes: &Map<String, Value>) -> Result<u64, String> {
        let mut shared = self.lock();
        let mut settings = shared.settings.clone();
        // The focus that a click has found stays when the camera moves.
        let pixel = settings.value("focus").is_some_and(|focus| focus.starts_with("auto"));
        if let (true, Some((generation, focus))) = (pixel, shared.focus)
            && generation == shared.generation
        {
            settings.put("focus", Some(format!("{focus}")));
        }
        settings.set(changes)?;
        shared.settings = settings;
        shared.generation += 1;
        self.progress.stop.store(true, Ordering::Relaxed);
        self.changed.notify_all();
        Ok(shared.generation)
    }

    /// Ends the engine and all clients.
    pub fn stop(&self) {
        self.lock().stopped = true;
        self.progress.stop.store(true, Ordering::Relaxed);
        self.changed.notify_all();
    }

    /// Waits for settings newer than a generation. `None` ends the engine.
    pub fn next_settings(&self, seen: u64) -> Option<(u64, ViewSettings)> {
        let mut shared = self.lock();
        while shared.generation == seen && !shared.stopped {
            shared = self.changed.wait(shared).unwrap_or_else(PoisonError::into_inner);
        }
        if shared.stopped {
            return None;
        }
        self.progress.stop.store(false, Ordering::Relaxed);
        Some((shared.generation, shared.settings.clone()))
    }

    /// Returns whether the settings have changed since the engine began to work for them.
    pub fn is_outdated(&self) -> bool {
        self.progress.stop.load(Ordering::Relaxed)
    }

    /// Returns whether pictures are not to be refined now.
    pub fn is_paused(&self) -> bool {
        self.refining_paused.load(Ordering::Relaxed) && !self.is_outdated()
    }

    /// Shows a frame.
    pub fn publish_frame(&self, frame: ViewFrame) {
        let message = Bytes::from(frame.message());
        let mut shared = self.lock();
        shared.frame_message = (shared.frame_message.0 + 1, message);
        shared.frame = Some(Arc::new(frame));
        self.changed.notify_all();
    }

    /// Shows the state of the panel, whose camera is focused at this distance (m).
    pub fn publish_panel(&self, generation: u64, panel: &Value, focus: Option<f64>) {
        let message = Utf8Bytes::from(&*with_option_names(&panel.to_string()));
        let mut shared = self.lock();
        shared.panel_message = (shared.panel_message.0 + 1, message);
        shared.focus = focus.filter(|focus| focus.is_finite()).map(|focus| (generation, focus));
        self.changed.notify_all();
    }

    /// Shows the blur map of a picture.
    pub fn publish_blur(&self, message: Vec<u8>) {
        let mut shared = self.lock();
        shared.blur_message = (shared.blur_message.0 + 1, Bytes::from(message));
        self.changed.notify_all();
    }

    /// Tells the clients about background work.
    pub fn publish_work(&self, message: &Value) {
        let message = Utf8Bytes::from(&*with_option_names(&message.to_string()));
        let mut shared = self.lock();
        shared.work_message = (shared.work_message.0 + 1, message);
        self.changed.notify_all();
    }

    /// Returns the settings, and the distance in focus (m) if the last picture shows them.
    pub fn settings(&self) -> (ViewSettings, Option<f64>) {
        let shared = self.lock();
        let focus = shared.focus.filter(|(generation, _)| *generation == shared.generation);
        (shared.settings.clone(), focus.map(|(_, focus)| focus))
    }

    /// Sets the camera of the last picture or draft.
    pub fn set_bench(&self, bench: LensBench) {
        self.lock().bench = Some(Arc::new(bench));
    }

    /// Returns the camera of the last picture or draft.
    pub fn bench(&self) -> Option<Arc<LensBench>> {
        self.lock().bench.clone()
    }

    /// Returns the last frame.
    pub fn frame(&self) -> Option<Arc<ViewFrame>> {
        self.lock().frame.clone()
    }

    /// Wakes the clients, after something of their own has changed.
    pub fn notify(&self) {
        let _shared = self.lock();
        self.changed.notify_all();
    }

    /// Waits, for a time at most, until there is news for a client, and returns it.
    pub fn wait<T>(&self, most: Duration, mut news: impl FnMut(&Shared) -> Option<T>) -> Option<T> {
        let mut shared = self.lock();
        let start = std::time::Instant::now();
        loop {
            if let Some(found) = news(&shared) {
                return Some(found);
            }
            let left = most.checked_sub(start.elapsed())?;
            let waited = self.changed.wait_timeout(shared, left);
            shared = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }
}
