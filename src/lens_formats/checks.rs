//! Checks of the figures of a surface, shared by the readers of foreign formats.

use super::report::ReadReport;
use super::{MAX_POWER, MIN_RADIUS};
use petzval_lens::system::MediumBehind;
use petzval_lens::{MAX_INDEX, MIN_INDEX};
use petzval_spectrum::Glass;

/// Largest radius of a surface that is curved (mm): files write planes as 1e5 and more, and beyond
/// 1e12 mm the sag of a metre is less than an atom.
const PLANE_RADIUS: f64 = 1e12;

/// Range of Abbe numbers that describe a glass.
const ABBE: std::ops::RangeInclusive<f64> = 5.0..=200.0;

/// Difference of two indices that are meant to be the same glass, if both have five decimals.
const SAME_INDEX: f64 = 1e-4;

/// Radius of curvature of a row: infinite for 0 and for planes.
///
/// # Errors
/// Returns a sentence if it is too small.
pub(super) fn radius(value: f64) -> Result<f64, String> {
    match value {
        value if value == 0.0 || value.abs() > PLANE_RADIUS => Ok(f64::INFINITY),
        value if value.abs() < MIN_RADIUS || value.is_nan() => Err(format!("radius {value:e}")),
        value => Ok(value),
    }
}

/// Curvature as a radius.
///
/// # Errors
/// Returns a sentence if the radius is too small.
pub(super) fn radius_of_curvature(curvature: f64) -> Result<f64, String> {
    if curvature == 0.0 { Ok(f64::INFINITY) } else { radius(curvature.recip()) }
}

/// Even powers from `first` on with those coefficients that are not 0.
///
/// # Errors
/// Returns a sentence if a power is beyond 30.
pub(super) fn even_powers(first: u32, coefficients: &[f64]) -> Result<Vec<(u32, f64)>, String> {
    powers((first..).step_by(2).zip(coefficients.iter().copied()))
}

/// Powers with those coefficients that are not 0.
///
/// # Errors
/// Returns a sentence if a power is below 2 or beyond 30.
pub(super) fn powers(
    terms: impl IntoIterator<Item = (u32, f64)>,
) -> Result<Vec<(u32, f64)>, String> {
    let terms: Vec<(u32, f64)> = terms.into_iter().filter(|&(_, value)| value != 0.0).collect();
    match terms.iter().find(|(power, _)| !(2..=MAX_POWER).contains(power)) {
        Some((power, _)) => Err(format!("a coefficient of the power {power}")),
        None => Ok(terms),
    }
}

/// Medium of a stated index, Abbe number and glass name, as far as they are stated. The name counts if
/// nothing else is stated, or if the glass has the stated index: catalogues know the dispersion better
/// than one Abbe number. Index 0 means air, and a negative index a mirror.
///
/// # Errors
/// Returns a sentence if no index is stated and the glass is unknown, or if the index is not one.
pub(super) fn medium(
    index: Option<f64>,
    abbe: Option<f64>,
    name: &str,
    report: &mut ReadReport<'_>,
) -> Result<MediumBehind, String> {
    let name = name.trim();
    let lower = name.to_ascii_lowercase();
    let is_air = ["air", "vacuum", "occluder", "iris"].contains(&lower.as_str());
    match index {
        Some(index) if index == 0.0 || index == 1.0 => return Ok(MediumBehind::Air),
        Some(index) if (-MAX_INDEX..=-1.0).contains(&index) => return Ok(MediumBehind::Mirror),
        Some(index) if !(MIN_INDEX..=MAX_INDEX).contains(&index) => {
            return Err(format!("index {index}"));
        }
        None if is_air || name.is_empty() => return Ok(MediumBehind::Air),
        _ => {}
    }
    if index.is_none()
        && let Some(model) = numbers_of(name)
    {
        return medium(Some(model.0), model.1, "", report);
    }
    let unnamed = ["", "unknown", "abbe", "air", "iris", "n/a", "-"].contains(&lower.as_str());
    let found = match unnamed {
        true => None,
        false => report.glasses().map_err(|error| error.to_string())?.resolve(name, &[]),
    };
    let Some(index) = index else {
        if let Some(fault) = report.glasses().ok().and_then(|library| library.fault(name)) {
            return Err(format!("the glass \"{name}\", which cannot be used: {fault}"));
        }
        let found = found.ok_or_else(|| format!("an unknown glass \"{name}\""))?;
        let glass = found.glass.clone();
        found.warnings().for_each(|warning| report.note(warning));
        return Ok(MediumBehind::Glass(glass));
    };
    // Three decimals are common in textbooks.
    let rounded = ((index * 1e3).round() - index * 1e3).abs() < 1e-6;
    let tolerance = if rounded { 6e-4 } else { SAME_INDEX };
    if let Some(found) = found
        && found.substitution.is_none()
        && (found.glass.nd() - index).abs() <= tolerance
    {
        let nd = found.glass.nd();
        if (nd - index).abs() > SAME_INDEX {
            report.note(format!(
                "the index {index} of {name} is taken as rounded: {nd:.5} of {} is used",
                found.glass
            ));
        }
        return Ok(MediumBehind::Glass(found.glass));
    }
    Ok(match abbe {
        Some(vd) if ABBE.contains(&vd) => MediumBehind::Glass(Glass::Abbe { nd: index, vd }),
        _ => MediumBehind::Index(index),
    })
}

/// Index and Abbe number of "1.5168/64.17" and "1.5168:64.17", or the index alone.
fn numbers_of(name: &str) -> Option<(f64, Option<f64>)> {
    let mut parts = name.split(['/', ':']).map(|part| part.trim().parse::<f64>().ok());
    let index = parts.next()??;
    let abbe = match parts.next() {
        Some(abbe) => Some(abbe?),
        None => None,
    };
    ((1.0..=MAX_INDEX).contains(&index) && parts.next().is_none()).then_some((index, abbe))
}

#[cfg(test)]
mod tests {
    use super::*;
    use petzval_base::io::ReadContext;

    fn of(index: Option<f64>, abbe: Option<f64>, name: &str) -> Result<MediumBehind, String> {
        medium(index, abbe, name, &mut ReadReport::new(&ReadContext::default()))
    }

    #[test]
    fn stated_numbers_count_more_than_an_unknown_or_other_glass() {
        let is_model = |medium, nd: f64, vd: f64| matches!(medium, Ok(MediumBehind::Glass(Glass::Abbe { nd: n, vd: v })) if n == nd && v == vd);
        assert!(is_model(of(Some(1.6), Some(40.0), "XYZ"), 1.6, 40.0));
        assert!(is_model(of(Some(1.6), Some(40.0), "N-BK7"), 1.6, 40.0));
        assert!(is_model(of(None, None, "1.83481/42.7"), 1.83481, 42.7));
        let known = of(Some(1.5168), Some(64.2), "N-BK7");
        assert!(matches!(known, Ok(MediumBehind::Glass(Glass::Catalogue(_)))));
        assert!(of(None, None, "no such glass").is_err());
        assert!(of(Some(0.5), None, "").is_err() && of(Some(f64::NAN), None, "").is_err());
        assert!(matches!(of(Some(0.0), Some(30.0), "x"), Ok(MediumBehind::Air)));
    }
}
