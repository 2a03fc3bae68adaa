//! Motion: a transform that depends on time.
//!
//! A motion leads from one transform, at time 0, to another, at time 1. As in pbrt, translations
//! are interpolated linearly, rotations about a fixed axis along the shorter arc (quaternions,
//! Shoemake 1985, "Animating rotation with quaternion curves"), and the remaining stretch of the
//! polar decomposition linearly (Shoemake & Duff 1992, "Matrix animation and polar decomposition").
//! Beyond its ends a motion continues at the same rate; the caller clamps the time if it must not.

mod interpolation;
mod polar_decomposition;
mod swept_bounds;

use glam::{DAffine3, DVec3};
use interpolation::Interpolation;

use petzval_base::rays::{Column, RayBatch};

/// A transform that depends on time: 0 at its start, 1 at its end.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion(Form);

/// How the transform is composed.
#[derive(Clone, Debug, PartialEq)]
enum Form {
    /// The same transform at all times.
    Still(DAffine3),
    /// The product of interpolations, the outermost first. A constant transform between two of them
    /// is folded into one of them.
    Moving(Vec<Interpolation>),
}

impl Motion {
    /// Returns the motion whose transform is always the same.
    pub fn still(transform: DAffine3) -> Self {
        Self(Form::Still(transform))
    }

    /// Returns the motion from one transform to another; `None` if one of them is singular.
    pub fn between([start, end]: [DAffine3; 2]) -> Option<Self> {
        if start == end {
            return Some(Self::still(start));
        }
        Some(Self(Form::Moving(vec![Interpolation::between(&start, &end)?])))
    }

    /// Returns the transform if it never changes.
    pub fn as_still(&self) -> Option<DAffine3> {
        match self.0 {
            Form::Still(transform) => Some(transform),
            Form::Moving(_) => None,
        }
    }

    /// Returns whether the motion rotates.
    pub fn rotates(&self) -> bool {
        match &self.0 {
            Form::Still(_) => false,
            Form::Moving(parts) => parts.iter().any(|part| part.angle > 0.0),
        }
    }

    /// Returns the motion `self * inner`: of an object that moves by `inner` in a frame that moves
    /// by `self`.
    pub fn compose(&self, inner: &Self) -> Self {
        Self(match (&self.0, &inner.0) {
            (Form::Still(outer), Form::Still(inner)) => Form::Still(*outer * *inner),
            (Form::Still(outer), Form::Moving(parts)) => {
                let mut parts = parts.clone();
                if let Some(first) = parts.first_mut() {
                    *first = first.precompose(outer);
                }
                Form::Moving(parts)
            }
            (Form::Moving(parts), Form::Still(inner)) => {
                let mut parts = parts.clone();
                if let Some(last) = parts.last_mut() {
                    *last = last.postcompose(inner);
                }
                Form::Moving(parts)
            }
            (Form::Moving(outer), Form::Moving(inner)) => {
                Form::Moving(outer.iter().chain(inner).cloned().collect())
            }
        })
    }

    /// Returns the transform at a time from 0 to 1.
    pub fn at(&self, time: f64) -> DAffine3 {
        match &self.0 {
            Form::Still(transform) => *transform,
            Form::Moving(parts) => match parts.as_slice() {
                [part] => part.at(time),
                parts => parts
                    .iter()
                    .fold(DAffine3::IDENTITY, |transform, part| transform * part.at(time)),
            },
        }
    }

    /// Transforms the rays of a camera at rest by this motion, each at its own time: a stage.
    /// `times` is indexed by the slot of a ray. Directions stay of unit length.
    pub fn transform_rays(&self, times: &Column<f32>, rays: &mut RayBatch) {
        for i in 0..rays.len {
            let transform = self.at(f64::from(times[rays.slot[i] as usize]));
            let vector = |columns: &[Column<f32>; 3]| {
                DVec3::from_array([0, 1, 2].map(|axis| f64::from(columns[axis][i])))
            };
            let origin = transform.transform_point3(vector(&rays.origin));
            let direction = transform.transform_vector3(vector(&rays.direction));
            let length = direction.length();
            for axis in 0..3 {
                rays.origin[axis][i] = origin[axis] as f32;
                rays.direction[axis][i] = (direction[axis] / length) as f32;
            }
            rays.t_max[i] *= length as f32;
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DQuat;

    use super::*;

    fn rotation(angle: f64, axis: DVec3) -> DAffine3 {
        DAffine3::from_axis_angle(axis.normalize(), angle)
    }

    fn assert_near(a: DAffine3, b: DAffine3) {
        let off = a.to_cols_array().into_iter().zip(b.to_cols_array()).map(|(a, b)| (a - b).abs());
        let off = off.fold(0.0, f64::max);
        assert!(off < 1e-12, "{off:e}: {a:?} and {b:?}");
    }

    #[test]
    fn a_motion_passes_its_ends_at_a_constant_rate() {
        let axis = DVec3::new(1.0, -2.0, 0.5);
        let start = DAffine3::from_translation(DVec3::new(1.0, 2.0, 3.0)) * rotation(0.3, axis);
        let end = DAffine3::from_translation(DVec3::new(-3.0, 2.0, 9.0)) * rotation(2.1, axis);
        let motion = Motion::between([start, end]).unwrap();
        assert_near(motion.at(0.0), start);
        assert_near(motion.at(1.0), end);
        let quarter = DAffine3::from_translation(DVec3::new(0.0, 2.0, 4.5)) * rotation(0.75, axis);
        assert_near(motion.at(0.25), quarter);
        let beyond = DAffine3::from_translation(DVec3::new(-5.0, 2.0, 12.0)) * rotation(3.0, axis);
        assert_near(motion.at(1.5), beyond);
    }

    #[test]
    fn rotations_take_the_shorter_arc() {
        let start = rotation(-3.0, DVec3::Z);
        let end = rotation(3.0, DVec3::Z);
        let motion = Motion::between([start, end]).unwrap();
        assert_near(motion.at(0.5), rotation(std::f64::consts::PI, DVec3::Z));
    }

    #[test]
    fn a_rotation_is_the_spherical_interpolation_of_quaternions() {
        let [a, b] = [DQuat::from_xyzw(0.1, 0.4, -0.2, 0.8), DQuat::from_xyzw(0.5, -0.3, 0.1, 0.6)]
            .map(DQuat::normalize);
        let [start, end] = [a, b].map(DAffine3::from_quat);
        let motion = Motion::between([start, end]).unwrap();
        for time in [0.1, 0.5, 0.9] {
            assert_near(motion.at(time), DAffine3::from_quat(a.slerp(b, time)));
        }
    }

    #[test]
    fn a_scale_is_linear_during_a_rotation() {
        let start = DAffine3::from_scale(DVec3::new(1.0, 2.0, 3.0));
        let end = rotation(1.0, DVec3::Y) * DAffine3::from_scale(DVec3::new(3.0, 2.0, 1.0));
        let motion = Motion::between([start, end]).unwrap();
        assert_near(
            motion.at(0.5),
            rotation(0.5, DVec3::Y) * DAffine3::from_scale(DVec3::splat(2.0)),
        );
    }

    #[test]
    fn a_reflection_does_not_change_the_rotation() {
        let mirror = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        let motion = Motion::between([mirror, rotation(1.2, DVec3::X) * mirror]).unwrap();
        assert_near(motion.at(0.5), rotation(0.6, DVec3::X) * mirror);
    }

    #[test]
    fn nested_motions_compose() {
        let step = DAffine3::from_translation(DVec3::X);
        let still = Motion::still(rotation(0.7, DVec3::Y) * step);
        let [a, b] = [
            Motion::between([step, rotation(1.0, DVec3::Z)]).unwrap(),
            Motion::between([rotation(0.4, DVec3::X), step * step]).unwrap(),
        ];
        let all = still.compose(&a).compose(&still).compose(&b).compose(&still);
        for time in [-0.5, 0.0, 0.3, 1.0, 1.2] {
            let [s, a, b] = [&still, &a, &b].map(|motion| motion.at(time));
            assert_near(all.at(time), s * a * s * b * s);
        }
    }

    #[test]
    fn a_singular_transform_has_no_motion() {
        let flat = DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0));
        assert_eq!(Motion::between([DAffine3::IDENTITY, flat]), None);
    }
}
