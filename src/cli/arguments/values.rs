//! Parsers of option values.

use std::ops::Range;
use std::sync::Arc;
use std::time::Duration;

use petzval_image::WhiteBalance;
use petzval_lens::{Coating, FocusModel, MAX_DECENTRE, MAX_TILT, Zoom};
use petzval_render::prepare::{FocusOn, Viewpoint};
use petzval_render::sensor::SensorSettings;
use petzval_scene::shutter::parse_seconds;
use petzval_spectrum::{BAND_RANGE, Passband, Spectrum, d_illuminant, daylight, named_spectrum};

/// Parses `N` whole numbers.
fn list<const N: usize>(text: &str, separator: char) -> Option<[u32; N]> {
    let numbers: Vec<u32> =
        text.split(separator).map(|part| part.trim().parse().ok()).collect::<Option<_>>()?;
    numbers.try_into().ok()
}

/// Parses a finite length of any sign (mm).
pub(in crate::cli) fn signed_length(text: &str) -> Option<f64> {
    signed(text, &LENGTHS, MILLIMETRE)
}

/// Parses two finite lengths (mm).
pub(in crate::cli) fn point(text: &str) -> Result<[f64; 2], String> {
    let lengths: Option<Vec<f64>> = text.split(',').map(signed_length).collect();
    let point = lengths.and_then(|lengths| lengths.try_into().ok());
    point.ok_or_else(|| "expected two lengths X,Y in mm, such as 0,10 or 0mm,10mm".to_owned())
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

/// Units of length (mm). A unit stands before those that end like it.
const LENGTHS: [(&str, f64); 7] = [
    ("nm", 1e-6),
    ("um", 1e-3),
    ("mm", MILLIMETRE),
    ("cm", 10.0),
    ("in", 25.4),
    ("ft", 304.8),
    ("m", METRE),
];

/// Millimetre and metre (mm), as units of options without one.
const MILLIMETRE: f64 = 1.0;
const METRE: f64 = 1e3;

/// Parses a finite number of any sign with a unit, in units of `default`, which is also the unit of
/// a number without one.
fn signed(text: &str, units: &[(&str, f64)], default: f64) -> Option<f64> {
    let text = text.trim();
    let with_unit = units.iter().find_map(|(unit, size)| Some((text.strip_suffix(unit)?, *size)));
    let (number, scale) = match with_unit {
        Some((number, size)) if size != default => (number, size / default),
        Some((number, _)) => (number, 1.0),
        None => (text, 1.0),
    };
    number.trim().parse().ok().map(|v: f64| v * scale).filter(|v| v.is_finite())
}

/// Parses a length above 0, in units of `default`. Infinity is `inf`.
fn length_above_zero(text: &str, default: f64) -> Option<f64> {
    match text.trim() {
        "inf" => Some(f64::INFINITY),
        text => signed(text, &LENGTHS, default).filter(|&length| length > 0.0),
    }
}

/// Parses a finite number above 0 with one of these endings, which do not change it.
fn above_zero(text: &str, endings: &[&str]) -> Option<f64> {
    let endings: Vec<(&str, f64)> = endings.iter().map(|&ending| (ending, 1.0)).collect();
    signed(text, &endings, 1.0).filter(|&number| number > 0.0)
}

/// Parses a spatial frequency (cycles/mm).
pub(in crate::cli) fn frequency(text: &str) -> Result<f64, String> {
    let found = above_zero(text, &["cycles/mm", "lp/mm", "/mm"]);
    found.ok_or_else(|| "expected a frequency above 0 in cycles/mm, such as 30 or 30/mm".to_owned())
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
    let expected = "a distance above 0 such as 2m or 850mm (a number alone is in m), or inf, auto, \
                    auto@X,Y";
    match text.strip_prefix("auto") {
        Some("") => Ok(FocusOn::Pixel(None)),
        Some(pixel) => match pixel.strip_prefix('@').and_then(|pixel| list(pixel, ',')) {
            Some(pixel) => Ok(FocusOn::Pixel(Some(pixel))),
            None => Err(format!("expected {expected}")),
        },
        None => length_above_zero(text, METRE)
            .map(FocusOn::Distance)
            .ok_or_else(|| format!("expected {expected}")),
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

/// Parses the light of a white balance.
pub(in crate::cli) fn white_balance(text: &str) -> Result<WhiteBalance, String> {
    const EXPECTED: &str =
        "expected a temperature from 1000K to 25000K, D50, D55, D65, D75, A, x,y, auto or off";
    let light = |spectrum: Spectrum| {
        let [x, y, z] = spectrum.to_xyz();
        WhiteBalance::to_light([x, y].map(|v| v / (x + y + z)))
    };
    let white = match text {
        "off" => return Ok(WhiteBalance::Off),
        "auto" => return Ok(WhiteBalance::Auto),
        "A" => named_spectrum("stdillum-A").and_then(light),
        "D50" => light(d_illuminant(5000.0)),
        "D55" => light(d_illuminant(5500.0)),
        "D65" => light(d_illuminant(6500.0)),
        "D75" => light(d_illuminant(7500.0)),
        _ => match text.strip_suffix(['K', 'k']) {
            Some(kelvin) => {
                let kelvin = kelvin.trim().parse::<f64>().map_err(|_| EXPECTED)?;
                (1000.0..=25_000.0).contains(&kelvin).then(|| light(daylight(kelvin))).flatten()
            }
            None => {
                let [x, y] = text.split_once(',').map(Into::into).ok_or(EXPECTED)?;
                let number = |word: &str| word.trim().parse::<f64>().map_err(|_| EXPECTED);
                WhiteBalance::to_light([number(x)?, number(y)?])
            }
        },
    };
    white.ok_or_else(|| EXPECTED.to_owned())
}

pub(in crate::cli) fn passband(text: &str) -> Result<Passband, String> {
    let nm = |text: &str| above_zero(text, &["nm"]);
    let ends = text.split_once("..").map(|(low, high)| [low, high].map(nm));
    match ends {
        Some([Some(low), Some(high)])
            if BAND_RANGE[0] <= low && low < high && high <= BAND_RANGE[1] =>
        {
            Ok(Passband { range: [low, high] })
        }
        _ => Err("expected two wavelengths from 400 to 704 nm, such as 540..560".to_owned()),
    }
}

/// Parses an f-number: 2.8, f/2.8 or f2.8.
pub(in crate::cli) fn f_number(text: &str) -> Result<f64, String> {
    let text = text.trim();
    let number = text.strip_prefix(['f', 'F']).unwrap_or(text);
    above_zero(number.strip_prefix('/').unwrap_or(number), &[])
        .ok_or_else(|| "expected an f-number such as 2.8 or f/2.8".to_owned())
}

/// Parses two numbers from -most to most, each with this unit or none.
fn two(text: &str, most: f64, units: &[(&str, f64)], unit: &str) -> Result<[f64; 2], String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|part| signed(part, units, 1.0)).collect();
    match numbers.as_deref() {
        Some(&[x, y]) if x.abs() <= most && y.abs() <= most => Ok([x, y]),
        _ => Err(format!("expected X,Y, each from -{most} to {most} {unit}")),
    }
}

pub(in crate::cli) fn shift(text: &str) -> Result<[f64; 2], String> {
    two(text, MAX_DECENTRE, &LENGTHS, "mm")
}

pub(in crate::cli) fn tilt(text: &str) -> Result<[f64; 2], String> {
    two(text, MAX_TILT, &[("degrees", 1.0), ("deg", 1.0), ("°", 1.0)], "degrees")
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
    let nm = [("nm", 1.0), ("um", 1e3)];
    let one = |part: &str| signed(part, &nm, 1.0).filter(|nm| (100.0..=1e5).contains(nm));
    let all: Option<Arc<[f64]>> = text.split(',').map(one).collect();
    all.ok_or_else(|| {
        "expected wavelengths from 100 to 100000 nm with commas between, such as 486.1,587.6,656.3"
            .to_owned()
    })
}

/// Parses the width and height of a sensor (mm).
pub(in crate::cli) fn sensor_size(text: &str) -> Result<[f64; 2], String> {
    let side =
        |part: &str| signed(part, &LENGTHS, MILLIMETRE).filter(|mm| (1e-3..=1e4).contains(mm));
    let sides = text.split_once('x').map(|(width, height)| [side(width), side(height)]);
    match sides {
        Some([Some(width), Some(height)]) => Ok([width, height]),
        _ => Err("expected WxH in mm, such as 36x24 or 36mmx24mm".to_owned()),
    }
}

/// Largest distance (m) that a number alone gives a command for lens files. A larger one was more
/// likely meant in mm, which lens files are in.
const FARTHEST_ALONE: f64 = 100.0;

/// Parses a distance in focus as [`focus`] does, for commands without a scene, in mm.
pub(in crate::cli) fn focus_distance(text: &str) -> Result<f64, String> {
    let alone = text.trim().parse::<f64>().ok().filter(|number| number.is_finite());
    if let Some(number) = alone.filter(|number| *number > FARTHEST_ALONE) {
        return Err(format!("a number alone is in metres; write {number}mm, or {number}m"));
    }
    let unit = if alone.is_some() { METRE } else { MILLIMETRE };
    length_above_zero(text, unit).map(|length| length * unit).ok_or_else(|| {
        "expected a distance above 0 such as 2m or 850mm (a number alone is in m), or inf"
            .to_owned()
    })
}

/// Parses a finite length (mm).
pub(in crate::cli) fn length(text: &str) -> Result<f64, String> {
    let length = length_above_zero(text, MILLIMETRE).filter(|length| length.is_finite());
    length.ok_or_else(|| {
        "expected a length above 0 such as 36mm or 3.6cm (a number alone is in mm)".to_owned()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_take_their_units_and_numbers_alone_keep_theirs() {
        for (text, mm) in
            [("2m", 2000.0), ("850mm", 850.0), ("85 cm", 850.0), ("3", 3.0), ("500um", 0.5)]
        {
            assert!((length(text).unwrap() - mm).abs() < 1e-12 * mm, "{text}");
        }
        let metres = |text: &str| match focus(text) {
            Ok(FocusOn::Distance(metres)) => metres,
            other => panic!("{text}: {other:?}"),
        };
        let found = ["2", "2m", "850mm", "inf", "2.5e-1m", "10ft"].map(metres);
        assert_eq!(found, [2.0, 2.0, 0.85, f64::INFINITY, 0.25, 3.048]);
        // One meaning of a number alone in all commands.
        for text in ["2", "2m", "850mm", "inf", "2.5e-1m", "0.1", "100"] {
            let found = focus_distance(text).unwrap();
            assert!(
                found == 1e3 * metres(text) || (found / 1e3 / metres(text) - 1.0).abs() < 1e-15
            );
        }
        assert_eq!(focus_distance("3720.8515mm"), Ok(3720.8515));
        let hint = focus_distance("2000").unwrap_err();
        assert!(hint.contains("2000mm") && hint.contains("2000m"), "{hint}");
        for bad in ["", "m", "-2m", "0mm", "nan", "nanmm", "infm", "2 m m", "2kg", "1e999m", "+-1"]
        {
            assert!(length(bad).is_err() && focus(bad).is_err(), "{bad}");
            assert!(focus_distance(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn other_quantities_take_their_units() {
        for text in ["8", "f/8", "F8", "f8", "F/8.0"] {
            assert_eq!(f_number(text), Ok(8.0), "{text}");
        }
        for bad in ["f/", "f//8", "f/0", "ff8", "inf", "f/inf", "8mm"] {
            assert!(f_number(bad).is_err(), "{bad}");
        }
        assert_eq!(shift("1mm,-0.2cm"), shift("1,-2"));
        assert_eq!(tilt("1deg,-2°"), Ok([1.0, -2.0]));
        assert_eq!(passband("540nm..560nm"), passband("540..560"));
        assert_eq!(wavelengths("587nm, 0.5um"), wavelengths("587,500"));
        assert_eq!(sensor_size("36mmx24mm"), Ok([36.0, 24.0]));
        assert_eq!(sensor_size("36x24mm"), Ok([36.0, 24.0]));
        assert_eq!(point("1cm,-2"), Ok([10.0, -2.0]));
        assert_eq!(frequency("30lp/mm"), frequency("30"));
        assert_eq!(time("1/60s"), time("1/60"));
        assert!(time("1/60s").is_ok());
    }
}
