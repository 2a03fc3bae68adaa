//! Crosstalk: charge that neighbouring photosites collect.

use rayon::prelude::*;

use super::{Bayer, at_least_zero};
use petzval_image::Picture;

/// Shares of the charge of photosites with red, green and blue filters that their four neighbours collect, a quarter
/// each.
///
/// Light that enters under a slant and charge that diffuses both do so electron by electron: the counts of neighbours
/// stay independent, and their means are those of the light spread out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Crosstalk(pub [f64; 3]);

impl Crosstalk {
    /// Largest share: a tenth for each neighbour. From a half on, no matrix undoes the mixing of channels.
    pub const MOST: f64 = 0.4;
    /// Largest charge: the sum of several is finite.
    const LARGEST: f64 = 1e30;

    /// Returns whether charge stays where it is.
    pub fn is_none(&self) -> bool {
        self.0 == [0.0; 3]
    }

    /// Spreads the light of photosites. `filter` is the channel of a pixel's filter; without filters, each pixel has a
    /// photosite for each channel, and each channel spreads for itself.
    ///
    /// Beyond the border, the picture goes on as its mirror image.
    pub(super) fn spread(
        &self,
        picture: &Picture,
        filter: Option<impl Fn([usize; 2]) -> usize + Sync>,
    ) -> Picture {
        let [width, height] = picture.size;
        // The photosite before the first has the filter of the one after it.
        let neighbours = |at: usize, count: usize| {
            let before = if at > 0 { at - 1 } else { 1.min(count - 1) };
            let after = if at + 1 < count { at + 1 } else { count.saturating_sub(2) };
            [before, after]
        };
        let charge = |[x, y]: [usize; 2], channel: usize| {
            let channel = filter.as_ref().map_or(channel, |filter| filter([x, y]));
            let light = at_least_zero(f64::from(picture.pixels[y * width + x][channel]));
            (light.min(Self::LARGEST), self.0[channel])
        };
        let mut spread = picture.clone();
        spread.pixels.par_chunks_mut(width.max(1)).enumerate().for_each(|(y, row)| {
            for (x, pixel) in row.iter_mut().enumerate() {
                let ([left, right], [up, down]) = (neighbours(x, width), neighbours(y, height));
                let around = [[left, y], [right, y], [x, up], [x, down]];
                *pixel = [0, 1, 2].map(|channel| {
                    let (own, share) = charge([x, y], channel);
                    let received = around.map(|at| charge(at, channel));
                    let received: f64 =
                        received.iter().map(|(light, share)| light * share / 4.0).sum();
                    (own * (1.0 - share) + received) as f32
                });
            }
        });
        spread
    }

    /// Returns the matrix, in rows, that maps the light behind the filters of an even surface to what photosites of a
    /// mosaic collect: red and blue have four green neighbours, green has two of either. In a quad pattern half of the
    /// neighbours have the same filter.
    pub(super) fn of_mosaic(&self, bayer: Bayer) -> [[f64; 3]; 3] {
        let other = if bayer.is_quad() { 0.5 } else { 1.0 };
        let [red, green, blue] = self.0.map(|share| share * other);
        [[1.0 - red, green, 0.0], [red / 2.0, 1.0 - green, blue / 2.0], [0.0, green, 1.0 - blue]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mosaic(size: [usize; 2], pixel: impl Fn(usize) -> [f32; 3]) -> Picture {
        Picture { size, pixels: (0..size[0] * size[1]).map(pixel).collect() }
    }

    fn filter([x, y]: [usize; 2]) -> usize {
        Bayer::Rggb.channel([x as u32, y as u32])
    }

    #[test]
    fn an_even_surface_gets_the_matrix_of_the_mosaic() {
        let crosstalk = Crosstalk([0.2, 0.1, 0.05]);
        let light = [0.3_f32, 0.8, 0.5];
        for bayer in [Bayer::Rggb, Bayer::QuadRggb] {
            let filter = |[x, y]: [usize; 2]| bayer.channel([x as u32, y as u32]);
            let spread = crosstalk.spread(&mosaic([8, 8], |_| light), Some(filter));
            let rows = crosstalk.of_mosaic(bayer);
            // Beyond the border, quad patterns go on otherwise.
            let inner = |i: &usize| [i % 8, i / 8].iter().all(|at| (1..7).contains(at));
            for i in (0..64).filter(|i| !bayer.is_quad() || inner(i)) {
                let channel = filter([i % 8, i / 8]);
                let expected: f64 = (0..3).map(|c| rows[channel][c] * f64::from(light[c])).sum();
                let found = f64::from(spread.pixels[i][channel]);
                assert!((found - expected).abs() < 1e-6, "{bayer}, {i}: {found}");
            }
        }
        let rows = crosstalk.of_mosaic(Bayer::Rggb);
        // No charge is lost: two of four photosites are green.
        let sums = [0, 1, 2]
            .map(|c| [1.0, 2.0, 1.0].iter().zip(rows).map(|(n, row)| n * row[c]).sum::<f64>());
        assert!((0..3).all(|c| (sums[c] - [1.0, 2.0, 1.0][c]).abs() < 1e-12), "{sums:?}");
    }

    #[test]
    fn a_bright_photosite_gives_a_quarter_of_its_share_to_each_neighbour() {
        let crosstalk = Crosstalk([0.4, 0.2, 0.0]);
        let point = mosaic([5, 5], |i| if i == 12 { [1.0; 3] } else { [0.0; 3] });
        let spread = crosstalk.spread(&point, Some(filter));
        let charges: Vec<f32> = (0..25).map(|i| spread.pixels[i][filter([i % 5, i / 5])]).collect();
        for (i, charge) in charges.iter().enumerate() {
            // The middle is red.
            let expected = match i {
                12 => 0.6,
                7 | 11 | 13 | 17 => 0.1,
                _ => 0.0,
            };
            assert!((charge - expected).abs() < 1e-6, "{i}: {charges:?}");
        }
        let channels = crosstalk.spread(&point, None::<fn([usize; 2]) -> usize>);
        assert_eq!(channels.pixels[12], [0.6, 0.8, 1.0]);
        assert_eq!(channels.pixels[11], [0.1, 0.05, 0.0]);
        // Infinite light spreads to neighbours that collect some of it, and no further.
        let endless = mosaic([5, 5], |i| if i == 12 { [f32::INFINITY; 3] } else { [0.5; 3] });
        let spread = Crosstalk([0.4, 0.0, 0.1]).spread(&endless, Some(filter));
        let charges: Vec<f32> = (0..25).map(|i| spread.pixels[i][filter([i % 5, i / 5])]).collect();
        assert!(charges.iter().all(|charge| charge.is_finite() && *charge > 0.2), "{charges:?}");
        assert!(charges[11] > 1e28 && charges[6] < 1.0, "{charges:?}");
        let one = crosstalk.spread(&mosaic([1, 1], |_| [1.0; 3]), Some(filter));
        assert!((one.pixels[0][0] - 1.0).abs() < 1e-6, "{:?}", one.pixels);
    }
}
