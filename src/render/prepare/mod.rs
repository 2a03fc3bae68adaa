//! Preparation of a job: from a scene file and the changes that the user asks for.

mod camera;
mod changes;
mod draft;
mod exposure;
mod film;
mod focus;
mod lens;
mod pilot;
mod report;
pub mod settings;
mod viewpoint;

pub use changes::{Changes, FocusOn};
pub use viewpoint::Viewpoint;

use std::sync::{Arc, OnceLock};

use crate::RenderError;
use crate::aov::{Aov, MotionVectors};
use crate::job::{Job, StopCriteria};
use crate::light_tracing::ghosts;
use crate::light_tracing::ghosts::GhostEstimate;
use crate::light_tracing::light_paths::LightPathSelection;
use crate::light_tracing::{LightTracingSurvey, survey};
use crate::plan::{
    DecidedBy, Effect, EffectSelection, LightTracingDecision, MotionInput, PilotEstimate, Plan,
    PlanInput, plan,
};
use petzval_base::io::{Location, ReadContext, Warning};
use petzval_image::Notes;
use petzval_lens::{FNumberError, LensError, LensModel, PupilSampling};
use petzval_scene::SpectralScene;
use petzval_scene_formats::pbrt::Description;
use petzval_spectrum::{BucketShares, lens_bands};

use draft::{Draft, draft};
use exposure::Exposure;
use report::Report;

/// Error of a preparation.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PrepareError {
    /// The lens file is not sound, or the lens file of the command line cannot be read.
    #[error(transparent)]
    Lens(#[from] LensError),
    /// The lens file that the scene names cannot be read.
    #[error("{at}: {source}")]
    Unreadable {
        /// The place in the scene file that names it.
        at: Location,
        /// The error of the reader.
        source: LensError,
    },
    /// The camera and its lens do not fit together.
    #[error("{at}: {problem}")]
    Camera {
        /// The place of the camera in the scene file.
        at: Location,
        /// The problem.
        problem: String,
    },
    /// The lens has no such f-number.
    #[error("'fstop' {asked}: {lens} {source}")]
    FNumber {
        /// The f-number that is asked for.
        asked: f64,
        /// The name of the lens.
        lens: String,
        /// Why not.
        source: FNumberError,
    },
    /// A setting asks for something impossible.
    #[error("{0}")]
    Request(String),
    /// The pilot render failed.
    #[error(transparent)]
    Pilot(#[from] RenderError),
}

/// A picture that is ready to be rendered.
#[derive(Debug)]
pub struct Prepared {
    /// The job.
    pub job: Job,
    /// The notes for the metadata of its picture.
    pub notes: Notes,
    /// The warnings about scene, lens and settings.
    pub warnings: Vec<Warning>,
}

/// Prepares a scene for rendering.
///
/// Clones of one description may be prepared in different ways. They share the large data, which is
/// neither read nor copied again.
///
/// # Errors
/// Returns an error if the lens cannot be read or cannot do what is asked of it.
pub fn prepare(description: Description, changes: &Changes) -> Result<Prepared, PrepareError> {
    // The lens and its iris are read for this job alone.
    let context = description.context.temporary();
    let mut files = description.files.clone();
    let (mut job, report) = plan_job(description, changes, &context)?;
    files.join(context.files());
    job.files = files;
    Ok(Prepared { job, notes: report.notes, warnings: report.warnings })
}

/// Effects of a draft: those that move, blur or dim much of the light, and cost little to prepare.
const DRAFT_EFFECTS: [Effect; 6] = [
    Effect::Fresnel,
    Effect::Iris,
    Effect::Motion,
    Effect::RollingShutter,
    Effect::TiltShift,
    Effect::Media,
];

/// Effects of a draft without a similar picture: those that are there or not.
const FIRST_DRAFT_EFFECTS: [Effect; 3] = [Effect::Iris, Effect::TiltShift, Effect::Media];

/// Prepares a draft of a picture, in a fraction of the time of [`prepare`], for a viewer. Its effects
/// are those of the plan of a similar picture, except for dispersion, ghosts, diffraction and the
/// sensor; without one, they are the shape of the iris, tilt, shift and media. It has no layers, and
/// no light paths. Its notes and warnings are those of [`prepare`] that need no plan.
///
/// # Errors
/// Returns an error as [`prepare`].
pub fn prepare_draft(
    description: Description,
    changes: &Changes,
    similar: Option<&Plan>,
) -> Result<Prepared, PrepareError> {
    let aim = match changes.aim {
        PupilSampling::Pupil => PupilSampling::RoundIris,
        other => other,
    };
    let changes = &Changes { aim, ..changes.clone() };
    let context = description.context.temporary();
    let exposure = Exposure::new(&description, changes)?;
    let warnings = description.warnings.clone();
    let mut report =
        Report { camera_at: description.camera_at.clone(), warnings, notes: Notes::new() };
    let excluded = ExcludedEffects::new(&changes.effects);
    let Draft { mut job, .. } =
        draft(description, changes, &context, excluded, &exposure, &mut report)?;
    job.plan = similar.map_or_else(|| Plan::of(&FIRST_DRAFT_EFFECTS), Plan::clone);
    for decision in &mut job.plan.effects {
        decision.on &= DRAFT_EFFECTS.contains(&decision.effect);
    }
    (job.layers, job.sensor) = (Vec::new(), None);
    apply_plan(&mut job, exposure, None)?;
    Ok(Prepared { job, notes: report.notes, warnings: report.warnings })
}

/// Effects that the user turns off and that shape the input of the plan, so that they are left out
/// before it is made. The plan alone decides about all others.
#[derive(Clone, Copy, Debug)]
struct ExcludedEffects {
    iris: bool,
    tilt_shift: bool,
    sensor: bool,
    ghosts: bool,
}

impl ExcludedEffects {
    fn new(selection: &EffectSelection) -> Self {
        let excluded = |effect| selection.of(effect) == Some(false);
        Self {
            iris: excluded(Effect::Iris),
            tilt_shift: excluded(Effect::TiltShift),
            sensor: excluded(Effect::Sensor),
            ghosts: excluded(Effect::Ghosts),
        }
    }
}

/// Returns a job with its plan, but without the files that it was read from.
fn plan_job(
    description: Description,
    changes: &Changes,
    context: &ReadContext,
) -> Result<(Job, Report), PrepareError> {
    let excluded = ExcludedEffects::new(&changes.effects);
    let exposure = Exposure::new(&description, changes)?;
    let warnings = description.warnings.clone();
    let mut report =
        Report { camera_at: description.camera_at.clone(), warnings, notes: Notes::new() };
    let buckets = film::buckets(&description.film, changes)?;
    let Draft { mut job, misalignment, sensor, pitch } =
        draft(description, changes, context, excluded, &exposure, &mut report)?;
    let measured = measure(&job, changes, excluded)?;
    let diffraction = OnceLock::new();
    let decide = |measured: &Measured| {
        plan(&PlanInput {
            diffraction: &diffraction,
            camera: &job.camera,
            resolution: job.frame.resolution,
            bands: &job.bands,
            narrow_band: changes.passband.is_some(),
            buckets: buckets.map(|(_, by)| by),
            assumed_dispersion: changes.assume_vd,
            coating_given: changes.coating.is_some(),
            ghosts: measured.ghosts.as_ref(),
            pilot: measured.pilot,
            sensor: sensor.as_ref(),
            samples: job.samples.end,
            motion: MotionInput {
                scene: &job.scene,
                timing: &exposure.timing,
                rolling: exposure.shutter.rolling.map(|rolling| (rolling, exposure.rolling_by)),
                pitch,
            },
            misalignment: misalignment.as_ref(),
            selection: &changes.effects,
            threshold: changes.threshold,
        })
    };
    job.plan = measured.as_ref().map_or_else(Plan::unwanted, decide);
    job.diffraction = diffraction.into_inner();
    let Measured { ghosts, pilot } = measured.unwrap_or_default();
    apply_plan(&mut job, exposure, ghosts.as_ref())?;
    job.response.buckets = buckets
        .filter(|(_, by)| *by == DecidedBy::Flag || changes.holds_spectra)
        .map(|(buckets, _)| Arc::new(BucketShares::new(buckets)));
    plan_light_paths(&mut job, changes.light_paths, pilot.mean);
    report.warn_unavailable(&changes.effects, &job.plan);
    if let LensModel::Real(lens) = &job.camera.model {
        let ghosts = if job.ghosts.is_some() { &job.bands[..] } else { &[] };
        report.check_indices(lens, ghosts)?;
    }
    report.warn_crop(&job.frame, &job.plan);
    if changes.lens.is_some() && changes.film_diagonal.is_none() {
        report.warn_small_circle(&job.camera);
    }
    if !changes.stop_criteria.count_only() {
        job.samples = 0..changes.samples.unwrap_or(StopCriteria::DEFAULT_MAX_SAMPLES);
        job.stop_criteria = changes.stop_criteria;
    }
    report.text("effects", job.plan.line());
    report.text("lightPaths", job.plan.light_paths.to_string());
    let has_lens = matches!(job.camera.model, LensModel::Real(_));
    if let (Some(aov), false) = (job.layers.iter().find(|aov| aov.needs_lens()), has_lens) {
        let name = aov.name();
        return Err(PrepareError::Request(format!("'aov' {name}: this camera has no lens file")));
    }
    Ok((job, report))
}

/// Estimates on which a plan is based.
#[derive(Default)]
struct Measured {
    ghosts: Option<GhostEstimate>,
    /// The brightness and the cost of the picture.
    pilot: PilotEstimate,
}

/// Measures a picture without effects; `None` if the user has decided about all effects and the light
/// paths, so that nothing needs to be measured.
///
/// # Errors
/// Returns an error if the pilot picture cannot be rendered.
fn measure(
    job: &Job,
    changes: &Changes,
    excluded: ExcludedEffects,
) -> Result<Option<Measured>, PrepareError> {
    let is_off = |&effect: &Effect| changes.effects.of(effect) == Some(false);
    if changes.light_paths.is_some() && Effect::ALL.iter().all(is_off) {
        return Ok(None);
    }
    let ghosts = || match excluded.ghosts {
        true => None,
        false => ghosts::estimate(&job.light_path_input()),
    };
    let (ghosts, pilot) = rayon::join(ghosts, || pilot::estimate(job));
    Ok(Some(Measured { ghosts, pilot: pilot? }))
}

/// Decides whether light paths find images of lamps, and caustics. `mean` is the mean
/// luminance of the picture.
fn plan_light_paths(job: &mut Job, wanted: Option<bool>, mean: f64) {
    let by = if wanted.is_some() { DecidedBy::Flag } else { DecidedBy::Scene };
    let input = job.light_path_input();
    let surveyed = match wanted {
        Some(false) => LightTracingSurvey::unwanted(),
        Some(true) => survey(&input, LightPathSelection::All),
        None => survey(&input, LightPathSelection::Noisy { mean }),
    };
    let LightTracingSurvey { lamp_images, caustics, reason } = surveyed;
    let on = lamp_images.is_some() || caustics.is_some();
    job.plan.light_paths = LightTracingDecision { on, by, reason };
    (job.lamp_images, job.caustics) = (lamp_images, caustics);
}

/// Turns on the effects that the plan of a job simulates.
fn apply_plan(
    job: &mut Job,
    exposure: Exposure,
    ghost_estimate: Option<&GhostEstimate>,
) -> Result<(), PrepareError> {
    if !job.plan.has(Effect::Media) {
        job.scene.remove_media();
    }
    if job.layers.contains(&Aov::Motion) {
        let timing = exposure.motion_timing(&job.plan)?;
        let vectors = MotionVectors::new(&job.scene, &job.camera, job.frame.resolution, &timing);
        job.motion_vectors = Some(Arc::new(vectors));
    }
    job.timing = exposure.timing(&job.plan, &mut job.scene)?;
    if job.plan.has(Effect::Spectra) {
        job.spectral = Some(Arc::new(SpectralScene::new(&job.scene)));
        job.response.receive_spectra();
    }
    let LensModel::Real(lens) = &mut job.camera.model else { return Ok(()) };
    lens.fresnel = job.plan.has(Effect::Fresnel);
    let bands = match job.plan.has(Effect::Spectra) {
        true => lens_bands(),
        false => job.bands.to_vec(),
    };
    if job.plan.has(Effect::Dispersion) {
        lens.disperse(&bands);
        lens.bound_all_bands();
    }
    if job.plan.has(Effect::Ghosts) {
        job.ghosts = ghost_estimate.map(|estimate| estimate.ghosts(lens, &bands));
    }
    Ok(())
}
