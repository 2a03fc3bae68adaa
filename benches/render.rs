//! Whole pictures: film samples per second with a real lens, a thin lens and a pinhole.

use std::path::Path;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use petzval::job::Job;
use petzval::lens::{LensModel, ThinLens};
use petzval::prepare::{Changes, prepare};
use petzval::render::{Backend, RenderOptions, render};
use petzval::scene::pbrt;

fn dgauss() -> Job {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/dgauss.pbrt");
    let description = pbrt::read(&scene).expect("a scene of the repository");
    // A crop without vignetting, so that every camera takes the same samples.
    let crop = Some([[100, 140], [200, 240]]);
    let changes = Changes { samples: Some(32), crop, ..Changes::default() };
    prepare(description, &changes).expect("a job").0
}

/// Replaces the lens by a thin lens of the same focal length, focus and f-number.
fn with_thin_lens(mut job: Job, radius: f64) -> Job {
    let LensModel::Real(lens) = &job.camera.model else { unreachable!("dgauss is a real lens") };
    let focal = lens.paraxial.focal_length;
    job.camera.film = job.camera.film.map(|side| side / focal);
    job.camera.model = LensModel::Thin(ThinLens { radius, focus: 3.88, middle: [0.0; 2] });
    job
}

fn pictures(bench: &mut Criterion) {
    let real = dgauss();
    let jobs = [
        ("dgauss/scalar", real.clone(), Backend::Scalar),
        ("dgauss", real.clone(), Backend::Simd),
        ("thin", with_thin_lens(real.clone(), 0.0124), Backend::Simd),
        ("pinhole", with_thin_lens(real, 0.0), Backend::Simd),
    ];
    let mut group = bench.benchmark_group("render");
    for (name, job, backend) in jobs {
        let [width, height] = job.frame.size();
        let samples = u64::from(width * height * (job.samples.end - job.samples.start));
        group.throughput(Throughput::Elements(samples));
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                render(&job, RenderOptions { backend, threads: 1, ..RenderOptions::default() })
                    .expect("a picture")
            });
        });
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20);
    targets = pictures
}
criterion_main!(benches);
