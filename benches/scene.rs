//! The scene stages: nearest hits and any hits on a height field of 520,000 triangles, one lane
//! beside eight and beside the traversal that comes with obvhs, in the same run; and how long the
//! tree of a million triangles takes to build.

use std::hint::black_box;
use std::time::Duration;

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use glam::Vec3;
use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::ray::{Ray as TheirRay, RayHit};
use obvhs::rt_triangle::RtTriangle;
use obvhs::triangle::Triangle;
use petzval::lanes::{Real, f32x8};
use petzval::rays::{Column, HitBatch, NONE, Ray, RayBatch, WAVE};
use petzval::sampler::{Dimension, pair};
use petzval::scene::{
    Geometry, Material, Mesh, Scene, SceneBuilder, ShapeSpec, TraversalStack, cosine_hemisphere,
};

/// Quads on a side: two triangles each.
const SIDE: u32 = 510;

fn hills(side: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for j in 0..=side {
        for i in 0..=side {
            let (x, z) =
                (i as f32 / side as f32 * 20.0 - 10.0, j as f32 / side as f32 * 20.0 - 10.0);
            let y = (x * 1.3).sin() * (z * 0.9).cos() + 0.2 * (x * 9.0).cos() * (z * 7.0).sin();
            mesh.positions.push([x, y, z]);
        }
    }
    for j in 0..side {
        for i in 0..side {
            let a = j * (side + 1) + i;
            mesh.triangles.extend([[a, a + 1, a + side + 2], [a, a + side + 2, a + side + 1]]);
        }
    }
    mesh
}

/// Samples of a pixel, one after another as the film stage takes them.
const SAMPLES: u32 = 16;

/// Rays of a camera, waves of neighbouring pixels through an aperture of 0.1 focused at 8; diffuse
/// bounces from where they hit; and shadow rays from there to a lamp.
fn waves(scene: &Scene) -> [Vec<RayBatch>; 3] {
    let mut stack = TraversalStack::default();
    let mut all = [const { Vec::new() }; 3];
    for wave in 0..16u32 {
        let [mut camera, mut diffuse, mut shadow] = [(); 3].map(|()| RayBatch::default());
        for i in 0..WAVE as u32 {
            // Blocks of 8 by 8 pixels, spread over a picture of 512 by 512.
            let (pixel, key) = (i / SAMPLES, wave * 64 + i / SAMPLES);
            let [u, v] = pair(key, i, Dimension::Film);
            let [a, b] = pair(key, i, Dimension::Pupil);
            let x = (wave % 4 * 128 + pixel % 8) as f32 + u;
            let y = (wave / 4 * 128 + pixel / 8) as f32 + v;
            let lens = Vec3::new(0.1 * (a - 0.5), 0.1 * (b - 0.5), 0.0);
            let focus = 8.0 * Vec3::new(x / 512.0 - 0.5, -0.25 - y / 1024.0, 1.0);
            let direction = (focus - lens).normalize();
            let ray = Ray {
                origin: (Vec3::new(0.0, 4.0, -9.5) + lens).to_array(),
                direction: direction.to_array(),
                t_max: f32::INFINITY,
            };
            camera.push(ray, [1.0; 3], i);
            let hit = scene.closest::<f32x8>(&ray, &mut stack);
            assert_ne!(hit.shape, NONE, "camera rays of the bench hit the hills");
            let (_, mut point) = scene.surface(&ray, &hit);
            if point.normal.dot(direction) > 0.0 {
                point.normal = -point.normal;
            }
            let (bounce, _) = cosine_hemisphere(point.normal, pair(key, i, Dimension::Bounce(0)));
            let leave = |towards: Vec3, t_max: f32| Ray {
                origin: point.leave(towards).to_array(),
                direction: towards.to_array(),
                t_max,
            };
            diffuse.push(leave(bounce, f32::INFINITY), [1.0; 3], i);
            let [u, v] = pair(key, i, Dimension::Light(0));
            let lamp = Vec3::new(6.0 + u, 3.0, 5.0 + v) - point.position;
            shadow.push(leave(lamp, 1.0), [1.0; 3], i);
        }
        for (waves, wave) in all.iter_mut().zip([camera, diffuse, shadow]) {
            waves.push(wave);
        }
    }
    all
}

fn ours<R: Real<Scalar = f32>>(
    bench: &mut Criterion,
    scene: &Scene,
    waves: &[RayBatch],
    any: bool,
    name: &str,
) {
    let (mut hits, mut stack) = (HitBatch::default(), TraversalStack::default());
    let mut radiance: [Column<f32>; 3] = Default::default();
    let mut group = bench.benchmark_group("scene");
    group.throughput(Throughput::Elements((waves.len() * WAVE) as u64));
    group.bench_function(name, |bencher| {
        bencher.iter(|| {
            for wave in waves {
                if any {
                    scene.occlude::<R>(black_box(wave), &mut stack, &mut radiance);
                } else {
                    scene.intersect::<R>(black_box(wave), &mut hits, &mut stack);
                }
            }
        });
    });
    group.finish();
}

/// The tree and the triangles of obvhs.
struct Theirs {
    bvh: Bvh2,
    ready: Vec<RtTriangle>,
}

impl Theirs {
    fn new(mesh: &Mesh) -> Self {
        let triangles: Vec<Triangle> = (0..mesh.triangles.len() as u32)
            .map(|i| {
                let [v0, v1, v2] = mesh.corners(i).map(Into::into);
                Triangle { v0, v1, v2 }
            })
            .collect();
        let params = BvhBuildParams::medium_build();
        let bvh = build_bvh2_from_tris(&triangles, params, &mut Duration::default());
        let ready =
            bvh.primitive_indices.iter().map(|&i| (&triangles[i as usize]).into()).collect();
        Self { bvh, ready }
    }

    fn run(&self, bench: &mut Criterion, waves: &[RayBatch], any: bool, name: &str) {
        let rays: Vec<TheirRay> = waves
            .iter()
            .flat_map(|wave| (0..wave.len).map(|i| wave.ray(i)))
            .map(|ray| TheirRay::new(ray.origin.into(), ray.direction.into(), 0.0, ray.t_max))
            .collect();
        let Self { bvh, ready } = self;
        let mut group = bench.benchmark_group("scene");
        group.throughput(Throughput::Elements(rays.len() as u64));
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                for ray in &rays {
                    let ray = *black_box(ray);
                    if any {
                        black_box(bvh.ray_traverse_miss(ray, |ray, i| ready[i].intersect(ray)));
                    } else {
                        let mut hit = RayHit::none();
                        bvh.ray_traverse(ray, &mut hit, |ray, i| ready[i].intersect(ray));
                        black_box(hit);
                    }
                }
            });
        });
        group.finish();
    }
}

fn built(mesh: Mesh) -> Scene {
    let mut builder = SceneBuilder::default();
    let material = builder.material(Material::diffuse([0.5; 3]));
    builder.shape(ShapeSpec::new(Geometry::Mesh(mesh), material));
    builder.build()
}

fn rays(bench: &mut Criterion) {
    let mesh = hills(SIDE);
    let theirs = Theirs::new(&mesh);
    let scene = built(mesh);
    let waves = waves(&scene);
    for (name, waves) in ["camera", "diffuse", "shadow"].into_iter().zip(&waves) {
        let any = name == "shadow";
        ours::<f32>(bench, &scene, waves, any, &format!("{name}/scalar"));
        ours::<f32x8>(bench, &scene, waves, any, &format!("{name}/f32x8"));
        theirs.run(bench, waves, any, &format!("{name}/obvhs"));
    }
}

fn build(bench: &mut Criterion) {
    let mesh = hills(710);
    let mut group = bench.benchmark_group("scene/build");
    group.throughput(Throughput::Elements(mesh.triangles.len() as u64)).sample_size(10);
    group.bench_function("million", |bencher| {
        bencher.iter_batched(|| mesh.clone(), built, BatchSize::LargeInput);
    });
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20);
    targets = rays, build
}
criterion_main!(benches);
