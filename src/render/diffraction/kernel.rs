//! Convolution kernel: the shares of a pixel's light that its surroundings receive.

use petzval_lens::FilmMap;
use rayon::prelude::*;

use super::aberrated_core::AberratedCore;
use super::point_spread::PointSpread;

/// Distance (pixels) up to which each number of sample points along a pixel's side is sufficient.
const POINTS: [(f64, usize); 3] = [(4.0, 16), (16.0, 8), (64.0, 4)];
/// The number of points farther out, where the table of the spread has no more detail.
const FAR_POINTS: usize = 2;

/// The shares of a pixel's light, by channel.
///
/// The light of a pixel is treated as coming from its centre, and is integrated over the pixels
/// that receive it: a spread narrower than a pixel changes nothing.
#[derive(Clone, Debug)]
pub(super) struct PixelKernel {
    /// Half width and half height without the centre (pixels).
    pub reach: [usize; 2],
    /// Rows from that of the pixel itself downwards. The upper half is the lower one rotated by 180
    /// degrees.
    half: Vec<[f32; 3]>,
    /// What the wavefront changes.
    core: Option<AberratedCore>,
}

impl PixelKernel {
    /// Integrates a point spread over pixels of this width and height (um), and adds what an
    /// aberrated wavefront changes.
    pub fn new(
        spread: &PointSpread,
        core: Option<AberratedCore>,
        pitch: [f64; 2],
        reach: [usize; 2],
    ) -> Self {
        let width = 2 * reach[0] + 1;
        let mut half = vec![[0.0f32; 3]; width * (reach[1] + 1)];
        let area = pitch[0] * pitch[1];
        half.par_chunks_mut(width).enumerate().for_each(|(row, shares)| {
            for (column, share) in shares.iter_mut().enumerate() {
                let offset = [column as f64 - reach[0] as f64, row as f64];
                let far = offset[0].hypot(offset[1]);
                let points = POINTS.iter().find(|(reach, _)| far < *reach);
                let points = points.map_or(FAR_POINTS, |(_, points)| *points);
                let part = |i: usize| (i as f64 + 0.5) / points as f64 - 0.5;
                let mut sum = [0.0; 3];
                for i in 0..points * points {
                    let at = [offset[0] + part(i % points), offset[1] + part(i / points)];
                    let along = |axis: usize| f64::from(FilmMap::DIRECTIONS[axis]) * at[axis];
                    let there = spread.at([0, 1].map(|axis| along(axis) * pitch[axis]));
                    sum = [0, 1, 2].map(|c| sum[c] + there[c]);
                }
                *share = sum.map(|sum| (sum * area / (points * points) as f64) as f32);
            }
        });
        let mut kernel = Self { reach, half, core };
        let extent = [0, 1].map(|i| (reach[i] as f64 + 0.5) * pitch[i]);
        let outside = spread.outside(extent);
        for (channel, outside) in outside.into_iter().enumerate() {
            kernel.normalize(channel, 1.0 - outside);
        }
        kernel
    }

    /// Normalizes the shares of a channel to the sum `whole`. If most of the light stays in its
    /// pixel, the spread there is too fine for sample points, and the central share is set to the
    /// remainder.
    fn normalize(&mut self, channel: usize, whole: f64) {
        let width = 2 * self.reach[0] + 1;
        let own = self.reach[0];
        let sum = |shares: &[[f32; 3]]| shares.iter().map(|s| f64::from(s[channel])).sum::<f64>();
        let beside = 2.0 * sum(&self.half[width..]) + 2.0 * sum(&self.half[..own]);
        let rest = whole - beside;
        if rest > 0.5 * whole {
            self.half[own][channel] = rest as f32;
            return;
        }
        let scale = whole / (beside + f64::from(self.half[own][channel]));
        for share in &mut self.half {
            share[channel] = (f64::from(share[channel]) * scale) as f32;
        }
    }

    /// Returns the share, by channel, of the pixel at this offset to the right and below.
    pub fn at(&self, [dx, dy]: [isize; 2]) -> [f32; 3] {
        let change = self.core.as_ref().map_or([0.0; 3], |core| core.at([dx, dy]));
        let (dx, dy) = if dy < 0 { (-dx, -dy) } else { (dx, dy) };
        let width = 2 * self.reach[0] + 1;
        let flat = self.half[dy as usize * width + (dx + self.reach[0] as isize) as usize];
        [0, 1, 2].map(|c| flat[c] + change[c])
    }

    /// Writes a row of the kernel into a plane of this size, with its centre at (0, 0) and negative
    /// offsets wrapped around. Returns whether the row holds anything.
    pub fn write_wrapped_row(
        &self,
        channel: usize,
        y: usize,
        size: [usize; 2],
        row: &mut [f64],
    ) -> bool {
        let [right, down] = self.reach.map(|reach| reach as isize);
        let dy = if y as isize <= down { y as isize } else { y as isize - size[1] as isize };
        if dy < -down {
            return false;
        }
        for dx in -right..=right {
            row[dx.rem_euclid(size[0] as isize) as usize] = self.at([dx, dy])[channel].into();
        }
        true
    }

    /// Returns for every pixel of a picture the share of the kernel that lies inside the picture.
    pub fn shares_inside(&self, channel: usize, [width, height]: [usize; 2]) -> Vec<f32> {
        let [right, down] = self.reach;
        let columns = 2 * right + 1;
        // Summed-area table.
        let mut sums = vec![0.0; (columns + 1) * (down + 2)];
        for y in 0..=down {
            let mut sum = 0.0;
            for x in 0..columns {
                sum += f64::from(self.half[y * columns + x][channel]);
                let above = sums[y * (columns + 1) + x + 1];
                sums[(y + 1) * (columns + 1) + x + 1] = above + sum;
            }
        }
        let part = |[x0, x1]: [usize; 2], [y0, y1]: [usize; 2]| {
            let sum = |x: usize, y: usize| sums[y * (columns + 1) + x];
            sum(x1, y1) - sum(x0, y1) - sum(x1, y0) + sum(x0, y0)
        };
        let mut inside = vec![0.0; width * height];
        inside.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
            for (x, inside) in row.iter_mut().enumerate() {
                let (left, right_of) = (right.min(width - 1 - x), right.min(x));
                let below = part([right - left, right + right_of + 1], [0, down.min(y) + 1]);
                let last = down.min(height - 1 - y);
                let above = part([right - right_of, right + left + 1], [1, last + 1]);
                let change = self.core.as_ref().map_or(0.0, |core| {
                    core.change_within(channel, [x, y], [width - 1 - x, height - 1 - y])
                });
                *inside = (below + above + change) as f32;
            }
        });
        inside
    }
}
