//! Scene stages: nearest hits and any hits on a height field of 520,000 triangles, with one lane, eight
//! lanes and the traversal of obvhs in the same run; and the time to build a BVH of a million triangles.

use std::hint::black_box;
use std::time::Duration;

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::ray::{Ray as TheirRay, RayHit};
use obvhs::rt_triangle::RtTriangle;
use obvhs::triangle::Triangle;
use petzval_base::lanes::{Real, f32x8};
use petzval_base::rays::{Column, HitBatch, RayBatch, WAVE_SIZE};
use petzval_scene::{Mesh, Scene, TraversalStack};
use petzval_tools::bench::hills::{built, hills, waves};

/// Number of quads along a side, of two triangles each.
const SIDE: u32 = 510;

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
    group.throughput(Throughput::Elements((waves.len() * WAVE_SIZE) as u64));
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

/// BVH and triangles of obvhs.
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
