//! Wavefront aberration of a film point.

use super::exit_pupil::ExitPupil;
use crate::camera::RealLens;
use crate::trace::kernel::LensRay;
use crate::trace::path::{PASSES, trace_past_rims};
use crate::trace::sequence::{Side, sequence};
use petzval_base::least_squares::least_squares;

/// Points along each side of the grid over the pupil.
const GRID: usize = 48;
/// Object distance from which a point counts as infinitely far, mm. The wavefront's curvature over
/// a pupil of 10 mm is then 5 nm, and is removed with defocus.
const FAR: f64 = 1e7;

/// A point of the wavefront.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WavefrontPoint {
    /// Position in the pupil: direction times index, as in [`ExitPupil`].
    pub pupil: [f64; 2],
    /// Optical path difference to the best reference sphere, mm.
    pub path_difference: f64,
}

/// The wavefront over the pupil of a film point, relative to its best reference sphere.
///
/// Rays are traced in f64 from the film point. Their optical paths extend to the scene point that
/// is closest to all of them. Piston, tilt and defocus are then removed by least squares (the terms
/// 1, T_x, T_y and T_z), which centres the reference sphere on the best image point.
#[derive(Clone, Debug)]
pub struct Wavefront {
    /// Samples on a regular grid of T.
    pub points: Vec<WavefrontPoint>,
    /// Root mean square of the path differences, mm.
    pub rms: f64,
}

impl Wavefront {
    /// Computes the wavefront of a film point (mm, the film's frame) at the d line. Takes some
    /// milliseconds. `None` if fewer rays pass than a sphere has parameters, or if film or elements
    /// are tilted or decentred.
    pub fn new(lens: &RealLens, film: [f64; 2], pupil: &ExitPupil) -> Option<Self> {
        let (middle, rays) = pupil_rays(lens, film, pupil)?;
        let target = best_image_point(&rays)?;
        let mut points = path_differences(&rays, &target);
        let unit = pupil.width(0.0).max(pupil.width(std::f64::consts::FRAC_PI_2));
        let tz = rays.iter().map(|ray| ray.tz).sum::<f64>() / rays.len() as f64;
        let terms = |ray: &PupilRay| {
            let [x, y] = [0, 1].map(|i| (ray.at[i] - middle[i]) / unit);
            [1.0, x, y, (ray.tz - tz) / (unit * unit)]
        };
        let all: Vec<[f64; 4]> = rays.iter().map(terms).collect();
        let columns = (0..4).map(|k| all.iter().map(|terms| terms[k]).collect()).collect();
        let paths = points.iter().map(|point| point.path_difference).collect();
        let fit = least_squares(columns, vec![paths]).pop()?;
        for (point, terms) in points.iter_mut().zip(&all) {
            point.path_difference -= terms.iter().zip(&fit).map(|(a, b)| a * b).sum::<f64>();
        }
        Self::with_points(points)
    }

    /// Computes the wavefront of the light of a scene point at this distance (mm) before the front
    /// vertex, or infinitely far, that comes to a film point. Piston alone is removed.
    pub fn from_distance(
        lens: &RealLens,
        film: [f64; 2],
        pupil: &ExitPupil,
        distance: f64,
    ) -> Option<Self> {
        let (_, rays) = pupil_rays(lens, film, pupil)?;
        let target = match distance < FAR {
            true => ImagePoint::At(mean(&rays, |LensRay { p, t, .. }| {
                let along = (distance - p[2]) / t[2];
                [p[0] + along * t[0], p[1] + along * t[1], distance]
            })),
            false => {
                let direction = mean(&rays, |ray| ray.t);
                ImagePoint::Towards(direction.map(|d| d / dot(direction, direction).sqrt()))
            }
        };
        Self::with_points(path_differences(&rays, &target))
    }

    fn with_points(points: Vec<WavefrontPoint>) -> Option<Self> {
        let squares: f64 =
            points.iter().map(|point| point.path_difference * point.path_difference).sum();
        let rms = (squares / points.len() as f64).sqrt();
        rms.is_finite().then_some(Self { points, rms })
    }
}

/// Traces rays from a film point over a grid on its pupil; returns its middle and the rays that
/// pass. `None` if there are fewer than eight.
fn pupil_rays(
    lens: &RealLens,
    film: [f64; 2],
    pupil: &ExitPupil,
) -> Option<([f64; 2], Vec<PupilRay>)> {
    if lens.is_misaligned() {
        return None;
    }
    let surfaces = sequence::<f64>(&lens.prescription, Side::Film(lens.film_distance));
    let index = lens.prescription.rear().index;
    let (width, height) = (pupil.width(0.0), pupil.width(std::f64::consts::FRAC_PI_2));
    let middle = pupil.centre();
    let step = |i: usize| (i as f64 + 0.5) / GRID as f64 - 0.5;
    let place = lens.film_pose.film_point(film);
    let mut rays = Vec::new();
    for i in 0..GRID * GRID {
        let at = [middle[0] + width * step(i % GRID), middle[1] + height * step(i / GRID)];
        let tz = (index * index - at[0] * at[0] - at[1] * at[1]).max(0.0).sqrt();
        let start = LensRay::new(place, [at[0], at[1], tz]);
        let path = trace_past_rims::<f64>(start, &surfaces);
        if path.length.is_finite() && path.clipped == PASSES {
            rays.push(PupilRay { at, tz, ray: path.ray, path: path.length });
        }
    }
    (rays.len() >= 8).then_some((middle, rays))
}

/// Returns the path differences of rays from a scene point, relative to their mean. Paths are
/// metres long; without their mean the squares would lose all precision.
fn path_differences(rays: &[PupilRay], target: &ImagePoint) -> Vec<WavefrontPoint> {
    let paths: Vec<f64> = rays.iter().map(|ray| ray.path + target.from(ray)).collect();
    let mean = paths.iter().sum::<f64>() / paths.len() as f64;
    let point = |(ray, path): (&PupilRay, f64)| WavefrontPoint {
        pupil: ray.at,
        path_difference: path - mean,
    };
    rays.iter().zip(paths).map(point).collect()
}

/// Returns the mean of a vector over rays.
fn mean(rays: &[PupilRay], of: impl Fn(&LensRay<f64>) -> [f64; 3]) -> [f64; 3] {
    let sum =
        rays.iter().map(|ray| of(&ray.ray)).fold([0.0; 3], |s, v| [0, 1, 2].map(|i| s[i] + v[i]));
    sum.map(|s| s / rays.len() as f64)
}

/// A ray that left the lens, in the frame of the front vertex.
struct PupilRay {
    at: [f64; 2],
    tz: f64,
    ray: LensRay<f64>,
    path: f64,
}

/// The scene point that is closest to all rays.
enum ImagePoint {
    At([f64; 3]),
    /// A point at infinity in this direction.
    Towards([f64; 3]),
}

impl ImagePoint {
    /// Returns its distance from the point where a ray left the lens; negative if rays diverge from
    /// it.
    fn from(&self, PupilRay { ray: LensRay { p, t, .. }, .. }: &PupilRay) -> f64 {
        match self {
            Self::At(point) => {
                let way = [0, 1, 2].map(|i| point[i] - p[i]);
                dot(way, way).sqrt() * dot(way, *t).signum()
            }
            Self::Towards(direction) => -dot(*p, *direction),
        }
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn best_image_point(rays: &[PupilRay]) -> Option<ImagePoint> {
    let middle = mean(rays, |ray| ray.p);
    let direction = mean(rays, |ray| ray.t);
    let direction = direction.map(|d| d / dot(direction, direction).sqrt());
    // The distance at which offsets and slopes across cancel best.
    let (mut against, mut spread) = (0.0, 0.0);
    for PupilRay { ray, .. } in rays {
        let offset = [0, 1, 2].map(|i| ray.p[i] - middle[i]);
        let length = dot(ray.t, direction);
        let slope = [0, 1, 2].map(|i| ray.t[i] / length - direction[i]);
        against += dot(offset, slope);
        spread += dot(slope, slope);
    }
    let along = -against / spread;
    if along.is_finite() && along.abs() < FAR {
        return Some(ImagePoint::At([0, 1, 2].map(|i| middle[i] + along * direction[i])));
    }
    Some(ImagePoint::Towards(direction))
}
