//! Whole pictures: film samples per second with a real lens, a thin lens and a pinhole, and of
//! eight lanes beside one.

use std::path::Path;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use petzval_lens::{LensModel, ThinLens};
use petzval_render::job::Job;
use petzval_render::plan::EffectSelection;
use petzval_render::prepare::{Changes, prepare};
use petzval_render::{Backend, RenderOptions, render};
use petzval_scene_formats::pbrt;

fn dgauss() -> Job {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/dgauss.pbrt");
    let description = pbrt::read(&scene).expect("a scene of the repository");
    // A crop without vignetting, so that every camera takes the same samples.
    let crop = Some([[100, 140], [200, 240]]);
    let changes = Changes { samples: Some(32), crop, ..Changes::default() };
    prepare(description, &changes).expect("a job").job
}

/// Replaces the lens by a thin lens of the same focal length, focus and f-number.
fn with_thin_lens(mut job: Job, radius: f64) -> Job {
    let LensModel::Real(lens) = &job.camera.model else { unreachable!("dgauss is a real lens") };
    let focal = lens.paraxial.focal_length;
    job.camera.film = job.camera.film.map(|side| side / focal);
    job.camera.model = LensModel::Thin(ThinLens { radius, focus: 3.88, middle: [0.0; 2] });
    job
}

/// A scene of the repository at a small size.
fn small(name: &str) -> Job {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenes/{name}.pbrt"));
    let description = pbrt::read(&scene).expect("a scene of the repository");
    let changes = Changes { samples: Some(16), resolution: Some([90, 60]), ..Changes::default() };
    let changes = Changes { effects: EffectSelection::None, ..changes };
    prepare(description, &changes).expect("a job").job
}

fn cameras(bench: &mut Criterion) {
    let real = dgauss();
    let jobs = [
        ("dgauss", real.clone(), Backend::Simd),
        ("thin", with_thin_lens(real.clone(), 0.0124), Backend::Simd),
        ("pinhole", with_thin_lens(real, 0.0), Backend::Simd),
    ];
    measure(bench, "render", jobs.map(|(name, job, backend)| (name.to_owned(), job, backend)));
}

fn lanes(bench: &mut Criterion) {
    let scenes = ["dgauss", "telephoto", "atelier", "night", "snowman"];
    let jobs = scenes.into_iter().flat_map(|name| {
        let job = small(name);
        let backends = [("simd", Backend::Simd), ("scalar", Backend::Scalar)];
        backends.map(|(lanes, backend)| (format!("{name}/{lanes}"), job.clone(), backend))
    });
    measure(bench, "lanes", jobs);
}

fn measure(
    bench: &mut Criterion,
    name: &str,
    jobs: impl IntoIterator<Item = (String, Job, Backend)>,
) {
    let mut group = bench.benchmark_group(name);
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
    targets = cameras, lanes
}
criterion_main!(benches);
