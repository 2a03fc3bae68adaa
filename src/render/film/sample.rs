//! Sampling stage: chooses the film and pupil points of samples.

use std::ops::Range;

use super::{Frame, Tile};
use petzval_base::rays::{SampleBatch, WAVE_SIZE};
use petzval_base::sampler::{Dimension, fill_2d, pixel_key};
use petzval_lens::FilmMap;
use petzval_scene::filter::PixelFilter;
use petzval_spectrum::{WAVELENGTH_SETS, WAVELENGTHS, hero_band, wavelength_set};

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
    /// Queue of each band: index into `pixels`, and sample. Empty without dispersion and spectra.
    band_queues: Vec<Vec<(u32, u32)>>,
    split: LightSplit,
    /// Group of the last wave.
    last_group: usize,
}

/// Division of the light of a picture among waves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LightSplit {
    /// Number of bands of the lens.
    pub bands: usize,
    /// Meaning of the channels of paths.
    pub spectra: SpectralSplit,
}

/// Meaning of the channels of the paths of a wave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpectralSplit {
    /// Red, green and blue.
    Rgb,
    /// The wavelengths of a set.
    Sets,
    /// The wavelengths of a set, one of which goes on behind glass of the scene that disperses.
    Heroes,
}

impl LightSplit {
    /// All light together, as red, green and blue.
    pub const NONE: Self = Self { bands: 1, spectra: SpectralSplit::Rgb };

    /// Returns the number of kinds of waves.
    fn kinds(self) -> usize {
        match (self.bands, self.spectra) {
            (1, SpectralSplit::Sets) => WAVELENGTH_SETS,
            (1, SpectralSplit::Heroes) => WAVELENGTHS,
            (bands, _) => bands,
        }
    }

    /// Returns the kind of waves of a sample, from two numbers in [0, 1).
    fn kind(self, numbers: [f32; 2]) -> usize {
        match (self.bands, self.spectra) {
            (1, SpectralSplit::Sets) => wavelength_set(numbers[0]),
            _ => hero_band(numbers, self.kinds()),
        }
    }

    /// Returns the band, and the set and the hero of its wavelengths, that two numbers in [0, 1) select.
    pub(crate) fn light_of(self, numbers: [f32; 2]) -> [usize; 3] {
        self.light(self.kind(numbers))
    }

    /// Returns the group of a kind of waves: paths of a group may go on together.
    fn group(self, kind: usize) -> usize {
        match self.spectra {
            SpectralSplit::Rgb => 0,
            SpectralSplit::Sets => kind % WAVELENGTH_SETS,
            SpectralSplit::Heroes => kind,
        }
    }

    /// Returns the band, and the set and the hero of its wavelengths, of a kind of waves.
    fn light(self, kind: usize) -> [usize; 3] {
        let band = if self.bands > 1 { kind } else { 0 };
        match self.spectra {
            SpectralSplit::Rgb => [band, 0, 0],
            _ => [band, kind % WAVELENGTH_SETS, kind / WAVELENGTH_SETS],
        }
    }
}

impl TileSampler {
    /// The samples of a tile, without pixels that receive no light. `sees(low, high)` returns
    /// whether any pixel from `low` to before `high` receives light.
    pub fn new(
        tile: &Tile,
        samples: Range<u32>,
        split: LightSplit,
        sees: impl Fn([u32; 2], [u32; 2]) -> bool,
    ) -> Self {
        let end = [0, 1].map(|axis| tile.low[axis] + tile.size[axis]);
        let count = if sees(tile.low, end) { tile.size[0] * tile.size[1] } else { 0 };
        let pixels = (0..count)
            .map(|i| (i, tile.pixel(i)))
            .filter(|(_, pixel)| sees(*pixel, pixel.map(|p| p + 1)))
            .collect();
        let kinds = split.kinds();
        let band_queues = vec![Vec::new(); if kinds > 1 { kinds } else { 0 }];
        Self { pixels, sample: samples.start, samples, pixel: 0, band_queues, split, last_group: 0 }
    }

    /// Returns whether no samples are left whose paths may go on together with those of the last wave.
    pub fn ends_group(&self) -> bool {
        if self.split.spectra == SpectralSplit::Rgb {
            return false;
        }
        let of_group = |(kind, queue): (usize, &Vec<(u32, u32)>)| {
            self.split.group(kind) == self.last_group && !queue.is_empty()
        };
        !self.band_queues.iter().enumerate().any(of_group)
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

    /// Queues samples of a pixel by their kind of waves.
    fn queue(&mut self, pixel: usize, key: u32, samples: Range<u32>) {
        // So many that their numbers are calculated in vectors.
        const AT_ONCE: usize = 64;
        let (keys, mut numbers) = ([key; AT_ONCE], [0; AT_ONCE]);
        let [mut u, mut v] = [[0.0; AT_ONCE]; 2];
        for first in samples.clone().step_by(AT_ONCE) {
            let len = AT_ONCE.min((samples.end - first) as usize);
            for (number, sample) in numbers[..len].iter_mut().zip(first..) {
                *number = sample;
            }
            fill_2d(&keys[..len], &numbers[..len], Dimension::Wavelength, &mut u, &mut v);
            for i in 0..len {
                let kind = self.split.kind([u[i], v[i]]);
                self.band_queues[kind].push((pixel as u32, numbers[i]));
            }
        }
    }

    /// Queues samples until a band has a whole wave, or none is left, and returns a band with
    /// samples. If paths carry spectra, all samples are queued, and those of a group follow each other.
    fn fill_band_queue(&mut self, seed: u32) -> Option<usize> {
        loop {
            let full = |queue: &Vec<(u32, u32)>| queue.len() >= WAVE_SIZE;
            if self.split.spectra == SpectralSplit::Rgb
                && let Some(full) = self.band_queues.iter().position(full)
            {
                return Some(full);
            }
            let Some((pixel, run)) = self.next_run(WAVE_SIZE) else {
                let left = |kind: &usize| !self.band_queues[*kind].is_empty();
                let kinds = (0..self.band_queues.len()).filter(left);
                return kinds.min_by_key(|&kind| self.split.group(kind));
            };
            let [x, y] = self.pixels[pixel].1;
            self.queue(pixel, pixel_key(x, y, seed), run);
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
    batch.seed = seed;
    [batch.band, batch.set, batch.hero] = [0; 3];
    if tile.band_queues.is_empty() {
        while len < WAVE_SIZE
            && let Some((pixel, run)) = tile.next_run(WAVE_SIZE - len)
        {
            let (index, [x, y]) = tile.pixels[pixel];
            let to = len..len + run.len();
            batch.pixel[to.clone()].fill(index);
            batch.key[to.clone()].fill(pixel_key(x, y, seed));
            batch.film[0][to.clone()].fill(x as f32);
            batch.film[1][to.clone()].fill(y as f32);
            len = to.end;
            for (slot, sample) in batch.sample[to].iter_mut().zip(run) {
                *slot = sample;
            }
        }
    } else if let Some(kind) = tile.fill_band_queue(seed) {
        let queue = &mut tile.band_queues[kind];
        for (i, (pixel, number)) in queue.drain(..queue.len().min(WAVE_SIZE)).enumerate() {
            let (index, [x, y]) = tile.pixels[pixel as usize];
            (batch.pixel[i], batch.sample[i]) = (index, number);
            batch.key[i] = pixel_key(x, y, seed);
            [batch.film[0][i], batch.film[1][i]] = [x as f32, y as f32];
            len = i + 1;
        }
        [batch.band, batch.set, batch.hero] = tile.split.light(kind);
        tile.last_group = tile.split.group(kind);
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
