//! Readings of photosites.

use super::deviations::Deviations;
use super::fixed_pattern::{PatternSamples, PhotositePattern};
use super::photosite_rng::PhotositeRng;
use super::poisson::poisson;
use super::{Sensor, at_least_zero};

/// One readout of a picture.
pub(super) struct Readout<'a> {
    sensor: &'a Sensor,
    seed: u32,
    read_noise: Deviations,
    pattern: Option<PatternSamples>,
}

impl<'a> Readout<'a> {
    /// Begins a readout. `origin` is the position of the picture's first pixel in its frame.
    pub fn new(sensor: &'a Sensor, origin: [u32; 2], size: [usize; 2], seed: u32) -> Self {
        Self {
            sensor,
            seed,
            read_noise: Deviations::new(&sensor.read_noise, origin, size, seed),
            pattern: sensor.fixed_pattern.samples(origin, size),
        }
    }

    /// Returns the code of a photosite that receives `value`, relative to white.
    pub fn code(&self, value: f32, pixel: [u32; 2], channel: u32) -> u32 {
        let Self { sensor, seed, read_noise, pattern } = self;
        let white = sensor.white_electrons();
        let pattern =
            pattern.as_ref().map_or(PhotositePattern::NONE, |pattern| pattern.at(pixel, channel));
        let light = at_least_zero(f64::from(value) * white * pattern.response);
        let dark_current = sensor.dark_current + pattern.dark_current;
        let dark = at_least_zero(dark_current * sensor.seconds);
        // The bound keeps the Poisson mean finite and well above the full well.
        let mean = (light + dark).min(2.0 * sensor.full_well + 100.0);
        let mut rng = PhotositeRng::new(pixel, channel, *seed);
        let mut electrons = poisson(mean, &mut rng).min(sensor.full_well) + pattern.dark_signal;
        if sensor.read_noise.pixel > 0.0 {
            electrons += sensor.read_noise.pixel * rng.normal();
        }
        electrons += read_noise.of_lines(pixel);
        let code = f64::from(sensor.black_level) + electrons * (sensor.code_span() / white);
        code.round().clamp(0.0, f64::from(sensor.max_code())) as u32
    }
}
