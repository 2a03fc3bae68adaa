//! Film of a whole picture: sums of its samples' radiance, and the means and variances of them.

use std::io;

use super::extra_sums::{ExtraChannels, ExtraStrip, ExtraSums};
use super::{DroppedSamples, Frame, Response, Tile, TileSums};
use petzval_base::io::codec::{ChecksumReader, ChecksumWriter};
use petzval_image::{ImageLayer, Picture, spectral_layer};

/// Rounds a value to f32, clamped to the range of finite numbers.
///
/// The film drops samples that are not finite, but a finite sum can still exceed f32. It becomes
/// the largest f32 instead of infinity: its samples cannot be told apart any more, and an infinite
/// pixel would spread through every later filter. A picture is therefore always finite.
pub(crate) fn clamp_to_f32(value: f64) -> f32 {
    value.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32
}

/// Pixels whose sums are freed at once while the picture is made: 1.5 MB, a block that the system
/// takes back immediately.
const FREED_PIXELS: usize = 1 << 16;

/// Sums of the radiance that the pixels of a picture received.
#[derive(Clone, Debug)]
pub struct FilmSums {
    frame: Frame,
    sums: Vec<[f64; 3]>,
    /// Sums of squares; empty if no variance is wanted.
    squares: Vec<[f64; 3]>,
    /// If the sums are means already: the variance of every pixel's mean, empty if unknown.
    mean_variance: Option<Vec<[f32; 3]>>,
    extra: ExtraSums,
    /// Samples that were not finite and were left out.
    pub dropped: DroppedSamples,
}

/// Light that a pixel of the picture receives outside any sample.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Splat {
    /// The pixel, (x, y) in the whole picture.
    pub pixel: [u32; 2],
    /// Set of the wavelengths of the light, if paths carry spectra.
    pub set: u16,
    /// Whether the light passed the left half of the exit pupil, if the film records it.
    pub left_half: bool,
    /// Linear sRGB, or values relative to daylight at the wavelengths of the set, of a path that stands for
    /// those of all sets.
    pub light: [f32; 3],
}

/// Rows of a film, which receive light that belongs to no sample.
pub(crate) struct FilmStrip<'a> {
    /// Its first pixel, (x, y) in the whole picture.
    first: [u32; 2],
    width: u32,
    sums: &'a mut [[f64; 3]],
    extra: ExtraStrip<'a>,
}

impl FilmStrip<'_> {
    /// Adds light to its pixel.
    #[inline(always)]
    pub fn add(&mut self, splat: &Splat, response: &Response) {
        let Splat { pixel: [x, y], set, left_half, light } = *splat;
        let (set, light) = (usize::from(set), light.map(f64::from));
        let index = ((y - self.first[1]) * self.width + (x - self.first[0])) as usize;
        let colour = response.apply_colour(response.to_rgb(set, light));
        let sum = &mut self.sums[index];
        *sum = [0, 1, 2].map(|c| sum[c] + colour[c]);
        self.extra.add(index, (set, light), left_half.then_some(colour));
    }
}

impl FilmSums {
    /// Returns the size of a pixel (bytes), with or without sums of squares.
    pub fn bytes_per_pixel(squares: bool) -> u64 {
        (if squares { 2 } else { 1 }) * size_of::<[f64; 3]>() as u64
    }

    /// An empty film that will not know its variance.
    pub fn new(frame: Frame) -> Self {
        Self::with_squares(frame, false)
    }

    /// An empty film. With sums of squares it will know its variance.
    pub fn with_squares(frame: Frame, squares: bool) -> Self {
        let [width, height] = frame.size().map(|n| n as usize);
        let squares = vec![[0.0; 3]; if squares { width * height } else { 0 }];
        let sums = vec![[0.0; 3]; width * height];
        Self {
            frame,
            sums,
            squares,
            mean_variance: None,
            extra: ExtraSums::default(),
            dropped: DroppedSamples::default(),
        }
    }

    /// Adds channels beside the colours.
    #[must_use]
    pub fn with_extra(self, channels: &ExtraChannels) -> Self {
        Self { extra: ExtraSums::new(channels, self.sums.len()), ..self }
    }

    /// A film of means, for pixels that took different numbers of samples. `variance` is that of
    /// every mean, empty if unknown.
    pub fn from_means(frame: Frame, means: Vec<[f64; 3]>, variance: Vec<[f32; 3]>) -> Self {
        Self {
            frame,
            sums: means,
            squares: Vec::new(),
            mean_variance: Some(variance),
            extra: ExtraSums::default(),
            dropped: DroppedSamples::default(),
        }
    }

    pub(crate) fn save(&self, to: &mut ChecksumWriter) -> io::Result<()> {
        to.triples(&self.sums)?;
        self.extra.save(to)
    }

    /// Adds the saved sums of a film of the same pixels.
    pub(crate) fn receive(&mut self, from: &mut ChecksumReader) -> io::Result<()> {
        from.add_triples(&mut self.sums)?;
        self.extra.receive(from)
    }

    /// Adds another film of the same pixels, multiplied by `scale`.
    pub fn add_film(&mut self, other: &Self, scale: f64) {
        for (sum, light) in self.sums.iter_mut().zip(&other.sums) {
            *sum = [0, 1, 2].map(|c| sum[c] + scale * light[c]);
        }
        self.extra.add(&other.extra, scale);
    }

    /// Returns the sums of a tile, without its dropped samples, which the film knows only in total.
    pub fn tile(&self, tile: &Tile) -> TileSums {
        let mut sums = TileSums::new(tile);
        sums.sums = tile.cut(&self.frame, &self.sums);
        if !self.squares.is_empty() {
            sums.squares = tile.cut(&self.frame, &self.squares);
        }
        sums.extra = self.extra.cut(tile, &self.frame);
        sums
    }

    /// Sets the sums of a tile.
    pub fn set_tile(&mut self, tile: &Tile, received: &TileSums) {
        tile.paste(&self.frame, &received.sums, &mut self.sums);
        if !self.squares.is_empty() {
            tile.paste(&self.frame, &received.squares, &mut self.squares);
        }
        self.extra.paste(tile, &self.frame, &received.extra);
    }

    /// Adds sums of other samples to those of a tile.
    pub fn add_tile(&mut self, tile: &Tile, more: &TileSums) {
        let mut sums = self.tile(tile);
        sums.add(more);
        self.set_tile(tile, &sums);
        self.dropped.add(&more.dropped);
    }

    /// Adds the extra channels of a tile, multiplied by `scale`, to those of a film of means.
    pub fn add_extra_means(&mut self, tile: &Tile, more: &TileSums, scale: f64) {
        let mut sums = self.extra.cut(tile, &self.frame);
        sums.add(&more.extra, scale);
        self.extra.paste(tile, &self.frame, &sums);
    }

    /// Turns the sums into means, given the number of samples of each tile's pixels. The variance
    /// is unknown afterwards.
    pub fn normalize<'a>(&mut self, samples: impl Iterator<Item = (&'a Tile, u32)>) {
        for (tile, samples) in samples {
            let scale = 1.0 / f64::from(samples.max(1));
            let mut means = tile.cut(&self.frame, &self.sums);
            means.as_flattened_mut().iter_mut().for_each(|sum| *sum *= scale);
            tile.paste(&self.frame, &means, &mut self.sums);
            let mut means = self.extra.cut(tile, &self.frame);
            means.scale(scale);
            self.extra.paste(tile, &self.frame, &means);
        }
        (self.squares, self.mean_variance) = (Vec::new(), Some(Vec::new()));
    }

    /// Divides the film into strips of so many rows.
    pub(crate) fn strips(&mut self, rows: u32) -> Vec<FilmStrip<'_>> {
        let (mut first, width) = (self.frame.low, self.frame.size()[0]);
        let mut rest = self.extra.as_strip();
        let mut strips = Vec::new();
        for sums in self.sums.chunks_mut((rows * width).max(1) as usize) {
            let [extra, others] = rest.split_at(sums.len());
            strips.push(FilmStrip { first, width, sums, extra });
            first[1] += rows;
            rest = others;
        }
        strips
    }

    /// Returns the variance of every pixel's mean by channel, the square of its standard error, or
    /// `None` if the film does not know it. `samples` is the number of samples of each pixel; a
    /// film of means ignores it.
    pub fn variance(&self, samples: u32) -> Option<Vec<[f32; 3]>> {
        if let Some(variance) = &self.mean_variance {
            return (!variance.is_empty()).then(|| variance.clone());
        }
        let n = f64::from(samples);
        let variance = |(sum, square): (&[f64; 3], &[f64; 3])| {
            [0, 1, 2].map(|c| {
                let deviations = (square[c] - sum[c] * sum[c] / n).max(0.0);
                clamp_to_f32(deviations / (n * (n - 1.0).max(1.0)))
            })
        };
        let all = self.sums.iter().zip(&self.squares).map(variance);
        (!self.squares.is_empty()).then(|| all.collect())
    }

    /// Returns the mean spectral radiance of every pixel by bucket as a layer, in the unit of
    /// [`petzval_spectrum::BucketShares::spread`]; `None` without buckets. `samples` is the number of samples
    /// of each pixel; a film of means ignores it.
    pub fn spectrum(&self, samples: u32) -> Option<ImageLayer> {
        let channels = self.extra.channels();
        let shares = channels.buckets.as_ref()?;
        let scale = self.scale(samples);
        let (sums, count) = (self.extra.sums(), channels.count());
        let column = |bucket: usize| {
            sums[bucket..].iter().step_by(count).map(|sum| clamp_to_f32(sum * scale)).collect()
        };
        Some(spectral_layer(&shares.buckets().middles(), column))
    }

    /// Returns the picture of the light that passed the left half of the exit pupil; `None` if the film does
    /// not record it. `samples` is the number of samples of each pixel; a film of means ignores it.
    pub(crate) fn left_half(&self, samples: u32) -> Option<Picture> {
        let channels = self.extra.channels();
        let mean = self.mean(samples);
        let first = channels.bucket_count();
        let pixel = |sums: &[f64]| mean(&[0, 1, 2].map(|c| sums[first + c]));
        channels.left_half.then(|| Picture {
            size: self.frame.size().map(|n| n as usize),
            pixels: self.extra.sums().chunks_exact(channels.count()).map(pixel).collect(),
        })
    }

    /// Returns whether no pixel has received light.
    pub fn is_dark(&self) -> bool {
        self.sums.iter().flatten().all(|&sum| sum <= 0.0)
    }

    /// Returns the picture of means. `samples` is the number of samples of each pixel; a film of
    /// means ignores it.
    pub fn picture(&self, samples: u32) -> Picture {
        let mean = self.mean(samples);
        Picture {
            size: self.frame.size().map(|n| n as usize),
            pixels: self.sums.iter().map(mean).collect(),
        }
    }

    /// Converts the film to the picture of means. The film is freed from its end while the picture
    /// is written, so the two never exist in full at the same time.
    pub fn into_picture(mut self, samples: u32) -> Picture {
        let mean = self.mean(samples);
        (self.squares, self.extra) = (Vec::new(), ExtraSums::default());
        let mut pixels = vec![[0.0; 3]; self.sums.len()];
        while !self.sums.is_empty() {
            let start = self.sums.len().saturating_sub(FREED_PIXELS);
            for (pixel, sum) in pixels[start..].iter_mut().zip(&self.sums[start..]) {
                *pixel = mean(sum);
            }
            self.sums.truncate(start);
            self.sums.shrink_to_fit();
        }
        Picture { size: self.frame.size().map(|n| n as usize), pixels }
    }

    /// Returns the function from a pixel's sum to its mean.
    fn mean(&self, samples: u32) -> impl Fn(&[f64; 3]) -> [f32; 3] + use<> {
        let scale = self.scale(samples);
        move |sum| sum.map(|s| clamp_to_f32(s * scale))
    }

    /// Returns the factor from a sum to a mean.
    fn scale(&self, samples: u32) -> f64 {
        match self.mean_variance {
            Some(_) => 1.0,
            None => 1.0 / f64::from(samples.max(1)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_beyond_f32_give_the_largest_finite_pixel() {
        let frame = Frame::whole([1, 1]);
        let mut film = FilmSums::new(frame);
        film.sums[0] = [1e300, -1e300, 1.0];
        let expected = [f32::MAX, f32::MIN, 1.0];
        assert_eq!(film.picture(1).pixels, [expected]);
        assert_eq!(film.into_picture(1).pixels, [expected]);
    }
}
