//! Agreement of hits: waves and single rays, lanes, instances and copies, and a naive search.

use std::f64::consts::TAU;

use glam::{DAffine3, DVec3};
use petzval_base::lanes::f32x8;
use petzval_base::rays::{Column, Hit, HitBatch, NO_INDEX, Ray, RayBatch, WAVE_SIZE};
use petzval_scene::{
    Geometry, Material, Mesh, Quadric, QuadricForm, SceneBuilder, ShapeSpec, TraversalStack,
};

use super::{ray, scene, torus};
use crate::support::Random;
use crate::support::nasty::nasty_f32;

#[test]
fn a_wave_has_the_hits_of_its_single_rays() {
    let mut builder = SceneBuilder::default();
    let material = builder.add_material(Material::diffuse([0.5; 3]));
    let object = builder.add_object();
    let ball = QuadricForm::Sphere { radius: 0.4, z: [-0.4, 0.4] };
    let ball = Geometry::Quadric(Quadric::new(ball, TAU, DAffine3::IDENTITY, false).unwrap());
    builder.add_shape(ShapeSpec {
        object: Some(object),
        ..ShapeSpec::new(Geometry::Mesh(torus(20, 10)), material)
    });
    builder.add_shape(ShapeSpec { object: Some(object), ..ShapeSpec::new(ball.clone(), material) });
    builder.add_instance(object, DAffine3::from_translation(DVec3::new(1.5, 0.5, 0.0)));
    builder.add_instance(object, DAffine3::from_scale(DVec3::new(0.5, -0.7, 0.9)));
    builder.add_shape(ShapeSpec::new(Geometry::Mesh(torus(48, 24)), material));
    // The same mesh twice: at equal distances the lower id wins.
    builder.add_shape(ShapeSpec::new(Geometry::Mesh(torus(48, 24)), material));
    builder.add_shape(ShapeSpec::new(ball, material));
    let scene = builder.build().unwrap();
    let (mut stack, mut random) = (TraversalStack::default(), Random::new(25));
    let (mut one, mut eight) = (HitBatch::default(), HitBatch::default());
    let nasty = nasty_f32();
    let bits = |hit: &Hit| {
        ([hit.t, hit.u, hit.v].map(f32::to_bits), [hit.shape, hit.primitive, hit.instance])
    };
    let mut met = 0;
    for _ in 0..20 {
        let mut wave = RayBatch::default();
        for i in 0..WAVE_SIZE as u32 - 3 {
            let mut point = |r: f64| DVec3::from_array([(); 3].map(|()| random.between(-r, r)));
            let mut ray = ray(point(3.0), point(1.0));
            if i % 3 == 0 {
                ray.t_max = 2.0;
            }
            if i % 50 == 0 {
                let pick = (random.next() * nasty.len() as f64) as usize;
                ray.direction[i as usize % 3] = nasty[pick];
            }
            wave.push(ray, [1.0, 2.0, 3.0], i);
        }
        scene.intersect::<f32>(&wave, &mut one, &mut stack);
        scene.intersect::<f32x8>(&wave, &mut eight, &mut stack);
        let mut radiance: [Column<f32>; 3] = Default::default();
        scene.occlude::<f32x8>(&wave, &mut stack, &mut radiance);
        for i in 0..wave.len {
            let single = scene.closest::<f32x8>(&wave.ray(i), &mut stack);
            assert_eq!(bits(&single), bits(&eight[i]), "{:?}", wave.ray(i));
            assert_eq!(bits(&one[i]), bits(&eight[i]), "{:?}", wave.ray(i));
            let free = !scene.occluded::<f32x8>(&wave.ray(i), &mut stack);
            assert_eq!(free, single.shape == NO_INDEX, "{:?}", wave.ray(i));
            assert_eq!(radiance[1][i], if free { 2.0 } else { 0.0 });
            met += usize::from(!free);
        }
    }
    assert!((5_000..18_000).contains(&met), "{met} hits are too few or too many");
}

/// Returns the nearest hit of all triangles, in f64 (Moller & Trumbore 1997).
fn naive_hit(mesh: &Mesh, ray: &Ray) -> Option<(f64, u32)> {
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
fn the_bvh_finds_the_hits_of_a_naive_search() {
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
        match naive_hit(&naive_mesh, &ray) {
            Some((t, triangle)) if hit.shape != NO_INDEX => {
                hits += 1;
                let near = (f64::from(hit.t) - t).abs() < 2e-6 * (1.0 + t);
                differ += usize::from(!near);
                assert!(near || hit.primitive != triangle, "t {} for {t} at {triangle}", hit.t);
            }
            None if hit.shape == NO_INDEX => {}
            _ => differ += 1,
        }
        let occluded = scene.occluded::<f32x8>(&ray, &mut stack);
        assert_eq!(occluded, hit.shape != NO_INDEX, "any hit and nearest hit disagree for {ray:?}");
        let short = Ray { t_max: hit.t, ..ray };
        assert!(hit.shape == NO_INDEX || !scene.occluded::<f32x8>(&short, &mut stack));
    }
    assert!(hits > 5_000, "too few hits: {hits}");
    // At silhouettes f32 and f64 may decide differently.
    assert!(differ <= 4, "{differ} of 20,000 rays differ");
}

#[test]
fn one_lane_has_the_hits_of_eight() {
    let mut shapes = vec![Geometry::Mesh(torus(30, 16))];
    let mut random = Random::new(13);
    for i in 0..40 {
        let mut number = || random.between(-2.0, 2.0);
        let place = DAffine3::from_translation(DVec3::new(number(), number(), number()));
        let form = match i % 3 {
            0 => QuadricForm::Sphere { radius: 0.2, z: [-0.2, 0.2] },
            1 => QuadricForm::Disk { radius: 0.3, inner: 0.1, height: 0.0 },
            _ => QuadricForm::Cone { radius: 0.2, height: 0.4 },
        };
        shapes.push(Geometry::Quadric(Quadric::new(form, TAU, place, false).unwrap()));
    }
    let scene = scene(shapes);
    let mut stack = TraversalStack::default();
    let nasty = nasty_f32();
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
fn instances_have_the_hits_of_copies() {
    let mut builder = SceneBuilder::default();
    let material = builder.add_material(Material::diffuse([0.5; 3]));
    let object = builder.add_object();
    let mut add = |geometry| {
        let object = Some(object);
        builder.add_shape(ShapeSpec { object, ..ShapeSpec::new(geometry, material) });
    };
    add(Geometry::Mesh(torus(24, 12)));
    let ball = Quadric::new(
        QuadricForm::Sphere { radius: 0.5, z: [-0.5, 0.5] },
        TAU,
        DAffine3::IDENTITY,
        false,
    );
    add(Geometry::Quadric(ball.unwrap()));
    let mut copies = Vec::new();
    for i in 0..7 {
        let place = DAffine3::from_scale_rotation_translation(
            DVec3::new(0.5, 1.0 + 0.2 * f64::from(i), 0.8),
            glam::DQuat::from_rotation_y(f64::from(i)),
            DVec3::new(2.0 * f64::from(i) - 6.0, 0.3, -0.5 * f64::from(i)),
        );
        builder.add_instance(object, place);
        let mut mesh = torus(24, 12);
        mesh.transform(&place, false);
        copies.push(Geometry::Mesh(mesh));
        let form = QuadricForm::Sphere { radius: 0.5, z: [-0.5, 0.5] };
        copies.push(Geometry::Quadric(Quadric::new(form, TAU, place, false).unwrap()));
    }
    let instanced = builder.build().unwrap();
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
        if (a.shape == NO_INDEX) != (b.shape == NO_INDEX) {
            differ += 1;
        } else if a.shape != NO_INDEX {
            hits += 1;
            let (_, p) = instanced.surface(&ray, &a);
            let (_, q) = copied.surface(&ray, &b);
            let same = p.position.distance(q.position) < 1e-4 && p.normal.dot(q.normal) > 0.999;
            differ += usize::from(!same);
        }
    }
    assert!(hits > 4_000 && differ <= 10, "{differ} of {hits} hits differ");
}
