//! Two means of the same pixels, whose difference tells how exact they are.

use crate::film::{Tile, TileSums};
use crate::spectrum::xyz_from_srgb;

/// Two quarters of all samples.
pub(super) struct Pair {
    /// Samples that a pixel has taken in each of the two, by tile.
    pub counts: Vec<u32>,
    pub quarters: [Vec<TileSums>; 2],
}

impl Pair {
    /// A pair without a place for what tiles receive: few of them take scouts.
    pub fn new(tiles: usize) -> Self {
        Self {
            counts: vec![0; tiles],
            quarters: [(); 2].map(|()| vec![TileSums::default(); tiles]),
        }
    }

    /// Makes place for what tiles receive of these counts.
    pub fn count(&mut self, tiles: &[Tile], counts: &[u32]) {
        for (i, (tile, &count)) in tiles.iter().zip(counts).enumerate() {
            if self.counts[i] == 0 && count > 0 {
                for quarter in &mut self.quarters {
                    quarter[i] = TileSums::new(tile, false);
                }
            }
        }
        self.counts.copy_from_slice(counts);
    }

    /// The means of both quarters, for each pixel of a tile.
    pub fn means(&self, tile: usize) -> impl Iterator<Item = [[f64; 3]; 2]> {
        let scale = 1.0 / f64::from(self.counts[tile].max(1));
        let [one, other] = self.quarters.each_ref().map(|quarter| quarter[tile].light().iter());
        one.zip(other).map(move |(one, other)| [*one, *other].map(|sum| sum.map(|s| s * scale)))
    }

    /// The mean luminance over so many pixels of the picture.
    pub fn luminance(&self, pixels: f64) -> f64 {
        let means = (0..self.counts.len()).flat_map(|tile| self.means(tile));
        means.map(|[one, other]| (luminance(one) + luminance(other)) / 2.0).sum::<f64>() / pixels
    }

    /// The relative variance of the pair's mean, as far as the pair alone knows, added up over
    /// the pixels of each tile, times its count: so that it does not depend on the count.
    pub fn variances(&self, tiles: &[Tile], floor: f64) -> Vec<f64> {
        let tile = |(i, tile): (usize, &Tile)| {
            let [one, other]: [Vec<f64>; 2] =
                [0, 1].map(|of| self.means(i).map(|means| luminance(means[of])).collect());
            let light: Vec<f64> = one.iter().zip(&other).map(|(a, b)| (a + b) / 2.0).collect();
            let light = despeckled(&light, tile.size[0] as usize);
            let errors = one.iter().zip(&other).zip(light);
            let errors =
                errors.map(|((a, b), light)| relative((a - b).powi(2) / 4.0, light, floor));
            f64::from(self.counts[i]) * errors.sum::<f64>()
        };
        tiles.iter().enumerate().map(tile).collect()
    }
}

/// No pixel brighter than the brightest of its neighbours in the tile. A single sample that
/// brings much light must not make its own error look small.
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

/// A variance over the square of what it is an error of.
pub(super) fn relative(variance: f64, light: f64, floor: f64) -> f64 {
    let whole = light.max(0.0) + floor;
    if whole > 0.0 { variance / (whole * whole) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_speck_is_as_bright_as_its_neighbours() {
        let light = [1.0, 2.0, 3.0, 1.0, 9.0, 2.0, 4.0, 1.0];
        assert_eq!(despeckled(&light, 4), [1.0, 2.0, 3.0, 1.0, 2.0, 2.0, 3.0, 1.0]);
        assert_eq!(despeckled(&[5.0], 1), [5.0]);
    }
}
