//! How a surface or a group stands: `decentre`, `tilt`, and the tables under `[[askew]]`.

use toml::de::DeValue;

use super::value::Section;
use crate::lens::error::LensError;
use crate::lens::pose::{Askew, MOST_DECENTRE, MOST_TILT, Pose};

/// More than there are elements and groups in any lens.
const MOST_BODIES: usize = 256;

/// The pose of a surface or of a group.
pub(super) fn read(section: &Section) -> Result<Pose, LensError> {
    let within = |key: &str, most: f64, unit: &str| -> Result<[f64; 2], LensError> {
        let expected = format!("expected [x, y], each from -{most} to {most} {unit}");
        let Some((at, pair)) = section.couple(key, &expected)? else { return Ok([0.0; 2]) };
        match pair.iter().find(|number| !(-most..=most).contains(*number)) {
            Some(number) => {
                Err(section.source.refuse(at, format!("{key} holds {number}"), expected))
            }
            None => Ok(pair),
        }
    };
    Ok(Pose {
        decentre: within("decentre", MOST_DECENTRE, "mm")?,
        tilt: within("tilt", MOST_TILT, "degrees")?,
    })
}

/// The bodies that stand askew, in a lens of so many surfaces.
pub(super) fn askew(top: &Section, count: usize) -> Result<Vec<Askew>, LensError> {
    if !top.has("askew") {
        return Ok(Vec::new());
    }
    let expected = "expected [[askew]] with surfaces = [first, last] and decentre or tilt";
    let Some(array) = top.array("askew") else {
        return Err(top.refuse("askew", "askew is no list", expected));
    };
    if array.len() > MOST_BODIES {
        let found = format!("{} entries of askew", array.len());
        return Err(top.refuse("askew", found, format!("expected at most {MOST_BODIES}")));
    }
    let body = |entry: &'_ toml::Spanned<DeValue<'_>>| -> Result<Askew, LensError> {
        let at = entry.span().start;
        let DeValue::Table(table) = entry.get_ref() else {
            return Err(top.source.refuse(at, "an entry of askew without keys", expected));
        };
        let section = Section { source: top.source, at, table };
        section.only(&["surfaces", "decentre", "tilt"])?;
        Ok(Askew { rows: rows(&section, count)?, pose: read(&section)? })
    };
    array.iter().map(body).collect()
}

/// First and last row, from 0; the file counts from 1.
fn rows(section: &Section, count: usize) -> Result<[usize; 2], LensError> {
    let expected =
        format!("expected surfaces = [first, last], whole numbers from 1 to {count}, in order");
    let Some((at, pair)) = section.couple("surfaces", &expected)? else {
        return Err(section.refuse("surfaces", "askew without surfaces", expected));
    };
    let [first, last] = pair;
    let whole = pair.iter().all(|number| number.fract() == 0.0);
    if whole && 1.0 <= first && first <= last && last <= count as f64 {
        return Ok([first as usize - 1, last as usize - 1]);
    }
    Err(section.source.refuse(at, format!("surfaces is [{first}, {last}]"), expected))
}
