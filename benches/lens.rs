//! The lens stage: rays a second, every variant beside its peers in the same run.

#[path = "../src/cli/bench/textbook.rs"]
mod textbook;
#[path = "../src/cli/bench/wave.rs"]
mod wave;

use std::hint::black_box;
use std::path::Path;
use std::time::{Duration, Instant};

use criterion::criterion_main;
use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, BenchmarkId, Criterion, Throughput, criterion_group};
use glam::DAffine3;
use petzval::film::{Filter, Frame, TileSampler, sample};
use petzval::lanes::{Real, f32x8};
use petzval::lens::{
    Aim, Axis, Camera, Fidelity, Focus, From, LensColumns, LensRay, Model, Prescription, RealLens,
    Row, read, sequence, trace_one,
};
use petzval::rays::{RayBatch, SampleBatch, WAVE};
use petzval::stats::LensStats;
use wave::{Bench, starts};

/// The course's lenses, with the film distances (mm) and half the film's side (mm) of its scenes.
const LENSES: [(&str, f64); 4] = [
    ("dgauss.50mm", 36.77),
    ("fisheye.10mm", 23.192),
    ("telephoto.250mm", 123.7439),
    ("wide.22mm", 14.54),
];

fn lens(name: &str) -> Prescription {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("lenses");
    read(&folder.join(format!("{name}.dat"))).expect("a lens of the repository")
}

fn batches<R: Real>(
    group: &mut BenchmarkGroup<WallTime>,
    id: impl Into<BenchmarkIdOrName>,
    mut bench: Bench<R>,
    elements: usize,
) {
    group.throughput(Throughput::Elements(elements as u64));
    group.bench_function(id.into().0, |bencher| bencher.iter(|| bench.trace()));
}

/// What criterion takes as a name.
struct BenchmarkIdOrName(BenchmarkId);

impl std::convert::From<&str> for BenchmarkIdOrName {
    fn from(name: &str) -> Self {
        Self(BenchmarkId::from_parameter(name))
    }
}

impl std::convert::From<String> for BenchmarkIdOrName {
    fn from(name: String) -> Self {
        Self(BenchmarkId::from_parameter(name))
    }
}

/// The same kernels eight, one and one f64 lane wide, a ray at a time, and the textbook.
fn precisions(criterion: &mut Criterion) {
    for (name, film) in [("dgauss.50mm", 36.77), ("wide.22mm", 14.54)] {
        let short = name.split('.').next().unwrap_or(name);
        let lens = lens(name);
        let mut group = criterion.benchmark_group(format!("lens/trace/{short}"));
        batches(&mut group, "f32x8", Bench::<f32x8>::new(&lens, film, WAVE, 1.0), WAVE);
        // The compiler makes packets of this by itself.
        batches(&mut group, "f32, one lane", Bench::<f32>::new(&lens, film, WAVE, 1.0), WAVE);
        batches(&mut group, "f64", Bench::<f64>::new(&lens, film, WAVE, 1.0), WAVE);

        let surfaces = sequence::<f32>(&lens, From::Film(film));
        let rays: Vec<LensRay<f32>> = starts(WAVE, film, 1.0)
            .iter()
            .map(|[p, t]| LensRay::new(p.map(|v| v as f32), t.map(|v| v as f32)))
            .collect();
        group.bench_function("f32, a ray at a time", |bencher| {
            bencher.iter(|| {
                rays.iter().filter(|ray| trace_one::<f32>(**ray, &surfaces).is_ok()).count()
            });
        });
        let table = textbook::table(&lens, film);
        let film_rays: Vec<textbook::Ray> =
            rays.iter().map(|ray| textbook::Ray::leaving(ray.p, ray.t)).collect();
        assert!(film_rays.iter().all(|ray| textbook::trace(&table, *ray).is_some()));
        group.bench_function("textbook", |bencher| {
            bencher.iter(|| {
                film_rays.iter().filter(|ray| textbook::trace(&table, **ray).is_some()).count()
            });
        });
        group.finish();
    }
}

/// Film points of a whole picture to rays in the world: sample, aim, trace, compact.
fn valid(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("lens/valid");
    for (name, film) in LENSES {
        let short = name.split('.').next().unwrap_or(name);
        for stop in ["open", "f8"] {
            let mut lens = lens(name);
            if stop == "f8" {
                let open = Focus::of(&lens).f_number().expect("the lens forms an image");
                lens.stop_down(lens.rows[lens.stop()].diameter * open / 8.0);
            }
            let lens = RealLens::new(lens, film, 35.0, Aim::Pupil, 1.0, 0.0);
            let camera = camera(lens);
            pictures(&mut group, &format!("{short}/{stop}"), &camera);
        }
    }
    group.finish();
}

/// The same by the model of the lens.
fn models(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("lens/model");
    for (name, film) in LENSES {
        let short = name.split('.').next().unwrap_or(name);
        let real = camera(RealLens::new(lens(name), film, 35.0, Aim::Pupil, 1.0, 0.0));
        for fidelity in Fidelity::ALL {
            pictures(&mut group, &format!("{short}/{fidelity}"), &real.simulated(fidelity));
        }
    }
    group.finish();
}

fn camera(lens: RealLens) -> Camera {
    Camera {
        model: Model::Real(Box::new(lens)),
        film: [49.497; 2],
        world_from_camera: DAffine3::IDENTITY,
        imaging_ratio: 1.0,
        depth: [0.0, f64::INFINITY],
    }
}

/// How fast a camera makes valid rays.
fn pictures(group: &mut BenchmarkGroup<WallTime>, name: &str, camera: &Camera) {
    let mut stats = LensStats { blocked: vec![0; 64], ..LensStats::default() };
    let mut columns = Columns::default();
    // The share that comes through, to count valid rays by.
    let mut came = 0;
    picture(camera, &mut columns, &mut stats, |rays| came += rays);
    group.throughput(Throughput::Elements(came));
    group.bench_function(name, |bencher| {
        bencher.iter_custom(|count| {
            let mut time = Duration::ZERO;
            for _ in 0..count {
                let start = Instant::now();
                picture(camera, &mut columns, &mut stats, |rays| {
                    black_box(rays);
                });
                time += start.elapsed();
            }
            time
        });
    });
}

#[derive(Default)]
struct Columns {
    samples: SampleBatch,
    lens: LensColumns,
    rays: RayBatch,
}

/// All waves of a small picture with 32 samples a pixel.
fn picture(
    camera: &Camera,
    columns: &mut Columns,
    stats: &mut LensStats,
    mut done: impl FnMut(u64),
) {
    let frame = Frame { resolution: [96; 2], low: [0; 2], high: [96; 2] };
    let filter = Filter::default();
    for tile in frame.tiles() {
        let mut points = TileSampler::new(&tile, 0..32, 1, |low, high| {
            camera.sees(low.map(f64::from), high.map(f64::from), frame.resolution)
        });
        while sample(&mut points, &frame, &filter, camera.film, 0, &mut columns.samples) {
            camera.expose::<f32x8>(&columns.samples, &mut columns.lens, &mut columns.rays, stats);
            done(columns.rays.len as u64);
        }
    }
}

/// A train of weak menisci of one kind of surface, in air; the first carries the stop.
fn train(count: usize, shape: &Row) -> Prescription {
    let row = |i: usize| Row {
        thickness: 2.0,
        index: if i.is_multiple_of(2) && i + 1 < count { 1.5 } else { 1.0 },
        diameter: 40.0,
        stop: i == 0,
        ..shape.clone()
    };
    let rows = (0..count).map(row).collect();
    Prescription { name: "train".into(), rows, ..Prescription::default() }
}

/// Nanoseconds for a ray and a surface, by kind and by number of surfaces.
fn kinds(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("lens/ray-surface");
    let dgauss = lens("dgauss.50mm");
    let count = dgauss.rows.len();
    let bench = Bench::<f32x8>::new(&dgauss, 36.77, WAVE, 1.0);
    batches(&mut group, "dgauss", bench, WAVE * count);
    let sphere = Row { radius: 90.0, ..Row::default() };
    let even = vec![(4, 1e-7), (6, -1e-9), (8, 1e-12), (10, 1e-15)];
    let shapes = [
        ("sphere", sphere.clone()),
        ("plane", Row::default()),
        ("cylinder", Row { axis: Some(Axis::X), ..sphere.clone() }),
        ("conic", Row { conic: -1.3, ..sphere.clone() }),
        ("asphere", Row { conic: -1.3, asphere: even, ..sphere.clone() }),
        ("odd asphere", Row { asphere: vec![(3, 1e-7), (4, 1e-8), (5, -1e-9)], ..sphere.clone() }),
    ];
    for (name, shape) in shapes {
        let bench = Bench::<f32x8>::new(&train(12, &shape), 40.0, WAVE, 1.0);
        batches(&mut group, name, bench, WAVE * 12);
    }
    let bench = Bench::<f32x8>::new(&train(30, &sphere), 40.0, WAVE, 1.0);
    batches(&mut group, "30 spheres", bench, WAVE * 30);
    group.finish();
}

/// Rays a second by the size of a batch, by the number of rays and by threads.
fn growth(criterion: &mut Criterion) {
    let dgauss = lens("dgauss.50mm");
    let mut group = criterion.benchmark_group("lens/batch");
    for rays in [128, 256, 512, WAVE] {
        let bench = Bench::<f32x8>::new(&dgauss, 36.77, rays, 1.0);
        batches(&mut group, rays.to_string(), bench, rays);
    }
    group.finish();

    let mut group = criterion.benchmark_group("lens/rays");
    group.sample_size(10);
    for rays in [10_000u64, 1_000_000, 100_000_000] {
        let mut bench = Bench::<f32x8>::new(&dgauss, 36.77, WAVE, 1.0);
        let waves = rays.div_ceil(WAVE as u64);
        group.throughput(Throughput::Elements(waves * WAVE as u64));
        group.bench_function(format!("{rays:e}"), |bencher| {
            bencher.iter(|| (0..waves).for_each(|_| bench.trace()));
        });
    }
    group.finish();

    let mut group = criterion.benchmark_group("lens/threads");
    group.sample_size(20);
    for threads in [1, 2] {
        let waves = 2000;
        group.throughput(Throughput::Elements((waves * WAVE) as u64));
        group.bench_function(threads.to_string(), |bencher| {
            let mut benches: Vec<_> =
                (0..threads).map(|_| Bench::<f32x8>::new(&dgauss, 36.77, WAVE, 1.0)).collect();
            bencher.iter(|| {
                std::thread::scope(|scope| {
                    for bench in &mut benches {
                        scope.spawn(move || (0..waves / threads).for_each(|_| bench.trace()));
                    }
                });
            });
        });
    }
    group.finish();
}

criterion_group!(benches, precisions, valid, models, kinds, growth);
criterion_main!(benches);
