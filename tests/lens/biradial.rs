//! Biconics and toroids against a naive twin, one lane against eight.

use std::process::Command;

use crate::support::nasty::NASTY;
use crate::support::{Random, folder, write};
use petzval_base::lanes::{Real, f32x8};
use petzval_base::rays::{LensBatch, WAVE_SIZE};
use petzval_lens::{
    CrossSection, LensRay, Paraxial, Prescription, Row, Side, TransverseAxis, retrace_in_f64,
    sequence, trace, trace_one,
};
use petzval_lens_formats::parse_toml;
use petzval_tools::bench::lens_wave::batch as lens_batch;

const FILM: f64 = 60.0;

fn biconic(radius: f64, conic: f64) -> Option<CrossSection> {
    Some(CrossSection::Biconic { radius, conic })
}

fn toroid(radius: f64) -> Option<CrossSection> {
    Some(CrossSection::Toroid { radius })
}

/// Returns a plano-curved lens in front of the stop, whose front has this shape.
fn lens(front: Row) -> Prescription {
    let rows = vec![
        Row { thickness: 6.0, index: 1.6, diameter: 24.0, ..front },
        Row { thickness: 3.0, diameter: 24.0, radius: -200.0, ..Row::default() },
        Row { stop: true, diameter: 14.0, ..Row::default() },
    ];
    Prescription::new("biradial", rows).expect("one stop")
}

/// Returns a lens with a surface of this shape behind the stop, towards the film.
fn rear(rear: Row) -> Prescription {
    let rows = vec![
        Row { stop: true, thickness: 2.0, diameter: 20.0, ..Row::default() },
        Row { thickness: 14.0, index: 1.2, diameter: 24.0, ..Row::default() },
        Row { diameter: 24.0, ..rear },
    ];
    Prescription::new("biradial", rows).expect("one stop")
}

fn lenses() -> Vec<(&'static str, Prescription)> {
    let row = |radius: f64, conic: f64, asphere: &[(u32, f64)], across| Row {
        radius,
        conic,
        asphere: asphere.to_vec(),
        across,
        ..Row::default()
    };
    vec![
        ("biconic", lens(row(40.0, -0.6, &[], biconic(55.0, 0.4)))),
        ("saddle", lens(row(-60.0, 0.0, &[], biconic(50.0, -2.0)))),
        ("with terms", lens(row(40.0, 0.2, &[(4, -2e-6), (6, 3e-9)], biconic(70.0, 0.0)))),
        ("odd terms", lens(row(f64::INFINITY, 0.0, &[(3, 1e-5)], biconic(35.0, 0.0)))),
        ("toroid", lens(row(45.0, -0.8, &[(4, 1e-6)], toroid(30.0)))),
        ("toroidal saddle", lens(row(-50.0, 0.0, &[], toroid(40.0)))),
        ("acylinder", lens(row(30.0, -1.5, &[(4, 2e-6)], toroid(f64::INFINITY)))),
        // Steeper than the rays at its rim, so that Newton's result is not accepted.
        ("steep", rear(row(-14.0, 0.0, &[], toroid(-12.5)))),
        ("steep biconic", rear(row(-13.0, 0.0, &[], biconic(-16.0, 0.3)))),
        ("wavy", lens(row(f64::INFINITY, 0.0, &[(2, 0.03), (4, -2.5e-4)], toroid(-60.0)))),
    ]
}

/// Returns the sag by the textbook formulas, without the forms that the library uses.
fn sag(row: &Row, x: f64, y: f64) -> f64 {
    let conic = |h: f64, radius: f64, k: f64| {
        if radius.is_infinite() {
            return 0.0;
        }
        // The root of c h^2 + (1 + k) c z^2 - 2 z = 0 nearer to the vertex, by bisection.
        let f = |z: f64| h * h + (1.0 + k) * z * z - 2.0 * radius * z;
        let (mut low, mut high) =
            (0.0, if k > -1.0 { radius / (1.0 + k) } else { 4.0 * h * h / radius });
        for _ in 0..200 {
            let middle = (low + high) / 2.0;
            if (f(middle) > 0.0) == (f(low) > 0.0 || h == 0.0) {
                low = middle
            } else {
                high = middle
            }
        }
        low
    };
    let terms = |h: f64| row.asphere.iter().map(|&(p, a)| a * h.powi(p as i32)).sum::<f64>();
    match row.across {
        Some(CrossSection::Toroid { radius }) => {
            let curve = conic(y.abs(), row.radius, row.conic) + terms(y.abs());
            if radius.is_infinite() {
                return curve;
            }
            let arm = radius - curve;
            radius - arm.signum() * (arm * arm - x * x).sqrt()
        }
        Some(CrossSection::Biconic { radius, conic: kx }) => {
            let (cx, cy) = (1.0 / radius, 1.0 / row.radius);
            let root = 1.0 - (1.0 + kx) * (cx * x).powi(2) - (1.0 + row.conic) * (cy * y).powi(2);
            (cx * x * x + cy * y * y) / (1.0 + root.sqrt()) + terms(x.hypot(y))
        }
        None => conic(x.hypot(y), row.radius, row.conic) + terms(x.hypot(y)),
    }
}

/// Traces a ray of the film through all rows with sags alone: the first crossing by small steps
/// and bisection, normals by differences. Returns point and direction, +z towards the scene.
fn naive(lens: &Prescription, p: [f64; 3], d: [f64; 3]) -> Option<[[f64; 3]; 2]> {
    let length = d.iter().map(|v| v * v).sum::<f64>().sqrt();
    let mut d = d.map(|v| v / length);
    // z towards the film from here on.
    d[2] = -d[2];
    let mut p = [p[0], p[1], lens.length() + FILM - p[2]];
    let vertices = lens.vertex_positions();
    for i in (0..lens.rows.len()).rev() {
        let row = &lens.rows[i];
        let half = row.diameter / 2.0;
        let over = |s: f64| {
            let [x, y, z] = [0, 1, 2].map(|k| p[k] + s * d[k]);
            let scale = (half / x.hypot(y)).min(1.0);
            z - vertices[i] - sag(row, scale * x, scale * y)
        };
        if d[2] >= 0.0 {
            return None;
        }
        let deepest = 13.0;
        let at = |z: f64| (vertices[i] + z - p[2]) / d[2];
        let (start, end) = (at(deepest), at(-deepest));
        let steps = 1000;
        let place = |k: i32| start + (end - start) * f64::from(k) / f64::from(steps);
        let first = (0..steps).find(|&k| over(place(k)) >= 0.0 && over(place(k + 1)) < 0.0)?;
        let (mut low, mut high) = (place(first), place(first + 1));
        for _ in 0..80 {
            let middle = (low + high) / 2.0;
            if over(middle) >= 0.0 { low = middle } else { high = middle }
        }
        p = [0, 1, 2].map(|k| p[k] + low * d[k]);
        let (x, y) = (p[0], p[1]);
        if x.hypot(y) > half {
            return None;
        }
        let e = 1e-5;
        let slope = |a: f64, b: f64| (a - b) / (2.0 * e);
        let zx = slope(sag(row, x + e, y), sag(row, x - e, y));
        let zy = slope(sag(row, x, y + e), sag(row, x, y - e));
        let norm = (1.0 + zx * zx + zy * zy).sqrt();
        let n = [zx / norm, zy / norm, -1.0 / norm];
        let [before, behind] = [row.index, lens.index_before(i)];
        let ratio = before / behind;
        let cos = d[0] * n[0] + d[1] * n[1] + d[2] * n[2];
        let inner = 1.0 - ratio * ratio * (1.0 - cos * cos);
        if inner < 0.0 || cos <= 0.0 {
            return None;
        }
        d = [0, 1, 2].map(|k| ratio * d[k] + (inner.sqrt() - ratio * cos) * n[k]);
    }
    Some([[p[0], p[1], -p[2]], [d[0], d[1], -d[2]]])
}

fn aimed(count: usize, seed: u64) -> Vec<[[f64; 3]; 2]> {
    let mut random = Random::new(seed);
    let round = |v: f64| f64::from(v as f32);
    (0..count)
        .map(|_| {
            let start = [random.between(-20.0, 20.0), random.between(-20.0, 20.0), 0.0].map(round);
            let aim = [random.between(-13.0, 13.0), random.between(-13.0, 13.0)];
            let d = [aim[0] - start[0], aim[1] - start[1], FILM];
            let length = d.iter().map(|v| v * v).sum::<f64>().sqrt();
            [start, d.map(|v| round(v / length))]
        })
        .collect()
}

#[test]
fn rays_agree_with_the_naive_twin() {
    for (name, lens) in lenses() {
        let exact = sequence::<f64>(&lens, Side::Film(FILM));
        let single = sequence::<f32>(&lens, Side::Film(FILM));
        let (mut both, mut one, mut worst, mut rough) = (0, 0, [0.0f64; 2], [0.0f64; 2]);
        for [p, d] in aimed(1500, 3) {
            let length = d.iter().map(|v| v * v).sum::<f64>().sqrt();
            let ray = LensRay::new(p, d.map(|v| v / length));
            let ours = trace_one::<f64>(ray, &exact).ok();
            let narrow = LensRay::new(p.map(|v| v as f32), ray.t.map(|v| v as f32));
            let narrow = trace_one::<f32>(narrow, &single).ok();
            match (ours, naive(&lens, p, d)) {
                (Some(ray), Some([p, d])) => {
                    both += 1;
                    let off = |a: [f64; 3], b: [f64; 3]| {
                        (0..3).map(|k| (a[k] - b[k]).abs()).fold(0.0, f64::max)
                    };
                    worst = [worst[0].max(off(ray.p, p)), worst[1].max(off(ray.t, d))];
                    if let Some(narrow) = narrow {
                        let [p, t] = [narrow.p, narrow.t].map(|v| v.map(f64::from));
                        rough = [rough[0].max(off(ray.p, p)), rough[1].max(off(ray.t, t))];
                    }
                }
                (None, None) => {}
                _ => one += 1,
            }
        }
        println!("{name}: {both} rays, {one} in one only, f64 {worst:?}, f32 {rough:?}");
        assert!(both > 200, "{name}: only {both} rays pass");
        // At rims the last bit decides.
        assert!(one < 4, "{name}: {one} rays pass in one only");
        // The differences of the twin's normals are exact to 1e-9.
        assert!(worst[0] < 1e-7 && worst[1] < 1e-8, "{name}: f64 is off by {worst:?}");
        // As aspheres, in mm and radians.
        assert!(rough[0] < 3e-4 && rough[1] < 2e-5, "{name}: f32 is off by {rough:?}");
    }
}

type Traced<T> = (Box<LensBatch<T>>, Vec<u64>);

fn traced<R: Real>(lens: &Prescription, rays: &[[[f64; 3]; 2]]) -> Traced<R::Scalar> {
    let surfaces = sequence::<R>(lens, Side::Film(FILM));
    let mut blocked = vec![0; lens.rows.len()];
    let mut batch = lens_batch::<R>(rays);
    trace::<R>(&mut batch, &surfaces, &mut blocked);
    (batch, blocked)
}

#[test]
fn eight_lanes_equal_one_lane_bit_for_bit() {
    for (name, lens) in lenses() {
        let mut rays = aimed(2 * WAVE_SIZE, 1);
        for a in NASTY {
            for b in NASTY {
                rays.push([[a, b, 0.0], [0.0, 0.0, 1.0]]);
                rays.push([[1.0, 0.0, 0.0], [a, b, 1.0]]);
                rays.push([[1.0, 2.0, a], [0.1, 0.0, b]]);
            }
        }
        rays.push([[0.0; 3], [0.0, 0.0, 1.0]]);
        for chunk in rays.chunks(WAVE_SIZE) {
            let (one, one_blocked) = traced::<f32>(&lens, chunk);
            let (eight, eight_blocked) = traced::<f32x8>(&lens, chunk);
            assert_eq!(one_blocked, eight_blocked, "{name}");
            for i in 0..chunk.len() {
                let bits = |b: &LensBatch<f32>| {
                    [b.x[i], b.y[i], b.z[i], b.tx[i], b.ty[i], b.tz[i]].map(f32::to_bits)
                };
                assert_eq!(one.x[i].is_nan(), eight.x[i].is_nan(), "{name} {:?}", chunk[i]);
                if !one.x[i].is_nan() {
                    assert_eq!(bits(&one), bits(&eight), "{name} {:?}", chunk[i]);
                }
            }
        }
    }
}

#[test]
fn retraced_rays_count_once() {
    for (name, lens) in lenses() {
        let rays = aimed(WAVE_SIZE, 9);
        let (mut batch, mut blocked) = traced::<f32x8>(&lens, &rays);
        let exact = sequence::<f64>(&lens, Side::Film(FILM));
        retrace_in_f64::<f32x8>(&mut batch, &exact, &mut blocked, |i| {
            LensRay::new(rays[i][0], rays[i][1])
        });
        let alive = (0..rays.len()).filter(|&i| !batch.x[i].is_nan()).count() as u64;
        assert_eq!(alive + blocked.iter().sum::<u64>(), WAVE_SIZE as u64, "{name}");
    }
}

#[test]
fn a_biconic_of_equal_sections_is_a_conic() {
    let conic = Row { radius: 40.0, conic: -0.7, ..Row::default() };
    let both = Row { across: biconic(40.0, -0.7), ..conic.clone() };
    let toric = Row { across: toroid(40.0), conic: 0.0, ..conic.clone() };
    let sphere = Row { conic: 0.0, ..conic.clone() };
    for (round, other) in [(conic, both), (sphere, toric)] {
        let [round, other] =
            [round, other].map(|row| sequence::<f64>(&lens(row), Side::Film(FILM)));
        let mut passed = 0;
        for [p, t] in aimed(2000, 4) {
            // The kernel of the sphere relies on the length of the direction.
            let length = t.iter().map(|v| v * v).sum::<f64>().sqrt();
            let ray = LensRay::new(p, t.map(|v| v / length));
            let (Ok(a), Ok(b)) = (trace_one::<f64>(ray, &round), trace_one::<f64>(ray, &other))
            else {
                continue;
            };
            passed += 1;
            for k in 0..3 {
                assert!((a.p[k] - b.p[k]).abs() < 1e-11 && (a.t[k] - b.t[k]).abs() < 1e-12);
            }
        }
        assert!(passed > 300);
    }
}

#[test]
fn rays_near_the_axis_meet_at_the_paraxial_focus_of_their_plane() {
    for (name, lens) in lenses().into_iter().filter(|(name, _)| *name != "odd terms") {
        let surfaces = sequence::<f64>(&lens, Side::Scene(20.0));
        for (plane, axis) in [TransverseAxis::X, TransverseAxis::Y].into_iter().enumerate() {
            let expected = Paraxial::in_plane(&lens, axis).back_focal_distance;
            let mut p = [0.0; 3];
            p[plane] = 1e-3;
            let ray =
                trace_one::<f64>(LensRay::new(p, [0.0, 0.0, 1.0]), &surfaces).expect("passes");
            let back = ray.p[2] - ray.p[plane] * ray.t[2] / ray.t[plane];
            assert!((back / expected - 1.0).abs() < 1e-5, "{name} {axis:?}: {back} for {expected}");
        }
    }
}

#[test]
fn gradients_are_the_derivatives_of_the_sag() {
    for (name, lens) in lenses() {
        let row = lens.rows.iter().find(|row| row.across.is_some()).expect("a section along x");
        for [x, y] in [[3.0, 4.0], [-7.0, 2.0], [5.0, -8.0], [0.0, 6.0], [9.0, 0.0]] {
            assert!((row.sag_at(x, y) - sag(row, x, y)).abs() < 1e-11, "{name} at {x}, {y}");
            let e = 1e-5;
            let expected = [
                (row.sag_at(x + e, y) - row.sag_at(x - e, y)) / (2.0 * e),
                (row.sag_at(x, y + e) - row.sag_at(x, y - e)) / (2.0 * e),
            ];
            let found = row.gradient(x, y);
            for k in 0..2 {
                assert!((expected[k] - found[k]).abs() < 1e-7, "{name}: {found:?} {expected:?}");
            }
        }
        assert!(!row.is_round() && row.is_anamorphic(), "{name}");
    }
}

const FILE: &str = "[[surface]]\nradius = 40\nconic = -0.5\nshape = \"biconic\"\nradius_x = 60\n\
                    conic_x = 0.25\nasphere = [[4, 1e-7]]\nthickness = 6\nindex = 1.6\n\
                    diameter = 24\n[[surface]]\nstop = true\ndiameter = 12\n";

#[test]
fn lens_files_give_biconics_and_toroids() {
    let parse = |text: &str| parse_toml(std::path::Path::new("lens.toml"), text);
    let lens = parse(FILE).expect("a lens");
    assert_eq!(lens.rows[0].across, biconic(60.0, 0.25));
    assert_eq!(lens.rows[0].radius, 40.0);
    let text = FILE.replace("biconic", "toroid").replace("conic_x = 0.25\n", "");
    assert_eq!(parse(&text).expect("a lens").rows[0].across, toroid(60.0));
    let text = text.replace("radius_x = 60", "radius_x = 0");
    assert_eq!(parse(&text).expect("a lens").rows[0].across, toroid(f64::INFINITY));
    for (from, to, expected) in [
        ("shape = \"biconic\"\n", "", "radius_x without a shape"),
        ("radius_x = 60\n", "", "a biconic without radius_x"),
        ("biconic", "toroid", "conic_x on a toroid"),
        ("biconic", "torus", "expected \"biconic\" or \"toroid\""),
        ("radius_x = 60", "radius_x = 1e-9", "radius_x is 1e-9"),
        ("radius_x = 60", "radius_x = 11", "ends at a diameter of"),
        ("conic = -0.5", "axis = \"x\"", "axis and shape on one surface"),
    ] {
        let error = parse(&FILE.replace(from, to)).expect_err(expected).to_string();
        assert!(error.contains(expected) && error.starts_with("lens.toml:"), "{error}");
    }
}

#[test]
fn the_command_describes_draws_and_traces_a_biconic() {
    let folder = folder();
    let file = write(&folder, "lens.toml", FILE);
    let svg = folder.path().join("lens.svg");
    let run = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_petzval"))
            .arg("lens")
            .arg(&file)
            .args(arguments)
            .output()
            .expect("the command starts");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    let text = run(&["--focus", "inf", "--draw", svg.to_str().expect("a name")]);
    // The front is all the power: f = R / (n - 1).
    assert!(text.contains("focal length                    100.0000 mm"), "{text}");
    assert!(text.contains("focal length along y             66.6667 mm"), "{text}");
    assert!(run(&["--vignetting", "--film-diagonal", "20"]).contains("along its x axis"));
}
