//! Sums of light by bucket of wavelength, for the pixels of a spectral film.

use std::io;
use std::sync::Arc;

use super::accumulate::two_sum;
use super::{Frame, Tile};
use petzval_base::io::codec::{ChecksumReader, ChecksumWriter};
use petzval_spectrum::BucketShares;

/// Sums of the spectral radiance that pixels received in the buckets of a film, pixel by pixel. Those of
/// a film without buckets hold nothing.
#[derive(Clone, Debug, Default)]
pub(super) struct BucketSums {
    shares: Option<Arc<BucketShares>>,
    sums: Vec<f64>,
    /// The rounding errors of the sums; empty if they are part of the sums already.
    errors: Vec<f64>,
}

/// Sums of successive pixels of a film, if it has buckets.
pub(super) struct BucketStrip<'a> {
    shares: Option<&'a BucketShares>,
    sums: &'a mut [f64],
}

impl<'a> BucketStrip<'a> {
    /// Divides the strip into its first pixels and the others.
    pub fn split_at(self, pixels: usize) -> [Self; 2] {
        let Self { shares, sums } = self;
        let count = shares.map_or(0, |shares| shares.buckets().count());
        let (first, others) = sums.split_at_mut(pixels * count);
        [first, others].map(|sums| Self { shares, sums })
    }

    /// Adds light at the wavelengths of a set to a pixel.
    #[inline(always)]
    pub fn add(&mut self, pixel: usize, set: usize, light: [f64; 3]) {
        let Self { shares: Some(shares), sums } = self else { return };
        let first = pixel * shares.buckets().count();
        shares.spread(set, light, |bucket, radiance| sums[first + bucket] += radiance);
    }
}

impl BucketSums {
    /// Empty sums of so many pixels.
    pub fn new(shares: Option<&Arc<BucketShares>>, pixels: usize) -> Self {
        let count = shares.map_or(0, |shares| shares.buckets().count());
        Self { shares: shares.cloned(), sums: vec![0.0; count * pixels], errors: Vec::new() }
    }

    /// Returns the shares of bands in the buckets, if there are any.
    pub fn shares(&self) -> Option<&Arc<BucketShares>> {
        self.shares.as_ref()
    }

    /// Returns the number of buckets.
    pub fn count(&self) -> usize {
        self.shares.as_ref().map_or(0, |shares| shares.buckets().count())
    }

    /// Returns the sums, pixel by pixel.
    pub fn sums(&self) -> &[f64] {
        &self.sums
    }

    /// Adds light at the wavelengths of a set to a pixel, and keeps the rounding errors.
    pub fn add_exactly_to(&mut self, pixel: usize, set: usize, light: [f64; 3]) {
        let Self { shares: Some(shares), sums, errors } = self else { return };
        errors.resize(sums.len(), 0.0);
        let first = pixel * shares.buckets().count();
        shares.spread(set, light, |bucket, radiance| {
            let (sum, lost) = two_sum(sums[first + bucket], radiance);
            sums[first + bucket] = sum;
            errors[first + bucket] += lost;
        });
    }

    /// Returns the sums of all pixels as a strip.
    pub fn as_strip(&mut self) -> BucketStrip<'_> {
        BucketStrip { shares: self.shares.as_deref(), sums: &mut self.sums }
    }

    /// Adds other sums of the same pixels, with the rounding errors of both.
    pub fn add_exactly(&mut self, other: &Self) {
        self.errors.resize(self.sums.len(), 0.0);
        let sums = self.sums.iter_mut().zip(&mut self.errors);
        for (i, ((sum, error), light)) in sums.zip(&other.sums).enumerate() {
            let (more, lost) = two_sum(*sum, *light);
            *sum = more;
            *error += lost + other.errors.get(i).copied().unwrap_or_default();
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
        let sums = tile.cut_columns(frame, &self.sums, self.count());
        Self { shares: self.shares.clone(), sums, errors: Vec::new() }
    }

    /// Replaces the sums of a tile of these pixels of a frame.
    pub fn paste(&mut self, tile: &Tile, frame: &Frame, from: &Self) {
        let count = self.count();
        tile.paste_columns(frame, &from.sums, &mut self.sums, count);
    }

    pub fn save(&self, to: &mut ChecksumWriter) -> io::Result<()> {
        to.numbers(&self.sums)
    }

    /// Adds the saved sums of the same pixels.
    pub fn receive(&mut self, from: &mut ChecksumReader) -> io::Result<()> {
        from.add_numbers(&mut self.sums)
    }
}
