//! The sensor: what a camera's photosites would record of the finished picture.
//!
//! A stage of its own, after the film: it is not run where nobody asks for it.
//!
//! # Calibration
//!
//! A picture's 1 is irradiance x shutter x ISO / 100, and is where the sensor saturates. By the
//! saturation-based speed of ISO 12232:2019, at ISO S that is a focal-plane exposure of 78 / S lux
//! seconds; so the same 1 is ever less light at higher speeds. A full well is what saturates at the
//! base speed, ISO 100: at ISO S, white is `well * 100 / S` electrons. Below the base speed the well
//! is full before white is reached, and pictures clip at S / 100.
//!
//! # Signal
//!
//! For each channel: Poisson-distributed electrons (shot noise), clipped at the full
//! well; plus Gaussian read noise, in electrons; times the gain, plus the black level, rounded
//! and clipped to a code of so many bits. The picture is made again of the codes: black is 0, the
//! last code 1, and what read noise pushes below black is 0.
//!
//! Channels are linear sRGB, and every one has the same well: there is no matrix and no white
//! balance between the photosites and the picture. Without a mosaic, every pixel has a photosite for
//! each channel.
//!
//! Noise is a function of pixel, channel and seed.

mod bayer;
mod exposure;
mod noise;
mod poisson;
mod settings;

pub use bayer::Bayer;
pub use exposure::ev100;
pub use settings::{Settings, WELL_PER_UM2};

use rayon::prelude::*;

use crate::image::Picture;
use noise::Noise;
use poisson::poisson;

/// The speed at which a full well is white (see the module's documentation).
pub const BASE_ISO: f64 = 100.0;

/// A sensor at one speed. Made by [`Settings::sensor`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensor {
    /// ISO speed.
    pub iso: f64,
    /// Full well of a photosite, electrons; 1 or more.
    pub well: f64,
    /// Standard deviation of the read noise, electrons.
    pub read: f64,
    /// Bits of a code, 1 to 16.
    pub bits: u32,
    /// The code of no light; less than the last code.
    pub black: u32,
    /// The colour filters, if every pixel sees one channel only.
    pub bayer: Option<Bayer>,
}

impl Sensor {
    /// Electrons that the picture's 1 stands for.
    pub fn white(&self) -> f64 {
        self.well * BASE_ISO / self.iso
    }

    /// The last code.
    pub fn top(&self) -> u32 {
        (1 << self.bits) - 1
    }

    /// Codes from black to white.
    fn span(&self) -> f64 {
        f64::from(self.top() - self.black)
    }

    /// What the sensor records of a picture whose first pixel is `origin` in its frame: a stage.
    ///
    /// With a mosaic, a pixel keeps the channel of its filter, in grey: red, green and blue are the
    /// same number. Values are finite, 0 to 1, whatever the picture holds.
    pub fn read_out(&self, picture: &Picture, origin: [u32; 2], seed: u32) -> Picture {
        let width = picture.size[0].max(1);
        let mut pixels = vec![[0.0; 3]; picture.pixels.len()];
        let rows = pixels.par_chunks_mut(width).zip(picture.pixels.par_chunks(width));
        rows.enumerate().for_each(|(row, (to, from))| {
            let y = origin[1] + row as u32;
            for (x, (to, from)) in (origin[0]..).zip(to.iter_mut().zip(from)) {
                let read = |channel: usize| {
                    let mut noise = Noise::new([x, y], channel as u32, seed);
                    self.value(self.code(from[channel], &mut noise))
                };
                *to = match self.bayer {
                    Some(bayer) => [read(bayer.channel([x, y])); 3],
                    None => [read(0), read(1), read(2)],
                };
            }
        });
        Picture { size: picture.size, pixels }
    }

    /// One reading of a photosite that receives this much of white.
    fn code(&self, value: f32, noise: &mut Noise) -> u32 {
        let white = self.white();
        let light = f64::from(value) * white;
        // A comparison with NaN is false: it is no light. What is far beyond the well fills it.
        let light = if light > 0.0 { light.min(2.0 * self.well + 100.0) } else { 0.0 };
        let mut electrons = poisson(light, noise).min(self.well);
        if self.read > 0.0 {
            electrons += self.read * noise.normal();
        }
        let code = f64::from(self.black) + electrons * (self.span() / white);
        code.round().clamp(0.0, f64::from(self.top())) as u32
    }

    /// What a code says of the light, of 1.
    fn value(&self, code: u32) -> f32 {
        (f64::from(code.saturating_sub(self.black)) / self.span()) as f32
    }

    /// The noise that the sensor adds to pixels of this value, % of the signal: 100 / SNR. Shot
    /// noise, read noise and rounding add by their squares; what is beyond the full well counts as
    /// a full well, no light as infinitely noisy.
    pub fn relative_noise(&self, value: f64) -> f64 {
        let electrons = (value * self.white()).min(self.well);
        let step = self.white() / self.span();
        let variance = electrons + self.read * self.read + step * step / 12.0;
        if electrons > 0.0 { 100.0 * variance.sqrt() / electrons } else { f64::INFINITY }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean and variance of many readings, in electrons above black.
    fn readings(sensor: &Sensor, electrons: f64, count: u32) -> [f64; 2] {
        let value = (electrons / sensor.white()) as f32;
        let per_code = sensor.white() / sensor.span();
        let [mut sum, mut squares] = [0.0; 2];
        for i in 0..count {
            let mut noise = Noise::new([i % 1024, i / 1024], 1, 7);
            let code = f64::from(sensor.code(value, &mut noise)) - f64::from(sensor.black);
            let off = code * per_code - electrons;
            sum += off;
            squares += off * off;
        }
        let n = f64::from(count);
        [electrons + sum / n, (squares - sum * sum / n) / (n - 1.0)]
    }

    #[test]
    fn variance_is_the_mean_and_the_square_of_read_noise() {
        // The photon transfer curve (Janesick 2007). Rounding to codes adds 1/12 of a code squared.
        let sensor =
            Sensor { iso: 200.0, well: 40_000.0, read: 4.0, bits: 14, black: 512, bayer: None };
        let step = sensor.white() / sensor.span();
        let count = 1 << 20;
        for electrons in [0.0, 3.0, 50.0, 1000.0, 15_000.0] {
            let [mean, variance] = readings(&sensor, electrons, count);
            let expected = electrons + 16.0 + step * step / 12.0;
            // Five standard errors: 0.02 and 0.7 %.
            let n = f64::from(count);
            assert!((mean - electrons).abs() < 5.0 * (expected / n).sqrt(), "{electrons}: {mean}");
            let off = variance / expected - 1.0;
            assert!(off.abs() < 5.0 * (2.0 / n).sqrt(), "{electrons}: {variance}, not {expected}");
        }
    }

    #[test]
    fn the_estimate_of_noise_is_that_of_the_readings() {
        let sensor =
            Sensor { iso: 1600.0, well: 30_000.0, read: 3.0, bits: 7, black: 16, bayer: None };
        for value in [0.05, 0.18, 0.6] {
            let [mean, variance] = readings(&sensor, value * sensor.white(), 200_000);
            let found = 100.0 * variance.sqrt() / mean;
            let estimate = sensor.relative_noise(value);
            assert!((estimate / found - 1.0).abs() < 0.02, "{value}: {estimate} and {found}");
        }
        assert_eq!(sensor.relative_noise(0.0), f64::INFINITY);
        assert_eq!(sensor.relative_noise(1e9), sensor.relative_noise(16.0));
    }
}
