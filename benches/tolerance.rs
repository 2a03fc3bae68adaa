//! Trials of a tolerance analysis per second: the double Gauss with 469 rays a field.

use std::hint::black_box;
use std::path::Path;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use petzval_lens_formats::read;
use petzval_optics::{
    ConditionChoices, DeviationShape, ImagingConditions, Refocus, ToleranceAnalysis,
    ToleranceGrade, ToleranceSettings,
};

/// Trials of a measurement.
const TRIALS: u64 = 200;

/// Measures trials with three fields and with five, on one thread and on two.
fn trials(criterion: &mut Criterion) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("lenses/dgauss.50mm.dat");
    let lens = read(&file).expect("a lens of the repository");
    let mut group = criterion.benchmark_group("tolerance/trials");
    group.throughput(Throughput::Elements(TRIALS)).sample_size(10);
    for (name, shares) in
        [("3 fields", vec![0.0, 0.7, 1.0]), ("5 fields", vec![0.0, 0.7, 1.0, -0.7, -1.0])]
    {
        for threads in [1, 2] {
            let settings = ToleranceSettings {
                limits: ToleranceGrade::Precision.limits(),
                shape: DeviationShape::Normal,
                refocus: Refocus::Fields,
                shares: shares.clone(),
                rings: 12,
                frequency: 30.0,
                seed: 1,
                threads,
            };
            let choices = ConditionChoices { image_height: Some(18.0), ..Default::default() };
            let conditions = ImagingConditions::new(&lens, choices).expect("an image");
            let analysis =
                ToleranceAnalysis::new(&lens, conditions, settings).expect("light at all fields");
            group.bench_function(format!("{name}, {threads} threads"), |bencher| {
                bencher.iter(|| black_box(&analysis).trials(TRIALS));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, trials);
criterion_main!(benches);
