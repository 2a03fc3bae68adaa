//! The same picture, bit for bit, whatever computes it.

mod support;

use petzval::film::Frame;
use petzval::image::Picture;
use petzval::job::{Changes, prepare};
use petzval::render::{Backend, Job};
use petzval::scene::pbrt;
use support::{picture, root};

fn job(scene: &str, changes: &Changes) -> Job {
    let description = pbrt::read(&root().join("scenes").join(scene)).expect("a scene");
    prepare(description, changes).expect("a job").0
}

fn small(scene: &str) -> Job {
    let resolution = Some([45, 37]);
    job(scene, &Changes { resolution, samples: Some(24), ..Changes::default() })
}

fn assert_same(one: &Picture, other: &Picture, what: &str) {
    assert_eq!(one.size, other.size, "{what}");
    for (i, (a, b)) in one.pixels.iter().zip(&other.pixels).enumerate() {
        let bits = |p: &[f32; 3]| p.map(f32::to_bits);
        let (x, y) = (i % one.size[0], i / one.size[0]);
        assert_eq!(bits(a), bits(b), "{what}: pixel {x}, {y}: {a:?} and {b:?}");
    }
    assert!(one.pixels.iter().any(|p| p[0] > 0.0), "{what}: a black picture shows nothing");
}

const SCENES: [&str; 6] =
    ["dgauss.pbrt", "fisheye.pbrt", "telephoto.pbrt", "wide.pbrt", "snowman.pbrt", "atelier.pbrt"];

#[test]
fn any_number_of_threads_gives_the_same_picture() {
    for scene in SCENES {
        let job = small(scene);
        let one = picture(&job, Backend::Simd, 1);
        for threads in [2, 7] {
            assert_same(
                &one,
                &picture(&job, Backend::Simd, threads),
                &format!("{scene}, {threads}"),
            );
        }
    }
}

#[test]
fn one_lane_gives_the_picture_of_eight() {
    for scene in SCENES {
        let job = small(scene);
        let eight = picture(&job, Backend::Simd, 2);
        assert_same(&eight, &picture(&job, Backend::Scalar, 2), scene);
    }
}

#[test]
fn a_crop_is_a_part_of_the_whole() {
    let whole = small("dgauss.pbrt");
    let part = Job { frame: Frame { low: [9, 5], high: [40, 29], ..whole.frame }, ..whole.clone() };
    let whole = picture(&whole, Backend::Simd, 2);
    let part = picture(&part, Backend::Simd, 2);
    let pixels = (5..29).flat_map(|y| whole.pixels[y * 45 + 9..y * 45 + 40].iter().copied());
    assert_same(&Picture { size: [31, 24], pixels: pixels.collect() }, &part, "crop");
}

#[test]
fn sample_ranges_add_up_to_the_whole() {
    let whole = small("wide.pbrt");
    let first = Job { samples: 0..8, ..whole.clone() };
    let rest = Job { samples: 8..24, ..whole.clone() };
    let [whole, first, rest] = [whole, first, rest].map(|job| picture(&job, Backend::Simd, 2));
    for i in 0..whole.pixels.len() {
        for c in 0..3 {
            let sum = (first.pixels[i][c] * 8.0 + rest.pixels[i][c] * 16.0) / 24.0;
            assert!((sum - whole.pixels[i][c]).abs() <= 1e-6 * whole.pixels[i][c].abs());
        }
    }
}

#[test]
fn another_seed_is_another_picture() {
    let job = small("dgauss.pbrt");
    let other = Job { seed: 1, ..job.clone() };
    let [one, other] = [job, other].map(|job| picture(&job, Backend::Simd, 2));
    assert_ne!(one, other);
    let [a, b] = [&one, &other].map(|p| support::mean(p)[0]);
    assert!((a / b - 1.0).abs() < 0.02, "{a} and {b}");
}
