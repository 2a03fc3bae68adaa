//! Convolution kernel of light that is spread near, with the effects of aberrations.

use super::aberrated_core::AberratedCore;
use super::half_kernel::HalfKernel;
use super::kernel_sums::KernelSums;

/// The shares of a pixel's light, by channel.
#[derive(Clone, Debug)]
pub(super) struct PixelKernel {
    /// Shares for a flat wavefront.
    flat: HalfKernel,
    /// What the wavefront changes.
    core: Option<AberratedCore>,
}

impl PixelKernel {
    /// Makes a kernel that is not normalized.
    pub fn new(flat: HalfKernel, core: Option<AberratedCore>) -> Self {
        Self { flat, core }
    }

    /// Returns half the width and half the height without the centre (pixels).
    pub fn reach(&self) -> [usize; 2] {
        self.flat.reach
    }

    /// Normalizes the shares to the sum `whole`, by channel.
    pub fn normalize(&mut self, whole: [f64; 3]) {
        (0..3).for_each(|channel| self.normalize_channel(channel, whole[channel]));
    }

    /// Normalizes the shares of a channel. If most of the light stays in its pixel, the spread there is
    /// too fine for sample points, and the central share is set to the remainder.
    fn normalize_channel(&mut self, channel: usize, whole: f64) {
        let HalfKernel { reach, shares } = &mut self.flat;
        let (width, own) = (2 * reach[0] + 1, reach[0]);
        let sum = |shares: &[[f32; 3]]| shares.iter().map(|s| f64::from(s[channel])).sum::<f64>();
        let beside = 2.0 * sum(&shares[width..]) + 2.0 * sum(&shares[..own]);
        let rest = whole - beside;
        if rest > 0.5 * whole {
            shares[own][channel] = rest as f32;
            return;
        }
        let scale = whole / (beside + f64::from(shares[own][channel]));
        for share in shares {
            share[channel] = (f64::from(share[channel]) * scale) as f32;
        }
    }

    /// Returns the share, by channel, of the pixel at this offset to the right and below.
    pub fn at(&self, [dx, dy]: [isize; 2]) -> [f32; 3] {
        let change = self.core.as_ref().map_or([0.0; 3], |core| core.at([dx, dy]));
        let flat = self.flat.at([dx, dy]);
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
        let [right, down] = self.reach().map(|reach| reach as isize);
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
        let sums = KernelSums::new(&self.flat, channel);
        let whole = sums.whole();
        move |at| {
            let after = [0, 1].map(|i| size[i] - 1 - at[i]);
            let core = self.core.as_ref();
            let change = core.map_or(0.0, |core| core.change_within(channel, at, after));
            let fits = (0..2).all(|i| at[i].min(after[i]) >= self.reach()[i]);
            change + if fits { whole } else { sums.inside(at, size) }
        }
    }
}
