//! Tilt and decentre: the keys `decentre` and `tilt`, and the tables under `[[askew]]`.

use toml::de::DeValue;

use super::value::Section;
use crate::lens::prescription::error::LensError;
use crate::lens::prescription::pose::{MAX_DECENTRE, MAX_TILT, Pose, TiltDecenter};

/// Largest number of tilted or decentred groups.
const MAX_GROUPS: usize = 256;

/// Reads the pose of a surface or of a group.
pub(super) fn read(section: &Section) -> Result<Pose, LensError> {
    let within = |key: &str, most: f64, unit: &str| -> Result<[f64; 2], LensError> {
        let expected = format!("expected [x, y], each from -{most} to {most} {unit}");
        let Some((at, pair)) = section.number_pair(key, &expected)? else { return Ok([0.0; 2]) };
        match pair.iter().find(|number| !(-most..=most).contains(*number)) {
            Some(number) => {
                Err(section.source.error_at(at, format!("{key} holds {number}"), expected))
            }
            None => Ok(pair),
        }
    };
    Ok(Pose {
        decentre: within("decentre", MAX_DECENTRE, "mm")?,
        tilt: within("tilt", MAX_TILT, "degrees")?,
    })
}

/// Reads the tilted or decentred groups of a lens with this number of surfaces.
pub(super) fn tilt_decenters(top: &Section, count: usize) -> Result<Vec<TiltDecenter>, LensError> {
    if !top.has("askew") {
        return Ok(Vec::new());
    }
    let expected = "expected [[askew]] with surfaces = [first, last] and decentre or tilt";
    let Some(array) = top.array("askew") else {
        return Err(top.error("askew", "askew is not a list", expected));
    };
    if array.len() > MAX_GROUPS {
        let found = format!("{} entries of askew", array.len());
        return Err(top.error("askew", found, format!("expected at most {MAX_GROUPS}")));
    }
    let body = |entry: &'_ toml::Spanned<DeValue<'_>>| -> Result<TiltDecenter, LensError> {
        let at = entry.span().start;
        let DeValue::Table(table) = entry.get_ref() else {
            return Err(top.source.error_at(at, "an entry of askew without keys", expected));
        };
        let section = Section { source: top.source, at, table };
        section.reject_unknown_keys(&["surfaces", "decentre", "tilt"])?;
        Ok(TiltDecenter { rows: rows(&section, count)?, pose: read(&section)? })
    };
    array.iter().map(body).collect()
}

/// Reads the first and the last row of a group. The result counts from 0, the file from 1.
fn rows(section: &Section, count: usize) -> Result<[usize; 2], LensError> {
    let expected =
        format!("expected surfaces = [first, last], whole numbers from 1 to {count}, in order");
    let Some((at, pair)) = section.number_pair("surfaces", &expected)? else {
        return Err(section.error("surfaces", "askew without surfaces", expected));
    };
    let [first, last] = pair;
    let whole = pair.iter().all(|number| number.fract() == 0.0);
    if whole && 1.0 <= first && first <= last && last <= count as f64 {
        return Ok([first as usize - 1, last as usize - 1]);
    }
    Err(section.source.error_at(at, format!("surfaces is [{first}, {last}]"), expected))
}
