//! The scene stage: nearest hits on a height field of 520,000 triangles, one lane beside eight
//! and beside the traversal that comes with obvhs, in the same run.

use std::hint::black_box;
use std::time::Duration;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use obvhs::BvhBuildParams;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::ray::Ray as TheirRay;
use obvhs::rt_triangle::RtTriangle;
use obvhs::triangle::Triangle;
use petzval::lanes::{Real, f32x8};
use petzval::rays::{HitBatch, NONE, Ray, RayBatch, WAVE};
use petzval::sampler::{Dimension, pair};
use petzval::scene::{
    Geometry, Material, Mesh, Scene, SceneBuilder, ShapeSpec, TraversalStack, cosine_hemisphere,
};

/// Quads on a side: two triangles each.
const SIDE: u32 = 510;

fn hills() -> Mesh {
    let mut mesh = Mesh::default();
    for j in 0..=SIDE {
        for i in 0..=SIDE {
            let (x, z) =
                (i as f32 / SIDE as f32 * 20.0 - 10.0, j as f32 / SIDE as f32 * 20.0 - 10.0);
            let y = (x * 1.3).sin() * (z * 0.9).cos() + 0.2 * (x * 9.0).cos() * (z * 7.0).sin();
            mesh.positions.push([x, y, z]);
        }
    }
    for j in 0..SIDE {
        for i in 0..SIDE {
            let a = j * (SIDE + 1) + i;
            mesh.triangles.extend([[a, a + 1, a + SIDE + 2], [a, a + SIDE + 2, a + SIDE + 1]]);
        }
    }
    mesh
}

/// Camera rays in tile order, and diffuse bounces from where they hit.
fn waves(scene: &Scene) -> [Vec<RayBatch>; 2] {
    let mut stack = TraversalStack::default();
    let (mut camera, mut diffuse) = (Vec::new(), Vec::new());
    for wave in 0..16u32 {
        let (mut first, mut second) = (RayBatch::default(), RayBatch::default());
        for i in 0..WAVE as u32 {
            let [u, v] = pair(wave, i, Dimension::Film);
            let (x, y) = ((wave % 4) as f32 + u, (wave / 4) as f32 + v);
            let direction = glam::Vec3::new(x / 4.0 - 0.5, -0.25 - y / 8.0, 1.0).normalize();
            let ray = Ray {
                origin: [0.1 * u, 4.0, -9.5 + 0.1 * v],
                direction: direction.to_array(),
                t_max: f32::INFINITY,
            };
            first.push(ray, [1.0; 3], i);
            let hit = scene.closest::<f32x8>(&ray, &mut stack);
            assert_ne!(hit.shape, NONE, "camera rays of the bench hit the hills");
            let (_, mut point) = scene.surface(&ray, &hit);
            if point.normal.dot(direction) > 0.0 {
                point.normal = -point.normal;
            }
            let (bounce, _) = cosine_hemisphere(point.normal, pair(wave, i, Dimension::Bounce(0)));
            let origin = point.leave(bounce).to_array();
            let ray = Ray { origin, direction: bounce.to_array(), t_max: f32::INFINITY };
            second.push(ray, [1.0; 3], i);
        }
        camera.push(first);
        diffuse.push(second);
    }
    [camera, diffuse]
}

fn ours<R: Real<Scalar = f32>>(
    bench: &mut Criterion,
    scene: &Scene,
    waves: &[RayBatch],
    name: &str,
) {
    let (mut hits, mut stack) = (HitBatch::default(), TraversalStack::default());
    let mut group = bench.benchmark_group("scene/closest_hit");
    group.throughput(Throughput::Elements((waves.len() * WAVE) as u64));
    group.bench_function(name, |bencher| {
        bencher.iter(|| {
            for wave in waves {
                scene.intersect::<R>(black_box(wave), &mut hits, &mut stack);
            }
        });
    });
    group.finish();
}

fn theirs(bench: &mut Criterion, mesh: &Mesh, waves: &[RayBatch], name: &str) {
    let triangles: Vec<Triangle> = (0..mesh.triangles.len() as u32)
        .map(|i| {
            let [v0, v1, v2] = mesh.corners(i).map(Into::into);
            Triangle { v0, v1, v2 }
        })
        .collect();
    let bvh =
        build_bvh2_from_tris(&triangles, BvhBuildParams::medium_build(), &mut Duration::default());
    let ready: Vec<RtTriangle> =
        bvh.primitive_indices.iter().map(|&i| (&triangles[i as usize]).into()).collect();
    let rays: Vec<TheirRay> = waves
        .iter()
        .flat_map(|wave| {
            (0..wave.len).map(|i| {
                let ray = wave.ray(i);
                TheirRay::new_inf(ray.origin.into(), ray.direction.into())
            })
        })
        .collect();
    let mut group = bench.benchmark_group("scene/closest_hit");
    group.throughput(Throughput::Elements(rays.len() as u64));
    group.bench_function(name, |bencher| {
        bencher.iter(|| {
            for ray in &rays {
                let mut hit = obvhs::ray::RayHit::none();
                bvh.ray_traverse(*black_box(ray), &mut hit, |ray, i| ready[i].intersect(ray));
                black_box(hit);
            }
        });
    });
    group.finish();
}

fn closest_hit(bench: &mut Criterion) {
    let mesh = hills();
    let mut builder = SceneBuilder::default();
    let material = builder.material(Material::diffuse([0.5; 3]));
    builder.shape(ShapeSpec::new(Geometry::Mesh(mesh.clone()), material));
    let scene = builder.build();
    for (name, waves) in ["camera", "diffuse"].into_iter().zip(waves(&scene)) {
        ours::<f32>(bench, &scene, &waves, &format!("{name}/scalar"));
        ours::<f32x8>(bench, &scene, &waves, &format!("{name}/f32x8"));
        theirs(bench, &mesh, &waves, &format!("{name}/obvhs"));
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20);
    targets = closest_hit
}
criterion_main!(benches);
