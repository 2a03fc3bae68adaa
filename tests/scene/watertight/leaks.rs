//! Closed meshes keep rays in, and surfaces do not shadow themselves.

use std::f64::consts::TAU;

use glam::{DAffine3, DVec3, Vec3};
use petzval_base::lanes::f32x8;
use petzval_base::rays::{HitBatch, NO_INDEX, Ray, RayBatch, WAVE_SIZE};
use petzval_scene::{Geometry, Mesh, Quadric, QuadricForm, TraversalStack};

use super::{ray, scene, torus};
use crate::support::Random;

#[test]
fn no_ray_slips_through_an_edge_or_a_vertex() {
    let mesh = torus(48, 24);
    let points: Vec<DVec3> = mesh.positions.iter().map(|p| Vec3::from(*p).as_dvec3()).collect();
    let triangles = mesh.triangles.clone();
    let scene = scene(vec![Geometry::Mesh(mesh)]);
    let mut stack = TraversalStack::default();
    let mut random = Random::new(11);
    let mut leaks = 0;
    for i in 0..400_000 {
        // Rays from inside the tube, to vertices, edges and points within a rounding of them, must hit
        // the wall.
        let angle = random.between(0.0, TAU);
        let origin = DVec3::new(angle.cos(), 0.0, angle.sin());
        let [a, b, _] = triangles[(random.next() * triangles.len() as f64) as usize];
        let target = match i % 3 {
            0 => points[a as usize],
            _ => points[a as usize].lerp(points[b as usize], random.next()),
        };
        let hit = scene.closest::<f32x8>(&ray(origin, target), &mut stack);
        leaks += usize::from(hit.shape == NO_INDEX);
    }
    assert_eq!(leaks, 0, "of 400,000 rays from inside a closed mesh");
}

/// Returns a sphere from an icosahedron whose triangles are split in four `times` times. `dent` is the
/// largest relative displacement of a vertex.
fn icosphere(times: u32, dent: f64) -> Mesh {
    let g = (1.0 + 5.0f64.sqrt()) / 2.0;
    let mut points = Vec::new();
    for axis in 0..3 {
        for (one, other) in [(-1.0, -g), (1.0, -g), (-1.0, g), (1.0, g)] {
            let mut p = [0.0; 3];
            (p[(axis + 1) % 3], p[(axis + 2) % 3]) = (one, other);
            points.push(DVec3::from_array(p).normalize());
        }
    }
    let edge = (0..12).map(|i| points[0].distance(points[i])).filter(|&d| d > 0.0);
    let edge = edge.fold(f64::INFINITY, f64::min) * 1.01;
    let mut faces = Vec::new();
    for (a, b, c) in
        (0..12).flat_map(|a| (0..12).flat_map(move |b| (0..12).map(move |c| (a, b, c))))
    {
        let near = |i: usize, j: usize| points[i].distance(points[j]) < edge;
        let outward = points[a].dot(points[b].cross(points[c])) > 0.0;
        if a < b && a < c && near(a, b) && near(b, c) && near(c, a) && outward {
            faces.push([a, b, c]);
        }
    }
    assert_eq!(faces.len(), 20);
    for _ in 0..times {
        let mut halves = std::collections::HashMap::new();
        let mut half = |a: usize, b: usize| {
            *halves.entry((a.min(b), a.max(b))).or_insert_with(|| {
                points.push((points[a] + points[b]).normalize());
                points.len() - 1
            })
        };
        faces = faces
            .into_iter()
            .flat_map(|[a, b, c]| {
                let (ab, bc, ca) = (half(a, b), half(b, c), half(c, a));
                [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
            })
            .collect();
    }
    let mut random = Random::new(21);
    Mesh {
        positions: points
            .iter()
            .map(|&p| (p * (1.0 + random.between(-dent, dent))).as_vec3().to_array())
            .collect(),
        triangles: faces.into_iter().map(|face| face.map(|i| i as u32)).collect(),
        ..Mesh::default()
    }
}

fn tetrahedron() -> Mesh {
    let positions = vec![[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
    let triangles = vec![[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]];
    Mesh { positions, triangles, ..Mesh::default() }
}

/// Returns a random vertex of a mesh or a point of an edge.
fn vertex_or_edge_point(points: &[DVec3], triangles: &[[u32; 3]], random: &mut Random) -> DVec3 {
    let [a, b, _] = triangles[(random.next() * triangles.len() as f64) as usize];
    let along = if random.next() < 0.3 { 0.0 } else { random.next() };
    points[a as usize].lerp(points[b as usize], along)
}

#[test]
fn closed_meshes_of_any_size_do_not_leak() {
    let mut random = Random::new(22);
    for (name, mesh) in [
        ("icosphere", icosphere(3, 0.0)),
        ("dented", icosphere(4, 0.05)),
        ("tetrahedron", tetrahedron()),
    ] {
        for scale in [1e-4, 1.0, 1e6] {
            let mut mesh = mesh.clone();
            let place = DAffine3::from_scale_rotation_translation(
                DVec3::splat(scale),
                glam::DQuat::from_rotation_y(random.next() * TAU),
                DVec3::new(0.3, -0.2, 0.7) * scale,
            );
            mesh.transform(&place, false);
            let points: Vec<DVec3> =
                mesh.positions.iter().map(|p| Vec3::from(*p).as_dvec3()).collect();
            let triangles = mesh.triangles.clone();
            let scene = scene(vec![Geometry::Mesh(mesh)]);
            let (mut stack, mut hits) = (TraversalStack::default(), HitBatch::default());
            let mut leaks = 0;
            for _ in 0..110 {
                let mut wave = RayBatch::default();
                for i in 0..WAVE_SIZE as u32 {
                    // The inscribed sphere of the tetrahedron has a third of its radius: 0.57 of 1.73.
                    let mut point = || random.between(-0.28, 0.28);
                    let origin = place.transform_point3(DVec3::new(point(), point(), point()));
                    wave.push(
                        ray(origin, vertex_or_edge_point(&points, &triangles, &mut random)),
                        [1.0; 3],
                        i,
                    );
                }
                scene.intersect::<f32x8>(&wave, &mut hits, &mut stack);
                leaks += hits[..wave.len].iter().filter(|hit| hit.shape == NO_INDEX).count();
            }
            assert_eq!(leaks, 0, "{name} of size {scale:e}: of 110,880 rays from inside");
        }
    }
}

#[test]
fn rays_from_a_million_diameters_away_hit_the_near_side() {
    for (name, mesh) in [("icosphere", icosphere(3, 0.0)), ("dented", icosphere(2, 0.02))] {
        let points: Vec<DVec3> = mesh.positions.iter().map(|p| Vec3::from(*p).as_dvec3()).collect();
        let triangles = mesh.triangles.clone();
        let scene = scene(vec![Geometry::Mesh(mesh)]);
        let mut stack = TraversalStack::default();
        let mut random = Random::new(23);
        let (mut rays, mut far) = (0, 0);
        while rays < 60_000 {
            let target = vertex_or_edge_point(&points, &triangles, &mut random);
            let mut number = || random.between(-1.0, 1.0);
            let away = DVec3::new(number(), number(), number()).normalize();
            // At a million diameters a rounding of the direction moves the ray by a tenth of the radius.
            if away.dot(target.normalize()) < 0.6 {
                continue;
            }
            rays += 1;
            let origin = away * 2e6;
            let ray = ray(origin, target);
            let hit = scene.closest::<f32x8>(&ray, &mut stack);
            let near = hit.shape != NO_INDEX && {
                let (_, point) = scene.surface(&ray, &hit);
                point.normal.dot(Vec3::from(ray.direction)) < 0.0
            };
            far += usize::from(!near);
        }
        assert_eq!(far, 0, "{name}: of {rays} rays from outside");
    }
}

#[test]
fn rays_that_graze_a_flat_mesh_do_not_pass_it() {
    // Rays along the edges of a plane grid of squares, at angles of up to a thousandth of a radian, from
    // heights above some roundings of their coordinates.
    let (mut mesh, n) = (Mesh::default(), 32);
    for j in 0..=n {
        for i in 0..=n {
            mesh.positions.push([i as f32, 0.0, j as f32]);
        }
    }
    for j in 0..n {
        for i in 0..n {
            let a = j * (n + 1) + i;
            mesh.triangles.extend([[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]);
        }
    }
    let scene = scene(vec![Geometry::Mesh(mesh)]);
    let mut stack = TraversalStack::default();
    let mut random = Random::new(24);
    let mut leaks = 0;
    for i in 0..60_000 {
        let whole = |random: &mut Random| 2.0 + (random.next() * 28.0).floor();
        let target = DVec3::new(whole(&mut random), 0.0, whole(&mut random));
        let along = match i % 3 {
            0 => DVec3::X,
            1 => DVec3::Z,
            _ => DVec3::new(1.0, 0.0, 1.0),
        };
        let origin = target - along + DVec3::Y * random.between(5e-5, 1e-3);
        let hit = scene.closest::<f32x8>(&ray(origin, target), &mut stack);
        leaks += usize::from(hit.shape == NO_INDEX);
    }
    assert_eq!(leaks, 0, "of 60,000 rays");
}

#[test]
fn rays_that_leave_a_surface_do_not_hit_it_again() {
    for scale in [1e-4, 1.0, 1e6] {
        let mut mesh = torus(40, 20);
        mesh.transform(&DAffine3::from_scale(DVec3::splat(scale)), false);
        // A sphere must not shadow itself either.
        let form = QuadricForm::Sphere { radius: 0.3 * scale, z: [-0.3 * scale, 0.3 * scale] };
        let place = DAffine3::from_translation(DVec3::new(3.0, 1.0, 2.0) * scale);
        let sphere = Quadric::new(form, TAU, place, false).unwrap();
        let scene = scene(vec![Geometry::Mesh(mesh), Geometry::Quadric(sphere)]);
        let mut stack = TraversalStack::default();
        let mut random = Random::new(15);
        let mut again = 0;
        for i in 0..40_000 {
            let mut point = || {
                DVec3::new(
                    random.between(-1.0, 1.0),
                    random.between(-1.0, 1.0),
                    random.between(-1.0, 1.0),
                )
            };
            let centre = if i % 2 == 0 { DVec3::ZERO } else { DVec3::new(3.0, 1.0, 2.0) };
            let from = (centre + point() * 4.0) * scale;
            let first = ray(from, (centre + point() * 0.9) * scale);
            let hit = scene.closest::<f32x8>(&first, &mut stack);
            if hit.shape == NO_INDEX {
                continue;
            }
            let (_, mut surface) = scene.surface(&first, &hit);
            if surface.normal.dot(Vec3::from(first.direction)) > 0.0 {
                surface.normal = -surface.normal;
            }
            // A grazing ray, a thousandth of a radian above the surface.
            let (tangent, _) = surface.normal.any_orthonormal_pair();
            let away = (tangent + surface.normal * 1e-3).normalize();
            let second = Ray {
                origin: surface.offset_origin(away).to_array(),
                direction: away.to_array(),
                t_max: (1e-3 * scale) as f32,
            };
            again += usize::from(scene.occluded::<f32x8>(&second, &mut stack));
        }
        // The torus is partly concave, so some rays do hit a neighbour.
        assert!(again < 200, "scale {scale:e}: {again} rays hit their own surface");
    }
}
