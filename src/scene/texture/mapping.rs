//! Mapping from points of surfaces to texture coordinates.

use std::f32::consts::PI;

use glam::{Affine3A, Mat2, Vec2, Vec3};

use super::TexturePoint;
use petzval_base::lanes::Real;

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
    /// The surface's own coordinates (u, v), multiplied by a matrix and then offset.
    UvMatrix {
        /// The matrix, by column.
        matrix: Mat2,
        /// Offset added to s and t.
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
    /// there. The radius is 0 for mappings by position.
    #[inline(always)]
    pub fn at<R: Real<Scalar = f32>>(&self, at: &TexturePoint<R>) -> ([R; 2], R) {
        match self {
            Self::Uv { scale, offset } => {
                let [u, v] = at.uv;
                let [su, sv, du, dv] = [scale.x, scale.y, offset.x, offset.y].map(R::splat);
                let radius = at.footprint * R::splat(scale.abs().max_element());
                ([u * su + du, v * sv + dv], radius)
            }
            Self::UvMatrix { matrix, offset } => {
                let [s, t] = product(matrix, at.uv);
                let [ds, dt] = offset.to_array().map(R::splat);
                let sums = matrix.x_axis.abs() + matrix.y_axis.abs();
                ([s + ds, t + dt], at.footprint * R::splat(sums.max_element()))
            }
            _ => (self.by_position(at.position), R::splat(0.0)),
        }
    }

    /// Returns the change of the texture coordinates to each of the two neighbouring samples; 0 for
    /// mappings by position.
    #[inline(always)]
    pub fn steps<R: Real<Scalar = f32>>(&self, at: &TexturePoint<R>) -> [[R; 2]; 2] {
        match self {
            Self::Uv { scale, .. } => {
                let [su, sv] = [scale.x, scale.y].map(R::splat);
                at.uv_steps.map(|[u, v]| [u * su, v * sv])
            }
            Self::UvMatrix { matrix, .. } => at.uv_steps.map(|step| product(matrix, step)),
            _ => [[R::splat(0.0); 2]; 2],
        }
    }

    /// Returns the texture coordinates of positions, world space.
    #[inline(never)]
    fn by_position<R: Real<Scalar = f32>>(&self, position: [R; 3]) -> [R; 2] {
        let mut positions = [[0.0; 8]; 3];
        for axis in 0..3 {
            position[axis].store(&mut positions[axis]);
        }
        let (mut s, mut t) = ([0.0; 8], [0.0; 8]);
        for lane in 0..R::LANES {
            let p = Vec3::new(positions[0][lane], positions[1][lane], positions[2][lane]);
            Vec2 { x: s[lane], y: t[lane] } = self.coordinates(p);
        }
        [R::load(&s), R::load(&t)]
    }

    /// Returns the texture coordinates of a position, world space; 0 for mappings of (u, v).
    fn coordinates(&self, position: Vec3) -> Vec2 {
        match self {
            Self::Uv { .. } | Self::UvMatrix { .. } => Vec2::ZERO,
            Self::Spherical { texture_from_world } => {
                let p = texture_from_world.transform_point3(position);
                let cos = (p.z / p.length()).clamp(-1.0, 1.0);
                let turn = p.y.atan2(p.x) / (2.0 * PI);
                Vec2::new(cos.acos() / PI, if turn < 0.0 { turn + 1.0 } else { turn })
            }
            Self::Cylindrical { texture_from_world } => {
                let p = texture_from_world.transform_point3(position);
                Vec2::new((PI + p.y.atan2(p.x)) / (2.0 * PI), p.z)
            }
            Self::Planar { texture_from_world, axes, offset } => {
                let p = texture_from_world.transform_point3(position);
                offset + Vec2::new(p.dot(axes[0]), p.dot(axes[1]))
            }
        }
    }
}

/// Returns the product of a matrix and a vector.
#[inline(always)]
fn product<R: Real<Scalar = f32>>(matrix: &Mat2, [u, v]: [R; 2]) -> [R; 2] {
    let [x, y] = [matrix.x_axis, matrix.y_axis].map(|axis| axis.to_array().map(R::splat));
    [u * x[0] + v * y[0], u * x[1] + v * y[1]]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_near(mapping: Mapping, position: [f32; 3], expected: [f32; 2]) {
        let at = TexturePoint { position, ..TexturePoint::default() };
        let (found, _) = mapping.at(&at);
        assert!(
            Vec2::from(found).abs_diff_eq(expected.into(), 1e-6),
            "{mapping:?}, {position:?}: {found:?}"
        );
    }

    /// Returns the transform to a texture space with its origin at x = 1.
    fn moved() -> Affine3A {
        Affine3A::from_translation(Vec3::new(-1.0, 0.0, 0.0))
    }

    #[test]
    fn surface_coordinates_are_scaled_and_then_offset() {
        let mapping = Mapping::Uv { scale: Vec2::new(2.0, -4.0), offset: Vec2::new(0.5, 1.0) };
        let uv = [0.25, 0.5];
        let at = TexturePoint { uv, footprint: 0.125f32, ..TexturePoint::default() };
        assert_eq!(mapping.at(&at), ([1.0, -1.0], 0.5));
    }

    #[test]
    fn a_matrix_maps_coordinates_steps_and_footprint() {
        let matrix = Mat2::from_cols(Vec2::new(0.0, 2.0), Vec2::new(-1.0, 1.0));
        let mapping = Mapping::UvMatrix { matrix, offset: Vec2::new(0.5, 1.0) };
        let at = TexturePoint {
            uv: [0.25, 0.5],
            footprint: 0.125f32,
            uv_steps: [[0.125, 0.0], [0.0, 0.0625]],
            ..TexturePoint::default()
        };
        assert_eq!(mapping.at(&at), ([0.0, 2.0], 0.375));
        assert_eq!(mapping.steps(&at), [[0.0, 0.25], [-0.0625, 0.0625]]);
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
