//! Reads what turns the codes of a DNG into a picture: levels, colours, white balance, orientation.

use glam::{DMat3, DVec3};

use super::mosaic::{RawDirectory, read_mosaic};
use crate::develop::{CameraColours, LightColours, Neutral, RawFile};

/// Tags of TIFF 6.0 and DNG 1.7.
mod tags {
    pub const ORIENTATION: u16 = 274;
    pub const BLACK_LEVEL_SIZE: u16 = 50713;
    pub const BLACK_LEVEL: u16 = 50714;
    pub const BLACK_LEVEL_DELTAS: [u16; 2] = [50715, 50716];
    pub const WHITE_LEVEL: u16 = 50717;
    pub const COLOR_MATRIX: [u16; 2] = [50721, 50722];
    pub const CAMERA_CALIBRATION: [u16; 2] = [50723, 50724];
    pub const ANALOG_BALANCE: u16 = 50727;
    pub const AS_SHOT_NEUTRAL: u16 = 50728;
    pub const AS_SHOT_WHITE: u16 = 50729;
    pub const BASELINE_EXPOSURE: u16 = 50730;
    pub const CALIBRATION_ILLUMINANT: [u16; 2] = [50778, 50779];
    pub const FORWARD_MATRIX: [u16; 2] = [50964, 50965];
}

/// Reads a raw file.
///
/// # Errors
/// Returns what was found if the file has no raw data that this reads, or if its levels or colours are missing or
/// of another form.
pub(crate) fn read_raw(bytes: &[u8]) -> Result<RawFile, String> {
    let codes = read_mosaic(bytes)?;
    let raw = RawDirectory::find(bytes)?;
    let (file, first) = (&raw.file, raw.first);
    let of_data = |tag| file.reals(raw.directory, tag);
    let finite = |found: Vec<f64>| found.iter().all(|number| number.is_finite()).then_some(found);
    for tag in tags::BLACK_LEVEL_DELTAS {
        if of_data(tag).is_some_and(|deltas| deltas.iter().any(|&delta| delta != 0.0)) {
            return Err("its black level differs from row to row or from column to column; expected one for each \
                        filter"
                .to_owned());
        }
    }
    let levels = of_data(tags::BLACK_LEVEL).unwrap_or_else(|| vec![0.0]);
    let size = file.entry(raw.directory, tags::BLACK_LEVEL_SIZE).unwrap_or_else(|| vec![1, 1]);
    let black = match (&size[..], &levels[..]) {
        ([1, 1], &[level]) => [level; 4],
        ([2, 2], &[a, b, c, d]) => [a, b, c, d],
        _ => {
            return Err(format!(
                "its black level is given for {} photosites; expected one, or two by two",
                levels.len()
            ));
        }
    };
    let white = of_data(tags::WHITE_LEVEL).and_then(|levels| levels.first().copied());
    let white = white.unwrap_or_else(|| f64::from(codes.bits).exp2() - 1.0);
    if !(white.is_finite() && black.iter().all(|&black| black >= 0.0 && black < white)) {
        return Err(format!(
            "its black level is {} and its white level {white}; expected less and more",
            black[0]
        ));
    }
    let of_camera = |tag| file.reals(first, tag).and_then(finite);
    let exposure = of_camera(tags::BASELINE_EXPOSURE).and_then(|found| found.first().copied());
    let orientation = file.entry(first, tags::ORIENTATION).and_then(|found| found.first().copied());
    let colours = match codes.filters {
        Some(_) => Some(read_colours(&of_camera)?),
        None => None,
    };
    Ok(RawFile {
        codes,
        black,
        white,
        colours,
        exposure: exposure.unwrap_or(0.0),
        orientation: orientation.unwrap_or(1) as u8,
    })
}

/// Reads the colours of a camera and its white balance.
///
/// # Errors
/// Returns what was found if there are none, or none that span all colours.
fn read_colours(entry: &impl Fn(u16) -> Option<Vec<f64>>) -> Result<CameraColours, String> {
    let three = |tag| match entry(tag).as_deref() {
        Some(&[a, b, c]) => Some(DVec3::new(a, b, c)),
        _ => None,
    };
    let matrix = |tag| {
        let elements: [f64; 9] = entry(tag)?.try_into().ok()?;
        Some(DMat3::from_cols_array(&elements).transpose())
    };
    let balance = DMat3::from_diagonal(three(tags::ANALOG_BALANCE).unwrap_or(DVec3::ONE));
    let mut lights = Vec::new();
    for k in 0..2 {
        let Some(from_xyz) = matrix(tags::COLOR_MATRIX[k]) else { continue };
        let of_camera = matrix(tags::CAMERA_CALIBRATION[k]).unwrap_or(DMat3::IDENTITY);
        let light = entry(tags::CALIBRATION_ILLUMINANT[k]).and_then(|found| found.first().copied());
        lights.push(LightColours {
            temperature: light.and_then(|light| temperature(light as u32)),
            from_xyz,
            calibration: balance * of_camera,
            to_xyz_d50: matrix(tags::FORWARD_MATRIX[k]),
        });
    }
    let as_shot = match (three(tags::AS_SHOT_NEUTRAL), entry(tags::AS_SHOT_WHITE).as_deref()) {
        (Some(neutral), _) => Some(Neutral::Channels(neutral)),
        (None, Some(&[x, y])) => Some(Neutral::Light([x, y])),
        _ => None,
    };
    CameraColours::new(lights, as_shot)
}

/// Returns the correlated colour temperature of a light source of Exif (K).
fn temperature(light: u32) -> Option<f64> {
    Some(match light {
        3 | 17 => 2856.0,
        24 => 3200.0,
        15 => 3450.0,
        2 | 14 => 4150.0,
        23 => 5003.0,
        13 => 5050.0,
        1 | 4 | 9 | 20 => 5503.0,
        18 => 4874.0,
        12 => 6430.0,
        10 | 21 => 6504.0,
        19 => 6774.0,
        11 | 22 => 7504.0,
        _ => return None,
    })
}
