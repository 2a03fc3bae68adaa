//! Colour matrices and white balance of a DNG.

use glam::{DMat3, DVec3};

use super::tags;
use crate::develop::{CameraColours, LightColours, Neutral};

/// Numbers of an entry, if the file has it.
type Reals = Result<Option<Vec<f64>>, String>;

/// Reads the colours of a camera and its white balance. The calibration of a camera counts if it was made for the profile
/// of the file.
///
/// # Errors
/// Returns what was found if there are none, or none that span all colours.
pub(super) fn read_colours(
    entry: &impl Fn(u16) -> Reals,
    is_calibrated: bool,
) -> Result<CameraColours, String> {
    let three = |tag| match entry(tag)?.as_deref() {
        Some(&[a, b, c]) => Ok(Some(DVec3::new(a, b, c))),
        Some(found) => Err(wrong_count(tag, found.len(), 3)),
        None => Ok(None),
    };
    let matrix = |tag| match entry(tag)? {
        None => Ok(None),
        Some(found) => match <[f64; 9]>::try_from(found) {
            Ok(elements) => Ok(Some(DMat3::from_cols_array(&elements).transpose())),
            Err(found) => Err(wrong_count(tag, found.len(), 9)),
        },
    };
    let balance = DMat3::from_diagonal(three(tags::ANALOG_BALANCE)?.unwrap_or(DVec3::ONE));
    let mut lights = Vec::new();
    for k in 0..2 {
        let Some(from_xyz) = matrix(tags::COLOR_MATRIX[k])? else { continue };
        let of_camera = match is_calibrated {
            true => matrix(tags::CAMERA_CALIBRATION[k])?,
            false => None,
        };
        let light = entry(tags::CALIBRATION_ILLUMINANT[k])?;
        lights.push(LightColours {
            kelvin: light.and_then(|found| light_source_kelvin(*found.first()?)),
            from_xyz,
            calibration: balance * of_camera.unwrap_or(DMat3::IDENTITY),
            to_xyz_d50: matrix(tags::FORWARD_MATRIX[k])?,
        });
    }
    let as_shot = match (three(tags::AS_SHOT_NEUTRAL)?, entry(tags::AS_SHOT_WHITE)?.as_deref()) {
        (Some(neutral), _) => Some(Neutral::Channels(neutral)),
        (None, Some(&[x, y])) => Some(Neutral::Light([x, y])),
        (None, Some(found)) => return Err(wrong_count(tags::AS_SHOT_WHITE, found.len(), 2)),
        (None, None) => None,
    };
    CameraColours::new(lights, as_shot)
}

fn wrong_count(tag: u16, found: usize, expected: usize) -> String {
    format!("its {} has {found} numbers; expected {expected}", tags::name(tag))
}

/// Returns the correlated colour temperature of a light source of Exif 2.32 (K).
fn light_source_kelvin(light: f64) -> Option<f64> {
    const TUNGSTEN: u32 = tags::TUNGSTEN as u32;
    const D65: u32 = tags::D65 as u32;
    Some(match light as u32 {
        3 | TUNGSTEN => 2856.0,
        16 => 2925.0,
        24 => 3200.0,
        15 => 3450.0,
        2 | 14 => 4150.0,
        18 => 4874.0,
        23 => 5003.0,
        13 => 5050.0,
        1 | 4 | 9 | 20 => 5503.0,
        12 => 6430.0,
        10 | D65 => 6504.0,
        19 => 6774.0,
        11 | 22 => 7504.0,
        _ => return None,
    })
}
