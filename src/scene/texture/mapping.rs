//! Mapping from points of surfaces to texture coordinates.

use std::f32::consts::PI;

use glam::{Affine3A, Vec2, Vec3};

use super::TexturePoint;

/// Mapping from a point of a surface to texture coordinates (s, t), as in pbrt-v4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mapping {
    /// The surface's own coordinates (u, v), scaled and then offset.
    Uv {
        /// Factors of u and v.
        scale: Vec2,
        /// Offset added to u and v.
        offset: Vec2,
    },
    /// The direction from the origin of texture space: the angle from +z over pi, and the angle
    /// about z over 2 pi.
    Spherical {
        /// World space to texture space.
        texture_from_world: Affine3A,
    },
    /// The angle about z over 2 pi, 0 at -x, and z.
    Cylindrical {
        /// World space to texture space.
        texture_from_world: Affine3A,
    },
    /// Coordinates along two vectors.
    Planar {
        /// World space to texture space.
        texture_from_world: Affine3A,
        /// Vectors; longer ones shrink the texture.
        axes: [Vec3; 2],
        /// Offset added to s and t.
        offset: Vec2,
    },
}

impl Default for Mapping {
    fn default() -> Self {
        Self::Uv { scale: Vec2::ONE, offset: Vec2::ZERO }
    }
}

impl Mapping {
    /// Returns the texture coordinates of a point, and the approximate radius of the footprint
    /// there. The radius is 0 for all mappings except [`Self::Uv`].
    pub fn at(&self, at: &TexturePoint) -> (Vec2, f32) {
        match self {
            Self::Uv { scale, offset } => {
                (at.uv * scale + offset, at.footprint * scale.abs().max_element())
            }
            Self::Spherical { texture_from_world } => {
                let p = texture_from_world.transform_point3(at.position);
                let cos = (p.z / p.length()).clamp(-1.0, 1.0);
                let turn = p.y.atan2(p.x) / (2.0 * PI);
                (Vec2::new(cos.acos() / PI, if turn < 0.0 { turn + 1.0 } else { turn }), 0.0)
            }
            Self::Cylindrical { texture_from_world } => {
                let p = texture_from_world.transform_point3(at.position);
                (Vec2::new((PI + p.y.atan2(p.x)) / (2.0 * PI), p.z), 0.0)
            }
            Self::Planar { texture_from_world, axes, offset } => {
                let p = texture_from_world.transform_point3(at.position);
                (offset + Vec2::new(p.dot(axes[0]), p.dot(axes[1])), 0.0)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_near(mapping: Mapping, position: [f32; 3], expected: [f32; 2]) {
        let at = TexturePoint { position: position.into(), ..TexturePoint::default() };
        let (found, _) = mapping.at(&at);
        assert!(found.abs_diff_eq(expected.into(), 1e-6), "{mapping:?}, {position:?}: {found}");
    }

    /// Returns the transform to a texture space with its origin at x = 1.
    fn moved() -> Affine3A {
        Affine3A::from_translation(Vec3::new(-1.0, 0.0, 0.0))
    }

    #[test]
    fn surface_coordinates_are_scaled_and_then_offset() {
        let mapping = Mapping::Uv { scale: Vec2::new(2.0, -4.0), offset: Vec2::new(0.5, 1.0) };
        let uv = Vec2::new(0.25, 0.5);
        let at = TexturePoint { uv, footprint: 0.125, ..TexturePoint::default() };
        assert_eq!(mapping.at(&at), (Vec2::new(1.0, -1.0), 0.5));
    }

    #[test]
    fn spherical_coordinates_start_at_the_pole() {
        let mapping = Mapping::Spherical { texture_from_world: moved() };
        assert_near(mapping, [1.0, 0.0, 3.0], [0.0, 0.0]);
        assert_near(mapping, [2.0, 0.0, 0.0], [0.5, 0.0]);
        assert_near(mapping, [1.0, 5.0, 0.0], [0.5, 0.25]);
        assert_near(mapping, [0.0, -1.0, -(2f32.sqrt())], [0.75, 0.625]);
    }

    #[test]
    fn cylindrical_coordinates_start_at_minus_x() {
        let mapping = Mapping::Cylindrical { texture_from_world: moved() };
        assert_near(mapping, [2.0, 0.0, 3.0], [0.5, 3.0]);
        assert_near(mapping, [1.0, 5.0, -2.0], [0.75, -2.0]);
        assert_near(mapping, [1.0, -1.0, 0.0], [0.25, 0.0]);
    }

    #[test]
    fn planar_coordinates_are_dot_products_with_the_axes() {
        let mapping = Mapping::Planar {
            texture_from_world: moved(),
            axes: [Vec3::new(2.0, 0.0, 0.0), Vec3::new(0.0, 1.0, 1.0)],
            offset: Vec2::new(0.25, -1.0),
        };
        assert_near(mapping, [2.0, 3.0, 4.0], [2.25, 6.0]);
    }
}
