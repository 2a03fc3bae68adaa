//! One pair: its two jobs, and the files that they become.

use std::collections::BTreeSet;
use std::fmt::Display;
use std::io::Write as _;
use std::path::Path;

use serde_json::{Map, json};

use super::manifest::{ManifestRow, relative};
use super::row::row;
use super::spec::{CleanCamera, DatasetSpec};
use super::{DatasetError, Draw, objects};
use petzval_base::io::{FileLog, OutputError, OutputFile, Outputs, ReadContext, Warning, npy};
use petzval_base::sampler::hash;
use petzval_image::{DisplayExposure, EncodingOptions, Note, Notes, RawFile, WhiteBalance};
use petzval_lens::{FNumberError, Fidelity, LensModel, on_axis_irradiance};
use petzval_optics::CalibrationSetup;
use petzval_render::job::Job;
use petzval_render::plan::{Effect, EffectSelection};
use petzval_render::prepare::{Changes, PrepareError, Prepared, prepare, prepare_draft};
use petzval_render::{OpticalImage, ReadPicture, RenderError, RenderOptions, render};

use petzval_render::sensor::{BASE_ISO, PixelVignetting, Sensor};
use petzval_scene::PlacedShape;
use petzval_scene_formats::pbrt::Description;

/// f-number of a lens that is stopped down to have all in focus.
const DEEP_F_NUMBER: f64 = 64.0;

/// A scene that pairs are taken of.
#[derive(Clone, Debug)]
pub struct DatasetScene {
    description: Description,
    /// The files that the scene was read from.
    pub files: FileLog,
    /// The value of a pixel in the middle for a radiance of 1, by the scene's own lens and stop;
    /// `None` without a real lens.
    exposure: Option<f64>,
}

impl DatasetScene {
    /// Reads a scene for the pictures of a specification.
    ///
    /// # Errors
    /// Returns an error if the scene or its lens cannot be read.
    pub fn read(
        path: &Path,
        spec: &DatasetSpec,
        context: &ReadContext,
    ) -> Result<Self, DatasetError> {
        let description = petzval_scene_formats::read_with(path, context)?;
        // On the same film the same rays measure the exposure.
        let changes = Changes {
            resolution: Some(spec.resolution),
            buckets: Some(None),
            ..Changes::default()
        };
        let own = prepare_draft(description.clone(), &changes, None)
            .map_err(|source| DatasetError::OwnCamera {
                scene: path.to_owned(),
                source: Box::new(source),
            })?
            .job;
        let (files, exposure) = (description.files.clone(), on_axis_value(&own));
        Ok(Self { description, files, exposure })
    }
}

/// Returns the value of a pixel in the middle of the picture for a radiance of 1.
fn on_axis_value(job: &Job) -> Option<f64> {
    let LensModel::Real(lens) = &job.camera.model else { return None };
    Some(on_axis_irradiance(lens) * job.camera.imaging_ratio).filter(|value| *value > 0.0)
}

/// Two jobs with the same seed and what else a pair consists of.
#[derive(Debug)]
pub struct Pair {
    /// Its parameters.
    pub draw: Draw,
    /// The job of the clean picture.
    pub clean: Job,
    /// The job of the degraded picture, without its sensor.
    pub degraded: Job,
    /// The sensor that reads the degraded picture out.
    pub sensor: Option<Sensor>,
    /// The warnings of the readers and of the preparation.
    pub warnings: Vec<Warning>,
    pub(super) notes: Notes,
    psf: bool,
}

/// Prepares the jobs of a pair.
///
/// # Errors
/// Returns an error if the lens cannot be read or cannot do what was drawn.
pub fn prepare_pair(
    spec: &DatasetSpec,
    mut draw: Draw,
    scene: &DatasetScene,
) -> Result<Pair, DatasetError> {
    let pair = draw.pair;
    let words = draw.to_string();
    let failed = |source: PrepareError| DatasetError::Prepare {
        pair,
        draw: words.clone(),
        source: Box::new(source),
    };
    let description = &scene.description;
    let mut changes = Changes {
        resolution: Some(spec.resolution),
        samples: Some(spec.spp),
        seed: Some(draw.seed),
        lens: draw.lens.clone(),
        focus: draw.focus,
        f_number: draw.f_number,
        viewpoint: draw.viewpoint(&description.world_from_camera),
        layers: spec.layers.clone(),
        // Both pictures show the same moment.
        shutter: spec.degraded.shutter.clone(),
        // Pairs are RGB, as the film of the scene may not be.
        buckets: Some(None),
        ..Changes::default()
    };
    let mut degraded_changes = Changes {
        effects: spec.degraded.effects.clone().unwrap_or_default(),
        rolling: spec.degraded.rolling_shutter,
        ..changes.clone()
    };
    let mut prepared = prepare(description.clone(), &degraded_changes);
    if let Err(PrepareError::FNumber { source: FNumberError::TooFast { open }, .. }) = prepared {
        // Lenses of one data set open differently.
        degraded_changes.f_number = Some(open);
        changes.f_number = Some(open);
        prepared = prepare(description.clone(), &degraded_changes);
    }
    let Prepared { job: mut degraded, notes, warnings } = prepared.map_err(failed)?;
    if !matches!(degraded.camera.model, LensModel::Real(_)) {
        return Err(DatasetError::NoLens { pair, scene: draw.scene });
    }
    degraded.sensor = None;
    // Media and colours are the scene's; all other effects are the camera's.
    let of_scene = |effect: Effect| {
        matches!(effect, Effect::Media | Effect::Spectra) && degraded.plan.has(effect)
    };
    let without_effects =
        || EffectSelection::Overrides(Effect::ALL.map(|e| (e, of_scene(e))).into());
    let mut clean_changes =
        Changes { effects: spec.clean.effects.clone().unwrap_or_else(without_effects), ..changes };
    if spec.clean.camera == CleanCamera::Deep {
        clean_changes.f_number = Some(DEEP_F_NUMBER);
    }
    let mut clean = prepare(description.clone(), &clean_changes).map_err(failed)?.job;
    clean.sensor = None;
    let exposure = spec.exposure.exp2();
    for job in [&mut degraded, &mut clean] {
        if let (Some(scene), Some(own)) = (scene.exposure, on_axis_value(job)) {
            job.camera.imaging_ratio *= scene / own;
        }
        job.camera.imaging_ratio *= exposure;
    }
    if spec.clean.camera == CleanCamera::Pinhole {
        clean.set_camera(clean.camera.with_fidelity(Fidelity::Pinhole));
        clean.layers.retain(|layer| !layer.needs_lens());
        (clean.ghosts, clean.lamp_images, clean.caustics) = (None, None, None);
    }
    let shutter = degraded_changes.shutter_of(&description.shutter).map_err(failed)?;
    let sensor = match spec.degraded.sensor {
        None => None,
        Some(settings) => {
            let Job { camera, frame, response, .. } = &degraded;
            let pitch = 1e3 * pitch(&degraded);
            let mut sensor = settings.sensor(BASE_ISO, pitch, shutter.time());
            sensor.iso *= (-draw.light).exp2();
            sensor.filters = response.filters;
            let vignetting = settings
                .microlenses
                .map(|microlenses| PixelVignetting::new(microlenses, camera, frame));
            sensor.vignetting = vignetting
                .transpose()
                .map_err(|error| failed(PrepareError::Request(error.to_string())))?;
            if draw.rig_camera > 0 {
                // The cameras of a rig are not the same one.
                let pattern = &mut sensor.fixed_pattern.seed;
                *pattern = hash(*pattern ^ hash(draw.rig_camera));
            }
            Some(sensor)
        }
    };
    draw.f_number = changes.f_number;
    Ok(Pair { draw, clean, degraded, sensor, warnings, notes, psf: spec.psf })
}

/// Returns the width of a pixel on the film (mm).
fn pitch(job: &Job) -> f64 {
    job.camera.film[0] / f64::from(job.frame.resolution[0])
}

/// Renders the pictures of a pair and writes its files to a folder: `NNNNNN.clean.exr`,
/// `NNNNNN.degraded.exr`, and, as the specification asks, `NNNNNN.raw.exr` and `NNNNNN.psf.npy`.
///
/// # Errors
/// Returns an error if the render was stopped, or a file cannot be written or is an input: of this pair,
/// or of those that `outputs` knows.
pub fn write_pair(
    spec: &DatasetSpec,
    pair: &Pair,
    folder: &Path,
    outputs: &Outputs,
    options: RenderOptions<'_>,
) -> Result<ManifestRow, DatasetError> {
    for job in [&pair.clean, &pair.degraded] {
        outputs.protect(&job.files);
    }
    // All are claimed before the pair is rendered.
    let name = |kind: &str| folder.join(format!("{:06}.{kind}", pair.draw.pair));
    let clean = outputs.claim(name("clean.exr"))?;
    let degraded_file = outputs.claim(name("degraded.exr"))?;
    let raw_file = pair.sensor.as_ref().map(|_| outputs.claim(name("raw.exr"))).transpose()?;
    let develop = spec.degraded.develop.filter(|_| pair.sensor.is_some());
    let claim = |kind: &str| outputs.claim(name(kind));
    let developed_files = develop
        .map(|tone| Ok::<_, OutputError>((tone, claim("raw.dng")?, claim("developed.png")?)))
        .transpose()?;
    let psf_file = pair.psf.then(|| outputs.claim(name("psf.npy"))).transpose()?;
    let mut files = Map::new();
    let mut add = |kind: &str, file: &OutputFile| -> Result<(), DatasetError> {
        let path = file.path();
        let bytes = path.metadata().map_err(DatasetError::io("read", path))?.len();
        files.insert(kind.to_owned(), json!({ "file": relative(folder, path), "bytes": bytes }));
        Ok(())
    };
    let (mut degraded, mut seen) = (None, None);
    for (kind, job, file) in
        [("clean", &pair.clean, &clean), ("degraded", &pair.degraded, &degraded_file)]
    {
        let RenderedPicture { image, shapes } = render_job(job, file, spec, pair, options)?;
        add(kind, file)?;
        if let Some(mut shapes) = shapes {
            seen.get_or_insert_with(BTreeSet::new).append(&mut shapes);
        }
        if kind == "degraded" {
            degraded = Some(image);
        }
    }
    if let (Some(sensor), Some(image), Some(file)) = (&pair.sensor, degraded, &raw_file) {
        let Job { frame, seed, .. } = &pair.degraded;
        let ReadPicture { picture: raw, halves } =
            image.read_out_by(Some(sensor), frame.low, *seed);
        let mut encoding = pair.degraded.encoding(DisplayExposure::default());
        // A half float has fewer codes than most sensors.
        (encoding.half, encoding.space, encoding.grey) = (false, None, sensor.bayer.is_some());
        raw.write_with_layers(&halves, file, frame.window(), encoding, &Notes::new())?;
        add("raw", file)?;
        if let Some((tone, dng, png)) = &developed_files {
            encoding.raw = pair.degraded.raw_format_of(sensor);
            raw.write(dng, frame.window(), encoding, &pair.notes)?;
            add("dng", dng)?;
            let developed = RawFile::read(dng.path(), &ReadContext::default())?
                .develop(WhiteBalance::Off)
                .map_err(|error| DatasetError::Develop {
                    pair: pair.draw.pair,
                    problem: error.to_string(),
                })?;
            let exposure = DisplayExposure::Stops(0.0);
            let encoding = EncodingOptions { exposure, tone: *tone, ..EncodingOptions::default() };
            developed.picture.write(png, frame.window(), encoding, &Notes::new())?;
            add("developed", png)?;
        }
    }
    let setup = CalibrationSetup::of_camera(&pair.degraded.camera, pair.degraded.frame.resolution);
    let calibrated = setup.as_ref().map(CalibrationSetup::calibrate_quickly);
    if let (Some(file), Some(setup), Some(calibrated)) = (&psf_file, &setup, &calibrated) {
        let failed = |error: &dyn Display| DatasetError::PointSpreads {
            pair: pair.draw.pair,
            problem: error.to_string(),
        };
        let calibration = calibrated.as_ref().map_err(|error| failed(error))?;
        let spots = setup.usual_spots(calibration).map_err(|error| failed(&error))?;
        let array = npy::encode(&spots.shape(), &spots.shares);
        let written = file.write(|file| file.write_all(&array));
        written.map_err(DatasetError::io("write", file.path()))?;
        add("psf", file)?;
    }
    // Some lenses have no centre of projection, or no model describes them: the row says null.
    let calibration = calibrated.and_then(Result::ok);
    let objects = seen.map(|seen| objects::rows(&pair.degraded, &seen));
    Ok(ManifestRow(row(spec, pair, calibration.as_ref(), objects, files)))
}

/// The light of a picture whose file is written, and the shapes that it shows, if it has a layer of them.
struct RenderedPicture {
    image: OpticalImage,
    shapes: Option<BTreeSet<PlacedShape>>,
}

fn render_job(
    job: &Job,
    file: &OutputFile,
    spec: &DatasetSpec,
    pair: &Pair,
    options: RenderOptions<'_>,
) -> Result<RenderedPicture, DatasetError> {
    let output = render(job, options)?;
    if output.partial_mean_spp.is_some() {
        return Err(RenderError::Stopped.into());
    }
    let mut layers = output.layers(job);
    let image = output.into_optical_image(job);
    let picture = image.clone().read_out(job).into_picture(job, &mut layers);
    let mut encoding = job.encoding(DisplayExposure::default());
    encoding.half |= spec.half;
    let mut notes: Notes = vec![
        ("software", Note::Text(format!("petzval {}", env!("CARGO_PKG_VERSION")))),
        ("pair", Note::Number(f64::from(pair.draw.pair))),
    ];
    if std::ptr::eq(job, &pair.degraded) {
        notes.extend(pair.notes.iter().cloned());
    }
    picture.write_with_layers(&layers, file, job.frame.window(), encoding, &notes)?;
    Ok(RenderedPicture { image, shapes: objects::seen_in(&layers) })
}
