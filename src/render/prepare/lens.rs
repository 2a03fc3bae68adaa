//! Prescription of a job's lens: the file, its coating, glass, iris and stop, and its alignment.

use super::camera::CameraInput;
use super::report::Report;
use super::{Changes, PrepareError};
use crate::plan::{DecidedBy, Misalignment};
use petzval_base::io::{Location, ReadContext};
use petzval_lens::{ApertureMask, Iris, LensError, MASK_NAMES, Pose, Prescription};
use petzval_lens_formats::read_mask_by_pbrt;
use petzval_scene_formats::pbrt::{IrisSpec, RealisticSpec};

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
    if let Some(coating) = &changes.coating {
        prescription.coat(coating);
    }
    prescription.assume_coating();
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
    read_mask_by_pbrt(path, context).map(Iris::Mask).map_err(|error| PrepareError::Camera {
        at: camera_at.clone(),
        problem: format!("aperture \"{name}\": {error}; expected circular, {known} or a picture"),
    })
}

/// Returns the diameter of the stop (mm) that gives an f-number. A slightly larger one may be the widest
/// of the lens; the report says so.
///
/// # Errors
/// Returns an error if the lens forms no image or does not open so wide.
pub(super) fn f_number_diameter(
    lens: &Prescription,
    asked: f64,
    report: &mut Report,
) -> Result<f64, PrepareError> {
    if let Some(rounded) = lens.rounded_f_number(asked) {
        report.warn(rounded.to_string());
    }
    lens.f_number_diameter(asked).map_err(|source| PrepareError::FNumber {
        asked,
        lens: lens.name.clone(),
        source,
    })
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
