//! Equal-area mapping between the sphere and the unit square (Clarberg 2008, "Fast equal-area
//! mapping of the (hemi)sphere using SIMD"), which is the layout of pbrt-v4's images of the sky.

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};

use glam::{Vec2, Vec3};

/// Maps a unit vector to a point of the unit square.
pub fn from_sphere(d: Vec3) -> Vec2 {
    // 1 - |z| without cancellation.
    let r = ((d.x * d.x + d.y * d.y) / (1.0 + d.z.abs())).sqrt();
    let (x, y) = (d.x.abs(), d.y.abs());
    let phi = if x.max(y) == 0.0 { 0.0 } else { y.atan2(x) / FRAC_PI_2 };
    let (mut u, mut v) = (r - phi * r, phi * r);
    if d.z < 0.0 {
        (u, v) = (1.0 - v, 1.0 - u);
    }
    Vec2::new((u.copysign(d.x) + 1.0) / 2.0, (v.copysign(d.y) + 1.0) / 2.0)
}

/// Maps a point of the unit square to a unit vector.
pub fn to_sphere(square: Vec2) -> Vec3 {
    let p = square * 2.0 - 1.0;
    let (u, v) = (p.x.abs(), p.y.abs());
    let inside = 1.0 - (u + v);
    let r = 1.0 - inside.abs();
    let phi = if r == 0.0 { FRAC_PI_4 } else { ((v - u) / r + 1.0) * FRAC_PI_4 };
    let (sin, cos) = phi.sin_cos();
    let across = r * (2.0 - r * r).max(0.0).sqrt();
    Vec3::new(
        (cos * across).copysign(p.x),
        (sin * across).copysign(p.y),
        (1.0 - r * r).copysign(inside),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn from_sphere_inverts_to_sphere() {
        for i in 0..64 {
            for j in 0..64 {
                let p = Vec2::new(i as f32 + 0.5, j as f32 + 0.5) / 64.0;
                let d = to_sphere(p);
                assert!((d.length() - 1.0).abs() < 1e-6, "{p}");
                assert!((from_sphere(d) - p).abs().max_element() < 1e-6, "{p}");
            }
        }
    }

    #[test]
    fn the_centre_is_plus_z_and_the_corners_are_minus_z() {
        assert_eq!(from_sphere(Vec3::Z), Vec2::splat(0.5));
        assert_eq!(from_sphere(Vec3::X), Vec2::new(1.0, 0.5));
        assert_eq!(from_sphere(Vec3::Y), Vec2::new(0.5, 1.0));
        assert_eq!(to_sphere(Vec2::ZERO).z, -1.0);
    }
}
