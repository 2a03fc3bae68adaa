//! Text of sensor settings, such as `iso=800,read=3,bits=12`.

use std::fmt;
use std::path::Path;
use std::str::FromStr;

use super::setting_values::{
    TEMPERATURES, WELLS, parse_binning, parse_components, parse_crosstalk, parse_dark_current,
    parse_hot_pixels, parse_integer, parse_microlenses, parse_number,
};
use super::{Bayer, Components, FixedPattern, Microlenses, Sensor, SensorSettings, sensor_file};

/// Range of the ISO speed.
pub(super) const SPEEDS: [f64; 2] = [1.0, 1e7];

/// Longest exposure (s).
const MAX_SECONDS: f64 = 1e9;

/// Largest part of the PRNU (%). Beyond it, responses below 0 would be so many that their bound lifts the
/// mean.
const MAX_PRNU: f64 = 30.0;

/// Names of the settings.
pub(super) const NAMES: [&str; 19] = [
    "iso",
    "gain",
    "pixel",
    "well",
    "read",
    "dark",
    "temperature",
    "time",
    "dsnu",
    "prnu",
    "hot",
    "pattern",
    "crosstalk",
    "binning",
    "hdr",
    "microlens",
    "bits",
    "black",
    "bayer",
];

/// Returns the words of settings.
fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(',').map(str::trim).filter(|word| !word.is_empty())
}

impl SensorSettings {
    /// Returns the name of the sensor file that settings begin with, if they do.
    pub fn file_name(text: &str) -> Option<&str> {
        words(text).next().filter(|word| !word.contains('=') && word.ends_with(".toml"))
    }

    /// Parses `name=value,name=value`, after the name of a sensor file if there is one, in a folder;
    /// an empty text is [`SensorSettings::default`].
    ///
    /// # Errors
    /// Returns what is wrong and what is expected, with file, line and column if it is in a file.
    pub fn parse_in(folder: &Path, text: &str) -> Result<Self, String> {
        let mut words = words(text).peekable();
        let file = Self::file_name(text);
        if file.is_some() {
            words.next();
        }
        let mut settings = match file {
            Some(file) => sensor_file::read(&folder.join(file))?,
            None => Self::default(),
        };
        let mut seen = Vec::new();
        for word in words {
            let (name, value) = word.split_once('=').unwrap_or((word, ""));
            let (name, value) = (name.trim(), value.trim());
            if !NAMES.contains(&name) {
                let [names @ .., last] = NAMES;
                return Err(format!(
                    "expected NAME=VALUE with {} or {last}, or a file NAME.toml before them, found {word:?}",
                    names.join(", ")
                ));
            }
            if seen.contains(&name) {
                return Err(format!("{name} is given twice"));
            }
            settings.set(name, value)?;
            seen.push(name);
        }
        check_names(&seen)?;
        settings.check().map_err(|(name, problem)| match (file, seen.contains(&name)) {
            (Some(file), false) => format!("{file}: {problem}"),
            _ => problem,
        })?;
        Ok(settings)
    }

    /// Sets one of [`NAMES`]. Speed and gain replace each other.
    pub(super) fn set(&mut self, name: &str, value: &str) -> Result<(), String> {
        match name {
            "iso" => {
                self.iso = Some(parse_number(name, value, "a speed", SPEEDS)?);
                self.gain = None;
            }
            "gain" => {
                self.gain = Some(parse_number(name, value, "codes per electron", [1e-9, 1e6])?);
                self.iso = None;
            }
            "pixel" => self.pixel = Some(parse_number(name, value, "um", [0.1, 1e4])?),
            "well" => self.well = Some(parse_number(name, value, "electrons", WELLS)?),
            "read" => self.read = parse_components(name, value, "electrons", 1e6)?,
            "dark" => self.dark = parse_dark_current(value)?,
            "temperature" => {
                let temperature = parse_number(name, value, "degrees Celsius", TEMPERATURES)?;
                self.temperature = Some(temperature);
            }
            "time" => self.time = Some(parse_number(name, value, "seconds", [0.0, MAX_SECONDS])?),
            "dsnu" => {
                self.pattern.dark_signal = parse_components(name, value, "electrons", WELLS[1])?;
            }
            "prnu" => {
                let percent = parse_components(name, value, "% of the signal", MAX_PRNU)?;
                self.pattern.response = percent.scaled(0.01);
            }
            "hot" => self.pattern.hot = parse_hot_pixels(value)?,
            "pattern" => self.pattern.seed = parse_integer(name, value, "a seed", [0, u32::MAX])?,
            "crosstalk" => self.crosstalk = parse_crosstalk(value)?,
            "binning" => self.binning = parse_binning(value)?,
            "hdr" => {
                self.hdr = parse_number(name, value, "a ratio of sensitivities", [1.0, 65536.0])?
            }
            "microlens" => self.microlenses = Some(parse_microlenses(value)?),
            "bits" => self.bits = parse_integer(name, value, "bits", [1, 16])?,
            "black" => self.black = Some(parse_integer(name, value, "a code", [0, 65534])?),
            "bayer" if value.is_empty() => self.bayer = Some(Bayer::default()),
            "bayer" => {
                let pattern = value.parse::<Bayer>();
                self.bayer = Some(pattern.map_err(|problem| format!("bayer: {problem}"))?);
            }
            _ => return Err(format!("there is no setting {name:?}")),
        }
        Ok(())
    }

    /// Checks settings against each other. Errors come with the name of the setting at fault.
    pub(super) fn check(&self) -> Result<(), (&'static str, String)> {
        let max_code = (1 << self.bits) - 1;
        if let Some(black) = self.black.filter(|&black| black >= max_code) {
            let bits = self.bits;
            let problem =
                format!("black={black}: expected less than {max_code}, the last of {bits} bits");
            return Err(("black", problem));
        }
        let Some(temperature) = self.temperature else { return Ok(()) };
        let fault = |problem: &str| {
            Err(("temperature", format!("temperature={temperature}: expected {problem}")))
        };
        if self.dark.reference.is_none() {
            return fault(
                "dark=CURRENT@CELSIUS/KELVIN, a current with its temperature and the rise that doubles it, beside it",
            );
        }
        let factor = self.dark.factor(Some(temperature));
        let currents = [self.dark.current, self.pattern.hot.dark_current];
        match currents.iter().all(|current| (0.0..=WELLS[1]).contains(&(factor * current))) {
            true => Ok(()),
            false => fault("a temperature with dark currents below 1e12 electrons/s"),
        }
    }
}

/// Checks that no two of these settings, of one file or one text, exclude each other.
pub(super) fn check_names(names: &[&str]) -> Result<(), String> {
    match names.contains(&"iso") && names.contains(&"gain") {
        true => Err("iso and gain are both given; expected one of them".to_owned()),
        false => Ok(()),
    }
}

impl FromStr for SensorSettings {
    type Err = String;

    /// Parses settings as [`SensorSettings::parse_in`] does, in the working folder.
    fn from_str(text: &str) -> Result<Self, String> {
        Self::parse_in(Path::new(""), text)
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
        // Shares times 100 are not quite the decimals that were read.
        let percent = |share: f64| (share * 1e8).round() / 1e6;
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
        if !self.crosstalk.is_none() {
            let [red, green, blue] = self.crosstalk.0.map(percent);
            match red == green && green == blue {
                true => write!(to, ",crosstalk={red}")?,
                false => write!(to, ",crosstalk={red}/{green}/{blue}")?,
            }
        }
        if self.hdr > 1.0 {
            write!(to, ",hdr={}", self.hdr)?;
        }
        if let Some(vignetting) = &self.vignetting {
            let Microlenses { half_angle, corner_angle } = vignetting.microlenses;
            write!(to, ",microlens={half_angle}/{corner_angle}")?;
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
    fn display_and_parse_round_trip() {
        for text in [
            "iso=1250,well=40000,read=1.25,bits=12,black=64,bayer=gbrg",
            "iso=100,well=9000,read=1.5/0.25/0,bits=12,black=64,dark=12.5,time=0.5,dsnu=0.8,prnu=0.7/0.1/0.3",
            "iso=1000,well=9000,read=2,bits=12,black=64,dark=40,time=0.5",
            "iso=100,well=9000,read=0,bits=10,black=4,time=8,dsnu=1/0/2,hot=0.0001/500,pattern=77",
            "iso=100,well=9000,read=0,bits=10,black=4,hdr=16,bayer=rggb",
            "iso=100,well=9000,read=0,bits=10,black=4,crosstalk=3.5,bayer=quad-rggb",
            "iso=100,well=9000,read=0,bits=10,black=4,prnu=0.7,crosstalk=4/2.5/1",
        ] {
            let settings: SensorSettings = text.parse().unwrap();
            assert_eq!(settings.sensor(100.0, 1.0, 3.0).to_string(), text);
        }
    }

    #[test]
    fn dark_current_doubles_with_each_step_of_temperature() {
        let sensor = |text: &str| -> Sensor {
            text.parse::<SensorSettings>().unwrap().sensor(100.0, 1.0, 3.0)
        };
        for (temperature, factor) in [("", 1.0), (",temperature=25", 1.0), (",temperature=39", 4.0)]
        {
            let found = sensor(&format!("dark=3@25/7,hot=0.1/50{temperature}"));
            assert!((found.dark_current / (3.0 * factor) - 1.0).abs() < 1e-12, "{found:?}");
            let hot = found.fixed_pattern.hot.dark_current;
            assert!((hot / (50.0 * factor) - 1.0).abs() < 1e-12, "{found:?}");
        }
        assert!((sensor("dark=3@25/7,temperature=11").dark_current - 0.75).abs() < 1e-12);
    }

    #[test]
    fn the_gain_is_that_of_the_codes() {
        let sensor = "gain=0.5,well=20000,bits=12,black=95".parse::<SensorSettings>().unwrap();
        let sensor = sensor.sensor(400.0, 1.0, 0.0);
        // 4000 codes span 8000 electrons.
        assert_eq!([sensor.iso, sensor.white_electrons()], [250.0, 8000.0]);
        let same: SensorSettings = sensor.to_string().parse().unwrap();
        assert_eq!(same.sensor(100.0, 1.0, 0.0), sensor);
        let steep = "gain=1e6,well=1e12".parse::<SensorSettings>().unwrap();
        assert_eq!(steep.sensor(400.0, 1.0, 0.0).iso, 1e7);
    }

    #[test]
    fn invalid_settings_are_refused_with_a_reason() {
        for (text, expected) in [
            (
                "scene.pbrt",
                "expected NAME=VALUE with iso, gain, pixel, well, read, dark, temperature, time, dsnu, prnu, hot, \
                 pattern, crosstalk, binning, hdr, microlens, bits, black or bayer, or a file NAME.toml before them, found \"scene.pbrt\"",
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
            ("dark=3@25", "or CURRENT@CELSIUS/KELVIN with the temperature of that current"),
            ("dark=3@25/0", "found \"3@25/0\""),
            ("temperature=-300", "temperature: expected degrees Celsius from -273.15 to 500"),
            ("temperature=40,dark=3", "temperature=40: expected dark=CURRENT@CELSIUS/KELVIN"),
            ("gain=0", "gain: expected codes per electron"),
            ("iso=200,gain=1", "iso and gain are both given"),
            (
                "dark=1@25/0.1,temperature=500",
                "temperature=500: expected a temperature with dark currents below",
            ),
            (
                "dark=0@25/0.1,temperature=500",
                "temperature=500: expected a temperature with dark currents below",
            ),
            ("missing.toml", "missing.toml"),
            ("time=-1", "time: expected seconds from 0"),
            ("hot=0.1", "hot: expected SHARE/CURRENT"),
            ("hot=2/10", "hot: expected SHARE/CURRENT, a share from 0 to 1"),
            ("pattern=-3", "pattern: expected a seed from 0"),
            ("bits=17", "bits: expected bits from 1 to 16"),
            ("bits=2.5", "bits: expected bits from 1 to 16"),
            ("bits=8,black=255", "expected less than 255, the last of 8 bits"),
            ("black=5000,bits=12", "expected less than 4095"),
            (
                "bayer=rgb",
                "bayer: expected rggb, bggr, grbg or gbrg, or quad- before them, found \"rgb\"",
            ),
            ("binning=0", "binning: expected photosites along a side from 1 to 16"),
            ("binning=2/light", "and charge or codes, such as 2/charge, found \"2/light\""),
            ("hdr=0.5", "hdr: expected a ratio of sensitivities from 1 to 65536"),
            ("microlens=0", "microlens: expected HALF or HALF/CORNER"),
            ("microlens=20/95", "found \"20/95\""),
            ("crosstalk=41", "crosstalk: expected % from 0 to 40"),
            ("crosstalk=1/2", "or three such numbers RED/GREEN/BLUE, found \"1/2\""),
            ("iso=100,iso=200", "iso is given twice"),
        ] {
            let said = text.parse::<SensorSettings>().expect_err(text);
            assert!(said.contains(expected), "{text}: {said}");
        }
        assert_eq!("".parse(), Ok(SensorSettings::default()));
    }
}
