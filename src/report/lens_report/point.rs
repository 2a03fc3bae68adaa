//! Spot diagram and modulation transfer of one film point, for viewers.

use petzval_lens::{Prescription, RealRayFocus};
use petzval_optics::{ConditionChoices, ImageQuality, ImagingConditions, ImagingGrid};

use super::inputs::ReportInputs;
use super::{spots, transfer};
use crate::plot::Plot;

/// Rays along each side of the grid over the pupil.
const PUPIL: usize = 32;
/// Least height on the film, for the axis (mm).
const LEAST: f64 = 1e-6;

/// The image of a point.
pub struct PointReport {
    /// Root mean square distance of the rays from their centroid (um).
    pub rms: f64,
    /// Spot diagram and modulation transfer, as SVG files.
    pub plots: [String; 2],
}

/// Analyses the image at a height on the film (mm), which is `film_distance` behind the rear vertex
/// (mm) and perpendicular to the axis.
///
/// # Errors
/// Returns a message if the lens cannot be analysed, or no light reaches the point.
pub fn point_report(
    lens: &Prescription,
    film_distance: f64,
    height: f64,
) -> Result<PointReport, String> {
    let object = RealRayFocus::new(lens).object_distance(film_distance);
    let choices = ConditionChoices {
        focus: object.map(|object| object + lens.film_position(film_distance)),
        film_distance: Some(film_distance),
        image_height: Some(height.max(LEAST)),
    };
    let conditions = ImagingConditions::new(lens, choices).map_err(|error| error.to_string())?;
    let index = |error| format!("{error}");
    let lens = lens.at_wavelength(conditions.primary_line().nm).map_err(index)?;
    let field = conditions.largest_field;
    let grid = ImagingGrid { fields: 2, pupil: PUPIL, threads: 1 };
    let quality = ImageQuality::new(&lens, conditions, grid).map_err(index)?;
    let dark = || "no light reaches this place through the middle of the stop".to_owned();
    let rays = quality.field(field, PUPIL).ok_or_else(dark)?;
    let rms = 1e3 * rays.spot().size(0.0, None).ok_or_else(dark)?.rms;
    let inputs = ReportInputs::new(lens, quality, (vec![rays], Vec::new()), None);
    let sections = [spots::spots(&inputs), transfer::by_frequency(&inputs)];
    let draw = |plot: Plot| Plot { narrow: true, ..plot }.file();
    let plots =
        sections.map(|section| section.plots.into_iter().next().map_or_else(String::new, draw));
    Ok(PointReport { rms, plots })
}
