//! What the pixels around a pixel get of its light.

use rayon::prelude::*;

use super::spread::Spread;

/// How far, pixels, each number of points along a pixel's side is enough.
const POINTS: [(f64, usize); 3] = [(4.0, 16), (16.0, 8), (64.0, 4)];
/// The number farther out, where the spread is not known to more detail.
const FAR_POINTS: usize = 2;

/// The shares of a pixel's light, by channel. Light counts as if it all came to the middle of its
/// pixel, and is added up over the pixels that it is spread to: a spread narrower than a pixel
/// changes nothing.
#[derive(Clone, Debug)]
pub(super) struct Kernel {
    /// How far it goes, pixels.
    pub reach: [usize; 2],
    /// Row by row, from that of the pixel itself downwards; upwards is the same, turned around.
    half: Vec<[f32; 3]>,
}

impl Kernel {
    /// Of a spread, for pixels of this width and height, um.
    pub fn new(spread: &Spread, pitch: [f64; 2], reach: [usize; 2]) -> Self {
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
                    // The picture is the film's mirror image in x and upside down.
                    let x = -(offset[0] + part(i % points)) * pitch[0];
                    let y = (offset[1] + part(i / points)) * pitch[1];
                    let there = spread.at([x, y]);
                    sum = [0, 1, 2].map(|c| sum[c] + there[c]);
                }
                *share = sum.map(|sum| (sum * area / (points * points) as f64) as f32);
            }
        });
        let mut kernel = Self { reach, half };
        let extent = [0, 1].map(|i| (reach[i] as f64 + 0.5) * pitch[i]);
        let outside = spread.outside(extent);
        for (channel, outside) in outside.into_iter().enumerate() {
            kernel.balance(channel, 1.0 - outside);
        }
        kernel
    }

    /// Makes the shares of a channel add up: where most of the light stays in its pixel, its spread
    /// there is too fine for points and is what the others leave.
    fn balance(&mut self, channel: usize, whole: f64) {
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

    /// The share, by channel, of the pixel so far to the right and below.
    pub fn at(&self, [dx, dy]: [isize; 2]) -> [f32; 3] {
        let (dx, dy) = if dy < 0 { (-dx, -dy) } else { (dx, dy) };
        let width = 2 * self.reach[0] + 1;
        self.half[dy as usize * width + (dx + self.reach[0] as isize) as usize]
    }

    /// Writes a row of a plane of this size in which the pixel itself is at 0, 0 and what is to
    /// the left and above comes in from the other side.
    pub fn wrapped(&self, channel: usize, y: usize, size: [usize; 2], row: &mut [f64]) -> bool {
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

    /// For every pixel of a picture, the share of the kernel that lies inside the picture.
    pub fn inside(&self, channel: usize, [width, height]: [usize; 2]) -> Vec<f32> {
        let [right, down] = self.reach;
        let columns = 2 * right + 1;
        // Sums from the first column, of the row and all before it.
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
                *inside = (below + above) as f32;
            }
        });
        inside
    }
}
