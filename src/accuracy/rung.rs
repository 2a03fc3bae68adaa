//! The rungs of the ladder: one picture, photographed by one camera model after another.

use super::watch::Watch;
use crate::ghosts::Ghosts;
use crate::job::{Changes, JobError, prepare};
use crate::lanes::f32x8;
use crate::lens::{Camera, Fidelity, FilmError, Model, film_error};
use crate::plan::{Effect, Plan, Wanted};
use crate::rays::NONE;
use crate::render::{Job, RenderError, Until};
use crate::scene::TraversalStack;
use crate::scene::pbrt::Description;
use crate::source::{Files, Warning};

/// Effects of glass: what cruder models do not know, and rungs leave out one by one. Others are of
/// the scene, and the same for all.
const EFFECTS: [Effect; 3] = [Effect::Dispersion, Effect::Fresnel, Effect::Ghosts];

/// What is left out of all rungs, as it is done with the finished picture and is the same for all.
const AFTERWARDS: [Effect; 2] = [Effect::Diffraction, Effect::Sensor];

/// Pixels of a report: some 1300 bytes each.
const MOST_PIXELS: u64 = 1 << 20;

/// One way to photograph the scene.
#[derive(Clone, Debug)]
pub struct Rung {
    /// A short name, for tables and files.
    pub name: String,
    /// What it is, and what it leaves out.
    pub sentence: String,
    /// How exactly its lens is simulated.
    pub fidelity: Fidelity,
    /// What it has and the measure of all others has not: no error, but a change.
    pub adds: Option<Effect>,
    /// How far off its rays are, on film.
    pub film: FilmError,
    pub(super) view: View,
}

/// What rungs differ by in a job.
#[derive(Clone, Debug)]
pub(super) struct View {
    camera: Camera,
    plan: Plan,
    ghosts: Option<Ghosts>,
}

impl View {
    fn of(job: &Job) -> Self {
        Self { camera: job.camera.clone(), plan: job.plan.clone(), ghosts: job.ghosts.clone() }
    }

    fn simulated(&self, fidelity: Fidelity) -> Self {
        Self { camera: self.camera.simulated(fidelity), ..self.clone() }
    }

    /// Puts it into a job, and what was there into it.
    pub fn swap(&mut self, job: &mut Job) {
        std::mem::swap(&mut self.camera, &mut job.camera);
        std::mem::swap(&mut self.plan, &mut job.plan);
        std::mem::swap(&mut self.ghosts, &mut job.ghosts);
    }
}

/// A scene, and the ways to photograph it.
#[derive(Debug)]
pub struct Ladder {
    /// The job of which rungs change the camera; its own is the plain one.
    pub(super) job: Job,
    /// From the crudest to the richest: every surface in f64, with all effects of the plan.
    pub rungs: Vec<Rung>,
    /// Name of the lens.
    pub lens: String,
    /// Effects that no rung is told apart by, and why.
    pub aside: Vec<(Effect, &'static str)>,
    /// What was noticed on the way.
    pub warnings: Vec<Warning>,
}

impl Ladder {
    /// The ladder of a scene:
    ///
    /// 1. The cruder models, from the pinhole to the polynomial, without effects of glass.
    /// 2. "real f32 alone": every surface, without these effects, where the plan has one.
    /// 3. "real f32 - effect": without this one, where the plan has others too. Effects are left
    ///    out one by one, and not added one to the other, because that is the choice that a user
    ///    has, and tells what each is worth beside all others.
    /// 4. "real f32": what a render does.
    /// 5. "real f32 + effect": with one that the plan leaves out, to see that it may.
    /// 6. "real f64".
    ///
    /// # Errors
    /// Where the scene cannot be photographed as asked, or its camera has no lens of glass; and
    /// [`RenderError::Stopped`] where the watch was.
    pub fn new(
        description: &Description,
        changes: &Changes,
        watch: &Watch,
    ) -> Result<Self, JobError> {
        let (mut job, _, warnings) = prepare(description.clone(), changes)?;
        let [width, height] = job.frame.size();
        if u64::from(width) * u64::from(height) > MOST_PIXELS {
            return Err(JobError::Asked(format!(
                "{width} x {height} pixels for every rung would take too much memory and time; \
                 make it {MOST_PIXELS} at most with --resolution or --crop"
            )));
        }
        let Model::Real(lens) = &job.camera.model else {
            return Err(JobError::Camera {
                at: description.camera_at.clone(),
                problem: "this camera has no lens file, so there are no models of a lens to \
                          compare"
                    .to_owned(),
            });
        };
        let lens = lens.prescription.name.clone();
        let mut aside: Vec<(Effect, &str)> = Effect::ALL
            .into_iter()
            .filter(|effect| !EFFECTS.contains(effect))
            .map(|effect| match (AFTERWARDS.contains(&effect), job.plan.has(effect)) {
                (true, true) => (effect, "planned, but done with the finished picture"),
                (true, false) => (effect, "done with the finished picture"),
                (false, true) => (effect, "in all models alike"),
                (false, false) => (effect, "in none: the plan leaves it out"),
            })
            .collect();
        let plan = job.plan.clone();
        let with = |given: &[(Effect, bool)]| -> Result<View, JobError> {
            let decided = |effect| given.iter().find(|(other, _)| *other == effect);
            let one = |effect| (effect, decided(effect).map_or(plan.has(effect), |(_, on)| *on));
            if watch.stopped() {
                return Err(RenderError::Stopped.into());
            }
            let effects = Wanted::But(Effect::ALL.map(one).to_vec());
            let changes = Changes { effects, ..changes.clone() };
            Ok(View::of(&prepare(description.clone(), &changes)?.0))
        };
        let [on, off]: [Vec<Effect>; 2] =
            [true, false].map(|on| EFFECTS.into_iter().filter(|&e| plan.has(e) == on).collect());
        let full = View::of(&job);
        let bare = match on.is_empty() {
            true => full.clone(),
            false => with(&EFFECTS.map(|effect| (effect, false)))?,
        };

        let mut rungs = Vec::new();
        let mut add = |name: String, sentence: String, fidelity, adds, view| {
            let film = FilmError::default();
            rungs.push(Rung { name, sentence, fidelity, adds, film, view });
        };
        for fidelity in Fidelity::ALL {
            if fidelity < Fidelity::Single {
                let sentence = fidelity.sentence().to_owned();
                add(fidelity.name().to_owned(), sentence, fidelity, None, bare.simulated(fidelity));
            }
        }
        let single = |of: &str| format!("{REAL}{of}");
        let sentence = |of: &str| format!("Every surface traced in f32, {of}.");
        if !on.is_empty() {
            add(single(" alone"), sentence("without effects"), Fidelity::Single, None, bare);
        }
        if on.len() > 1 {
            for &effect in &on {
                let name = effect.name();
                let view = with(&[(effect, false)])?;
                let sentence = sentence(&format!("without {name}"));
                add(single(&format!(" - {name}")), sentence, Fidelity::Single, None, view);
            }
        }
        let double = full.simulated(Fidelity::Double);
        add(single(""), sentence("as a render does"), Fidelity::Single, None, full);
        for effect in off {
            let view = with(&[(effect, true)])?;
            if view.plan.has(effect) {
                let name = effect.name();
                let sentence = sentence(&format!("with {name}, which the plan leaves out"));
                add(single(&format!(" + {name}")), sentence, Fidelity::Single, Some(effect), view);
            } else {
                aside.push((effect, "cannot be had in this scene"));
            }
        }
        let best = "Every surface traced in f64, with all effects of the plan.".to_owned();
        add("real f64".to_owned(), best, Fidelity::Double, None, double);

        job.layers.clear();
        job.sensor = None;
        job.until = Until::default();
        let mut ladder = Self { job, rungs, lens, aside, warnings };
        ladder.judge_film();
        Ok(ladder)
    }

    /// How far off the rays of every rung are.
    fn judge_film(&mut self) {
        let Self { job, rungs, .. } = self;
        let Some(best) = rungs.last().map(|rung| rung.view.camera.clone()) else { return };
        let time = job.timing.as_ref().map_or(0.0, |timing| timing.middle() as f32);
        let mut stack = TraversalStack::default();
        for rung in rungs {
            rung.film = film_error(&rung.view.camera, &best, |ray| {
                let hit = job.scene.closest_at::<f32x8>(ray, time, &mut stack);
                let length = ray.direction.iter().map(|v| v * v).sum::<f32>().sqrt();
                if hit.shape == NONE { f64::INFINITY } else { f64::from(hit.t * length) }
            });
        }
    }

    /// The place of the rung that a render takes.
    pub fn usual(&self) -> Option<usize> {
        self.rungs.iter().position(|rung| rung.name == REAL)
    }

    /// The files that the scene was read from.
    pub fn files(&self) -> &Files {
        &self.job.files
    }

    /// Width and height of the part that is rendered, pixels.
    pub fn size(&self) -> [u32; 2] {
        self.job.frame.size()
    }

    /// Width of a pixel on the film, um.
    pub fn pitch(&self) -> f64 {
        1e3 * self.job.camera.film[0] / f64::from(self.job.frame.resolution[0])
    }
}

/// The rung that a render takes.
const REAL: &str = "real f32";
