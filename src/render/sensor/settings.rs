//! Parser of sensor settings such as `iso=800,read=3,bits=12`.

use std::fmt;
use std::str::FromStr;

use super::{Bayer, Components, FixedPattern, HotPixels, Sensor};

/// Electrons that a full well holds, per um^2 of the pixel.
///
/// Saturation at the base speed is 0.78 lux s ([`super`]), which at 555 nm, 683 lm/W, is 3190
/// photons per um^2. Filter, fill factor and quantum efficiency of together 47 % leave 1500
/// electrons. A pixel of 6 um holds 54,000.
pub const WELL_PER_UM2: f64 = 1500.0;

/// Range of the full well (electrons). Beyond it, shot noise is less than a millionth.
const WELLS: [f64; 2] = [1.0, 1e12];

/// Longest exposure (s).
const MAX_SECONDS: f64 = 1e9;

/// Largest part of the PRNU (%). Beyond it, responses below 0 would be so many that their bound lifts the
/// mean.
const MAX_PRNU: f64 = 30.0;

/// Requested properties of a sensor. Those not given follow from the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorSettings {
    /// ISO speed; by default that of the film. It does not change the brightness of the picture: a
    /// higher speed means less light.
    pub iso: Option<f64>,
    /// Pixel pitch (um), which determines the full well; by default that of the film.
    pub pixel: Option<f64>,
    /// Full well (electrons), whatever the pitch; by default [`WELL_PER_UM2`] times the pixel's area.
    pub well: Option<f64>,
    /// Standard deviations of the read noise (electrons).
    pub read: Components,
    /// Dark current (electrons a second).
    pub dark: f64,
    /// Exposure time (s) for the dark current; by default that of the shutter.
    pub time: Option<f64>,
    /// Fixed patterns.
    pub pattern: FixedPattern,
    /// Bit depth of a code.
    pub bits: u32,
    /// The code of no light; by default a thirty-second of all codes.
    pub black: Option<u32>,
    /// The mosaic; `None` if every pixel sees all channels.
    pub bayer: Option<Bayer>,
}

impl Default for SensorSettings {
    /// Returns the settings of a current camera: 2.5 electrons of read noise, 14 bits.
    fn default() -> Self {
        Self {
            iso: None,
            pixel: None,
            well: None,
            read: Components { pixel: 2.5, ..Components::default() },
            dark: 0.0,
            time: None,
            pattern: FixedPattern::default(),
            bits: 14,
            black: None,
            bayer: None,
        }
    }
}

impl SensorSettings {
    /// Returns the sensor for a film of this ISO speed and pixel pitch (um) and a shutter that is open for
    /// `seconds`, without the filters of a camera.
    pub fn sensor(&self, film_iso: f64, film_pitch: f64, seconds: f64) -> Sensor {
        let pitch = self.pixel.unwrap_or(film_pitch);
        let well = self.well.unwrap_or(WELL_PER_UM2 * pitch * pitch);
        Sensor {
            iso: self.iso.unwrap_or(film_iso),
            full_well: well.clamp(WELLS[0], WELLS[1]),
            read_noise: self.read,
            dark_current: self.dark,
            seconds: self.time.unwrap_or(seconds),
            fixed_pattern: self.pattern,
            bits: self.bits,
            black_level: self.black.unwrap_or((1 << self.bits) / 32),
            bayer: self.bayer,
            filters: None,
        }
    }
}

/// Parses a number within bounds.
fn parse_number(name: &str, text: &str, unit: &str, [low, high]: [f64; 2]) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number| (low..=high).contains(number));
    number.ok_or_else(|| format!("{name}: expected {unit} from {low} to {high}, found {text:?}"))
}

/// Parses one number for photosites, or three between slashes: for photosites, rows and columns.
fn parse_components(name: &str, text: &str, unit: &str, most: f64) -> Result<Components, String> {
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
fn parse_hot_pixels(text: &str) -> Result<HotPixels, String> {
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

fn parse_integer(name: &str, text: &str, unit: &str, [low, high]: [u32; 2]) -> Result<u32, String> {
    let number = text.parse().ok().filter(|number| (low..=high).contains(number));
    number.ok_or_else(|| format!("{name}: expected {unit} from {low} to {high}, found {text:?}"))
}

impl FromStr for SensorSettings {
    type Err = String;

    /// Parses `name=value,name=value`; an empty text is [`SensorSettings::default`].
    fn from_str(text: &str) -> Result<Self, String> {
        let mut settings = Self::default();
        let mut seen = Vec::new();
        for word in text.split(',').map(str::trim).filter(|word| !word.is_empty()) {
            let (name, value) = word.split_once('=').unwrap_or((word, ""));
            let (name, value) = (name.trim(), value.trim());
            match name {
                "iso" => settings.iso = Some(parse_number(name, value, "a speed", [1.0, 1e7])?),
                "pixel" => settings.pixel = Some(parse_number(name, value, "um", [0.1, 1e4])?),
                "well" => settings.well = Some(parse_number(name, value, "electrons", WELLS)?),
                "read" => settings.read = parse_components(name, value, "electrons", 1e6)?,
                "dark" => {
                    settings.dark = parse_number(name, value, "electrons/s", [0.0, WELLS[1]])?;
                }
                "time" => {
                    settings.time = Some(parse_number(name, value, "seconds", [0.0, MAX_SECONDS])?)
                }
                "dsnu" => {
                    settings.pattern.dark_signal =
                        parse_components(name, value, "electrons", WELLS[1])?;
                }
                "prnu" => {
                    let percent = parse_components(name, value, "% of the signal", MAX_PRNU)?;
                    settings.pattern.response = percent.scaled(0.01);
                }
                "hot" => settings.pattern.hot = parse_hot_pixels(value)?,
                "pattern" => {
                    settings.pattern.seed = parse_integer(name, value, "a seed", [0, u32::MAX])?;
                }
                "bits" => settings.bits = parse_integer(name, value, "bits", [1, 16])?,
                "black" => settings.black = Some(parse_integer(name, value, "a code", [0, 65534])?),
                "bayer" if value.is_empty() => settings.bayer = Some(Bayer::default()),
                "bayer" => settings.bayer = Some(value.parse()?),
                _ => {
                    return Err(format!(
                        "expected NAME=VALUE with iso, pixel, well, read, dark, time, dsnu, prnu, \
                         hot, pattern, bits, black or bayer, found {word:?}"
                    ));
                }
            }
            if seen.contains(&name) {
                return Err(format!("{name} is given twice"));
            }
            seen.push(name);
        }
        let max_code = (1 << settings.bits) - 1;
        if let Some(black) = settings.black.filter(|&black| black >= max_code) {
            return Err(format!(
                "black={black}: expected less than {max_code}, the last of {} bits",
                settings.bits
            ));
        }
        Ok(settings)
    }
}

impl fmt::Display for Components {
    /// Writes one number, or three between slashes.
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { pixel, row, column } = self;
        match [*row, *column] {
            [0.0, 0.0] => write!(to, "{pixel}"),
            _ => write!(to, "{pixel}/{row}/{column}"),
        }
    }
}

impl fmt::Display for Sensor {
    /// Writes the sensor in the format of [`SensorSettings`].
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            iso, full_well: well, read_noise: read, bits, black_level: black, bayer, ..
        } = self;
        write!(to, "iso={iso},well={well:.0},read={read},bits={bits},black={black}")?;
        let none = Components::default();
        let FixedPattern { seed, dark_signal, response, hot } = &self.fixed_pattern;
        if self.dark_current > 0.0 {
            write!(to, ",dark={}", self.dark_current)?;
        }
        if self.dark_current > 0.0 || hot.share > 0.0 {
            write!(to, ",time={}", self.seconds)?;
        }
        if *dark_signal != none {
            write!(to, ",dsnu={dark_signal}")?;
        }
        if *response != none {
            // Shares times 100 are not quite the decimals that were read.
            let percent = |share: f64| (share * 1e8).round() / 1e6;
            let Components { pixel, row, column } = *response;
            let [pixel, row, column] = [pixel, row, column].map(percent);
            write!(to, ",prnu={}", Components { pixel, row, column })?;
        }
        if hot.share > 0.0 {
            write!(to, ",hot={}/{}", hot.share, hot.dark_current)?;
        }
        if *seed != 0 {
            write!(to, ",pattern={seed}")?;
        }
        match bayer {
            Some(bayer) => write!(to, ",bayer={bayer}"),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn omitted_settings_follow_from_the_film() {
        let sensor = SensorSettings::default().sensor(400.0, 6.0, 0.02);
        let expected = Sensor {
            iso: 400.0,
            full_well: 54_000.0,
            read_noise: Components { pixel: 2.5, ..Components::default() },
            dark_current: 0.0,
            seconds: 0.02,
            fixed_pattern: FixedPattern::default(),
            bits: 14,
            black_level: 512,
            bayer: None,
            filters: None,
        };
        assert_eq!(sensor, expected);
        let said: SensorSettings = "iso=800, read=3,well=40000,bits=12,bayer".parse().unwrap();
        let expected = Sensor {
            iso: 800.0,
            full_well: 40_000.0,
            read_noise: Components { pixel: 3.0, ..Components::default() },
            bits: 12,
            black_level: 128,
            bayer: Some(Bayer::Rggb),
            ..Sensor::default()
        };
        assert_eq!(said.sensor(100.0, 6.0, 0.0), expected);
        let pitch: SensorSettings = "pixel=4".parse().unwrap();
        assert_eq!(pitch.sensor(100.0, 45.0, 1.0).full_well, 24_000.0);
        let both: SensorSettings = "well=9000,pixel=4".parse().unwrap();
        assert_eq!(both.sensor(100.0, 45.0, 1.0).full_well, 9_000.0);
    }

    #[test]
    fn the_default_full_well_matches_the_saturation_of_iso_12232() {
        let photon = 6.626_070_15e-34 * 2.997_924_58e8 / 555e-9;
        let photons = 0.78 / 683.0 * 1e-12 / photon;
        assert!((WELL_PER_UM2 / photons - 0.47).abs() < 0.005, "{photons} photons on a um^2");
    }

    #[test]
    fn display_and_parse_round_trip() {
        for text in [
            "iso=1250,well=40000,read=1.25,bits=12,black=64,bayer=gbrg",
            "iso=100,well=9000,read=1.5/0.25/0,bits=12,black=64,dark=12.5,time=0.5,dsnu=0.8,prnu=0.7/0.1/0.3",
            "iso=100,well=9000,read=0,bits=10,black=4,time=8,dsnu=1/0/2,hot=0.0001/500,pattern=77",
        ] {
            let settings: SensorSettings = text.parse().unwrap();
            assert_eq!(settings.sensor(100.0, 1.0, 3.0).to_string(), text);
        }
    }

    #[test]
    fn invalid_settings_are_refused_with_a_reason() {
        for (text, expected) in [
            (
                "scene.pbrt",
                "expected NAME=VALUE with iso, pixel, well, read, dark, time, dsnu, prnu, hot, pattern, bits, \
                 black or bayer, found",
            ),
            ("iso=0", "iso: expected a speed from 1 to 10000000, found \"0\""),
            ("iso", "found \"\""),
            ("well=nan", "well: expected electrons"),
            ("read=-1", "read: expected electrons from 0"),
            ("read=inf", "read: expected electrons from 0"),
            ("read=1/2/3/4", "three such numbers PIXEL/ROW/COLUMN, found \"1/2/3/4\""),
            ("dsnu=1/x", "dsnu: expected electrons from 0 to 1000000000000"),
            ("prnu=31", "prnu: expected % of the signal from 0 to 30"),
            ("read=1/2", "three such numbers PIXEL/ROW/COLUMN, found \"1/2\""),
            ("dark=-1", "dark: expected electrons/s from 0"),
            ("time=-1", "time: expected seconds from 0"),
            ("hot=0.1", "hot: expected SHARE/CURRENT"),
            ("hot=2/10", "hot: expected SHARE/CURRENT, a share from 0 to 1"),
            ("pattern=-3", "pattern: expected a seed from 0"),
            ("bits=17", "bits: expected bits from 1 to 16"),
            ("bits=2.5", "bits: expected bits from 1 to 16"),
            ("bits=8,black=255", "expected less than 255, the last of 8 bits"),
            ("black=5000,bits=12", "expected less than 4095"),
            ("bayer=rgb", "expected rggb, bggr, grbg or gbrg, found \"rgb\""),
            ("iso=100,iso=200", "iso is given twice"),
        ] {
            let said = text.parse::<SensorSettings>().expect_err(text);
            assert!(said.contains(expected), "{text}: {said}");
        }
        assert_eq!("".parse(), Ok(SensorSettings::default()));
    }
}
