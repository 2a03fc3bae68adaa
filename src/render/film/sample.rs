//! Sampling stage: chooses the film and pupil points of samples.

use std::ops::Range;

use super::{Frame, Tile};
use petzval_base::rays::{SampleBatch, WAVE_SIZE};
use petzval_base::sampler::{Dimension, fill_2d, pixel_key, sample_2d};
use petzval_lens::FilmMap;
use petzval_scene::filter::PixelFilter;
use petzval_spectrum::hero_band;

/// Samples of a tile, wave by wave.
///
/// All samples of a pixel come before those of the next, so that the rays of a wave stay close. If
/// the lens disperses light, samples are queued until there is a wave of their band.
#[derive(Clone, Debug)]
pub struct TileSampler {
    /// Pixels that receive light: index in the tile, and (x, y) in the picture.
    pixels: Vec<(u32, [u32; 2])>,
    samples: Range<u32>,
    pixel: usize,
    sample: u32,
    /// Queue of each band: index into `pixels`, and sample. Empty without dispersion.
    band_queues: Vec<Vec<(usize, u32)>>,
}

impl TileSampler {
    /// The samples of a tile, without pixels that receive no light. `sees(low, high)` returns
    /// whether any pixel from `low` to before `high` receives light. The light consists of `bands`
    /// bands.
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
        let band_queues = vec![Vec::new(); if bands > 1 { bands } else { 0 }];
        Self { pixels, sample: samples.start, samples, pixel: 0, band_queues }
    }

    /// Returns the number of samples of the tile.
    pub fn count(&self) -> u64 {
        self.pixels.len() as u64 * self.samples.len() as u64
    }

    /// Returns the next samples of one pixel, at most `most`: its index in `pixels`, and the
    /// samples.
    fn next_run(&mut self, most: usize) -> Option<(usize, Range<u32>)> {
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

    /// Queues samples until a band has a whole wave, or none is left, and returns a band with
    /// samples.
    fn fill_band_queue(&mut self, seed: u32) -> Option<usize> {
        loop {
            if let Some(full) = self.band_queues.iter().position(|queue| queue.len() >= WAVE_SIZE) {
                return Some(full);
            }
            let Some((pixel, run)) = self.next_run(WAVE_SIZE) else {
                return self.band_queues.iter().position(|queue| !queue.is_empty());
            };
            let [x, y] = self.pixels[pixel].1;
            let key = pixel_key(x, y, seed);
            for sample in run {
                let numbers = sample_2d(key, sample, Dimension::Wavelength);
                let band = hero_band(numbers, self.band_queues.len());
                self.band_queues[band].push((pixel, sample));
            }
        }
    }
}

/// Fills a batch with the next samples of a tile, and returns false if none are left.
///
/// `film` is the width and height of the whole film in its own units; [`FilmMap`] says where on it the
/// pixels lie.
pub fn sample(
    tile: &mut TileSampler,
    frame: &Frame,
    filter: &PixelFilter,
    film: [f64; 2],
    seed: u32,
    batch: &mut SampleBatch,
) -> bool {
    let mut len = 0;
    let mut push = |(index, [x, y]): (u32, [u32; 2]), run: Range<u32>| {
        let key = pixel_key(x, y, seed);
        let to = len..len + run.len();
        batch.pixel[to.clone()].fill(index);
        batch.key[to.clone()].fill(key);
        batch.film[0][to.clone()].fill(x as f32);
        batch.film[1][to.clone()].fill(y as f32);
        len = to.end;
        for (slot, sample) in batch.sample[to].iter_mut().zip(run) {
            *slot = sample;
        }
        len
    };
    (batch.seed, batch.band) = (seed, 0);
    if tile.band_queues.is_empty() {
        let mut room = WAVE_SIZE;
        while room > 0
            && let Some((pixel, run)) = tile.next_run(room)
        {
            room = WAVE_SIZE - push(tile.pixels[pixel], run);
        }
    } else if let Some(band) = tile.fill_band_queue(seed) {
        let queue = &mut tile.band_queues[band];
        for (pixel, sample) in queue.drain(..queue.len().min(WAVE_SIZE)) {
            push(tile.pixels[pixel], sample..sample + 1);
        }
        batch.band = band;
    }
    batch.len = len;
    let pitch = FilmMap::new(film, frame.resolution).pitch().map(|pitch| pitch as f32);
    // Centre of the picture, relative to the centre of its first pixel (pixels).
    let centre = frame.resolution.map(|n| (n as f32 - 1.0) / 2.0);
    let SampleBatch { key, sample, film, offset, weight, pupil, .. } = batch;
    // Whole packets, so that the lanes after the last sample hold finite numbers too.
    let padded = len.next_multiple_of(8);
    let (keys, samples) = (&key[..padded], &sample[..padded]);
    let [u, v] = pupil;
    fill_2d(keys, samples, Dimension::Film, &mut u[..], &mut v[..]);
    if filter.is_signed() {
        for i in 0..padded {
            weight[i] = filter.weight([u[i], v[i]]);
        }
    }
    filter.place(0, &mut u[..padded]);
    filter.place(1, &mut v[..padded]);
    if !tile.band_queues.is_empty() {
        offset[0][..padded].copy_from_slice(&u[..padded]);
        offset[1][..padded].copy_from_slice(&v[..padded]);
    }
    let [x, y] = film;
    for i in 0..padded {
        x[i] = ((x[i] + u[i]) - centre[0]) * pitch[0];
        y[i] = ((y[i] + v[i]) - centre[1]) * pitch[1];
    }
    fill_2d(keys, samples, Dimension::Pupil, &mut u[..], &mut v[..]);
    len > 0
}
