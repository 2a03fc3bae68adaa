//! Shares of a pixel's light that the pixels around it receive, of a spread that is the same on both sides.

use std::f64::consts::FRAC_PI_2;

use petzval_base::lanes::{Real, f32x8};
use petzval_lens::FilmMap;
use rayon::prelude::*;

use super::mapped_spread::MappedSpread;

/// Distance (pixels) up to which each number of sample points along a pixel's side is sufficient.
const POINTS: [(f64, usize); 3] = [(4.0, 16), (16.0, 8), (64.0, 4)];
/// The number of points farther out, where the table of the spread has no more detail.
const FAR_POINTS: usize = 2;

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

/// The shares of a pixel's light, by channel.
///
/// The light of a pixel is treated as coming from its centre, and is integrated over the pixels
/// that receive it: a spread narrower than a pixel changes nothing.
#[derive(Clone, Debug)]
pub(super) struct HalfKernel {
    /// Half width and half height without the centre (pixels).
    pub reach: [usize; 2],
    /// Rows from that of the pixel itself downwards. The upper half is the lower one rotated by 180
    /// degrees.
    pub shares: Vec<[f32; 3]>,
}

impl HalfKernel {
    /// Integrates a part of a point spread, by the distance (pixels), over pixels of this width and height
    /// (um).
    pub fn new(
        spread: &MappedSpread,
        part: impl Fn(f64) -> f64 + Sync,
        pitch: [f64; 2],
        reach: [usize; 2],
    ) -> Self {
        let width = 2 * reach[0] + 1;
        let mut shares = vec![[0.0f32; 3]; width * (reach[1] + 1)];
        shares.par_chunks_mut(width).enumerate().for_each(|(row, shares)| {
            for (group, shares) in shares.chunks_mut(8).enumerate() {
                let first = (group * 8) as f64 - reach[0] as f64;
                let distances: [f64; 8] =
                    std::array::from_fn(|k| (first + k as f64).hypot(row as f64));
                let parts = distances.map(|distance| part(distance) as f32);
                if parts != [0.0; 8] {
                    let nearest = distances.into_iter().fold(f64::INFINITY, f64::min);
                    let whole = integrate(spread, [first as f32, row as f32], nearest, pitch);
                    for ((share, whole), part) in shares.iter_mut().zip(whole).zip(parts) {
                        *share = whole.map(|v| part * v);
                    }
                }
            }
        });
        Self { reach, shares }
    }

    /// Returns the share, by channel, of the pixel at this offset to the right and below.
    pub fn at(&self, [dx, dy]: [isize; 2]) -> [f32; 3] {
        let (dx, dy) = if dy < 0 { (-dx, -dy) } else { (dx, dy) };
        let width = 2 * self.reach[0] + 1;
        self.shares[dy as usize * width + (dx + self.reach[0] as isize) as usize]
    }

    /// Writes a row of a channel, from that of the pixel downwards, with its centre first and negative
    /// offsets wrapped around.
    pub fn write_row(&self, channel: usize, y: usize, row: &mut [f32]) {
        let right = self.reach[0];
        let shares = &self.shares[y * (2 * right + 1)..][..2 * right + 1];
        let wrapped = row.len() - right;
        for (value, share) in row[wrapped..].iter_mut().zip(shares) {
            *value = share[channel];
        }
        for (value, share) in row.iter_mut().zip(&shares[right..]) {
            *value = share[channel];
        }
    }
}

/// Returns the shares of eight pixels to the right of an offset, the nearest of which is at this distance
/// (pixels).
fn integrate(
    spread: &MappedSpread,
    [first, row]: [f32; 2],
    nearest: f64,
    pitch: [f64; 2],
) -> [[f32; 3]; 8] {
    let points = POINTS.iter().find(|(reach, _)| nearest < *reach);
    let points = points.map_or(FAR_POINTS, |(_, points)| *points);
    let place = |i: usize| (i as f32 + 0.5) / points as f32 - 0.5;
    let [per_column, per_row] =
        [0, 1].map(|i| f32x8::splat(f32::from(FilmMap::DIRECTIONS[i]) * pitch[i] as f32));
    let columns = f32x8::load(&std::array::from_fn::<f32, 8, _>(|k| first + k as f32));
    let mut sums = [[0.0f32; 4]; 8];
    for i in 0..points * points {
        let across = (columns + f32x8::splat(place(i % points))) * per_column;
        let down = f32x8::splat(row + place(i / points)) * per_row;
        for (sum, density) in sums.iter_mut().zip(spread.at_lanes([across, down])) {
            *sum = std::array::from_fn(|c| sum[c] + density[c]);
        }
    }
    let area = (pitch[0] * pitch[1]) as f32 / (points * points) as f32;
    sums.map(|[r, g, b, _]| [r, g, b].map(|v| area * v))
}
