//! Prescription and first-order data of a lens, as text.

use std::fmt::Write as _;

use petzval_lens::{
    AxialLight, Coating, FieldKind, FocusError, FocusModel, Paraxial, Prescription, PupilSampling,
    RealLens, RealRayFocus, Row, TransverseAxis,
};
use petzval_report::number::rounded;
use petzval_spectrum::D_LINE;

use super::LensArguments;
use crate::cli::Failure;

/// A lens described in words, and where its film is.
pub(super) struct Summary {
    pub text: String,
    /// Distance of the film behind the rear vertex; `None` if the lens forms no image (mm).
    pub film: Option<f64>,
}

/// Describes a lens and its focus as the arguments ask for. `groups_film` is the distance of the film
/// behind the rear vertex (mm) if the groups of the lens stand where this focus has them.
///
/// # Errors
/// Returns an error if the lens cannot focus at the distance of --focus.
pub(super) fn summary(
    lens: &Prescription,
    arguments: &LensArguments,
    groups_film: Option<f64>,
) -> Result<Summary, Failure> {
    let paraxial = Paraxial::new(lens);
    let mut text = format!("{}\n{lens}\n", lens.name);
    if lens.is_misaligned() {
        text += "All figures below are for the lens without tilt and decentre.\n\n";
    }
    let mut line = |name: &str, value: f64, unit: &str| write_line(&mut text, name, value, unit);
    let wavelength = lens.design.primary_wavelength();
    let unit = match (lens.is_monochromatic(), wavelength == D_LINE) {
        (true, _) => " nm  (all indices; the file states no dispersion)",
        (false, true) => " nm  (the d line, for which all figures hold)",
        (false, false) => " nm  (the primary one, for which all figures hold)",
    };
    line("wavelength", wavelength, unit);
    line("focal length", paraxial.focal_length, " mm");
    if paraxial.film_index != 1.0 {
        let index = paraxial.film_index;
        line("index before the film", index, "     (the f-numbers below hold for any medium)");
        let times = format!(" mm  ({index:.4} times the focal length)");
        line("rear focal length", paraxial.rear_focal_length(), &times);
    }
    if paraxial.is_afocal() {
        let magnification = paraxial.whole.d / paraxial.film_index;
        line("angular magnification", magnification, "     (slope behind the lens / before it)");
    }
    if let Some(stated) = lens.stated_focal_length {
        line("", stated, " mm  (as the file states)");
    }
    if lens.rows.iter().any(Row::is_anamorphic) {
        let along_y = Paraxial::in_plane(lens, TransverseAxis::Y).focal_length;
        line("focal length along y", along_y, " mm  (all other figures are along x)");
    }
    line("f-number", paraxial.f_number(), "     (focal length / entrance pupil)");
    if let Some(stated) = lens.stated_f_number {
        line("", stated, "     (as the file states)");
    }
    if let Some(f_number) = RealRayFocus::new(lens).f_number() {
        line("f-number, marginal ray", f_number, "     (defines --fstop and the brightness)");
        let focused = focused(&lens.centred());
        let light = |nm: f64| AxialLight::of(focused.as_ref()?, nm);
        if let Some(axial) = light(wavelength) {
            let AxialLight { transmitted, unobstructed } = axial;
            let behind = match unobstructed < 1.0 {
                true => format!("{:.1} % obstructed; ", 100.0 * (1.0 - unobstructed)),
                false => String::new(),
            };
            let by = format!(
                "     ({behind}{:.1} % transmitted{}{})",
                100.0 * transmitted,
                coatings(lens),
                absorption(lens)
            );
            line("T-stop", axial.t_number(f_number), &by);
            let others = lens.design.wavelengths.iter().map(|line| line.nm);
            for nm in others.filter(|nm| *nm != wavelength) {
                let Some(axial) = light(nm) else { continue };
                let share = 100.0 * axial.transmitted;
                let by = format!("     (at {} nm: {share:.1} % transmitted)", rounded(nm));
                line("", axial.t_number(f_number), &by);
            }
        }
    }
    if let Some(fields) = fields(lens) {
        let _ = writeln!(text, "{:<28}{fields}  (as the file states)", "fields");
    }
    let mut line = |name: &str, value: f64, unit: &str| write_line(&mut text, name, value, unit);
    line("back focal distance", paraxial.back_focal_distance, " mm  (rear vertex to focus)");
    line("length", paraxial.length, " mm  (front to rear vertex)");
    line("entrance pupil position", paraxial.entrance_pupil.position, " mm  (behind front vertex)");
    line("entrance pupil diameter", paraxial.entrance_pupil.diameter, " mm");
    line("exit pupil position", paraxial.exit_pupil.position, " mm  (behind rear vertex)");
    line("exit pupil diameter", paraxial.exit_pupil.diameter, " mm");
    let film_for = |model: FocusModel, focus: f64| model.film(lens, focus, arguments.film_diagonal);
    let infinity = film_for(arguments.focus_model, f64::INFINITY);
    // Unknown figures are explained after the others.
    let mut missing = String::new();
    if let (Err(error), None) = (&infinity, groups_film) {
        missing = format!(
            "\nnot known: f-number of the marginal ray, T-stop, film distance for infinity:\n\
             {error}\n"
        );
    }
    let mut film = infinity.ok();
    if let Some(distance) = arguments.film_distance {
        film = Some(distance);
        let focus = paraxial.object_distance(distance);
        line("film distance", distance, " mm  (behind rear vertex)");
        if focus > 0.0 && focus.is_finite() {
            line("in focus", focus, " mm  (before front vertex)");
            line("", focus + lens.film_position(distance), " mm  (from the film)");
            if let Some(focus) = RealRayFocus::new(lens).object_distance(distance) {
                line("in focus, real rays", focus, " mm  (before front vertex)");
                line("", focus + lens.film_position(distance), " mm  (from the film)");
            }
        } else {
            line("in focus", f64::NAN, "");
            missing += "\nno real object is in focus: the film is too near to the lens\n";
        }
    }
    if let (Some(focus), Some(distance)) = (arguments.focus, groups_film) {
        line("focus", focus, " mm  (from the film; all figures are for the gaps of this focus)");
        line("film distance", distance, " mm  (behind rear vertex; the file moves groups instead)");
        film = arguments.film_distance.or(groups_film);
    } else if let Some(focus) = arguments.focus {
        line("focus", focus, " mm  (from the film)");
        let paraxial_film = paraxial.film_for_focus(focus);
        line("film distance", film_or_nan(paraxial_film)?, " mm  (behind rear vertex)");
        let [sharpest, pbrt] =
            [FocusModel::Sharpest, FocusModel::Pbrt].map(|model| film_for(model, focus));
        line(
            "film distance, real rays",
            film_or_nan(sharpest)?,
            " mm  (smallest spot on the axis)",
        );
        if let Ok(pbrt) = pbrt {
            line("film distance, pbrt-v4", pbrt, " mm  (--focus-model pbrt: its thick lens)");
        }
        if let (Ok(sharpest), Ok(pbrt)) = (sharpest, pbrt) {
            line("", pbrt - sharpest, " mm  (farther from the lens)");
        }
        let distance = match arguments.focus_model {
            FocusModel::Pbrt => pbrt,
            _ => sharpest,
        };
        film = arguments.film_distance.or(distance.ok());
        if let (Err(error), true) = (distance, missing.is_empty()) {
            let _ = write!(missing, "\nnot known: film distance for this focus:\n{error}\n");
        }
    }
    text += &missing;
    Ok(Summary { text, film })
}

/// Writes a figure, or a word for one that is not a number.
fn write_line(text: &mut String, name: &str, value: f64, unit: &str) {
    let word = match name.starts_with("focal length") && value.abs() >= Paraxial::AFOCAL {
        true => Some("afocal"),
        false if value.is_nan() => Some("none"),
        false if value.is_infinite() => Some("infinite"),
        false => None,
    };
    let _ = match word {
        Some(word) => writeln!(text, "{name:<28}{word:>12}"),
        None => writeln!(text, "{name:<28}{value:>12.4}{unit}"),
    };
}

/// Most field points in a line.
const FIELDS: usize = 6;

/// Lists the field points that the file states, if any.
fn fields(lens: &Prescription) -> Option<String> {
    let fields = lens.design.fields.as_ref()?;
    let (unit, what) = match fields.kind {
        FieldKind::Angle => ("deg", "field angle"),
        FieldKind::ObjectHeight => ("mm", "object height"),
        FieldKind::ImageHeight => ("mm", "image height"),
    };
    let mut distances: Vec<f64> = fields.points.iter().map(|[x, y]| x.hypot(*y)).collect();
    distances.sort_by(f64::total_cmp);
    distances.dedup();
    let largest = *distances.last()?;
    let words = match distances.len() <= FIELDS {
        true => distances.iter().map(|v| rounded(*v)).collect::<Vec<_>>().join(", "),
        false => format!("{} up to {}", distances.len(), rounded(largest)),
    };
    Some(format!("{words:>12} {unit}  {what}"))
}

/// Returns the film distance, or NaN if the lens forms no image.
///
/// # Errors
/// Returns an error if the focus distance is too near.
fn film_or_nan(film: Result<f64, FocusError>) -> Result<f64, FocusError> {
    match film {
        Err(error @ FocusError::TooNear { .. }) => Err(error),
        other => Ok(other.unwrap_or(f64::NAN)),
    }
}

/// Returns the lens with its film at the focus of infinity.
fn focused(lens: &Prescription) -> Option<RealLens> {
    let film = RealRayFocus::new(lens).film_distance(f64::INFINITY).ok()?;
    Some(RealLens::new(lens.clone(), film, 1.0, PupilSampling::Axis, 1.0, 0.0))
}

/// Says of how many glasses the absorption counts, if of any.
fn absorption(lens: &Prescription) -> String {
    match lens.rows.iter().filter(|row| row.glass.absorbs() && !row.mirror).count() {
        0 => String::new(),
        1 => "; absorption of 1 glass".to_owned(),
        count => format!("; absorption of {count} glasses"),
    }
}

/// Lists the coatings of a lens's glass-air surfaces, if there are any.
fn coatings(lens: &Prescription) -> String {
    let surfaces = (0..lens.rows.len()).filter(|&i| Coating::applies_to(lens.indices(i)));
    let mut counts: Vec<(&str, usize)> = Coating::NAMES.map(|name| (name, 0)).to_vec();
    for i in surfaces {
        let name = lens.rows[i].coating.as_ref().unwrap_or(&Coating::Bare).name();
        match counts.iter_mut().find(|(known, _)| *known == name) {
            Some((_, count)) => *count += 1,
            None => counts.push((name, 1)),
        }
    }
    let used = counts.iter().filter(|(_, count)| *count > 0);
    let words: Vec<String> = used.map(|(name, count)| format!("{name} on {count}")).collect();
    let assumed = if lens.assumed_coating { ", assumed" } else { "" };
    match words.is_empty() {
        true => String::new(),
        false => format!("; coatings: {}{assumed}", words.join(", ")),
    }
}
