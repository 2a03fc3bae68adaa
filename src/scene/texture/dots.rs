//! Dots at random places (Pharr, Jakob & Humphreys 2016, section 10.6.2).

use glam::{Vec2, Vec3};

use super::noise::noise;
use super::{Mapping, TexturePoint};
use petzval_base::lanes::Real;

/// Pattern of dots as in pbrt-v4: in every second unit square of texture coordinates, on average,
/// stands a dot. It is not filtered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DotPattern {
    /// Mapping to texture coordinates.
    pub mapping: Mapping,
}

/// Radius of a dot.
const RADIUS: f32 = 0.35;

impl DotPattern {
    /// Returns 1 inside a dot and 0 elsewhere, lane by lane.
    #[inline(never)]
    pub fn inside<R: Real<Scalar = f32>>(&self, at: &TexturePoint<R>) -> R {
        let ([s, t], _) = self.mapping.at(at);
        s.zip(t, |s, t| f32::from(is_inside(Vec2::new(s, t))))
    }
}

fn is_inside(at: Vec2) -> bool {
    let square = (at + 0.5).floor();
    let random = |u: f32, v: f32| noise(Vec3::new(square.x + u, square.y + v, 0.5));
    if random(0.5, 0.5) <= 0.0 {
        return false;
    }
    // A dot stays in its square.
    let shift = (0.5 - RADIUS) * Vec2::new(random(1.5, 2.8), random(4.5, 9.8));
    (at - (square + shift)).length_squared() < RADIUS * RADIUS
}

#[cfg(test)]
mod tests {
    use super::*;
    use petzval_base::lanes::f32x8;

    /// Rows of 32 points, one bit each, lowest first, as printed by pbrt-v4.
    const ROWS: [u32; 16] = [
        0x0000_6000,
        0x0066_0033,
        0x00ee_0073,
        0,
        0x0066_0700,
        0x00e6_0700,
        0,
        0,
        0,
        0x0000_6003,
        0x0000_6003,
        0,
        0xceee_6300,
        0xceee_6700,
        0x0040_0000,
        0xceee_e000,
    ];

    #[test]
    fn dots_are_pbrts_in_one_lane_and_in_eight() {
        let pattern = DotPattern { mapping: Mapping::default() };
        for (row, expected) in ROWS.into_iter().enumerate() {
            let v = -2.6875 + row as f32 * 0.375;
            let us = [0, 1, 2, 3].map(|packet| {
                [0, 1, 2, 3, 4, 5, 6, 7].map(|lane| -3.125 + (8 * packet + lane) as f32 * 0.234_375)
            });
            let mut found = 0;
            for (packet, us) in us.iter().enumerate() {
                let uv = [f32x8::load(us), f32x8::splat(v)];
                let inside = pattern.inside(&TexturePoint { uv, ..TexturePoint::default() });
                let mut lanes = [0.0; 8];
                inside.store(&mut lanes);
                for lane in 0..8 {
                    let at = TexturePoint { uv: [us[lane], v], ..TexturePoint::default() };
                    assert_eq!(pattern.inside(&at), lanes[lane]);
                    found |= (lanes[lane] as u32) << (8 * packet + lane);
                }
            }
            assert_eq!(found, expected, "row {row}");
        }
    }
}
