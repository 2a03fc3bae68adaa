//! Accumulation stage: adds samples to the sums of a tile.

use std::io;

use super::{DroppedSamples, Response, SampleId, Tile};
use crate::io::codec::{ChecksumReader, ChecksumWriter};
use crate::rays::{Column, NO_INDEX, SampleBatch};

/// Sums of the radiance that the pixels of a tile received, row by row.
#[derive(Clone, Debug, Default)]
pub struct TileSums {
    tile: Tile,
    pub(super) sums: Vec<[f64; 3]>,
    /// Sums of squares; empty if no variance is wanted.
    pub(super) squares: Vec<[f64; 3]>,
    /// Samples that were not finite and were left out.
    pub dropped: DroppedSamples,
}

impl TileSums {
    /// Empty sums, without sums of squares.
    pub fn new(tile: &Tile) -> Self {
        Self::with_squares(tile, false)
    }

    /// Empty sums, with sums of squares for the variance if `squares` is true.
    pub fn with_squares(tile: &Tile, squares: bool) -> Self {
        let pixels = (tile.size[0] * tile.size[1]) as usize;
        let squares = vec![[0.0; 3]; if squares { pixels } else { 0 }];
        let dropped = DroppedSamples::default();
        Self { tile: *tile, sums: vec![[0.0; 3]; pixels], squares, dropped }
    }

    /// Adds sums of other samples of the same tile.
    pub fn add(&mut self, other: &Self) {
        let add = |to: &mut Vec<[f64; 3]>, from: &[[f64; 3]]| {
            for (to, from) in to.iter_mut().zip(from) {
                *to = [0, 1, 2].map(|c| to[c] + from[c]);
            }
        };
        add(&mut self.sums, &other.sums);
        add(&mut self.squares, &other.squares);
        self.dropped.add(&other.dropped);
    }

    /// Returns the sum of each pixel, row by row.
    pub fn sums(&self) -> &[[f64; 3]] {
        &self.sums
    }

    pub(crate) fn save(&self, to: &mut ChecksumWriter) -> io::Result<()> {
        to.triples(&self.sums)?;
        to.triples(&self.squares)?;
        self.dropped.save(to)
    }

    /// Adds the saved sums of the same tile.
    pub(crate) fn receive(&mut self, from: &mut ChecksumReader) -> io::Result<()> {
        from.add_triples(&mut self.sums)?;
        from.add_triples(&mut self.squares)?;
        self.dropped.receive(from, &self.tile)
    }

    /// Adds the samples of a wave, except those without a pixel ([`NO_INDEX`]), which another wave
    /// completes. A sample that is not finite is left out and recorded in [`Self::dropped`].
    pub fn accumulate(
        &mut self,
        film: &Response,
        samples: &SampleBatch,
        radiance: &[Column<f32>; 3],
    ) {
        let signed = film.filter.is_signed();
        for i in (0..samples.len).filter(|&i| samples.pixel[i] != NO_INDEX) {
            let light = [0, 1, 2].map(|c| f64::from(radiance[c][i]));
            if !(light[0] + light[1] + light[2]).is_finite() {
                let pixel = self.tile.pixel(samples.pixel[i]);
                self.dropped.record(SampleId::new(pixel, samples.sample[i], samples.seed));
                continue;
            }
            let mut light = film.apply(light);
            if signed {
                light = light.map(|c| c * f64::from(samples.weight[i]));
            }
            let sum = &mut self.sums[samples.pixel[i] as usize];
            *sum = [0, 1, 2].map(|c| sum[c] + light[c]);
            if let Some(sum) = self.squares.get_mut(samples.pixel[i] as usize) {
                *sum = [0, 1, 2].map(|c| sum[c] + light[c] * light[c]);
            }
        }
    }
}
