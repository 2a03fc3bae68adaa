//! Centre of projection: the point that comes nearest to all rays of a picture.

use glam::{DMat3, DVec3};

use super::pixel_grid::SightLine;

/// Least angle to the axis (radians) at which a ray shows where the pupil is.
const OBLIQUE: f64 = 0.02;

/// The centre of projection of a camera: its no-parallax point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProjectionCentre {
    /// Position (mm, x to the right and y down in the picture, z towards the scene from the film
    /// plane): the least sum of squared distances from the rays of all pixels.
    pub point: DVec3,
    /// Distance of the rays from it (mm): the largest and the root mean square.
    pub miss: [f64; 2],
    /// Least and largest depth (mm from the film plane) at which single rays come nearest to the
    /// axis through the centre: the wander of the entrance pupil with the field.
    pub wander: [f64; 2],
}

impl ProjectionCentre {
    /// Returns the centre of some rays; on the axis if the lens is round. `None` if the rays are
    /// parallel.
    pub(super) fn of<'a>(
        rays: impl Iterator<Item = &'a SightLine> + Clone,
        round: bool,
    ) -> Option<Self> {
        // The distance of C from a ray (p, d) is |(1 - d d^T) (C - p)|.
        let (mut matrix, mut side) = (DMat3::ZERO, DVec3::ZERO);
        for SightLine { point, direction: d } in rays.clone() {
            let across = DMat3::IDENTITY - DMat3::from_cols(d.x * *d, d.y * *d, d.z * *d);
            matrix += across;
            side += across * *point;
        }
        let point = match round {
            true => DVec3::new(0.0, 0.0, side.z / matrix.z_axis.z),
            false => matrix.inverse() * side,
        };
        let count = rays.clone().count() as f64;
        if !point.is_finite() || matrix.z_axis.z < 1e-8 * count {
            return None;
        }
        let (mut largest, mut squares) = (0.0f64, 0.0);
        let mut wander = [f64::INFINITY, f64::NEG_INFINITY];
        for ray in rays {
            let off = point - ray.point;
            let miss = (off - off.dot(ray.direction) * ray.direction).length();
            (largest, squares) = (largest.max(miss), squares + miss * miss);
            let across = ray.direction.truncate();
            if ray.angle() > OBLIQUE {
                let along = off.truncate().dot(across) / across.length_squared();
                let depth = ray.point.z + along * ray.direction.z;
                wander = [wander[0].min(depth), wander[1].max(depth)];
            }
        }
        if wander[0] > wander[1] {
            wander = [point.z; 2];
        }
        Some(Self { point, miss: [largest, (squares / count).sqrt()], wander })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ray(angle: f64, depth: f64) -> SightLine {
        let (sin, cos) = angle.sin_cos();
        let point = DVec3::new(0.0, 0.0, depth) + 7.0 * DVec3::new(sin, 0.0, cos);
        SightLine { point, direction: DVec3::new(sin, 0.0, cos) }
    }

    #[test]
    fn rays_through_one_point_have_it_as_their_centre() {
        let rays = [0.3, -0.2, 0.1, 0.0].map(|angle| ray(angle, 40.0));
        for round in [true, false] {
            let mut rays = rays.to_vec();
            rays.push(SightLine {
                point: DVec3::new(0.0, 0.3, 41.0),
                direction: DVec3::new(0.0, 0.3, 1.0).normalize(),
            });
            let centre = ProjectionCentre::of(rays.iter(), round).unwrap();
            assert!((centre.point - DVec3::new(0.0, 0.0, 40.0)).length() < 1e-9, "{centre:?}");
            assert!(centre.miss[0] < 1e-9 && (centre.wander[1] - 40.0).abs() < 1e-9);
        }
    }

    #[test]
    fn a_pupil_that_moves_is_told_by_its_wander() {
        let rays = [ray(0.1, 40.0), ray(0.4, 42.0)];
        let centre = ProjectionCentre::of(rays.iter(), true).unwrap();
        assert!(centre.point.z > 41.5 && centre.point.z < 42.0, "oblique rays count more");
        assert!((centre.wander[0] - 40.0).abs() < 1e-9 && (centre.wander[1] - 42.0).abs() < 1e-9);
    }

    #[test]
    fn parallel_rays_have_no_centre() {
        let parallel = |x: f64| SightLine { point: DVec3::new(x, 0.0, 0.0), direction: DVec3::Z };
        assert!(ProjectionCentre::of([parallel(0.0), parallel(1.0)].iter(), true).is_none());
    }
}
