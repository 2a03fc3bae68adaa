//! Parsers of tolerances.

use std::path::Path;

use petzval_optics::{DeviationShape, RadiusLimit, ToleranceGrade};

use super::sample::Criterion;
use crate::cli::Failure;
use crate::cli::arguments::values;

/// Largest tolerance of a radius or an Abbe number (percent).
const MOST_PERCENT: f64 = 20.0;
/// Largest tolerance of a length (mm).
const MOST_LENGTH: f64 = 10.0;
/// Largest tolerance of an angle (arc minutes).
const MOST_ANGLE: f64 = 600.0;

/// Parses a number from 0 to a limit; "off" is 0.
fn within(text: &str, most: f64, expected: &str) -> Result<f64, String> {
    if text == "off" {
        return Ok(0.0);
    }
    let number = text.trim().parse().ok().filter(|number| (0.0..=most).contains(number));
    number.ok_or_else(|| format!("expected {expected}"))
}

pub(super) fn radius(text: &str) -> Result<RadiusLimit, String> {
    let expected = "a percentage up to 20 (0.1%), fringes up to 1000 (3fr) or off";
    if let Some(number) = text.strip_suffix("fr") {
        return within(number, 1000.0, expected).map(RadiusLimit::Fringes);
    }
    match (text, text.strip_suffix('%')) {
        ("off", _) => Ok(RadiusLimit::Percent(0.0)),
        (_, Some(number)) => within(number, MOST_PERCENT, expected).map(RadiusLimit::Percent),
        _ => Err(format!("expected {expected}")),
    }
}

pub(super) fn percent(text: &str) -> Result<f64, String> {
    let expected = "a percentage up to 20, such as 0.5%, or off";
    match (text, text.strip_suffix('%')) {
        ("off", _) => Ok(0.0),
        (_, Some(number)) => within(number, MOST_PERCENT, expected),
        _ => Err(format!("expected {expected}")),
    }
}

/// Parses a length (mm) with its unit or without.
pub(super) fn length(text: &str) -> Result<f64, String> {
    let expected = "a length up to 10 mm, such as 0.02 or 20um (a number alone is in mm), or off";
    match values::length(text) {
        Ok(length) if length <= MOST_LENGTH => Ok(length),
        Ok(_) => Err(format!("expected {expected}")),
        Err(_) => within(text, MOST_LENGTH, expected),
    }
}

pub(super) fn index(text: &str) -> Result<f64, String> {
    within(text, 0.1, "an error of the index up to 0.1, such as 5e-4, or off")
}

/// Parses an angle; the result is in arc minutes.
pub(super) fn angle(text: &str) -> Result<f64, String> {
    let expected = "an angle up to 10 degrees with its unit, such as 1', 30\" or 0.02deg, or off";
    let units =
        [("'", 1.0), ("arcmin", 1.0), ("\"", 1.0 / 60.0), ("arcsec", 1.0 / 60.0), ("deg", 60.0)];
    if text == "off" || text == "0" {
        return Ok(0.0);
    }
    for (unit, minutes) in units {
        if let Some(number) = text.strip_suffix(unit) {
            return Ok(minutes * within(number, MOST_ANGLE / minutes, expected)?);
        }
    }
    Err(format!("expected {expected}"))
}

pub(super) fn grade(text: &str) -> Result<ToleranceGrade, String> {
    let found = ToleranceGrade::NAMES.iter().find(|(name, _)| *name == text);
    found.map(|(_, grade)| *grade).ok_or_else(|| {
        let names = ToleranceGrade::NAMES.map(|(name, _)| name);
        format!("expected one of {}", names.join(", "))
    })
}

pub(super) fn shape(text: &str) -> Result<DeviationShape, String> {
    match text {
        "normal" => Ok(DeviationShape::Normal),
        "uniform" => Ok(DeviationShape::Uniform),
        "extremes" => Ok(DeviationShape::Extremes),
        _ => Err("expected normal, uniform or extremes".to_owned()),
    }
}

pub(super) fn criterion(text: &str) -> Result<Criterion, String> {
    match text {
        "spot" => Ok(Criterion::Spot),
        "mtf" => Ok(Criterion::Modulation),
        _ => Err("expected spot or mtf".to_owned()),
    }
}

/// Checks that a lens file has a name of the only format that holds tilts.
pub(in crate::cli::lens) fn check_toml(path: &Path) -> Result<(), Failure> {
    match path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml")) {
        true => Ok(()),
        false => Err(format!(
            "--output {}: the lens is written as TOML; name the file {}",
            path.display(),
            path.with_extension("toml").display()
        )
        .into()),
    }
}
