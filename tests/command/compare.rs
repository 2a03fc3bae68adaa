//! Error metrics against independent implementations, and the command `compare`.

use crate::support::{folder, petzval, write, write_picture};
use petzval_base::sampler::hash;
use petzval_image::Picture;
use petzval_tools::metric::{
    DynamicRange, Measurement, Metric, flip_hdr, flip_ldr, measure, pixels_per_degree,
};
use std::path::Path;

const SIZE: [usize; 2] = [72, 48];

/// Returns a picture and its reference: noise, a shift, or noise on a scene with a bright light. The other
/// implementations measured pictures of the same formulas.
fn pair(kind: &str) -> [Picture; 2] {
    let [w, h] = SIZE;
    let mut pixels = [Vec::new(), Vec::new()];
    for y in 0..h {
        for x in 0..w {
            let board = |x: usize| ((x / 8 + y / 8) % 2) as f64 * 0.8 + 0.1;
            let number = |c: usize| {
                let i = ((y * w + x) * 3 + c) as u32;
                f64::from(hash(i) >> 8) / 16_777_216.0
            };
            let base = [x as f64 / w as f64, y as f64 / h as f64, board(x)];
            let (mut seen, mut right) = ([0.0; 3], base);
            for c in 0..3 {
                seen[c] = match kind {
                    "noise" => base[c] + (number(c) - 0.5) * 0.2,
                    "shift" => [base[0], base[1], board(x + 2)][c],
                    _ => {
                        let inside = x.abs_diff(20).pow(2) + y.abs_diff(15).pow(2) < 16;
                        right[c] = 0.05 + base[c] * base[c] * 3.0;
                        right[c] += if inside { 200.0 } else { 0.0 };
                        right[c] * (0.8 + 0.4 * number(c))
                    }
                };
            }
            pixels[0].push(seen.map(|v| v as f32));
            pixels[1].push(right.map(|v| v as f32));
        }
    }
    pixels.map(|pixels| Picture { size: SIZE, pixels })
}

fn clipped(picture: &Picture) -> Picture {
    let pixels = picture.pixels.iter().map(|p| p.map(|c| c.clamp(0.0, 1.0))).collect();
    Picture { size: picture.size, pixels }
}

/// MSE, relMSE, MAPE, FLIP and PSNR. NumPy 1.26 computed them in f64, flip-evaluator 1.7 computed FLIP.
const VALUES: [(&str, [f64; 5]); 3] = [
    ("noise", [0.0032506065, 0.0579311865, 0.2348646233, 0.1072716713, 22.4301547055]),
    ("shift", [0.0533333300, 1.3658535539, 0.3396603258, 0.2506146729, 15.1495733263]),
    ("light", [7.7207727872, 0.0107485743, 0.0962782580, 0.0796694383, 33.4660871074]),
];

#[test]
fn metrics_agree_with_other_implementations() {
    for (kind, values) in VALUES {
        let [mut picture, mut reference] = pair(kind);
        let range = if kind == "light" { DynamicRange::High } else { DynamicRange::Low };
        if range == DynamicRange::Low {
            [picture, reference] = [clipped(&picture), clipped(&reference)];
        }
        for (metric, expected) in Metric::ALL.into_iter().zip(values) {
            let Measurement { value: found, map } =
                measure(metric, &picture, &reference, range).expect("one size");
            println!("{kind} {}: {found:.8}, {expected:.8} by others", metric.name());
            assert!((found / expected - 1.0).abs() < 1e-4, "{kind} {metric:?}: {found}");
            assert_eq!(map.len(), SIZE[0] * SIZE[1]);
        }
    }
}

#[test]
fn flip_uses_the_exposures_of_its_authors() {
    let [picture, reference] = pair("light");
    let flip = flip_hdr(&picture, &reference, pixels_per_degree());
    let [start, stop] = flip.exposures;
    println!("{start} {stop} {}", flip.count);
    assert!((start - -6.564_161_8).abs() < 1e-4 && (stop - 1.199_218_5).abs() < 2e-4);
    assert_eq!(flip.count, 8);
}

#[test]
fn equal_pictures_have_no_error_and_opposites_the_largest() {
    let [picture, reference] = pair("noise");
    let value = |metric, a: &Picture, b: &Picture, range| {
        measure(metric, a, b, range).expect("one size").value
    };
    for metric in [Metric::Mse, Metric::RelMse, Metric::Mape, Metric::Flip] {
        for range in [DynamicRange::Low, DynamicRange::High] {
            assert_eq!(value(metric, &reference, &reference, range), 0.0);
        }
        assert!(value(metric, &picture, &reference, DynamicRange::Low) > 0.0);
    }
    let psnr = value(Metric::Psnr, &picture, &picture, DynamicRange::Low);
    assert_eq!(psnr, f64::INFINITY);
    let of = |pixel| Picture { size: [20, 20], pixels: vec![pixel; 400] };
    let most = flip_ldr(&of([0.0, 1.0, 0.0]), &of([0.0, 0.0, 1.0]), pixels_per_degree());
    assert!(most.iter().all(|&off| (off - 1.0).abs() < 1e-4), "{}", most[0]);
    // A black picture has no median to expose for.
    let black = value(Metric::Flip, &of([0.0; 3]), &of([0.0; 3]), DynamicRange::High);
    assert_eq!(black, 0.0);
}

fn save(at: &Path, name: &str, picture: &Picture) {
    write_picture(picture, at.join(name));
}

#[test]
fn the_command_prints_metrics_and_fails_above_a_limit() {
    let folder = folder();
    let at = folder.path();
    let [picture, reference] = pair("light");
    save(at, "a.exr", &picture);
    save(at, "b.exr", &reference);
    save(at, "a.png", &picture);
    save(at, "b.png", &reference);
    let (code, stdout, _) = petzval(at, &["compare", "a.exr", "b.exr"]);
    assert_eq!(code, 0);
    let first: Vec<&str> = stdout.lines().filter_map(|line| line.split(' ').next()).collect();
    assert_eq!(first, ["mse", "relmse", "mape", "flip", "psnr"]);

    let (code, stdout, _) =
        petzval(at, &["compare", "a.exr", "b.exr", "--json", "--metric", "flip,mse"]);
    let json: serde_json::Value = serde_json::from_str(&stdout).expect("JSON");
    assert_eq!(code, 0);
    assert!((json["flip"].as_f64().expect("a number") - VALUES[2].1[3]).abs() < 1e-5);
    assert!((json["mse"].as_f64().expect("a number") / VALUES[2].1[0] - 1.0).abs() < 1e-5);

    for (arguments, expected) in [
        (&["--metric", "relmse", "--fail-above", "0.02"][..], 0),
        (&["--metric", "relmse", "--fail-above", "0.01"], 1),
        (&["--metric", "psnr", "--fail-above", "30"], 0),
        (&["--metric", "psnr", "--fail-above", "40"], 1),
        (&["--metric", "ssim"], 2),
    ] {
        let (code, _, stderr) = petzval(at, &[&["compare", "a.exr", "b.exr"], arguments].concat());
        assert_eq!(code, expected, "{arguments:?}: {stderr}");
    }
    // PNGs are compared as displayed. The map of differences is a picture.
    let (code, ..) =
        petzval(at, &["compare", "a.png", "b.png", "--metric", "flip", "--map", "m.png"]);
    assert_eq!(code, 0);
    let map = Picture::read(&at.join("m.png")).expect("a picture");
    assert_eq!(map.size, SIZE);
    assert!(map.pixels.iter().any(|p| p[0] > 0.1) && map.pixels.iter().any(|p| p[0] < 0.01));
}

#[test]
fn pictures_that_cannot_be_compared_are_refused() {
    let folder = folder();
    let at = folder.path();
    let [picture, _] = pair("noise");
    save(at, "a.exr", &picture);
    let small = Picture { size: [2, 1], pixels: vec![[0.5; 3]; 2] };
    save(at, "small.exr", &small);
    let hole = Picture { size: [2, 1], pixels: vec![[0.5; 3], [f32::NAN, 0.0, 0.0]] };
    save(at, "hole.exr", &hole);
    write(&folder, "words.png", "no picture");
    for (other, expected) in [
        ("small.exr", "has 72 x 48 pixels and small.exr 2 x 1"),
        ("none.exr", "cannot read the picture none.exr"),
        ("words.png", "words.png"),
        ("a.psd", "names no picture format"),
    ] {
        let (code, stdout, stderr) = petzval(at, &["compare", "a.exr", other]);
        assert!(code == 2 && stdout.is_empty() && stderr.contains(expected), "{other}: {stderr}");
    }
    let (code, _, stderr) = petzval(at, &["compare", "small.exr", "hole.exr"]);
    assert!(code == 2 && stderr.contains("pixel 1,0"), "{stderr}");
}
