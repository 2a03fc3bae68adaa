//! Squares and cubes in turn.

use glam::{Affine3A, Vec2};

use super::{Mapping, TexturePoint};

/// What is cut into equal parts that take turns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Board {
    /// A flat texture, into squares of 1.
    Squares(Mapping),
    /// Space, into cubes of 1.
    Cubes {
        /// World space to texture space.
        texture_from_world: Affine3A,
    },
}

impl Board {
    /// The share of the second of the two, at a point or over what the sample reaches.
    pub fn share(&self, at: &TexturePoint) -> f32 {
        match self {
            Self::Squares(mapping) => {
                let (Vec2 { x, y }, reach) = mapping.at(at);
                // As wide as pbrt-v4's filter.
                let reach = 1.5 * reach;
                0.5 - 0.5 * sign(x, reach) * sign(y, reach)
            }
            Self::Cubes { texture_from_world } => {
                let p = texture_from_world.transform_point3(at.position);
                0.5 - 0.5 * sign(p.x, 0.0) * sign(p.y, 0.0) * sign(p.z, 0.0)
            }
        }
    }
}

/// 1 between an even number and the next, -1 between an odd one and the next; the mean under a
/// triangle of this half width (Heckbert 1986: the second difference of the second integral).
fn sign(x: f32, reach: f32) -> f32 {
    if (x - reach).floor() == (x + reach).floor() {
        return if x.floor().rem_euclid(2.0) == 0.0 { 1.0 } else { -1.0 };
    }
    let twice_integrated = |x: f32| {
        let y = x / 2.0 - (x / 2.0).floor() - 0.5;
        x / 2.0 + y * (1.0 - 2.0 * y.abs())
    };
    let difference =
        twice_integrated(x + reach) - 2.0 * twice_integrated(x) + twice_integrated(x - reach);
    difference / (reach * reach)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn flat(u: f32, v: f32, footprint: f32) -> f32 {
        let uv = Vec2::new(u, v);
        Board::Squares(Mapping::default()).share(&TexturePoint {
            uv,
            footprint,
            ..TexturePoint::default()
        })
    }

    #[test]
    fn squares_take_turns_on_both_sides_of_zero() {
        for (u, v, share) in [(0.5, 0.5, 0.0), (1.5, 0.5, 1.0), (-0.5, 0.5, 1.0), (-0.5, -0.5, 0.0)]
        {
            assert_eq!(flat(u, v, 0.0), share, "{u} {v}");
        }
    }

    #[test]
    fn cubes_take_turns_in_texture_space() {
        let board = Board::Cubes { texture_from_world: Affine3A::from_scale(Vec3::splat(2.0)) };
        let at = |x: f32, y: f32, z: f32| {
            board.share(&TexturePoint { position: Vec3::new(x, y, z), ..TexturePoint::default() })
        };
        assert_eq!(
            [at(0.25, 0.25, 0.25), at(0.75, 0.25, 0.25), at(0.75, 0.75, 0.25)],
            [0.0, 1.0, 0.0]
        );
        assert_eq!([at(-0.25, 0.25, 0.25), at(0.75, 0.75, 0.75)], [1.0, 1.0]);
    }

    #[test]
    fn a_wide_sample_sees_half_of_each_and_an_edge_half_and_half() {
        assert!((flat(0.3, 0.7, 50.0) - 0.5).abs() < 1e-3);
        assert!((flat(1.0, 0.5, 0.1) - 0.5).abs() < 1e-5);
        assert_eq!(flat(0.5, 0.5, 0.1), 0.0);
    }

    #[test]
    fn the_filter_is_the_mean_under_a_triangle() {
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
