//! `petzval lens trace`: rays from a CSV, against the oracle.

use std::fmt::Write as _;
use std::path::Path;
use std::process::{Command, Output};

use crate::support::grazing::Hemisphere;
use crate::support::{LENSES, Random, folder, lens, oracle, root, write};
use petzval_lens::Row;

fn trace(lens: &Path, rays: &Path, more: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_petzval"))
        .args(["lens", "trace"])
        .arg(lens)
        .arg("--rays")
        .arg(rays)
        .args(more)
        .output()
        .expect("the command starts")
}

fn lines(output: &Output) -> Vec<String> {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).lines().map(str::to_owned).collect()
}

#[test]
fn traced_rays_agree_with_the_oracle() {
    let folder = folder();
    for (name, film) in LENSES {
        let prescription = lens(name);
        let path = root().join("lenses").join(format!("{name}.dat"));
        let mut random = Random::new(21);
        let (mut text, mut rays) = (String::new(), Vec::new());
        for _ in 0..5000 {
            let film_z = prescription.length() + film;
            let start = [random.between(-15.0, 15.0), random.between(-15.0, 15.0), film_z];
            let (r, phi) =
                (random.next() * prescription.rear().diameter * 0.6, random.next() * 6.3);
            // A direction of any length: the command normalises it.
            let d = [r * phi.cos() - start[0], r * phi.sin() - start[1], -film];
            let _ =
                writeln!(text, "{},{},{},{},{},{}", start[0], start[1], start[2], d[0], d[1], d[2]);
            rays.push((start, d));
        }
        let csv = write(&folder, "rays.csv", &text);
        let f64_lines = lines(&trace(&path, &csv, &["--precision", "f64"]));
        assert_eq!(f64_lines.len(), rays.len());
        let mut through = 0;
        for (line, (start, d)) in f64_lines.iter().zip(&rays) {
            let film_point = [start[0], start[1], 0.0];
            match oracle::trace_spheres(&prescription, film, film_point, [d[0], d[1], -d[2]]) {
                Ok([p, t]) => {
                    let s = -p[2] / t[2];
                    let exact = [p[0] + s * t[0], p[1] + s * t[1], 0.0, t[0], t[1], -t[2]];
                    let ours: Vec<f64> = line.split(',').map(|v| v.parse().unwrap()).collect();
                    for (exact, ours) in exact.iter().zip(&ours) {
                        assert!((exact - ours).abs() < 1e-10, "{name}: {line}");
                    }
                    through += 1;
                }
                Err(row) => {
                    assert!(line.starts_with(&format!("blocked,{},", row + 1)), "{name}: {line}")
                }
            }
        }
        assert!(through > 300, "{name}: only {through} rays leave the lens");
        let simd = lines(&trace(&path, &csv, &[]));
        let scalar = lines(&trace(&path, &csv, &["--backend", "scalar"]));
        assert_eq!(simd, scalar, "{name}: one lane and eight differ");
        for (single, double) in simd.iter().zip(&f64_lines) {
            if single.starts_with("blocked") || double.starts_with("blocked") {
                continue;
            }
            for (a, b) in single.split(',').zip(double.split(',')) {
                let (a, b): (f64, f64) = (a.parse().unwrap(), b.parse().unwrap());
                assert!((a - b).abs() < 2e-4, "{name}: {single} and {double}");
            }
        }
    }
}

#[test]
fn a_blocked_ray_says_where_and_why() {
    let folder = folder();
    // A plate in front, a strong lens and the stop behind.
    let table = "1e9 2 1.5 20\n-1e9 1 1 20\n10 6 1.8 18\n-10 1 1 18\n0 0 0 4\n";
    let lens = write(&folder, "lens.dat", table);
    let rays = "x,y,z,dx,dy,dz,wavelength_nm\n\
                0,0,30,0,0,-1,550\n\
                0,2.5,30,0,0,-1,550\n\
                0,0,30,0,0,1,550\n\
                # a comment\n\
                0,0,30,1,0,0\n";
    let rays = write(&folder, "rays.csv", rays);
    let printed = lines(&trace(&lens, &rays, &["--precision", "f64"]));
    assert_eq!(printed[0], "x,y,z,dx,dy,dz");
    let straight: Vec<f64> = printed[1].split(',').map(|v| v.parse().unwrap()).collect();
    assert_eq!(straight, [0.0, 0.0, 0.0, 0.0, 0.0, -1.0]);
    assert_eq!(printed[2], "blocked,5,stop");
    assert_eq!(printed[3], "blocked,5,miss");
    assert_eq!(printed[4], "blocked,5,miss");
    assert_eq!(printed.len(), 5);

    // A hemisphere behind a plane front with a narrow rim.
    let ball = write(&folder, "ball.dat", "1e9 9 1.9 12\n-8 9 1 15.9\n0 0 0 30\n");
    let rays = "0,0,20,0,0,-1\n\
                14,0,20,-14,0,-19\n\
                9,0,20,0,0,-1\n\
                7.97,0,20,0,0,-1\n\
                14,0,20,-8,0,-19\n";
    let rays = write(&folder, "ball.csv", rays);
    for precision in ["f32", "f64"] {
        let printed = lines(&trace(&ball, &rays, &["--precision", precision]));
        assert!(!printed[0].starts_with("blocked"), "{printed:?}");
        // Through the centre of the ball, at 36 degrees to the plane: beyond 31.8 total reflection.
        assert_eq!(printed[1], "blocked,1,tir");
        assert_eq!(printed[2], "blocked,2,miss");
        assert_eq!(printed[3], "blocked,2,clip");
        assert!(printed[4].starts_with("blocked,1,"), "{printed:?}");
    }
}

#[test]
fn f32_prints_nine_digits_and_f64_seventeen() {
    let folder = folder();
    let rays = write(&folder, "rays.csv", "1,1,68.81,-0.01,-0.02,-1\n");
    let path = root().join("lenses/dgauss.50mm.dat");
    for (precision, digits) in [("f32", 9), ("f64", 17)] {
        let printed = lines(&trace(&path, &rays, &["--precision", precision]));
        for number in printed[0].split(',') {
            let mantissa = number.split('e').next().unwrap();
            assert_eq!(mantissa.chars().filter(char::is_ascii_digit).count(), digits, "{number}");
        }
    }
}

#[test]
fn bad_rays_are_named_with_their_line() {
    let folder = folder();
    let path = root().join("lenses/dgauss.50mm.dat");
    for (rays, expected) in [
        ("1,2,3,4,5,6\n1,2,3,4,5\n", "rays.csv:2: 5 columns; expected x,y,z,dx,dy,dz"),
        ("1,2,3,4,5,6\n1,2,x,4,5,6\n", "rays.csv:2: \"x\" is not a finite number"),
        ("1,2,3,4,5,nan\n", "rays.csv:1: \"nan\" is not a finite number"),
        ("1,2,3,0,0,0\n", "rays.csv:1: a ray without a direction"),
    ] {
        let rays = write(&folder, "rays.csv", rays);
        let output = trace(&path, &rays, &[]);
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2));
        assert!(stderr.contains(expected), "{stderr}");
    }
    let output = trace(&path, Path::new("no.csv"), &[]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("cannot read the rays no.csv"));
}

#[test]
fn rays_that_graze_a_rear_hemisphere_stay_within_the_bound_in_f32() {
    let folder = folder();
    for seed in 0..12 {
        let mut random = Random::new(seed);
        let hemisphere = Hemisphere::random(&mut random);
        let (radius, length) = (hemisphere.radius(), hemisphere.lens.length());
        let (mut table, mut rays) = (String::new(), String::new());
        for row in &hemisphere.lens.rows {
            let (stop, Row { radius, thickness, index, diameter, .. }) = (row.stop, row);
            let _ = writeln!(
                table,
                "[[surface]]\nradius = {radius:?}\nthickness = {thickness:?}\nindex = {index:?}\n\
                 diameter = {diameter:?}\nstop = {stop}"
            );
        }
        for _ in 0..10_000 {
            let [p, d] = hemisphere.ray(&mut random);
            let way = radius * 10f64.powf(random.between(0.0, 1.5));
            let [x, y, z] = [0, 1, 2].map(|i| p[i] - way * d[i]);
            let _ = writeln!(rays, "{x},{y},{},{},{},{}", length - z, d[0], d[1], -d[2]);
        }
        let (lens, csv) = (write(&folder, "lens.toml", table), write(&folder, "rays.csv", rays));
        let [single, double] =
            ["f32", "f64"].map(|precision| lines(&trace(&lens, &csv, &["--precision", precision])));
        let (mut through, mut worst) = (0, 0.0f64);
        for (single, double) in single.iter().zip(&double) {
            let numbers = |line: &str| -> Option<Vec<f64>> {
                line.split(',').map(|word| word.parse().ok()).collect()
            };
            let (Some(a), Some(b)) = (numbers(single), numbers(double)) else { continue };
            through += 1;
            worst = worst.max(1e6 * (3..6).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt());
        }
        assert!(through > 1000, "lens {seed}: {through} rays leave the lens");
        assert!(worst < 5.0, "lens {seed}: {worst} urad");
    }
}
