//! Adding up what arrives: a stage, and the film that keeps the sums.

use std::io;

use super::{Dropped, Frame, Response, SampleName, Tile};
use crate::checkpoint::{Reader, Writer};
use crate::image::Picture;
use crate::rays::{Column, NONE, SampleBatch};

/// Sums of the radiance that a tile's pixels received.
#[derive(Clone, Debug, Default)]
pub struct TileSums {
    tile: Tile,
    sums: Vec<[f64; 3]>,
    /// Of the squares, where somebody asks for the variance.
    squares: Vec<[f64; 3]>,
    /// Samples that were not finite and were left out.
    pub dropped: Dropped,
}

impl TileSums {
    /// A tile that has received nothing; `squares` says whether its variance will be asked for.
    pub fn new(tile: &Tile, squares: bool) -> Self {
        let pixels = (tile.size[0] * tile.size[1]) as usize;
        let squares = vec![[0.0; 3]; if squares { pixels } else { 0 }];
        Self { tile: *tile, sums: vec![[0.0; 3]; pixels], squares, dropped: Dropped::default() }
    }

    /// Adds what the same tile received from other samples.
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

    /// What its pixels received, row by row, added up.
    pub fn light(&self) -> &[[f64; 3]] {
        &self.sums
    }

    pub(crate) fn save(&self, to: &mut Writer) -> io::Result<()> {
        to.sums(&self.sums)?;
        to.sums(&self.squares)?;
        self.dropped.save(to)
    }

    /// Adds what was saved of the same tile.
    pub(crate) fn receive(&mut self, from: &mut Reader) -> io::Result<()> {
        from.add_sums(&mut self.sums)?;
        from.add_sums(&mut self.squares)?;
        self.dropped.receive(from, &self.tile)
    }

    /// Adds a wave: a stage. A sample whose pixel is [`NONE`] arrives by another wave. What is not
    /// a finite number is left out, and noted.
    pub fn accumulate(
        &mut self,
        film: &Response,
        samples: &SampleBatch,
        radiance: &[Column<f32>; 3],
    ) {
        let signed = film.filter.signed();
        for i in (0..samples.len).filter(|&i| samples.pixel[i] != NONE) {
            let light = [0, 1, 2].map(|c| f64::from(radiance[c][i]));
            if !(light[0] + light[1] + light[2]).is_finite() {
                let pixel = self.tile.pixel(samples.pixel[i]);
                self.dropped.note(SampleName::new(pixel, samples.sample[i], samples.seed));
                continue;
            }
            let mut light = film.to(light);
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

/// What a picture holds is finite: a sum of numbers may be more than f32 has.
pub(crate) fn single(value: f64) -> f32 {
    value.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32
}

/// Pixels by which a film gives way to its picture: 1.5 MB, which the system takes back at once.
const GIVEN_UP: usize = 1 << 16;

/// Sums of the radiance that a picture's pixels received.
#[derive(Clone, Debug)]
pub struct FilmSums {
    frame: Frame,
    sums: Vec<[f64; 3]>,
    squares: Vec<[f64; 3]>,
    /// Of every pixel's mean, where the sums are means already.
    settled: Option<Vec<[f32; 3]>>,
    /// Samples that were not finite and were left out.
    pub dropped: Dropped,
}

impl FilmSums {
    /// Bytes of a pixel.
    pub fn bytes(squares: bool) -> u64 {
        (if squares { 2 } else { 1 }) * size_of::<[f64; 3]>() as u64
    }

    /// A film that has received nothing; `squares` says whether its variance will be asked for.
    pub fn new(frame: Frame, squares: bool) -> Self {
        let [width, height] = frame.size().map(|n| n as usize);
        let squares = vec![[0.0; 3]; if squares { width * height } else { 0 }];
        let sums = vec![[0.0; 3]; width * height];
        Self { frame, sums, squares, settled: None, dropped: Dropped::default() }
    }

    /// A film of means that need no more division, as pixels took different numbers of samples;
    /// with their variance, which is empty where nobody knows it.
    pub fn settled(frame: Frame, means: Vec<[f64; 3]>, variance: Vec<[f32; 3]>) -> Self {
        let dropped = Dropped::default();
        Self { frame, sums: means, squares: Vec::new(), settled: Some(variance), dropped }
    }

    pub(crate) fn save(&self, to: &mut Writer) -> io::Result<()> {
        to.sums(&self.sums)
    }

    /// Adds what was saved of a film of the same pixels.
    pub(crate) fn receive(&mut self, from: &mut Reader) -> io::Result<()> {
        from.add_sums(&mut self.sums)
    }

    /// Adds this share of what another film of the same pixels received.
    pub fn add_film(&mut self, other: &Self, share: f64) {
        for (sum, light) in self.sums.iter_mut().zip(&other.sums) {
            *sum = [0, 1, 2].map(|c| sum[c] + share * light[c]);
        }
    }

    /// What the pixels of a tile have received. What was left out there is not known here.
    pub fn tile(&self, tile: &Tile) -> TileSums {
        let mut sums = TileSums::new(tile, false);
        sums.sums = tile.cut(&self.frame, &self.sums);
        if !self.squares.is_empty() {
            sums.squares = tile.cut(&self.frame, &self.squares);
        }
        sums
    }

    /// Takes over the pixels of a tile, as [`FilmSums::tile`] gave them.
    pub fn put(&mut self, tile: &Tile, received: &TileSums) {
        tile.paste(&self.frame, &received.sums, &mut self.sums);
        if !self.squares.is_empty() {
            tile.paste(&self.frame, &received.squares, &mut self.squares);
        }
    }

    /// Adds what the pixels of a tile received from other samples.
    pub fn add_tile(&mut self, tile: &Tile, more: &TileSums) {
        let mut sums = self.tile(tile);
        sums.add(more);
        self.put(tile, &sums);
        self.dropped.add(&more.dropped);
    }

    /// Makes means of its sums, by the samples that the pixels of each tile took; their variance
    /// is not known any more.
    pub fn settle<'a>(&mut self, samples: impl Iterator<Item = (&'a Tile, u32)>) {
        for (tile, samples) in samples {
            let scale = 1.0 / f64::from(samples.max(1));
            let mut means = tile.cut(&self.frame, &self.sums);
            means.as_flattened_mut().iter_mut().for_each(|sum| *sum *= scale);
            tile.paste(&self.frame, &means, &mut self.sums);
        }
        (self.squares, self.settled) = (Vec::new(), Some(Vec::new()));
    }

    /// Adds light to a pixel of the picture, by its coordinates there, beside its samples.
    pub fn add(&mut self, [x, y]: [u32; 2], light: [f64; 3]) {
        let row = self.frame.size()[0];
        let place = (y - self.frame.low[1]) * row + (x - self.frame.low[0]);
        let sum = &mut self.sums[place as usize];
        *sum = [0, 1, 2].map(|c| sum[c] + light[c]);
    }

    /// The variance of every pixel's mean over this many samples, by channel: the square of its
    /// standard error. `None` where the squares were not added up. A film of means knows its own.
    pub fn variance(&self, samples: u32) -> Option<Vec<[f32; 3]>> {
        if let Some(variance) = &self.settled {
            return (!variance.is_empty()).then(|| variance.clone());
        }
        let n = f64::from(samples);
        let variance = |(sum, square): (&[f64; 3], &[f64; 3])| {
            [0, 1, 2].map(|c| {
                let spread = (square[c] - sum[c] * sum[c] / n).max(0.0);
                single(spread / (n * (n - 1.0).max(1.0)))
            })
        };
        let all = self.sums.iter().zip(&self.squares).map(variance);
        (!self.squares.is_empty()).then(|| all.collect())
    }

    /// Whether no light has arrived anywhere.
    pub fn dark(&self) -> bool {
        self.sums.iter().flatten().all(|&sum| sum <= 0.0)
    }

    /// The mean over this many samples a pixel, or the film's means where it has them.
    pub fn picture(&self, samples: u32) -> Picture {
        let mean = self.mean(samples);
        Picture {
            size: self.frame.size().map(|n| n as usize),
            pixels: self.sums.iter().map(mean).collect(),
        }
    }

    /// [`FilmSums::picture`] of a film that is not needed any more. Never both are whole: as the
    /// picture comes to be, from its end, the film goes.
    pub fn into_picture(mut self, samples: u32) -> Picture {
        let mean = self.mean(samples);
        self.squares = Vec::new();
        let mut pixels = vec![[0.0; 3]; self.sums.len()];
        while !self.sums.is_empty() {
            let start = self.sums.len().saturating_sub(GIVEN_UP);
            for (pixel, sum) in pixels[start..].iter_mut().zip(&self.sums[start..]) {
                *pixel = mean(sum);
            }
            self.sums.truncate(start);
            self.sums.shrink_to_fit();
        }
        Picture { size: self.frame.size().map(|n| n as usize), pixels }
    }

    /// What makes a pixel of its sums.
    fn mean(&self, samples: u32) -> impl Fn(&[f64; 3]) -> [f32; 3] + use<> {
        let scale = match self.settled {
            Some(_) => 1.0,
            None => 1.0 / f64::from(samples.max(1)),
        };
        move |sum| sum.map(|s| single(s * scale))
    }
}
