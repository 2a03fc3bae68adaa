//! Light that zones spread far, over the whole picture.

use rayon::prelude::*;

use super::field_zone::GridNode;
use super::fourier::{Complex, PlaneFft, PlaneSpectrum};
use super::half_kernel::HalfKernel;
use super::kernel_sums::KernelSums;
use super::received::{Received, fill_row};
use petzval_image::Picture;

/// The sum of what all zones spread far.
pub(super) struct FarSpread {
    plane: PlaneFft<f32>,
    /// Transforms of the light received, by channel; empty before the first zone.
    sums: [PlaneSpectrum<f32>; 3],
    /// The share of the light, by channel, that each zone does not spread near.
    shares: Vec<(GridNode, [f64; 3])>,
}

impl FarSpread {
    pub fn new(size: [usize; 2], reach: [usize; 2]) -> Self {
        let plane = PlaneFft::new([size[0] + reach[0], size[1] + reach[1]]);
        Self { plane, sums: [const { PlaneSpectrum::new() }; 3], shares: Vec::new() }
    }

    /// Adds the light of a zone, of which the share `beyond` goes farther than the kernel reaches.
    pub fn add(
        &mut self,
        picture: &Picture,
        kernel: &HalfKernel,
        grid: GridNode,
        beyond: [f64; 3],
        received: &mut Received,
    ) {
        let mut share = beyond;
        for channel in 0..3 {
            let sums = KernelSums::new(kernel, channel);
            share[channel] += sums.whole();
            received.add_far_shares(channel, &sums, grid);
            self.add_channel(picture, kernel, channel, grid);
        }
        self.shares.push((grid, share));
    }

    fn add_channel(
        &mut self,
        picture: &Picture,
        kernel: &HalfKernel,
        channel: usize,
        grid: GridNode,
    ) {
        let [width, height] = picture.size;
        let light = self
            .plane
            .spectrum(height, |y, row| fill_row(picture, grid, channel, (0..width, y), row));
        let shares = self.plane.symmetric_spectrum(kernel.reach[1] + 1, |y, row| {
            kernel.write_row(channel, y, row);
            true
        });
        let sum = &mut self.sums[channel];
        if sum.is_empty() {
            sum.resize(light.len(), Complex::default());
        }
        let parts = sum.par_iter_mut().zip(&light).zip(&shares);
        parts.for_each(|((sum, light), share)| *sum += light * share);
    }

    /// Adds what all zones have spread to the light received.
    pub fn finish(&mut self, received: &mut Received) {
        for (channel, sum) in self.sums.iter_mut().enumerate() {
            received.add_spectrum(channel, &self.plane, std::mem::take(sum));
        }
    }

    /// Returns the share of the light, by channel, that is not spread near at a place relative to the
    /// picture, from 0 to 1.
    pub fn share_at(&self, place: [f64; 2]) -> [f64; 3] {
        self.shares.iter().fold([0.0; 3], |sum, (grid, share)| {
            let weight = grid.weight_at(place);
            [0, 1, 2].map(|c| sum[c] + weight * share[c])
        })
    }
}
