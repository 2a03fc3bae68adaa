//! Way of light paths from the plane of the front vertex through the lens to the pixels.

use glam::DVec3;

use super::wave::LightPaths;
use crate::light_tracing::entry::EntrySquare;
use petzval_base::lanes::Real;
use petzval_lens::{
    Band, LensRay, RealLens, Side, Surface, retrace_in_f64, retrace_in_f64_lossy, trace,
    trace_lossy,
};
use petzval_spectrum::bands_of_ray;

/// A lens as light paths enter it: through a square in the plane of its front vertex.
#[derive(Clone, Debug)]
pub(crate) struct FrontEntry {
    /// The square that holds the entry points.
    pub square: EntrySquare,
    /// Distance before the front vertex at which rays enter the lens (mm).
    start: f64,
    /// Surfaces from there to the film, by band.
    bands: Vec<FrontBand>,
}

/// Surfaces of a lens for light paths of one band.
#[derive(Clone, Debug)]
struct FrontBand {
    surfaces: Vec<Surface<f32>>,
    surfaces_f64: Vec<Surface<f64>>,
}

impl FrontEntry {
    /// Prepares the entry through a square.
    pub fn new(lens: &RealLens, square: EntrySquare) -> Self {
        let start = 2.0 * lens.prescription.rows[0].diameter.max(square.half);
        let of_band = |band: &Band| FrontBand {
            surfaces: band.sequence::<f32>(&lens.prescription, Side::Scene(start)),
            surfaces_f64: band.sequence::<f64>(&lens.prescription, Side::Scene(start)),
        };
        Self { square, start, bands: lens.bands.iter().map(of_band).collect() }
    }

    /// Returns the largest number of bands that share a path.
    pub fn bands_per_path(lens: &RealLens) -> u64 {
        (bands_of_ray(0, lens.bands.len()).len() as u64).max(1)
    }

    /// Returns the start of the ray (mm, the frame of the first surface) that passes an entry point
    /// (mm) and comes from a direction, a unit vector to the scene in the frame of the camera.
    pub fn start(&self, [x, y]: [f64; 2], towards: DVec3) -> [f64; 3] {
        let back = self.start / towards.z;
        [x + towards.x * back, y + towards.y * back, 0.0]
    }

    /// Traces a wave from the scene to the film, in one band.
    pub fn trace<R: Real<Scalar = f32>>(
        &self,
        lens: &RealLens,
        band: usize,
        paths: &mut LightPaths,
    ) {
        let FrontBand { surfaces, surfaces_f64 } = &self.bands[band];
        paths.trace_with::<R>(lens, |batch, starts, blocked| {
            let start = |i: usize| LensRay {
                p: [starts.x[i], starts.y[i], starts.z[i]].map(f64::from),
                t: [starts.tx[i], starts.ty[i], starts.tz[i]].map(f64::from),
                weight: 1.0,
            };
            match lens.fresnel {
                false => {
                    trace::<R>(batch, surfaces, blocked);
                    retrace_in_f64::<R>(batch, surfaces_f64, blocked, start);
                }
                true => {
                    trace_lossy::<R>(batch, surfaces, blocked);
                    retrace_in_f64_lossy::<R>(batch, surfaces_f64, blocked, start);
                }
            }
        });
    }
}
