//! Point spread functions against theory.

use std::f64::consts::{PI, TAU};

use petzval_lens::{ApertureMask, ExitPupil, Iris, RealLens, RealRayFocus, Wavefront};
use petzval_render::diffraction::PointSpread;
use petzval_spectrum::bands;

use super::{GREEN, blades, dgauss, first_minimum};

#[test]
fn the_airy_disc_has_its_radius_and_share_of_light() {
    // The f-number comes from the sine of the marginal ray, which is independent of the pupil.
    let lens = dgauss(22.0, Iris::Round);
    let f_number = RealRayFocus::new(&lens.prescription).f_number().expect("an f-number");
    assert!((f_number / 22.0 - 1.0).abs() < 0.01, "{f_number}");
    let pupil = ExitPupil::trace(&lens, [0.0; 2]).expect("light");
    let expected = 1.219_67 * GREEN * f_number;
    for angle in [0.0, 1.1, 2.5] {
        let zero = first_minimum(2.0 * expected, |r| {
            pupil.density([r * f64::cos(angle), r * f64::sin(angle)], GREEN)
        });
        assert!((zero / expected - 1.0).abs() < 0.005, "{zero} um, expected {expected}");
    }
    assert!((pupil.airy_radius(GREEN) / expected - 1.0).abs() < 0.005);
    // 83.8 % of the light is inside the first dark ring, 91.0 % inside the second (Rayleigh 1881).
    let inside = |radius: f64| {
        let (rings, spokes) = (400, 16);
        let at = |i: usize| radius * (i as f64 + 0.5) / rings as f64;
        let ring = |i: usize| {
            let around = (0..spokes).map(|j| {
                let (sin, cos) = (TAU * f64::from(j) / f64::from(spokes)).sin_cos();
                pupil.density([at(i) * cos, at(i) * sin], GREEN)
            });
            around.sum::<f64>() / f64::from(spokes) * TAU * at(i) * radius / rings as f64
        };
        (0..rings).map(ring).sum::<f64>()
    };
    for (zero, expected_share) in [(1.219_67, 0.838), (2.233_13, 0.910)] {
        let share = inside(expected * zero / 1.219_67);
        assert!((share - expected_share).abs() < 0.004, "{share}, expected {expected_share}");
    }
}

#[test]
fn the_table_of_white_light_is_the_sum_over_wavelengths() {
    // The expected values are sums of the closed formula over 50 wavelengths of each band.
    let lens = dgauss(16.0, blades(7, 10.0));
    let pupil = ExitPupil::trace(&lens, [0.0; 2]).expect("light");
    let spread = PointSpread::new(&pupil, &bands(), 3000.0, 5.0);
    let bands = bands();
    let width = 1e-3 * (bands[1].wavelength - bands[0].wavelength);
    for radius in [0.0, 2.0, 6.0, 11.0, 30.0, 90.0, 400.0] {
        for angle in [0.3, 1.0, 2.9] {
            let at = [radius * f64::cos(angle), radius * f64::sin(angle)];
            let mut expected = [0.0; 3];
            for band in &bands {
                for i in 0..50 {
                    let share = (f64::from(i) + 0.5) / 50.0 - 0.5;
                    let density = pupil.density(at, 1e-3 * band.wavelength + width * share);
                    for c in 0..3 {
                        expected[c] += density * band.response[c] / (50.0 * bands.len() as f64);
                    }
                }
            }
            let found = spread.at(at);
            let bright = expected.into_iter().fold(0.0, f64::max);
            for c in 0..3 {
                let off = (found[c] - expected[c]).abs();
                // The radii of the table are 2 % apart, which matters where the function is steep.
                let bound = if radius < 3.0 { 0.004 } else { 0.02 };
                assert!(off < bound * bright, "{radius} um, {angle}: {found:?}, not {expected:?}");
            }
        }
    }
}

#[test]
fn a_square_stop_has_the_zeros_of_a_sine() {
    let side = 0.05;
    let pupil = ExitPupil::polygon(&[[0.0, 0.0], [side, 0.0], [side, side], [0.0, side]]);
    let sinc = |x: f64| if x == 0.0 { 1.0 } else { (PI * x).sin() / (PI * x) };
    let peak = side * side / (GREEN * GREEN);
    for [x, y] in [[0.0, 0.0], [3.0, 0.0], [5.0, -8.0], [16.5, 40.0], [120.0, 1.0]] {
        let expected = peak * (sinc(x * side / GREEN) * sinc(y * side / GREEN)).powi(2);
        let found = pupil.density([x, y], GREEN);
        assert!((found - expected).abs() < 1e-9 * peak, "{x}, {y}: {found}, not {expected}");
    }
    // The zeros of a square aperture are at multiples of lambda / side, whether blades form it or a mask.
    let mask = Iris::Mask(ApertureMask::named("square").expect("a mask of pbrt's"));
    for (iris, turned) in [(blades(4, 45.0), true), (mask, false)] {
        let pupil = ExitPupil::trace(&dgauss(8.0, iris), [0.0; 2]).expect("light");
        let zero = GREEN / pupil.width(0.0);
        for k in [1.0, 2.0, 5.0] {
            let along = |r: f64| pupil.density([r, 0.0], GREEN) + pupil.density([0.0, r], GREEN);
            let (at, between) = (along(k * zero), along((k + 0.5) * zero));
            assert!(at < 0.01 * between, "{turned}, {k}: {at} and {between}");
        }
    }
}

/// Returns the directions of the rays far from the light (tenths of a degree).
fn rays(lens: &RealLens) -> Vec<usize> {
    let pupil = ExitPupil::trace(lens, [0.0; 2]).expect("light");
    let spread = PointSpread::new(&pupil, &bands(), 2000.0, 5.0);
    let far = |tenths: usize| {
        let (sin, cos) = (0.1 * tenths as f64).to_radians().sin_cos();
        let radii = (0..40).map(|i| 400.0 + 10.0 * f64::from(i));
        radii.map(|radius| spread.at([radius * cos, radius * sin])[1]).sum::<f64>()
    };
    let steps = 3600;
    let around: Vec<f64> = (0..steps).map(far).collect();
    let mean = around.iter().sum::<f64>() / steps as f64;
    let peak = |&i: &usize| {
        let near = |k: usize| around[(i + k + steps - 20) % steps];
        around[i] > 4.0 * mean && (0..=40).all(|k| near(k) <= around[i])
    };
    (0..steps).filter(peak).collect()
}

/// Checks that the rays stand at right angles to the blades, whose first corner is rotated.
fn assert_rays(found: &[usize], count: u32, rotation: f64, what: &str) {
    let rays = if count.is_multiple_of(2) { count } else { 2 * count };
    assert_eq!(found.len(), rays as usize, "{what}: {found:?}");
    // The middle of the first blade is half an angle beyond the first corner.
    let first = rotation + 180.0 / f64::from(count);
    let between = 360.0 / f64::from(rays);
    for ray in found {
        let off = (0.1 * *ray as f64 - first).rem_euclid(between);
        assert!(off.min(between - off) < 0.3, "{what}: a ray at {} degrees", 0.1 * *ray as f64);
    }
}

#[test]
fn blades_cause_rays_at_right_angles() {
    // Far from the centre light concentrates in rays at right angles to each blade, to both sides.
    for count in 5..9 {
        let rays = rays(&dgauss(16.0, blades(count, 11.0)));
        assert_rays(&rays, count, 11.0, &format!("{count} blades"));
    }
}

/// The corners of pixels would spread light along rows and columns, and take the rays from the blades.
#[test]
fn drawn_blades_cause_the_rays_of_blades() {
    let mask = ApertureMask::named("pentagon").expect("a mask of pbrt's");
    let lens = dgauss(12.0, Iris::Mask(mask));
    assert_rays(&rays(&lens), 5, 90.0, "a drawn pentagon");
    // Its edges are straight: a pixel of the mask is 0.005 of the width.
    let pupil = ExitPupil::trace(&lens, [0.0; 2]).expect("light");
    let corners = || pupil.edges.iter().map(|edge| edge.from);
    let sides: Vec<([f64; 2], f64)> = (0..5)
        .map(|k| {
            let (sin, cos) = (90.0 + 36.0 + 72.0 * f64::from(k)).to_radians().sin_cos();
            ([cos, sin], corners().map(|[x, y]| x * cos + y * sin).fold(f64::MIN, f64::max))
        })
        .collect();
    for [x, y] in corners() {
        let within = sides.iter().map(|([cos, sin], side)| side - (x * cos + y * sin));
        let within = within.fold(f64::MAX, f64::min) / pupil.width(0.0);
        assert!(within < 0.003, "{within} of the width within the sides");
    }
}

#[test]
fn an_opening_that_darkens_towards_its_rim_has_weaker_rings() {
    // The first ring of a round pupil has 0.0175 of its centre, at 1.635 lambda N.
    let ring = |iris: Iris| {
        let pupil = ExitPupil::trace(&dgauss(8.0, iris), [0.0; 2]).expect("light");
        let n = 1.0 / pupil.width(0.0);
        let most = |from: f64| {
            let radii = (0..60).map(|i| (from + 0.01 * f64::from(i)) * GREEN * n);
            radii.map(|radius| pupil.density([radius, 0.0], GREEN)).fold(0.0, f64::max)
        };
        most(1.35) / pupil.density([0.0; 2], GREEN)
    };
    let round = ring(Iris::Round);
    assert!((round - 0.0175).abs() < 5e-4, "{round}");
    let gaussian = ApertureMask::named("gaussian").expect("a mask of pbrt's");
    let soft = ring(Iris::Mask(gaussian));
    assert!(soft > 1e-4 && soft < 0.012, "{soft}");
}

#[test]
fn a_good_wavefront_gives_the_point_spread_of_its_pupil_shape() {
    // The lens is limited by diffraction at f/22 and not wide open.
    for (f_number, good) in [(22.0, true), (11.0, true), (2.0, false)] {
        let lens = dgauss(f_number, Iris::Round);
        let pupil = ExitPupil::trace(&lens, [0.0; 2]).expect("light");
        let front = Wavefront::new(&lens, [0.0; 2], &pupil).expect("a wavefront");
        let waves = 1e3 * front.rms / GREEN;
        assert_eq!(waves < 1.0 / 14.0, good, "f/{f_number}: {waves} waves");
        let wave = |x: f64| {
            let (mut re, mut im) = (0.0, 0.0);
            for delay in &front.points {
                let (sin, cos) =
                    (TAU * (1e3 * delay.path_difference - delay.pupil[0] * x) / GREEN).sin_cos();
                (re, im) = (re + cos, im + sin);
            }
            (re * re + im * im) / (front.points.len() as f64).powi(2)
        };
        let shape = |x: f64| pupil.density([x, 0.0], GREEN) / pupil.density([0.0; 2], GREEN);
        let strehl = wave(0.0);
        println!("f/{f_number}: {waves:.4} waves rms, Strehl ratio {strehl:.4}");
        if good {
            // exp(-(2 pi sigma)^2) (Mahajan 1983).
            assert!((strehl - (-(TAU * waves).powi(2)).exp()).abs() < 0.005, "{strehl}");
            for i in 0..40 {
                let x = 2.0 * pupil.airy_radius(GREEN) * f64::from(i) / 40.0;
                let bound = 1.0 - strehl + 0.01;
                assert!((wave(x) - shape(x)).abs() < bound, "{x}: {} {}", wave(x), shape(x));
            }
        } else {
            assert!(strehl < 0.8, "{strehl}");
        }
    }
}

#[test]
fn monochromatic_light_has_sharp_rings() {
    // With a passband of 2 nm the first ring of Airy's pattern is dark.
    let lens = dgauss(22.0, Iris::Round);
    let pupil = ExitPupil::trace(&lens, [0.0; 2]).expect("light");
    let narrow = petzval_spectrum::Passband { range: [549.0, 551.0] };
    let spread = PointSpread::new(&pupil, &narrow.bands(), 500.0, 1.0);
    let white = PointSpread::new(&pupil, &bands(), 500.0, 1.0);
    let (zero, peak) = (pupil.airy_radius(GREEN), pupil.density([0.0; 2], GREEN));
    for (found, channel) in spread.at([0.0, zero]).into_iter().zip(0..) {
        assert!(found < 3e-4 * peak && white.at([0.0, zero])[channel] > 3e-4 * peak, "{found}");
        let ring = spread.at([0.0, 1.635 / 1.22 * zero])[channel];
        assert!((ring / peak - 0.0175).abs() < 5e-4, "the first bright ring: {}", ring / peak);
    }
}
