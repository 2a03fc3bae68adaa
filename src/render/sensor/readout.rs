//! Readings of photosites.

use super::deviations::Deviations;
use super::fixed_pattern::{PatternSamples, PhotositePattern};
use super::photosite_rng::PhotositeRng;
use super::poisson::poisson;
use super::{Sensor, at_least_zero};
use petzval_base::sampler::hash;

/// One of the two photodiodes that share the photosite of a dual pixel. Their noise is independent.
#[derive(Clone, Copy, Debug)]
pub(super) enum Photodiode {
    Left,
    Right,
}

/// One readout of a picture.
pub(super) struct Readout<'a> {
    sensor: &'a Sensor,
    seed: u32,
    /// Share of the photosite that is read.
    share: f64,
    read_noise: Deviations,
    pattern: Option<PatternSamples>,
}

impl<'a> Readout<'a> {
    /// Begins a readout. `origin` is the position of the picture's first pixel in its frame.
    pub fn new(sensor: &'a Sensor, origin: [u32; 2], size: [usize; 2], seed: u32) -> Self {
        Self {
            sensor,
            seed,
            share: 1.0,
            read_noise: Deviations::new(&sensor.read_noise, origin, size, seed),
            pattern: sensor.fixed_pattern.samples(origin, size),
        }
    }

    /// Begins a readout of one photodiode of each photosite, which has half of its full well and of its dark
    /// signal.
    pub fn of_photodiode(
        photodiode: Photodiode,
        sensor: &'a Sensor,
        origin: [u32; 2],
        size: [usize; 2],
        seed: u32,
    ) -> Self {
        let salt = match photodiode {
            Photodiode::Left => 0x1ef7_d10d,
            Photodiode::Right => 0x719b_7d10,
        };
        Self { share: 0.5, ..Self::new(sensor, origin, size, hash(seed ^ salt)) }
    }

    /// Returns the code of a photosite that receives `value`, relative to white.
    pub fn code(&self, value: f32, pixel: [u32; 2], channel: u32) -> u32 {
        let pattern = self.pattern_at(pixel, channel);
        let mut rng = PhotositeRng::new(pixel, channel, self.seed);
        let electrons = self.electrons_with(value, &pattern, &mut rng);
        self.code_with(electrons, &pattern, pixel, &mut rng)
    }

    /// Returns the electrons of a photosite that receives `value`, the same as [`Self::code`] draws.
    pub fn electrons(&self, value: f32, pixel: [u32; 2], channel: u32) -> f64 {
        let mut rng = PhotositeRng::new(pixel, channel, self.seed);
        self.electrons_with(value, &self.pattern_at(pixel, channel), &mut rng)
    }

    /// Returns the code of a photosite that holds so many electrons.
    pub fn code_of(&self, electrons: f64, pixel: [u32; 2], channel: u32) -> u32 {
        let mut rng = PhotositeRng::new(pixel, channel, self.seed);
        self.code_with(electrons, &self.pattern_at(pixel, channel), pixel, &mut rng)
    }

    fn pattern_at(&self, pixel: [u32; 2], channel: u32) -> PhotositePattern {
        let pattern = self.pattern.as_ref();
        pattern.map_or(PhotositePattern::NONE, |pattern| pattern.at(pixel, channel))
    }

    /// Returns the electrons of light and dark current.
    fn electrons_with(
        &self,
        value: f32,
        pattern: &PhotositePattern,
        rng: &mut PhotositeRng,
    ) -> f64 {
        let Self { sensor, share, .. } = self;
        let full_well = share * sensor.full_well;
        let light = at_least_zero(f64::from(value) * sensor.white_electrons() * pattern.response);
        let dark_current = sensor.dark_current + pattern.dark_current;
        let dark = at_least_zero(dark_current * sensor.seconds) * share;
        // The bound keeps the Poisson mean finite and well above the full well.
        let mean = (light + dark).min(2.0 * full_well + 100.0);
        poisson(mean, rng).min(full_well)
    }

    /// Returns the code of electrons and the noise of reading them.
    fn code_with(
        &self,
        electrons: f64,
        pattern: &PhotositePattern,
        pixel: [u32; 2],
        rng: &mut PhotositeRng,
    ) -> u32 {
        let Self { sensor, share, read_noise, .. } = self;
        let mut electrons = electrons + share * pattern.dark_signal;
        if sensor.read_noise.pixel > 0.0 {
            electrons += sensor.read_noise.pixel * rng.normal();
        }
        electrons += read_noise.of_lines(pixel);
        let scale = sensor.code_span() / sensor.white_electrons();
        let code = f64::from(sensor.black_level) + electrons * scale;
        code.round().clamp(0.0, f64::from(sensor.max_code())) as u32
    }
}
