//! Geometric error of a camera against a reference, measured on the film.

mod comparison;
mod scene_line;

use comparison::RayComparison;

use petzval_base::rays::Ray;
use petzval_lens::{Camera, LensModel};

/// Waves of rays that are compared.
const WAVES: usize = 16;
/// Radius beyond which a film point counts as corner, relative to the largest lit radius.
const CORNER: f64 = 0.9;

/// The error of a camera's rays against those of a reference.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FilmError {
    /// Root mean square over film and pupil, weighted by the reference's light, um on film.
    pub rms_um: f64,
    /// The same over the outermost tenth of the lit radius; NaN if the camera blocks all of it.
    pub corner_um: f64,
    /// 95th percentile of the light, um on film.
    pub p95_um: f64,
    /// Share of the reference's light whose rays this camera blocks.
    pub lost: f64,
    /// Light on the film, relative to the reference.
    pub light: f64,
}

/// Returns the error of a camera against a reference: the same film rays are traced through both,
/// to the object that the reference's ray meets.
///
/// `distance` returns the distance of that object along a ray of the reference, in world units;
/// infinite if the ray meets nothing. The error is the distance by which the camera's ray misses
/// the object point, seen along the reference's ray, converted to the film displacement that would
/// move the reference's ray as far.
///
/// Both cameras must have the same film: made by [`Camera::with_fidelity`] from one camera. A
/// reference without a real lens has no error. The result is deterministic; it takes some 16,000
/// rays on one thread.
pub fn film_error(
    camera: &Camera,
    reference: &Camera,
    mut distance: impl FnMut(&Ray) -> f64,
) -> FilmError {
    let LensModel::Real(lens) = &reference.model else {
        return FilmError { light: 1.0, ..FilmError::default() };
    };
    let mut comparison = RayComparison::new(camera, reference, lens);
    let mut sums = Sums::default();
    for wave in 0..WAVES {
        comparison.compare_wave(wave, &mut distance, &mut sums);
    }
    sums.error()
}

/// The error of one ray.
struct RayError {
    /// Distance from the centre of the film, mm.
    radius: f64,
    /// Squared error, mm^2.
    error2: f64,
    weight: f64,
}

/// Sums over all rays.
#[derive(Default)]
struct Sums {
    compared: Vec<RayError>,
    /// Light of the reference's rays, and of those that the camera blocks.
    light: f64,
    lost: f64,
    /// Light on the film: from the camera, and from the reference.
    exposure: [f64; 2],
    /// Largest lit radius, mm.
    end: f64,
}

impl Sums {
    fn error(mut self) -> FilmError {
        let rms = |inner: f64| {
            let outer = self.compared.iter().filter(|ray| ray.radius >= inner);
            let (sum, weight) = outer.fold((0.0, 0.0), |(sum, weight), ray| {
                (sum + ray.weight * ray.error2, weight + ray.weight)
            });
            1e3 * (sum / weight).sqrt()
        };
        let (rms_um, corner_um) = (rms(0.0), rms(CORNER * self.end));
        self.compared.sort_by(|a, b| a.error2.total_cmp(&b.error2));
        let mut left = 0.95 * self.compared.iter().map(|ray| ray.weight).sum::<f64>();
        let last = self.compared.iter().find(|ray| {
            left -= ray.weight;
            left <= 0.0
        });
        let share = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 0.0 };
        FilmError {
            rms_um,
            corner_um,
            p95_um: last.map_or(f64::NAN, |ray| 1e3 * ray.error2.sqrt()),
            lost: share(self.lost, self.light),
            light: share(self.exposure[0], self.exposure[1]),
        }
    }
}
