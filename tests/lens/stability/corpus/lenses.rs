//! Lenses of the corpus, by kind of surface.

use petzval_lens::{ApertureMask, Iris, Paraxial, Row, TransverseAxis};

use super::{Case, PROMISE, PROMISE_F64, case};
use crate::support::probe::RIM_TOLERANCE;
use crate::support::{root, row};

fn stop(diameter: f64, thickness: f64) -> Row {
    row(0.0, thickness, 1.0, diameter)
}

fn conic(radius: f64, conic: f64, thickness: f64, index: f64, diameter: f64) -> Row {
    Row { conic, ..row(radius, thickness, index, diameter) }
}

pub fn asphere(base: Row, terms: &[(u32, f64)]) -> Row {
    Row { asphere: terms.to_vec(), ..base }
}

/// Returns an asphere that is flat in the middle and has a bump, an inflection and a slope of 1.5 at the
/// rim.
pub fn wavy_asphere(thickness: f64, index: f64) -> Row {
    asphere(
        conic(6.0, -4.0, thickness, index, 6.0),
        &[(4, -2.2e-2), (6, 2.4e-3), (8, 1.0e-4), (10, -8.0e-6)],
    )
}

fn cylinder(axis: TransverseAxis, radius: f64, thickness: f64, index: f64, diameter: f64) -> Row {
    Row { axis: Some(axis), ..row(radius, thickness, index, diameter) }
}

pub(super) fn radii(all: &mut Vec<Case>) {
    let flat = f64::INFINITY;
    all.push(case(
        "plates",
        vec![row(flat, 3.0, 1.5, 30.0), row(flat, 2.0, 2.2, 30.0), row(flat, 0.0, 1.0, 30.0)],
        20.0,
        [20.0, 18.0],
    ));
    for exponent in 1..=12 {
        let radius = 10f64.powi(exponent);
        for radius in [radius, -radius] {
            let rows = vec![
                row(radius, 5.0, 1.6, 16.0),
                row(flat, 2.0, 1.0, 16.0),
                stop(9.0, 1.0),
                row(flat, 3.0, 1.8, 16.0),
                row(radius, 0.0, 1.0, 16.0),
            ];
            all.push(case(format!("R = {radius:e}"), rows, 25.0, [15.0, 9.0]));
        }
    }
}

pub(super) fn spheres(all: &mut Vec<Case>) {
    let flat = f64::INFINITY;
    let hemisphere = |radius: f64, index| match radius > 0.0 {
        true => vec![row(radius, 5.0, index, 10.0), row(flat, 0.0, 1.0, 10.0)],
        false => vec![row(flat, 5.0, index, 10.0), row(radius, 0.0, 1.0, 10.0)],
    };
    for index in [1.2, 1.5, 2.0] {
        all.push(case(
            format!("hemisphere, dome to the scene, n = {index}"),
            hemisphere(5.0, index),
            4.0,
            [5.0, 5.0],
        ));
        all.push(case(
            format!("hemisphere, dome to the film, n = {index}"),
            hemisphere(-5.0, index),
            4.0,
            [5.0, 5.0],
        ));
        for film in [0.1, 4.0, 100.0] {
            let ball = vec![row(5.0, 10.0, index, 10.0), row(-5.0, 0.0, 1.0, 10.0)];
            let name = format!("ball of n = {index}, film at {film} mm");
            let ball = case(name, ball, film, [6.0, 7.0]);
            // From 100 mm the square of 1 + c z is 441, which multiplies roundings.
            all.push(if film > 50.0 { ball.exact_to(2e-5) } else { ball });
        }
    }
    // Air inside glass: every border is total internal reflection.
    let hollow = vec![
        row(flat, 8.0, 1.7, 30.0),
        row(5.0, 10.0, 1.0, 10.0),
        row(-5.0, 8.0, 1.7, 10.0),
        row(flat, 0.0, 1.0, 30.0),
    ];
    all.push(case("air bubble in glass", hollow, 10.0, [10.0, 8.0]));
    // Hemispheres that are concave to the film and to the scene.
    let bowls = vec![row(-6.0, 1.0, 1.5, 12.0), row(6.0, 0.0, 1.0, 12.0)];
    all.push(case("two bowls, rims wider than the glass", bowls, 9.0, [4.0, 7.0]));
    let fish = vec![row(20.0, 2.0, 1.8, 36.0), row(9.0, 0.0, 1.0, 17.5)];
    all.push(case("beyond 90 degrees", fish, 8.0, [0.5, 40.0]));
    let weak = vec![row(8.0, 4.0, 1.0 + 1e-6, 15.9), row(-8.0, 0.0, 1.0, 15.9)];
    all.push(case("n' - n = 1e-6", weak, 6.0, [6.0, 9.0]));
    let tir = vec![row(-40.0, 10.0, 1.5, 40.0), row(flat, 0.0, 1.5, 60.0)];
    all.push(case("film in glass, dome in", tir, 10.0, [14.0, 25.0]));
    let prism = vec![row(flat, 5.0, 1.9, 40.0), row(30.0, 0.0, 1.0, 30.0)];
    all.push(case("meniscus of a high index", prism, 8.0, [14.0, 25.0]));
    let water =
        vec![row(12.0, 3.0, 1.5, 16.0), row(-15.0, 4.0, 1.33, 16.0), row(-9.0, 0.0, 1.33, 14.0)];
    all.push(case("film in water", water, 10.0, [8.0, 9.0]));
}

pub(super) fn gaps(all: &mut Vec<Case>) {
    let flat = f64::INFINITY;
    let negative = vec![
        row(12.0, -1.0, 1.6, 14.0),
        row(30.0, -2.5, 1.0, 14.0),
        row(-25.0, 3.0, 1.5, 14.0),
        row(-10.0, 0.0, 1.0, 14.0),
    ];
    all.push(case("negative gaps", negative, 15.0, [9.0, 8.0]));
    let behind = vec![
        row(20.0, 4.0, 1.5, 20.0),
        row(flat, -30.0, 1.0, 20.0),
        stop(6.0, 30.0),
        row(-20.0, 0.0, 1.5, 20.0),
        row(30.0, 0.0, 1.0, 20.0),
    ];
    all.push(case("a stop 30 mm behind the glass before it", behind, 25.0, [9.0, 8.0]));
    let cemented = vec![
        row(20.0, 4.0, 1.5, 16.0),
        row(-18.0, 0.0, 1.6, 16.0),
        row(-18.0, 0.0, 1.7, 16.0),
        row(-18.0, 2.0, 1.8, 16.0),
        row(-60.0, 0.0, 1.0, 16.0),
    ];
    all.push(case("cemented, layers without thickness", cemented, 22.0, [9.0, 9.0]));
    let touching = vec![
        row(15.0, 0.0, 1.5, 12.0),
        row(-15.0, 0.0, 1.0, 12.0),
        row(8.0, 0.0, 1.7, 12.0),
        row(flat, 0.0, 1.0, 12.0),
    ];
    all.push(case("four surfaces touch at the vertex", touching, 22.0, [9.0, 7.0]));
    for diameter in [0.1, 0.001] {
        let pinhole = vec![
            row(20.0, 4.0, 1.6, 12.0),
            row(-20.0, 1.0, 1.0, 12.0),
            stop(diameter, 1.0),
            row(-20.0, 2.0, 1.6, 12.0),
            row(20.0, 0.0, 1.0, 12.0),
        ];
        let pinhole = case(format!("a stop of {diameter} mm"), pinhole, 25.0, [6.0, diameter]);
        let ahead = 25.0 - Paraxial::new(&pinhole.lens).exit_pupil.position;
        all.push(Case { ahead, ..pinhole });
    }
    let first = vec![stop(6.0, 2.0), row(20.0, 4.0, 1.6, 12.0), row(-20.0, 0.0, 1.0, 12.0)];
    all.push(case("stop as the first row", first, 20.0, [8.0, 7.0]));
    let last = vec![row(20.0, 4.0, 1.6, 12.0), row(-20.0, 2.0, 1.0, 12.0), stop(6.0, 0.0)];
    all.push(case("stop as the last row", last, 20.0, [8.0, 4.0]));
    let bent = vec![
        row(20.0, 4.0, 1.6, 14.0),
        Row { stop: true, ..row(-9.0, 1.0, 1.0, 8.0) },
        row(-30.0, 1.0, 1.5, 12.0),
        row(60.0, 0.0, 1.0, 12.0),
    ];
    all.push(case("stop on a curved glass", bent, 20.0, [8.0, 6.0]));
    let ringed = vec![
        Row { obstruction: 3.0, ..row(20.0, 4.0, 1.6, 14.0) },
        row(-30.0, 2.0, 1.0, 14.0),
        Row { obstruction: 2.0, ..stop(8.0, 1.0) },
        row(50.0, 0.0, 1.0, 14.0),
    ];
    all.push(case("obstructions on glass and stop", ringed, 20.0, [8.0, 6.0]));
    for scale in [1e-3, 1e3] {
        let s = |v: f64| v * scale;
        let rows = vec![
            row(s(12.0), s(3.0), 1.6, s(9.0)),
            row(s(-30.0), s(2.0), 1.0, s(9.0)),
            stop(s(5.0), s(1.0)),
            row(s(-14.0), s(2.0), 1.7, s(8.0)),
            row(s(40.0), 0.0, 1.0, s(8.0)),
        ];
        let big = case(format!("a lens times {scale:e}"), rows, s(22.0), [s(8.0), s(5.0)]);
        all.push(match scale > 1.0 {
            true => big.bound(5.0, 5.0, "8 m of height have 0.5 um between two f32").exact_to(1e-5),
            false => big.bound(1e-3, 5.0, "the promise, a thousand times smaller"),
        });
    }
}

pub(super) fn conics(all: &mut Vec<Case>) {
    let flat = f64::INFINITY;
    for k in [1e-12, -1e-12, -0.5, -0.999_999, -1.0, -1.000_001, -3.0, -30.0, -1e4, 0.5, 3.0] {
        // The widest diameter that the conic has, or 24 mm.
        let edge = if k > -0.75 { 20.0 / (1.0f64 + k).sqrt() } else { 24.0 };
        let rows = |radius: f64| vec![conic(radius, k, 5.0, 1.5, edge), row(flat, 0.0, 1.0, 40.0)];
        all.push(case(format!("conic k = {k}, dome to the scene"), rows(10.0), 8.0, [12.0, 14.0]));
        all.push(case(format!("conic k = {k}, bowl to the scene"), rows(-10.0), 8.0, [12.0, 14.0]));
        let far = vec![row(flat, 8.0, 1.7, 40.0), conic(-10.0, k, 0.0, 1.0, edge)];
        all.push(case(format!("conic k = {k}, bowl from afar"), far.clone(), 30.0, [12.0, 14.0]));
        let far = vec![row(flat, 8.0, 1.7, 40.0), conic(10.0, k, 0.0, 1.0, edge)];
        all.push(case(format!("conic k = {k}, dome from afar"), far, 30.0, [12.0, 14.0]));
    }
}

pub(super) fn aspheres(all: &mut Vec<Case>) {
    let flat = f64::INFINITY;
    for (name, terms) in [
        ("0", vec![(4, 0.0), (6, 0.0)]),
        ("1e-12", vec![(4, 1e-12), (6, 1e-14)]),
        ("of r^3 0", vec![(3, 0.0)]),
    ] {
        for radius in [10.0, -10.0] {
            let rows = vec![
                asphere(conic(radius, -0.6, 5.0, 1.5, 18.0), &terms),
                asphere(row(40.0, 0.0, 1.0, 18.0), &terms),
            ];
            all.push(case(
                format!("asphere, coefficients {name}, R = {radius}"),
                rows,
                12.0,
                [9.0, 9.0],
            ));
        }
    }
    let phone = petzval_lens_formats::read(&root().join("lenses/phone.toml"))
        .expect("a lens of the repository");
    all.push(Case {
        name: "phone".into(),
        lens: phone,
        film: 0.53,
        from: [3.4, 1.2],
        ahead: 5.0,
        single: PROMISE,
        double: PROMISE_F64,
        rims: RIM_TOLERANCE,
        reason: "the promise",
    });
    for (name, rows) in [
        ("to the scene", vec![wavy_asphere(3.0, 1.6), row(flat, 0.0, 1.0, 8.0)]),
        ("to the film", vec![row(flat, 3.0, 1.6, 8.0), wavy_asphere(0.0, 1.0)]),
    ] {
        for film in [0.5, 4.0, 12.0] {
            let name = format!("inflected asphere {name}, film at {film} mm");
            let bent = case(name, rows.clone(), film, [8.0, 4.0]);
            // The search steps over a crossing of the flange that is shorter than a thousandth of
            // the path through the slab; the ray then meets the surface behind.
            all.push(Case { rims: [2e-3, 2e-3], ..bent });
        }
    }
    let odd = vec![
        asphere(row(9.0, 3.0, 1.5, 8.0), &[(3, 4e-3), (5, -6e-4), (7, 1e-5)]),
        asphere(row(-30.0, 0.0, 1.0, 8.0), &[(3, -3e-3), (4, 2e-4)]),
    ];
    all.push(case("odd aspheres with r^3", odd, 9.0, [6.0, 5.0]));
    let flat_polynomial = vec![
        asphere(row(flat, 2.0, 1.5, 8.0), &[(2, 0.05), (4, -1e-3)]),
        asphere(row(flat, 0.0, 1.0, 8.0), &[(4, 1e-3)]),
    ];
    all.push(case("polynomials on planes", flat_polynomial, 9.0, [6.0, 5.0]));
    let deep = vec![asphere(row(5.0, 5.0, 1.5, 10.0), &[(4, 1e-5)]), row(flat, 0.0, 1.0, 10.0)];
    all.push(case("asphere on a whole hemisphere", deep, 4.0, [5.0, 5.0]));
    // Flat inside the clear diameter, where the polynomial cancels the conic, and steep beyond it.
    for radius in [4.0, -4.0] {
        let terms = [(2, -0.5 / radius), (12, 2e-7)];
        let flattened = vec![
            asphere(conic(radius, -1.0, 2.0, 1.5, 6.0), &terms),
            asphere(conic(radius, -1.0, 0.0, 1.0, 6.0), &terms),
        ];
        all.push(case(format!("flattened, R = {radius}"), flattened, 2.0, [5.0, 4.0]));
    }
    let plate = vec![
        asphere(row(flat, 1.0, 1.5, 12.0), &[(2, 1e-3), (4, -2e-3), (6, 1.1e-4)]),
        row(flat, 10.0, 1.0, 12.0),
        row(-30.0, 0.0, 1.0, 12.0),
    ];
    all.push(case("corrector plate", plate, 9.0, [6.0, 6.0]));
}

pub(super) fn cylinders(all: &mut Vec<Case>) {
    let flat = f64::INFINITY;
    for (name, axis, other) in
        [("x", TransverseAxis::X, TransverseAxis::Y), ("y", TransverseAxis::Y, TransverseAxis::X)]
    {
        let rows =
            |radius: f64| vec![cylinder(axis, radius, 4.0, 1.6, 15.9), row(flat, 0.0, 1.0, 20.0)];
        all.push(case(format!("cylinder along {name}, dome"), rows(8.0), 10.0, [9.0, 10.0]));
        all.push(case(format!("cylinder along {name}, bowl"), rows(-8.0), 10.0, [9.0, 10.0]));
        let rod = vec![cylinder(axis, 5.0, 10.0, 1.5, 10.0), cylinder(axis, -5.0, 0.0, 1.0, 10.0)];
        all.push(case(format!("rod along {name}"), rod, 6.0, [6.0, 6.0]));
        let crossed = vec![
            cylinder(axis, 9.0, 4.0, 1.6, 16.0),
            cylinder(other, -9.0, 3.0, 1.0, 16.0),
            stop(7.0, 1.0),
            cylinder(axis, -20.0, 2.0, 1.7, 12.0),
            cylinder(other, 40.0, 0.0, 1.0, 12.0),
        ];
        all.push(case(format!("crossed cylinders, {name} first"), crossed, 20.0, [9.0, 7.0]));
    }
}

pub(super) fn shaped(all: &mut Vec<Case>) {
    for (name, iris) in [
        ("7 straight blades", Iris::Blades { count: 7, rotation: 11.0, curvature: 0.0 }),
        ("3 curved blades", Iris::Blades { count: 3, rotation: -40.0, curvature: 0.7 }),
        ("64 blades", Iris::Blades { count: 64, rotation: 400.0, curvature: 1.0 }),
        ("star mask", Iris::Mask(ApertureMask::named("star").expect("a mask"))),
        ("gaussian mask", Iris::Mask(ApertureMask::named("gaussian").expect("a mask"))),
    ] {
        let rows = vec![
            row(20.0, 4.0, 1.6, 14.0),
            row(-60.0, 2.0, 1.0, 14.0),
            Row { iris: iris.clone(), ..stop(8.0, 1.0) },
            row(-25.0, 2.0, 1.7, 12.0),
            row(80.0, 0.0, 1.0, 12.0),
        ];
        all.push(case(name, rows, 22.0, [8.0, 6.0]));
        let rows =
            vec![row(20.0, 4.0, 1.6, 14.0), Row { iris, stop: true, ..row(-12.0, 0.0, 1.0, 8.0) }];
        all.push(case(format!("{name} on a curved glass"), rows, 22.0, [8.0, 5.0]));
    }
    // Retraced rays keep the weight that the mask leaves.
    let gaussian = Iris::Mask(ApertureMask::named("gaussian").expect("a mask"));
    let masked = Row { iris: gaussian, ..stop(9.0, 0.0) };
    let half = [row(5.0, 5.0, 1.5, 10.0), row(f64::INFINITY, 0.0, 1.0, 10.0)];
    let behind = [&half[..], std::slice::from_ref(&masked)].concat();
    all.push(case("gaussian mask behind a hemisphere", behind, 4.0, [5.0, 5.0]));
    let before = [&[Row { thickness: 1.0, ..masked }], &half[..]].concat();
    all.push(case("gaussian mask before a hemisphere", before, 4.0, [5.0, 5.0]));
}
