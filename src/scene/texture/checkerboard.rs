//! Checkerboard patterns of squares or cubes.

use glam::Affine3A;

use super::{Mapping, TexturePoint};
use petzval_base::lanes::Real;
use petzval_base::lanes::vector::{add, splat, transform};

/// Checkerboard pattern.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CheckerPattern {
    /// Unit squares of texture coordinates.
    Squares(Mapping),
    /// Unit cubes of texture space.
    Cubes {
        /// World space to texture space.
        texture_from_world: Affine3A,
    },
}

impl CheckerPattern {
    /// Returns the weight of the second texture, 0 to 1: at a point, or averaged over the
    /// footprint.
    pub fn second_weight<R: Real<Scalar = f32>>(&self, at: &TexturePoint<R>) -> R {
        let (zero, half) = (R::splat(0.0), R::splat(0.5));
        match self {
            Self::Squares(mapping) => {
                let ([x, y], radius) = mapping.at(at);
                // The width of pbrt-v4's filter.
                let radius = R::splat(1.5) * radius;
                half - half * sign(x, radius) * sign(y, radius)
            }
            Self::Cubes { texture_from_world } => {
                let columns = texture_from_world.matrix3.to_cols_array_2d().map(splat);
                let moved = splat(texture_from_world.translation.to_array());
                let [x, y, z] = add(transform(&columns, at.position), moved);
                half - half * sign(x, zero) * sign(y, zero) * sign(z, zero)
            }
        }
    }
}

/// Returns the mean of a square wave under a triangle filter of a given radius (Heckbert 1986: the
/// second difference of the second integral). The wave is 1 from an even number to the next, and -1
/// from an odd number to the next.
#[inline(always)]
fn sign<R: Real<Scalar = f32>>(x: R, radius: R) -> R {
    let (zero, one, half) = (R::splat(0.0), R::splat(1.0), R::splat(0.5));
    let inside = (x - radius).floor().equals((x + radius).floor());
    let whole = x.floor();
    let even = (whole * half).floor().equals(whole * half);
    let wave = R::select(even, one, -one);
    if R::bits(inside) == (1 << R::LANES) - 1 {
        return wave;
    }
    let twice_integrated = |x: R| {
        let h = x * half;
        let y = h - h.floor() - half;
        h + y * (one - (y + y).abs())
    };
    let (here, before, after) =
        (twice_integrated(x), twice_integrated(x - radius), twice_integrated(x + radius));
    let safe = R::select(radius.equals(zero), one, radius * radius);
    R::select(inside, wave, (after - (here + here) + before) / safe)
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    fn flat(u: f32, v: f32, footprint: f32) -> f32 {
        let uv = [u, v];
        CheckerPattern::Squares(Mapping::default()).second_weight(&TexturePoint {
            uv,
            footprint,
            ..TexturePoint::default()
        })
    }

    #[test]
    fn squares_alternate_on_both_sides_of_zero() {
        for (u, v, share) in [(0.5, 0.5, 0.0), (1.5, 0.5, 1.0), (-0.5, 0.5, 1.0), (-0.5, -0.5, 0.0)]
        {
            assert_eq!(flat(u, v, 0.0), share, "{u} {v}");
        }
    }

    #[test]
    fn cubes_alternate_in_texture_space() {
        let board =
            CheckerPattern::Cubes { texture_from_world: Affine3A::from_scale(Vec3::splat(2.0)) };
        let at = |x: f32, y: f32, z: f32| {
            board.second_weight(&TexturePoint { position: [x, y, z], ..TexturePoint::default() })
        };
        assert_eq!(
            [at(0.25, 0.25, 0.25), at(0.75, 0.25, 0.25), at(0.75, 0.75, 0.25)],
            [0.0, 1.0, 0.0]
        );
        assert_eq!([at(-0.25, 0.25, 0.25), at(0.75, 0.75, 0.75)], [1.0, 1.0]);
    }

    #[test]
    fn a_wide_footprint_and_an_edge_average_both_textures() {
        assert!((flat(0.3, 0.7, 50.0) - 0.5).abs() < 1e-3);
        assert!((flat(1.0, 0.5, 0.1) - 0.5).abs() < 1e-5);
        assert_eq!(flat(0.5, 0.5, 0.1), 0.0);
    }

    #[test]
    fn sign_is_the_mean_under_a_triangle_filter() {
        for (x, reach) in [(0.2f32, 0.5f32), (0.9, 0.3), (3.4, 1.7), (-0.6, 0.9)] {
            let steps = 20_000;
            let mean: f64 = (0..steps)
                .map(|i| {
                    let t = (f64::from(i) + 0.5) / f64::from(steps) * 2.0 - 1.0;
                    let at = f64::from(x) + t * f64::from(reach);
                    let value = if at.floor().rem_euclid(2.0) == 0.0 { 1.0 } else { -1.0 };
                    value * (1.0 - t.abs()) * 2.0 / f64::from(steps)
                })
                .sum();
            let found = f64::from(sign(x, reach));
            assert!((found - mean).abs() < 1e-3, "{x} +- {reach}: {found}, {mean}");
        }
    }
}
