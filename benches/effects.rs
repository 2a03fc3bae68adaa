//! What effects cost: each beside the same without it.

use std::path::Path;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use petzval::film::{FilmSums, Frame};
use petzval::image::Picture;
use petzval::job::{Changes, prepare};
use petzval::render::{Exposed, Job};
use petzval::scene::pbrt;
use petzval::sensor::{Bayer, Sensor};
use petzval::stats::Stats;

const SIZE: [u32; 2] = [256, 256];

/// ns a pixel of the finished picture, on one thread.
fn sensor(bench: &mut Criterion) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let mut group = bench.benchmark_group("effect/sensor");
    group.throughput(Throughput::Elements(u64::from(SIZE[0] * SIZE[1])));

    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/dgauss.pbrt");
    let description = pbrt::read(&scene).expect("a scene of the repository");
    let job = prepare(description, &Changes::default()).expect("a job").0;
    let frame = Frame::whole(SIZE);
    let job = Job { frame, sensor: None, ..job };
    let exposed =
        Exposed { film: FilmSums::new(frame, false), features: None, stats: Stats::default() };
    group.bench_function("without", |bencher| bencher.iter(|| exposed.film.picture(16)));
    group.bench_function("off", |bencher| bencher.iter(|| exposed.picture(&job)));

    let on = Sensor { iso: 800.0, well: 54_000.0, read: 2.5, bits: 14, black: 512, bayer: None };
    let mosaic = Sensor { bayer: Some(Bayer::Rggb), ..on };
    for (name, sensor, value) in
        [("on", on, 0.18), ("on/dark", on, 5e-4), ("on/bayer", mosaic, 0.18)]
    {
        let size = SIZE.map(|n| n as usize);
        let picture = Picture { size, pixels: vec![[value; 3]; size[0] * size[1]] };
        group.bench_function(name, |bencher| {
            bencher.iter(|| pool.install(|| sensor.read_out(&picture, [0, 0], 0)));
        });
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20);
    targets = sensor
}
criterion_main!(benches);
