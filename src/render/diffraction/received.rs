//! Light that pixels receive.

use std::ops::Range;

use rayon::prelude::*;

use super::field_zone::{FieldZone, GridNode};
use super::fourier::{PlaneFft, PlaneSpectrum};
use super::kernel::PixelKernel;
use super::kernel_sums::KernelSums;
use petzval_image::Picture;

/// Distance of the pixels for which the share of far light inside the picture is computed (pixels).
const SHARE_STEP: usize = 16;

/// Light that pixels receive, and the share of the spread of each pixel that lies inside the picture, by
/// channel.
pub(super) struct Received {
    size: [usize; 2],
    light: [Vec<f32>; 3],
    inside: [Vec<f32>; 3],
}

impl Received {
    pub fn new(size: [usize; 2]) -> Self {
        let plane = || vec![0.0; size[0] * size[1]];
        Self {
            size,
            light: std::array::from_fn(|_| plane()),
            inside: std::array::from_fn(|_| plane()),
        }
    }

    /// Adds the shares inside of the light that a zone spreads far: linear between pixels of a grid.
    pub fn add_far_shares(&mut self, channel: usize, shares: &KernelSums, grid: GridNode) {
        let size = self.size;
        let nodes = size.map(|n| (n - 1).div_ceil(SHARE_STEP) + 1);
        let at = |node: usize, axis: usize| (node * SHARE_STEP).min(size[axis] - 1);
        let table: Vec<f32> = (0..nodes[0] * nodes[1])
            .map(|i| shares.inside([at(i % nodes[0], 0), at(i / nodes[0], 1)], size) as f32)
            .collect();
        let split = |axis: usize, pixel: usize| {
            let before = (pixel / SHARE_STEP).min(nodes[axis].saturating_sub(2));
            let width = at(before + 1, axis).saturating_sub(at(before, axis)).max(1);
            (before, (pixel - at(before, axis)) as f32 / width as f32)
        };
        let rows = self.inside[channel].par_chunks_mut(size[0]).enumerate();
        rows.for_each(|(y, row)| {
            let (above, down) = split(1, y);
            let below = (above + 1).min(nodes[1] - 1);
            for (x, share) in row.iter_mut().enumerate() {
                let weight = grid.weight([x, y], size) as f32;
                if weight == 0.0 {
                    continue;
                }
                let (left, along) = split(0, x);
                let right = (left + 1).min(nodes[0] - 1);
                let mix = |row: usize| {
                    let [a, b] = [left, right].map(|column| table[row * nodes[0] + column]);
                    a + along * (b - a)
                };
                *share += weight * (mix(above) + down * (mix(below) - mix(above)));
            }
        });
    }

    /// Adds the light of a spectrum.
    pub fn add_spectrum(
        &mut self,
        channel: usize,
        plane: &PlaneFft<f32>,
        spectrum: PlaneSpectrum<f32>,
    ) {
        plane.inverse_rows(spectrum, &mut self.light[channel], self.size[0], |row, light| {
            light.iter_mut().zip(row).for_each(|(light, value)| *light += value);
        });
    }

    /// Adds the light that zones spread near, each over its own part of the picture.
    pub fn add_near(&mut self, picture: &Picture, zones: &[FieldZone], kernels: &[PixelKernel]) {
        let size = self.size;
        let span = |zone: &FieldZone| [0, 1].map(|axis| zone.grid.pixels(axis, size[axis]));
        let least = zones.iter().zip(kernels).fold([1; 2], |least, (zone, kernel)| {
            let span = span(zone);
            [0, 1].map(|i| least[i].max(span[i].len() + 2 * kernel.reach()[i]))
        });
        let plane = PlaneFft::<f64>::new(least);
        for (zone, kernel) in zones.iter().zip(kernels) {
            let [columns, rows] = span(zone);
            let reach = kernel.reach();
            // The part of the picture that receives light.
            let [left, top] = [columns.start, rows.start];
            let [left, top] = [left - left.min(reach[0]), top - top.min(reach[1])];
            let right = (columns.end + reach[0]).min(size[0]);
            let bottom = (rows.end + reach[1]).min(size[1]);
            for channel in 0..3 {
                let mut light = plane.spectrum(rows.end - top, |y, row| {
                    let y = top + y;
                    let row = &mut row[columns.start - left..];
                    y >= rows.start
                        && fill_row(picture, zone.grid, channel, (columns.clone(), y), row)
                });
                let shares = plane.spectrum(plane.size[1], |y, row| {
                    kernel.write_wrapped_row(channel, y, plane.size, row)
                });
                light.par_iter_mut().zip(&shares).for_each(|(light, share)| *light *= share);
                let into = &mut self.light[channel][top * size[0]..bottom * size[0]];
                plane.inverse_rows(light, into, size[0], |row, light| {
                    let light = light[left..right].iter_mut();
                    light.zip(row).for_each(|(light, value)| *light += *value as f32);
                });
                let inside = kernel.inside(channel, size);
                let chunks = self.inside[channel].par_chunks_mut(size[0]).enumerate();
                chunks.filter(|(y, _)| rows.contains(y)).for_each(|(y, row)| {
                    for x in columns.clone() {
                        row[x] += (zone.grid.weight([x, y], size) * inside([x, y])) as f32;
                    }
                });
            }
        }
    }

    /// Returns the picture, in which light from beyond its edge is that of the surroundings.
    pub fn picture(&self, before: &Picture) -> Picture {
        // Values below the darkest input are rounding errors. The input may be negative after a
        // signed filter.
        let least = [0, 1, 2].map(|channel| {
            let values = before.pixels.iter().map(|pixel| pixel[channel]);
            values.filter(|v| v.is_finite()).fold(0.0, f32::min)
        });
        let pixel =
            |i: usize| [0, 1, 2].map(|c| (self.light[c][i] / self.inside[c][i]).max(least[c]));
        let pixels = (0..before.pixels.len()).into_par_iter().map(pixel).collect();
        Picture { size: self.size, pixels }
    }
}

/// Writes a part of a row of the light of one channel that a zone spreads; returns whether any of it is
/// not 0.
pub(super) fn fill_row<T: From<f32>>(
    picture: &Picture,
    grid: GridNode,
    channel: usize,
    (columns, y): (Range<usize>, usize),
    row: &mut [T],
) -> bool {
    let width = picture.size[0];
    let mut some = false;
    for (value, x) in row.iter_mut().zip(columns) {
        let light = picture.pixels[y * width + x][channel];
        if light.is_finite() && light != 0.0 {
            let share = light * grid.weight([x, y], picture.size) as f32;
            *value = share.into();
            some |= share != 0.0;
        }
    }
    some
}
