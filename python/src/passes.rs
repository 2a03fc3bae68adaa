//! Pictures of a render while it goes on.

use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use petzval::{Picture, Progress};
use petzval_image::Note;
use petzval_render::ProgressiveRender;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use crate::image::Image;
use crate::job::Job;
use crate::worker;

/// How often the next picture is waited for before Ctrl-C counts.
const PULSE: Duration = Duration::from_millis(50);
/// Stack of the thread that renders.
const STACK: usize = 8 << 20;

/// Iterator over pictures of 1, 2, 4, 8 ... samples a pixel, up to those of the job.
#[pyclass(frozen, module = "petzval")]
pub struct Passes {
    job: Py<Job>,
    progress: Arc<Progress>,
    pictures: Mutex<Receiver<Result<(Picture, u32), String>>>,
}

impl Passes {
    /// Starts to render.
    pub fn new(job: Py<Job>, threads: usize) -> PyResult<Self> {
        worker::check_process()?;
        let shared = Arc::clone(&job.get().job);
        let progress = Arc::new(Progress::default());
        let (send, pictures) = sync_channel(1);
        let state = Arc::clone(&progress);
        let work = move || {
            let render = || -> Result<(), String> {
                let all = shared.samples.end - shared.samples.start;
                let failed = |error: petzval::RenderError| error.to_string();
                let mut render = ProgressiveRender::new(&shared, threads).map_err(failed)?;
                let mut next = 1;
                while render.samples() < all {
                    let end = next.min(all);
                    while render.samples() < end {
                        let step = end - render.samples();
                        render = render.step(step, &state).map_err(failed)?;
                    }
                    if send.send(Ok((render.picture(), end))).is_err() {
                        return Ok(());
                    }
                    next *= 2;
                }
                Ok(())
            };
            if let Err(problem) = render() {
                // Nobody may be left to hear it.
                let _ = send.send(Err(problem));
            }
        };
        std::thread::Builder::new().stack_size(STACK).spawn(work)?;
        Ok(Self { job, progress, pictures: Mutex::new(pictures) })
    }
}

impl Drop for Passes {
    fn drop(&mut self) {
        self.progress.stop.store(true, Ordering::Relaxed);
    }
}

#[pymethods]
impl Passes {
    fn __iter__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __next__(&self, py: Python<'_>) -> PyResult<Option<Image>> {
        loop {
            let received = py.detach(|| {
                let pictures = self.pictures.lock().unwrap_or_else(|poison| poison.into_inner());
                pictures.recv_timeout(PULSE)
            });
            py.check_signals()?;
            return match received {
                Ok(Ok((picture, samples))) => {
                    let note = ("samplesPerPixel", Note::Number(f64::from(samples)));
                    self.job.get().image(py, &picture, Vec::new(), vec![note]).map(Some)
                }
                Ok(Err(problem)) => Err(PyRuntimeError::new_err(problem)),
                Err(RecvTimeoutError::Timeout) => continue,
                Err(RecvTimeoutError::Disconnected) => Ok(None),
            };
        }
    }
}
