//! Parsers of option values.

use std::ops::Range;
use std::sync::Arc;
use std::time::Duration;

use petzval_image::{BitDepth, RawFile, WhiteBalance};
use petzval_lens::{FILM_SIZES, film_size};
use petzval_render::prepare::settings::{
    self, Assignment, LENGTHS, PictureSetting, SettingError, SettingValue, UnitRange,
    number_with_unit,
};

/// Returns the parser of an option that is a setting of a picture.
pub(in crate::cli) fn setting(
    name: &'static str,
) -> impl Fn(&str) -> Result<Assignment, String> + Clone + Send + Sync {
    move |text| {
        let setting = PictureSetting::named(name).ok_or_else(|| format!("no setting '{name}'"))?;
        typed(|value| setting.read(value))(text)
    }
}

/// Returns the parser of words that a reader of a setting reads.
pub(in crate::cli) fn typed<T>(
    read: impl Fn(&SettingValue) -> Result<T, SettingError> + Clone,
) -> impl Fn(&str) -> Result<T, String> + Clone {
    move |text| read(&SettingValue::Words(text.to_owned())).map_err(|error| error.to_string())
}

/// Parses `N` whole numbers.
fn list<const N: usize>(text: &str, separator: char) -> Option<[u32; N]> {
    let numbers: Vec<u32> =
        text.split(separator).map(|part| part.trim().parse().ok()).collect::<Option<_>>()?;
    numbers.try_into().ok()
}

/// Parses a finite length of any sign (mm).
pub(in crate::cli) fn signed_length(text: &str) -> Option<f64> {
    number_with_unit(text, LENGTHS, 1.0)
}

/// Parses two finite lengths (mm).
pub(in crate::cli) fn point(text: &str) -> Result<[f64; 2], String> {
    let lengths: Option<Vec<f64>> = text.split(',').map(signed_length).collect();
    let point = lengths.and_then(|lengths| lengths.try_into().ok());
    point.ok_or_else(|| "expected two lengths X,Y in mm, such as 0,10 or 0mm,10mm".to_owned())
}

/// Parses a pixel pitch (um).
pub(in crate::cli) fn pixel_pitch(text: &str) -> Result<f64, String> {
    let pitch = number_with_unit(text, &[("um", 1.0), ("mm", 1e3)], 1.0);
    let known = pitch.filter(|pitch| (0.01..=1e5).contains(pitch));
    known.ok_or_else(|| "expected a pitch from 0.01 to 100000 um".to_owned())
}

/// Parses the bits of a channel.
pub(in crate::cli) fn bit_depth(text: &str) -> Result<BitDepth, String> {
    match text {
        "8" => Ok(BitDepth::Eight),
        "16" => Ok(BitDepth::Sixteen),
        _ => Err("expected 8 or 16".to_owned()),
    }
}

pub(in crate::cli) fn pixel(text: &str) -> Result<[u32; 2], String> {
    list(text, ',').ok_or_else(|| "expected two whole numbers X,Y".to_owned())
}

/// A finite number above 0.
const ABOVE_ZERO: [f64; 2] = [f64::MIN_POSITIVE, f64::MAX];

/// Parses a spatial frequency (cycles/mm).
pub(in crate::cli) fn frequency(text: &str) -> Result<f64, String> {
    let frequency = UnitRange {
        units: &[("cycles/mm", 1.0), ("lp/mm", 1.0), ("/mm", 1.0)],
        unit: 1.0,
        name: "cycles/mm",
        range: ABOVE_ZERO,
        words: "a frequency above 0 in cycles/mm, such as 30 or 30/mm",
    };
    frequency.parse(text)
}

/// Parses a number; infinity is allowed. NaN is refused, as every picture would pass it.
pub(in crate::cli) fn limit(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| !number.is_nan());
    number.ok_or_else(|| "expected a number such as 0.05".to_owned())
}

/// Parses `--sensor`, whose value is optional: the next word may have been meant as something else.
pub(in crate::cli) fn sensor(text: &str) -> Result<Assignment, String> {
    setting("sensor")(text).map_err(|problem| match text.contains('=') || text.contains(".toml") {
        true => problem,
        false => format!("{problem}; to give no value, put another option after --sensor"),
    })
}

/// Time between checkpoints; `None` for no checkpoints.
#[derive(Clone, Copy, Debug)]
pub(in crate::cli) struct CheckpointInterval(pub Option<Duration>);

pub(in crate::cli) fn checkpoint_interval(text: &str) -> Result<CheckpointInterval, String> {
    if ["off", "0", "0s"].contains(&text) {
        return Ok(CheckpointInterval(None));
    }
    typed(settings::time)(text)
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
    WhiteBalance::parse(text, "off")
}

/// Parses the light of the white balance of a raw file, which has one of its own.
pub(in crate::cli) fn raw_white_balance(text: &str) -> Result<WhiteBalance, String> {
    WhiteBalance::parse(text, RawFile::AS_SHOT)
}

/// Parses wavelengths (nm).
pub(in crate::cli) fn wavelengths(text: &str) -> Result<Arc<[f64]>, String> {
    let nm = [("nm", 1.0), ("um", 1e3)];
    let one = |part: &str| number_with_unit(part, &nm, 1.0).filter(|nm| (100.0..=1e5).contains(nm));
    let all: Option<Arc<[f64]>> = text.split(',').map(one).collect();
    all.ok_or_else(|| {
        "expected wavelengths from 100 to 100000 nm with commas between, such as 486.1,587.6,656.3"
            .to_owned()
    })
}

/// Parses the width and height of a sensor (mm), or its name.
pub(in crate::cli) fn sensor_size(text: &str) -> Result<[f64; 2], String> {
    if let Some(known) = film_size(text) {
        return Ok(known.size);
    }
    let side =
        |part: &str| number_with_unit(part, LENGTHS, 1.0).filter(|mm| (1e-3..=1e4).contains(mm));
    let sides = text.split_once('x').map(|(width, height)| [side(width), side(height)]);
    match sides {
        Some([Some(width), Some(height)]) => Ok([width, height]),
        _ => {
            let names: Vec<&str> = FILM_SIZES.iter().map(|size| size.name).collect();
            let names = names.join(", ");
            Err(format!("expected WxH in mm, such as 36x24 or 36mmx24mm, or one of {names}"))
        }
    }
}

/// Largest distance (m) that a number alone gives a command for lens files. A larger one was more
/// likely meant in mm, which lens files are in.
const FARTHEST_ALONE: f64 = 100.0;

/// Parses a distance in focus as [`settings::focus`] does, for commands without a scene, in mm.
pub(in crate::cli) fn focus_distance(text: &str) -> Result<f64, String> {
    let alone = text.trim().parse::<f64>().ok().filter(|number| number.is_finite());
    if let Some(number) = alone.filter(|number| *number > FARTHEST_ALONE) {
        return Err(format!("a number alone is in metres; write {number}mm, or {number}m"));
    }
    let distance = UnitRange {
        units: LENGTHS,
        unit: if alone.is_some() { 1e3 } else { 1.0 },
        name: "m",
        range: [f64::MIN_POSITIVE, f64::INFINITY],
        words: "a distance above 0 such as 2m or 850mm (a number alone is in m), or inf",
    };
    distance.parse(text).map(|length| length * distance.unit)
}

/// Parses a finite length (mm).
pub(in crate::cli) fn length(text: &str) -> Result<f64, String> {
    let length = UnitRange {
        units: LENGTHS,
        unit: 1.0,
        name: "mm",
        range: ABOVE_ZERO,
        words: "a length above 0 such as 36mm or 3.6cm (a number alone is in mm)",
    };
    length.parse(text)
}

#[cfg(test)]
mod tests {
    use petzval_render::prepare::FocusOn;

    use super::*;

    #[test]
    fn lengths_take_their_units_and_numbers_alone_keep_theirs() {
        for (text, mm) in
            [("2m", 2000.0), ("850mm", 850.0), ("85 cm", 850.0), ("3", 3.0), ("500um", 0.5)]
        {
            assert!((length(text).unwrap() - mm).abs() < 1e-12 * mm, "{text}");
        }
        // One meaning of a number alone in all commands.
        for text in ["2", "2m", "850mm", "inf", "2.5e-1m", "0.1", "100"] {
            let Ok(FocusOn::Distance(metres)) = typed(settings::focus)(text) else {
                panic!("{text}")
            };
            let found = focus_distance(text).unwrap();
            assert!(found == 1e3 * metres || (found / 1e3 / metres - 1.0).abs() < 1e-15);
        }
        assert_eq!(focus_distance("3720.8515mm"), Ok(3720.8515));
        let hint = focus_distance("2000").unwrap_err();
        assert!(hint.contains("2000mm") && hint.contains("2000m"), "{hint}");
        for bad in ["", "m", "-2m", "0mm", "nan", "nanmm", "infm", "2 m m", "2kg", "1e999m", "+-1"]
        {
            assert!(length(bad).is_err() && focus_distance(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn other_quantities_take_their_units() {
        assert_eq!(wavelengths("587nm, 0.5um"), wavelengths("587,500"));
        assert_eq!(sensor_size("36mmx24mm"), Ok([36.0, 24.0]));
        assert_eq!(sensor_size("36x24mm"), Ok([36.0, 24.0]));
        assert_eq!(point("1cm,-2"), Ok([10.0, -2.0]));
        assert_eq!(frequency("30lp/mm"), frequency("30"));
    }
}
