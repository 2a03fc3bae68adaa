//! Engine: renders the settings of the view, first as a draft, then refined sample by sample.
//!
//! The scene and its hierarchy are read once. A change of the settings ends the work in progress
//! within a wave of rays. Drafts then follow the changes, at a resolution that takes a fixed time,
//! until the picture itself is prepared with its plan.

use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use petzval_base::io::ByteSize;
use petzval_render::film::Frame;
use petzval_render::job::Job;
use petzval_render::plan::Plan;
use petzval_render::prepare::{Changes, Prepared, prepare_draft};
use petzval_render::{ProgressiveRender, RenderError};
use petzval_scene_formats::pbrt::Description;

use super::blur_map::{blur_map, reduced};
use super::frame::ViewFrame;
use super::lens_bench::LensBench;
use super::panel::{Panel, PreparedAs};
use super::preparer::{PrepareStatus, Preparer};
use super::settings::ViewSettings;
use super::state::ViewState;
use crate::cli::Failure;
use crate::cli::memory::Memory;

/// Time that the first sample of a draft should take.
const DRAFT_TIME: Duration = Duration::from_millis(40);
/// Shortest longer side of a draft (pixels).
const MIN_DRAFT_SIDE: f64 = 96.0;
/// Time from a change of the settings to the preparation of the picture, so that drafts follow a hand
/// without it.
const REST: Duration = Duration::from_millis(120);
/// Samples of a draft after which it only waits for the picture.
const DRAFT_SAMPLES: u32 = 64;
/// Time of a sample on one thread before any was taken (s).
const FIRST_GUESS: f64 = 2e-6;
/// Largest number of samples between two frames.
const MAX_STEP: u32 = 64;
/// Time between looks at whether the settings have changed, while there is nothing to render.
const LOOK: Duration = Duration::from_millis(5);

/// Renders what the clients look at.
pub(super) struct Engine {
    description: Description,
    threads: usize,
    /// The limit that the user gives.
    memory: Option<ByteSize>,
    pub state: Arc<ViewState>,
}

impl Engine {
    /// Creates the engine of a scene.
    pub fn new(
        description: Description,
        settings: ViewSettings,
        threads: usize,
        memory: Option<ByteSize>,
    ) -> Result<Self, Failure> {
        settings.changes()?;
        Ok(Self { description, threads, memory, state: Arc::new(ViewState::new(settings)) })
    }

    /// Renders until the state is stopped.
    pub fn run(&self) {
        thread::scope(|scope| {
            let preparer = Preparer::start(scope, self.description.clone());
            let guess = FIRST_GUESS / self.threads as f64;
            let mut work = EngineWork {
                engine: self,
                memory: Memory::new(self.memory),
                preparer,
                panel: Panel::new(&self.description),
                plan: None,
                draft: None,
                sample_time: guess,
                generation: 0,
            };
            while let Some((generation, settings)) = self.state.next_settings(work.generation) {
                work.generation = generation;
                if let Err(problem) = work.show(&settings) {
                    let panel = work.panel.failed(generation, &settings, &problem);
                    self.state.publish_panel(generation, panel, None);
                }
            }
        });
    }
}

/// The work of an engine.
struct EngineWork<'a> {
    engine: &'a Engine,
    memory: Memory,
    preparer: Preparer,
    panel: Panel,
    /// The plan of the last picture.
    plan: Option<Plan>,
    /// The last draft, and its settings.
    draft: Option<(ViewSettings, Job)>,
    /// The time of a sample (s), on all threads together.
    sample_time: f64,
    /// The settings that it works for.
    generation: u64,
}

impl EngineWork<'_> {
    /// Shows a picture of the settings until it is finished or they change.
    fn show(&mut self, settings: &ViewSettings) -> Result<(), String> {
        let changes = settings.changes()?;
        let prepared = match self.draft(settings, &changes) {
            Some(draft) => self.show_draft(&draft, &changes)?,
            None => {
                self.preparer.order(self.generation, changes.clone());
                self.wait()?
            }
        };
        match prepared {
            Some(prepared) => self.show_picture(settings, &changes, prepared),
            None => Ok(()),
        }
    }

    /// Returns a draft of the settings, or `None` if they show none: the picture itself has the same
    /// error, with its message.
    fn draft(&mut self, settings: &ViewSettings, changes: &Changes) -> Option<Job> {
        let moved = self.draft.take().and_then(|(of, mut job)| {
            let still = job.timing.as_ref().is_none_or(|timing| timing.camera_motion.is_none());
            let viewpoint = changes.viewpoint.filter(|_| still && settings.differs_in_view(&of))?;
            job.camera.world_from_camera =
                viewpoint.world_from_camera(&job.camera.world_from_camera);
            Some(job)
        });
        let prepare = || {
            let description = self.engine.description.clone();
            prepare_draft(description, changes, self.plan.as_ref()).ok()
        };
        let job = match moved {
            Some(job) => job,
            None => {
                let prepared = prepare()?;
                self.show_camera(settings, changes, &prepared, PreparedAs::Draft);
                prepared.job
            }
        };
        self.draft = Some((settings.clone(), job.clone()));
        Some(job)
    }

    /// Shows the camera of a draft or a picture: first its lens, for which a page asks when it has the
    /// state of the panel.
    fn show_camera(
        &mut self,
        settings: &ViewSettings,
        changes: &Changes,
        prepared: &Prepared,
        purpose: PreparedAs,
    ) {
        let state = &self.engine.state;
        state.set_bench(LensBench::new(&prepared.job));
        let panel = self.panel.update(self.generation, settings, changes, prepared, purpose);
        state.publish_panel(self.generation, &panel, self.panel.focus());
    }

    /// Returns the picture once it is prepared, or `None` if the settings have changed.
    fn wait(&self) -> Result<Option<Box<Prepared>>, String> {
        while !self.engine.state.is_outdated() {
            if let Some(prepared) = self.prepared(LOOK)? {
                return Ok(Some(prepared));
            }
        }
        Ok(None)
    }

    fn prepared(&self, most: Duration) -> Result<Option<Box<Prepared>>, String> {
        match self.preparer.result(self.generation, most) {
            PrepareStatus::Ready(Ok(prepared)) => Ok(Some(prepared)),
            PrepareStatus::Ready(Err(error)) => Err(error.to_string()),
            PrepareStatus::Working => Ok(None),
            PrepareStatus::Ended => Err("the preparation of the picture has ended".to_owned()),
        }
    }

    /// Refines a draft until the picture is prepared, and returns the picture.
    fn show_draft(
        &mut self,
        job: &Job,
        changes: &Changes,
    ) -> Result<Option<Box<Prepared>>, String> {
        let start = Instant::now();
        // The first picture waits for no hand.
        let mut ordered = self.plan.is_none();
        if ordered {
            self.preparer.order(self.generation, changes.clone());
        }
        let mut job = job.clone();
        job.frame = self.draft_frame(&job.frame);
        let threads = self.engine.threads;
        let mut draft = ProgressiveRender::new(&job, threads).map_err(|e| e.to_string())?;
        while draft.samples() < DRAFT_SAMPLES {
            let step = 1 + draft.samples() / 4;
            let Some(refined) = self.step(draft, step, &job)? else { return Ok(None) };
            draft = refined;
            self.publish(&draft, DRAFT_SAMPLES, true);
            if !ordered && start.elapsed() >= REST {
                self.preparer.order(self.generation, changes.clone());
                ordered = true;
            }
            if let Some(prepared) = self.prepared(Duration::ZERO)? {
                return Ok(Some(prepared));
            }
        }
        if !ordered {
            self.preparer.order(self.generation, changes.clone());
        }
        self.wait()
    }

    /// Refines the picture until it has all its samples.
    fn show_picture(
        &mut self,
        settings: &ViewSettings,
        changes: &Changes,
        prepared: Box<Prepared>,
    ) -> Result<(), String> {
        let generation = self.generation;
        self.show_camera(settings, changes, &prepared, PreparedAs::Picture);
        let Prepared { mut job, .. } = *prepared;
        self.plan = Some(job.plan.clone());
        job.layers.clear();
        let threads = self.engine.threads;
        let fits = self.memory.check_shown(&job, threads, ViewFrame::BYTES_PER_PIXEL);
        fits.map_err(|failure| failure.to_string())?;
        let blur = blur_map(&job, generation, self.engine.threads, &self.engine.state.progress);
        self.engine.state.publish_blur(blur.unwrap_or_default());
        let target = job.samples.len() as u32;
        let mut picture = ProgressiveRender::new(&job, threads).map_err(|e| e.to_string())?;
        while picture.samples() < target {
            while self.engine.state.is_paused() {
                thread::sleep(LOOK);
            }
            let step = (picture.samples() / 4).clamp(1, MAX_STEP);
            let step = step.min(target - picture.samples());
            let Some(refined) = self.step(picture, step, &job)? else { return Ok(()) };
            picture = refined;
            self.publish(&picture, target, false);
        }
        Ok(())
    }

    /// Returns a frame of the same picture with so many pixels that a sample of each takes a fixed
    /// time.
    fn draft_frame(&self, frame: &Frame) -> Frame {
        let [width, height] = frame.size().map(f64::from);
        let shortest = MIN_DRAFT_SIDE * MIN_DRAFT_SIDE * width.min(height) / width.max(height);
        reduced(frame, (DRAFT_TIME.as_secs_f64() / self.sample_time).max(shortest))
    }

    /// Takes samples, or returns `None` if the settings have changed.
    fn step<'j>(
        &mut self,
        render: ProgressiveRender<'j>,
        count: u32,
        job: &Job,
    ) -> Result<Option<ProgressiveRender<'j>>, String> {
        let (start, before) = (Instant::now(), render.samples());
        match render.step(count, &self.engine.state.progress) {
            Ok(render) => {
                let pixels: f64 = job.frame.size().map(f64::from).iter().product();
                let samples = pixels * f64::from(render.samples() - before);
                let time = start.elapsed().as_secs_f64() / samples;
                self.sample_time = 0.5 * (self.sample_time + time);
                Ok(Some(render))
            }
            Err(RenderError::Stopped) => Ok(None),
            Err(error) => Err(error.to_string()),
        }
    }

    fn publish(&self, render: &ProgressiveRender<'_>, target: u32, draft: bool) {
        let samples = render.samples();
        self.engine.state.publish_frame(ViewFrame {
            generation: self.generation,
            picture: render.picture(),
            samples,
            target,
            draft,
            finished: !draft && samples >= target,
        });
    }
}
