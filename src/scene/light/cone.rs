//! Cones of directions that hold the normals of a group of lights.

use std::f32::consts::PI;

use glam::Vec3;

/// All directions within an angle of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cone {
    /// Unit vector, world space.
    pub(super) axis: Vec3,
    /// Radians, 0 to pi.
    pub(super) angle: f32,
}

impl Cone {
    /// Every direction.
    pub(super) const ALL: Self = Self { axis: Vec3::Z, angle: PI };

    /// One direction.
    pub(super) fn along(axis: Vec3) -> Self {
        Self { axis, angle: 0.0 }
    }

    /// The smallest cone that holds two cones.
    pub(super) fn with(self, other: Self) -> Self {
        let (wide, narrow) = if self.angle < other.angle { (other, self) } else { (self, other) };
        // Not by the arc cosine, which is blind to small angles.
        let cross = wide.axis.cross(narrow.axis).length();
        let between = cross.atan2(wide.axis.dot(narrow.axis));
        if between + narrow.angle <= wide.angle {
            return wide;
        }
        let angle = (wide.angle + between + narrow.angle) / 2.0;
        let turn = angle - wide.angle;
        let sideways = narrow.axis - wide.axis * wide.axis.dot(narrow.axis);
        match sideways.try_normalize() {
            Some(sideways) if angle < PI => {
                let (sin, cos) = turn.sin_cos();
                Self { axis: (wide.axis * cos + sideways * sin).normalize(), angle }
            }
            _ => Self::ALL,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_union_holds_both_and_touches_both() {
        for (angle, one, other) in [(0.3, 0.2, 0.1), (1.0, 0.0, 0.0), (2.0, 0.5, 0.5)] {
            let a = Cone { axis: Vec3::X, angle: one };
            let b = Cone { axis: Vec3::new(f32::cos(angle), f32::sin(angle), 0.0), angle: other };
            let both = a.with(b);
            assert!((both.angle - (angle + one + other) / 2.0).abs() < 1e-6);
            assert!((both.axis.angle_between(a.axis) + one - both.angle).abs() < 1e-3);
            assert!((both.axis.angle_between(b.axis) + other - both.angle).abs() < 1e-3);
        }
    }

    #[test]
    fn a_cone_inside_another_adds_nothing() {
        let wide = Cone { axis: Vec3::Y, angle: 1.0 };
        let narrow = Cone { axis: Vec3::new(0.1, 1.0, 0.0).normalize(), angle: 0.5 };
        assert_eq!(wide.with(narrow), wide);
        assert_eq!(narrow.with(wide), wide);
    }

    #[test]
    fn opposite_directions_fill_the_sphere() {
        assert_eq!(Cone::along(Vec3::X).with(Cone::along(-Vec3::X)), Cone::ALL);
    }
}
