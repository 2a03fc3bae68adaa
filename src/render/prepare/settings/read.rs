//! Readers of settings: from a value of any front end to the one that the library takes.

use std::time::Duration;

use petzval_lens::{Coating, FocusModel, MAX_DECENTRE, MAX_TILT, Zoom};
use petzval_scene::shutter::parse_seconds;
use petzval_spectrum::{BAND_RANGE, Buckets, Passband};

use super::unit_range::{DEGREES, LENGTHS, UnitRange};
use super::value::{SettingError, SettingValue, type_error};
use crate::aov::Aov;
use crate::prepare::{FocusOn, Viewpoint};

/// A finite number above 0.
const ABOVE_ZERO: [f64; 2] = [f64::MIN_POSITIVE, f64::MAX];

/// A plain number without a range of its own.
const PLAIN: UnitRange =
    UnitRange { units: &[], unit: 1.0, name: "", range: ABOVE_ZERO, words: "" };

const F_NUMBER: UnitRange = UnitRange { words: "an f-number such as 2.8 or f/2.8", ..PLAIN };

const FOCUS: UnitRange = UnitRange {
    units: LENGTHS,
    unit: 1e3,
    name: "m",
    range: [f64::MIN_POSITIVE, f64::INFINITY],
    words: "a distance above 0 such as 2m or 850mm (a number alone is in m), or inf, auto, auto@X,Y",
};

/// The description of a focus for programs.
const FOCUS_VALUES: &str = "metres above 0, a pixel (x, y), or \"auto\"";

const FILM_DIAGONAL: UnitRange = UnitRange {
    units: LENGTHS,
    name: "mm",
    range: [1e-3, 1e4],
    words: "a length from 0.001 to 10000 mm, such as 36mm or 3.6cm (a number alone is in mm)",
    ..PLAIN
};

const FILM_SHIFT: UnitRange =
    UnitRange { units: LENGTHS, name: "mm", range: [-MAX_DECENTRE, MAX_DECENTRE], ..PLAIN };

const FILM_TILT: UnitRange =
    UnitRange { units: DEGREES, name: "degrees", range: [-MAX_TILT, MAX_TILT], ..PLAIN };

const NOISE: UnitRange = UnitRange {
    range: [1e-5, 1.0],
    words: "a relative error from 0.00001 to 1, such as 0.01",
    ..PLAIN
};

const TIME: UnitRange = UnitRange { name: "s", range: [f64::MIN_POSITIVE, 1e9], ..PLAIN };

const BAND_EDGE: UnitRange =
    UnitRange { units: &[("nm", 1.0)], name: "nm", range: BAND_RANGE, ..PLAIN };

const BUCKET_EDGE: UnitRange = UnitRange { range: Buckets::VISIBLE, ..BAND_EDGE };

const FOCAL_LENGTH: UnitRange = UnitRange { units: &[("mm", 1.0)], name: "mm", ..PLAIN };

/// Largest side of a picture (pixels).
const MAX_SIDE: u32 = 65536;

/// Most samples per pixel.
const MAX_SAMPLES: u32 = 1 << 30;

/// Reads an f-number: 2.8, or the words f/2.8 and f2.8.
pub fn f_number(value: &SettingValue) -> Result<f64, SettingError> {
    let SettingValue::Words(text) = value else { return F_NUMBER.read(value) };
    let text = text.trim();
    let number = text.strip_prefix(['f', 'F']).unwrap_or(text);
    F_NUMBER.read(&SettingValue::Words(number.strip_prefix('/').unwrap_or(number).to_owned()))
}

/// Reads an object in focus: a distance (m), a pixel, or `auto` for the middle of the picture.
pub fn focus(value: &SettingValue) -> Result<FocusOn, SettingError> {
    let unsound = || SettingError::Value(format!("expected {FOCUS_VALUES}"));
    match value {
        SettingValue::Words(text) => match text.strip_prefix("auto") {
            Some("") => Ok(FocusOn::Pixel(None)),
            Some(rest) => {
                let pixel = rest.strip_prefix('@').unwrap_or_default().to_owned();
                let pixel = wholes(&SettingValue::Words(pixel), ",", [0, u32::MAX], FOCUS.words)?;
                Ok(FocusOn::Pixel(Some(pixel)))
            }
            None => FOCUS.read(value).map(FocusOn::Distance),
        },
        SettingValue::Text(text) if text == "auto" => Ok(FocusOn::Pixel(None)),
        SettingValue::Text(_) => Err(unsound()),
        SettingValue::Number(_) | SettingValue::Whole(_) => {
            FOCUS.read(value).map(FocusOn::Distance).map_err(|_| unsound())
        }
        _ => wholes(value, ",", [0, u32::MAX], FOCUS_VALUES).map(|at| FocusOn::Pixel(Some(at))),
    }
}

/// Reads the model that places the film.
pub fn focus_model(value: &SettingValue) -> Result<FocusModel, SettingError> {
    text(value, "sharpest or pbrt", |name| match name {
        "sharpest" => Ok(FocusModel::Sharpest),
        "pbrt" => Ok(FocusModel::Pbrt),
        _ => Err("expected sharpest or pbrt".to_owned()),
    })
}

/// Reads the diagonal of the film (mm).
pub fn film_diagonal(value: &SettingValue) -> Result<f64, SettingError> {
    FILM_DIAGONAL.read(value)
}

/// Reads the shift of the film, right and up (mm).
pub fn film_shift(value: &SettingValue) -> Result<[f64; 2], SettingError> {
    pair(&FILM_SHIFT, value)
}

/// Reads the tilt of the film about two axes (degrees).
pub fn film_tilt(value: &SettingValue) -> Result<[f64; 2], SettingError> {
    pair(&FILM_TILT, value)
}

fn pair(range: &UnitRange, value: &SettingValue) -> Result<[f64; 2], SettingError> {
    let limits = range.limits();
    let expected = match value {
        SettingValue::Words(_) => format!("X,Y, each{limits}"),
        _ => format!("two numbers{limits}"),
    };
    range.read_pair(value, ",", &expected)
}

/// Reads a place and a direction: the words X,Y,Z,X,Y,Z[,X,Y,Z], or two or three lists.
pub(super) fn look_at(value: &SettingValue) -> Result<Viewpoint, SettingError> {
    let parsed = |text: &str| text.parse().map_err(SettingError::Value);
    let expected = "(eye, target) or (eye, target, up), each three numbers";
    let refused = || type_error(expected);
    match value {
        SettingValue::Words(words) => parsed(words),
        SettingValue::List(points) => {
            let mut numbers = Vec::new();
            for point in points {
                let SettingValue::List(point) = point else { return Err(refused()) };
                let point: Option<Vec<f64>> = point.iter().map(SettingValue::number).collect();
                let point = point.ok_or_else(refused)?;
                if point.len() != 3 {
                    return Err(SettingError::Value(format!("expected {expected}")));
                }
                numbers.extend(point.iter().map(f64::to_string));
            }
            match numbers.len() {
                6 | 9 => parsed(&numbers.join(",")),
                _ => Err(SettingError::Value(format!("expected {expected}"))),
            }
        }
        _ => Err(refused()),
    }
}

/// Reads the width and height of a picture (pixels).
pub fn resolution(value: &SettingValue) -> Result<[u32; 2], SettingError> {
    let expected = match value {
        SettingValue::Words(_) => format!("WxH in pixels, such as 1200x800, up to {MAX_SIDE}"),
        _ => format!("two whole numbers of pixels, width and height, from 1 to {MAX_SIDE}"),
    };
    wholes(value, "x", [1, MAX_SIDE], &expected)
}

/// Reads the upper left pixel of a rectangle, and the one after its lower right.
pub fn crop(value: &SettingValue) -> Result<[[u32; 2]; 2], SettingError> {
    let expected = match value {
        SettingValue::Words(_) => "four whole numbers X0,Y0,X1,Y1",
        _ => "four whole numbers: left, top, right, bottom",
    };
    wholes(value, ",", [0, u32::MAX], expected).map(|[x0, y0, x1, y1]| [[x0, y0], [x1, y1]])
}

/// Reads a number of samples per pixel.
pub fn samples(value: &SettingValue) -> Result<u32, SettingError> {
    whole(value, [1, MAX_SAMPLES])
}

/// Reads a seed of random numbers.
pub fn seed(value: &SettingValue) -> Result<u32, SettingError> {
    whole(value, [0, u32::MAX])
}

fn whole(value: &SettingValue, range: [u32; 2]) -> Result<u32, SettingError> {
    let expected = format!("a whole number from {} to {}", range[0], range[1]);
    // A number alone is a list of one.
    let list = match value {
        SettingValue::Words(_) => value.clone(),
        SettingValue::List(_) => return Err(type_error(&expected)),
        other => SettingValue::List(vec![other.clone()]),
    };
    wholes(&list, ",", range, &expected).map(|[number]| number)
}

fn wholes<const N: usize>(
    value: &SettingValue,
    separator: &str,
    [least, most]: [u32; 2],
    expected: &str,
) -> Result<[u32; N], SettingError> {
    let item = |item: &SettingValue| match item {
        SettingValue::Words(text) => text.trim().parse().ok(),
        other => other.whole(),
    };
    let numbers: [i64; N] = value.items(separator, item, expected)?;
    match numbers.iter().all(|n| (i64::from(least)..=i64::from(most)).contains(n)) {
        true => Ok(numbers.map(|n| n as u32)),
        false => Err(SettingError::Value(format!("expected {expected}"))),
    }
}

/// Reads whether light paths are traced; `None` for where they pay.
pub fn light_paths(value: &SettingValue) -> Result<Option<bool>, SettingError> {
    let expected = "auto, on or off";
    match value {
        SettingValue::Flag(on) => Ok(Some(*on)),
        SettingValue::Words(words) => match words.as_str() {
            "auto" => Ok(None),
            "on" => Ok(Some(true)),
            "off" => Ok(Some(false)),
            _ => Err(SettingError::Value(format!("expected {expected}"))),
        },
        _ => Err(type_error("True, False or None")),
    }
}

/// Reads the names of layers.
pub fn layers(value: &SettingValue) -> Result<Vec<Aov>, SettingError> {
    let expected = "names of layers, such as [\"depth\", \"normal\"]";
    let layer = |name: &str| name.parse().map_err(SettingError::Value);
    match value {
        SettingValue::Words(words) => words.split(',').map(layer).collect(),
        SettingValue::Text(name) => Ok(vec![layer(name)?]),
        SettingValue::List(names) => {
            names.iter().map(|name| text(name, expected, str::parse)).collect()
        }
        _ => Err(type_error(expected)),
    }
}

/// Reads a relative error at which a render stops.
pub fn noise(value: &SettingValue) -> Result<f64, SettingError> {
    NOISE.read(value)
}

/// Reads a time.
pub fn time(value: &SettingValue) -> Result<Duration, SettingError> {
    let seconds = match value {
        SettingValue::Words(words) => parse_seconds(words)
            .ok()
            .and_then(|seconds| TIME.read(&SettingValue::Number(seconds)).ok())
            .ok_or_else(|| SettingError::Value("expected a time above 0, such as 30s".to_owned())),
        other => TIME.read(other),
    };
    seconds.map(Duration::from_secs_f64)
}

/// Reads the passband of the film.
pub fn passband(value: &SettingValue) -> Result<Passband, SettingError> {
    let expected = match value {
        SettingValue::Words(_) => {
            format!("two wavelengths{}, such as 540..560", BAND_EDGE.limits())
        }
        _ => format!("two wavelengths{}", BAND_EDGE.limits()),
    };
    let range = BAND_EDGE.read_pair(value, "..", &expected)?;
    match range[0] < range[1] {
        true => Ok(Passband { range }),
        false => Err(SettingError::Value(format!("expected {expected}"))),
    }
}

/// Reads buckets of wavelength: a number, of all visible light or of a range (nm), or none.
pub fn buckets(value: &SettingValue) -> Result<Option<Buckets>, SettingError> {
    let expected =
        "a number of buckets, such as 16, or with a range in nm, such as 31@400..710, or none";
    let unsound = || SettingError::Value(format!("expected {expected}"));
    let (count, range) = match value {
        SettingValue::Words(text) | SettingValue::Text(text) if text == "none" => return Ok(None),
        SettingValue::Words(text) | SettingValue::Text(text) => {
            let (count, range) = match text.split_once('@') {
                Some((count, range)) => (count, Some(SettingValue::Words(range.to_owned()))),
                None => (text.as_str(), None),
            };
            let range = range.map(|range| BUCKET_EDGE.read_pair(&range, "..", expected));
            (count.trim().parse().ok(), range.transpose()?)
        }
        SettingValue::Whole(count) => (u32::try_from(*count).ok(), None),
        _ => return Err(type_error(expected)),
    };
    let count = count.ok_or_else(unsound)?;
    let made = Buckets::new(count, range.unwrap_or(Buckets::DEFAULT.range()));
    made.map(Some).map_err(SettingError::Value)
}

/// Reads a zoom setting: a focal length (mm), or the name or number (#2) of a state.
pub fn zoom(value: &SettingValue) -> Result<Zoom, SettingError> {
    let expected = "a focal length above 0 in mm, or a state such as #2";
    let unsound = |_| SettingError::Value(format!("expected {expected}"));
    match value {
        SettingValue::Words(words) => {
            let words = words.trim();
            if let Some(number) = words.strip_prefix('#') {
                return Ok(Zoom::State(number.to_owned()));
            }
            let number = words.strip_suffix("mm").unwrap_or(words).trim();
            match number.parse() {
                Err(_) if !words.is_empty() => Ok(Zoom::State(words.to_owned())),
                mm => FOCAL_LENGTH
                    .read(&mm.map_or(SettingValue::Other, SettingValue::Number))
                    .map(Zoom::FocalLength)
                    .map_err(unsound),
            }
        }
        SettingValue::Text(state) => Ok(Zoom::State(state.clone())),
        SettingValue::Number(_) | SettingValue::Whole(_) => {
            FOCAL_LENGTH.read(value).map(Zoom::FocalLength).map_err(unsound)
        }
        _ => Err(type_error(expected)),
    }
}

/// Reads the coating of surfaces that have none of their own.
pub fn coating(value: &SettingValue) -> Result<Coating, SettingError> {
    let expected = format!("one of {}", Coating::NAMES.join(", "));
    text(value, &expected, |name| {
        Coating::named(name).ok_or_else(|| format!("expected {expected}"))
    })
}

pub(super) fn flag(value: &SettingValue) -> Result<bool, SettingError> {
    match value {
        SettingValue::Flag(flag) => Ok(*flag),
        _ => Err(type_error("True or False")),
    }
}

/// Reads a text by a parser. `expected` describes it if the value is no text.
pub(super) fn text<T>(
    value: &SettingValue,
    expected: &str,
    parse: impl Fn(&str) -> Result<T, String>,
) -> Result<T, SettingError> {
    match value {
        SettingValue::Words(text) | SettingValue::Text(text) => {
            parse(text).map_err(SettingError::Value)
        }
        _ => Err(type_error(expected)),
    }
}
