//! Half buffer: two independent means of the same pixels, whose difference estimates their variance.

use crate::film::{Tile, TileSums};
use crate::job::Job;
use petzval_spectrum::xyz_from_srgb;

/// Two quarters of all samples.
pub(super) struct HalfBuffer {
    /// The number of samples per pixel in each quarter, by tile.
    pub counts: Vec<u32>,
    /// The sums of each quarter, by tile.
    pub quarters: [Vec<TileSums>; 2],
}

impl HalfBuffer {
    /// Returns an empty buffer. It allocates no sums, as few tiles take pilot samples.
    pub fn new(tiles: usize) -> Self {
        Self {
            counts: vec![0; tiles],
            quarters: [(); 2].map(|()| vec![TileSums::default(); tiles]),
        }
    }

    /// Sets the counts of all tiles, and allocates the sums of those that had no samples.
    pub fn set_counts(&mut self, job: &Job, tiles: &[Tile], counts: &[u32]) {
        for (i, (tile, &count)) in tiles.iter().zip(counts).enumerate() {
            if self.counts[i] == 0 && count > 0 {
                for quarter in &mut self.quarters {
                    quarter[i] = TileSums::new(tile).with_extra(&job.extra_channels());
                }
            }
        }
        self.counts.copy_from_slice(counts);
    }

    /// Returns the means of both quarters for each pixel of a tile.
    pub fn means(&self, tile: usize) -> impl Iterator<Item = [[f64; 3]; 2]> {
        let scale = 1.0 / f64::from(self.counts[tile].max(1));
        let [first, second] = self.quarters.each_ref().map(|quarter| quarter[tile].sums().iter());
        first
            .zip(second)
            .map(move |(first, second)| [*first, *second].map(|sum| sum.map(|s| s * scale)))
    }

    /// Returns the mean luminance of a picture of this many pixels.
    pub fn luminance(&self, pixels: f64) -> f64 {
        let means = (0..self.counts.len()).flat_map(|tile| self.means(tile));
        means.map(|[first, second]| (luminance(first) + luminance(second)) / 2.0).sum::<f64>()
            / pixels
    }

    /// Returns the relative variance of one sample, added up over the pixels of each tile: the variance
    /// of the mean of both quarters, times the count.
    pub fn variances(&self, tiles: &[Tile], floor: f64) -> Vec<f64> {
        let tile = |(i, tile): (usize, &Tile)| {
            let [first, second]: [Vec<f64>; 2] = [0, 1]
                .map(|quarter| self.means(i).map(|means| luminance(means[quarter])).collect());
            let light: Vec<f64> = first.iter().zip(&second).map(|(a, b)| (a + b) / 2.0).collect();
            let light = despeckled(&light, tile.size[0] as usize);
            let errors = first.iter().zip(&second).zip(light);
            let errors = errors
                .map(|((a, b), light)| relative_variance((a - b).powi(2) / 4.0, light, floor));
            f64::from(self.counts[i]) * errors.sum::<f64>()
        };
        tiles.iter().enumerate().map(tile).collect()
    }
}

/// Limits each pixel to the brightest of its neighbours in the tile. Without this, a single very bright
/// sample would make its own relative error look small.
fn despeckled(light: &[f64], width: usize) -> Vec<f64> {
    let rows = light.len() / width;
    let around = |at: usize, count: usize| at.saturating_sub(1)..(at + 2).min(count);
    let pixel = |(i, &own): (usize, &f64)| {
        let (x, y) = (i % width, i / width);
        let near = around(y, rows).flat_map(|y| around(x, width).map(move |x| y * width + x));
        let brightest = near.filter(|&j| j != i).map(|j| light[j]).reduce(f64::max);
        brightest.map_or(own, |brightest| own.min(brightest))
    };
    light.iter().enumerate().map(pixel).collect()
}

pub(super) fn luminance(light: [f64; 3]) -> f64 {
    xyz_from_srgb(light)[1]
}

/// Returns a variance divided by the square of the luminance, raised by a floor.
pub(super) fn relative_variance(variance: f64, light: f64, floor: f64) -> f64 {
    let scale = light.max(0.0) + floor;
    if scale > 0.0 { variance / (scale * scale) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bright_pixels_are_limited_to_their_neighbours() {
        let light = [1.0, 2.0, 3.0, 1.0, 9.0, 2.0, 4.0, 1.0];
        assert_eq!(despeckled(&light, 4), [1.0, 2.0, 3.0, 1.0, 2.0, 2.0, 3.0, 1.0]);
        assert_eq!(despeckled(&[5.0], 1), [5.0]);
    }
}
