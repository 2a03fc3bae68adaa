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
//! Up to 64 pixels light is spread by each of the zones, whose planes hold its part of the picture
//! alone. Beyond, where little light goes and the spread changes slowly over the picture, nine zones at
//! most spread it over the whole picture. Between half of that distance and the whole one kernel goes over
//! into the other. Pupils that are affine images of one another share a table.
//!
//! # Time and memory
//!
//! Some 200 bytes per pixel, and 46 MB while a table is made, one after the other. On one core 0.3 s for
//! each table of far light, and 3 to 5 us per pixel for all zones together.

mod aberrated_core;
mod band_integral;
mod far_spread;
mod field_zone;
mod fourier;
mod half_kernel;
mod kernel;
mod kernel_sums;
mod mapped_spread;
mod point_spread;
mod pupil_transform;
mod received;

use rayon::prelude::*;

use crate::film::Frame;
use aberrated_core::AberratedCore;
use far_spread::FarSpread;
use field_zone::{FieldZone, FieldZones, field_zones};
use fourier::{Complex, PlaneFft};
use half_kernel::{Boundary, HalfKernel};
use kernel::PixelKernel;
use mapped_spread::{MappedSpread, PupilShape};
use petzval_image::Picture;
use petzval_lens::{Camera, LensModel, Pose, Row};
use petzval_spectrum::LightBand;
use received::Received;

pub use point_spread::PointSpread;

/// Largest distance that light is spread (pixels). It bounds the memory, which grows with its
/// square.
const MAX_REACH: usize = 4096;

/// Distance up to which all zones spread light (pixels).
const NEAR: usize = 64;

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
    camera: CameraKey,
    light: Vec<LightBand>,
    /// Width and height of a pixel (um).
    pitch: [f64; 2],
}

/// Everything that decides the pupils of a picture.
#[derive(Clone, Debug, PartialEq)]
struct CameraKey {
    frame: Frame,
    size: [f64; 2],
    lens: Option<(f64, Pose, Vec<Row>)>,
}

impl CameraKey {
    fn new(camera: &Camera, frame: &Frame) -> Self {
        let lens = match &camera.model {
            LensModel::Real(lens) => {
                Some((lens.film_distance, lens.film_pose, lens.prescription.rows.to_vec()))
            }
            _ => None,
        };
        Self { frame: *frame, size: camera.film, lens }
    }
}

/// Number and size of the parts of the work for a picture, for an estimate of its time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DiffractionWork {
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
        Self { zones, camera: CameraKey::new(camera, frame), light: light.to_vec(), pitch }
    }

    /// Returns the most memory that [`Diffraction::spread`] takes for a picture of this width and
    /// height, besides the picture itself (bytes).
    pub fn bytes(size: [usize; 2]) -> u64 {
        let reach = size.map(reach);
        let plane = PlaneFft::<f32>::new([size[0] + reach[0], size[1] + reach[1]]).size;
        let numbers = (plane[0] / 2 + 1) * plane[1];
        let spectrum = numbers * size_of::<Complex<f32>>();
        let kernel = (2 * reach[0] + 1) * (reach[1] + 1) * size_of::<[f32; 3]>();
        let sums = (2 * reach[0] + 2) * (reach[1] + 2) * size_of::<f64>();
        let pixels = size[0] * size[1] * size_of::<[f32; 3]>();
        // The light received in each of three channels, the light of one channel, and the rows it is made
        // of; the kernel, its sums and its transform. Received light, shares inside and the result are
        // pictures. What zones spread near takes less.
        let far = 5 * spectrum + numbers * size_of::<f32>() + kernel + sums;
        (TABLE_BYTES + far + 3 * pixels) as u64
    }

    /// Returns whether the pupils are those of a camera over the rendered part of the picture.
    pub(crate) fn is_of(&self, camera: &Camera, frame: &Frame) -> bool {
        self.camera == CameraKey::new(camera, frame)
    }

    /// Returns what it takes to spread a picture of this size.
    pub(crate) fn work(&self, size: [usize; 2]) -> DiffractionWork {
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
        let mut received = Received::new(size);
        let mut far = FarSpread::new(size, reach);
        let mut kernels = vec![None; self.zones.near.len()];
        // One table at a time.
        for base in 0..self.zones.bases.len() {
            let is_used = |zone: &FieldZone| zone.shape.base == base;
            if boundary.is_none() && !self.zones.near.iter().any(is_used) {
                continue;
            }
            let spread = self.table(base, reach, boundary);
            let mapped = |shape: &PupilShape| MappedSpread::new(&spread, shape);
            if let Some(boundary) = boundary {
                for (shape, grid) in self.zones.far.iter().filter(|(shape, _)| shape.base == base) {
                    let spread = mapped(shape);
                    let part = |distance| 1.0 - boundary.near(distance);
                    let kernel = HalfKernel::new(&spread, part, self.pitch, reach);
                    let beyond = spread.outside(self.extent(reach));
                    far.add(picture, &kernel, *grid, beyond, &mut received);
                }
            }
            let near = kernels.par_iter_mut().zip(&self.zones.near);
            near.filter(|(_, zone)| is_used(zone)).for_each(|(kernel, zone)| {
                *kernel = Some(self.near_kernel(zone, &mapped(&zone.shape), reach, boundary));
            });
        }
        let mut kernels: Vec<PixelKernel> = kernels.into_iter().flatten().collect();
        if boundary.is_some() {
            far.finish(&mut received);
            for (kernel, zone) in kernels.iter_mut().zip(&self.zones.near) {
                kernel.normalize(far.share_at(zone.grid.place()).map(|share| 1.0 - share));
            }
        }
        received.add_near(picture, &self.zones.near, &kernels);
        received.picture(picture)
    }

    /// Makes the table of the point spread of a pupil.
    fn table(&self, base: usize, reach: [usize; 2], boundary: Option<Boundary>) -> PointSpread {
        let reach = match boundary {
            Some(Boundary(near)) if base >= self.zones.far_bases => [near; 2],
            _ => reach,
        };
        let [width, height] = [0, 1].map(|i| reach[i] as f64 * self.pitch[i]);
        let detail = self.pitch[0].min(self.pitch[1]);
        PointSpread::new(&self.zones.bases[base], &self.light, width.hypot(height), detail)
    }

    /// Returns half the width and the height of a kernel of this reach (um).
    fn extent(&self, reach: [usize; 2]) -> [f64; 2] {
        [0, 1].map(|i| (reach[i] as f64 + 0.5) * self.pitch[i])
    }

    /// Makes the kernel of the light that a zone spreads near; without a boundary, of all its light.
    fn near_kernel(
        &self,
        zone: &FieldZone,
        spread: &MappedSpread,
        reach: [usize; 2],
        boundary: Option<Boundary>,
    ) -> PixelKernel {
        let near = boundary.map_or(reach, |Boundary(near)| reach.map(|reach| reach.min(near)));
        let core = zone.wavefront.as_ref().and_then(|wavefront| {
            AberratedCore::new(&zone.pupil, wavefront, &self.light, self.pitch)
        });
        let reach = core
            .as_ref()
            .map_or(near, |core| [0, 1].map(|i| near[i].max(core.reach[i]).min(reach[i])));
        let part = |distance| boundary.map_or(1.0, |boundary| boundary.near(distance));
        let mut kernel = PixelKernel::new(HalfKernel::new(spread, part, self.pitch, reach), core);
        if boundary.is_none() {
            kernel.normalize(spread.outside(self.extent(reach)).map(|share| 1.0 - share));
        }
        kernel
    }
}
