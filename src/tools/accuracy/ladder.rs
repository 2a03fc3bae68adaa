//! The ladder of camera models that photograph one scene, from the crudest to the richest.

use std::sync::Arc;

use super::monitor::RunMonitor;
use petzval_base::io::{FileLog, Warning};
use petzval_base::lanes::f32x8;
use petzval_base::rays::NO_INDEX;
use petzval_lens::{Camera, Fidelity, LensModel};
use petzval_optics::{FilmError, film_error};
use petzval_render::RenderError;
use petzval_render::film::Response;
use petzval_render::job::{Job, StopCriteria};
use petzval_render::light_tracing::ghosts::Ghosts;
use petzval_render::plan::{Effect, EffectSelection, Plan};
use petzval_render::prepare::{Changes, PrepareError, Prepared, prepare};
use petzval_scene::{SpectralScene, TraversalStack};
use petzval_scene_formats::pbrt::Description;

/// Effects of glass, which cruder models lack.
const GLASS_EFFECTS: [Effect; 3] = [Effect::Dispersion, Effect::Fresnel, Effect::Ghosts];

/// Effects that rungs leave out in turn.
const COMPARED: [Effect; 4] =
    [Effect::Dispersion, Effect::Fresnel, Effect::Ghosts, Effect::Spectra];

/// Effects on the finished picture, which are the same for all rungs and left out of all.
const PICTURE_EFFECTS: [Effect; 2] = [Effect::Diffraction, Effect::Sensor];

/// Most pixels of a report; each takes about 1300 bytes.
const MAX_PIXELS: u64 = 1 << 20;

/// One way to photograph the scene: a camera model with a set of effects.
#[derive(Clone, Debug)]
pub struct Rung {
    /// Short name, for tables and files.
    pub name: String,
    /// Description: what it simulates and what it leaves out.
    pub sentence: String,
    /// Model of the lens.
    pub fidelity: Fidelity,
    /// Effect that this rung has and the richest lacks: its difference is a change, not an error.
    pub adds: Option<Effect>,
    /// Distance of its rays from those of the richest rung, on film.
    pub film: FilmError,
    /// Factor on its pictures, for the same exposure as that of the richest rung. It differs from 1
    /// if one of the two has Fresnel losses and no coating is known: an even loss then is a matter
    /// of exposure, as in the plan.
    pub exposure: f32,
    pub(super) variant: JobVariant,
}

impl Rung {
    fn new(name: String, sentence: String, fidelity: Fidelity, variant: JobVariant) -> Self {
        let film = FilmError::default();
        Self { name, sentence, fidelity, adds: None, film, exposure: 1.0, variant }
    }
}

/// The parts of a job that differ between rungs.
#[derive(Clone, Debug)]
pub(super) struct JobVariant {
    camera: Camera,
    plan: Plan,
    ghosts: Option<Ghosts>,
    /// The scene by wavelength, if paths carry spectra, and the response of the film to them.
    spectral: Option<Arc<SpectralScene>>,
    response: Response,
    /// Share of the light that is left by losses which count as exposure.
    light: f64,
}

impl JobVariant {
    fn of(job: &Job) -> Self {
        let (camera, plan) = (job.camera.clone(), job.plan.clone());
        let (ghosts, spectral) = (job.ghosts.clone(), job.spectral.clone());
        let response = job.response.clone();
        Self { light: light(&camera, &plan), camera, plan, ghosts, spectral, response }
    }

    fn with_fidelity(&self, fidelity: Fidelity) -> Self {
        Self { camera: self.camera.with_fidelity(fidelity), ..self.clone() }
    }

    /// Exchanges these parts with those of a job.
    pub fn swap(&mut self, job: &mut Job) {
        std::mem::swap(&mut self.camera, &mut job.camera);
        std::mem::swap(&mut self.plan, &mut job.plan);
        std::mem::swap(&mut self.ghosts, &mut job.ghosts);
        std::mem::swap(&mut self.spectral, &mut job.spectral);
        std::mem::swap(&mut self.response, &mut job.response);
    }
}

/// Returns the share of the light that surfaces transmit, as a mean over the film, if they have
/// losses and their coatings are assumed; otherwise 1.
fn light(camera: &Camera, plan: &Plan) -> f64 {
    let LensModel::Real(lens) = &camera.model else { return 1.0 };
    if !plan.has(Effect::Fresnel) || !lens.prescription.assumed_coating {
        return 1.0;
    }
    let through = lens.throughput(camera.half_diagonal());
    through.map_or(1.0, |through| through.mean).max(f64::from(f32::EPSILON))
}

/// A scene and its rungs.
#[derive(Debug)]
pub struct Ladder {
    /// The job whose camera and effects rungs exchange; its own are those of a plain render.
    pub(super) job: Job,
    /// The rungs from the crudest to the richest, which traces every surface in f64 with all
    /// effects of the plan.
    pub rungs: Vec<Rung>,
    /// Name of the lens.
    pub lens: String,
    /// Effects that the ladder does not compare, with the reasons.
    pub not_compared: Vec<(Effect, &'static str)>,
    /// Warnings of the readers and of the preparation.
    pub warnings: Vec<Warning>,
}

impl Ladder {
    /// Builds the ladder of a scene:
    ///
    /// 1. The cruder models, from the pinhole to the polynomial, without effects of glass.
    /// 2. "real f32 alone": every surface, without effects of glass, if the plan has any.
    /// 3. "real f32 - effect": without one effect, if the plan has others too. Effects are left out
    ///    in turn, not added up, because leaving out one effect is the choice that a user has.
    /// 4. "real f32, one wavelength", if paths carry spectra: all but one end at the first surface.
    /// 5. "real f32": as a render does.
    /// 6. "real f32 + effect": with an effect that the plan leaves out, to check that decision.
    /// 7. "real f64".
    ///
    /// # Errors
    /// Returns an error if the scene cannot be photographed as requested, if its camera has no lens
    /// file, or if the monitor was stopped ([`RenderError::Stopped`]).
    pub fn new(
        description: &Description,
        changes: &Changes,
        monitor: &RunMonitor,
    ) -> Result<Self, PrepareError> {
        let Prepared { mut job, warnings, .. } = prepare(description.clone(), changes)?;
        let [width, height] = job.frame.size();
        if u64::from(width) * u64::from(height) > MAX_PIXELS {
            return Err(PrepareError::Request(format!(
                "{width} x {height} pixels for every rung would take too much memory and time; \
                 make it {MAX_PIXELS} at most with 'resolution' or 'crop'"
            )));
        }
        let LensModel::Real(lens) = &job.camera.model else {
            return Err(PrepareError::Camera {
                at: description.camera_at.clone(),
                problem: "this camera has no lens file, so there are no models of a lens to \
                          compare"
                    .to_owned(),
            });
        };
        let lens = lens.prescription.name.clone();
        let (plan, spectral) = (job.plan.clone(), job.spectral.clone());
        let variants = Variants { description, changes, plan, spectral, monitor };
        let (rungs, impossible) = variants.rungs(JobVariant::of(&job))?;
        let mut not_compared = not_compared(&job.plan);
        not_compared.extend(impossible.into_iter().map(|e| (e, "this scene cannot have it")));

        job.layers.clear();
        // All cameras of the ladder take the same paths, those of the camera.
        job.lamp_images = None;
        job.caustics = None;
        job.sensor = None;
        job.stop_criteria = StopCriteria::default();
        let mut ladder = Self { job, rungs, lens, not_compared, warnings };
        ladder.measure_film();
        Ok(ladder)
    }

    /// Measures how far the rays of every rung are from those of the richest.
    fn measure_film(&mut self) {
        let Self { job, rungs, .. } = self;
        let Some(best) = rungs.last().map(|rung| rung.variant.clone()) else { return };
        let usual = job.camera.clone();
        let time = job.timing.as_ref().map_or(0.0, |timing| timing.first_row_middle() as f32);
        let mut stack = TraversalStack::default();
        for rung in rungs {
            let exposure = best.light / rung.variant.light;
            rung.exposure = exposure as f32;
            // Spectra change the bands of a lens, not its rays.
            let same_spectra = rung.variant.spectral.is_some() == best.spectral.is_some();
            let camera = if same_spectra { &rung.variant.camera } else { &usual };
            rung.film = film_error(camera, &best.camera, |ray| {
                let hit = job.scene.closest_at::<f32x8>(ray, time, &mut stack);
                let length = ray.direction.iter().map(|v| v * v).sum::<f32>().sqrt();
                if hit.shape == NO_INDEX { f64::INFINITY } else { f64::from(hit.t * length) }
            });
            rung.film.light *= exposure;
        }
    }

    /// Returns the index of the rung that a plain render uses.
    pub fn usual(&self) -> Option<usize> {
        self.rungs.iter().position(|rung| rung.name == REAL)
    }

    /// Returns the files that the scene was read from.
    pub fn files(&self) -> &FileLog {
        &self.job.files
    }

    /// Returns width and height of the rendered part (pixels).
    pub fn size(&self) -> [u32; 2] {
        self.job.frame.size()
    }

    /// Returns the width of a pixel on the film (um).
    pub fn pitch(&self) -> f64 {
        1e3 * self.job.camera.film[0] / f64::from(self.job.frame.resolution[0])
    }
}

/// Returns the effects that are the same for all rungs, with the reasons.
fn not_compared(plan: &Plan) -> Vec<(Effect, &'static str)> {
    Effect::ALL
        .into_iter()
        .filter(|effect| !COMPARED.contains(effect))
        .map(|effect| match (PICTURE_EFFECTS.contains(&effect), plan.has(effect)) {
            (true, true) => (effect, "planned, but applied to the finished picture"),
            (true, false) => (effect, "applied to the finished picture"),
            (false, true) => (effect, "in all models alike"),
            (false, false) => (effect, "in none: the plan leaves it out"),
        })
        .collect()
}

/// Prepares variants of a scene's job.
struct Variants<'a> {
    description: &'a Description,
    changes: &'a Changes,
    /// Plan of a plain render.
    plan: Plan,
    /// Its scene by wavelength, which all rungs with spectra share.
    spectral: Option<Arc<SpectralScene>>,
    monitor: &'a RunMonitor,
}

impl Variants<'_> {
    /// Returns the rungs, where `full` is the variant of a plain render, and the effects that the
    /// scene cannot have.
    fn rungs(&self, full: JobVariant) -> Result<(Vec<Rung>, Vec<Effect>), PrepareError> {
        let [on, off]: [Vec<Effect>; 2] = [true, false]
            .map(|on| COMPARED.into_iter().filter(|&e| self.plan.has(e) == on).collect());
        let of_glass = on.iter().filter(|effect| GLASS_EFFECTS.contains(effect)).count();
        let bare = match of_glass {
            0 => full.clone(),
            _ => self.with(&GLASS_EFFECTS.map(|effect| (effect, false)))?,
        };
        let crude = Fidelity::ALL.into_iter().filter(|fidelity| *fidelity < Fidelity::Single);
        let mut rungs: Vec<Rung> = crude
            .map(|fidelity| {
                let (name, sentence) = (fidelity.name().to_owned(), fidelity.sentence().to_owned());
                Rung::new(name, sentence, fidelity, bare.with_fidelity(fidelity))
            })
            .collect();
        let single = |suffix: &str, effects: &str, variant| {
            let sentence = format!("Every surface traced in f32, {effects}.");
            Rung::new(format!("{REAL}{suffix}"), sentence, Fidelity::Single, variant)
        };
        if of_glass > 0 {
            rungs.push(single(" alone", "without effects of glass", bare));
        }
        for effect in on {
            // The only effect of glass is left out above.
            if of_glass > 1 || effect == Effect::Spectra {
                let (name, variant) = (effect.name(), self.with(&[(effect, false)])?);
                rungs.push(single(&format!(" - {name}"), &format!("without {name}"), variant));
            }
        }
        if let Some(scene) = &full.spectral {
            let spectral = Some(Arc::new(scene.with_one_wavelength()));
            let variant = JobVariant { spectral, ..full.clone() };
            rungs.push(single(", one wavelength", "one wavelength a path", variant));
        }
        let double = full.with_fidelity(Fidelity::Double);
        rungs.push(single("", "as a render does", full));
        let mut impossible = Vec::new();
        for effect in off {
            let (name, variant) = (effect.name(), self.with(&[(effect, true)])?);
            if !variant.plan.has(effect) {
                impossible.push(effect);
                continue;
            }
            let same = if variant.light == 1.0 { "" } else { ", at the same exposure" };
            let effects = format!("with {name}, which the plan leaves out{same}");
            let rung = single(&format!(" + {name}"), &effects, variant);
            rungs.push(Rung { adds: Some(effect), ..rung });
        }
        let sentence = "Every surface traced in f64, with all effects of the plan.".to_owned();
        rungs.push(Rung::new("real f64".to_owned(), sentence, Fidelity::Double, double));
        Ok((rungs, impossible))
    }

    /// Prepares the job with the plan's effects, except these.
    fn with(&self, overrides: &[(Effect, bool)]) -> Result<JobVariant, PrepareError> {
        if self.monitor.stopped() {
            return Err(RenderError::Stopped.into());
        }
        let one = |effect| {
            let given = overrides.iter().find(|(other, _)| *other == effect);
            (effect, given.map_or(self.plan.has(effect), |(_, on)| *on))
        };
        let effects = EffectSelection::Overrides(Effect::ALL.map(one).to_vec());
        let changes = Changes { effects, ..self.changes.clone() };
        let mut variant = JobVariant::of(&prepare(self.description.clone(), &changes)?.job);
        if let (Some(own), Some(shared)) = (&mut variant.spectral, &self.spectral) {
            own.clone_from(shared);
        }
        Ok(variant)
    }
}

/// Name of the rung that a plain render uses.
const REAL: &str = "real f32";
