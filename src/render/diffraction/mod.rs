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
//! # Time and memory
//!
//! Some 200 bytes per pixel, and 15 MB for the table of a zone's spread. On one core about 0.35 s
//! per zone for the table, and 0.9 us per pixel and zone.

mod aberrated_core;
mod band_integral;
mod field_zone;
mod fourier;
mod kernel;
mod point_spread;
mod pupil_transform;

use rayon::prelude::*;

use crate::film::Frame;
use aberrated_core::AberratedCore;
use field_zone::{FieldZone, field_zones};
use fourier::{Complex, PlaneFft, PlaneSpectrum};
use kernel::PixelKernel;
use petzval_image::Picture;
use petzval_lens::{Camera, LensModel};
use petzval_spectrum::LightBand;

pub use point_spread::PointSpread;

/// Largest distance that light is spread (pixels). It bounds the memory, which grows with its
/// square.
const MAX_REACH: usize = 4096;

/// Size of the table of a zone's spread (bytes).
const TABLE_BYTES: usize = 15_000_000;

/// Largest allocation that glibc takes from its heap (bytes); larger ones return to the system when
/// freed.
const MAX_HEAP_ALLOCATION: usize = 1 << 25;

/// Returns how far light is spread in a picture of this width or height (pixels).
fn reach(size: usize) -> usize {
    size.saturating_sub(1).min(MAX_REACH)
}

/// The point spreads of a camera's pupil over a picture.
#[derive(Clone, Debug)]
pub struct Diffraction {
    zones: Vec<FieldZone>,
    light: Vec<LightBand>,
    /// Width and height of a pixel (um).
    pitch: [f64; 2],
}

impl Diffraction {
    /// Traces the pupils of a camera over the rendered part of the picture.
    ///
    /// Without a real lens, or if the film is dark, there are no zones and nothing is spread. The
    /// bands of the light have equal widths and are contiguous.
    pub fn new(camera: &Camera, frame: &Frame, light: &[LightBand]) -> Self {
        let zones = match &camera.model {
            LensModel::Real(lens) => field_zones(lens, camera.film, frame),
            _ => Vec::new(),
        };
        let pitch = [0, 1].map(|i| 1e3 * camera.film[i] / f64::from(frame.resolution[i]));
        Self { zones, light: light.to_vec(), pitch }
    }

    /// Returns the most memory that [`Diffraction::spread`] takes for a picture of this width and
    /// height, besides the picture itself (bytes).
    pub fn bytes(size: [usize; 2]) -> u64 {
        let reach = size.map(reach);
        let plane = PlaneFft::new([size[0] + reach[0], size[1] + reach[1]]).size;
        let spectrum = (plane[0] / 2 + 1) * plane[1] * size_of::<Complex<f64>>();
        let kernel = (2 * reach[0] + 1) * (reach[1] + 1) * size_of::<[f32; 3]>();
        let pixels = size[0] * size[1] * size_of::<[f32; 3]>();
        let sums = (2 * reach[0] + 2) * (reach[1] + 2) * size_of::<f64>();
        // The six spectra: the light received in each of three channels, the light of one channel,
        // its kernel, and the lines these are made of. The three pictures: the shares inside, those
        // of one channel before they are added, and the result. The kernel's sums are freed by
        // then, but small ones stay in the heap.
        (TABLE_BYTES + 6 * spectrum + kernel + 3 * pixels + sums.min(MAX_HEAP_ALLOCATION)) as u64
    }

    /// Returns the number of field zones.
    pub fn zones(&self) -> usize {
        self.zones.len()
    }

    /// Returns the picture spread by diffraction: a stage. Values that are not finite count as
    /// dark. The result does not depend on the number of threads.
    pub fn spread(&self, picture: &Picture) -> Picture {
        let size = picture.size;
        if self.zones.is_empty() || picture.pixels.is_empty() {
            return picture.clone();
        }
        let reach = size.map(reach);
        let plane = PlaneFft::new([size[0] + reach[0], size[1] + reach[1]]);
        let mut received = [const { PlaneSpectrum::new() }; 3];
        let mut inside = [const { Vec::<f32>::new() }; 3];
        for zone in &self.zones {
            let core = zone.wavefront.as_ref().and_then(|wavefront| {
                AberratedCore::new(&zone.pupil, wavefront, &self.light, self.pitch)
            });
            let far = (reach[0] as f64 * self.pitch[0]).hypot(reach[1] as f64 * self.pitch[1]);
            let spread =
                PointSpread::new(&zone.pupil, &self.light, far, self.pitch[0].min(self.pitch[1]));
            let kernel = PixelKernel::new(&spread, core, self.pitch, reach);
            drop(spread);
            for channel in 0..3 {
                let shares = kernel.shares_inside(channel, size);
                accumulate(&mut inside[channel], shares, |i| {
                    zone.weight([i % size[0], i / size[0]], size) as f32
                });
                let mut light =
                    plane.spectrum(|y, row| fill_zone_row(picture, zone, channel, y, row));
                let shares =
                    plane.spectrum(|y, row| kernel.write_wrapped_row(channel, y, plane.size, row));
                light.par_iter_mut().zip(&shares).for_each(|(light, share)| *light *= share);
                drop(shares);
                accumulate(&mut received[channel], light, |_| 1.0);
            }
        }
        let mut pixels = vec![[0.0; 3]; picture.pixels.len()];
        for (channel, spectrum) in received.into_iter().enumerate() {
            // Values below the darkest input are rounding errors. The input may be negative after a
            // signed filter.
            let values = picture.pixels.iter().map(|pixel| pixel[channel]);
            let least = values.filter(|v| v.is_finite()).fold(0.0, f32::min);
            plane.inverse_rows(spectrum, &mut pixels, size[0], |row, pixels| {
                for (pixel, &value) in pixels.iter_mut().zip(row) {
                    pixel[channel] = value as f32;
                }
            });
            for (pixel, inside) in pixels.iter_mut().zip(&inside[channel]) {
                pixel[channel] = (pixel[channel] / inside).max(least);
            }
        }
        Picture { size, pixels }
    }
}

/// Adds `part` times a factor to `sum`, which is empty before the first zone.
fn accumulate<T, F>(sum: &mut Vec<T>, mut part: Vec<T>, factor: impl Fn(usize) -> F + Sync)
where
    T: Copy + Send + Sync + std::ops::AddAssign + std::ops::MulAssign<F>,
{
    part.par_iter_mut().enumerate().for_each(|(i, part)| *part *= factor(i));
    if sum.is_empty() {
        *sum = part;
        return;
    }
    sum.par_iter_mut().zip(&part).for_each(|(sum, &part)| *sum += part);
}

/// Writes a row of the light of one channel that a zone spreads; returns whether any of it is not
/// 0.
fn fill_zone_row(
    picture: &Picture,
    zone: &FieldZone,
    channel: usize,
    y: usize,
    row: &mut [f64],
) -> bool {
    let [width, height] = picture.size;
    if y >= height {
        return false;
    }
    let mut some = false;
    for (x, value) in row[..width].iter_mut().enumerate() {
        let light = picture.pixels[y * width + x][channel];
        if light.is_finite() && light != 0.0 {
            *value = f64::from(light) * zone.weight([x, y], picture.size);
            some |= *value != 0.0;
        }
    }
    some
}
