//! What the values of options look like.

use std::time::Duration;

use petzval::job::FocusOn;
use petzval::lens::{Coating, FocusModel, MOST_DECENTRE, MOST_TILT};
use petzval::sensor::Settings;
use petzval::shutter::seconds;
use petzval::spectrum::{Passband, RANGE};

pub(super) fn list<const N: usize>(text: &str, separator: char) -> Option<[u32; N]> {
    let numbers: Vec<u32> =
        text.split(separator).map(|part| part.trim().parse().ok()).collect::<Option<_>>()?;
    numbers.try_into().ok()
}

/// Two finite numbers.
pub(super) fn point(text: &str) -> Result<[f64; 2], String> {
    let numbers: Option<Vec<f64>> = text
        .split(',')
        .map(|part| part.trim().parse().ok().filter(|v: &f64| v.is_finite()))
        .collect();
    let point = numbers.and_then(|numbers| numbers.try_into().ok());
    point.ok_or_else(|| "expected two numbers X,Y in mm, such as 0,10".to_owned())
}

pub(super) fn pixel(text: &str) -> Result<[u32; 2], String> {
    list(text, ',').ok_or_else(|| "expected two whole numbers X,Y".to_owned())
}

pub(super) fn four(text: &str) -> Result<[u32; 4], String> {
    list(text, ',').ok_or_else(|| "expected four whole numbers X0,Y0,X1,Y1".to_owned())
}

pub(super) fn size(text: &str) -> Result<[u32; 2], String> {
    let size =
        list(text, 'x').filter(|size: &[u32; 2]| size.iter().all(|n| (1..=65536).contains(n)));
    size.ok_or_else(|| "expected WxH in pixels, such as 1200x800, up to 65536".to_owned())
}

/// A number above 0, perhaps infinite.
pub(super) fn above_zero(text: &str, expected: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|&number: &f64| number > 0.0);
    number.ok_or_else(|| format!("expected {expected}"))
}

/// A number, perhaps infinite. Nothing is above or below NaN, so that every picture would pass.
pub(super) fn limit(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| !number.is_nan());
    number.ok_or_else(|| "expected a number such as 0.05".to_owned())
}

pub(super) fn sensor(text: &str) -> Result<Settings, String> {
    text.parse().map_err(|problem| match text.contains('=') {
        true => problem,
        false => format!("{problem}; to give no value, put another option behind --sensor"),
    })
}

pub(super) fn focus(text: &str) -> Result<FocusOn, String> {
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

pub(super) fn focus_model(text: &str) -> Result<FocusModel, String> {
    match text {
        "sharpest" => Ok(FocusModel::Sharpest),
        "pbrt" => Ok(FocusModel::Pbrt),
        _ => Err("expected sharpest or pbrt".to_owned()),
    }
}

pub(super) fn noise(text: &str) -> Result<f64, String> {
    let noise = text.parse().ok().filter(|noise| (1e-5..=1.0).contains(noise));
    noise.ok_or_else(|| "expected a relative error from 0.00001 to 1, such as 0.01".to_owned())
}

pub(super) fn time(text: &str) -> Result<Duration, String> {
    let time = seconds(text).ok().filter(|&seconds| seconds > 0.0);
    let time = time.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
    time.ok_or_else(|| "expected a time above 0, such as 30s".to_owned())
}

/// A time between things; without one they do not happen.
#[derive(Clone, Copy, Debug)]
pub(super) struct Every(pub Option<Duration>);

pub(super) fn every(text: &str) -> Result<Every, String> {
    if ["off", "0", "0s"].contains(&text) {
        return Ok(Every(None));
    }
    time(text)
        .map(|time| Every(Some(time)))
        .map_err(|_| "expected a time such as 60s, or off".into())
}

pub(super) fn shard(text: &str) -> Result<[u32; 2], String> {
    let shard = list(text, '/').filter(|&[i, n]: &[u32; 2]| 1 <= i && i <= n);
    shard.ok_or_else(|| "expected I/N, from 1/N to N/N, such as 3/8".to_owned())
}

pub(super) fn range(text: &str) -> Result<[u32; 2], String> {
    let ends = text.split_once("..").map(|(first, end)| [first, end].map(str::parse));
    match ends {
        Some([Ok(first), Ok(end)]) if first < end => Ok([first, end]),
        _ => Err("expected A..B, such as 0..64".to_owned()),
    }
}

pub(super) fn passband(text: &str) -> Result<Passband, String> {
    let ends = text.split_once("..").map(|(low, high)| [low, high].map(str::parse));
    match ends {
        Some([Ok(low), Ok(high)]) if RANGE[0] <= low && low < high && high <= RANGE[1] => {
            Ok(Passband { range: [low, high] })
        }
        _ => Err("expected two wavelengths from 400 to 704 nm, such as 540..560".to_owned()),
    }
}

pub(super) fn f_number(text: &str) -> Result<f64, String> {
    above_zero(text, "an f-number such as 2.8").and_then(|number| match number.is_finite() {
        true => Ok(number),
        false => Err("expected an f-number such as 2.8".to_owned()),
    })
}

/// Two numbers from -most to most.
fn two(text: &str, most: f64, unit: &str) -> Result<[f64; 2], String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y]) if x.abs() <= most && y.abs() <= most => Ok([x, y]),
        _ => Err(format!("expected X,Y, each from -{most} to {most} {unit}")),
    }
}

pub(super) fn shift(text: &str) -> Result<[f64; 2], String> {
    two(text, MOST_DECENTRE, "mm")
}

pub(super) fn tilt(text: &str) -> Result<[f64; 2], String> {
    two(text, MOST_TILT, "degrees")
}

pub(super) fn coating(text: &str) -> Result<Coating, String> {
    Coating::named(text).ok_or_else(|| format!("expected one of {}", Coating::NAMES.join(", ")))
}

pub(super) fn length_or_inf(text: &str) -> Result<f64, String> {
    above_zero(text, "a length above 0, in mm")
}

pub(super) fn length(text: &str) -> Result<f64, String> {
    length_or_inf(text).and_then(|length| match length.is_finite() {
        true => Ok(length),
        false => Err("expected a finite length, in mm".to_owned()),
    })
}
