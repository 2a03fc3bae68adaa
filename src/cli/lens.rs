//! `petzval lens`

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

use petzval::image::replace;
use petzval::lens::{
    Aim, Axis, Coating, D_LINE, Focus, FocusError, FocusModel, Paraxial, Prescription, RealLens,
    draw, read,
};
use petzval::source::reading;

use super::outputs::{check_distinct, check_writable};
use super::{Failure, LensArguments, Outcome};

pub(super) fn run(arguments: &LensArguments) -> Result<Outcome, Failure> {
    let file = arguments.lens.as_deref().ok_or("name a lens file")?;
    if let Some(drawing) = &arguments.draw {
        svg(drawing)?;
    }
    let (lens, files) = reading(|| read(file));
    let mut lens = lens?;
    warn(file, &lens, [D_LINE; 2]);
    for (option, output) in [("--draw", &arguments.draw), ("--psf", &arguments.psf)] {
        if let Some(output) = output {
            check_distinct([output], option, &files)?;
            check_writable(output, option)?;
        }
    }
    lens.coat(arguments.coating);
    let opening = lens.rows[lens.stop()].diameter;
    if let Some(stop) = arguments.stop {
        if stop > opening {
            return Err(format!("--stop {stop}: expected at most {opening} mm").into());
        }
        lens.stop_down(stop);
    }
    let paraxial = Paraxial::of(&lens);
    let mut text = format!("{}\n{lens}\n", lens.name);
    if lens.is_askew() {
        text += "All figures below are of the lens with its parts square.\n\n";
    }
    let mut line = |name: &str, value: f64, unit: &str| {
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
    };
    let known = match lens.is_monochromatic() {
        true => " nm  (all indices; the file says nothing of dispersion)",
        false => " nm  (the d line, at which all figures hold)",
    };
    line("wavelength", D_LINE, known);
    line("focal length", paraxial.focal_length, " mm");
    if let Some(stated) = lens.stated_focal_length {
        line("", stated, " mm  (as the file states)");
    }
    if lens.rows.iter().any(|row| row.axis.is_some()) {
        let along_y = Paraxial::in_plane(&lens, Axis::Y).focal_length;
        line("focal length along y", along_y, " mm  (all else is along x)");
    }
    line("f-number", paraxial.f_number(), "     (focal length / entrance pupil)");
    if let Some(stated) = lens.stated_f_number {
        line("", stated, "     (as the file states)");
    }
    if let Some(f_number) = Focus::of(&lens).f_number() {
        line("f-number, marginal ray", f_number, "     (what --fstop and brightness go by)");
        if let Some(share) = axial_transmittance(&lens.centred()) {
            let by = format!("     ({:.1} % comes through; {})", 100.0 * share, coatings(&lens));
            line("T-stop", f_number / share.sqrt(), &by);
        }
    }
    line("back focal distance", paraxial.back_focal_distance, " mm  (rear vertex to focus)");
    line("length", paraxial.length, " mm  (front to rear vertex)");
    line("entrance pupil position", paraxial.entrance_pupil.position, " mm  (behind front vertex)");
    line("entrance pupil diameter", paraxial.entrance_pupil.diameter, " mm");
    line("exit pupil position", paraxial.exit_pupil.position, " mm  (behind rear vertex)");
    line("exit pupil diameter", paraxial.exit_pupil.diameter, " mm");
    let stands = |model: FocusModel, focus: f64| model.film(&lens, focus, arguments.film_diagonal);
    let infinity = stands(arguments.focus_model, f64::INFINITY);
    // What is not known is said behind the numbers.
    let mut missing = String::new();
    if let Err(error) = &infinity {
        let _ = write!(
            missing,
            "\nnot known: f-number of the marginal ray, T-stop, film distance for infinity:\n{error}\n"
        );
    }
    let mut film = infinity.ok();
    if let Some(distance) = arguments.film_distance {
        film = Some(distance);
        let focus = paraxial.focus_of_film(distance);
        line("film distance", distance, " mm  (behind rear vertex)");
        if focus > 0.0 && focus.is_finite() {
            line("in focus", focus, " mm  (before front vertex)");
            line("", focus + paraxial.length + distance, " mm  (from the film)");
            if let Some(focus) = Focus::of(&lens).object(distance) {
                line("in focus, real rays", focus, " mm  (before front vertex)");
                line("", focus + paraxial.length + distance, " mm  (from the film)");
            }
        } else {
            line("in focus", f64::NAN, "");
            missing += "\nnothing real is in focus: the film is too near to the lens\n";
        }
    }
    if let Some(focus) = arguments.focus {
        line("focus", focus, " mm  (from the film)");
        let paraxial_film = paraxial.film_for_focus(focus);
        line("film distance", possible(paraxial_film)?, " mm  (behind rear vertex)");
        let [sharpest, pbrt] =
            [FocusModel::Sharpest, FocusModel::Pbrt].map(|model| stands(model, focus));
        line("film distance, real rays", possible(sharpest)?, " mm  (smallest spot on the axis)");
        if let Ok(pbrt) = pbrt {
            line("film distance, pbrt-v4", pbrt, " mm  (--focus-model pbrt: its thick lens)");
        }
        if let (Ok(sharpest), Ok(pbrt)) = (sharpest, pbrt) {
            line("", pbrt - sharpest, " mm  (farther from the lens)");
        }
        let distance = stands(arguments.focus_model, focus);
        film = arguments.film_distance.or(distance.ok());
        if let (Err(error), true) = (distance, missing.is_empty()) {
            let _ = write!(missing, "\nnot known: film distance for this focus:\n{error}\n");
        }
    }
    text += &missing;
    if let Some(drawing) = &arguments.draw {
        write(drawing, &lens, film, arguments.film_diagonal / 2.0)?;
    }
    if arguments.vignetting {
        let film = film.ok_or_else(|| no_film("--vignetting"))?;
        text = super::vignetting::table(&lens, film, arguments.film_diagonal)?;
    }
    if let Some(path) = &arguments.psf {
        let film = film.ok_or_else(|| no_film("--psf"))?;
        text += &super::psf::draw(path, &lens, film, arguments.at)?;
    }
    super::print(&text)
}

/// Warns of glass whose data do not cover light from the first to the second wavelength, nm.
pub(super) fn warn(file: &Path, lens: &Prescription, used: [f64; 2]) {
    for doubt in lens.doubtful_indices(used) {
        say!("petzval: warning: {}: {doubt}", file.display());
    }
}

fn no_film(option: &str) -> String {
    format!(
        "{option}: the lens forms no real image of distant things; say where the film stands with \
         --film-distance"
    )
}

/// Where the film stands; no number where the lens forms no image. A distance that is too near is an
/// error.
fn possible(film: Result<f64, FocusError>) -> Result<f64, FocusError> {
    match film {
        Err(error @ FocusError::TooNear { .. }) => Err(error),
        other => Ok(other.unwrap_or(f64::NAN)),
    }
}

/// The share of light that comes to the middle of the film, focused at infinity, of what would
/// if surfaces reflected nothing: as a mean over the pupil.
fn axial_transmittance(lens: &Prescription) -> Option<f64> {
    let film = Focus::of(lens).film(f64::INFINITY).ok()?;
    RealLens::new(lens.clone(), film, 1.0, Aim::Pupil, 1.0, 0.0).transmittance([0.0; 2])
}

/// What the faces of a lens are coated with, in words.
fn coatings(lens: &Prescription) -> String {
    let faces = (0..lens.rows.len()).filter(|&i| Coating::fits(lens.indices(i)));
    let mut counts = [0; Coating::NAMES.len()];
    faces.for_each(|i| counts[lens.rows[i].coating.unwrap_or_default() as usize] += 1);
    let worn = counts.iter().zip(Coating::NAMES).filter(|(count, _)| **count > 0);
    let words: Vec<String> = worn.map(|(count, name)| format!("{name} on {count}")).collect();
    format!("coatings: {}", words.join(", "))
}

/// Whether a drawing can have this name.
fn svg(path: &Path) -> Result<(), Failure> {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    match extension.as_str() {
        "svg" => Ok(()),
        _ => Err(format!(
            "--draw {}: drawings are SVG; name the file {}",
            path.display(),
            path.with_extension("svg").display()
        )
        .into()),
    }
}

fn write(
    path: &Path,
    lens: &Prescription,
    film: Option<f64>,
    film_radius: f64,
) -> Result<(), Failure> {
    let text = draw(lens, film, film_radius);
    replace(path, |file| file.write_all(text.as_bytes()))
        .map_err(|error| format!("cannot write the drawing {}: {error}", path.display()))?;
    if film.is_none() {
        say!("petzval: the lens forms no real image: {} has no film and no rays", path.display());
    }
    Ok(())
}
