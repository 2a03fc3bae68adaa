//! What effects of the lens cost: each off and on beside each other in the same run.

use std::hint::black_box;
use std::path::Path;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use petzval::lanes::f32x8;
use petzval::lens::{Aim, Coating, From, RealLens, Surface, read, sequence, trace, trace_lossy};
use petzval::rays::{LensBatch, WAVE};

/// The double Gauss of the course and the film distance of its scene, mm.
const LENS: (&str, f64) = ("lenses/dgauss.50mm.dat", 36.77);

type Trace = fn(&mut LensBatch<f32>, &[Surface<f32>], &mut [u64]);

/// Rays of a wave from near the axis, all of which come through.
fn wave() -> Box<LensBatch<f32>> {
    let mut batch = Box::<LensBatch<f32>>::default();
    for i in 0..WAVE {
        let share = i as f32 / WAVE as f32;
        let (sin, cos) = (40.0 * share).sin_cos();
        let [x, y] = [2.0 * share * cos, 2.0 * share * sin];
        let d = [sin - x, cos - y, LENS.1 as f32];
        let length = d.iter().map(|v| v * v).sum::<f32>().sqrt();
        (batch.x[i], batch.y[i]) = (x, y);
        [batch.tx[i], batch.ty[i], batch.tz[i]] = d.map(|v| v / length);
        batch.weight[i] = 1.0;
    }
    batch.resize::<f32x8>(WAVE);
    batch
}

/// Losses of surfaces: the trace of a wave without them, and with each coating.
fn fresnel(criterion: &mut Criterion) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let bare = read(&folder.join(LENS.0)).expect("a lens of the repository");
    let mut group = criterion.benchmark_group("effect/fresnel");
    group.throughput(Throughput::Elements(WAVE as u64));
    let fresh = wave();
    let cases: [(&str, Coating, Trace); 4] = [
        ("off", Coating::Bare, trace::<f32x8>),
        ("on", Coating::Bare, trace_lossy::<f32x8>),
        ("on, broadband", Coating::Broadband, trace_lossy::<f32x8>),
        ("on, mgf2", Coating::Mgf2, trace_lossy::<f32x8>),
    ];
    for (name, coating, trace) in cases {
        let mut lens = bare.clone();
        lens.coat(coating);
        let surfaces = sequence::<f32>(&lens, From::Film(LENS.1));
        let mut blocked = vec![0; lens.rows.len()];
        let mut batch = fresh.clone();
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                // A traced wave cannot be traced again.
                (*batch).clone_from(&fresh);
                trace(black_box(&mut batch), &surfaces, &mut blocked);
            });
        });
        assert_eq!(blocked, vec![0; lens.rows.len()], "the bench means rays that pass");
    }
    // What it takes to know the loss: 33 film points.
    let lens = RealLens::new(bare, LENS.1, 21.6, Aim::Pupil, 1.0, 0.0);
    group.throughput(Throughput::Elements(1));
    group.bench_function("estimate", |bencher| bencher.iter(|| lens.throughput(21.6)));
    group.finish();
}

criterion_group!(benches, fresnel);
criterion_main!(benches);
