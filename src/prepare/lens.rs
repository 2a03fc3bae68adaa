//! Prescription of a job's lens: the file, its coating, glass, iris and stop, and its alignment.

use super::camera::CameraInput;
use super::report::Report;
use super::{Changes, PrepareError};
use crate::io::{Location, ReadContext};
use crate::lens::{ApertureMask, Iris, LensError, MASK_NAMES, Pose, Prescription, RealRayFocus};
use crate::plan::{DecidedBy, Misalignment};
use crate::scene::pbrt::{IrisSpec, RealisticSpec};

/// Reads the lens of a camera, with the coating, the dispersion and the iris that are asked for.
///
/// # Errors
/// Returns an error if the lens file or the picture of the iris cannot be read.
pub(super) fn read_lens(
    input: &CameraInput<'_>,
    spec: &RealisticSpec,
    report: &mut Report,
) -> Result<Prescription, PrepareError> {
    let CameraInput { context, changes, excluded, .. } = *input;
    let (RealisticSpec::V4 { lens: file, lens_at, .. }
    | RealisticSpec::V2 { lens: file, lens_at, .. }) = spec;
    let mut prescription = match &changes.lens {
        Some(other) => changes.lens_options.read(other, context)?,
        None => changes.lens_options.read(file, context).map_err(|source| match source {
            LensError::Io { .. } => PrepareError::Unreadable { at: lens_at.clone(), source },
            // These errors name the line in the lens file.
            other => other.into(),
        })?,
    };
    for note in &prescription.design.notes {
        report.warn(format!("lens {}: {note}", prescription.name));
    }
    if let Some(coating) = changes.coating {
        prescription.coat(coating);
    }
    if changes.assume_vd {
        let guessed = prescription.assume_dispersion();
        let names: Vec<&str> = guessed.iter().map(|glass| &*glass.name).collect();
        report.text("assumedGlass", names.join(" "));
    }
    if let RealisticSpec::V4 { iris: Some(iris), .. } = spec {
        let stop = prescription.stop();
        prescription.rows[stop].iris = read_iris(iris, context, &report.camera_at)?;
    }
    if excluded.iris {
        for row in &mut prescription.rows {
            row.open_all();
        }
    }
    Ok(prescription)
}

/// Returns the iris of one of pbrt's names, or reads it from a picture.
fn read_iris(
    IrisSpec { name, path }: &IrisSpec,
    context: &ReadContext,
    camera_at: &Location,
) -> Result<Iris, PrepareError> {
    if name == "circular" {
        return Ok(Iris::Round);
    }
    if let Some(mask) = ApertureMask::named_by_pbrt(name) {
        return Ok(Iris::Mask(mask));
    }
    let known = MASK_NAMES.join(", ");
    ApertureMask::image_by_pbrt(path, context).map(Iris::Mask).map_err(|error| {
        PrepareError::Camera {
            at: camera_at.clone(),
            problem: format!(
                "aperture \"{name}\": {error}; expected circular, {known} or a picture"
            ),
        }
    })
}

/// Returns the diameter of the stop (mm) that gives an f-number, measured by a traced marginal ray.
/// So the light on the film follows the f-number whatever the aberrations of the pupil.
///
/// # Errors
/// Returns an error if the lens forms no image or does not open so wide.
pub(super) fn f_number_diameter(lens: &Prescription, asked: f64) -> Result<f64, PrepareError> {
    let f_number = |diameter: f64| {
        let mut closed = lens.clone();
        closed.stop_down(diameter);
        RealRayFocus::new(&closed).f_number().unwrap_or(f64::INFINITY)
    };
    let (mut narrow, mut wide) = (0.0, lens.rows[lens.stop()].diameter);
    let open = f_number(wide);
    if open.is_infinite() {
        return Err(PrepareError::Request(format!(
            "--fstop {asked}: {} forms no image",
            lens.name
        )));
    }
    if asked >= open * (1.0 - 1e-3) {
        // Fifty bisections reach the precision of f64.
        for _ in 0..50 {
            let middle = (narrow + wide) / 2.0;
            if f_number(middle) > asked {
                narrow = middle;
            } else {
                wide = middle;
            }
        }
        return Ok(wide);
    }
    Err(PrepareError::Request(format!(
        "--fstop {asked}: {} opens to f/{open:.2} and no wider; expected {open:.2} or more",
        lens.name
    )))
}

/// Returns the pose of the film, and the misalignment that is asked for, if any. If it is excluded,
/// the elements of the lens are centred and the film is aligned.
pub(super) fn align(
    lens: &mut Prescription,
    spec: &RealisticSpec,
    changes: &Changes,
    excluded: bool,
) -> (Pose, Option<Misalignment>) {
    let (RealisticSpec::V4 { film_pose, .. } | RealisticSpec::V2 { film_pose, .. }) = spec;
    let film = Pose::of_film(
        changes.film_shift.unwrap_or(film_pose.film_shift()),
        changes.film_tilt.unwrap_or(film_pose.tilt),
    );
    if film.is_aligned() && !lens.is_misaligned() {
        return (Pose::ALIGNED, None);
    }
    let by = match changes.film_shift.is_some() || changes.film_tilt.is_some() {
        _ if film.is_aligned() => DecidedBy::Lens,
        true => DecidedBy::Flag,
        false => DecidedBy::Scene,
    };
    let misalignment = Some(Misalignment { lens: lens.clone(), film, by });
    if excluded {
        lens.centre();
        return (Pose::ALIGNED, misalignment);
    }
    (film, misalignment)
}
