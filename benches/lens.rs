//! The lens stage: rays a second, one lane beside eight in the same run.

use std::hint::black_box;
use std::path::Path;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use petzval::lanes::{Real, f32x8};
use petzval::lens::{From, Prescription, read, sequence, trace};
use petzval::rays::{LensBatch, WAVE};

fn lens(name: &str) -> Prescription {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("lenses");
    read(&folder.join(name)).expect("a lens of the repository")
}

/// A wave of rays from points near the axis that all come through.
fn wave<R: Real>(film: f64) -> Box<LensBatch<R::Scalar>> {
    let mut batch = Box::<LensBatch<R::Scalar>>::default();
    for i in 0..WAVE {
        let t = i as f64 / WAVE as f64;
        let (sin, cos) = (t * 40.0).sin_cos();
        let start = [2.0 * t * cos, 2.0 * t * sin, 0.0];
        let d = [sin - start[0], cos - start[1], film];
        let length = d.iter().map(|v| v * v).sum::<f64>().sqrt();
        [batch.x[i], batch.y[i], batch.z[i]] = start.map(R::scalar);
        [batch.tx[i], batch.ty[i], batch.tz[i]] = d.map(|v| R::scalar(v / length));
    }
    batch.resize::<R>(WAVE);
    batch
}

fn traces<R: Real>(bench: &mut Criterion, name: &str, film: f64, lanes: &str) {
    let surfaces = sequence::<R>(&lens(&format!("{name}.dat")), From::Film(film));
    let fresh = wave::<R>(film);
    let mut batch = fresh.clone();
    let mut blocked = vec![0; surfaces.len()];
    trace::<R>(&mut batch, &surfaces, &mut blocked);
    assert_eq!(blocked.iter().sum::<u64>(), 0, "the bench means rays that come through");

    let short = name.split('.').next().unwrap_or(name);
    let mut group = bench.benchmark_group("lens/trace");
    group.throughput(Throughput::Elements(WAVE as u64));
    group.bench_function(format!("{short}/{lanes}"), |bencher| {
        bencher.iter(|| {
            // A traced wave cannot be traced again; copying it is a tenth of the work.
            batch.clone_from(&fresh);
            trace::<R>(black_box(&mut batch), &surfaces, &mut blocked);
        });
    });
    group.finish();
}

fn trace_benches(bench: &mut Criterion) {
    for (name, film) in [("dgauss.50mm", 36.77), ("wide.22mm", 14.54)] {
        traces::<f32>(bench, name, film, "scalar");
        traces::<f32x8>(bench, name, film, "f32x8");
        traces::<f64>(bench, name, film, "f64");
    }
}

criterion_group!(benches, trace_benches);
criterion_main!(benches);
