//! Convolution kernel: the shares of a pixel's light that its surroundings receive.

use petzval_lens::FilmMap;

use super::aberrated_core::AberratedCore;
use super::far_kernel::Boundary;
use super::kernel_sums::KernelSums;
use super::mapped_spread::MappedSpread;

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
    /// Integrates a point spread over pixels of this width and height (um) up to a boundary, and adds what
    /// an aberrated wavefront changes. It is not normalized.
    pub fn new(
        spread: &MappedSpread,
        core: Option<AberratedCore>,
        boundary: Option<Boundary>,
        pitch: [f64; 2],
        reach: [usize; 2],
    ) -> Self {
        let width = 2 * reach[0] + 1;
        let mut half = vec![[0.0f32; 3]; width * (reach[1] + 1)];
        let area = pitch[0] * pitch[1];
        for (i, share) in half.iter_mut().enumerate() {
            let offset = [(i % width) as f64 - reach[0] as f64, (i / width) as f64];
            let far = offset[0].hypot(offset[1]);
            let near = boundary.map_or(1.0, |boundary| boundary.near(far));
            if near == 0.0 {
                continue;
            }
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
            *share = sum.map(|sum| (near * sum * area / (points * points) as f64) as f32);
        }
        Self { reach, half, core }
    }

    /// Normalizes the shares to the sum `whole`, by channel.
    pub fn normalize(&mut self, whole: [f64; 3]) {
        (0..3).for_each(|channel| self.normalize_channel(channel, whole[channel]));
    }

    /// Normalizes the shares of a channel. If most of the light stays in its pixel, the spread there is
    /// too fine for sample points, and the central share is set to the remainder.
    fn normalize_channel(&mut self, channel: usize, whole: f64) {
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

    /// Returns a function of a pixel of a picture of this size: the share of a channel of its kernel that
    /// lies inside.
    pub fn inside(&self, channel: usize, size: [usize; 2]) -> impl Fn([usize; 2]) -> f64 + Sync {
        let sums = KernelSums::new(self.reach, &self.half, channel);
        let whole = sums.whole();
        move |at| {
            let after = [0, 1].map(|i| size[i] - 1 - at[i]);
            let core = self.core.as_ref();
            let change = core.map_or(0.0, |core| core.change_within(channel, at, after));
            let fits = (0..2).all(|i| at[i].min(after[i]) >= self.reach[i]);
            change + if fits { whole } else { sums.inside(at, size) }
        }
    }
}
