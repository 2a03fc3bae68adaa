//! Hits on bilinear patches: against another formula, at shared edges, and of rays that leave them.

use glam::{DVec3, Vec3};
use petzval_base::lanes::f32x8;
use petzval_base::rays::{HitBatch, NO_INDEX, Ray, RayBatch, WAVE_SIZE};
use petzval_scene::{Geometry, Mesh, PatchMesh, TraversalStack};

use super::{ray, scene};
use crate::support::Random;
use crate::support::nasty::nasty_f32;

/// Returns patches that share nothing, of these corners.
fn separate(corners: &[[DVec3; 4]]) -> PatchMesh {
    let positions = corners.iter().flatten().map(|p| p.as_vec3().to_array()).collect();
    let patches = (0..corners.len() as u32).map(|i| [4 * i, 4 * i + 1, 4 * i + 2, 4 * i + 3]);
    PatchMesh { vertices: Mesh { positions, ..Mesh::default() }, patches: patches.collect() }
}

/// Returns a height field of `side` by `side` patches over the unit square.
fn hills(side: u32, random: &mut Random) -> PatchMesh {
    let row = side + 1;
    let at = |i: u32| [(i % row) as f32 / side as f32, (i / row) as f32 / side as f32];
    let height = 1.0 / f64::from(side);
    let positions =
        (0..row * row).map(|i| [at(i)[0], at(i)[1], (height * random.next()) as f32]).collect();
    let corner = |i: u32| i / side * row + i % side;
    let patches = (0..side * side).map(corner).map(|a| [a, a + 1, a + row, a + row + 1]).collect();
    PatchMesh { vertices: Mesh { positions, ..Mesh::default() }, patches }
}

fn corner(random: &mut Random) -> DVec3 {
    DVec3::from_array([(); 3].map(|()| random.between(-1.0, 1.0) as f32 as f64))
}

/// Distances and (u, v) of all hits of a line on a patch, from its meets with two planes that hold
/// the line (Ramsey, Potter & Hansen 2004, "Ray bilinear patch intersections").
fn by_two_planes(corners: [Vec3; 4], ray: &Ray) -> Vec<[f64; 3]> {
    let [a, b, c, d] = corners.map(|p| p.as_dvec3());
    let [o, r] = [ray.origin, ray.direction].map(|v| Vec3::from(v).as_dvec3());
    let (one, other) = r.any_orthonormal_pair();
    // The planes' equations, linear in u v, u, v and 1.
    let [p, q] = [one, other].map(|n| [d - c - b + a, b - a, c - a, a - o].map(|term| term.dot(n)));
    // v = -(p1 u + p3) / (p0 u + p2) in both; cross-multiplied.
    let square = p[1] * q[0] - q[1] * p[0];
    let linear = p[1] * q[2] + p[3] * q[0] - q[1] * p[2] - q[3] * p[0];
    let constant = p[3] * q[2] - q[3] * p[2];
    let root = (linear * linear - 4.0 * square * constant).sqrt();
    let mut hits = Vec::new();
    for sign in [-1.0, 1.0] {
        let u = (-linear + sign * root) / (2.0 * square);
        let steep = |p: &[f64; 4]| (p[0] * u + p[2]).abs();
        let plane = if steep(&p) > steep(&q) { p } else { q };
        let v = -(plane[1] * u + plane[3]) / (plane[0] * u + plane[2]);
        let point = a + u * (b - a) + v * (c - a) + u * v * (a - b - c + d);
        let t = (point - o).dot(r) / r.dot(r);
        hits.push([t, u, v]);
    }
    hits
}

#[test]
fn hits_are_those_of_another_formula() {
    let (mut random, mut stack) = (Random::new(3), TraversalStack::default());
    let (mut hit_count, mut second, mut unsure) = (0, 0, 0);
    for _ in 0..400 {
        let patches = separate(&[[(); 4].map(|()| corner(&mut random))]);
        let corners = patches.corners(0);
        let scene = scene(vec![Geometry::Patches(patches)]);
        for _ in 0..250 {
            let origin = 2.0 * corner(&mut random);
            let ray = ray(origin, 0.7 * corner(&mut random));
            let all = by_two_planes(corners, &ray);
            let off = |w: f64| (-w).max(w - 1.0);
            // Rays close to an edge, to the silhouette or to the end of the ray may go either way.
            let near = |[t, u, v]: &[f64; 3]| off(*u).max(off(*v)).abs() < 1e-6 || t.abs() < 1e-6;
            if (all[0][0] - all[1][0]).abs() < 1e-4 || all.iter().any(near) {
                unsure += 1;
                continue;
            }
            let inside = |[t, u, v]: &&[f64; 3]| off(*u) < 0.0 && off(*v) < 0.0 && *t > 0.0;
            let expected = all.iter().filter(inside).min_by(|a, b| a[0].total_cmp(&b[0]));
            let found = scene.closest::<f32x8>(&ray, &mut stack);
            second += usize::from(all.iter().filter(inside).count() == 2);
            match expected {
                None => assert_eq!(found.shape, NO_INDEX, "{all:?}"),
                Some([t, u, v]) => {
                    hit_count += 1;
                    assert_ne!(found.shape, NO_INDEX, "{all:?}");
                    let close = |a: f32, b: f64| (f64::from(a) - b).abs() < 1e-5 * b.abs().max(1.0);
                    let same = close(found.t, *t) && close(found.u, *u) && close(found.v, *v);
                    assert!(same, "{found:?} {all:?}");
                }
            }
            assert_eq!(scene.occluded::<f32x8>(&ray, &mut stack), expected.is_some());
        }
    }
    assert!(hit_count > 10_000 && second > 500 && unsure < 1000, "{hit_count} {second} {unsure}");
}

#[test]
fn one_lane_and_eight_give_the_same_bits() {
    let mut random = Random::new(8);
    let mut corners: Vec<[DVec3; 4]> =
        (0..300).map(|_| [(); 4].map(|()| corner(&mut random))).collect();
    // Flat ones, parallelograms, and ones with corners in one place or on a line.
    for i in 0..60 {
        let [a, b, c, d] = &mut corners[i];
        match i % 4 {
            0 => [a, b, c, d].into_iter().for_each(|p| p.z = 0.25),
            1 => *d = *b + *c - *a,
            2 => *d = *c,
            _ => *c = *a + 2.0 * (*b - *a),
        }
    }
    let scene = scene(vec![Geometry::Patches(separate(&corners))]);
    let (mut stack, nasty) = (TraversalStack::default(), nasty_f32());
    let (mut one, mut eight) = (HitBatch::default(), HitBatch::default());
    let mut hit_count = 0;
    for round in 0..20 {
        let mut wave = RayBatch::default();
        for i in 0..WAVE_SIZE as u32 {
            let mut ray = ray(2.0 * corner(&mut random), corner(&mut random));
            if i % 20 == 0 {
                let value = nasty[(random.next() * nasty.len() as f64) as usize];
                match round % 2 {
                    0 => ray.direction[i as usize % 3] = value,
                    _ => ray.origin[i as usize % 3] = value,
                }
            }
            wave.push(ray, [1.0; 3], i);
        }
        scene.intersect::<f32>(&wave, &mut one, &mut stack);
        scene.intersect::<f32x8>(&wave, &mut eight, &mut stack);
        for i in 0..wave.len {
            let bits = |hits: &HitBatch| {
                let hit = &hits[i];
                ([hit.t, hit.u, hit.v].map(f32::to_bits), hit.shape, hit.primitive)
            };
            assert_eq!(bits(&one), bits(&eight), "{:?}", wave.ray(i));
            hit_count += usize::from(one[i].shape != NO_INDEX);
        }
    }
    assert!(hit_count > 3000, "{hit_count}");
}

#[test]
fn no_ray_slips_through_an_edge_or_corner() {
    let mut random = Random::new(17);
    let side = 40;
    let patches = hills(side, &mut random);
    let positions = patches.vertices.positions.clone();
    let all = patches.patches.clone();
    let scene = scene(vec![Geometry::Patches(patches)]);
    let mut stack = TraversalStack::default();
    let at = |i: u32| Vec3::from(positions[i as usize]).as_dvec3();
    for round in 0..400_000 {
        let [a, b, c, d] = all[(random.next() * all.len() as f64) as usize].map(at);
        let w = random.next();
        let target = match round % 3 {
            0 => a.lerp(b, w),
            1 => b.lerp(d, w),
            _ => c,
        };
        if target.x * (1.0 - target.x) * target.y * (1.0 - target.y) < 1e-9 {
            continue;
        }
        let origin = target + DVec3::new(random.between(-0.5, 0.5), random.between(-0.5, 0.5), 2.0);
        let ray = ray(origin, target);
        assert_ne!(scene.closest::<f32x8>(&ray, &mut stack).shape, NO_INDEX, "{ray:?}");
    }
}

#[test]
fn a_ray_that_leaves_a_patch_does_not_hit_it_again() {
    let mut random = Random::new(21);
    let mut stack = TraversalStack::default();
    for offset in [0.0, 1000.0] {
        let mut patches = hills(30, &mut random);
        for p in patches.vertices.positions.iter_mut() {
            *p = p.map(|v| v + offset);
        }
        let scene = scene(vec![Geometry::Patches(patches)]);
        for _ in 0..100_000 {
            let [x, y] = [(); 2].map(|()| random.between(0.01, 0.99) + f64::from(offset));
            let above = DVec3::new(x, y, 2.0 + f64::from(offset));
            let down = ray(above, above - DVec3::Z);
            let hit = scene.closest::<f32x8>(&down, &mut stack);
            assert_ne!(hit.shape, NO_INDEX);
            let (_, point) = scene.surface(&down, &hit);
            assert!(point.normal.z > 0.0);
            let up = Ray {
                origin: point.offset_origin(Vec3::Z).to_array(),
                direction: [0.0, 0.0, 1.0],
                t_max: f32::INFINITY,
            };
            assert!(!scene.occluded::<f32x8>(&up, &mut stack), "{down:?} {up:?}");
        }
    }
}
