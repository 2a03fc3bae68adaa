//! Rays of NaN, infinite, zero and huge numbers: the tracer returns finite rays only and counts all.

use petzval_base::lanes::{Real, f32x8};
use petzval_base::rays::WAVE_SIZE;
use petzval_lens::{LensRay, Surface, retrace_in_f64, trace, trace_one};
use petzval_tools::bench::lens_wave::batch as lens_batch;

use super::corpus::corpus;
use crate::support::nasty::NASTY;
use crate::support::probe::Bench;

/// Returns an ordinary ray with one, two, three or all of its six numbers replaced by nasty ones.
fn rays(film: f64) -> Vec<[f64; 6]> {
    let ordinary = [0.3, -0.2, 0.0, 0.05, -0.1, 0.99];
    let mut rays = vec![[0.0; 6], [0.0, 0.0, film, 0.0, 0.0, 0.0]];
    for a in 0..6 {
        for value in NASTY {
            let mut ray = ordinary;
            ray[a] = value;
            rays.push(ray);
            for b in 0..a {
                for second in NASTY {
                    ray[b] = second;
                    rays.push(ray);
                }
                ray[b] = ordinary[b];
            }
        }
    }
    for value in NASTY {
        rays.push([value; 6]);
        rays.push([0.0, 0.0, 0.0, value, value, value]);
        rays.push([value, value, value, 0.0, 0.0, 1.0]);
    }
    rays
}

fn traced<R: Real>(
    bench: &Bench,
    rays: &[[f64; 6]],
    surfaces: &[Surface<R::Scalar>],
    living: &dyn Fn(&[f64; 6]) -> bool,
) -> (Vec<Option<[f64; 6]>>, Vec<u32>) {
    let mut blocked = vec![0; bench.lens.rows.len()];
    let starts: Vec<_> = rays.iter().map(|&[x, y, z, a, b, c]| [[x, y, z], [a, b, c]]).collect();
    let mut batch = lens_batch::<R>(&starts);
    // A ray whose x is NaN is blocked from the start.
    batch.live = rays.iter().filter(|ray| living(ray)).count();
    trace::<R>(&mut batch, surfaces, &mut blocked);
    let needs_f64 = batch.needs_f64.clone();
    for (k, i) in needs_f64.iter().enumerate() {
        assert!(!needs_f64[..k].contains(i), "ray {i} is listed twice: {:?}", rays[*i as usize]);
    }
    let ends = blocked.iter().sum::<u64>() as usize;
    let out = (0..rays.len()).filter(|&i| !R::to_f64(batch.x[i]).is_nan()).count();
    assert_eq!(out + ends + needs_f64.len(), batch.live, "counts");
    retrace_in_f64::<R>(&mut batch, &bench.double, &mut blocked, |i| {
        let [x, y, z, tx, ty, tz] = rays[i].map(R::from_f64).map(R::to_f64);
        LensRay::new([x, y, z], [tx, ty, tz])
    });
    let out = (0..rays.len()).map(|i| {
        let [x, y, z] = [batch.x[i], batch.y[i], batch.z[i]].map(R::to_f64);
        let [tx, ty, tz] = [batch.tx[i], batch.ty[i], batch.tz[i]].map(R::to_f64);
        (!x.is_nan()).then_some([x, y, z, tx, ty, tz])
    });
    (out.collect(), needs_f64)
}

/// Returns whether a direction, whose length should be the refractive index, has a square that is
/// infinite in f32. The tracer promises nothing for such a ray.
fn overflows(ray: &[f64; 6]) -> bool {
    let long = |v: &f64| v.is_finite() && v.abs() > 1e18;
    (*ray)[3..].iter().any(long) && (*ray)[3..].iter().all(|v| (*v as f32).is_finite())
}

#[test]
fn neither_nan_nor_infinity_leaves_a_lens() {
    for case in corpus() {
        let bench = Bench::new(&case.lens, case.film);
        for wave in rays(case.film).chunks(WAVE_SIZE) {
            let single = |ray: &[f64; 6]| !(ray[0] as f32).is_nan();
            let (one, needs_f64) = traced::<f32>(&bench, wave, &bench.single, &single);
            let (eight, needs_f64_8) = traced::<f32x8>(&bench, wave, &bench.single, &single);
            let (double, _) = traced::<f64>(&bench, wave, &bench.double, &|ray| !ray[0].is_nan());
            assert_eq!(needs_f64, needs_f64_8, "{}", case.name);
            for i in 0..wave.len() {
                assert_eq!(
                    one[i].map(|v| v.map(f64::to_bits)),
                    eight[i].map(|v| v.map(f64::to_bits)),
                    "{} {:?}",
                    case.name,
                    wave[i]
                );
                for out in [one[i], double[i]].into_iter().flatten() {
                    assert!(
                        overflows(&wave[i]) || out.iter().all(|v| v.is_finite()),
                        "{}: {:?} gives {out:?}",
                        case.name,
                        wave[i]
                    );
                }
                let [x, y, z, tx, ty, tz] = wave[i];
                let alone = trace_one::<f64>(LensRay::new([x, y, z], [tx, ty, tz]), &bench.double);
                if let Ok(ray) = alone {
                    let all = [ray.p, ray.t].concat();
                    assert!(
                        all.iter().all(|v| v.is_finite()),
                        "{}: {:?} gives {all:?}",
                        case.name,
                        wave[i]
                    );
                }
            }
        }
    }
}
