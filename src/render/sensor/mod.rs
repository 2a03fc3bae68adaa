//! Sensor simulation: what the photosites of a camera record of the finished picture.
//!
//! An optional stage after the film.
//!
//! # Calibration
//!
//! The value 1 in a picture is irradiance x shutter x ISO / 100, and is where the sensor saturates.
//! By the saturation-based speed of ISO 12232:2019, at ISO S that is a focal-plane exposure of 78 /
//! S lux seconds, so at higher speeds the same value stands for less light. A full well saturates
//! at the base speed, ISO 100: at ISO S, white is `full_well * 100 / S` electrons. Below the base
//! speed the well is full before white is reached, and pictures clip at S / 100.
//!
//! # Signal
//!
//! For each channel, as in the linear model of EMVA 1288 (release 4.0, 2021): Poisson-distributed electrons
//! of light and dark current (shot noise), clipped at the full well; plus Gaussian noise of reading a
//! photosite, its row and its column, in electrons; times the gain, plus the black level; rounded and
//! clipped to a code of the sensor's bit depth. Response and dark signal differ from photosite to photosite
//! ([`FixedPattern`]). The output picture is computed from the codes: black is 0, the
//! last code 1. Codes below the black level are negative, so that noise has no bias: without dark current and
//! patterns, a dark frame has the mean 0 and all of its variance. (A black level of 0 cuts the noise below it, as a sensor would.)
//!
//! Channels are those of the film's measured camera ([`ColourFilters`]), whose matrix then makes the picture
//! of them: so noise of one channel is in all colours. Without such a camera, channels are linear sRGB, with no
//! colour matrix and no white balance between photosites and picture. All have the same full well. Without a
//! mosaic, every pixel has a photosite for each channel. Neighbours of a photosite collect a share of its charge
//! ([`Crosstalk`]).
//!
//! Beside each photosite may be a smaller one, whose reading, scaled up, replaces that of the first from 90 % of saturation
//! on ([`Sensor::hdr`]): values then exceed 1. Microlenses lose oblique light ([`PixelVignetting`]).
//!
//! Noise is a function of pixel, channel and seed; fixed patterns are one of pixel, channel and their own
//! seed, and thus the same in all pictures.

mod bayer;
mod binning;
mod crosstalk;
mod deviations;
mod exposure;
mod filters;
mod fixed_pattern;
mod microlens;
mod photosite_rng;
mod poisson;
mod raw_format;
mod readout;
mod second_photosite;
mod sensor_file;
mod setting_values;
mod settings;
mod settings_text;

pub use bayer::Bayer;
pub use binning::{Binning, BinningSum};
pub use crosstalk::Crosstalk;
pub use deviations::Components;
pub use exposure::ev100;
pub use filters::ColourFilters;
pub use fixed_pattern::{FixedPattern, HotPixels};
pub use microlens::{MicrolensError, Microlenses, PixelVignetting};
pub use settings::{DarkCurrent, SensorSettings, WELL_PER_UM2};

use rayon::prelude::*;

use petzval_image::Picture;
use readout::{Photodiode, Readout};
use second_photosite::salted;

/// The ISO speed at which a full well is white (see the module's documentation).
pub const BASE_ISO: f64 = 100.0;

/// A sensor at one ISO speed. Made by [`SensorSettings::sensor`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensor {
    /// ISO speed.
    pub iso: f64,
    /// Full well of a photosite (electrons), at least 1.
    pub full_well: f64,
    /// Standard deviations of the read noise (electrons); those of rows and columns are the same for all
    /// photosites there, and new in every picture.
    pub read_noise: Components,
    /// Dark current of a photosite (electrons a second).
    pub dark_current: f64,
    /// Exposure time (s), in which dark current adds up.
    pub seconds: f64,
    /// Non-uniformity of response and dark signal, and hot pixels.
    pub fixed_pattern: FixedPattern,
    /// Shares of the charge that neighbours collect.
    pub crosstalk: Crosstalk,
    /// Sensitivity of a photosite relative to that of a smaller one beside it, whose reading counts where the
    /// first saturates; 1 for no other.
    pub hdr: f64,
    /// Light that is lost behind microlenses; `None` for none.
    pub vignetting: Option<PixelVignetting>,
    /// Bit depth of a code, 1 to 16.
    pub bits: u32,
    /// The code of no light, less than the last code.
    pub black_level: u32,
    /// The mosaic; `None` if every pixel sees all channels.
    pub bayer: Option<Bayer>,
    /// The colour filters of a measured camera; `None` if channels are linear sRGB.
    pub filters: Option<ColourFilters>,
}

impl Default for Sensor {
    /// Returns the sensor of [`SensorSettings::default`] for a film of ISO 100 and pixels of 6 um.
    fn default() -> Self {
        SensorSettings::default().sensor(BASE_ISO, 6.0, 0.0)
    }
}

impl Sensor {
    /// Returns the electrons that correspond to the value 1 in a picture.
    pub fn white_electrons(&self) -> f64 {
        self.full_well * BASE_ISO / self.iso
    }

    /// Returns the last code.
    pub fn max_code(&self) -> u32 {
        (1 << self.bits) - 1
    }

    /// Returns the number of codes from black to white.
    fn code_span(&self) -> f64 {
        f64::from(self.max_code() - self.black_level)
    }

    /// Returns what the sensor records of a picture: a stage. `origin` is the position of the
    /// picture's first pixel in its frame.
    ///
    /// With a mosaic, a pixel keeps only the channel of its filter, as grey: red, green and blue
    /// are equal. The result is finite for any input, and within 0 to 1, or to the ratio of a second
    /// sensitivity, unless a camera's matrix has developed it or a code is below black.
    pub fn read_out(&self, picture: Picture, origin: [u32; 2], seed: u32) -> Picture {
        let small = self.second_photosite();
        let readouts = self.photosites(&small, |sensor, salt| {
            Readout::new(sensor, origin, picture.size, salted(seed, salt))
        });
        let picture = self.behind_filters(picture, origin);
        self.read_values(picture, origin, |_, light, pixel, channel| {
            self.merged(&readouts, |readout, share| {
                readout.code(share * light[channel], pixel, channel as u32)
            })
        })
    }

    /// Returns what a sensor with two photodiodes in each photosite records of the light that reaches the left
    /// and the right ones: the picture of their common charge, and the pictures of both.
    ///
    /// The halves are relative to the same white, so that their sum is the picture but for noise of reading.
    pub fn read_out_halves(
        &self,
        [left, right]: [Picture; 2],
        origin: [u32; 2],
        seed: u32,
    ) -> (Picture, [Picture; 2]) {
        let size = left.size;
        let [left, right] = [left, right].map(|half| self.behind_filters(half, origin));
        let small = self.second_photosite();
        let photosites = self.photosites(&small, |sensor, salt| {
            let seed = salted(seed, salt);
            let half = |half| Readout::of_photodiode(half, sensor, origin, size, seed);
            let halves = [Photodiode::Left, Photodiode::Right].map(half);
            (Readout::new(sensor, origin, size, seed), halves)
        });
        let whole = self.read_values(left.clone(), origin, |i, light, pixel, channel| {
            let (others, number) = (right.pixels[i], channel as u32);
            self.merged(&photosites, |(readout, [of_left, of_right]), share| {
                let electrons = of_left.electrons(share * light[channel], pixel, number)
                    + of_right.electrons(share * others[channel], pixel, number);
                readout.code_of(electrons, pixel, number)
            })
        });
        let read_half = |half: Picture, side: usize| {
            self.read_values(half, origin, |_, light, pixel, channel| {
                // The well of a half is half as deep, and saturates at half the code.
                self.merged_below(0.5, &photosites, |(_, halves), share| {
                    halves[side].code(share * light[channel], pixel, channel as u32)
                })
            })
        };
        (whole, [read_half(left, 0), read_half(right, 1)])
    }

    /// Returns the light of the photosites: behind microlenses and colour filters, and with the crosstalk of their neighbours.
    fn behind_filters(&self, mut picture: Picture, origin: [u32; 2]) -> Picture {
        if let Some(vignetting) = &self.vignetting {
            vignetting.darken(&mut picture, origin);
        }
        if let Some(filters) = &self.filters {
            picture.pixels.par_iter_mut().for_each(|pixel| *pixel = filters.raw(*pixel));
        }
        if self.crosstalk.is_none() {
            return picture;
        }
        let filter = self.bayer.map(|bayer| {
            move |at: [usize; 2]| bayer.channel([0, 1].map(|i| origin[i] + at[i] as u32))
        });
        self.crosstalk.spread(&picture, filter)
    }

    /// Returns what photosites of a mosaic collect of an even surface, of whose light this is behind their filters.
    fn in_mosaic(&self, bayer: Bayer, light: [f64; 3]) -> [f64; 3] {
        let rows = self.crosstalk.of_mosaic(bayer);
        rows.map(|row| (0..3).map(|c| row[c] * light[c]).sum())
    }

    /// Returns the picture of the values of the photosites. `read` gets the index of a pixel, the light of its
    /// photosites, its position in the frame, and a channel.
    fn read_values(
        &self,
        mut picture: Picture,
        origin: [u32; 2],
        read: impl Fn(usize, [f32; 3], [u32; 2], usize) -> f32 + Sync,
    ) -> Picture {
        let width = picture.size[0].max(1);
        picture.pixels.par_chunks_mut(width).enumerate().for_each(|(row, pixels)| {
            let y = origin[1] + row as u32;
            for (column, pixel) in pixels.iter_mut().enumerate() {
                let (i, x) = (row * width + column, origin[0] + column as u32);
                let light = *pixel;
                let read = |channel: usize| read(i, light, [x, y], channel);
                *pixel = match (self.bayer, self.filters) {
                    (Some(bayer), _) => [read(bayer.channel([x, y])); 3],
                    (None, None) => [read(0), read(1), read(2)],
                    (None, Some(filters)) => filters.develop([read(0), read(1), read(2)]),
                };
            }
        });
        picture
    }

    /// Returns the picture value of a code; negative below the black level.
    fn value(&self, code: u32) -> f32 {
        ((f64::from(code) - f64::from(self.black_level)) / self.code_span()) as f32
    }

    /// Returns the noise that the sensor adds to grey pixels of this value, % of the signal: 100 / SNR;
    /// that of the noisiest channel.
    ///
    /// Variances of shot noise, read noise, fixed patterns and quantization add up, without hot pixels.
    /// Light and dark current beyond the full well count as a full well; no light gives infinity.
    pub fn relative_noise(&self, value: f64) -> f64 {
        if self.hdr > 1.0 && value > self.merging_value() {
            return self.second_photosite().relative_noise(value / self.hdr);
        }
        let relative = |noise: ReadingNoise| percentage(noise.variance().sqrt(), noise.electrons);
        let Some(filters) = &self.filters else { return relative(self.reading_noise(value)) };
        let white = match self.bayer {
            Some(bayer) => self.in_mosaic(bayer, filters.white()),
            None => filters.white(),
        };
        let readings = white.map(|share| self.reading_noise(value * share));
        let noise = match self.bayer {
            Some(_) => readings.map(relative),
            None => {
                let white = self.white_electrons();
                let signal = value.min(self.full_well / white);
                // The response of a line scales all channels, and thus the picture.
                let response = self.fixed_pattern.response.line_variance() * signal * signal;
                let variances = readings.map(|noise| noise.independent / (white * white));
                let lines = self.line_variance() / (white * white);
                filters
                    .developed_variances(variances, lines)
                    .map(|variance| percentage((variance + response).sqrt(), signal))
            }
        };
        noise.into_iter().fold(0.0, f64::max)
    }

    /// Returns the variance of what rows and columns add to their readings (electrons^2).
    fn line_variance(&self) -> f64 {
        self.read_noise.line_variance() + self.fixed_pattern.dark_signal.line_variance()
    }

    /// Returns the noise of a photosite that receives `value`, relative to white.
    fn reading_noise(&self, value: f64) -> ReadingNoise {
        let electrons = (value * self.white_electrons()).min(self.full_well);
        let dark = at_least_zero(self.dark_current * self.seconds);
        let step = self.white_electrons() / self.code_span();
        let FixedPattern { dark_signal, response, .. } = &self.fixed_pattern;
        let square = |x: f64| x * x;
        ReadingNoise {
            electrons,
            independent: (electrons + dark).min(self.full_well)
                + square(self.read_noise.pixel)
                + square(dark_signal.pixel)
                + square(response.pixel * electrons)
                + square(step) / 12.0,
            of_lines: self.line_variance() + response.line_variance() * square(electrons),
        }
    }
}

/// Noise of a reading.
#[derive(Clone, Copy)]
struct ReadingNoise {
    /// Mean electrons of light.
    electrons: f64,
    /// Variance of what is independent of other photosites and channels (electrons^2).
    independent: f64,
    /// Variance of what the photosites and channels of a row or a column have in common (electrons^2).
    of_lines: f64,
}

impl ReadingNoise {
    fn variance(&self) -> f64 {
        self.independent + self.of_lines
    }
}

/// Returns a number, or 0 if it is negative or NaN.
fn at_least_zero(x: f64) -> f64 {
    if x > 0.0 { x } else { 0.0 }
}

/// Returns a deviation in % of a signal; infinity if there is none.
fn percentage(deviation: f64, signal: f64) -> f64 {
    if signal > 0.0 { 100.0 * deviation / signal } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns mean and variance of many readings, in electrons above black.
    fn readings(sensor: &Sensor, electrons: f64, count: u32) -> [f64; 2] {
        let value = (electrons / sensor.white_electrons()) as f32;
        let per_code = sensor.white_electrons() / sensor.code_span();
        let [mut sum, mut squares] = [0.0; 2];
        let readout = Readout::new(sensor, [0, 0], [1024, 1024], 7);
        for i in 0..count {
            let code = readout.code(value, [i % 1024, i / 1024], 1);
            let code = f64::from(code) - f64::from(sensor.black_level);
            let off = code * per_code - electrons;
            sum += off;
            squares += off * off;
        }
        let n = f64::from(count);
        [electrons + sum / n, (squares - sum * sum / n) / (n - 1.0)]
    }

    #[test]
    fn the_variance_is_the_mean_plus_the_squared_read_noise() {
        // The photon transfer curve (Janesick 2007). Rounding to codes adds 1/12 of a code squared.
        let sensor = Sensor {
            iso: 200.0,
            full_well: 40_000.0,
            read_noise: Components { pixel: 4.0, ..Components::default() },
            bits: 14,
            black_level: 512,
            ..Sensor::default()
        };
        let step = sensor.white_electrons() / sensor.code_span();
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
    fn the_noise_estimate_matches_the_readings() {
        let sensor = Sensor {
            iso: 1600.0,
            full_well: 30_000.0,
            read_noise: Components { pixel: 3.0, ..Components::default() },
            bits: 7,
            black_level: 16,
            ..Sensor::default()
        };
        for value in [0.05, 0.18, 0.6] {
            let [mean, variance] = readings(&sensor, value * sensor.white_electrons(), 200_000);
            let found = 100.0 * variance.sqrt() / mean;
            let estimate = sensor.relative_noise(value);
            assert!((estimate / found - 1.0).abs() < 0.02, "{value}: {estimate} and {found}");
        }
        assert_eq!(sensor.relative_noise(0.0), f64::INFINITY);
        assert_eq!(sensor.relative_noise(1e9), sensor.relative_noise(16.0));
    }
}
