//! Values of sensor settings.

use super::{Binning, BinningSum, Components, Crosstalk, DarkCurrent, HotPixels, Microlenses};

/// Range of the full well (electrons). Beyond it, shot noise is less than a millionth.
pub(super) const WELLS: [f64; 2] = [1.0, 1e12];

/// Temperatures of sensors (degrees Celsius).
pub(super) const TEMPERATURES: [f64; 2] = [-273.15, 500.0];

/// Parses a number within bounds.
pub(super) fn parse_number(
    name: &str,
    text: &str,
    unit: &str,
    [low, high]: [f64; 2],
) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number| (low..=high).contains(number));
    number.ok_or_else(|| format!("{name}: expected {unit} from {low} to {high}, found {text:?}"))
}

/// Parses one number for photosites, or three between slashes: for photosites, rows and columns.
pub(super) fn parse_components(
    name: &str,
    text: &str,
    unit: &str,
    most: f64,
) -> Result<Components, String> {
    let wrong = || {
        format!(
            "{name}: expected {unit} from 0 to {most}, or three such numbers PIXEL/ROW/COLUMN, found \
             {text:?}"
        )
    };
    let parse =
        |word: &str| parse_number(name, word.trim(), unit, [0.0, most]).map_err(|_| wrong());
    match text.split('/').collect::<Vec<_>>()[..] {
        [pixel] => Ok(Components { pixel: parse(pixel)?, ..Components::default() }),
        [pixel, row, column] => {
            Ok(Components { pixel: parse(pixel)?, row: parse(row)?, column: parse(column)? })
        }
        _ => Err(wrong()),
    }
}

/// Parses `SHARE/CURRENT`.
pub(super) fn parse_hot_pixels(text: &str) -> Result<HotPixels, String> {
    let wrong = || {
        format!(
            "hot: expected SHARE/CURRENT, a share from 0 to 1 and electrons a second from 0 to {}, found \
             {text:?}",
            WELLS[1]
        )
    };
    let (share, current) = text.split_once('/').ok_or_else(wrong)?;
    let parse =
        |text: &str, most| parse_number("", text.trim(), "", [0.0, most]).map_err(|_| wrong());
    Ok(HotPixels { share: parse(share, 1.0)?, dark_current: parse(current, WELLS[1])? })
}

pub(super) fn parse_integer(
    name: &str,
    text: &str,
    unit: &str,
    [low, high]: [u32; 2],
) -> Result<u32, String> {
    let number = text.parse().ok().filter(|number| (low..=high).contains(number));
    number.ok_or_else(|| format!("{name}: expected {unit} from {low} to {high}, found {text:?}"))
}

/// Parses `CURRENT`, or `CURRENT@CELSIUS/KELVIN`.
pub(super) fn parse_dark_current(text: &str) -> Result<DarkCurrent, String> {
    let wrong = || {
        format!(
            "dark: expected electrons/s from 0 to {}, or CURRENT@CELSIUS/KELVIN with the temperature of that \
             current and the rise that doubles it, found {text:?}",
            WELLS[1]
        )
    };
    let parse = |text: &str, [low, high]: [f64; 2]| {
        parse_number("", text.trim(), "", [low, high]).map_err(|_| wrong())
    };
    let (current, reference) = text.split_once('@').unzip();
    let current = parse(current.unwrap_or(text), [0.0, WELLS[1]])?;
    let reference = match reference {
        None => None,
        Some(reference) => {
            let (at, doubling) = reference.split_once('/').ok_or_else(wrong)?;
            Some([parse(at, TEMPERATURES)?, parse(doubling, [0.1, 1000.0])?])
        }
    };
    Ok(DarkCurrent { current, reference })
}

/// Parses one share for all filters, or three between slashes, in %.
pub(super) fn parse_crosstalk(text: &str) -> Result<Crosstalk, String> {
    let most = 100.0 * Crosstalk::MOST;
    let wrong = || {
        format!(
            "crosstalk: expected % from 0 to {most}, or three such numbers RED/GREEN/BLUE, found {text:?}"
        )
    };
    let parse = |word: &str| {
        parse_number("", word.trim(), "", [0.0, most]).map(|n| 0.01 * n).map_err(|_| wrong())
    };
    match text.split('/').collect::<Vec<_>>()[..] {
        [all] => Ok(Crosstalk([parse(all)?; 3])),
        [red, green, blue] => Ok(Crosstalk([parse(red)?, parse(green)?, parse(blue)?])),
        _ => Err(wrong()),
    }
}

/// Parses `SIDE`, or `SIDE/charge` or `SIDE/codes`.
pub(super) fn parse_binning(text: &str) -> Result<Binning, String> {
    let wrong = || {
        let most = Binning::MOST;
        format!(
            "binning: expected photosites along a side from 1 to {most}, and charge or codes, such as 2/charge, found \
             {text:?}"
        )
    };
    let (side, sum) = text.split_once('/').unwrap_or((text, "codes"));
    let side = parse_integer("", side.trim(), "", [1, Binning::MOST]).map_err(|_| wrong())?;
    match sum.trim() {
        "codes" => Ok(Binning { side, sum: BinningSum::Codes }),
        "charge" => Ok(Binning { side, sum: BinningSum::Charge }),
        _ => Err(wrong()),
    }
}

/// Parses `HALF`, or `HALF/CORNER`, in degrees.
pub(super) fn parse_microlenses(text: &str) -> Result<Microlenses, String> {
    let wrong = || {
        format!(
            "microlens: expected HALF or HALF/CORNER, the angle at which a photosite collects half the light from 1 to 90 \
             degrees, and the chief ray angle of the corner that it is made for from 0 to 89, found {text:?}"
        )
    };
    let (half, corner) = text.split_once('/').unwrap_or((text, "0"));
    let parse = |text: &str, range| parse_number("", text.trim(), "", range).map_err(|_| wrong());
    Ok(Microlenses {
        half_angle: parse(half, [1.0, 90.0])?,
        corner_angle: parse(corner, [0.0, 89.0])?,
    })
}
