//! Surface points and derivatives of curves have pbrt-v4's frames.

use glam::{DAffine3, DVec3, Vec3};
use petzval_base::rays::NO_INDEX;
use petzval_scene::{CurveKind, CurveSegment};

use super::crossing::{KINDS, curves, nearest, ray, scene};
use super::naive::{in_cube, point, slope, smooth_segment};
use crate::support::Random;

#[test]
fn derivatives_and_normals_are_those_of_the_kind() {
    for kind in KINDS {
        let mut random = Random::new(4);
        let mut compared = 0;
        for _ in 0..600 {
            let segment = smooth_segment(kind, &mut random);
            let scene = scene(curves(kind, &[segment], &DAffine3::IDENTITY));
            let from = in_cube(&mut random).normalize() * 4.0;
            let aim = point(&segment, random.next()) + 0.01 * in_cube(&mut random);
            let ray = ray(from, aim - from);
            let hit = nearest(&scene, &ray);
            if hit.shape == NO_INDEX {
                continue;
            }
            let double = |v: Vec3| v.as_dvec3();
            let along = double(Vec3::from(ray.direction)).normalize();
            let (surface, derivatives) =
                (scene.surface(&ray, &hit).1, scene.surface_derivatives(&ray, &hit));
            let [du, dv] = derivatives.dp.map(double);
            assert_eq!(derivatives.uv.to_array(), [hit.u, hit.v]);
            assert_eq!(derivatives.dn, [Vec3::ZERO; 2]);
            let expected = slope(&segment, f64::from(hit.u));
            assert!((du - expected).length() < 1e-4 * expected.length(), "{du} {expected}");
            assert!(du.dot(dv).abs() < 1e-5 * du.length() * dv.length());
            let normal = double(surface.normal);
            assert!((du.cross(dv).normalize() - normal).length() < 1e-5);
            assert_eq!(surface.normal, surface.shading_normal);
            let tangent = du.normalize();
            // The normal of a flat curve, and the width that the ray sees.
            let away = (along - tangent * along.dot(tangent)).normalize();
            let [w0, w1] = segment.width;
            let mut width = w0 + (w1 - w0) * f64::from(hit.u);
            match kind {
                CurveKind::Flat => assert!((normal - away).length() < 1e-4, "{normal} {away}"),
                CurveKind::Cylinder => {
                    let side = along.cross(tangent).normalize();
                    let h = 2.0 * f64::from(hit.v) - 1.0;
                    let (sin, cos) = (h * std::f64::consts::FRAC_PI_2).sin_cos();
                    let expected = away * cos + side * sin;
                    assert!((normal - expected).length() < 1e-4, "{h}: {normal} {expected}");
                }
                CurveKind::Ribbon => {
                    let [from, to] = segment.normals.expect("a ribbon");
                    let share = dv.length() / width;
                    // The width is seen as from the ribbon's normal, which is between its ends.
                    let between = from.lerp(to, 0.5).normalize();
                    let spread = from.angle_between(to) / 2.0 + 1e-3;
                    let facing = share.min(1.0).acos();
                    let middle = between.dot(along).abs().min(1.0).acos();
                    assert!((facing - middle).abs() < spread, "{facing} {middle} {spread}");
                    width *= share;
                }
            }
            assert!((dv.length() - width).abs() < 1e-5 * width + 1e-8);
            // A ray that leaves the curve starts beyond the width.
            let leaves = surface.offset_origin(surface.normal);
            let moved = double(leaves - surface.position).dot(normal);
            assert!(moved >= width * 0.999, "{moved} {width}");
            compared += 1;
        }
        assert!(compared > 200, "{kind:?}: {compared}");
    }
}

#[test]
fn v_increases_to_the_right_of_the_curve() {
    let control = [0.0, 1.0, 2.0, 3.0].map(|y| DVec3::new(0.0, y, 0.0));
    let segment = CurveSegment { control, width: [0.4; 2], normals: None };
    for kind in [CurveKind::Flat, CurveKind::Cylinder] {
        let scene = scene(curves(kind, &[segment], &DAffine3::IDENTITY));
        for (x, v) in [(-0.19f64, 0.975), (-0.1, 0.75), (0.0, 0.5), (0.1, 0.25), (0.19, 0.025)] {
            // Seen from +z, the curve goes up and x is on its right.
            let down = ray(DVec3::new(x, 1.2, 5.0), DVec3::new(0.0, 0.0, -1.0));
            let hit = nearest(&scene, &down);
            assert!((hit.v - 1.0 + v as f32).abs() < 1e-5, "{x}: {}", hit.v);
            assert!((hit.u - 0.4).abs() < 1e-6 && (hit.t - 5.0).abs() < 1e-6);
            let up = ray(DVec3::new(x, 1.2, -5.0), DVec3::new(0.0, 0.0, 1.0));
            let hit = nearest(&scene, &up);
            assert!((hit.v - v as f32).abs() < 1e-5, "{x}: {}", hit.v);
        }
    }
}
