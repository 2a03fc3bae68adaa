//! What may be said about a sensor, in words such as `iso=800,read=3,bits=12`.

use std::fmt;
use std::str::FromStr;

use super::{Bayer, Sensor};

/// Electrons that a full well holds, per um^2 of the pixel.
///
/// Saturation at the base speed is 0.78 lux s ([`super`]), which at 555 nm, 683 lm/W, is 3190
/// photons on a um^2; 1500 of them are counted where filter, fill factor and quantum efficiency
/// let 47 % through. A pixel of 6 um holds 54,000.
pub const WELL_PER_UM2: f64 = 1500.0;

/// Fewest and most electrons of a well. Shot noise beyond is under a millionth.
const WELLS: [f64; 2] = [1.0, 1e12];

/// What is asked of a sensor. What is not said follows from the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// ISO speed; that of the film if not given. The picture stays as bright: a higher speed means
    /// that it is taken with less light.
    pub iso: Option<f64>,
    /// Pitch of the pixels, um, which the well follows from; that of the film if not given.
    pub pixel: Option<f64>,
    /// Full well, electrons; [`WELL_PER_UM2`] on the pixel's area if not given.
    pub well: Option<f64>,
    /// Standard deviation of the read noise, electrons.
    pub read: f64,
    /// Bits of a code.
    pub bits: u32,
    /// The code of no light; a thirty-second of all codes if not given.
    pub black: Option<u32>,
    /// The colour filters, if every pixel sees one channel only.
    pub bayer: Option<Bayer>,
}

impl Default for Settings {
    /// A camera of these years: 2.5 electrons of read noise, 14 bits.
    fn default() -> Self {
        Self { iso: None, pixel: None, well: None, read: 2.5, bits: 14, black: None, bayer: None }
    }
}

impl Settings {
    /// The sensor behind a film of this speed whose pixels have this pitch, um.
    pub fn sensor(&self, film_iso: f64, film_pitch: f64) -> Sensor {
        let pitch = self.pixel.unwrap_or(film_pitch);
        let well = self.well.unwrap_or(WELL_PER_UM2 * pitch * pitch);
        Sensor {
            iso: self.iso.unwrap_or(film_iso),
            well: well.clamp(WELLS[0], WELLS[1]),
            read: self.read,
            bits: self.bits,
            black: self.black.unwrap_or((1 << self.bits) / 32),
            bayer: self.bayer,
        }
    }
}

/// A number within bounds.
fn number(name: &str, text: &str, unit: &str, [low, high]: [f64; 2]) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number| (low..=high).contains(number));
    number.ok_or_else(|| format!("{name}: expected {unit} from {low} to {high}, found {text:?}"))
}

fn whole(name: &str, text: &str, unit: &str, [low, high]: [u32; 2]) -> Result<u32, String> {
    let number = text.parse().ok().filter(|number| (low..=high).contains(number));
    number.ok_or_else(|| format!("{name}: expected {unit} from {low} to {high}, found {text:?}"))
}

impl FromStr for Settings {
    type Err = String;

    /// Reads `name=value,name=value`; an empty text is [`Settings::default`].
    fn from_str(text: &str) -> Result<Self, String> {
        let mut settings = Self::default();
        let mut seen = Vec::new();
        for word in text.split(',').map(str::trim).filter(|word| !word.is_empty()) {
            let (name, value) = word.split_once('=').unwrap_or((word, ""));
            let (name, value) = (name.trim(), value.trim());
            match name {
                "iso" => settings.iso = Some(number(name, value, "a speed", [1.0, 1e7])?),
                "pixel" => settings.pixel = Some(number(name, value, "um", [0.1, 1e4])?),
                "well" => settings.well = Some(number(name, value, "electrons", WELLS)?),
                "read" => settings.read = number(name, value, "electrons", [0.0, 1e6])?,
                "bits" => settings.bits = whole(name, value, "bits", [1, 16])?,
                "black" => settings.black = Some(whole(name, value, "a code", [0, 65534])?),
                "bayer" if value.is_empty() => settings.bayer = Some(Bayer::default()),
                "bayer" => settings.bayer = Some(value.parse()?),
                _ => {
                    return Err(format!(
                        "expected NAME=VALUE with iso, pixel, well, read, bits, black or bayer, \
                         found {word:?}"
                    ));
                }
            }
            if seen.contains(&name) {
                return Err(format!("{name} is given twice"));
            }
            seen.push(name);
        }
        let top = (1 << settings.bits) - 1;
        if let Some(black) = settings.black.filter(|&black| black >= top) {
            return Err(format!(
                "black={black}: expected less than {top}, the last of {} bits",
                settings.bits
            ));
        }
        if settings.pixel.is_some() && settings.well.is_some() {
            return Err("well and pixel are given; the pitch only says how large the well is, \
                        leave one out"
                .to_owned());
        }
        Ok(settings)
    }
}

impl fmt::Display for Sensor {
    /// As [`Settings`] are written.
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { iso, well, read, bits, black, bayer } = self;
        write!(to, "iso={iso},well={well:.0},read={read},bits={bits},black={black}")?;
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
    fn what_is_not_said_follows_from_the_film() {
        let sensor = Settings::default().sensor(400.0, 6.0);
        let expected =
            Sensor { iso: 400.0, well: 54_000.0, read: 2.5, bits: 14, black: 512, bayer: None };
        assert_eq!(sensor, expected);
        let said: Settings = "iso=800, read=3,well=40000,bits=12,bayer".parse().unwrap();
        let expected = Sensor {
            iso: 800.0,
            well: 40_000.0,
            read: 3.0,
            bits: 12,
            black: 128,
            bayer: Some(Bayer::Rggb),
        };
        assert_eq!(said.sensor(100.0, 6.0), expected);
        let pitch: Settings = "pixel=4".parse().unwrap();
        assert_eq!(pitch.sensor(100.0, 45.0).well, 24_000.0);
    }

    #[test]
    fn the_well_is_what_the_saturation_of_iso_12232_leaves() {
        let photon = 6.626_070_15e-34 * 2.997_924_58e8 / 555e-9;
        let photons = 0.78 / 683.0 * 1e-12 / photon;
        assert!((WELL_PER_UM2 / photons - 0.47).abs() < 0.005, "{photons} photons on a um^2");
    }

    #[test]
    fn a_sensor_is_written_as_it_is_read() {
        let text = "iso=1250,well=40000,read=1.25,bits=12,black=64,bayer=gbrg";
        let settings: Settings = text.parse().unwrap();
        assert_eq!(settings.sensor(100.0, 1.0).to_string(), text);
    }

    #[test]
    fn nonsense_is_refused_in_words() {
        for (text, expected) in [
            (
                "scene.pbrt",
                "expected NAME=VALUE with iso, pixel, well, read, bits, black or bayer, found",
            ),
            ("iso=0", "iso: expected a speed from 1 to 10000000, found \"0\""),
            ("iso", "found \"\""),
            ("well=nan", "well: expected electrons"),
            ("read=-1", "read: expected electrons from 0"),
            ("read=inf", "read: expected electrons from 0"),
            ("bits=17", "bits: expected bits from 1 to 16"),
            ("bits=2.5", "bits: expected bits from 1 to 16"),
            ("bits=8,black=255", "expected less than 255, the last of 8 bits"),
            ("black=5000,bits=12", "expected less than 4095"),
            ("bayer=rgb", "expected rggb, bggr, grbg or gbrg, found \"rgb\""),
            ("iso=100,iso=200", "iso is given twice"),
            ("well=100,pixel=6", "leave one out"),
        ] {
            let said = text.parse::<Settings>().expect_err(text);
            assert!(said.contains(expected), "{text}: {said}");
        }
        assert_eq!("".parse(), Ok(Settings::default()));
    }
}
