//! Way of light paths from the plane of the front vertex through the lens to the pixels.

use glam::{DVec3, Vec3};

use super::LightPathInput;
use super::splat::{PathCount, Splat, film_pixels};
use super::wave::{FilmHit, LightPaths};
use crate::film::PixelFilter;
use crate::lanes::Real;
use crate::lens::{
    LensRay, RealLens, Side, Surface, retrace_in_f64, retrace_in_f64_lossy, sequence, trace,
    trace_lossy,
};
use crate::scene::luminance;

/// A lens as light paths enter it: through a square in the plane of its front vertex.
#[derive(Clone, Debug)]
pub(crate) struct FrontEntry {
    /// Half side of the square about the front vertex that holds the entry points (mm).
    pub half: f64,
    /// Distance before the front vertex at which rays enter the lens (mm).
    start: f64,
    /// Surfaces from there to the film.
    surfaces: Vec<Surface<f32>>,
    surfaces_f64: Vec<Surface<f64>>,
}

impl FrontEntry {
    /// Prepares the entry through a square of this half side (mm).
    pub fn new(lens: &RealLens, half: f64) -> Self {
        let start = 2.0 * lens.prescription.rows[0].diameter.max(half);
        Self {
            half,
            start,
            surfaces: sequence::<f32>(&lens.prescription, Side::Scene(start)),
            surfaces_f64: sequence::<f64>(&lens.prescription, Side::Scene(start)),
        }
    }

    /// Returns the world position of an entry point (mm in the plane of the front vertex).
    pub fn world_point(input: &LightPathInput<'_>, lens: &RealLens, [x, y]: [f64; 2]) -> Vec3 {
        let [right, up] = [x, y].map(|v| v * lens.units_per_mm);
        let place = DVec3::new(right, up, lens.front_depth);
        input.camera.world_from_camera.transform_point3(place).as_vec3()
    }

    /// Returns the start of the ray (mm, the frame of the first surface) that passes an entry point
    /// (mm) and comes from a direction, a unit vector to the scene in the frame of the camera.
    pub fn start(&self, [x, y]: [f64; 2], towards: DVec3) -> [f64; 3] {
        let back = self.start / towards.z;
        [x + towards.x * back, y + towards.y * back, 0.0]
    }

    /// Traces a wave from the scene to the film.
    pub fn trace<R: Real<Scalar = f32>>(
        &self,
        lens: &RealLens,
        paths: &mut LightPaths,
        blocked: &mut Vec<u64>,
    ) {
        blocked.clear();
        blocked.resize(lens.prescription.rows.len(), 0);
        paths.trace_with::<R>(lens, |batch, starts| {
            let start = |i: usize| LensRay {
                p: [starts.x[i], starts.y[i], starts.z[i]].map(f64::from),
                t: [starts.tx[i], starts.ty[i], starts.tz[i]].map(f64::from),
                weight: 1.0,
            };
            match lens.fresnel {
                false => {
                    trace::<R>(batch, &self.surfaces, blocked);
                    retrace_in_f64::<R>(batch, &self.surfaces_f64, blocked, start);
                }
                true => {
                    trace_lossy::<R>(batch, &self.surfaces, blocked);
                    retrace_in_f64_lossy::<R>(batch, &self.surfaces_f64, blocked, start);
                }
            }
        });
    }
}

/// Returns the splats of a traced wave of one sample number, which has `count` paths. `weight`
/// returns the weight of a path by its index and its arrival on the film.
pub(crate) fn splats<R: Real<Scalar = f32>>(
    input: &LightPathInput<'_>,
    count: PathCount,
    paths: &mut LightPaths,
    weight: impl Fn(usize, &FilmHit) -> f64,
) -> Vec<Splat> {
    let frame = input.frame;
    let filter: &PixelFilter = &input.response.filter;
    let margin = filter.margin();
    let near = |at: [f64; 2]| {
        (0..2).all(|i| {
            at[i] > f64::from(frame.low[i]) - margin[i]
                && at[i] < f64::from(frame.high[i]) + margin[i]
        })
    };
    let arrivals: Vec<(usize, FilmHit, [f64; 2])> = (0..paths.len())
        .filter_map(|i| paths.film_hit(i).map(|hit| (i, hit)))
        .map(|(i, hit)| (i, hit, film_pixels(input, hit.point)))
        .filter(|(.., at)| near(*at))
        .collect();
    paths.connect::<R>(input, arrivals.iter().map(|(i, ..)| *i as u32));
    let scale = count.splat_scale(input);
    let mut splats = Vec::new();
    for (i, hit, at) in arrivals {
        let flux = paths.flux(i);
        if !(luminance(flux) > 0.0 && flux.iter().all(|c| c.is_finite())) {
            continue;
        }
        let factor = hit.transmission * weight(i, &hit) * scale;
        let light = flux.map(|c| f64::from(c) * factor);
        filter.pixels_at(at, |pixel, share| {
            let inside = (0..2).all(|k| {
                pixel[k] >= i64::from(frame.low[k]) && pixel[k] < i64::from(frame.high[k])
            });
            if inside && share != 0.0 {
                let light = light.map(|c| (c * share) as f32);
                splats.push(Splat { pixel: pixel.map(|p| p as u32), light });
            }
        });
    }
    splats
}
