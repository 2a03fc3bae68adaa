//! State that the engine and the clients share: the settings, the last frame, and the state of the
//! panel.

use std::sync::atomic::Ordering;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use petzval::render::Progress;
use serde_json::{Map, Value};
use tungstenite::{Bytes, Utf8Bytes};

use super::frame::ViewFrame;
use super::settings::ViewSettings;

/// State of the view.
pub(super) struct ViewState {
    inner: Mutex<Shared>,
    changed: Condvar,
    /// The switch that stops the engine's work when the settings change.
    pub progress: Progress,
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
            focus: None,
        };
        Self { inner: Mutex::new(inner), changed: Condvar::new(), progress: Progress::default() }
    }

    fn lock(&self) -> MutexGuard<'_, Shared> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
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
        let message = Utf8Bytes::from(panel.to_string());
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
