//! Tilt and decentre: the keys `decentre` and `tilt`, and the tables under `[[askew]]`.

use glam::{DAffine3, DMat3, DVec3};

use super::value::Section;
use petzval_lens::LensError;
use petzval_lens::{CoordinateBreak, MAX_DECENTRE, MAX_TILT, Pose, TiltDecenter};

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
    let expected = "expected [[askew]] with surfaces = [first, last] and decentre or tilt";
    let body = |section: &Section| {
        section.reject_unknown_keys(&["surfaces", "decentre", "tilt"])?;
        Ok(TiltDecenter { rows: rows(section, count)?, pose: read(section)? })
    };
    top.tables("askew", expected)?.iter().map(body).collect()
}

/// Reads the changes of the axis in a lens with this number of surfaces.
pub(super) fn breaks(top: &Section, count: usize) -> Result<Vec<CoordinateBreak>, LensError> {
    let expected = "expected [[break]] with surface = the first one that follows the new axis, and \
                    decentre = [x, y, z], tilt = [x, y, z] or axes = [[x, y, z], ...]";
    let one = |section: &Section| {
        section.reject_unknown_keys(&["surface", "decentre", "tilt", "axes"])?;
        let row = match section.finite("surface")? {
            Some(row) if row.fract() == 0.0 && (1.0..=count as f64 + 1.0).contains(&row) => row,
            _ => {
                let found = "a break without the number of a surface";
                let expected = format!("expected surface = 1 to {}", count + 1);
                return Err(section.error("surface", found, expected));
            }
        };
        let three = |key: &str| section.numbers(key, 3, &format!("expected {key} = [x, y, z]"));
        let origin = three("decentre")?.map_or(DVec3::ZERO, |v| DVec3::from_slice(&v));
        let axes = section.numbers("axes", 9, "expected three unit vectors across each other")?;
        let tilt = three("tilt")?;
        let rotation = match (axes, tilt) {
            (Some(_), Some(_)) => {
                return Err(section.error("tilt", "tilt beside axes", "expected one of them"));
            }
            (Some(axes), None) => {
                let axes = DMat3::from_cols_slice(&axes);
                let skew = axes.transpose() * axes - DMat3::IDENTITY;
                if skew.to_cols_array().iter().any(|v| v.abs() > 1e-9) || axes.determinant() < 0.0 {
                    let expected = "expected three unit vectors across each other, right-handed";
                    return Err(section.error("axes", "axes that are no rotation", expected));
                }
                axes
            }
            (None, tilt) => {
                let [x, y, z] = [0, 1, 2].map(|i| tilt.as_ref().map_or(0.0, |t| t[i].to_radians()));
                DMat3::from_rotation_x(x) * DMat3::from_rotation_y(y) * DMat3::from_rotation_z(z)
            }
        };
        let transform = DAffine3::from_mat3_translation(rotation, origin);
        Ok(CoordinateBreak { row: row as usize - 1, transform })
    };
    let mut breaks: Vec<CoordinateBreak> =
        top.tables("break", expected)?.iter().map(one).collect::<Result<_, _>>()?;
    breaks.sort_by_key(|axis| axis.row);
    Ok(breaks)
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
