//! Parsers of option values.

use std::ops::Range;
use std::sync::Arc;
use std::time::Duration;

use petzval::lens::{Coating, FocusModel, MAX_DECENTRE, MAX_TILT, Zoom};
use petzval::prepare::{FocusOn, Viewpoint};
use petzval::sensor::SensorSettings;
use petzval::shutter::parse_seconds;
use petzval::spectrum::{BAND_RANGE, Passband};

/// Parses `N` whole numbers.
fn list<const N: usize>(text: &str, separator: char) -> Option<[u32; N]> {
    let numbers: Vec<u32> =
        text.split(separator).map(|part| part.trim().parse().ok()).collect::<Option<_>>()?;
    numbers.try_into().ok()
}

/// Parses two finite numbers.
pub(in crate::cli) fn point(text: &str) -> Result<[f64; 2], String> {
    let numbers: Option<Vec<f64>> = text
        .split(',')
        .map(|part| part.trim().parse().ok().filter(|v: &f64| v.is_finite()))
        .collect();
    let point = numbers.and_then(|numbers| numbers.try_into().ok());
    point.ok_or_else(|| "expected two numbers X,Y in mm, such as 0,10".to_owned())
}

pub(in crate::cli) fn pixel(text: &str) -> Result<[u32; 2], String> {
    list(text, ',').ok_or_else(|| "expected two whole numbers X,Y".to_owned())
}

/// Parses the upper left pixel of a rectangle, and the one after its lower right.
pub(in crate::cli) fn crop(text: &str) -> Result<[[u32; 2]; 2], String> {
    match list(text, ',') {
        Some([x0, y0, x1, y1]) => Ok([[x0, y0], [x1, y1]]),
        None => Err("expected four whole numbers X0,Y0,X1,Y1".to_owned()),
    }
}

pub(in crate::cli) fn size(text: &str) -> Result<[u32; 2], String> {
    let size =
        list(text, 'x').filter(|size: &[u32; 2]| size.iter().all(|n| (1..=65536).contains(n)));
    size.ok_or_else(|| "expected WxH in pixels, such as 1200x800, up to 65536".to_owned())
}

/// Parses a number above 0; infinity is allowed.
pub(in crate::cli) fn above_zero(text: &str, expected: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|&number: &f64| number > 0.0);
    number.ok_or_else(|| format!("expected {expected}"))
}

/// Parses a number; infinity is allowed. NaN is refused, as every picture would pass it.
pub(in crate::cli) fn limit(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| !number.is_nan());
    number.ok_or_else(|| "expected a number such as 0.05".to_owned())
}

pub(in crate::cli) fn sensor(text: &str) -> Result<SensorSettings, String> {
    text.parse().map_err(|problem| match text.contains('=') {
        true => problem,
        false => format!("{problem}; to give no value, put another option after --sensor"),
    })
}

pub(in crate::cli) fn focus(text: &str) -> Result<FocusOn, String> {
    let expected = "a distance above 0, in m, or inf, auto, auto@X,Y";
    match text.strip_prefix("auto") {
        Some("") => Ok(FocusOn::Pixel(None)),
        Some(pixel) => match pixel.strip_prefix('@').and_then(|pixel| list(pixel, ',')) {
            Some(pixel) => Ok(FocusOn::Pixel(Some(pixel))),
            None => Err(format!("expected {expected}")),
        },
        None => above_zero(text, expected).map(FocusOn::Distance),
    }
}

pub(in crate::cli) fn viewpoint(text: &str) -> Result<Viewpoint, String> {
    text.parse()
}

pub(in crate::cli) fn focus_model(text: &str) -> Result<FocusModel, String> {
    match text {
        "sharpest" => Ok(FocusModel::Sharpest),
        "pbrt" => Ok(FocusModel::Pbrt),
        _ => Err("expected sharpest or pbrt".to_owned()),
    }
}

pub(in crate::cli) fn noise(text: &str) -> Result<f64, String> {
    let noise = text.parse().ok().filter(|noise| (1e-5..=1.0).contains(noise));
    noise.ok_or_else(|| "expected a relative error from 0.00001 to 1, such as 0.01".to_owned())
}

pub(in crate::cli) fn time(text: &str) -> Result<Duration, String> {
    let time = parse_seconds(text).ok().filter(|&seconds| seconds > 0.0);
    let time = time.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
    time.ok_or_else(|| "expected a time above 0, such as 30s".to_owned())
}

/// Time between checkpoints; `None` for no checkpoints.
#[derive(Clone, Copy, Debug)]
pub(in crate::cli) struct CheckpointInterval(pub Option<Duration>);

pub(in crate::cli) fn checkpoint_interval(text: &str) -> Result<CheckpointInterval, String> {
    if ["off", "0", "0s"].contains(&text) {
        return Ok(CheckpointInterval(None));
    }
    time(text)
        .map(|time| CheckpointInterval(Some(time)))
        .map_err(|_| "expected a time such as 60s, or off".into())
}

/// One of `count` equal parts of a picture's samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::cli) struct Shard {
    /// From 1 to `count`.
    pub index: u32,
    pub count: u32,
}

impl Shard {
    /// Returns the samples of this part, of `all` samples per pixel.
    pub fn samples(self, all: u32) -> Range<u32> {
        let share = |n: u32| (u64::from(all) * u64::from(n) / u64::from(self.count)) as u32;
        share(self.index - 1)..share(self.index)
    }
}

pub(in crate::cli) fn shard(text: &str) -> Result<Shard, String> {
    match list(text, '/') {
        Some([index, count]) if (1..=count).contains(&index) => Ok(Shard { index, count }),
        _ => Err("expected I/N, from 1/N to N/N, such as 3/8".to_owned()),
    }
}

pub(in crate::cli) fn range(text: &str) -> Result<Range<u32>, String> {
    let ends = text.split_once("..").map(|(first, end)| [first, end].map(str::parse));
    match ends {
        Some([Ok(first), Ok(end)]) if first < end => Ok(first..end),
        _ => Err("expected A..B, such as 0..64".to_owned()),
    }
}

pub(in crate::cli) fn passband(text: &str) -> Result<Passband, String> {
    let ends = text.split_once("..").map(|(low, high)| [low, high].map(str::parse));
    match ends {
        Some([Ok(low), Ok(high)])
            if BAND_RANGE[0] <= low && low < high && high <= BAND_RANGE[1] =>
        {
            Ok(Passband { range: [low, high] })
        }
        _ => Err("expected two wavelengths from 400 to 704 nm, such as 540..560".to_owned()),
    }
}

pub(in crate::cli) fn f_number(text: &str) -> Result<f64, String> {
    above_zero(text, "an f-number such as 2.8").and_then(|number| match number.is_finite() {
        true => Ok(number),
        false => Err("expected an f-number such as 2.8".to_owned()),
    })
}

/// Parses two numbers from -most to most.
fn two(text: &str, most: f64, unit: &str) -> Result<[f64; 2], String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y]) if x.abs() <= most && y.abs() <= most => Ok([x, y]),
        _ => Err(format!("expected X,Y, each from -{most} to {most} {unit}")),
    }
}

pub(in crate::cli) fn shift(text: &str) -> Result<[f64; 2], String> {
    two(text, MAX_DECENTRE, "mm")
}

pub(in crate::cli) fn tilt(text: &str) -> Result<[f64; 2], String> {
    two(text, MAX_TILT, "degrees")
}

/// Choice about light paths; `None` for where they pay.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::cli) struct LightPathChoice(pub Option<bool>);

pub(in crate::cli) fn light_paths(text: &str) -> Result<LightPathChoice, String> {
    match text {
        "auto" => Ok(LightPathChoice(None)),
        "on" => Ok(LightPathChoice(Some(true))),
        "off" => Ok(LightPathChoice(Some(false))),
        _ => Err("expected auto, on or off".to_owned()),
    }
}

pub(in crate::cli) fn coating(text: &str) -> Result<Coating, String> {
    Coating::named(text).ok_or_else(|| format!("expected one of {}", Coating::NAMES.join(", ")))
}

/// Parses a zoom setting: a focal length such as 70 or 70mm, or the name or number (#2) of a state.
pub(in crate::cli) fn zoom(text: &str) -> Result<Zoom, String> {
    let text = text.trim();
    if let Some(number) = text.strip_prefix('#') {
        return Ok(Zoom::State(number.to_owned()));
    }
    match text.strip_suffix("mm").unwrap_or(text).trim().parse::<f64>() {
        Ok(mm) if mm.is_finite() && mm > 0.0 => Ok(Zoom::FocalLength(mm)),
        Err(_) if !text.is_empty() => Ok(Zoom::State(text.to_owned())),
        _ => Err("expected a focal length above 0 in mm, or a state such as #2".to_owned()),
    }
}

/// Parses wavelengths (nm).
pub(in crate::cli) fn wavelengths(text: &str) -> Result<Arc<[f64]>, String> {
    let one = |part: &str| part.trim().parse().ok().filter(|nm| (100.0..=1e5).contains(nm));
    let all: Option<Arc<[f64]>> = text.split(',').map(one).collect();
    all.ok_or_else(|| {
        "expected wavelengths from 100 to 100000 nm with commas between, such as 486.1,587.6,656.3"
            .to_owned()
    })
}

/// Parses the width and height of a sensor (mm).
pub(in crate::cli) fn sensor_size(text: &str) -> Result<[f64; 2], String> {
    let side = |part: &str| part.trim().parse().ok().filter(|mm| (1e-3..=1e4).contains(mm));
    let sides = text.strip_suffix("mm").unwrap_or(text).split_once('x');
    match sides.map(|(width, height)| [side(width), side(height)]) {
        Some([Some(width), Some(height)]) => Ok([width, height]),
        _ => Err("expected WxH in mm, such as 36x24".to_owned()),
    }
}

/// Parses a distance with its unit (mm), or infinity.
pub(in crate::cli) fn distance(text: &str) -> Result<f64, String> {
    let expected = "expected a distance with its unit, such as 2m or 850mm, or inf";
    let text = text.trim();
    if text == "inf" {
        return Ok(f64::INFINITY);
    }
    let (number, unit) = match (text.strip_suffix("mm"), text.strip_suffix('m')) {
        (Some(number), _) => (number, 1.0),
        (None, Some(number)) => (number, 1e3),
        (None, None) => return Err(expected.to_owned()),
    };
    let number = number.trim().parse().ok().filter(|v: &f64| *v > 0.0 && v.is_finite());
    number.map(|number| number * unit).ok_or_else(|| expected.to_owned())
}

pub(in crate::cli) fn length_or_inf(text: &str) -> Result<f64, String> {
    above_zero(text, "a length above 0, in mm")
}

pub(in crate::cli) fn length(text: &str) -> Result<f64, String> {
    length_or_inf(text).and_then(|length| match length.is_finite() {
        true => Ok(length),
        false => Err("expected a finite length, in mm".to_owned()),
    })
}
