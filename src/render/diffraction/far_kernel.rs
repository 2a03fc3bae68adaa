//! Convolution kernel of light that is spread far: the shares beyond those of a [`PixelKernel`].
//!
//! [`PixelKernel`]: super::kernel::PixelKernel

use std::f64::consts::FRAC_PI_2;

use petzval_base::lanes::{Real, f32x8};
use petzval_lens::FilmMap;
use rayon::prelude::*;

use super::mapped_spread::MappedSpread;

/// Places in a pixel at which the spread is evaluated, along each side (pixels): the table has no more
/// detail.
const PLACES: [f32; 2] = [-0.25, 0.25];

/// Boundary between light that is spread near and light that is spread far: shares go over from one to
/// the other between half of this distance and the whole (pixels).
#[derive(Clone, Copy, Debug)]
pub(super) struct Boundary(pub usize);

impl Boundary {
    /// Returns the part of a share at this distance (pixels) that is near.
    pub fn near(self, distance: f64) -> f64 {
        let half = self.0 as f64 / 2.0;
        let place = ((distance - half) / half).clamp(0.0, 1.0);
        if place < 1.0 { (FRAC_PI_2 * place).cos().powi(2) } else { 0.0 }
    }
}

/// The shares of a pixel's light that pixels beyond the boundary receive, by channel.
#[derive(Clone, Debug)]
pub(super) struct FarKernel {
    /// Half width and half height without the centre (pixels).
    pub reach: [usize; 2],
    /// Rows from that of the pixel itself downwards. The upper half is the lower one rotated by 180
    /// degrees.
    pub half: Vec<[f32; 3]>,
}

impl FarKernel {
    /// Integrates a point spread over pixels of this width and height (um).
    pub fn new(
        spread: &MappedSpread,
        boundary: Boundary,
        pitch: [f64; 2],
        reach: [usize; 2],
    ) -> Self {
        let width = 2 * reach[0] + 1;
        let mut half = vec![[0.0f32; 3]; width * (reach[1] + 1)];
        let scale = [0, 1].map(|i| f64::from(FilmMap::DIRECTIONS[i]) * pitch[i]);
        let area = (pitch[0] * pitch[1]) as f32 / (PLACES.len() * PLACES.len()) as f32;
        let [per_column, per_row] = scale.map(|v| f32x8::splat(v as f32));
        half.par_chunks_mut(width).enumerate().for_each(|(row, shares)| {
            for (group, shares) in shares.chunks_mut(8).enumerate() {
                let first = (group * 8) as f64 - reach[0] as f64;
                let part = |k: usize| match row < boundary.0 {
                    true => 1.0 - boundary.near((first + k as f64).hypot(row as f64)) as f32,
                    false => 1.0,
                };
                let parts: [f32; 8] = std::array::from_fn(part);
                if parts.iter().all(|part| *part <= 0.0) {
                    continue;
                }
                let columns =
                    f32x8::load(&std::array::from_fn::<f32, 8, _>(|k| first as f32 + k as f32));
                let mut sums = [[0.0f32; 4]; 8];
                for y in PLACES {
                    for x in PLACES {
                        let across = (columns + f32x8::splat(x)) * per_column;
                        let down = f32x8::splat(row as f32 + y) * per_row;
                        let there = spread.at_lanes([across, down]);
                        for (sum, there) in sums.iter_mut().zip(there) {
                            *sum = std::array::from_fn(|c| sum[c] + there[c]);
                        }
                    }
                }
                for ((share, sum), part) in shares.iter_mut().zip(sums).zip(parts) {
                    *share = [0, 1, 2].map(|c| part * area * sum[c]);
                }
            }
        });
        Self { reach, half }
    }

    /// Writes a row of a channel, from that of the pixel downwards, with its centre first and negative
    /// offsets wrapped around.
    pub fn write_row(&self, channel: usize, y: usize, row: &mut [f32]) {
        let right = self.reach[0];
        let shares = &self.half[y * (2 * right + 1)..][..2 * right + 1];
        let wrapped = row.len() - right;
        for (value, share) in row[wrapped..].iter_mut().zip(shares) {
            *value = share[channel];
        }
        for (value, share) in row.iter_mut().zip(&shares[right..]) {
            *value = share[channel];
        }
    }
}
