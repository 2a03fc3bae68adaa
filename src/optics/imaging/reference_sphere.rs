//! Reference of phases and path differences.

use super::lens_at_wavelength::FilmRay;
use super::vector::dot;

/// Reference of phases: a point on the film and the sphere around it through the exit pupil.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReferenceSphere {
    /// Point on the film (mm).
    pub point: [f64; 2],
    /// Position of the film behind the rear vertex (mm).
    pub film_distance: f64,
    /// Signed radius of the sphere: distance from the exit pupil to the film along the chief ray
    /// (mm), infinite for a telecentric lens.
    pub radius: f64,
}

impl ReferenceSphere {
    /// Returns the optical path of a ray to the plane wave of direction `t` through the reference
    /// point (mm). The ray may be slightly off `t`: its transverse aberration is the gradient.
    pub(super) fn phase(&self, ray: &FilmRay, t: [f64; 2]) -> f64 {
        // Second order: the aberration hardly changes within a hundredth of a cell.
        let off = [0, 1].map(|i| self.point[i] - ray.point[i]);
        ray.length + off[0] * t[0] + off[1] * t[1]
    }

    /// Returns the optical path of a ray to the reference sphere, plus the radius in the medium
    /// (mm).
    pub(super) fn path_difference(&self, ray: &FilmRay) -> f64 {
        let off = [self.point[0] - ray.point[0], self.point[1] - ray.point[1], 0.0];
        let n2 = dot(ray.t, ray.t);
        let n = n2.sqrt();
        // From the point on the film, along the ray, to the foot of the centre, and back by what
        // the sphere lies closer there: R - sqrt(R^2 - b^2).
        let foot = dot(off, ray.t) / n;
        let b2 = (dot(off, off) - foot * foot).max(0.0);
        let closer = match self.radius.is_finite() {
            // Of the same sign as the radius: paths shorten where it is positive.
            true => {
                b2 / (self.radius
                    + self.radius.signum() * (self.radius * self.radius - b2).max(0.0).sqrt())
            }
            false => 0.0,
        };
        ray.length + n * (foot + closer)
    }
}
