//! Diffraction at the stop: an optional stage after the film is exposed.
//!
//! # Model
//!
//! Rays carry the effects of aberrations and defocus on the light of a point. They omit that the
//! pupil is bounded. Therefore the picture is convolved with the point spread of the pupil's shape
//! with a flat wavefront ([`ExitPupil::density`](petzval_lens::ExitPupil::density)); an aberrated
//! wavefront would count blur twice. Both together give the point spread of the aberrated wavefront
//! where the wavefront is good, below Marechal's limit of 1/14 of a wave rms (see
//! [`Wavefront`](petzval_lens::Wavefront)), and where it is so bad that geometrical optics suffices.
//! In between the convolution would be too wide, and the core of the kernel is the quotient of the
//! traced wavefront's transfer function by that of the rays (`aberrated_core`). It is exact in the
//! plane of focus.
//!
//! The pupil is the real one, traced with blades, masks, obstructions and vignetting, by field
//! zone. Each zone spreads the light of its own part of the film, and neighbouring zones blend
//! linearly.
//!
//! # Light
//!
//! Each channel is spread as daylight in its own wavelengths, or as what a film sees in its
//! passband. A white scene stays white.
//!
//! Light that leaves the film is lost, and light from beyond its edge is unknown. It is estimated
//! by extending the surroundings of each pixel: the pixel is divided by the share of its spread
//! that lies inside the picture. A uniform picture stays uniform up to its edge, but the
//! diffraction spikes of a light just outside a crop are missing. AOV layers are not spread.
//!
//! # Near and far
//!
//! Up to [`NEAR`] pixels light is spread by each of the zones, whose planes hold its part of the picture
//! alone. Beyond, where little light goes and the spread changes slowly over the picture, nine zones at
//! most spread it over the whole picture. Between half of that distance and the whole one kernel goes over
//! into the other. Pupils that are affine images of one another share a table.
//!
//! # Time and memory
//!
//! Some 180 bytes per pixel, and 46 MB for a table. On one core 0.3 s for each table, and 1.5 us per pixel
//! for all zones together.

mod aberrated_core;
mod band_integral;
mod far_kernel;
mod field_zone;
mod fourier;
mod kernel;
mod kernel_sums;
mod mapped_spread;
mod point_spread;
mod pupil_transform;

use rayon::prelude::*;

use crate::film::Frame;
use aberrated_core::AberratedCore;
use far_kernel::{Boundary, FarKernel};
use field_zone::{FieldZone, FieldZones, GridNode, field_zones};
use fourier::{Complex, PlaneFft, PlaneSpectrum};
use kernel::PixelKernel;
use kernel_sums::KernelSums;
use mapped_spread::{MappedSpread, PupilShape};
use petzval_image::Picture;
use petzval_lens::{Camera, LensModel};
use petzval_spectrum::LightBand;

pub use point_spread::PointSpread;

/// Largest distance that light is spread (pixels). It bounds the memory, which grows with its
/// square.
const MAX_REACH: usize = 4096;

/// Distance up to which all zones spread light (pixels).
const NEAR: usize = 64;

/// Distance of the pixels for which the share of far light inside the picture is computed (pixels).
const SHARE_STEP: usize = 16;

/// Size of a table of spread, while it is made (bytes).
const TABLE_BYTES: usize = 46_000_000;

/// Returns how far light is spread in a picture of this width or height (pixels).
fn reach(size: usize) -> usize {
    size.saturating_sub(1).min(MAX_REACH)
}

/// The point spreads of a camera's pupil over a picture.
#[derive(Clone, Debug)]
pub struct Diffraction {
    zones: FieldZones,
    frame: Frame,
    light: Vec<LightBand>,
    /// Width and height of a pixel (um).
    pitch: [f64; 2],
}

/// Light that pixels receive, and the share of the spread of each pixel that lies inside the picture, by
/// channel.
struct Received {
    size: [usize; 2],
    light: [Vec<f32>; 3],
    inside: [Vec<f32>; 3],
}

/// What it takes to spread a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiffractionWork {
    /// Zones of light that is spread near.
    pub zones: usize,
    /// Tables of point spreads of light that is spread far.
    pub far_tables: usize,
    /// Tables of point spreads of light that is only spread near.
    pub near_tables: usize,
    /// Pixels of the planes of all near zones together.
    pub near: f64,
    /// Pixels of the planes of all far zones together.
    pub far: f64,
}

impl Diffraction {
    /// Traces the pupils of a camera over the rendered part of the picture.
    ///
    /// Without a real lens, or if the film is dark, there are no zones and nothing is spread. The
    /// bands of the light have equal widths and are contiguous.
    pub fn new(camera: &Camera, frame: &Frame, light: &[LightBand]) -> Self {
        let zones = match &camera.model {
            LensModel::Real(lens) => field_zones(lens, camera.film, frame),
            _ => FieldZones::default(),
        };
        let pitch = [0, 1].map(|i| 1e3 * camera.film[i] / f64::from(frame.resolution[i]));
        Self { zones, frame: *frame, light: light.to_vec(), pitch }
    }

    /// Returns the most memory that [`Diffraction::spread`] takes for a picture of this width and
    /// height, besides the picture itself (bytes).
    pub fn bytes(size: [usize; 2]) -> u64 {
        let reach = size.map(reach);
        let plane = PlaneFft::<f32>::new([size[0] + reach[0], size[1] + reach[1]]).size;
        let numbers = (plane[0] / 2 + 1) * plane[1];
        let spectrum = numbers * size_of::<Complex<f32>>();
        let kernel = (2 * reach[0] + 1) * (reach[1] + 1) * size_of::<[f32; 3]>();
        let pixels = size[0] * size[1] * size_of::<[f32; 3]>();
        // The light received in each of three channels, the light of one channel, and the rows it is made
        // of; the kernel and its transform. Received light, shares inside and the result are pictures.
        let far = 5 * spectrum + numbers * size_of::<f32>() + kernel;
        (TABLE_BYTES + far + 3 * pixels) as u64
    }

    /// Returns the part of the picture for which the pupils were traced.
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// Returns what it takes to spread a picture of this size.
    pub fn work(&self, size: [usize; 2]) -> DiffractionWork {
        let FieldZones { near, far, bases, far_bases } = &self.zones;
        let pixels = |reach: usize, zone: &FieldZone| {
            let sides = [0, 1].map(|i| zone.grid.pixels(i, size[i]).len() + 2 * reach);
            (sides[0] * sides[1]) as f64
        };
        let reach = size.map(reach);
        let whole = ((size[0] + reach[0]) * (size[1] + reach[1])) as f64;
        let is_small = reach[0].max(reach[1]) <= NEAR;
        DiffractionWork {
            zones: near.len(),
            far_tables: *far_bases,
            near_tables: bases.len() - far_bases,
            near: near.iter().map(|zone| pixels(NEAR.min(reach[0].max(reach[1])), zone)).sum(),
            far: if is_small { 0.0 } else { far.len() as f64 * whole },
        }
    }

    /// Returns the number of field zones.
    pub fn zones(&self) -> usize {
        self.zones.near.len()
    }

    /// Returns the picture spread by diffraction: a stage. Values that are not finite count as
    /// dark. The result does not depend on the number of threads.
    pub fn spread(&self, picture: &Picture) -> Picture {
        let size = picture.size;
        if self.zones.near.is_empty() || picture.pixels.is_empty() {
            return picture.clone();
        }
        let reach = size.map(reach);
        let boundary = (reach[0].max(reach[1]) > NEAR).then_some(Boundary(NEAR));
        let spreads = self.tables(reach, boundary);
        let mapped = |shape: &PupilShape| MappedSpread::new(&spreads[shape.base], shape);
        let mut received = Received::new(size);
        let mut beyond = Vec::new();
        if let Some(boundary) = boundary {
            let plane = PlaneFft::new([size[0] + reach[0], size[1] + reach[1]]);
            let mut sums = [const { PlaneSpectrum::new() }; 3];
            for (shape, grid) in &self.zones.far {
                let spread = mapped(shape);
                let kernel = FarKernel::new(&spread, boundary, self.pitch, reach);
                let extent = [0, 1].map(|i| (reach[i] as f64 + 0.5) * self.pitch[i]);
                let mut share = spread.outside(extent);
                for channel in 0..3 {
                    let shares = KernelSums::new(reach, &kernel.half, channel);
                    share[channel] += shares.whole();
                    received.add_far_shares(channel, &shares, *grid);
                    spread_far(picture, &kernel, channel, *grid, &plane, &mut sums[channel]);
                }
                beyond.push((*grid, share));
            }
            for (channel, spectrum) in sums.into_iter().enumerate() {
                received.add_spectrum(channel, &plane, spectrum);
            }
        }
        let near_reach = match boundary {
            Some(Boundary(near)) => reach.map(|reach| reach.min(near)),
            None => reach,
        };
        let extent = [0, 1].map(|i| (near_reach[i] as f64 + 0.5) * self.pitch[i]);
        let kernel = |zone: &FieldZone| {
            let spread = mapped(&zone.shape);
            let elsewhere = match boundary {
                None => spread.outside(extent),
                // What far zones spread beyond, at the node of this one.
                Some(_) => beyond.iter().fold([0.0; 3], |sum, (grid, share)| {
                    let weight = grid.weight_at(zone.grid.place());
                    [0, 1, 2].map(|c| sum[c] + weight * share[c])
                }),
            };
            let core = zone.wavefront.as_ref().and_then(|wavefront| {
                AberratedCore::new(&zone.pupil, wavefront, &self.light, self.pitch)
            });
            let reach = core.as_ref().map_or(near_reach, |core| {
                [0, 1].map(|i| near_reach[i].max(core.reach[i]).min(reach[i]))
            });
            let whole = elsewhere.map(|share| 1.0 - share);
            PixelKernel::new(&spread, core, boundary, self.pitch, reach, whole)
        };
        let kernels: Vec<PixelKernel> = self.zones.near.par_iter().map(kernel).collect();
        drop(spreads);
        received.add_near(picture, &self.zones.near, &kernels);
        received.picture(picture)
    }

    /// Makes the tables of the point spreads.
    fn tables(&self, reach: [usize; 2], boundary: Option<Boundary>) -> Vec<PointSpread> {
        let far = (reach[0] as f64 * self.pitch[0]).hypot(reach[1] as f64 * self.pitch[1]);
        let detail = self.pitch[0].min(self.pitch[1]);
        let zones = &self.zones;
        let table = |(i, pupil)| {
            let reach = match boundary {
                Some(Boundary(near)) if i >= zones.far_bases => {
                    near as f64 * self.pitch[0].hypot(self.pitch[1])
                }
                _ => far,
            };
            PointSpread::new(pupil, &self.light, reach, detail)
        };
        zones.bases.iter().enumerate().map(table).collect()
    }
}

impl Received {
    fn new(size: [usize; 2]) -> Self {
        let plane = || vec![0.0; size[0] * size[1]];
        Self {
            size,
            light: std::array::from_fn(|_| plane()),
            inside: std::array::from_fn(|_| plane()),
        }
    }

    /// Adds the shares inside of the light that a zone spreads far: linear between pixels of a grid.
    fn add_far_shares(&mut self, channel: usize, shares: &KernelSums, grid: GridNode) {
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
    fn add_spectrum(
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
    fn add_near(&mut self, picture: &Picture, zones: &[FieldZone], kernels: &[PixelKernel]) {
        let size = self.size;
        let span = |zone: &FieldZone| [0, 1].map(|axis| zone.grid.pixels(axis, size[axis]));
        let least = zones.iter().zip(kernels).fold([1; 2], |least, (zone, kernel)| {
            let span = span(zone);
            [0, 1].map(|i| least[i].max(span[i].len() + 2 * kernel.reach[i]))
        });
        let plane = PlaneFft::<f64>::new(least);
        for (zone, kernel) in zones.iter().zip(kernels) {
            let [columns, rows] = span(zone);
            let reach = kernel.reach;
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
    fn picture(&self, before: &Picture) -> Picture {
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

/// Adds the transform of the light that a zone spreads far to a sum, which is empty before the first
/// zone.
fn spread_far(
    picture: &Picture,
    kernel: &FarKernel,
    channel: usize,
    grid: GridNode,
    plane: &PlaneFft<f32>,
    sum: &mut PlaneSpectrum<f32>,
) {
    let [width, height] = picture.size;
    let light =
        plane.spectrum(height, |y, row| fill_row(picture, grid, channel, (0..width, y), row));
    let shares = plane.symmetric_spectrum(kernel.reach[1] + 1, |y, row| {
        kernel.write_row(channel, y, row);
        true
    });
    if sum.is_empty() {
        sum.resize(light.len(), Complex::default());
    }
    let parts = sum.par_iter_mut().zip(&light).zip(&shares);
    parts.for_each(|((sum, light), share)| *sum += light * share);
}

/// Writes a part of a row of the light of one channel that a zone spreads; returns whether any of it is
/// not 0.
fn fill_row<T: From<f32>>(
    picture: &Picture,
    grid: GridNode,
    channel: usize,
    (columns, y): (std::ops::Range<usize>, usize),
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
