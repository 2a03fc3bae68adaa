//! Apertures of a surface: the tables of `apertures`.

use std::fmt::Write as _;

use super::value::Section;
use petzval_base::io::excerpt;
use petzval_lens::LensError;
use petzval_lens::{ApertureForm, SurfaceAperture};

/// Greatest number of apertures of one surface.
const MAX_APERTURES: usize = 16;

/// Names of the forms.
const FORMS: [(&str, ApertureForm); 2] =
    [("rectangle", ApertureForm::Rectangle), ("ellipse", ApertureForm::Ellipse)];

/// Reads the apertures of a surface.
pub(super) fn read(section: &Section) -> Result<Vec<SurfaceAperture>, LensError> {
    let expected = "expected apertures = [{ shape = \"rectangle\", half_widths = [x, y] }]";
    let tables = section.tables("apertures", expected)?;
    if tables.len() > MAX_APERTURES {
        let found = format!("{} apertures of one surface", tables.len());
        return Err(section.error("apertures", found, format!("expected {MAX_APERTURES} at most")));
    }
    tables.iter().map(one).collect()
}

fn one(section: &Section) -> Result<SurfaceAperture, LensError> {
    section.reject_unknown_keys(&["shape", "half_widths", "centre", "rotation", "obscures"])?;
    let expected = "expected shape = \"rectangle\" or \"ellipse\"";
    let Some(name) = section.string("shape")? else {
        return Err(section.error("shape", "an aperture without a shape", expected));
    };
    let Some(&(_, form)) = FORMS.iter().find(|(known, _)| *known == name) else {
        let found = format!("shape is \"{}\"", excerpt(name));
        return Err(section.error("shape", found, expected));
    };
    let expected = "expected half_widths = [x, y], each from 1e-9 to 1e9 mm";
    let Some((_, half_widths)) = section.number_pair("half_widths", expected)? else {
        return Err(section.error("half_widths", "an aperture without half_widths", expected));
    };
    if let Some(half) = half_widths.iter().find(|half| !(1e-9..=1e9).contains(*half)) {
        return Err(section.error("half_widths", format!("a half-width of {half} mm"), expected));
    }
    let expected = "expected centre = [x, y], each from -1e9 to 1e9 mm";
    let centre = section.number_pair("centre", expected)?.map_or([0.0; 2], |(_, centre)| centre);
    if let Some(place) = centre.iter().find(|place| place.abs() > 1e9) {
        return Err(section.error("centre", format!("a centre at {place} mm"), expected));
    }
    let expected = "expected a rotation from -360 to 360 degrees";
    let rotation = section.number("rotation")?.unwrap_or(0.0);
    if rotation.abs() > 360.0 {
        return Err(section.error("rotation", format!("a rotation of {rotation}"), expected));
    }
    let obscures = section.boolean("obscures")?;
    Ok(SurfaceAperture { form, half_widths, centre, rotation, obscures })
}

/// Writes the apertures of a surface.
pub(super) fn write(apertures: &[SurfaceAperture], text: &mut String) {
    if apertures.is_empty() {
        return;
    }
    text.push_str("apertures = [\n");
    for SurfaceAperture { form, half_widths, centre, rotation, obscures } in apertures {
        let name =
            FORMS.iter().find(|(_, known)| known == form).map_or("ellipse", |(name, _)| name);
        let _ = write!(text, "    {{ shape = {name:?}, half_widths = {half_widths:?}");
        if *centre != [0.0; 2] {
            let _ = write!(text, ", centre = {centre:?}");
        }
        if *rotation != 0.0 {
            let _ = write!(text, ", rotation = {rotation:?}");
        }
        text.push_str(if *obscures { ", obscures = true },\n" } else { " },\n" });
    }
    text.push_str("]\n");
}
