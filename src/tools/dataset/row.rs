//! Rows of the manifest.

use serde_json::{Map, Value, json};

use super::pair::Pair;
use super::spec::DatasetSpec;
use petzval_image::Note;
use petzval_lens::LensModel;
use petzval_optics::Calibration;
use petzval_render::aov::Aov;
use petzval_render::job::Job;
use petzval_render::plan::Effect;

/// Returns the manifest's row of a pair.
pub(super) fn row(
    spec: &DatasetSpec,
    pair: &Pair,
    calibration: Option<&Calibration>,
    objects: Option<Value>,
    files: Map<String, Value>,
) -> Map<String, Value> {
    let Pair { draw, clean, degraded, sensor, notes, .. } = pair;
    let metadata: Map<String, Value> = notes
        .iter()
        .map(|(name, note)| {
            let value = match note {
                Note::Text(text) => json!(text),
                Note::Number(number) => json!(number),
            };
            ((*name).to_owned(), value)
        })
        .collect();
    let model = calibration.and_then(|calibration| {
        let fit = calibration.suggested()?;
        let names = fit.model.coefficient_names();
        let distortion: Map<String, Value> = names
            .iter()
            .zip(&fit.coefficients)
            .map(|(name, value)| ((*name).to_owned(), json!(value)))
            .collect();
        Some(json!({
            "model": fit.model.name(),
            "matrix": fit.matrix.rows(),
            "distortion": distortion,
            "largest_error_pixels": fit.residual.max,
            "projection_centre_mm": calibration.centre.point.to_array(),
        }))
    });
    let clean_model = match &clean.camera.model {
        LensModel::Real(_) => model.clone(),
        _ => Some(json!({ "model": "pinhole", "matrix": pinhole_matrix(clean) })),
    };
    let layers = |job: &Job| job.layers.iter().map(|layer: &Aov| layer.name()).collect::<Vec<_>>();
    let picture = |job: &Job, camera: Option<Value>| {
        json!({
            "effects": effects(job),
            "exposure": job.camera.imaging_ratio,
            "world_from_camera": world_from_camera(job),
            "layers": layers(job),
            "camera": camera,
        })
    };
    let value = json!({
        "pair": draw.pair,
        "view": draw.view,
        "rig_camera": draw.rig_camera,
        "trajectory_s": draw.pose.map(|pose| pose.time),
        "seed": draw.seed,
        "scene": draw.scene,
        "lens": draw.lens,
        "light_stops": draw.light,
        "move_m": draw.shift,
        "turn_degrees": draw.turn,
        "f_number": draw.f_number,
        "resolution": spec.resolution,
        "spp": spec.spp,
        "film_mm": degraded.camera.film,
        "clean_camera": format!("{:?}", spec.clean.camera).to_lowercase(),
        "clean": picture(clean, clean_model),
        "degraded": picture(degraded, model),
        "sensor": sensor.map(|sensor| json!({
            "settings": sensor.to_string(),
            "iso": sensor.iso,
            "full_well": sensor.full_well,
            "read_noise": sensor.read_noise.pixel,
            "bits": sensor.bits,
            "black": sensor.black_level,
            "bayer": sensor.bayer.map(|bayer| bayer.name()),
        })),
        "objects": objects,
        "metadata": metadata,
        "files": files,
    });
    match value {
        Value::Object(row) => row,
        _ => Map::new(),
    }
}

/// Returns the names of the effects that a picture has.
fn effects(job: &Job) -> Vec<&'static str> {
    Effect::ALL.into_iter().filter(|effect| job.plan.has(*effect)).map(Effect::name).collect()
}

/// Returns the camera matrix of a pinhole, in pixels whose centres are whole numbers.
fn pinhole_matrix(job: &Job) -> [[f64; 3]; 3] {
    let [width, height] = job.frame.resolution.map(f64::from);
    let [across, down] = job.camera.film;
    [
        [width / across, 0.0, (width - 1.0) / 2.0],
        [0.0, height / down, (height - 1.0) / 2.0],
        [0.0, 0.0, 1.0],
    ]
}

/// Returns the pose of a camera, row by row.
fn world_from_camera(job: &Job) -> [[f64; 4]; 3] {
    let pose = job.camera.world_from_camera;
    let columns = [pose.matrix3.x_axis, pose.matrix3.y_axis, pose.matrix3.z_axis, pose.translation];
    [0, 1, 2].map(|row| columns.map(|column| column[row]))
}
