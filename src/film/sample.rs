//! Choosing film and pupil points: a stage.

use std::ops::Range;

use super::{Filter, Frame, Tile};
use crate::rays::{SampleBatch, WAVE};
use crate::sampler::{Dimension, pairs, pixel_key};

/// Walks through the samples of a tile, wave by wave: pixel after pixel, all samples of one
/// before the next, so that rays of a wave stay together.
#[derive(Clone, Debug)]
pub struct TileSampler {
    /// Place of each pixel that sees light: index in the tile and coordinates in the picture.
    pixels: Vec<(u32, [u32; 2])>,
    samples: Range<u32>,
    pixel: usize,
    sample: u32,
}

impl TileSampler {
    /// The samples of a tile, without the pixels that see no light: `sees` says whether any
    /// pixel from the first of two to before the second does.
    pub fn new(
        tile: &Tile,
        samples: Range<u32>,
        sees: impl Fn([u32; 2], [u32; 2]) -> bool,
    ) -> Self {
        let end = [0, 1].map(|axis| tile.low[axis] + tile.size[axis]);
        let count = if sees(tile.low, end) { tile.size[0] * tile.size[1] } else { 0 };
        let pixels = (0..count)
            .map(|i| (i, [tile.low[0] + i % tile.size[0], tile.low[1] + i / tile.size[0]]))
            .filter(|(_, pixel)| sees(*pixel, pixel.map(|p| p + 1)))
            .collect();
        Self { pixels, sample: samples.start, samples, pixel: 0 }
    }

    /// How many samples the tile has in all.
    pub fn count(&self) -> u64 {
        self.pixels.len() as u64 * self.samples.len() as u64
    }
}

/// Fills a batch with the next samples of a tile; false when there are none left.
///
/// `film` is the size of the whole film in its own units. The picture on it is upside down
/// and mirrored: the right of the picture lies at negative x, its lower edge at positive y.
pub fn sample(
    tile: &mut TileSampler,
    frame: &Frame,
    filter: &Filter,
    film: [f64; 2],
    seed: u32,
    batch: &mut SampleBatch,
) -> bool {
    let mut len = 0;
    while len < WAVE && tile.pixel < tile.pixels.len() {
        let (index, [x, y]) = tile.pixels[tile.pixel];
        let key = pixel_key(x, y, seed);
        let count = (WAVE - len).min((tile.samples.end - tile.sample) as usize);
        for i in 0..count {
            batch.pixel[len + i] = index;
            batch.key[len + i] = key;
            batch.sample[len + i] = tile.sample + i as u32;
            batch.film[0][len + i] = x as f32;
            batch.film[1][len + i] = y as f32;
        }
        len += count;
        tile.sample += count as u32;
        if tile.sample == tile.samples.end {
            tile.sample = tile.samples.start;
            tile.pixel += 1;
        }
    }
    batch.len = len;
    let pitch = [0, 1].map(|i| (film[i] / f64::from(frame.resolution[i])) as f32);
    // The middle of the picture, from the middle of its first pixel.
    let centre = frame.resolution.map(|n| (n as f32 - 1.0) / 2.0);
    let SampleBatch { key, sample, film, weight, pupil, .. } = batch;
    // Whole packets, so that the lanes behind the last sample hold numbers too.
    let padded = len.next_multiple_of(8);
    let (keys, samples) = (&key[..padded], &sample[..padded]);
    let [u, v] = pupil;
    pairs(keys, samples, Dimension::Film, &mut u[..], &mut v[..]);
    if filter.signed() {
        for i in 0..padded {
            weight[i] = filter.weight([u[i], v[i]]);
        }
    }
    filter.place(0, &mut u[..padded]);
    filter.place(1, &mut v[..padded]);
    let [x, y] = film;
    for i in 0..padded {
        x[i] = (centre[0] - (x[i] + u[i])) * pitch[0];
        y[i] = ((y[i] + v[i]) - centre[1]) * pitch[1];
    }
    pairs(keys, samples, Dimension::Pupil, &mut u[..], &mut v[..]);
    len > 0
}
