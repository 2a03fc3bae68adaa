//! Use of the lens: wavelengths, fields, object, film, configurations.

use super::value::Section;
use petzval_lens::LensError;
use petzval_lens::{Configuration, Design, FieldKind, Fields, Quantity, Setting, SpectralLine};

/// Keys of the top level that this module reads.
pub(super) const KEYS: [&str; 6] =
    ["wavelengths", "primary", "fields", "object_distance", "film_distance", "configuration"];

/// Names of the kinds of fields.
pub(super) const FIELD_KINDS: [(&str, FieldKind); 3] = [
    ("angle", FieldKind::Angle),
    ("object height", FieldKind::ObjectHeight),
    ("image height", FieldKind::ImageHeight),
];

/// Keys of the quantities that a configuration changes.
pub(super) const QUANTITIES: [(&str, Quantity); 3] = [
    ("thickness", Quantity::Thickness),
    ("curvature", Quantity::Curvature),
    ("diameter", Quantity::Diameter),
];

/// Reads the design data of a lens with this number of surfaces.
pub(super) fn read(top: &Section, count: usize) -> Result<Design, LensError> {
    let mut wavelengths = Vec::new();
    for (at, [nm, weight]) in top.number_pairs("wavelengths", "[[nm, weight], ...]")? {
        if nm <= 0.0 || weight < 0.0 {
            let found = format!("wavelength {nm} of weight {weight}");
            let expected = "expected nm above 0 and a weight of 0 or more";
            return Err(top.source.error_at(at, found, expected));
        }
        wavelengths.push(SpectralLine { nm, weight });
    }
    let primary = match top.finite("primary")? {
        None => 0,
        Some(n) if n.fract() == 0.0 && n >= 1.0 && n <= wavelengths.len() as f64 => n as usize - 1,
        Some(n) => {
            let expected = format!("expected 1 to {}, of wavelengths", wavelengths.len());
            return Err(top.error("primary", format!("primary is {n}"), expected));
        }
    };
    let expected = "expected [[configuration]] with name, film_distance, thickness = [[surface, \
                    mm], ...]";
    let configurations = top.tables("configuration", expected)?;
    Ok(Design {
        wavelengths,
        primary,
        fields: fields(top)?,
        object_distance: top.number("object_distance")?,
        film_distance: top.finite("film_distance")?,
        configurations: configurations
            .iter()
            .map(|section| configuration(section, count))
            .collect::<Result<_, _>>()?,
        notes: Vec::new(),
    })
}

fn fields(top: &Section) -> Result<Option<Fields>, LensError> {
    let expected = "expected [[fields]] with kind and points = [[x, y], ...], once";
    let sections = top.tables("fields", expected)?;
    let [section] = &sections[..] else {
        return match sections.is_empty() {
            true => Ok(None),
            false => Err(top.error("fields", "several tables of fields", expected)),
        };
    };
    section.reject_unknown_keys(&["kind", "points"])?;
    let name = section.string("kind")?.unwrap_or("angle");
    let Some((_, kind)) = FIELD_KINDS.iter().find(|(known, _)| *known == name) else {
        let names = FIELD_KINDS.map(|(known, _)| known).join(", ");
        return Err(section.error("kind", "an unknown kind", format!("expected {names}")));
    };
    let points = section.number_pairs("points", "[[x, y], ...]")?;
    Ok(Some(Fields { kind: *kind, points: points.into_iter().map(|(_, point)| point).collect() }))
}

fn configuration(section: &Section, count: usize) -> Result<Configuration, LensError> {
    let mut known = vec![
        "name",
        "focal_length",
        "f_number",
        "object_distance",
        "magnification",
        "film_distance",
    ];
    known.extend(QUANTITIES.map(|(key, _)| key));
    section.reject_unknown_keys(&known)?;
    let mut settings = Vec::new();
    for (key, quantity) in QUANTITIES {
        for (at, [row, value]) in section.number_pairs(key, "[[surface, value], ...]")? {
            if row.fract() != 0.0 || !(1.0..=count as f64).contains(&row) {
                let expected = format!("expected the number of a surface, 1 to {count}");
                return Err(section.source.error_at(at, format!("surface {row}"), expected));
            }
            settings.push(Setting { row: row as usize - 1, quantity, value });
        }
    }
    Ok(Configuration {
        name: section.string("name")?.unwrap_or_default().to_owned(),
        focal_length: section.finite("focal_length")?,
        f_number: section.finite("f_number")?,
        object_distance: section.number("object_distance")?,
        magnification: section.finite("magnification")?,
        film_distance: section.finite("film_distance")?,
        settings,
    })
}
