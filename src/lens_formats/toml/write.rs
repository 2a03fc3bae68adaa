//! Writer of petzval's own lens files, in TOML.

use std::fmt::Write as _;

use super::aperture;
use super::coating;
use super::design::{FIELD_KINDS, QUANTITIES};
use super::formula;
use petzval_lens::Design;
use petzval_lens::Iris;
use petzval_lens::Pose;
use petzval_lens::{Prescription, Row, TransverseAxis};
use petzval_spectrum::{Glass, GlassLibrary};

/// Writes a lens so that reading it gives the same lens, with every digit. Notes of its design are
/// not part of it, and pictures of apertures are named only.
pub fn to_toml(lens: &Prescription) -> String {
    let mut text = String::new();
    string(&mut text, "name", &lens.name);
    if let Some(source) = &lens.source {
        string(&mut text, "source", source);
    }
    optional(&mut text, "focal_length", lens.stated_focal_length);
    optional(&mut text, "f_number", lens.stated_f_number);
    design(&lens.design, &mut text);
    let library = GlassLibrary::built_in();
    coating::write(lens, &library, &mut text);
    let mut before = Row::default();
    for row in &lens.rows {
        surface(row, &before, &library, &mut text);
        before = row.clone();
    }
    for body in &lens.tilt_decenters {
        let [first, last] = body.rows.map(|row| row + 1);
        let _ = write!(text, "\n[[askew]]\nsurfaces = [{first}, {last}]\n");
        pose(&body.pose, &mut text);
    }
    for axis in &lens.breaks {
        let origin = axis.transform.translation.to_array();
        let axes = axis.transform.matrix3.to_cols_array_2d();
        let _ = write!(text, "\n[[break]]\nsurface = {}\n", axis.row + 1);
        let _ = write!(text, "decentre = {origin:?}\naxes = {axes:?}\n");
    }
    configurations(&lens.design, &mut text);
    text
}

/// Writes a key and a string, escaped.
pub(super) fn string(text: &mut String, key: &str, value: &str) {
    let escape = |c: char| match c {
        '"' | '\\' => format!("\\{c}"),
        c if c.is_control() => format!("\\u{:04X}", u32::from(c)),
        c => c.to_string(),
    };
    let escaped: String = value.chars().map(escape).collect();
    let _ = writeln!(text, "{key} = \"{escaped}\"");
}

fn optional(text: &mut String, key: &str, value: Option<f64>) {
    if let Some(value) = value {
        let _ = writeln!(text, "{key} = {value:?}");
    }
}

/// Writes a number unless it is the default of its key.
fn unless(text: &mut String, key: &str, value: f64, default: f64) {
    if value != default {
        let _ = writeln!(text, "{key} = {value:?}");
    }
}

fn design(design: &Design, text: &mut String) {
    if !design.wavelengths.is_empty() {
        let lines: Vec<[f64; 2]> =
            design.wavelengths.iter().map(|line| [line.nm, line.weight]).collect();
        let _ = writeln!(text, "wavelengths = {lines:?}\nprimary = {}", design.primary + 1);
    }
    optional(text, "object_distance", design.object_distance);
    optional(text, "film_distance", design.film_distance);
    if let Some(fields) = &design.fields {
        let kind = FIELD_KINDS.iter().find(|(_, kind)| *kind == fields.kind);
        let kind = kind.map_or("angle", |(name, _)| name);
        let points = &fields.points;
        let _ = write!(text, "\n[[fields]]\nkind = {kind:?}\npoints = {points:?}\n");
    }
}

fn configurations(design: &Design, text: &mut String) {
    for state in &design.configurations {
        text.push_str("\n[[configuration]]\n");
        if !state.name.is_empty() {
            string(text, "name", &state.name);
        }
        optional(text, "focal_length", state.focal_length);
        optional(text, "f_number", state.f_number);
        optional(text, "object_distance", state.object_distance);
        optional(text, "magnification", state.magnification);
        optional(text, "film_distance", state.film_distance);
        for (key, quantity) in QUANTITIES {
            let of_kind = state.settings.iter().filter(|setting| setting.quantity == quantity);
            let values: Vec<String> =
                of_kind.map(|s| format!("[{}, {:?}]", s.row + 1, s.value)).collect();
            if !values.is_empty() {
                let _ = writeln!(text, "{key} = [{}]", values.join(", "));
            }
        }
    }
}

fn pose(pose: &Pose, text: &mut String) {
    if pose.decentre != [0.0; 2] {
        let _ = writeln!(text, "decentre = {:?}", pose.decentre);
    }
    if pose.tilt != [0.0; 2] {
        let _ = writeln!(text, "tilt = {:?}", pose.tilt);
    }
}

fn surface(row: &Row, before: &Row, library: &GlassLibrary, text: &mut String) {
    text.push_str("\n[[surface]]\n");
    unless(text, "radius", row.radius, f64::INFINITY);
    unless(text, "conic", row.conic, 0.0);
    if !row.asphere.is_empty() {
        let terms: Vec<String> =
            row.asphere.iter().map(|(power, a)| format!("[{power}, {a:?}]")).collect();
        let _ = writeln!(text, "asphere = [{}]", terms.join(", "));
    }
    if let Some(axis) = row.axis {
        string(text, "axis", if axis == TransverseAxis::X { "x" } else { "y" });
    }
    if let Some([x, y]) = row.ideal {
        let [x, y] = [x, y].map(|m| [m.a, m.b, m.c, m.d]);
        let _ = writeln!(text, "ideal = [{x:?}, {y:?}]");
    }
    unless(text, "thickness", row.thickness, 0.0);
    let _ = writeln!(text, "diameter = {:?}", row.diameter);
    unless(text, "obstruction", row.obstruction, 0.0);
    aperture::write(&row.apertures, text);
    if row.stop {
        text.push_str("stop = true\n");
    }
    match &row.iris {
        Iris::Round => {}
        Iris::Blades { count, rotation, curvature } => {
            let _ = writeln!(text, "blades = {count}");
            unless(text, "rotation", *rotation, 0.0);
            unless(text, "curvature", *curvature, 0.0);
        }
        Iris::Mask(mask) => string(text, "aperture", &mask.name),
    }
    if let Some(coating) = &row.coating {
        string(text, "coating", coating.name());
    }
    pose(&row.pose, text);
    if row.mirror {
        text.push_str("mirror = true\n");
        return;
    }
    medium(row, before, library, text);
}

/// Writes the medium behind a row.
pub(super) fn medium(row: &Row, before: &Row, library: &GlassLibrary, text: &mut String) {
    match &row.glass {
        // A plane stop without a medium would be inside the one before it.
        Glass::Constant if row.index != 1.0 || row.stop && before.index != 1.0 => {
            let _ = writeln!(text, "index = {:?}", row.index);
        }
        Glass::Constant => {}
        Glass::Abbe { nd, vd } => {
            let _ = writeln!(text, "index = {nd:?}\nabbe = {vd:?}");
        }
        Glass::Table(entries) => {
            let _ = writeln!(text, "index = {entries:?}");
        }
        Glass::Catalogue(glass) => {
            let name = glass.full_name();
            match library.find(&name, &[]) {
                Some(found) if found.glass == row.glass => string(text, "glass", &name),
                _ => formula::write(glass, text),
            }
        }
    }
}
