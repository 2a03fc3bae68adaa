//! Diffraction in pictures of stars and of uniform light.

use std::f64::consts::PI;

use petzval_image::Picture;
use petzval_lens::{Camera, ExitPupil, Iris, LensModel, RealLens};
use petzval_render::diffraction::{Diffraction, PointSpread};
use petzval_render::film::Frame;
use petzval_spectrum::bands;

use super::{GREEN, blades, dgauss, first_minimum};

/// Returns a camera with square pixels of this pitch, um, and its frame.
fn camera(lens: RealLens, pitch: f64, size: [u32; 2]) -> (Camera, Frame) {
    let camera = Camera {
        model: LensModel::Real(Box::new(lens)),
        film: size.map(|n| f64::from(n) * pitch * 1e-3),
        world_from_camera: glam::DAffine3::IDENTITY,
        imaging_ratio: 1.0,
        depth: [0.0, f64::INFINITY],
    };
    (camera, Frame::whole(size))
}

/// Returns a black picture with one white pixel.
fn star(size: [u32; 2], at: [u32; 2]) -> Picture {
    let size = size.map(|n| n as usize);
    let mut pixels = vec![[0.0; 3]; size[0] * size[1]];
    pixels[at[1] as usize * size[0] + at[0] as usize] = [1.0; 3];
    Picture { size, pixels }
}

fn sum(picture: &Picture, channel: usize) -> f64 {
    picture.pixels.iter().map(|pixel| f64::from(pixel[channel])).sum()
}

#[test]
fn the_light_of_a_point_is_conserved() {
    // At f/22 a millimetre holds all but a thousandth of the light (2 lambda N / (pi^2 r)).
    for (iris, f_number) in [(Iris::Round, 22.0), (blades(6, 0.0), 11.0)] {
        let (camera, frame) = camera(dgauss(f_number, iris), 12.0, [401, 401]);
        let spread =
            Diffraction::new(&camera, &frame, &bands()).spread(&star([401, 401], [200, 200]));
        for c in 0..3 {
            let lost = 1.0 - sum(&spread, c);
            println!("channel {c} of f/{f_number}: {lost}");
            assert!(lost.abs() < 1e-3, "channel {c} of f/{f_number}: {lost}");
        }
        assert!(spread.pixels.iter().flatten().all(|v| v.is_finite() && *v >= 0.0));
        // Both pupils are the same if they are rotated by 180 degrees.
        for (x, y) in [(3, 1), (40, 17), (70, 2), (100, 0), (120, 90), (180, 33)] {
            let at = |x: i32, y: i32| spread.pixels[((200 + y) * 401 + 200 + x) as usize][1];
            let [one, other] = [at(x, y), at(-x, -y)];
            assert!((one / other - 1.0).abs() < 5e-3, "f/{f_number}, {x}, {y}: {one}, {other}");
            let mirrored = at(-x, y);
            assert!(
                (one / mirrored - 1.0).abs() < 0.02,
                "f/{f_number}, {x}, {y}: {one}, {mirrored}"
            );
        }
        // The convolution does not wrap around: light only fades outwards.
        let row = |x: usize| spread.pixels[200 * 401 + x][1];
        assert!(row(400) < 1e-3 * row(210) && row(0) < 1e-3 * row(190));
    }
}

#[test]
fn light_that_leaves_the_film_does_not_wrap_around() {
    // A star at an edge: the light towards the other edge follows the point spread function, without
    // light that left the film on the near side.
    let lens = dgauss(22.0, Iris::Round);
    let pupil = ExitPupil::trace(&lens, [0.0; 2]).expect("light");
    let spread = PointSpread::new(&pupil, &bands(), 5000.0, 12.0);
    let (camera, frame) = camera(lens, 12.0, [301, 41]);
    let diffraction = Diffraction::new(&camera, &frame, &bands());
    for (edge, inwards) in [(8, 1), (292, -1)] {
        let picture = diffraction.spread(&star([301, 41], [edge, 20]));
        for far in [20, 40, 60, 80, 100, 150, 200, 280] {
            let expected = spread.at([0.0, 12.0 * f64::from(far)]).map(|v| 144.0 * v);
            let at = 20 * 301 + edge as i32 + inwards * far;
            let found = picture.pixels[at as usize].map(f64::from);
            for c in 0..3 {
                let off = found[c] / expected[c] - 1.0;
                assert!(off.abs() < 0.08, "{edge}, {far}: {found:?}, not {expected:?}");
            }
        }
    }
}

#[test]
fn a_uniform_picture_stays_uniform_to_its_edge() {
    for lens in [dgauss(22.0, Iris::Round), dgauss(2.0, Iris::Round)] {
        let (camera, frame) = camera(lens, 200.0, [90, 60]);
        let diffraction = Diffraction::new(&camera, &frame, &bands());
        let white = Picture { size: [90, 60], pixels: vec![[2.0, 1.0, 0.5]; 90 * 60] };
        for pixel in diffraction.spread(&white).pixels {
            for (found, expected) in pixel.into_iter().zip([2.0, 1.0, 0.5]) {
                assert!((found / expected - 1.0).abs() < 2e-3, "{found}, not {expected}");
            }
        }
    }
}

/// Beyond 64 pixels light is spread by other zones, whose shares must complete those of the near ones.
#[test]
fn pictures_of_any_shape_stay_uniform() {
    for (size, pitch) in [
        ([300, 40], 100.0),
        ([40, 300], 90.0),
        ([301, 1], 20.0),
        ([1, 200], 20.0),
        ([1, 1], 5.0),
        ([2, 1], 5.0),
    ] {
        for f_number in [2.0, 16.0] {
            let (camera, frame) = camera(dgauss(f_number, blades(5, 0.0)), pitch, size);
            let diffraction = Diffraction::new(&camera, &frame, &bands());
            let [width, height] = size.map(|n| n as usize);
            let white = Picture { size: [width, height], pixels: vec![[1.0; 3]; width * height] };
            for (i, pixel) in diffraction.spread(&white).pixels.into_iter().enumerate() {
                for found in pixel {
                    assert!((found - 1.0).abs() < 3e-3, "{size:?} f/{f_number}, {i}: {found}");
                }
            }
        }
    }
}

#[test]
fn a_spread_much_narrower_than_a_pixel_changes_nothing() {
    let (camera, frame) = camera(dgauss(2.0, Iris::Round), 100.0, [64, 48]);
    let spread = Diffraction::new(&camera, &frame, &bands()).spread(&star([64, 48], [20, 30]));
    for (i, pixel) in spread.pixels.iter().enumerate() {
        let expected = if i == 30 * 64 + 20 { 1.0 } else { 0.0 };
        // Half a percent of the light is beyond half a pixel (2 lambda N / (pi^2 r)).
        assert!(pixel.iter().all(|v| (v - expected).abs() < 0.008), "{i}: {pixel:?}");
    }
}

#[test]
fn a_vignetted_pupil_spreads_light_across_its_narrow_side() {
    // Wide open the pupil of the corner is narrow along the radius, so the spread is long there.
    let lens = dgauss(2.0, Iris::Round);
    let [middle, corner] =
        [[0.0; 2], [15.0, 0.0]].map(|film| ExitPupil::trace(&lens, film).expect("light"));
    let narrow = corner.width(0.0) / corner.width(PI / 2.0);
    assert!(narrow < 0.8, "{narrow}");
    assert!((middle.width(0.0) / middle.width(PI / 2.0) - 1.0).abs() < 1e-3);
    let zero = |angle: f64| {
        first_minimum(6.0, |r| corner.density([r * f64::cos(angle), r * f64::sin(angle)], GREEN))
    };
    let long = zero(0.0) / zero(PI / 2.0);
    assert!((long * narrow - 1.0).abs() < 0.2, "{long} times as long for {narrow} as wide");
    // The same holds in the picture, along the radius of the corner.
    let (camera, frame) = camera(lens, 1.0, [21_000, 21_000]);
    let crop = Frame { low: [20_900, 20_900], high: [21_000, 21_000], ..frame };
    let spread = Diffraction::new(&camera, &crop, &bands()).spread(&star([100, 100], [50, 50]));
    let at = |x: usize, y: usize| spread.pixels[y * 100 + x][1];
    let along: f32 = (2..6).map(|k| at(50 + k, 50 + k) + at(50 - k, 50 - k)).sum();
    let across: f32 = (2..6).map(|k| at(50 + k, 50 - k) + at(50 - k, 50 + k)).sum();
    assert!(along > 1.5 * across, "{along} along the radius, {across} across");
}

#[test]
fn zones_blend_without_seams() {
    // The peaks of a row of points across a vignetted film change smoothly.
    let (camera, frame) = camera(dgauss(2.0, Iris::Round), 150.0, [160, 120]);
    let camera = Camera { film: [24.0, 18.0], ..camera };
    let diffraction = Diffraction::new(&camera, &frame, &bands());
    assert!(diffraction.zones() > 1);
    let fine = Camera { film: [24.0, 18.0], ..camera };
    let one = Frame::whole([24_000, 18_000]);
    let size = [600, 20];
    let frame = Frame { low: [11_700, 8_990], high: [12_300, 9_010], ..one };
    let points = Picture {
        size,
        pixels: (0..600 * 20)
            .map(|i| [if i / 600 == 10 && i % 600 % 10 == 5 { 1.0 } else { 0.0 }; 3])
            .collect(),
    };
    let spread = Diffraction::new(&fine, &frame, &bands()).spread(&points);
    let peaks: Vec<f32> = (1..59).map(|k| spread.pixels[10 * 600 + 10 * k + 5][1]).collect();
    for pair in peaks.windows(2) {
        assert!((pair[1] / pair[0] - 1.0).abs() < 0.02, "{peaks:?}");
    }
}

#[test]
fn the_picture_does_not_depend_on_threads() {
    let (camera, frame) = camera(dgauss(11.0, blades(5, 0.0)), 80.0, [150, 100]);
    let pixels = (0..150 * 100).map(|i| [(i * 7919 % 1000) as f32, 1.0, f32::NAN]).collect();
    let picture = Picture { size: [150, 100], pixels };
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| Diffraction::new(&camera, &frame, &bands()).spread(&picture))
    };
    let one = with(1);
    assert_eq!(one, with(3));
    assert!(one.pixels.iter().flatten().all(|v| v.is_finite() && *v >= 0.0));
}
