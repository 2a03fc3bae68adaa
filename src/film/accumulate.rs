//! Adding up what arrives: a stage, and the film that keeps the sums.

use super::{Frame, Tile};
use crate::image::Picture;
use crate::rays::{Column, SampleBatch};

/// Sums of the radiance that a tile's pixels received.
#[derive(Clone, Debug)]
pub struct TileSums {
    sums: Vec<[f64; 3]>,
    /// Samples that were not finite and were left out.
    pub dropped: u64,
}

impl TileSums {
    /// A tile that has received nothing.
    pub fn new(tile: &Tile) -> Self {
        let pixels = (tile.size[0] * tile.size[1]) as usize;
        Self { sums: vec![[0.0; 3]; pixels], dropped: 0 }
    }

    /// Adds a wave: a stage. What is not a finite number is left out and counted.
    pub fn accumulate(&mut self, samples: &SampleBatch, radiance: &[Column<f32>; 3]) {
        for i in 0..samples.len {
            let light = [0, 1, 2].map(|c| f64::from(radiance[c][i]));
            if !(light[0] + light[1] + light[2]).is_finite() {
                self.dropped += 1;
                continue;
            }
            let sum = &mut self.sums[samples.pixel[i] as usize];
            *sum = [0, 1, 2].map(|c| sum[c] + light[c]);
        }
    }
}

/// Sums of the radiance that a picture's pixels received.
#[derive(Clone, Debug)]
pub struct FilmSums {
    frame: Frame,
    sums: Vec<[f64; 3]>,
    /// Samples that were not finite and were left out.
    pub dropped: u64,
}

impl FilmSums {
    /// A film that has received nothing.
    pub fn new(frame: Frame) -> Self {
        let [width, height] = frame.size().map(|n| n as usize);
        Self { frame, sums: vec![[0.0; 3]; width * height], dropped: 0 }
    }

    /// Takes over the pixels of a tile.
    pub fn put(&mut self, tile: &Tile, received: &TileSums) {
        self.dropped += received.dropped;
        let row = self.frame.size()[0] as usize;
        let [x, y] = [0, 1].map(|i| (tile.low[i] - self.frame.low[i]) as usize);
        let width = tile.size[0] as usize;
        for (i, pixels) in received.sums.chunks_exact(width).enumerate() {
            let start = (y + i) * row + x;
            self.sums[start..start + width].copy_from_slice(pixels);
        }
    }

    /// The mean over this many samples a pixel.
    pub fn picture(&self, samples: u32) -> Picture {
        let scale = 1.0 / f64::from(samples.max(1));
        Picture {
            size: self.frame.size().map(|n| n as usize),
            pixels: self.sums.iter().map(|sum| sum.map(|s| (s * scale) as f32)).collect(),
        }
    }
}
