//! Sums of light in the channels that the pixels of a film have beside their colours.

use std::io;
use std::sync::Arc;

use super::accumulate::two_sum;
use super::{Frame, Tile};
use petzval_base::io::codec::{ChecksumReader, ChecksumWriter};
use petzval_spectrum::BucketShares;

/// The channels of a film beside its colours: none by default.
#[derive(Clone, Debug, Default)]
pub struct ExtraChannels {
    /// Buckets of wavelength, if paths carry spectra. They receive the light that reaches the film, whatever
    /// the sensor and its white balance are.
    pub buckets: Option<Arc<BucketShares>>,
    /// Whether the film records the colours of the light through the left half of the exit pupil.
    pub left_half: bool,
}

impl ExtraChannels {
    /// Returns their number.
    pub fn count(&self) -> usize {
        self.bucket_count() + if self.left_half { 3 } else { 0 }
    }

    /// Returns the number of buckets, which come first.
    pub fn bucket_count(&self) -> usize {
        self.buckets.as_ref().map_or(0, |shares| shares.buckets().count())
    }

    /// Distributes light at the wavelengths of a set over the buckets: calls `add` with each and its part.
    #[inline(always)]
    fn spread(&self, set: usize, light: [f64; 3], add: impl FnMut(usize, f64)) {
        if let Some(shares) = &self.buckets {
            shares.spread(set, light, add);
        }
    }
}

/// Sums of the light that pixels received in the extra channels of a film, pixel by pixel.
#[derive(Clone, Debug, Default)]
pub(super) struct ExtraSums {
    channels: ExtraChannels,
    sums: Vec<f64>,
    /// The rounding errors of the sums; empty if they are part of the sums already.
    errors: Vec<f64>,
}

/// Sums of successive pixels of a film.
pub(super) struct ExtraStrip<'a> {
    channels: &'a ExtraChannels,
    sums: &'a mut [f64],
}

impl<'a> ExtraStrip<'a> {
    /// Divides the strip into its first pixels and the others.
    pub fn split_at(self, pixels: usize) -> [Self; 2] {
        let Self { channels, sums } = self;
        let (first, others) = sums.split_at_mut(pixels * channels.count());
        [first, others].map(|sums| Self { channels, sums })
    }

    /// Adds light at the wavelengths of a set to the buckets of a pixel, and its colour to the left half of
    /// the pupil if the light passed it.
    #[inline(always)]
    pub fn add(&mut self, pixel: usize, (set, light): (usize, [f64; 3]), left: Option<[f64; 3]>) {
        let Self { channels, sums } = self;
        let first = pixel * channels.count();
        channels.spread(set, light, |bucket, radiance| sums[first + bucket] += radiance);
        if let (true, Some(colour)) = (channels.left_half, left) {
            let first = first + channels.bucket_count();
            sums[first..].iter_mut().zip(colour).for_each(|(sum, value)| *sum += value);
        }
    }
}

impl ExtraSums {
    /// Empty sums of so many pixels.
    pub fn new(channels: &ExtraChannels, pixels: usize) -> Self {
        let sums = vec![0.0; channels.count() * pixels];
        Self { channels: channels.clone(), sums, errors: Vec::new() }
    }

    /// Returns the channels.
    pub fn channels(&self) -> &ExtraChannels {
        &self.channels
    }

    /// Returns the sums, pixel by pixel.
    pub fn sums(&self) -> &[f64] {
        &self.sums
    }

    /// Adds light at the wavelengths of a set to the buckets of a pixel, and keeps the rounding errors.
    pub fn add_spectrum_exactly(&mut self, pixel: usize, set: usize, light: [f64; 3]) {
        let Self { channels, sums, errors } = self;
        errors.resize(sums.len(), 0.0);
        let first = pixel * channels.count();
        channels.spread(set, light, |bucket, radiance| {
            add_exactly(&mut sums[first + bucket], &mut errors[first + bucket], radiance);
        });
    }

    /// Adds the colour of light that passed the left half of the pupil to a pixel, and keeps the rounding
    /// errors.
    pub fn add_left_exactly(&mut self, pixel: usize, colour: [f64; 3]) {
        let Self { channels, sums, errors } = self;
        errors.resize(sums.len(), 0.0);
        let first = pixel * channels.count() + channels.bucket_count();
        let sums = sums[first..].iter_mut().zip(&mut errors[first..]);
        sums.zip(colour).for_each(|((sum, error), value)| add_exactly(sum, error, value));
    }

    /// Returns the sums of all pixels as a strip.
    pub fn as_strip(&mut self) -> ExtraStrip<'_> {
        ExtraStrip { channels: &self.channels, sums: &mut self.sums }
    }

    /// Adds other sums of the same pixels, with the rounding errors of both.
    pub fn add_exactly(&mut self, other: &Self) {
        self.errors.resize(self.sums.len(), 0.0);
        let sums = self.sums.iter_mut().zip(&mut self.errors);
        for (i, ((sum, error), light)) in sums.zip(&other.sums).enumerate() {
            add_exactly(sum, error, *light);
            *error += other.errors.get(i).copied().unwrap_or_default();
        }
    }

    /// Rounds the sums and their errors to single numbers.
    pub fn round(&mut self) {
        for (sum, error) in self.sums.iter_mut().zip(std::mem::take(&mut self.errors)) {
            *sum += error;
        }
    }

    /// Adds other rounded sums of the same pixels, multiplied by `scale`.
    pub fn add(&mut self, other: &Self, scale: f64) {
        for (sum, light) in self.sums.iter_mut().zip(&other.sums) {
            *sum += scale * light;
        }
    }

    /// Multiplies all sums.
    pub fn scale(&mut self, factor: f64) {
        self.sums.iter_mut().for_each(|sum| *sum *= factor);
    }

    /// Returns the rounded sums of a tile of these pixels of a frame.
    pub fn cut(&self, tile: &Tile, frame: &Frame) -> Self {
        let sums = tile.cut_columns(frame, &self.sums, self.channels.count());
        Self { channels: self.channels.clone(), sums, errors: Vec::new() }
    }

    /// Replaces the sums of a tile of these pixels of a frame.
    pub fn paste(&mut self, tile: &Tile, frame: &Frame, from: &Self) {
        tile.paste_columns(frame, &from.sums, &mut self.sums, self.channels.count());
    }

    pub fn save(&self, to: &mut ChecksumWriter) -> io::Result<()> {
        to.numbers(&self.sums)
    }

    /// Adds the saved sums of the same pixels.
    pub fn receive(&mut self, from: &mut ChecksumReader) -> io::Result<()> {
        from.add_numbers(&mut self.sums)
    }
}

/// Adds a value to a sum and its rounding error.
fn add_exactly(sum: &mut f64, error: &mut f64, value: f64) {
    let (more, lost) = two_sum(*sum, value);
    *sum = more;
    *error += lost;
}
