//! Identities that hold exactly or to a rounding.

use petzval_base::lanes::{Real, f32x8};
use petzval_lens::{
    BlockReason, Blocked, LensRay, Prescription, Row, Rows, Side, TransverseAxis, sequence,
    trace_one,
};

use super::corpus::{asphere, corpus, wavy_asphere};
use crate::support::oracle::unit;
use crate::support::probe::{Bench, Start, lens_of_rows, random_rays, start};
use crate::support::row;

fn exit_ray<R: Real>(
    lens: &Prescription,
    film: f64,
    [p, d]: Start,
) -> Result<[[f64; 3]; 2], Blocked> {
    let index = lens.rear().index;
    let splat = |v: f64| R::splat(R::from_f64(v));
    let ray = LensRay::new(p.map(splat), unit(d).map(|v| splat(v * index)));
    let number = |v: R| {
        let mut lanes = [R::from_f64(0.0); 8];
        v.store(&mut lanes);
        R::to_f64(lanes[0])
    };
    let ray = trace_one::<R>(ray, &sequence::<R>(lens, Side::Film(film)))?;
    Ok([ray.p.map(number), ray.t.map(number)])
}

#[test]
fn a_ray_along_the_axis_stays_on_it() {
    for case in corpus() {
        let ray = [[0.0; 3], [0.0, 0.0, 1.0]];
        for (name, out) in [
            ("f32", exit_ray::<f32>(&case.lens, case.film, ray)),
            ("f32x8", exit_ray::<f32x8>(&case.lens, case.film, ray)),
            ("f64", exit_ray::<f64>(&case.lens, case.film, ray)),
        ] {
            let obstructed = case.lens.rows.iter().any(|row| row.obstruction > 0.0);
            match out {
                Ok([p, t]) => {
                    assert!(!obstructed, "{} {name}", case.name);
                    assert_eq!([p[0], p[1], t[0], t[1]], [0.0; 4], "{} {name}", case.name);
                    assert!(
                        p[2].abs() < 1e-6 * case.film.max(10.0) && t[2] > 0.999_999,
                        "{} {name}",
                        case.name
                    );
                }
                // All rays of this hyperboloid need f64.
                Err(_) if case.name.contains("-10000") && name != "f64" => {}
                Err(end) => assert!(obstructed, "{} {name}: {end:?}", case.name),
            }
        }
    }
}

#[test]
fn surfaces_between_equal_indices_do_not_refract() {
    let kinds = [
        row(5.0, 1.0, 1.0, 9.0),
        row(-5.0, 1.0, 1.0, 9.0),
        Row { conic: -1.0, ..row(-7.0, 1.0, 1.0, 20.0) },
        Row { conic: 2.0, ..row(8.0, 1.0, 1.0, 8.0) },
        Row { axis: Some(TransverseAxis::X), ..row(6.0, 1.0, 1.0, 11.0) },
        Row { axis: Some(TransverseAxis::Y), ..row(-6.0, 1.0, 1.0, 11.0) },
        wavy_asphere(1.0, 1.0),
        asphere(row(9.0, 1.0, 1.0, 8.0), &[(3, 4e-3)]),
        row(f64::INFINITY, 1.0, 1.0, 20.0),
    ];
    for index in [1.0, 1.33, 2.2] {
        for kind in &kinds {
            let front = row(f64::INFINITY, 3.0, index, 1e4);
            let lens = lens_of_rows(vec![front, Row { index, ..kind.clone() }]);
            let mut through = 0;
            for ray in random_rays(9.0, 6.0, 6.0, 3000, 5) {
                fn bent<R: Real>(lens: &Prescription, index: f64, [p, d]: Start) -> Option<bool> {
                    let splat = |v: f64| R::splat(R::from_f64(v));
                    let before = unit(d).map(|v| splat(v * index));
                    let surfaces = sequence::<R>(lens, Side::Film(9.0));
                    let ray = LensRay::new(p.map(splat), before);
                    let ray = trace_one::<R>(ray, &surfaces[..1]).ok()?;
                    Some((0..3).any(|i| R::bits(ray.t[i].equals(before[i])) & 1 == 0))
                }
                for bent in [bent::<f32>(&lens, index, ray), bent::<f64>(&lens, index, ray)] {
                    assert_ne!(bent, Some(true), "{kind:?} in {index} bends {ray:?}");
                    through += usize::from(bent == Some(false));
                }
            }
            assert!(through > 500, "{kind:?}: {through}");
        }
    }
}

/// Scales a lens. The coefficient of power p has the unit mm^(1 - p).
fn scaled(lens: &Prescription, by: f64) -> Prescription {
    let mut lens = lens.clone();
    for row in &mut lens.rows {
        row.radius *= by;
        row.thickness *= by;
        row.diameter *= by;
        row.obstruction *= by;
        for (power, a) in &mut row.asphere {
            *a *= by.powi(1 - *power as i32);
        }
    }
    lens
}

#[test]
fn a_lens_in_metres_is_the_same_lens() {
    for case in corpus() {
        let bench = Bench::new(&case.lens, case.film);
        let rays = random_rays(case.ahead, case.from[0], case.from[1], 300, 11);
        for by in [1e3, 1e-3] {
            let lens = scaled(&case.lens, by);
            let other = Bench::new(&lens, case.film * by);
            for &[p, d] in &rays {
                let outcome = bench.outcome([p, d]);
                let ours = bench.trace_one([p, d]);
                let theirs = other.trace_one([p.map(|v| v * by), d]);
                match (ours, theirs) {
                    (Ok(a), Ok(b)) => {
                        // Roundings, and their square root if the ray grazes.
                        let bound = if case.name.contains("-10000") { 1e-9 } else { 1e-11 };
                        let bound = bound / outcome.cosine.max(1e-6);
                        for i in 0..3 {
                            let reach = case.film + 10.0;
                            let (dp, dd) = ((a.p[i] - b.p[i] / by) / reach, a.d[i] - b.d[i]);
                            assert!(
                                dp.abs() < bound && dd.abs() < bound,
                                "{} {a:?} {b:?}",
                                case.name
                            );
                        }
                    }
                    (Err(a), Err(b)) if a == b => {}
                    _ => assert!(
                        outcome.rim < case.rims[1].max(1e-9) || outcome.cosine < 1e-6,
                        "{} times {by}: {ours:?} {theirs:?} {:?} {outcome:?}",
                        case.name,
                        [p, d]
                    ),
                }
            }
        }
    }
}

/// Returns the lens turned around.
fn reversed(lens: &Prescription) -> Prescription {
    let count = lens.rows.len();
    let rows = (0..count).rev().map(|i| Row {
        radius: -lens.rows[i].radius,
        asphere: lens.rows[i].asphere.iter().map(|&(p, a)| (p, -a)).collect(),
        thickness: if i > 0 { lens.rows[i - 1].thickness } else { 0.0 },
        index: lens.index_before(i),
        ..lens.rows[i].clone()
    });
    Prescription { rows: Rows::new(rows.collect()).expect("one stop"), ..lens.clone() }
}

#[test]
fn tracing_from_the_scene_equals_tracing_the_reversed_lens_from_the_film() {
    for case in corpus().iter().filter(|case| case.lens.rear().index == 1.0) {
        let turned = reversed(&case.lens);
        let last = turned.rows.len() - 1;
        let one = sequence::<f64>(&turned, Side::Scene(case.film));
        let other = sequence::<f64>(&case.lens, Side::Film(case.film));
        for [p, d] in random_rays(case.ahead, case.from[0], case.from[1], 500, 13) {
            let ray = LensRay::new(p, unit(d));
            match (trace_one::<f64>(ray, &one), trace_one::<f64>(ray, &other)) {
                (Ok(a), Ok(b)) => assert!(a.p == b.p && a.t == b.t, "{}", case.name),
                (Err(a), Err(b)) => {
                    assert_eq!((a.row, a.reason), (last - b.row, b.reason), "{}", case.name);
                }
                (a, b) => panic!("{}: {a:?} {b:?}", case.name),
            }
        }
    }
}

#[test]
fn a_conic_constant_near_0_gives_a_sphere_and_zero_coefficients_a_conic() {
    let close = |a: &[Row], b: &[Row], film: f64| {
        let (a, b) = (lens_of_rows(a.to_vec()), lens_of_rows(b.to_vec()));
        let (one, other) = (Bench::new(&a, film), Bench::new(&b, film));
        let mut both = 0;
        for ray in random_rays(film, 8.0, 8.0, 4000, 17) {
            let outcome = one.outcome(ray);
            match (one.trace_one(ray), other.trace_one(ray)) {
                (Ok(a), Ok(b)) => {
                    both += 1;
                    let bound = 1e-10 / outcome.cosine.max(1e-6);
                    let off = (0..3).map(|i| (a.p[i] - b.p[i]).abs().max((a.d[i] - b.d[i]).abs()));
                    assert!(off.fold(0.0, f64::max) < bound, "{ray:?}: {a:?} {b:?}");
                }
                (Err(_), Err(_)) => {}
                (a, b) => assert!(outcome.rim < 1e-9, "{ray:?}: {a:?} {b:?}"),
            }
        }
        assert!(both > 300, "{both}");
    };
    for radius in [9.0, -9.0] {
        let ball = [row(radius, 3.0, 1.5, 14.0), row(f64::INFINITY, 0.0, 1.0, 14.0)];
        for k in [1e-12, -1e-12] {
            let conic = [Row { conic: k, ..ball[0].clone() }, ball[1].clone()];
            close(&ball, &conic, 10.0);
        }
        for k in [-2.5, -1.0, 0.0, 0.3] {
            let conic = Row { conic: k, ..ball[0].clone() };
            for (power, a) in [(4, 0.0), (4, 1e-16), (3, 0.0), (20, 0.0)] {
                let polynomial = asphere(conic.clone(), &[(power, a)]);
                close(&[conic.clone(), ball[1].clone()], &[polynomial, ball[1].clone()], 10.0);
            }
        }
    }
}

#[test]
fn the_second_sheet_of_a_hyperboloid_is_ignored() {
    // k = -3, R = 10: the other sheet has its vertex 10 mm behind, on the film side of a dome.
    let lens = lens_of_rows(vec![Row { conic: -3.0, ..row(10.0, 0.0, 1.0, 8.0) }]);
    let asphere_too = lens_of_rows(vec![asphere(lens.rows[0].clone(), &[(4, 0.0)])]);
    let bowl = lens_of_rows(vec![Row { conic: -3.0, ..row(-10.0, 0.0, 1.0, 8.0) }]);
    let straight = |h: f64| start([h, 0.0, 0.0], [0.0, 0.0, 1.0]);
    let sag = 16.0 / 10.0 / (1.0 + (1.0f64 + 2.0 * 16.0 / 100.0).sqrt());
    for (lens, sag) in [(&lens, -sag), (&asphere_too, -sag), (&bowl, sag)] {
        // Film positions on both sides of the other sheet, far away, and ahead of the vertex.
        for film in [2.0, 9.0, 11.0, 14.0, 50.0, -3.0, -30.0] {
            for (name, out) in [
                ("f32", exit_ray::<f32>(lens, film, straight(4.0))),
                ("f64", exit_ray::<f64>(lens, film, straight(4.0))),
            ] {
                let [p, _] = out.expect("a ray along the axis meets the sheet of the vertex");
                assert!((p[2] - sag).abs() < 2e-5, "{name}, film at {film}: z = {}", p[2]);
            }
        }
    }
}

#[test]
fn a_ray_beyond_90_degrees_leaves_the_front_but_misses_surfaces_ahead() {
    // Rays that leave the front of a fisheye at more than 90 degrees.
    let fish = vec![row(20.0, 2.0, 1.8, 36.0), row(9.0, 0.0, 1.0, 17.5)];
    let behind = lens_of_rows(fish.clone());
    let mut ahead = vec![row(f64::INFINITY, 1.0, 1.0, 1e6)];
    ahead.extend(fish);
    let ahead = lens_of_rows(ahead);
    let mut back = 0;
    for slope in 0..2000 {
        let ray = start([0.0; 3], [f64::from(slope) * 4e-3, 0.0, 1.0]);
        for (one, two) in [
            (exit_ray::<f32>(&behind, 8.0, ray), exit_ray::<f32>(&ahead, 8.0, ray)),
            (exit_ray::<f64>(&behind, 8.0, ray), exit_ray::<f64>(&ahead, 8.0, ray)),
        ] {
            match one {
                Ok([_, t]) if t[2] <= 0.0 => {
                    back += 1;
                    assert_eq!(two, Err(Blocked { row: 0, reason: BlockReason::Miss }), "{ray:?}");
                }
                // The ray meets the plane, far out.
                Ok(_) => assert!(two.is_ok() || two.is_err_and(|end| end.row == 0)),
                Err(end) => assert_eq!(two.map_err(|end| end.reason), Err(end.reason)),
            }
        }
    }
    assert!(back > 100, "{back} rays leave beyond 90 degrees");
}

#[test]
fn a_surface_behind_the_ray_is_intersected_backwards() {
    // The film lies ahead of both faces of the plate: the ray goes back 7 mm and then 2 mm.
    let lens =
        lens_of_rows(vec![row(f64::INFINITY, -2.0, 1.5, 40.0), row(f64::INFINITY, 0.0, 1.0, 40.0)]);
    let ray = start([1.0, 0.0, 0.0], [0.6, 0.0, 0.8]);
    let [p, t] = exit_ray::<f64>(&lens, -7.0, ray).expect("planes are met");
    // x = 1 - 7 * 0.75 at the first face, then -2 mm in glass, in which the sine is 0.4.
    let expected = 1.0 - 7.0 * 0.75 - 2.0 * 0.4 / (1.0f64 - 0.16).sqrt();
    assert!((p[0] - expected).abs() < 1e-6 && p[2].abs() < 1e-12, "{p:?} {expected}");
    assert!((t[0] - 0.6).abs() < 1e-7, "{t:?}");
}
