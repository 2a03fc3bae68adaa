//! Spherical camera: a picture of all directions, seen from one point.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

use super::Camera;
use super::camera_to_world::CameraToWorld;
use super::film_map::FilmMap;
use petzval_base::equal_area;
use petzval_base::lanes::Real;
use petzval_base::rays::{RayBatch, SampleBatch};

/// Mapping between a picture and all directions, as in pbrt-v4. Points of the picture are fractions
/// of its width from the left, and of its height from the top. The y axis of the camera frame points
/// up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SphericalMapping {
    /// Every pixel covers the same solid angle (Clarberg 2008). The top of the camera's sphere is in
    /// the middle of the picture.
    #[default]
    EqualArea,
    /// Columns are meridians and rows are circles of latitude, from +y at the top to -y. The left
    /// edge is at +x, and +z a quarter of the width to the right.
    Equirectangular,
}

impl SphericalMapping {
    /// Returns the unit direction, camera space, that is seen at a point of the picture. Points
    /// outside the picture continue across its edges.
    pub fn direction(self, at: Vec2) -> Vec3 {
        match self {
            Self::EqualArea => swap(equal_area::to_sphere(wrap_square(at))),
            Self::Equirectangular => {
                // Behind a pole is the opposite meridian: sines of angles below 0 and above pi are
                // negative.
                let ((sin, cos), (y, x)) = ((PI * at.y).sin_cos(), (TAU * at.x).sin_cos());
                Vec3::new(sin * x, cos, sin * y)
            }
        }
    }

    /// Returns the point of the picture at which a unit direction, camera space, is seen.
    pub fn point(self, direction: Vec3) -> Vec2 {
        match self {
            Self::EqualArea => equal_area::from_sphere(swap(direction)),
            Self::Equirectangular => {
                let turn = direction.z.atan2(direction.x) / TAU;
                let across = direction.x.hypot(direction.z);
                Vec2::new(turn - turn.floor(), across.atan2(direction.y) / PI)
            }
        }
    }

    /// Returns the changes of a unit direction, camera space, that are seen at small distances to
    /// the right and downwards in the picture, or in the opposite directions.
    pub fn neighbours(self, direction: Vec3, distance: Vec2) -> [Vec3; 2] {
        match self {
            Self::EqualArea => {
                let at = self.point(direction);
                let seen = self.direction(at);
                // Towards the middle, because the edges are folds.
                let step = distance.copysign(Vec2::splat(0.5) - at);
                [Vec2::X, Vec2::Y].map(|axis| self.direction(at + step * axis) - seen)
            }
            Self::Equirectangular => {
                let Vec3 { x, y, z } = direction;
                let across = x.hypot(z);
                let [east, south] = match across > 0.0 {
                    true => {
                        [Vec3::new(-z, 0.0, x), Vec3::new(x * y / across, -across, z * y / across)]
                    }
                    false => [Vec3::ZERO, Vec3::new(y, 0.0, 0.0)],
                };
                [east * (TAU * distance.x), south * (PI * distance.y)]
            }
        }
    }
}

/// Exchanges y and z: the axis of the mapping is z, that of the camera's picture is y.
fn swap(direction: Vec3) -> Vec3 {
    Vec3::new(direction.x, direction.z, direction.y)
}

/// Returns the point inside the unit square that continues it at a point just outside: an edge meets
/// itself, turned about its midpoint.
fn wrap_square(at: Vec2) -> Vec2 {
    let fold = |x: f32| if x < 0.0 { -x } else { (2.0 - x).min(x) };
    let inside = |x: f32| (0.0..=1.0).contains(&x);
    let mut at = at;
    if !inside(at.x) {
        at = Vec2::new(fold(at.x), 1.0 - at.y);
    }
    if !inside(at.y) {
        at = Vec2::new(1.0 - at.x, fold(at.y));
    }
    at.clamp(Vec2::ZERO, Vec2::ONE)
}

impl Camera {
    /// Generates the rays of a spherical camera, whose film has a width and a height of 1. Directions
    /// are computed one by one, also those of packets.
    pub(crate) fn project_sphere<R: Real<Scalar = f32>>(
        &self,
        mapping: SphericalMapping,
        samples: &SampleBatch,
        rays: &mut RayBatch,
    ) {
        let to_world = CameraToWorld::<R>::new(self, 1.0, 0.0);
        let (ratio, zero) = (R::constant(self.imaging_ratio), R::constant(0.0));
        for first in (0..samples.len).step_by(R::LANES) {
            let mut towards = [[0.0; 8]; 3];
            for lane in 0..R::LANES {
                let share = [0, 1].map(|axis| {
                    let along = f32::from(FilmMap::DIRECTIONS[axis]);
                    0.5 + along * samples.film[axis][first + lane]
                });
                let direction = mapping.direction(Vec2::from(share));
                for axis in 0..3 {
                    towards[axis][lane] = direction[axis];
                }
            }
            let towards = [R::load(&towards[0]), R::load(&towards[1]), R::load(&towards[2])];
            rays.store_packet(first / R::LANES, to_world.ray([zero; 3], towards), ratio);
        }
        rays.number_slots(samples.len);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOTH: [SphericalMapping; 2] =
        [SphericalMapping::EqualArea, SphericalMapping::Equirectangular];

    fn grid() -> impl Iterator<Item = Vec2> {
        (0..40 * 40).map(|i| Vec2::new((i % 40) as f32 + 0.5, (i / 40) as f32 + 0.5) / 40.0)
    }

    #[test]
    fn points_and_directions_are_inverse() {
        for (mapping, at) in
            BOTH.into_iter().flat_map(|mapping| grid().map(move |at| (mapping, at)))
        {
            let direction = mapping.direction(at);
            assert!((direction.length() - 1.0).abs() < 1e-6);
            assert!(mapping.point(direction).distance(at) < 3e-6, "{mapping:?} {at}");
        }
    }

    #[test]
    fn an_equirectangular_picture_has_the_axis_a_quarter_from_the_left() {
        let seen = |u: f32, v: f32| SphericalMapping::Equirectangular.direction(Vec2::new(u, v));
        for (at, axis) in [
            (seen(0.25, 0.5), Vec3::Z),
            (seen(0.0, 0.5), Vec3::X),
            (seen(0.75, 0.5), Vec3::NEG_Z),
            (seen(0.3, 0.0), Vec3::Y),
            (seen(0.6, 1.0), Vec3::NEG_Y),
        ] {
            assert!(at.distance(axis) < 1e-6, "{at}, not {axis}");
        }
    }

    #[test]
    fn an_equal_area_picture_has_the_top_in_the_middle() {
        let seen = |u: f32, v: f32| SphericalMapping::EqualArea.direction(Vec2::new(u, v));
        for (at, axis) in [
            (seen(0.5, 0.5), Vec3::Y),
            (seen(0.5, 1.0), Vec3::Z),
            (seen(1.0, 0.5), Vec3::X),
            (seen(0.0, 0.0), Vec3::NEG_Y),
        ] {
            assert!(at.distance(axis) < 1e-6, "{at}, not {axis}");
        }
    }

    #[test]
    fn pictures_continue_across_their_edges() {
        let beyond = 1e-3;
        for (mapping, share) in
            BOTH.into_iter().flat_map(|mapping| [0.1, 0.37, 0.5, 0.93].map(|at| (mapping, at)))
        {
            for (edge, outwards) in [
                (Vec2::new(0.0, share), Vec2::NEG_X),
                (Vec2::new(1.0, share), Vec2::X),
                (Vec2::new(share, 0.0), Vec2::NEG_Y),
                (Vec2::new(share, 1.0), Vec2::Y),
            ] {
                let [at, outside] =
                    [edge, edge + outwards * beyond].map(|at| mapping.direction(at));
                // Between a third and ten times the share of the picture, as inside.
                let step = at.distance(outside) / beyond;
                assert!((0.3..10.0).contains(&step), "{mapping:?} {edge}: {step}");
            }
        }
    }

    #[test]
    fn neighbours_are_those_of_the_picture() {
        let distance = Vec2::new(1e-3, 2e-3);
        for (mapping, at) in
            BOTH.into_iter().flat_map(|mapping| grid().map(move |at| (mapping, at)))
        {
            let seen = mapping.direction(at);
            let found = mapping.neighbours(seen, distance);
            for (axis, found) in [Vec2::X, Vec2::Y].into_iter().zip(found) {
                let step = distance * axis;
                let expected = [step, -step].map(|step| mapping.direction(at + step) - seen);
                // The difference of second order, and the folds of the equal-area mapping.
                let near =
                    |expected: Vec3| found.distance(expected) < 0.1 * expected.length() + 1e-5;
                assert!(expected.into_iter().any(near), "{mapping:?} {at}: {found}, {expected:?}");
            }
        }
    }
}
