//! Mirrors, folds and telescopes: focus by formula, one lane against eight, film against scene.

mod command;
mod models;

use std::f64::consts::FRAC_PI_4;
use std::process::Command;

use crate::support::{Random, folder, root, row, write};
use glam::{DAffine3, DMat3, DVec3};
use petzval_base::lanes::{Real, f32x8};
use petzval_base::rays::LensBatch;
use petzval_lens::{
    CoordinateBreak, LensRay, Normalization, Paraxial, Prescription, RealRayFocus, Row, Side,
    Vignetting, sequence, trace, trace_one,
};
use petzval_tools::bench::lens_wave::batch as lens_batch;

/// Radius and conic constant of the mirrors of a Cassegrain, their distance, and the back focal
/// distance (mm): a parabola of f = 400 and a hyperbola that magnifies four times.
const PRIMARY: f64 = -800.0;
const APART: f64 = 300.0;
const MAGNIFICATION: f64 = 4.0;

fn mirror(radius: f64, conic: f64, thickness: f64, diameter: f64) -> Row {
    Row { radius, conic, thickness, diameter, mirror: true, ..Row::default() }
}

fn single(conic: f64) -> Prescription {
    let rows = vec![Row { stop: true, ..mirror(-200.0, conic, 0.0, 40.0) }];
    Prescription::new("mirror", rows).expect("one stop")
}

/// The secondary has the object distance 400 - 300 and the image distance four times that, so
/// 1 / 400 - 1 / 100 = 2 / R, and k = -((m + 1) / (m - 1))^2 (Schroeder 2000, table 2.9).
fn cassegrain() -> Prescription {
    let near = -PRIMARY / 2.0 - APART;
    let radius = -2.0 / (1.0 / near - 1.0 / (MAGNIFICATION * near));
    let conic = -((MAGNIFICATION + 1.0) / (MAGNIFICATION - 1.0)).powi(2);
    let primary = mirror(PRIMARY, -1.0, -APART, 200.0);
    let rows =
        vec![Row { stop: true, obstruction: 60.0, ..primary }, mirror(radius, conic, 0.0, 56.0)];
    Prescription::new("Cassegrain", rows).expect("one stop")
}

/// A mirror behind a layer of glass.
fn mangin() -> Prescription {
    let rows = vec![
        Row { stop: true, ..row(-150.0, 6.0, 1.5, 50.0) },
        Row { index: 1.5, ..mirror(-230.0, 0.0, -6.0, 52.0) },
        row(-150.0, 0.0, 1.0, 50.0),
    ];
    Prescription::new("Mangin", rows).expect("one stop")
}

fn singlet() -> Vec<Row> {
    vec![
        row(60.0, 5.0, 1.5168, 24.0),
        row(-90.0, 4.0, 1.0, 24.0),
        row(0.0, 3.0, 1.0, 12.0),
        row(-40.0, 2.0, 1.62, 20.0),
        row(-80.0, 0.0, 1.0, 20.0),
    ]
}

/// The lens behind a mirror at 45 degrees, 50 mm before it.
fn folded() -> Prescription {
    let mut rows = vec![mirror(f64::INFINITY, 0.0, -50.0, 90.0)];
    rows.extend(singlet().into_iter().map(|row| Row {
        radius: -row.radius,
        thickness: -row.thickness,
        ..row
    }));
    let turn = DAffine3::from_mat3(DMat3::from_rotation_x(FRAC_PI_4));
    let mut lens = Prescription::new("folded", rows).expect("one stop");
    lens.breaks = [0, 1].map(|row| CoordinateBreak { row, transform: turned(row, turn) }).into();
    lens
}

/// Returns the break that turns the axis about the vertex of the mirror.
fn turned(row: usize, turn: DAffine3) -> DAffine3 {
    let along = |z: f64| DAffine3::from_translation(DVec3::new(0.0, 0.0, z));
    match row {
        0 => turn,
        _ => along(50.0) * turn * along(-50.0),
    }
}

fn unfolded() -> Prescription {
    Prescription::new("unfolded", singlet()).expect("one stop")
}

/// All systems, with a film distance and half the width of the film (mm).
fn systems() -> Vec<(Prescription, f64, f64)> {
    let focused = |lens: Prescription, half: f64| {
        let film = RealRayFocus::new(&lens).film_distance(f64::INFINITY);
        (lens.clone(), film.unwrap_or_else(|error| panic!("{}: {error}", lens.name)), half)
    };
    vec![
        focused(single(0.0), 4.0),
        focused(single(-1.0), 4.0),
        focused(cassegrain(), 6.0),
        focused(mangin(), 4.0),
        focused(folded(), 12.0),
    ]
}

/// Returns rays from the film to a disk somewhat wider than the rear surface.
fn aimed(lens: &Prescription, film: f64, half: f64, count: usize) -> Vec<[[f64; 3]; 2]> {
    let mut random = Random::new(7);
    let round = |v: f64| f64::from(v as f32);
    let reach = 0.55 * lens.rear().diameter;
    (0..count)
        .map(|_| {
            let start = [random.between(-half, half), random.between(-half, half), 0.0].map(round);
            let aim = [random.between(-reach, reach), random.between(-reach, reach)];
            let d = [aim[0] - start[0], aim[1] - start[1], film];
            let length = d.iter().map(|v| v * v).sum::<f64>().sqrt();
            [start, d.map(|v| round(v / length))]
        })
        .collect()
}

fn traced<R: Real>(
    lens: &Prescription,
    film: f64,
    rays: &[[[f64; 3]; 2]],
) -> (Box<LensBatch<R::Scalar>>, Vec<u64>) {
    let mut blocked = vec![0; lens.rows.len()];
    let mut batch = lens_batch::<R>(rays);
    trace::<R>(&mut batch, &sequence::<R>(lens, Side::Film(film)), &mut blocked);
    (batch, blocked)
}

#[test]
fn eight_lanes_equal_one_lane_bit_for_bit() {
    for (lens, film, half) in systems() {
        let rays = aimed(&lens, film, half, 1001);
        let (one, one_blocked) = traced::<f32>(&lens, film, &rays);
        let (eight, eight_blocked) = traced::<f32x8>(&lens, film, &rays);
        assert_eq!(one_blocked, eight_blocked, "{}", lens.name);
        let mut passed = 0;
        for i in 0..rays.len() {
            assert_eq!(one.x[i].is_nan(), eight.x[i].is_nan(), "{} {:?}", lens.name, rays[i]);
            if one.x[i].is_nan() {
                continue;
            }
            passed += 1;
            let bits = |b: &LensBatch<f32>| {
                [b.x[i], b.y[i], b.z[i], b.tx[i], b.ty[i], b.tz[i]].map(f32::to_bits)
            };
            assert_eq!(bits(&one), bits(&eight), "{} {:?}", lens.name, rays[i]);
        }
        assert!(passed > 200, "{}: only {passed} rays pass", lens.name);
    }
}

#[test]
fn f32_agrees_with_f64() {
    for (lens, film, half) in systems() {
        let exact = sequence::<f64>(&lens, Side::Film(film));
        let single = sequence::<f32>(&lens, Side::Film(film));
        let (mut um, mut urad, mut one) = (0.0f64, 0.0f64, 0);
        for [p, d] in aimed(&lens, film, half, 4000) {
            let length = d.iter().map(|v| v * v).sum::<f64>().sqrt();
            let a = trace_one::<f64>(LensRay::new(p, d.map(|v| v / length)), &exact);
            let b =
                trace_one::<f32>(LensRay::new(p.map(|v| v as f32), d.map(|v| v as f32)), &single);
            match (a, b) {
                (Ok(a), Ok(b)) => {
                    for k in 0..3 {
                        um = um.max(1e3 * (a.p[k] - f64::from(b.p[k])).abs());
                        urad = urad.max(1e6 * (a.t[k] - f64::from(b.t[k])).abs());
                    }
                }
                (Err(_), Err(_)) => {}
                _ => one += 1,
            }
        }
        println!("{}: {um:.3} um, {urad:.3} urad, {one} in one only", lens.name);
        // Ways of hundreds of millimetres: 24 bits of 400 mm are 0.02 um.
        assert!(um < 0.5 && urad < 2.0 && one < 8, "{}: {um} um, {urad} urad, {one}", lens.name);
    }
}

#[test]
fn a_ray_from_the_film_returns_on_its_own_path() {
    for (lens, film, half) in systems() {
        let out = sequence::<f64>(&lens, Side::Film(film));
        let back = sequence::<f64>(&lens, Side::Scene(500.0));
        let mut passed = 0;
        for [p, d] in aimed(&lens, film, half, 500) {
            let length = d.iter().map(|v| v * v).sum::<f64>().sqrt();
            let Ok(ray) = trace_one::<f64>(LensRay::new(p, d.map(|v| v / length)), &out) else {
                continue;
            };
            passed += 1;
            let s = (500.0 - ray.p[2]) / ray.t[2];
            let start = [0, 1].map(|k| ray.p[k] + s * ray.t[k]);
            let t = [-ray.t[0], -ray.t[1], ray.t[2]];
            let ray = trace_one::<f64>(LensRay::new([start[0], start[1], 0.0], t), &back)
                .unwrap_or_else(|end| panic!("{}: {end:?}", lens.name));
            let s = (film - ray.p[2]) / ray.t[2];
            for k in 0..2 {
                let met = ray.p[k] + s * ray.t[k];
                assert!((met - p[k]).abs() < 1e-9, "{}: {met} for {}", lens.name, p[k]);
            }
        }
        assert!(passed > 100, "{}: {passed}", lens.name);
    }
}

/// Returns the largest distance from the axis at which rays of a distant point on the axis meet
/// the paraxial focus (mm).
fn blur(lens: &Prescription) -> f64 {
    let back = Paraxial::new(lens).back_focal_distance;
    let surfaces = sequence::<f64>(lens, Side::Scene(400.0));
    let half = lens.rows[0].diameter / 2.0;
    let at = |h: f64| {
        let ray = trace_one::<f64>(LensRay::new([0.0, h, 0.0], [0.0, 0.0, 1.0]), &surfaces).ok()?;
        Some((ray.p[1] + (back - ray.p[2]) * ray.t[1] / ray.t[2]).abs())
    };
    let met: Vec<f64> = (1..50).filter_map(|i| at(half * f64::from(i) / 50.0)).collect();
    assert!(met.len() > 20, "{}: {} rays pass", lens.name, met.len());
    met.into_iter().fold(0.0, f64::max)
}

#[test]
fn focal_lengths_are_those_of_the_formulas() {
    for conic in [0.0, -1.0] {
        let paraxial = Paraxial::new(&single(conic));
        assert!((paraxial.focal_length - 100.0).abs() < 1e-12);
        assert!((paraxial.back_focal_distance - 100.0).abs() < 1e-12);
    }
    let paraxial = Paraxial::new(&cassegrain());
    let [f, back] = [paraxial.focal_length, paraxial.back_focal_distance];
    assert!((f - 1600.0).abs() < 1e-9, "f1 times the magnification, not {f}");
    assert!((back - 400.0).abs() < 1e-9, "four times 100 mm, not {back}");
    // A Mangin mirror of two thin lenses and a mirror: 1/f = 2 (n - 1) (1/R1 - 1/R2) - 2 / R2 in the
    // limit of a thin glass.
    let mut thin = mangin();
    for row in &mut thin.rows {
        row.thickness *= 1e-6;
    }
    let expected = 2.0 * 0.5 * (-1.0 / 150.0 + 1.0 / 230.0) + 2.0 / 230.0;
    let f = Paraxial::new(&thin).focal_length;
    assert!((f * expected - 1.0).abs() < 1e-6, "{f} for {}", 1.0 / expected);
}

#[test]
fn parabola_and_cassegrain_are_stigmatic_and_the_sphere_is_not() {
    assert!(blur(&single(-1.0)) < 1e-9, "{}", blur(&single(-1.0)));
    assert!(blur(&cassegrain()) < 1e-9, "{}", blur(&cassegrain()));
    // Third order: h^3 / (2 R^2) at the focus of the sphere, for h = 19.6 and R = 200.
    let expected = 19.6f64.powi(3) / (2.0 * 200.0 * 200.0);
    assert!((blur(&single(0.0)) / expected - 1.0).abs() < 0.05, "{}", blur(&single(0.0)));
}

#[test]
fn the_obstruction_takes_its_share_of_the_light() {
    let lens = cassegrain();
    let film = Paraxial::new(&lens).back_focal_distance;
    let vignetting = Vignetting::new(&lens, film, 1 << 16);
    let mut open = lens.clone();
    open.rows[0].obstruction = 0.0;
    let [part, all] = [&vignetting, &Vignetting::new(&open, film, 1 << 16)].map(|vignetting| {
        vignetting.budget([0.0; 2], Normalization::Stop).expect("light").irradiance
    });
    // The disk has the same centre as the primary, and (60 / 200)^2 of its area.
    assert!((part / all - 0.91).abs() < 4e-3, "{}", part / all);
    // The field angle is that of the focal length.
    let angle = vignetting.field_angle(5.0).expect("a chief ray");
    assert!((angle.to_radians().tan() * 1600.0 / 5.0 - 1.0).abs() < 1e-3, "{angle}");
}

#[test]
fn a_fold_shows_the_picture_of_the_unfolded_lens() {
    let (folded, unfolded) = (folded(), unfolded());
    let [a, b] = [&folded, &unfolded].map(Paraxial::new);
    assert!((a.focal_length - b.focal_length).abs() < 1e-12);
    assert!((a.back_focal_distance - b.back_focal_distance).abs() < 1e-12);
    let film = b.back_focal_distance;
    let [one, other] = [&folded, &unfolded].map(|lens| sequence::<f64>(lens, Side::Film(film)));
    let mut passed = 0;
    for [p, d] in aimed(&unfolded, film, 8.0, 500) {
        let length = d.iter().map(|v| v * v).sum::<f64>().sqrt();
        let ray = LensRay::new(p, d.map(|v| v / length));
        let Ok(straight) = trace_one::<f64>(ray, &other) else { continue };
        let bent = trace_one::<f64>(ray, &one).expect("the mirror is wide");
        passed += 1;
        // Along the axis, rays go to the scene: z forward.
        let slope = |t: [f64; 3]| [t[0] / t[2], t[1] / t[2]];
        let (s, c) = (slope(straight.t), slope(bent.t));
        assert!((s[0] - c[0]).abs() < 1e-12, "x of {s:?} and {c:?}");
        assert!((s[1].abs() - c[1].abs()).abs() < 1e-12, "y of {s:?} and {c:?}");
        // 50 mm farther on the straight way both rays have the same height.
        let at = |ray: &LensRay<f64>, z: f64| {
            [0, 1].map(|k| ray.p[k] + (z - ray.p[2]) * ray.t[k] / ray.t[2])
        };
        let (s, c) = (at(&straight, 50.0), at(&bent, 0.0));
        assert!((s[0] - c[0]).abs() < 1e-10, "{s:?} and {c:?}");
        assert!((s[1].abs() - c[1].abs()).abs() < 1e-10, "{s:?} and {c:?}");
    }
    assert!(passed > 100, "{passed}");
}

#[test]
fn rims_of_a_folded_lens_block_what_they_block_unfolded() {
    let film = Paraxial::new(&unfolded()).back_focal_distance;
    for x in [0.0, 6.0, 14.0] {
        let [one, other] = [folded(), unfolded()].map(|lens| {
            let vignetting = Vignetting::new(&lens, film, 1 << 14);
            let budget = vignetting.budget([x, 0.0], Normalization::Stop).expect("light");
            (budget.pass, budget.irradiance, vignetting.field_angle(x).expect("a chief ray"))
        });
        assert!((one.0 - other.0).abs() < 1e-4, "{one:?} {other:?}");
        assert!((one.1 / other.1 - 1.0).abs() < 1e-4, "{one:?} {other:?}");
        assert!((one.2 - other.2).abs() < 1e-6, "{one:?} {other:?}");
    }
}

const CASSEGRAIN: &str = "name = \"Cassegrain\"\n[[surface]]\nmirror = true\nstop = true\n\
    radius = -800\nconic = -1\nthickness = -300\ndiameter = 200\nobstruction = 60\n[[surface]]\n\
    mirror = true\nradius = -266.66666666666667\nconic = -2.7777777777777777\ndiameter = 56\n";

const FOLDED: &str = "name = \"folded\"\n[[surface]]\nmirror = true\nradius = 0\n\
    thickness = -50\ndiameter = 90\n[[surface]]\nradius = -60\nthickness = -5\nindex = 1.5168\n\
    diameter = 24\n[[surface]]\nradius = 90\nthickness = -4\ndiameter = 24\n[[surface]]\n\
    stop = true\nthickness = -3\ndiameter = 12\n[[surface]]\nradius = 40\nthickness = -2\n\
    index = 1.62\ndiameter = 20\n[[surface]]\nradius = 80\ndiameter = 20\n\
    [[break]]\nsurface = 1\ntilt = [45, 0, 0]\n\
    [[break]]\nsurface = 2\ndecentre = [0, 35.35533905932738, 14.644660940672622]\ntilt = [45, 0, 0]\n";
