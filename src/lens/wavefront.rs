//! The wavefront of a film point: by how much the lens delays the light of one part of its pupil
//! against another.

use super::camera::RealLens;
use super::exit_pupil::ExitPupil;
use super::refract::LensRay;
use super::surface::{From, Surface, sequence};
use super::trace::trace_one;

/// Points along each side of the grid over the pupil.
const GRID: usize = 48;
/// A point of the scene farther away than this, mm, is as good as infinitely far: what is left of
/// its wavefront's curvature over a pupil of 10 mm is 5 nm, and refocused away.
const FAR: f64 = 1e7;

/// A point of the wavefront.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Delay {
    /// Where in the pupil: direction times index, as in [`ExitPupil`].
    pub at: [f64; 2],
    /// Optical path to the sharpest point of the scene, less that of the best sphere, mm.
    pub path: f64,
}

/// The wavefront over the pupil of a film point, from its best reference sphere.
///
/// Rays are traced in f64 from the film point; the optical path of each goes on to the point of
/// the scene that all of them are nearest to. Piston, tilt and defocus are then taken out by
/// least squares (the terms 1, T_x, T_y and T_z), which puts the reference sphere about the best
/// image point.
#[derive(Clone, Debug)]
pub struct Wavefront {
    /// Over an even grid of T.
    pub delays: Vec<Delay>,
    /// Root mean square of the delays, mm.
    pub rms: f64,
}

impl Wavefront {
    /// Of a film point (mm, the film's frame), at the d line. Some milliseconds. None where fewer
    /// rays come through than a sphere has parameters, and where film or elements stand askew.
    pub fn of(lens: &RealLens, film: [f64; 2], pupil: &ExitPupil) -> Option<Self> {
        if lens.is_askew() {
            return None;
        }
        let surfaces = sequence::<f64>(&lens.prescription, From::Film(lens.film_distance));
        let index = lens.prescription.rear().index;
        let (width, height) = (pupil.width(0.0), pupil.width(std::f64::consts::FRAC_PI_2));
        let middle = pupil.middle();
        let step = |i: usize| (i as f64 + 0.5) / GRID as f64 - 0.5;
        let place = lens.film_pose.film_point(film);
        let mut rays = Vec::new();
        for i in 0..GRID * GRID {
            let at = [middle[0] + width * step(i % GRID), middle[1] + height * step(i / GRID)];
            let tz = (index * index - at[0] * at[0] - at[1] * at[1]).max(0.0).sqrt();
            let start = LensRay::new(place, [at[0], at[1], tz]);
            rays.extend(path(start, &surfaces).map(|(ray, path)| Ray { at, tz, ray, path }));
        }
        let target = nearest(&rays)?;
        let mut delays: Vec<Delay> = rays
            .iter()
            .map(|ray| Delay { at: ray.at, path: ray.path + target.from(ray) })
            .collect();
        let unit = width.max(height);
        let tz = rays.iter().map(|ray| ray.tz).sum::<f64>() / rays.len() as f64;
        let terms = |ray: &Ray| {
            let [x, y] = [0, 1].map(|i| (ray.at[i] - middle[i]) / unit);
            [1.0, x, y, (ray.tz - tz) / (unit * unit)]
        };
        let all: Vec<[f64; 4]> = rays.iter().map(terms).collect();
        // Lengths of metres leave nothing of a wave in squares.
        let mean = delays.iter().map(|delay| delay.path).sum::<f64>() / delays.len() as f64;
        delays.iter_mut().for_each(|delay| delay.path -= mean);
        let fit = least_squares(&all, &delays)?;
        for (delay, terms) in delays.iter_mut().zip(&all) {
            delay.path -= terms.iter().zip(&fit).map(|(a, b)| a * b).sum::<f64>();
        }
        let squares: f64 = delays.iter().map(|delay| delay.path * delay.path).sum();
        let rms = (squares / delays.len() as f64).sqrt();
        rms.is_finite().then_some(Self { delays, rms })
    }
}

/// A ray that came out, in the frame of the front vertex.
struct Ray {
    at: [f64; 2],
    tz: f64,
    ray: LensRay<f64>,
    path: f64,
}

/// A ray through all surfaces, and its optical path to the last.
fn path(mut ray: LensRay<f64>, surfaces: &[Surface<f64>]) -> Option<(LensRay<f64>, f64)> {
    let mut path = 0.0;
    for surface in surfaces {
        let next = trace_one::<f64>(ray, std::slice::from_ref(surface)).ok()?;
        let [x, y, z] = [0, 1, 2].map(|i| next.p[i] - ray.p[i]);
        let along = [x, y, z + surface.advance];
        // The direction is as long as the index: it turns a length into an optical one.
        path += along[0] * ray.t[0] + along[1] * ray.t[1] + along[2] * ray.t[2];
        ray = next;
    }
    Some((ray, path))
}

/// The point of the scene that rays are nearest to.
enum Target {
    At([f64; 3]),
    /// Infinitely far, in this direction.
    Towards([f64; 3]),
}

impl Target {
    /// How far it is from where a ray came out; negative where rays diverge from it.
    fn from(&self, Ray { ray: LensRay { p, t, .. }, .. }: &Ray) -> f64 {
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

fn nearest(rays: &[Ray]) -> Option<Target> {
    if rays.len() < 8 {
        return None;
    }
    let mean = |of: &dyn Fn(&Ray) -> [f64; 3]| {
        let sum = rays.iter().map(of).fold([0.0; 3], |s, v| [0, 1, 2].map(|i| s[i] + v[i]));
        sum.map(|s| s / rays.len() as f64)
    };
    let middle = mean(&|ray| ray.ray.p);
    let direction = mean(&|ray| ray.ray.t);
    let direction = direction.map(|d| d / dot(direction, direction).sqrt());
    // How far along, so that offsets and slopes across cancel best.
    let (mut against, mut spread) = (0.0, 0.0);
    for Ray { ray, .. } in rays {
        let offset = [0, 1, 2].map(|i| ray.p[i] - middle[i]);
        let length = dot(ray.t, direction);
        let slope = [0, 1, 2].map(|i| ray.t[i] / length - direction[i]);
        against += dot(offset, slope);
        spread += dot(slope, slope);
    }
    let along = -against / spread;
    if along.is_finite() && along.abs() < FAR {
        return Some(Target::At([0, 1, 2].map(|i| middle[i] + along * direction[i])));
    }
    Some(Target::Towards(direction))
}

/// The four numbers whose products with the terms are nearest to the paths: by the normal
/// equations, eliminated with pivots.
fn least_squares(terms: &[[f64; 4]], delays: &[Delay]) -> Option<[f64; 4]> {
    let mut rows = [[0.0; 5]; 4];
    for (terms, delay) in terms.iter().zip(delays) {
        for i in 0..4 {
            for j in 0..4 {
                rows[i][j] += terms[i] * terms[j];
            }
            rows[i][4] += terms[i] * delay.path;
        }
    }
    for i in 0..4 {
        let pivot = (i..4).max_by(|&a, &b| rows[a][i].abs().total_cmp(&rows[b][i].abs()))?;
        rows.swap(i, pivot);
        let row = rows[i].map(|v| v / rows[i][i]);
        for (j, other) in rows.iter_mut().enumerate() {
            let by = other[i];
            for k in 0..5 {
                other[k] = if j == i { row[k] } else { other[k] - by * row[k] };
            }
        }
    }
    let fit = rows.map(|row| row[4]);
    fit.iter().all(|v| v.is_finite()).then_some(fit)
}
