//! Diffraction: light that bends at the stop, as a stage of its own after the film is exposed. It
//! is not run where it is not planned.
//!
//! # What is spread by what
//!
//! Rays carry what the lens's aberrations and its focus do to the light of a point. What they
//! leave out is that the pupil is bounded: so the picture is convolved with the spread of the
//! pupil's shape with a flat wavefront ([`ExitPupil::density`](crate::lens::ExitPupil::density)),
//! else blur would count twice. Both together are the spread of the aberrated wavefront where the
//! wavefront is good, below Marechal's limit of 1/14 of a wave rms
//! ([`Wavefront`](crate::lens::Wavefront) tells), and where it is so bad that rays tell all; in
//! between the convolution is somewhat too wide.
//!
//! The pupil is the real one: traced, with blades, masks, obstructions and vignetting, by field
//! zone. Each zone spreads the light of its own part of the film, and parts blend linearly.
//!
//! # Light
//!
//! Each channel is spread as daylight in its own wavelengths, or as what a film sees in its passband.
//! A white scene stays white.
//!
//! What leaves the film is lost, and light from beyond its edge is not known. A pixel is taken to
//! get from there as much as it would if its surroundings went on as they are inside: it is
//! divided by the share of its spread that lies inside. So an even picture stays even to its very
//! edge; but rays from a lamp just outside a crop are missing. Layers are not spread.
//!
//! # Time and memory
//!
//! Some 200 bytes a pixel, and 15 MB for the table of a zone's spread. On one core about 0.35 s a zone
//! for the table, and 0.9 us a pixel and zone.

mod fourier;
mod kernel;
mod spread;
mod zone;

use rayon::prelude::*;

use crate::film::Frame;
use crate::image::Picture;
use crate::lens::{Camera, Model};
use crate::spectrum::LightBand;
use fourier::{Complex, Plane, Spectrum};
use kernel::Kernel;
use zone::{Zone, zones};

pub use spread::Spread;

/// How far light is spread at most, pixels: larger pictures than this would take memory as the
/// square of it.
const REACH: usize = 4096;

/// Bytes of the table of a zone's spread.
const TABLE: usize = 15_000_000;

/// Bytes that glibc takes from its heap at most; what is larger goes back to the system at once.
const IN_HEAP: usize = 1 << 25;

/// How far light is spread, pixels, in a picture so wide or high.
fn reach(size: usize) -> usize {
    size.saturating_sub(1).min(REACH)
}

/// What the pupil of a camera does to a picture.
#[derive(Clone, Debug)]
pub struct Diffraction {
    zones: Vec<Zone>,
    light: Vec<LightBand>,
    /// Width and height of a pixel, um.
    pitch: [f64; 2],
}

impl Diffraction {
    /// Traces the pupils of a camera over the part of the picture that is rendered. A camera
    /// without a real lens, or a film without light, spreads nothing. The bands of the light are of
    /// the same width, one after another.
    pub fn new(camera: &Camera, frame: &Frame, light: &[LightBand]) -> Self {
        let zones = match &camera.model {
            Model::Real(lens) => zones(lens, camera.film, frame),
            Model::Thin(_) => Vec::new(),
        };
        let pitch = [0, 1].map(|i| 1e3 * camera.film[i] / f64::from(frame.resolution[i]));
        Self { zones, light: light.to_vec(), pitch }
    }

    /// Bytes that [`Diffraction::spread`] takes at most beside the picture that it is given, of this
    /// width and height.
    pub fn bytes(size: [usize; 2]) -> u64 {
        let reach = size.map(reach);
        let plane = Plane::new([size[0] + reach[0], size[1] + reach[1]]).size;
        let spectrum = (plane[0] / 2 + 1) * plane[1] * size_of::<Complex<f64>>();
        let kernel = (2 * reach[0] + 1) * (reach[1] + 1) * size_of::<[f32; 3]>();
        let pixels = size[0] * size[1] * size_of::<[f32; 3]>();
        let sums = (2 * reach[0] + 2) * (reach[1] + 2) * size_of::<f64>();
        // What was received by channel, a channel's light, its shares and the lines that they are made
        // of; the shares inside, those of a channel before they are added, and the picture that
        // comes of it. The kernel's sums are gone by then, but small ones stay in the heap.
        (TABLE + 6 * spectrum + kernel + 3 * pixels + sums.min(IN_HEAP)) as u64
    }

    /// How many zones of the picture have a spread of their own.
    pub fn zones(&self) -> usize {
        self.zones.len()
    }

    /// The picture as diffraction spreads it: a stage. What is no finite number counts as dark.
    /// The same for any number of threads.
    pub fn spread(&self, picture: &Picture) -> Picture {
        let size = picture.size;
        if self.zones.is_empty() || picture.pixels.is_empty() {
            return picture.clone();
        }
        let reach = size.map(reach);
        let plane = Plane::new([size[0] + reach[0], size[1] + reach[1]]);
        let mut received = [const { Spectrum::new() }; 3];
        let mut inside = [const { Vec::<f32>::new() }; 3];
        for zone in &self.zones {
            let far = (reach[0] as f64 * self.pitch[0]).hypot(reach[1] as f64 * self.pitch[1]);
            let spread =
                Spread::new(&zone.pupil, &self.light, far, self.pitch[0].min(self.pitch[1]));
            let kernel = Kernel::new(&spread, self.pitch, reach);
            drop(spread);
            for channel in 0..3 {
                let shares = kernel.inside(channel, size);
                add(&mut inside[channel], shares, |i| {
                    zone.weight([i % size[0], i / size[0]], size) as f32
                });
                let mut light = plane.spectrum(|y, row| part(picture, zone, channel, y, row));
                let shares = plane.spectrum(|y, row| kernel.wrapped(channel, y, plane.size, row));
                light.par_iter_mut().zip(&shares).for_each(|(light, share)| *light *= share);
                drop(shares);
                add(&mut received[channel], light, |_| 1.0);
            }
        }
        let mut pixels = vec![[0.0; 3]; picture.pixels.len()];
        for (channel, spectrum) in received.into_iter().enumerate() {
            // Below the darkest there is rounding only; a signed filter may go below 0.
            let values = picture.pixels.iter().map(|pixel| pixel[channel]);
            let least = values.filter(|v| v.is_finite()).fold(0.0, f32::min);
            plane.rows(spectrum, &mut pixels, size[0], |row, pixels| {
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

/// The first zone's numbers, and those of others times a factor.
fn add<T, F>(sum: &mut Vec<T>, mut part: Vec<T>, factor: impl Fn(usize) -> F + Sync)
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

/// A row of what a zone spreads of a channel; false where there is nothing.
fn part(picture: &Picture, zone: &Zone, channel: usize, y: usize, row: &mut [f64]) -> bool {
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
