//! Draft of a job: everything but its plan.

use super::camera::{CameraInput, CameraSetup};
use super::exposure::Exposure;
use super::focus::View;
use super::report::Report;
use super::{Changes, ExcludedEffects, PrepareError, film};
use crate::job::{Job, StopCriteria};
use crate::plan::{Misalignment, Plan};
use crate::sensor::{PixelVignetting, Sensor};
use petzval_base::io::{FileLog, ReadContext};
use petzval_lens::{Camera, LensModel};
use petzval_scene_formats::pbrt::Description;
use petzval_spectrum::bands;

/// A job without a plan, and the parts that only the plan needs.
pub(super) struct Draft {
    pub job: Job,
    pub misalignment: Option<Misalignment>,
    /// The sensor that the user asks for, excluded or not.
    pub sensor: Option<Sensor>,
    /// The distance from pixel to pixel (um).
    pub pitch: f64,
}

/// Returns a job with an empty plan.
pub(super) fn draft(
    description: Description,
    changes: &Changes,
    context: &ReadContext,
    excluded: ExcludedEffects,
    exposure: &Exposure,
    report: &mut Report,
) -> Result<Draft, PrepareError> {
    let world_from_camera = exposure.world_from_camera;
    let Description { mut scene, camera: mut spec, film, .. } = description;
    exposure.set_time(&mut spec);
    scene.set_time_range(exposure.timing.range());
    let frame = film::frame(&film, changes)?;
    let response = film::response(&description.filter, &film, changes);
    let input = CameraInput {
        context,
        film: &film,
        changes,
        excluded,
        efficiency: exposure.efficiency,
        view: View {
            scene: &scene,
            time: exposure.timing.first_row_middle() as f32,
            world_from_camera,
            frame: &frame,
            filter_reach: response.filter.margin(),
        },
    };
    let CameraSetup { model, film_size, imaging_ratio, depth, misalignment } =
        input.set_up(&spec, report)?;
    let samples = changes.samples.unwrap_or(description.samples);
    let uniform = changes.stop_criteria.count_only();
    if !uniform && changes.samples.is_some_and(|samples| samples < StopCriteria::MIN_SAMPLES) {
        let problem = format!(
            "'spp' {samples}: 'noise' and 'time' need {} samples a pixel or more",
            StopCriteria::MIN_SAMPLES
        );
        return Err(PrepareError::Request(problem));
    }
    let seed = changes.seed.unwrap_or(description.seed);
    let pitch = 1e3 * film::pixel_pitch(&model, &film, film_size, frame.resolution);
    let filters = response.filters;
    let seconds = exposure.shutter.time();
    let imaging_ratio = imaging_ratio * exposure.efficiency;
    let camera = Camera { model, film: film_size, world_from_camera, imaging_ratio, depth };
    let vignetting = match changes.sensor.and_then(|settings| settings.microlenses) {
        None => None,
        Some(microlenses) => Some(
            PixelVignetting::new(microlenses, &camera, &frame)
                .map_err(|error| PrepareError::Request(error.to_string()))?,
        ),
    };
    let asked = changes.sensor.map(|settings| {
        let sensor = settings.sensor(film.iso, pitch, seconds);
        Sensor { filters, vignetting, ..sensor }
    });
    let sensor = asked.filter(|_| !excluded.sensor);
    if let Some(sensor) = &sensor {
        report.text("sensor", sensor.to_string());
        if let Some(filters) = &sensor.filters {
            let numbers = |numbers: &[f64]| {
                numbers.iter().map(|number| format!("{number:.6}")).collect::<Vec<_>>().join(" ")
            };
            report.text("sensorWhite", numbers(&filters.white()));
            report.text("sensorToXYZ", numbers(filters.xyz_from_raw().as_flattened()));
        }
    }
    report.number("isoSpeed", changes.iso(&film, pitch));
    report.number("filmWidth", film_size[0]);
    report.number("filmHeight", film_size[1]);
    if uniform {
        report.number("samplesPerPixel", f64::from(samples));
    }
    report.number("seed", f64::from(seed));
    let mut job = Job {
        diffraction: None,
        scene,
        spectral: None,
        camera,
        plan: Plan::default(),
        frame,
        response,
        colour_space: film.colour_space,
        half: film.half,
        samples: 0..samples,
        stop_criteria: StopCriteria::default(),
        seed,
        path_limits: description.path_limits,
        layers: film::layers(&film, changes),
        camera_layers: film.camera_layers,
        bands: changes.passband.map_or_else(bands, |passband| passband.bands()),
        ghosts: None,
        lamp_images: None,
        caustics: None,
        sensor,
        timing: Some(exposure.timing.clone()),
        motion_vectors: None,
        files: FileLog::default(),
    };
    if let (Some(passband), LensModel::Real(lens)) = (changes.passband, &mut job.camera.model) {
        lens.disperse(&[passband.whole()]);
    }
    Ok(Draft { job, misalignment, sensor: asked, pitch })
}
