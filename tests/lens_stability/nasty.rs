//! Numbers that no ray has: nothing that is no number comes out, and every ray is counted.

use petzval::lanes::{Real, f32x8};
use petzval::lens::{LensRay, Surface, settle, trace, trace_one};
use petzval::rays::{LensBatch, WAVE};

use super::corpus::corpus;
use super::support::probe::Bench;

const NASTY: [f64; 18] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    0.0,
    -0.0,
    1e-45,
    -1e-45,
    1e-40,
    1e-20,
    -1e-20,
    1e10,
    -1e10,
    1e20,
    1e30,
    -1e30,
    3.4e38,
    -3.4e38,
    1e300,
];

/// An ordinary ray with one, two or three of its six numbers nasty.
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
    let mut batch = Box::<LensBatch<R::Scalar>>::default();
    for (i, ray) in rays.iter().enumerate() {
        let [x, y, z, tx, ty, tz] = ray.map(R::scalar);
        [batch.x[i], batch.y[i], batch.z[i]] = [x, y, z];
        [batch.tx[i], batch.ty[i], batch.tz[i]] = [tx, ty, tz];
        batch.weight[i] = R::scalar(1.0);
    }
    batch.resize::<R>(rays.len());
    // What is no number in x is blocked from the start.
    batch.living = rays.iter().filter(|ray| living(ray)).count();
    trace::<R>(&mut batch, surfaces, &mut blocked);
    let doubtful = batch.doubtful.clone();
    for (k, i) in doubtful.iter().enumerate() {
        assert!(!doubtful[..k].contains(i), "ray {i} is noted twice: {:?}", rays[*i as usize]);
    }
    let ends = blocked.iter().sum::<u64>() as usize;
    let out = (0..rays.len()).filter(|&i| !R::to_f64(batch.x[i]).is_nan()).count();
    assert_eq!(out + ends + doubtful.len(), batch.living, "counts");
    settle::<R>(&mut batch, &bench.double, &mut blocked, |i| {
        let [x, y, z, tx, ty, tz] = rays[i].map(R::scalar).map(R::to_f64);
        LensRay::new([x, y, z], [tx, ty, tz])
    });
    let out = (0..rays.len()).map(|i| {
        let [x, y, z] = [batch.x[i], batch.y[i], batch.z[i]].map(R::to_f64);
        let [tx, ty, tz] = [batch.tx[i], batch.ty[i], batch.tz[i]].map(R::to_f64);
        (!x.is_nan()).then_some([x, y, z, tx, ty, tz])
    });
    (out.collect(), doubtful)
}

/// Directions have the length of the index; what is finite and so long that its square is
/// infinite in f32 is no ray, and nothing is promised of it.
fn overflows(ray: &[f64; 6]) -> bool {
    let long = |v: &f64| v.is_finite() && v.abs() > 1e18;
    (*ray)[3..].iter().any(long) && (*ray)[3..].iter().all(|v| (*v as f32).is_finite())
}

#[test]
fn no_nan_and_no_infinity_comes_out() {
    for case in corpus() {
        let bench = Bench::new(&case.lens, case.film);
        for wave in rays(case.film).chunks(WAVE) {
            let single = |ray: &[f64; 6]| !(ray[0] as f32).is_nan();
            let (one, doubtful) = traced::<f32>(&bench, wave, &bench.single, &single);
            let (eight, doubtful8) = traced::<f32x8>(&bench, wave, &bench.single, &single);
            let (double, _) = traced::<f64>(&bench, wave, &bench.double, &|ray| !ray[0].is_nan());
            assert_eq!(doubtful, doubtful8, "{}", case.name);
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
