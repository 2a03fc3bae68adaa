//! Motion: where a thing stands at a share of its way.
//!
//! A motion leads from one transform, at share 0, to another, at share 1. Between them places go
//! straight, directions turn about a fixed axis by the shorter way (quaternions, Shoemake 1985,
//! "Animating rotation with quaternion curves"), and what is left of the two by the polar
//! decomposition goes straight (Shoemake & Duff 1992, "Matrix animation and polar
//! decomposition"): as pbrt has it. Beyond its ends a motion goes on at the same rate; whether it
//! is asked that far is up to who asks.

mod carry;
mod path;
mod polar;
mod turn;

use glam::DAffine3;
use turn::Turn;

/// A transform that depends on time, as a share of the way from its start to its end.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion(Steps);

/// Transforms one after the other, the outermost first.
#[derive(Clone, Debug, PartialEq)]
enum Steps {
    Still(DAffine3),
    /// What stands still between two turns is part of one of them.
    Moving(Vec<Turn>),
}

impl Motion {
    /// The transform that is always the same.
    pub fn still(transform: DAffine3) -> Self {
        Self(Steps::Still(transform))
    }

    /// The motion from a transform to another; `None` where one of the two flattens space.
    pub fn between([start, end]: [DAffine3; 2]) -> Option<Self> {
        if start == end {
            return Some(Self::still(start));
        }
        Some(Self(Steps::Moving(vec![Turn::between(&start, &end)?])))
    }

    /// The transform, if it is always the same.
    pub fn as_still(&self) -> Option<DAffine3> {
        match self.0 {
            Steps::Still(transform) => Some(transform),
            Steps::Moving(_) => None,
        }
    }

    /// Whether directions change on the way.
    pub fn turns(&self) -> bool {
        match &self.0 {
            Steps::Still(_) => false,
            Steps::Moving(turns) => turns.iter().any(|turn| turn.angle > 0.0),
        }
    }

    /// The motion of what moves by `inner` within something that moves by this one.
    pub fn then(&self, inner: &Self) -> Self {
        Self(match (&self.0, &inner.0) {
            (Steps::Still(outer), Steps::Still(inner)) => Steps::Still(*outer * *inner),
            (Steps::Still(outer), Steps::Moving(turns)) => {
                let mut turns = turns.clone();
                if let Some(first) = turns.first_mut() {
                    *first = first.within(outer);
                }
                Steps::Moving(turns)
            }
            (Steps::Moving(turns), Steps::Still(inner)) => {
                let mut turns = turns.clone();
                if let Some(last) = turns.last_mut() {
                    *last = last.around(inner);
                }
                Steps::Moving(turns)
            }
            (Steps::Moving(outer), Steps::Moving(inner)) => {
                Steps::Moving(outer.iter().chain(inner).cloned().collect())
            }
        })
    }

    /// The transform at a share of the way.
    pub fn at(&self, share: f64) -> DAffine3 {
        match &self.0 {
            Steps::Still(transform) => *transform,
            Steps::Moving(turns) => match turns.as_slice() {
                [turn] => turn.at(share),
                turns => turns
                    .iter()
                    .fold(DAffine3::IDENTITY, |transform, turn| transform * turn.at(share)),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, DVec3};

    use super::*;

    fn turned(angle: f64, axis: DVec3) -> DAffine3 {
        DAffine3::from_axis_angle(axis.normalize(), angle)
    }

    fn near(a: DAffine3, b: DAffine3) {
        let off = a.to_cols_array().into_iter().zip(b.to_cols_array()).map(|(a, b)| (a - b).abs());
        let off = off.fold(0.0, f64::max);
        assert!(off < 1e-12, "{off:e}: {a:?} and {b:?}");
    }

    #[test]
    fn a_motion_passes_its_ends_and_goes_evenly_between_them() {
        let axis = DVec3::new(1.0, -2.0, 0.5);
        let start = DAffine3::from_translation(DVec3::new(1.0, 2.0, 3.0)) * turned(0.3, axis);
        let end = DAffine3::from_translation(DVec3::new(-3.0, 2.0, 9.0)) * turned(2.1, axis);
        let motion = Motion::between([start, end]).unwrap();
        near(motion.at(0.0), start);
        near(motion.at(1.0), end);
        let quarter = DAffine3::from_translation(DVec3::new(0.0, 2.0, 4.5)) * turned(0.75, axis);
        near(motion.at(0.25), quarter);
        let beyond = DAffine3::from_translation(DVec3::new(-5.0, 2.0, 12.0)) * turned(3.0, axis);
        near(motion.at(1.5), beyond);
    }

    #[test]
    fn turns_go_the_shorter_way() {
        let start = turned(-3.0, DVec3::Z);
        let end = turned(3.0, DVec3::Z);
        let motion = Motion::between([start, end]).unwrap();
        near(motion.at(0.5), turned(std::f64::consts::PI, DVec3::Z));
    }

    #[test]
    fn a_turn_is_the_spherical_interpolation_of_quaternions() {
        let [a, b] = [DQuat::from_xyzw(0.1, 0.4, -0.2, 0.8), DQuat::from_xyzw(0.5, -0.3, 0.1, 0.6)]
            .map(DQuat::normalize);
        let [start, end] = [a, b].map(DAffine3::from_quat);
        let motion = Motion::between([start, end]).unwrap();
        for share in [0.1, 0.5, 0.9] {
            near(motion.at(share), DAffine3::from_quat(a.slerp(b, share)));
        }
    }

    #[test]
    fn a_scale_goes_straight_while_its_thing_turns() {
        let start = DAffine3::from_scale(DVec3::new(1.0, 2.0, 3.0));
        let end = turned(1.0, DVec3::Y) * DAffine3::from_scale(DVec3::new(3.0, 2.0, 1.0));
        let motion = Motion::between([start, end]).unwrap();
        near(motion.at(0.5), turned(0.5, DVec3::Y) * DAffine3::from_scale(DVec3::splat(2.0)));
    }

    #[test]
    fn a_mirrored_thing_turns_as_the_other_does() {
        let mirror = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        let motion = Motion::between([mirror, turned(1.2, DVec3::X) * mirror]).unwrap();
        near(motion.at(0.5), turned(0.6, DVec3::X) * mirror);
    }

    #[test]
    fn things_move_within_things_that_move() {
        let step = DAffine3::from_translation(DVec3::X);
        let still = Motion::still(turned(0.7, DVec3::Y) * step);
        let [a, b] = [
            Motion::between([step, turned(1.0, DVec3::Z)]).unwrap(),
            Motion::between([turned(0.4, DVec3::X), step * step]).unwrap(),
        ];
        let all = still.then(&a).then(&still).then(&b).then(&still);
        for share in [-0.5, 0.0, 0.3, 1.0, 1.2] {
            let [s, a, b] = [&still, &a, &b].map(|motion| motion.at(share));
            near(all.at(share), s * a * s * b * s);
        }
    }

    #[test]
    fn what_is_flat_does_not_move() {
        let flat = DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0));
        assert_eq!(Motion::between([DAffine3::IDENTITY, flat]), None);
    }
}
