//! Settings of a sensor, and the sensor of a film that they give.

use super::setting_values::WELLS;
use super::settings_text::SPEEDS;
use super::{BASE_ISO, Bayer, Binning, Components, Crosstalk, FixedPattern, Microlenses, Sensor};

/// Electrons that a full well holds, per um^2 of the pixel.
///
/// Saturation at the base speed is 0.78 lux s ([`super`]), which at 555 nm, 683 lm/W, is 3190
/// photons per um^2. Filter, fill factor and quantum efficiency of together 47 % leave 1500
/// electrons. A pixel of 6 um holds 54,000.
pub const WELL_PER_UM2: f64 = 1500.0;

/// Dark current of a photosite.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DarkCurrent {
    /// The current (electrons a second), at the reference temperature if there is one.
    pub current: f64,
    /// Reference temperature (degrees Celsius), and the rise that doubles the current (K).
    pub reference: Option<[f64; 2]>,
}

impl DarkCurrent {
    /// Returns the factor from the current at the reference temperature to that at another (degrees Celsius):
    /// 2^((T - T_ref) / T_d), equation 11 of EMVA 1288 (release 3.1, 2016).
    pub(super) fn factor(&self, temperature: Option<f64>) -> f64 {
        let at = self.reference.zip(temperature);
        at.map_or(1.0, |([reference, doubling], at)| ((at - reference) / doubling).exp2())
    }
}

/// Requested properties of a sensor. Those not given follow from the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorSettings {
    /// ISO speed; by default that of the film. It does not change the brightness of the picture: a
    /// higher speed means less light.
    pub iso: Option<f64>,
    /// System gain (codes per electron), in place of the ISO speed, which follows from it.
    pub gain: Option<f64>,
    /// Pixel pitch (um), which determines the full well; by default that of the film.
    pub pixel: Option<f64>,
    /// Full well (electrons), whatever the pitch; by default [`WELL_PER_UM2`] times the pixel's area.
    pub well: Option<f64>,
    /// Standard deviations of the read noise (electrons).
    pub read: Components,
    /// Dark current.
    pub dark: DarkCurrent,
    /// Temperature (degrees Celsius), if the dark current has a reference. Hot pixels follow it too.
    pub temperature: Option<f64>,
    /// Exposure time (s) for the dark current; by default that of the shutter.
    pub time: Option<f64>,
    /// Fixed patterns.
    pub pattern: FixedPattern,
    /// Shares of the charge that neighbours collect.
    pub crosstalk: Crosstalk,
    /// Photosites of a pixel.
    pub binning: Binning,
    /// Sensitivity relative to that of a second photosite in each pixel; 1 for none.
    pub hdr: f64,
    /// Microlenses, which lose oblique light.
    pub microlenses: Option<Microlenses>,
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
            gain: None,
            pixel: None,
            well: None,
            read: Components { pixel: 2.5, ..Components::default() },
            dark: DarkCurrent::default(),
            temperature: None,
            time: None,
            pattern: FixedPattern::default(),
            crosstalk: Crosstalk::default(),
            binning: Binning::NONE,
            hdr: 1.0,
            microlenses: None,
            bits: 14,
            black: None,
            bayer: None,
        }
    }
}

impl SensorSettings {
    /// Returns the sensor for a film of this ISO speed and pixel pitch (um) and a shutter that is open for
    /// `seconds`, without the filters of a camera and the microlenses behind its lens.
    pub fn sensor(&self, film_iso: f64, film_pitch: f64, seconds: f64) -> Sensor {
        let binning = self.binning;
        let pitch = self.pixel.unwrap_or(film_pitch / f64::from(binning.side));
        let well = self.well.unwrap_or(WELL_PER_UM2 * pitch * pitch) * binning.count();
        let well = well.clamp(WELLS[0], WELLS[1]);
        let black_level = self.black.unwrap_or((1 << self.bits) / 32);
        let codes = f64::from((1 << self.bits) - 1 - black_level);
        let iso_of_gain =
            self.gain.map(|gain| (BASE_ISO * well * gain / codes).clamp(SPEEDS[0], SPEEDS[1]));
        let warming = self.dark.factor(self.temperature);
        let mut fixed_pattern = binning.pattern(self.pattern);
        fixed_pattern.hot.dark_current *= warming;
        Sensor {
            iso: self.iso.or(iso_of_gain).unwrap_or(film_iso),
            full_well: well,
            read_noise: binning.read_noise(self.read),
            dark_current: self.dark.current * warming * binning.count(),
            seconds: self.time.unwrap_or(seconds),
            fixed_pattern,
            crosstalk: binning.crosstalk(self.crosstalk),
            hdr: self.hdr,
            vignetting: None,
            bits: self.bits,
            black_level,
            bayer: self.bayer,
            filters: None,
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
            crosstalk: Crosstalk::default(),
            hdr: 1.0,
            vignetting: None,
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
}
