//! Cone of directions around the normals of a group of lights.

use std::f32::consts::PI;

use glam::Vec3;

/// All directions within an angle of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::light) struct Cone {
    /// Axis: a unit vector, world space.
    pub(in crate::light) axis: Vec3,
    /// Half angle (rad), 0 to pi.
    pub(in crate::light) angle: f32,
}

impl Cone {
    /// All directions.
    pub(in crate::light) const ALL: Self = Self { axis: Vec3::Z, angle: PI };

    /// Returns the cone of a single direction.
    pub(in crate::light) fn from_direction(axis: Vec3) -> Self {
        Self { axis, angle: 0.0 }
    }

    /// Returns the smallest cone around two cones.
    pub(in crate::light) fn union(self, other: Self) -> Self {
        let (wide, narrow) = if self.angle < other.angle { (other, self) } else { (self, other) };
        // The arc cosine is inaccurate for small angles.
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
    fn the_union_contains_both_cones_and_touches_both() {
        for (angle, one, other) in [(0.3, 0.2, 0.1), (1.0, 0.0, 0.0), (2.0, 0.5, 0.5)] {
            let a = Cone { axis: Vec3::X, angle: one };
            let b = Cone { axis: Vec3::new(f32::cos(angle), f32::sin(angle), 0.0), angle: other };
            let both = a.union(b);
            assert!((both.angle - (angle + one + other) / 2.0).abs() < 1e-6);
            assert!((both.axis.angle_between(a.axis) + one - both.angle).abs() < 1e-3);
            assert!((both.axis.angle_between(b.axis) + other - both.angle).abs() < 1e-3);
        }
    }

    #[test]
    fn the_union_with_a_cone_inside_is_the_larger_cone() {
        let wide = Cone { axis: Vec3::Y, angle: 1.0 };
        let narrow = Cone { axis: Vec3::new(0.1, 1.0, 0.0).normalize(), angle: 0.5 };
        assert_eq!(wide.union(narrow), wide);
        assert_eq!(narrow.union(wide), wide);
    }

    #[test]
    fn the_union_of_opposite_directions_is_the_sphere() {
        assert_eq!(Cone::from_direction(Vec3::X).union(Cone::from_direction(-Vec3::X)), Cone::ALL);
    }
}
