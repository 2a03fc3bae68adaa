//! Lens stage: rays per second of all variants in the same run.

use std::path::Path;

use criterion::criterion_main;
use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, BenchmarkId, Criterion, Throughput, criterion_group};
use glam::DAffine3;
use petzval_base::lanes::{Real, f32x8};
use petzval_base::rays::WAVE_SIZE;
use petzval_lens::{
    Camera, Fidelity, LensModel, LensRay, Prescription, PupilSampling, RealLens, RealRayFocus, Row,
    Side, TransverseAxis, sequence, trace_one,
};
use petzval_lens_formats::read;
use petzval_render::film::Frame;
use petzval_tools::bench::launch::Launch;
use petzval_tools::bench::lens_wave::{LensWave, starts};
use petzval_tools::bench::textbook;

/// The course's lenses with the film distances of their scenes (mm).
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
    mut bench: LensWave<R>,
    elements: usize,
) {
    group.throughput(Throughput::Elements(elements as u64));
    group.bench_function(id.into().0, |bencher| bencher.iter(|| bench.trace()));
}

/// Name of a benchmark, with or without a parameter.
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

/// Measures the kernels with eight lanes, one lane and one lane of f64, ray by ray, and a textbook tracer.
fn precisions(criterion: &mut Criterion) {
    for (name, film) in [("dgauss.50mm", 36.77), ("wide.22mm", 14.54)] {
        let short = name.split('.').next().unwrap_or(name);
        let lens = lens(name);
        let mut group = criterion.benchmark_group(format!("lens/trace/{short}"));
        batches(
            &mut group,
            "f32x8",
            LensWave::<f32x8>::new(&lens, film, WAVE_SIZE, 1.0),
            WAVE_SIZE,
        );
        // The compiler vectorises this loop by itself.
        batches(
            &mut group,
            "f32, one lane",
            LensWave::<f32>::new(&lens, film, WAVE_SIZE, 1.0),
            WAVE_SIZE,
        );
        batches(&mut group, "f64", LensWave::<f64>::new(&lens, film, WAVE_SIZE, 1.0), WAVE_SIZE);

        let surfaces = sequence::<f32>(&lens, Side::Film(film));
        let rays: Vec<LensRay<f32>> = starts(WAVE_SIZE, film, 1.0)
            .iter()
            .map(|[p, t]| LensRay::new(p.map(|v| v as f32), t.map(|v| v as f32)))
            .collect();
        group.bench_function("f32, a ray at a time", |bencher| {
            bencher.iter(|| {
                rays.iter().filter(|ray| trace_one::<f32>(**ray, &surfaces).is_ok()).count()
            });
        });
        let table = textbook::table(&lens, film);
        let film_rays: Vec<textbook::TextbookRay> =
            rays.iter().map(|ray| textbook::TextbookRay::leaving(ray.p, ray.t)).collect();
        assert!(film_rays.iter().all(|ray| textbook::trace(&table, *ray).is_some()));
        group.bench_function("textbook", |bencher| {
            bencher.iter(|| {
                film_rays.iter().filter(|ray| textbook::trace(&table, **ray).is_some()).count()
            });
        });
        group.finish();
    }
}

/// Measures valid rays of a whole picture, from film points to rays in the world: sample, aim, trace,
/// compact.
fn valid(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("lens/valid");
    for (name, film) in LENSES {
        let short = name.split('.').next().unwrap_or(name);
        for stop in ["open", "f8"] {
            let mut lens = lens(name);
            if stop == "f8" {
                let open = RealRayFocus::new(&lens).f_number().expect("the lens forms an image");
                lens.stop_down(lens.rows[lens.stop()].diameter * open / 8.0);
            }
            let lens = RealLens::new(lens, film, 35.0, PupilSampling::Pupil, 1.0, 0.0);
            let camera = camera(lens);
            pictures(&mut group, &format!("{short}/{stop}"), &camera);
        }
    }
    group.finish();
}

/// Measures valid rays of a whole picture by the model of the lens.
fn models(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("lens/model");
    for (name, film) in LENSES {
        let short = name.split('.').next().unwrap_or(name);
        let real = camera(RealLens::new(lens(name), film, 35.0, PupilSampling::Pupil, 1.0, 0.0));
        for fidelity in Fidelity::ALL {
            pictures(&mut group, &format!("{short}/{fidelity}"), &real.with_fidelity(fidelity));
        }
    }
    group.finish();
}

fn camera(lens: RealLens) -> Camera {
    Camera {
        model: LensModel::Real(Box::new(lens)),
        film: [49.497; 2],
        world_from_camera: DAffine3::IDENTITY,
        imaging_ratio: 1.0,
        depth: [0.0, f64::INFINITY],
    }
}

/// Measures valid rays per second of a small picture with 32 samples per pixel.
fn pictures(group: &mut BenchmarkGroup<WallTime>, name: &str, camera: &Camera) {
    let frame = Frame { resolution: [96; 2], low: [0; 2], high: [96; 2] };
    let mut launch = Launch::default();
    // Only rays that leave the lens count.
    let valid = launch.camera(camera, &frame, 0..32);
    group.throughput(Throughput::Elements(valid));
    group.bench_function(name, |bencher| {
        bencher.iter(|| launch.camera(camera, &frame, 0..32));
    });
}

/// Returns a series of weak menisci of one kind of surface in air. The first surface is the stop.
fn train(count: usize, shape: &Row) -> Prescription {
    let row = |i: usize| Row {
        thickness: 2.0,
        index: if i.is_multiple_of(2) && i + 1 < count { 1.5 } else { 1.0 },
        diameter: 40.0,
        stop: i == 0,
        ..shape.clone()
    };
    let rows = (0..count).map(row).collect();
    Prescription::new("train", rows).expect("one stop")
}

/// Measures the time per ray and surface by kind and number of surfaces.
fn kinds(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("lens/ray-surface");
    let dgauss = lens("dgauss.50mm");
    let count = dgauss.rows.len();
    let bench = LensWave::<f32x8>::new(&dgauss, 36.77, WAVE_SIZE, 1.0);
    batches(&mut group, "dgauss", bench, WAVE_SIZE * count);
    let sphere = Row { radius: 90.0, ..Row::default() };
    let even = vec![(4, 1e-7), (6, -1e-9), (8, 1e-12), (10, 1e-15)];
    let shapes = [
        ("sphere", sphere.clone()),
        ("plane", Row::default()),
        ("cylinder", Row { axis: Some(TransverseAxis::X), ..sphere.clone() }),
        ("conic", Row { conic: -1.3, ..sphere.clone() }),
        ("asphere", Row { conic: -1.3, asphere: even, ..sphere.clone() }),
        ("odd asphere", Row { asphere: vec![(3, 1e-7), (4, 1e-8), (5, -1e-9)], ..sphere.clone() }),
    ];
    for (name, shape) in shapes {
        let bench = LensWave::<f32x8>::new(&train(12, &shape), 40.0, WAVE_SIZE, 1.0);
        batches(&mut group, name, bench, WAVE_SIZE * 12);
    }
    let bench = LensWave::<f32x8>::new(&train(30, &sphere), 40.0, WAVE_SIZE, 1.0);
    batches(&mut group, "30 spheres", bench, WAVE_SIZE * 30);
    group.finish();
}

/// Measures rays per second by batch size, number of rays and threads.
fn growth(criterion: &mut Criterion) {
    let dgauss = lens("dgauss.50mm");
    let mut group = criterion.benchmark_group("lens/batch");
    for rays in [128, 256, 512, WAVE_SIZE] {
        let bench = LensWave::<f32x8>::new(&dgauss, 36.77, rays, 1.0);
        batches(&mut group, rays.to_string(), bench, rays);
    }
    group.finish();

    let mut group = criterion.benchmark_group("lens/rays");
    group.sample_size(10);
    for rays in [10_000u64, 1_000_000, 100_000_000] {
        let mut bench = LensWave::<f32x8>::new(&dgauss, 36.77, WAVE_SIZE, 1.0);
        let waves = rays.div_ceil(WAVE_SIZE as u64);
        group.throughput(Throughput::Elements(waves * WAVE_SIZE as u64));
        group.bench_function(format!("{rays:e}"), |bencher| {
            bencher.iter(|| (0..waves).for_each(|_| bench.trace()));
        });
    }
    group.finish();

    let mut group = criterion.benchmark_group("lens/threads");
    group.sample_size(20);
    for threads in [1, 2] {
        let waves = 2000;
        group.throughput(Throughput::Elements((waves * WAVE_SIZE) as u64));
        group.bench_function(threads.to_string(), |bencher| {
            let mut benches: Vec<_> = (0..threads)
                .map(|_| LensWave::<f32x8>::new(&dgauss, 36.77, WAVE_SIZE, 1.0))
                .collect();
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
