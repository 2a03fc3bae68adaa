//! Rays against geometry: nothing leaks, one lane and eight agree, and a naive search finds
//! the same.

mod support;

use std::f64::consts::TAU;

use glam::{DAffine3, DVec3, Vec3};
use petzval::lanes::f32x8;
use petzval::rays::{Column, Hit, HitBatch, NONE, Ray, RayBatch, WAVE};
use petzval::scene::{
    Form, Geometry, Material, Mesh, Quadric, Scene, SceneBuilder, ShapeSpec, TraversalStack,
};
use support::Random;

fn scene(shapes: Vec<Geometry>) -> Scene {
    let mut builder = SceneBuilder::default();
    let material = builder.material(Material::diffuse([0.5; 3]));
    for shape in shapes {
        builder.shape(ShapeSpec::new(shape, material));
    }
    builder.build()
}

/// A closed torus with bumps: every edge is shared by two triangles, and few are aligned.
fn torus(columns: u32, rows: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for j in 0..rows {
        for i in 0..columns {
            let (a, b) =
                (f64::from(i) / f64::from(columns) * TAU, f64::from(j) / f64::from(rows) * TAU);
            let tube = 0.4 + 0.03 * (5.0 * a).sin() * (3.0 * b).cos();
            let ring = 1.0 + tube * b.cos();
            mesh.positions.push([ring * a.cos(), tube * b.sin(), ring * a.sin()].map(|v| v as f32));
        }
    }
    let at = |i: u32, j: u32| (j % rows) * columns + i % columns;
    for j in 0..rows {
        for i in 0..columns {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

fn ray(origin: DVec3, towards: DVec3) -> Ray {
    let direction = (towards - origin).normalize();
    Ray {
        origin: origin.as_vec3().to_array(),
        direction: direction.as_vec3().to_array(),
        t_max: f32::INFINITY,
    }
}

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
        // From inside the tube, where every ray must meet the wall, at vertices, at edges and
        // at points within a rounding of them.
        let angle = random.between(0.0, TAU);
        let origin = DVec3::new(angle.cos(), 0.0, angle.sin());
        let [a, b, _] = triangles[(random.next() * triangles.len() as f64) as usize];
        let target = match i % 3 {
            0 => points[a as usize],
            _ => points[a as usize].lerp(points[b as usize], random.next()),
        };
        let hit = scene.closest::<f32x8>(&ray(origin, target), &mut stack);
        leaks += usize::from(hit.shape == NONE);
    }
    assert_eq!(leaks, 0, "of 400,000 rays from inside a closed mesh");
}

/// A sphere of triangles, each of an icosahedron's split in four again and again; `dent` moves
/// every vertex in or out by up to that share.
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

/// A vertex of a mesh, or a point of one of its edges.
fn rim(points: &[DVec3], triangles: &[[u32; 3]], random: &mut Random) -> DVec3 {
    let [a, b, _] = triangles[(random.next() * triangles.len() as f64) as usize];
    let along = if random.next() < 0.3 { 0.0 } else { random.next() };
    points[a as usize].lerp(points[b as usize], along)
}

#[test]
fn closed_meshes_of_any_size_keep_rays_in() {
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
                for i in 0..WAVE as u32 {
                    // The ball inside a tetrahedron has a third of its radius: 0.57 of 1.73.
                    let mut point = || random.between(-0.28, 0.28);
                    let origin = place.transform_point3(DVec3::new(point(), point(), point()));
                    wave.push(ray(origin, rim(&points, &triangles, &mut random)), [1.0; 3], i);
                }
                scene.intersect::<f32x8>(&wave, &mut hits, &mut stack);
                leaks += hits[..wave.len].iter().filter(|hit| hit.shape == NONE).count();
            }
            assert_eq!(leaks, 0, "{name} of size {scale:e}: of 110,880 rays from inside");
        }
    }
}

#[test]
fn rays_from_a_million_diameters_away_meet_the_near_side() {
    for (name, mesh) in [("icosphere", icosphere(3, 0.0)), ("dented", icosphere(2, 0.02))] {
        let points: Vec<DVec3> = mesh.positions.iter().map(|p| Vec3::from(*p).as_dvec3()).collect();
        let triangles = mesh.triangles.clone();
        let scene = scene(vec![Geometry::Mesh(mesh)]);
        let mut stack = TraversalStack::default();
        let mut random = Random::new(23);
        let (mut rays, mut far) = (0, 0);
        while rays < 60_000 {
            let target = rim(&points, &triangles, &mut random);
            let mut number = || random.between(-1.0, 1.0);
            let away = DVec3::new(number(), number(), number()).normalize();
            // At a million diameters a rounding of the direction is a tenth of the radius.
            if away.dot(target.normalize()) < 0.6 {
                continue;
            }
            rays += 1;
            let origin = away * 2e6;
            let ray = ray(origin, target);
            let hit = scene.closest::<f32x8>(&ray, &mut stack);
            let near = hit.shape != NONE && {
                let (_, point) = scene.surface(&ray, &hit);
                point.normal.dot(Vec3::from(ray.direction)) < 0.0
            };
            far += usize::from(!near);
        }
        assert_eq!(far, 0, "{name}: of {rays} rays from outside");
    }
}

#[test]
fn rays_that_graze_a_flat_mesh_never_pass_to_its_other_side() {
    // A grid of squares in a plane, and rays that come in along its edges, at up to a thousandth
    // of a radian, from no nearer than some roundings of their coordinates.
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
        leaks += usize::from(hit.shape == NONE);
    }
    assert_eq!(leaks, 0, "of 60,000 rays");
}

#[test]
fn a_wave_meets_what_its_rays_meet_one_by_one() {
    let mut builder = SceneBuilder::default();
    let material = builder.material(Material::diffuse([0.5; 3]));
    let object = builder.object();
    let ball = Form::Sphere { radius: 0.4, z: [-0.4, 0.4] };
    let ball = Geometry::Quadric(Quadric::new(ball, TAU, DAffine3::IDENTITY, false).unwrap());
    builder.shape(ShapeSpec {
        object: Some(object),
        ..ShapeSpec::new(Geometry::Mesh(torus(20, 10)), material)
    });
    builder.shape(ShapeSpec { object: Some(object), ..ShapeSpec::new(ball.clone(), material) });
    builder.instance(object, DAffine3::from_translation(DVec3::new(1.5, 0.5, 0.0)));
    builder.instance(object, DAffine3::from_scale(DVec3::new(0.5, -0.7, 0.9)));
    builder.shape(ShapeSpec::new(Geometry::Mesh(torus(48, 24)), material));
    // The same twice: of equal distances the lower number counts.
    builder.shape(ShapeSpec::new(Geometry::Mesh(torus(48, 24)), material));
    builder.shape(ShapeSpec::new(ball, material));
    let scene = builder.build();
    let (mut stack, mut random) = (TraversalStack::default(), Random::new(25));
    let (mut one, mut eight) = (HitBatch::default(), HitBatch::default());
    let nasty = [f32::NAN, f32::INFINITY, 0.0, -0.0, 1e-30, 1e20];
    let bits = |hit: &Hit| {
        ([hit.t, hit.u, hit.v].map(f32::to_bits), [hit.shape, hit.primitive, hit.instance])
    };
    let mut met = 0;
    for _ in 0..20 {
        let mut wave = RayBatch::default();
        for i in 0..WAVE as u32 - 3 {
            let mut point = |r: f64| DVec3::from_array([(); 3].map(|()| random.between(-r, r)));
            let mut ray = ray(point(3.0), point(1.0));
            if i % 3 == 0 {
                ray.t_max = 2.0;
            }
            if i % 50 == 0 {
                let pick = (random.next() * 6.0) as usize;
                ray.direction[i as usize % 3] = nasty[pick];
            }
            wave.push(ray, [1.0, 2.0, 3.0], i);
        }
        scene.intersect::<f32>(&wave, &mut one, &mut stack);
        scene.intersect::<f32x8>(&wave, &mut eight, &mut stack);
        let mut radiance: [Column<f32>; 3] = Default::default();
        scene.occlude::<f32x8>(&wave, &mut stack, &mut radiance);
        for i in 0..wave.len {
            let lone = scene.closest::<f32x8>(&wave.ray(i), &mut stack);
            assert_eq!(bits(&lone), bits(&eight[i]), "{:?}", wave.ray(i));
            assert_eq!(bits(&one[i]), bits(&eight[i]), "{:?}", wave.ray(i));
            let free = !scene.occluded::<f32x8>(&wave.ray(i), &mut stack);
            assert_eq!(free, lone.shape == NONE, "{:?}", wave.ray(i));
            assert_eq!(radiance[1][i], if free { 2.0 } else { 0.0 });
            met += usize::from(!free);
        }
    }
    assert!((5_000..18_000).contains(&met), "{met} hits say little");
}

/// The nearest hit by looking at every triangle, in f64 (Moller & Trumbore 1997).
fn naive(mesh: &Mesh, ray: &Ray) -> Option<(f64, u32)> {
    let double = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let (o, d) = (double(ray.origin), double(ray.direction));
    let mut best: Option<(f64, u32)> = None;
    for i in 0..mesh.triangles.len() as u32 {
        let [a, b, c] = mesh.corners(i).map(|v| v.as_dvec3());
        let (e1, e2) = (b - a, c - a);
        let p = d.cross(e2);
        let det = e1.dot(p);
        let s = o - a;
        let u = s.dot(p) / det;
        let q = s.cross(e1);
        let (v, t) = (d.dot(q) / det, e2.dot(q) / det);
        let inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0;
        if inside && t > 0.0 && best.is_none_or(|(nearest, _)| t < nearest) {
            best = Some((t, i));
        }
    }
    best
}

#[test]
fn the_tree_finds_what_a_naive_search_finds() {
    let mesh = torus(40, 20);
    let naive_mesh = mesh.clone();
    let scene = scene(vec![Geometry::Mesh(mesh)]);
    let mut stack = TraversalStack::default();
    let mut random = Random::new(12);
    let (mut hits, mut differ) = (0, 0);
    for _ in 0..20_000 {
        let mut point = |reach: f64| {
            DVec3::new(
                random.between(-reach, reach),
                random.between(-reach, reach),
                random.between(-reach, reach),
            )
        };
        let ray = ray(point(3.0), point(1.2));
        let hit = scene.closest::<f32x8>(&ray, &mut stack);
        match naive(&naive_mesh, &ray) {
            Some((t, triangle)) if hit.shape != NONE => {
                hits += 1;
                let near = (f64::from(hit.t) - t).abs() < 2e-6 * (1.0 + t);
                differ += usize::from(!near);
                assert!(near || hit.primitive != triangle, "t {} for {t} at {triangle}", hit.t);
            }
            None if hit.shape == NONE => {}
            _ => differ += 1,
        }
        let occluded = scene.occluded::<f32x8>(&ray, &mut stack);
        assert_eq!(occluded, hit.shape != NONE, "any hit and nearest hit disagree for {ray:?}");
        let short = Ray { t_max: hit.t, ..ray };
        assert!(hit.shape == NONE || !scene.occluded::<f32x8>(&short, &mut stack));
    }
    assert!(hits > 5_000, "too few hits to say anything: {hits}");
    // Silhouettes, where f32 and f64 may fall on different sides.
    assert!(differ <= 4, "{differ} of 20,000 rays differ");
}

#[test]
fn one_lane_walks_like_eight() {
    let mut shapes = vec![Geometry::Mesh(torus(30, 16))];
    let mut random = Random::new(13);
    for i in 0..40 {
        let mut number = || random.between(-2.0, 2.0);
        let place = DAffine3::from_translation(DVec3::new(number(), number(), number()));
        let form = match i % 3 {
            0 => Form::Sphere { radius: 0.2, z: [-0.2, 0.2] },
            1 => Form::Disk { radius: 0.3, inner: 0.1, height: 0.0 },
            _ => Form::Cone { radius: 0.2, height: 0.4 },
        };
        shapes.push(Geometry::Quadric(Quadric::new(form, TAU, place, false).unwrap()));
    }
    let scene = scene(shapes);
    let mut stack = TraversalStack::default();
    let nasty = [0.0f32, -0.0, 1.0, -1.0, 1e-30, 0.3, f32::MIN_POSITIVE, 1e20];
    let mut rays = Vec::new();
    for _ in 0..30_000 {
        let mut point = || {
            DVec3::new(
                random.between(-3.0, 3.0),
                random.between(-3.0, 3.0),
                random.between(-3.0, 3.0),
            )
        };
        rays.push(ray(point(), point()));
    }
    for x in nasty {
        for y in nasty {
            for z in nasty {
                let direction = [x, y, z];
                rays.push(Ray { origin: [0.1, 0.2, -3.0], direction, t_max: f32::INFINITY });
                rays.push(Ray { origin: [x, y, z], direction: [0.0, 0.0, 1.0], t_max: 7.0 });
            }
        }
    }
    let bits = |hit: Hit| {
        ([hit.t, hit.u, hit.v].map(f32::to_bits), [hit.shape, hit.primitive, hit.instance])
    };
    for ray in rays {
        let one = scene.closest::<f32>(&ray, &mut stack);
        let eight = scene.closest::<f32x8>(&ray, &mut stack);
        assert_eq!(bits(one), bits(eight), "{ray:?}");
        let (one, eight) =
            (scene.occluded::<f32>(&ray, &mut stack), scene.occluded::<f32x8>(&ray, &mut stack));
        assert_eq!(one, eight, "{ray:?}");
    }
}

#[test]
fn quadrics_are_met_where_their_formulas_say() {
    let place = DAffine3::from_translation(DVec3::new(1.0, 2.0, 3.0));
    let sphere =
        Quadric::new(Form::Sphere { radius: 2.0, z: [-2.0, 2.0] }, TAU, place, false).unwrap();
    let hit = |q: &Quadric, o: [f64; 3], d: [f64; 3]| {
        q.intersect(DVec3::from_array(o), DVec3::from_array(d), f64::INFINITY)
    };
    assert_eq!(hit(&sphere, [1.0, 2.0, -7.0], [0.0, 0.0, 1.0]), Some(8.0));
    assert_eq!(hit(&sphere, [1.0, 2.0, 3.0], [0.0, 0.0, 1.0]), Some(2.0));
    assert_eq!(hit(&sphere, [1.0, 4.1, -7.0], [0.0, 0.0, 1.0]), None);
    let disk = Form::Disk { radius: 2.0, inner: 1.0, height: 0.5 };
    let disk = Quadric::new(disk, TAU, place, false).unwrap();
    assert_eq!(hit(&disk, [2.5, 2.0, 0.0], [0.0, 0.0, 1.0]), Some(3.5));
    assert_eq!(hit(&disk, [1.5, 2.0, 0.0], [0.0, 0.0, 1.0]), None);
    let cone = Quadric::new(Form::Cone { radius: 1.0, height: 2.0 }, TAU, place, false).unwrap();
    // Halfway up its radius is half.
    let t = hit(&cone, [-9.0, 2.0, 4.0], [1.0, 0.0, 0.0]).unwrap();
    assert!((t - 9.5).abs() < 1e-12, "{t}");
    assert_eq!(hit(&cone, [-9.0, 2.0, 5.1], [1.0, 0.0, 0.0]), None);
    // Half of it cut away: the side of negative y is gone.
    let half =
        Quadric::new(Form::Cone { radius: 1.0, height: 2.0 }, TAU / 2.0, place, false).unwrap();
    assert!(hit(&half, [1.0, -9.0, 4.0], [0.0, 1.0, 0.0]).unwrap() > 11.0);
}

#[test]
fn samples_of_quadrics_lie_on_them_and_are_uniform_by_area() {
    let place = DAffine3::from_scale_rotation_translation(
        DVec3::new(1.5, 0.5, 2.0),
        glam::DQuat::from_rotation_x(0.7),
        DVec3::new(1.0, 2.0, 3.0),
    );
    for form in [
        Form::Sphere { radius: 1.2, z: [-1.2, 1.2] },
        Form::Sphere { radius: 1.2, z: [-0.3, 0.9] },
        Form::Disk { radius: 1.1, inner: 0.0, height: 0.2 },
        Form::Disk { radius: 1.1, inner: 0.4, height: 0.2 },
        Form::Cone { radius: 0.7, height: 1.3 },
    ] {
        for phi_max in [TAU, 2.0] {
            let shape = Quadric::new(form, phi_max, place, false).unwrap();
            let mut random = Random::new(17);
            let (mut area, mut far) = (0.0, 0.0f64);
            let n = 40_000;
            for _ in 0..n {
                let (point, density) = shape.sample([random.next() as f32, random.next() as f32]);
                area += 1.0 / f64::from(density) / f64::from(n);
                let back = shape.point(point.position.as_dvec3());
                far = far.max(f64::from(back.position.distance(point.position)));
                assert!(back.normal.dot(point.normal) > 0.999, "{form:?}");
                // A ray down the normal meets the shape at the sample.
                let above = (point.position + point.normal).as_dvec3();
                let t = shape.intersect(above, -point.normal.as_dvec3(), 2.0);
                let met = t.is_some_and(|t| t < 1.0 + 1e-4);
                // Rounding may put a sample just past the edge where a piece is cut out.
                assert!(met || u_edge(form, phi_max), "{form:?} {phi_max}: {t:?}");
            }
            assert!(far < 1e-5, "{form:?}: a sample lies {far} off its shape");
            let expected = shape.area();
            assert!((area / expected - 1.0).abs() < 0.02, "{form:?}: {area} and {expected}");
        }
    }
}

/// Whether a form has open edges that a sample can round past.
fn u_edge(form: Form, phi_max: f64) -> bool {
    phi_max < TAU || !matches!(form, Form::Sphere { radius, z } if z == [-radius, radius])
}

#[test]
fn instances_stand_where_their_copies_would() {
    let mut builder = SceneBuilder::default();
    let material = builder.material(Material::diffuse([0.5; 3]));
    let object = builder.object();
    let mut add = |geometry| {
        let object = Some(object);
        builder.shape(ShapeSpec { object, ..ShapeSpec::new(geometry, material) });
    };
    add(Geometry::Mesh(torus(24, 12)));
    let ball =
        Quadric::new(Form::Sphere { radius: 0.5, z: [-0.5, 0.5] }, TAU, DAffine3::IDENTITY, false);
    add(Geometry::Quadric(ball.unwrap()));
    let mut copies = Vec::new();
    for i in 0..7 {
        let place = DAffine3::from_scale_rotation_translation(
            DVec3::new(0.5, 1.0 + 0.2 * f64::from(i), 0.8),
            glam::DQuat::from_rotation_y(f64::from(i)),
            DVec3::new(2.0 * f64::from(i) - 6.0, 0.3, -0.5 * f64::from(i)),
        );
        builder.instance(object, place);
        let mut mesh = torus(24, 12);
        mesh.transform(&place, false);
        copies.push(Geometry::Mesh(mesh));
        let form = Form::Sphere { radius: 0.5, z: [-0.5, 0.5] };
        copies.push(Geometry::Quadric(Quadric::new(form, TAU, place, false).unwrap()));
    }
    let instanced = builder.build();
    let copied = scene(copies);
    let mut stack = TraversalStack::default();
    let mut random = Random::new(14);
    let (mut hits, mut differ) = (0, 0);
    for _ in 0..20_000 {
        let origin = DVec3::new(random.between(-8.0, 8.0), 5.0, random.between(-5.0, 5.0));
        let target = DVec3::new(random.between(-7.0, 7.0), 0.0, random.between(-3.0, 1.0));
        let ray = ray(origin, target);
        let a = instanced.closest::<f32x8>(&ray, &mut stack);
        let b = copied.closest::<f32x8>(&ray, &mut stack);
        if (a.shape == NONE) != (b.shape == NONE) {
            differ += 1;
        } else if a.shape != NONE {
            hits += 1;
            let (_, p) = instanced.surface(&ray, &a);
            let (_, q) = copied.surface(&ray, &b);
            let same = p.position.distance(q.position) < 1e-4 && p.normal.dot(q.normal) > 0.999;
            differ += usize::from(!same);
        }
    }
    assert!(hits > 4_000 && differ <= 10, "{differ} of {hits} hits differ");
}

#[test]
fn rays_that_leave_a_surface_do_not_meet_it_again() {
    for scale in [1e-4, 1.0, 1e6] {
        let mut mesh = torus(40, 20);
        mesh.transform(&DAffine3::from_scale(DVec3::splat(scale)), false);
        // Of its own radius: a sphere may not shadow itself either.
        let form = Form::Sphere { radius: 0.3 * scale, z: [-0.3 * scale, 0.3 * scale] };
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
            if hit.shape == NONE {
                continue;
            }
            let (_, mut surface) = scene.surface(&first, &hit);
            if surface.normal.dot(Vec3::from(first.direction)) > 0.0 {
                surface.normal = -surface.normal;
            }
            // Grazing: a thousandth of a radian above the surface.
            let (tangent, _) = surface.normal.any_orthonormal_pair();
            let away = (tangent + surface.normal * 1e-3).normalize();
            let second = Ray {
                origin: surface.leave(away).to_array(),
                direction: away.to_array(),
                t_max: (1e-3 * scale) as f32,
            };
            again += usize::from(scene.occluded::<f32x8>(&second, &mut stack));
        }
        // The torus is concave in places: a neighbour may truly be in the way.
        assert!(again < 200, "scale {scale:e}: {again} rays met their own surface");
    }
}
