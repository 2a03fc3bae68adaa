//! Choosing film and pupil points: a stage.

use std::ops::Range;

use super::{Filter, Frame, Tile};
use crate::plan::EFFECTS;
use crate::rays::{SampleBatch, WAVE};
use crate::sampler::{Dimension, pair, pairs, pixel_key};
use crate::spectrum::hero;

/// Walks through the samples of a tile, wave by wave: pixel after pixel, all samples of one
/// before the next, so that rays of a wave stay together. Where the lens takes the light apart,
/// samples wait until there is a wave of their band.
#[derive(Clone, Debug)]
pub struct TileSampler {
    /// Place of each pixel that sees light: index in the tile and coordinates in the picture.
    pixels: Vec<(u32, [u32; 2])>,
    samples: Range<u32>,
    pixel: usize,
    sample: u32,
    /// By band, pixel and sample; empty where all light goes together.
    waiting: Vec<Vec<(usize, u32)>>,
}

impl TileSampler {
    /// The samples of a tile, without the pixels that see no light: `sees` says whether any
    /// pixel from the first of two to before the second does. The light is in this many bands.
    pub fn new(
        tile: &Tile,
        samples: Range<u32>,
        bands: usize,
        sees: impl Fn([u32; 2], [u32; 2]) -> bool,
    ) -> Self {
        let end = [0, 1].map(|axis| tile.low[axis] + tile.size[axis]);
        let count = if sees(tile.low, end) { tile.size[0] * tile.size[1] } else { 0 };
        let pixels = (0..count)
            .map(|i| (i, tile.pixel(i)))
            .filter(|(_, pixel)| sees(*pixel, pixel.map(|p| p + 1)))
            .collect();
        let waiting = vec![Vec::new(); if bands > 1 { bands } else { 0 }];
        Self { pixels, sample: samples.start, samples, pixel: 0, waiting }
    }

    /// How many samples the tile has in all.
    pub fn count(&self) -> u64 {
        self.pixels.len() as u64 * self.samples.len() as u64
    }

    /// The next samples of one pixel, at most so many: its place in the list, and which.
    fn next(&mut self, most: usize) -> Option<(usize, Range<u32>)> {
        let pixel = self.pixel;
        if pixel == self.pixels.len() || self.samples.is_empty() {
            return None;
        }
        let first = self.sample;
        self.sample += most.min((self.samples.end - first) as usize) as u32;
        let run = first..self.sample;
        if self.sample == self.samples.end {
            self.sample = self.samples.start;
            self.pixel += 1;
        }
        Some((pixel, run))
    }

    /// Fills the line of some band with a wave, or with what is left; answers which.
    fn gather(&mut self, seed: u32) -> Option<usize> {
        loop {
            if let Some(full) = self.waiting.iter().position(|line| line.len() >= WAVE) {
                return Some(full);
            }
            let Some((pixel, run)) = self.next(WAVE) else {
                return self.waiting.iter().position(|line| !line.is_empty());
            };
            let [x, y] = self.pixels[pixel].1;
            let key = pixel_key(x, y, seed);
            for sample in run {
                let numbers = pair(key, sample, Dimension::Wavelength);
                let band = hero(numbers, self.waiting.len());
                self.waiting[band].push((pixel, sample));
            }
        }
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
    let mut put = |(index, [x, y]): (u32, [u32; 2]), run: Range<u32>| {
        let key = pixel_key(x, y, seed);
        let to = len..len + run.len();
        batch.pixel[to.clone()].fill(index);
        batch.key[to.clone()].fill(key);
        batch.film[0][to.clone()].fill(x as f32);
        batch.film[1][to.clone()].fill(y as f32);
        len = to.end;
        for (place, sample) in batch.sample[to].iter_mut().zip(run) {
            *place = sample;
        }
        len
    };
    (batch.seed, batch.band) = (seed, 0);
    if !EFFECTS || tile.waiting.is_empty() {
        let mut room = WAVE;
        while room > 0
            && let Some((pixel, run)) = tile.next(room)
        {
            room = WAVE - put(tile.pixels[pixel], run);
        }
    } else if let Some(band) = tile.gather(seed) {
        let line = &mut tile.waiting[band];
        for (pixel, sample) in line.drain(..line.len().min(WAVE)) {
            put(tile.pixels[pixel], sample..sample + 1);
        }
        batch.band = band;
    }
    batch.len = len;
    let pitch = [0, 1].map(|i| (film[i] / f64::from(frame.resolution[i])) as f32);
    // The middle of the picture, from the middle of its first pixel.
    let centre = frame.resolution.map(|n| (n as f32 - 1.0) / 2.0);
    let SampleBatch { key, sample, film, offset, weight, pupil, .. } = batch;
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
    if EFFECTS && !tile.waiting.is_empty() {
        offset[0][..padded].copy_from_slice(&u[..padded]);
        offset[1][..padded].copy_from_slice(&v[..padded]);
    }
    let [x, y] = film;
    for i in 0..padded {
        x[i] = (centre[0] - (x[i] + u[i])) * pitch[0];
        y[i] = ((y[i] + v[i]) - centre[1]) * pitch[1];
    }
    pairs(keys, samples, Dimension::Pupil, &mut u[..], &mut v[..]);
    len > 0
}
