//! Rays per second of the lens report, next to the kernels that trace them.
//!
//! A report traces each ray in f64 with its optical path and its place in the stop, finds the pupils
//! first, and divides the cells at their edges. The kernel alone traces rays that all pass.
//!
//!     cargo bench --bench lens_report

use std::hint::black_box;
use std::path::Path;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use petzval_base::lanes::f32x8;
use petzval_base::rays::WAVE_SIZE;
use petzval_lens::Prescription;
use petzval_lens_formats::read;
use petzval_optics::{ConditionChoices, ImageQuality, ImagingConditions, ImagingGrid};
use petzval_tools::bench::lens_wave::LensWave;

/// Lenses with the distance of their film (mm) and its half diagonal (mm). The first has 12 rows,
/// the second 15.
const LENSES: [(&str, f64, f64); 2] =
    [("dgauss.50mm.dat", 36.77, 21.6), ("wide.22mm.dat", 14.54, 16.0)];
const FIELDS: usize = 21;
const PUPIL: usize = 64;

fn lens(name: &str) -> Prescription {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("lenses").join(name);
    read(&file).expect("a lens of the repository")
}

/// Measures the traced grids of a report on one thread and on two, and the kernels.
fn report(criterion: &mut Criterion) {
    for (name, film, height) in LENSES {
        let lens = lens(name);
        let mut group = criterion.benchmark_group(format!("lens_report/{name}"));
        group.sample_size(10);
        let choices = ConditionChoices {
            image_height: Some(height),
            film_distance: Some(film),
            ..Default::default()
        };
        let conditions = ImagingConditions::new(&lens, choices).expect("an image");
        for threads in [1, 2] {
            let grid = ImagingGrid { fields: FIELDS, pupil: PUPIL, threads };
            let trace = || ImageQuality::new(&lens, conditions.clone(), grid).expect("its glasses");
            // Only rays that reach the film count, not those that find the pupils.
            group.throughput(Throughput::Elements(trace().rays() as u64));
            group.bench_function(format!("grids, {threads} threads"), |bencher| {
                bencher.iter(|| black_box(trace()));
            });
        }
        group.throughput(Throughput::Elements(WAVE_SIZE as u64));
        let mut wave = LensWave::<f64>::new(&lens, film, WAVE_SIZE, 1.0);
        group.bench_function("kernel, f64", |bencher| bencher.iter(|| wave.trace()));
        let mut wave = LensWave::<f32x8>::new(&lens, film, WAVE_SIZE, 1.0);
        group.bench_function("kernel, f32x8", |bencher| bencher.iter(|| wave.trace()));
        group.finish();
    }
}

criterion_group!(benches, report);
criterion_main!(benches);
