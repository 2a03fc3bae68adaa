//! From what a scene file asks for, and what the command line changes, to a job.

mod changes;
mod exposure;
mod frame;
mod level;
mod place;
mod setup;

pub use changes::{Changes, FocusOn};

use glam::DMat3;

use crate::aov::Aov;
use crate::film::{Filter, Response};
use crate::ghosts;
use crate::image::{Note, Notes};
use crate::lens::{Camera, LensError, Model};
use crate::plan::{Effect, Moves, Plan, Question, plan};
use crate::render::{Job, RenderError, Until};
use crate::scene::pbrt::{CameraSpec, Description, FilmSpec};
use crate::source::{Files, Location, Warning, reading};
use crate::spectrum::{bands, white_balance};

use exposure::Exposure;
use frame::frame;
use level::level;
use place::Place;
use setup::Setup;

/// Why a scene cannot be photographed as asked.
#[derive(Debug, thiserror::Error)]
pub enum JobError {
    /// The lens file.
    #[error(transparent)]
    Lens(#[from] LensError),
    /// The lens file that the scene names cannot be read.
    #[error("{at}: {source}")]
    Unreadable {
        /// Where the scene names it.
        at: Location,
        /// The error of the reader.
        source: LensError,
    },
    /// The camera and its lens do not fit together.
    #[error("{at}: {problem}")]
    Camera {
        /// Where the camera stands in the scene file.
        at: Location,
        /// What is wrong.
        problem: String,
    },
    /// The command line asks for what cannot be.
    #[error("{0}")]
    Asked(String),
    /// The look at how bright the picture will be failed.
    #[error(transparent)]
    Level(#[from] RenderError),
}

/// Makes a scene ready to render. Answers the job, what to write about it into the picture, and
/// what was noticed on the way. A clone of the description may be made ready in another way: what is
/// large is neither read nor copied again.
///
/// # Errors
/// Where the lens cannot be read, or cannot do what is asked of it.
pub fn prepare(
    description: Description,
    changes: &Changes,
) -> Result<(Job, Notes, Vec<Warning>), JobError> {
    let mut files = description.files.clone();
    let (made, own) = reading(|| make(description, changes));
    let (mut job, notes, warnings) = made?;
    files.join(own);
    job.files = files;
    Ok((job, notes, warnings))
}

/// A job that does not know its files yet.
fn make(
    description: Description,
    changes: &Changes,
) -> Result<(Job, Notes, Vec<Warning>), JobError> {
    let exposure = Exposure::new(&description, changes)?;
    let world_from_camera = exposure.world_from_camera;
    let Description { mut scene, mut camera, camera_at, film, warnings, .. } = description;
    exposure.set(&mut camera);
    scene.expose(exposure.timing.range());
    let efficiency = exposure.efficiency;
    let mut setup = Setup { at: camera_at, warnings, notes: Notes::new(), posed: None, efficiency };
    let frame = frame(&film, changes)?;
    let response = Response {
        filter: Filter::new(description.filter.profile, description.filter.radius),
        brightest: film.brightest,
        balance: balance(&film, changes),
    };
    let bands = changes.passband.map_or_else(bands, |film| film.bands());
    let (model, size, imaging_ratio, depth) = match camera {
        CameraSpec::Thin(_) if changes.needs_lens().is_some() => {
            let option = changes.needs_lens().unwrap_or_default();
            let problem = format!("{option} is given, but this camera has no lens file");
            return Err(JobError::Camera { at: setup.at, problem });
        }
        CameraSpec::Thin(spec) => setup.thin(&spec, &film, frame.resolution),
        CameraSpec::Realistic(spec) => {
            let reach = response.filter.reach();
            let time = exposure.timing.middle() as f32;
            let place = Place { scene: &scene, time, world_from_camera, frame: &frame, reach };
            setup.real(&spec, &film, place, changes)?
        }
    };
    let samples = changes.samples.unwrap_or(description.samples);
    let evenly = changes.until.count_only();
    if !evenly && changes.samples.is_some_and(|samples| samples < Until::FEWEST) {
        let problem = format!(
            "--spp {samples}: --noise and --time need {} samples a pixel or more",
            Until::FEWEST
        );
        return Err(JobError::Asked(problem));
    }
    let seed = changes.seed.unwrap_or(description.seed);
    let pitch = 1e3 * pitch(&model, &film, size, frame.resolution);
    let asked = changes.sensor.map(|settings| settings.sensor(film.iso, pitch));
    let sensor = asked.filter(|_| changes.effects.of(Effect::Sensor) != Some(false));
    if let Some(sensor) = &sensor {
        setup.notes.push(("sensor", Note::Text(sensor.to_string())));
    }
    setup.number("isoSpeed", changes.iso(&film));
    setup.number("filmWidth", size[0]);
    setup.number("filmHeight", size[1]);
    if evenly {
        setup.number("samplesPerPixel", f64::from(samples));
    }
    setup.number("seed", f64::from(seed));
    let imaging_ratio = imaging_ratio * efficiency;
    let mut job = Job {
        scene,
        camera: Camera { model, film: size, world_from_camera, imaging_ratio, depth },
        plan: Plan::default(),
        frame,
        film: response,
        samples: 0..samples,
        until: Until::default(),
        seed,
        reach: description.reach,
        layers: layers(&film, changes),
        light: bands,
        ghosts: None,
        sensor,
        timing: Some(exposure.timing.clone()),
        files: Files::default(),
    };
    if let (Some(film), Model::Real(lens)) = (changes.passband, &mut job.camera.model) {
        lens.disperse(&[film.whole()]);
    }
    let sighting = match changes.effects.of(Effect::Ghosts) {
        Some(false) => None,
        _ => ghosts::survey(&job),
    };
    let level = level(&mut job)?;
    job.plan = plan(&Question {
        camera: &job.camera,
        resolution: job.frame.resolution,
        bands: &bands,
        assumed: changes.assume_vd,
        coated: changes.coating.is_some(),
        ghosts: sighting.as_ref(),
        level,
        sensor: asked.as_ref(),
        samples,
        moves: Moves {
            scene: &job.scene,
            timing: &exposure.timing,
            rolling: exposure.shutter.rolling.map(|rolling| (rolling, exposure.rolling_by)),
            pitch,
        },
        posed: setup.posed.as_ref(),
        wanted: &changes.effects,
        visible: changes.visible,
    });
    if let Model::Real(lens) = &mut job.camera.model {
        lens.fresnel = job.plan.has(Effect::Fresnel);
        if job.plan.has(Effect::Dispersion) {
            lens.disperse(&bands);
            lens.cover();
        }
        if job.plan.has(Effect::Ghosts) {
            job.ghosts = sighting.map(|sighting| sighting.ghosts(lens, &bands));
        }
    }
    setup.missed(&changes.effects, &job.plan);
    if let Model::Real(lens) = &job.camera.model {
        setup.doubt(lens);
    }
    setup.cropped(&job.frame, &job.plan);
    if !evenly {
        job.samples = 0..changes.samples.unwrap_or(Until::MOST);
        job.until = changes.until;
    }
    job.timing = exposure.plan(&job.plan, &mut job.scene)?;
    setup.notes.push(("effects", Note::Text(job.plan.line())));
    if let (Some(aov), Model::Thin(_)) =
        (job.layers.iter().find(|aov| aov.needs_lens()), &job.camera.model)
    {
        let name = format!("{aov:?}").to_lowercase();
        return Err(JobError::Asked(format!("--aov {name}: this camera has no lens file")));
    }
    Ok((job, setup.notes, setup.warnings))
}

/// What the film makes of colours, white balance first.
fn balance(film: &FilmSpec, changes: &Changes) -> Option<DMat3> {
    let white = film.white_balance.map(white_balance);
    match (changes.passband.map(|film| film.grey()), white) {
        (Some(grey), Some(white)) => Some(grey * white),
        (grey, white) => grey.or(white),
    }
}

/// The distance from pixel to pixel, mm.
fn pitch(model: &Model, film: &FilmSpec, size: [f64; 2], resolution: [u32; 2]) -> f64 {
    let [width, height] = resolution.map(f64::from);
    match model {
        Model::Real(_) => size[0] / width,
        // Its own film is measured in distances from the pinhole.
        Model::Thin(_) => film.diagonal / width.hypot(height),
    }
}

/// The layers that the command line or a film of the kind "gbuffer" asks for, each once.
fn layers(film: &FilmSpec, changes: &Changes) -> Vec<Aov> {
    let given: &[Aov] = match film.gbuffer && changes.holds_layers {
        true => &[Aov::Depth, Aov::Position, Aov::Normal, Aov::Albedo, Aov::Variance],
        false => &[],
    };
    let mut layers = Vec::new();
    for &aov in changes.layers.iter().chain(given) {
        if !layers.contains(&aov) {
            layers.push(aov);
        }
    }
    layers
}
