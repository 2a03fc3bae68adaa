//! Accumulation stage: adds samples to the sums of a tile.

use std::io;

use super::extra_sums::{ExtraChannels, ExtraSums};
use super::{DroppedSamples, Response, SampleId, Tile};
use petzval_base::io::codec::{ChecksumReader, ChecksumWriter};
use petzval_base::rays::{Column, NO_INDEX, SampleBatch};

/// Sums of the radiance that the pixels of a tile received, row by row.
///
/// Waves complete samples in an order that depends on how many samples they take at once. The sums
/// carry their rounding errors along (Neumaier 1974), so that they do not depend on it.
#[derive(Clone, Debug, Default)]
pub struct TileSums {
    tile: Tile,
    pub(super) sums: Vec<[f64; 3]>,
    /// The rounding errors of the sums; empty if they are part of the sums already.
    errors: Vec<[f64; 3]>,
    /// Sums of squares; empty if no variance is wanted.
    pub(super) squares: Vec<[f64; 3]>,
    pub(super) extra: ExtraSums,
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
        Self { tile: *tile, sums: vec![[0.0; 3]; pixels], squares, ..Self::default() }
    }

    /// Adds channels beside the colours.
    #[must_use]
    pub fn with_extra(self, channels: &ExtraChannels) -> Self {
        Self { extra: ExtraSums::new(channels, self.sums.len()), ..self }
    }

    /// Adds sums of other samples of the same tile, with the rounding errors of both.
    pub fn add_exactly(&mut self, other: &Self) {
        self.errors.resize(self.sums.len(), [0.0; 3]);
        for (i, light) in other.sums.iter().enumerate() {
            let error = other.errors.get(i).copied().unwrap_or_default();
            for c in 0..3 {
                let (sum, lost) = two_sum(self.sums[i][c], light[c]);
                self.sums[i][c] = sum;
                self.errors[i][c] += lost + error[c];
            }
        }
        self.extra.add_exactly(&other.extra);
        self.dropped.add(&other.dropped);
    }

    /// Rounds the sums and their errors to single numbers.
    pub fn round(&mut self) {
        for (sum, error) in self.sums.iter_mut().zip(std::mem::take(&mut self.errors)) {
            *sum = [0, 1, 2].map(|c| sum[c] + error[c]);
        }
        self.extra.round();
    }

    /// Adds rounded sums of other samples of the same tile.
    pub fn add(&mut self, other: &Self) {
        let add = |to: &mut Vec<[f64; 3]>, from: &[[f64; 3]]| {
            for (to, from) in to.iter_mut().zip(from) {
                *to = [0, 1, 2].map(|c| to[c] + from[c]);
            }
        };
        add(&mut self.sums, &other.sums);
        add(&mut self.squares, &other.squares);
        self.extra.add(&other.extra, 1.0);
        self.dropped.add(&other.dropped);
    }

    /// Returns the sum of each pixel, row by row.
    pub fn sums(&self) -> &[[f64; 3]] {
        &self.sums
    }

    /// Returns the sums of the extra channels of each pixel, pixel by pixel.
    pub fn extra_sums(&self) -> &[f64] {
        self.extra.sums()
    }

    pub(crate) fn save(&self, to: &mut ChecksumWriter) -> io::Result<()> {
        to.triples(&self.sums)?;
        to.triples(&self.squares)?;
        self.extra.save(to)?;
        self.dropped.save(to)
    }

    /// Adds the saved sums of the same tile.
    pub(crate) fn receive(&mut self, from: &mut ChecksumReader) -> io::Result<()> {
        from.add_triples(&mut self.sums)?;
        from.add_triples(&mut self.squares)?;
        self.extra.receive(from)?;
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
        self.errors.resize(self.sums.len(), [0.0; 3]);
        let signed = film.filter.is_signed();
        let ExtraChannels { buckets, left_half } = self.extra.channels();
        let (has_buckets, has_left) = (buckets.is_some(), *left_half);
        for i in (0..samples.len).filter(|&i| samples.pixel[i] != NO_INDEX) {
            let received = [0, 1, 2].map(|c| f64::from(radiance[c][i]));
            let light = film.to_rgb(samples.set, received);
            if !(light[0] + light[1] + light[2]).is_finite() {
                let pixel = self.tile.pixel(samples.pixel[i]);
                self.dropped.record(SampleId::new(pixel, samples.sample[i], samples.seed));
                continue;
            }
            let pixel = samples.pixel[i] as usize;
            if has_buckets {
                let weight = if signed { f64::from(samples.weight[i]) } else { 1.0 };
                let spectrum = film.limit(light, received).map(|value| weight * value);
                self.extra.add_spectrum_exactly(pixel, samples.set, spectrum);
            }
            let mut light = film.apply(light);
            if signed {
                light = light.map(|c| c * f64::from(samples.weight[i]));
            }
            if has_left && samples.left_half[i] {
                self.extra.add_left_exactly(pixel, light);
            }
            let (sum, error) = (&mut self.sums[pixel], &mut self.errors[pixel]);
            for c in 0..3 {
                let (more, lost) = two_sum(sum[c], light[c]);
                sum[c] = more;
                error[c] += lost;
            }
            if let Some(sum) = self.squares.get_mut(pixel) {
                *sum = [0, 1, 2].map(|c| sum[c] + light[c] * light[c]);
            }
        }
    }
}

/// Returns the rounded sum of two numbers and its rounding error, which is exact (Knuth 1969). An
/// infinite sum has none.
pub(super) fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let part = sum - a;
    let error = (a - (sum - part)) + (b - part);
    (sum, if error.is_finite() { error } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use petzval_scene::filter::PixelFilter;
    use petzval_scene::filter::Profile;

    /// Returns the sum of the light of some samples of one pixel, taken in steps.
    fn sum(steps: &[&[f32]]) -> [f64; 3] {
        let film = Response {
            filter: PixelFilter::new(Profile::Box, [0.5, 0.5]),
            max_component: None,
            ..Response::default()
        };
        let tile = Tile { low: [0, 0], size: [1, 1] };
        let mut whole = TileSums::new(&tile);
        for light in steps {
            let mut samples = SampleBatch { len: light.len(), ..SampleBatch::default() };
            let mut radiance = <[Column<f32>; 3]>::default();
            for (i, &light) in light.iter().enumerate() {
                samples.pixel[i] = 0;
                radiance.iter_mut().for_each(|column| column[i] = light);
            }
            let mut step = TileSums::new(&tile);
            step.accumulate(&film, &samples, &radiance);
            whole.add_exactly(&step);
        }
        whole.round();
        whole.sums()[0]
    }

    #[test]
    fn sums_do_not_depend_on_the_order_or_the_steps() {
        // Each number is below the rounding error of the one before.
        let expected = sum(&[&[1e28, 3e12, 7e-5, 9e-22, 5e12]]);
        assert!(expected[0] > 1e28_f32.into(), "{expected:?}");
        assert_eq!(sum(&[&[9e-22, 5e12, 7e-5], &[3e12], &[1e28]]), expected);
        assert_eq!(sum(&[&[5e12], &[3e12, 1e28, 9e-22], &[7e-5]]), expected);
    }

    #[test]
    fn sums_beyond_f64_stay_infinite() {
        assert_eq!(two_sum(f64::MAX, f64::MAX), (f64::INFINITY, 0.0));
    }
}
