//! Light that bends at the stop: spreads against theory, and what they do to pictures.

mod support;

use std::f64::consts::{PI, TAU};

use petzval::diffraction::{Diffraction, Spread};
use petzval::film::Frame;
use petzval::image::Picture;
use petzval::job::{Changes, prepare};
use petzval::lens::{Aim, Camera, ExitPupil, Focus, Iris, Mask, Model, RealLens, Wavefront};
use petzval::plan::{Effect, Harm, Wanted};
use petzval::render::{Backend, Job, render};
use petzval::scene::pbrt;
use petzval::spectrum::bands;
use support::{folder, lens, root, write};

/// um.
const GREEN: f64 = 0.55;

/// The course's double Gauss, focused far away, its stop closed to an f-number.
fn dgauss(f_number: f64, iris: Iris) -> RealLens {
    let mut lens = lens("dgauss.50mm");
    let paraxial = petzval::lens::Paraxial::of(&lens);
    let stop = lens.stop();
    let diameter = lens.rows[stop].diameter * paraxial.f_number() / f_number;
    lens.stop_down(diameter);
    lens.rows[stop].iris = iris;
    let film = Focus::of(&lens).film(f64::INFINITY).expect("a film");
    RealLens::new(lens, film, 21.6, Aim::Pupil, 1e-3, 0.1)
}

fn blades(count: u32, rotation: f64) -> Iris {
    Iris::Blades { count, rotation, curvature: 0.0 }
}

/// A camera with square pixels of this pitch, um, and its frame.
fn camera(lens: RealLens, pitch: f64, size: [u32; 2]) -> (Camera, Frame) {
    let camera = Camera {
        model: Model::Real(Box::new(lens)),
        film: size.map(|n| f64::from(n) * pitch * 1e-3),
        world_from_camera: glam::DAffine3::IDENTITY,
        imaging_ratio: 1.0,
        depth: [0.0, f64::INFINITY],
    };
    (camera, Frame::whole(size))
}

/// A black picture with one white pixel.
fn star(size: [u32; 2], at: [u32; 2]) -> Picture {
    let size = size.map(|n| n as usize);
    let mut pixels = vec![[0.0; 3]; size[0] * size[1]];
    pixels[at[1] as usize * size[0] + at[0] as usize] = [1.0; 3];
    Picture { size, pixels }
}

fn sum(picture: &Picture, channel: usize) -> f64 {
    picture.pixels.iter().map(|pixel| f64::from(pixel[channel])).sum()
}

/// The first minimum of a function beyond 0, looked for up to an end.
fn first_minimum(end: f64, f: impl Fn(f64) -> f64) -> f64 {
    let steps = 4000;
    let at = |i: usize| end * i as f64 / steps as f64;
    let values: Vec<f64> = (0..=steps).map(|i| f(at(i))).collect();
    let lowest = (1..steps).find(|&i| values[i] < values[i - 1] && values[i] <= values[i + 1]);
    at(lowest.expect("a minimum"))
}

#[test]
fn airys_disc_has_its_radius_and_its_light() {
    // By the sine of the marginal ray, which knows nothing of pupils.
    let lens = dgauss(22.0, Iris::Round);
    let f_number = Focus::of(&lens.prescription).f_number().expect("an f-number");
    assert!((f_number / 22.0 - 1.0).abs() < 0.01, "{f_number}");
    let pupil = ExitPupil::seen(&lens, [0.0; 2]).expect("light");
    let expected = 1.219_67 * GREEN * f_number;
    for angle in [0.0, 1.1, 2.5] {
        let zero = first_minimum(2.0 * expected, |r| {
            pupil.density([r * f64::cos(angle), r * f64::sin(angle)], GREEN)
        });
        assert!((zero / expected - 1.0).abs() < 0.005, "{zero} um, expected {expected}");
    }
    assert!((pupil.airy(GREEN) / expected - 1.0).abs() < 0.005);
    // Rayleigh 1881: 83.8 % inside the first dark ring, 91.0 % inside the second.
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
    // Against sums over 50 wavelengths of each band of the closed form.
    let lens = dgauss(16.0, blades(7, 10.0));
    let pupil = ExitPupil::seen(&lens, [0.0; 2]).expect("light");
    let spread = Spread::new(&pupil, &bands(), 3000.0, 5.0);
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
                // Where the spread is steep, the table's radii are 2 % apart.
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
    // Four blades leave a square; traced, its zeros stand at multiples of lambda / side, whichever
    // of the two ways of seeing a pupil is taken.
    let mask = Iris::Mask(Mask::named("square").expect("a mask of pbrt's"));
    for (iris, turned) in [(blades(4, 45.0), true), (mask, false)] {
        let pupil = ExitPupil::seen(&dgauss(8.0, iris), [0.0; 2]).expect("light");
        let zero = GREEN / pupil.width(0.0);
        for k in [1.0, 2.0, 5.0] {
            let along = |r: f64| pupil.density([r, 0.0], GREEN) + pupil.density([0.0, r], GREEN);
            let (at, between) = (along(k * zero), along((k + 0.5) * zero));
            assert!(at < 0.01 * between, "{turned}, {k}: {at} and {between}");
        }
    }
}

#[test]
fn blades_give_rays_across_them() {
    // Light far out, by direction: a ray at right angles to each blade, to both sides.
    for (count, rays) in [(5, 10), (6, 6), (7, 14), (8, 8)] {
        let rotation = 11.0;
        let lens = dgauss(16.0, blades(count, rotation));
        let pupil = ExitPupil::seen(&lens, [0.0; 2]).expect("light");
        let spread = Spread::new(&pupil, &bands(), 2000.0, 5.0);
        let far = |degrees: f64| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            (0..40)
                .map(|i| {
                    spread.at([
                        (400.0 + 10.0 * f64::from(i)) * cos,
                        (400.0 + 10.0 * f64::from(i)) * sin,
                    ])[1]
                })
                .sum::<f64>()
        };
        let steps = 3600;
        let around: Vec<f64> = (0..steps).map(|i| far(0.1 * f64::from(i))).collect();
        let mean = around.iter().sum::<f64>() / f64::from(steps);
        let peak = |&i: &usize| {
            let near = |k: usize| around[(i + k + steps as usize - 20) % steps as usize];
            around[i] > 4.0 * mean && (0..=40).all(|k| near(k) <= around[i])
        };
        let peaks: Vec<usize> = (0..steps as usize).filter(peak).collect();
        assert_eq!(peaks.len(), rays, "{count} blades: {peaks:?}");
        // The first blade stands half an angle beyond the first corner.
        let first = rotation + 180.0 / f64::from(count);
        let between = 360.0 / rays as f64;
        for peak in peaks {
            let off = (0.1 * peak as f64 - first).rem_euclid(between);
            assert!(
                off.min(between - off) < 0.3,
                "{count} blades: a ray at {} degrees",
                0.1 * peak as f64
            );
        }
    }
}

#[test]
fn the_light_of_a_point_is_kept() {
    // In the middle; a millimetre holds all but a thousandth at f/22 (2 lambda N / (pi^2 r)).
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
        // Nothing comes back from the other side: light only fades outwards.
        let row = |x: usize| spread.pixels[200 * 401 + x][1];
        assert!(row(400) < 1e-3 * row(210) && row(0) < 1e-3 * row(190));
    }
}

#[test]
fn light_that_leaves_the_film_does_not_come_back() {
    // A star at an edge: towards the other one it gives what its spread says, and nothing of what
    // left on its own side.
    let lens = dgauss(22.0, Iris::Round);
    let pupil = ExitPupil::seen(&lens, [0.0; 2]).expect("light");
    let spread = Spread::new(&pupil, &bands(), 5000.0, 12.0);
    let (camera, frame) = camera(lens, 12.0, [301, 41]);
    let diffraction = Diffraction::new(&camera, &frame, &bands());
    for (edge, inwards) in [(8, 1), (292, -1)] {
        let picture = diffraction.spread(&star([301, 41], [edge, 20]));
        for far in [100, 200, 280] {
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
fn an_even_picture_stays_even_to_its_edge() {
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

#[test]
fn a_spread_much_narrower_than_a_pixel_changes_nothing() {
    let (camera, frame) = camera(dgauss(2.0, Iris::Round), 100.0, [64, 48]);
    let spread = Diffraction::new(&camera, &frame, &bands()).spread(&star([64, 48], [20, 30]));
    for (i, pixel) in spread.pixels.iter().enumerate() {
        let expected = if i == 30 * 64 + 20 { 1.0 } else { 0.0 };
        // 2 lambda N / (pi^2 r) of the light is beyond half a pixel: half a percent.
        assert!(pixel.iter().all(|v| (v - expected).abs() < 0.008), "{i}: {pixel:?}");
    }
}

#[test]
fn a_vignetted_pupil_spreads_light_across_its_narrow_side() {
    // Wide open the corner sees a cat's eye, narrow along the radius: the spread is long there.
    let lens = dgauss(2.0, Iris::Round);
    let [middle, corner] =
        [[0.0; 2], [15.0, 0.0]].map(|film| ExitPupil::seen(&lens, film).expect("light"));
    let narrow = corner.width(0.0) / corner.width(PI / 2.0);
    assert!(narrow < 0.8, "{narrow}");
    assert!((middle.width(0.0) / middle.width(PI / 2.0) - 1.0).abs() < 1e-3);
    let zero = |angle: f64| {
        first_minimum(6.0, |r| corner.density([r * f64::cos(angle), r * f64::sin(angle)], GREEN))
    };
    let long = zero(0.0) / zero(PI / 2.0);
    assert!((long * narrow - 1.0).abs() < 0.2, "{long} times as long for {narrow} as wide");
    // In the picture too, at the corner's own angle: its long side is along the radius.
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
    // A row of points across a vignetted film: their peaks change evenly from one to the next.
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

#[test]
fn a_good_wavefront_spreads_light_as_the_shape_of_its_pupil() {
    // Closed to f/22 the lens is limited by diffraction; wide open it is not.
    for (f_number, good) in [(22.0, true), (11.0, true), (2.0, false)] {
        let lens = dgauss(f_number, Iris::Round);
        let pupil = ExitPupil::seen(&lens, [0.0; 2]).expect("light");
        let front = Wavefront::of(&lens, [0.0; 2], &pupil).expect("a wavefront");
        let waves = 1e3 * front.rms / GREEN;
        assert_eq!(waves < 1.0 / 14.0, good, "f/{f_number}: {waves} waves");
        let wave = |x: f64| {
            let (mut re, mut im) = (0.0, 0.0);
            for delay in &front.delays {
                let (sin, cos) = (TAU * (1e3 * delay.path - delay.at[0] * x) / GREEN).sin_cos();
                (re, im) = (re + cos, im + sin);
            }
            (re * re + im * im) / (front.delays.len() as f64).powi(2)
        };
        let shape = |x: f64| pupil.density([x, 0.0], GREEN) / pupil.density([0.0; 2], GREEN);
        let strehl = wave(0.0);
        println!("f/{f_number}: {waves:.4} waves rms, Strehl ratio {strehl:.4}");
        if good {
            // Mahajan 1983: exp(-(2 pi sigma)^2).
            assert!((strehl - (-(TAU * waves).powi(2)).exp()).abs() < 0.005, "{strehl}");
            for i in 0..40 {
                let x = 2.0 * pupil.airy(GREEN) * f64::from(i) / 40.0;
                let bound = 1.0 - strehl + 0.01;
                assert!((wave(x) - shape(x)).abs() < bound, "{x}: {} {}", wave(x), shape(x));
            }
        } else {
            assert!(strehl < 0.8, "{strehl}");
        }
    }
}

/// A picture of a world behind a lens, metres, with these changes.
fn job(lens: &str, film: &str, world: &str, changes: &Changes) -> Job {
    warned(lens, film, world, changes).0
}

/// The same, and what it warns of.
fn warned(lens: &str, film: &str, world: &str, changes: &Changes) -> (Job, String) {
    let folder = folder();
    let text = format!(
        "Film \"rgb\" {film} PixelFilter \"box\" Integrator \"path\" \"integer maxdepth\" 1
         Camera \"realistic\" \"string lensfile\" \"{}\" \"float aperturediameter\" 30
         \"float focusdistance\" 1000\nWorldBegin\n{world}",
        root().join("lenses").join(lens).display()
    );
    let description = pbrt::read(&write(&folder, "scene.pbrt", text)).expect("a scene of a test");
    let (job, _, warnings) = prepare(description, changes).expect("a job");
    let warnings: Vec<String> = warnings.iter().map(ToString::to_string).collect();
    (job, warnings.join("\n"))
}

/// 3 um pixels.
const FINE: &str =
    "\"integer xresolution\" 120 \"integer yresolution\" 120 \"float diagonal\" 0.50912";

#[test]
fn a_landscape_at_f_22_needs_diffraction_and_a_portrait_wide_open_does_not() {
    let world = "LightSource \"infinite\"";
    let on = |f_number: Option<f64>, effects: &str| {
        let effects: Wanted = effects.parse().expect("effects");
        let film =
            "\"integer xresolution\" 60 \"integer yresolution\" 40 \"float diagonal\" 0.7211";
        let changes = Changes { f_number, effects, ..Changes::default() };
        job("dgauss.50mm.dat", film, world, &changes).plan.has(Effect::Diffraction)
    };
    // 10 um pixels: radii of 14.8 and 1.3 um.
    assert!(on(Some(22.0), "auto") && !on(None, "auto"));
    assert!(!on(Some(22.0), "-diffraction") && on(None, "+diffraction") && !on(Some(22.0), "none"));
}

#[test]
fn the_radius_that_is_said_is_the_radius_that_is_seen() {
    // A star on the axis, with and without: the radius that holds 83.8 % of its light grows by
    // what the plan says. Of white light and with the pixels' own width, within a fifth.
    let world = "AreaLightSource \"diffuse\" \"rgb L\" [1e6 1e6 1e6] Translate 0 0 1000
        Shape \"sphere\" \"float radius\" 0.01";
    let seen = |effects: &str| {
        let changes = Changes {
            f_number: Some(22.0),
            effects: effects.parse().expect("effects"),
            samples: Some(64),
            ..Changes::default()
        };
        let job = job("dgauss.50mm.dat", FINE, world, &changes);
        let exposed = render(&job, Backend::Simd, 2, &Default::default()).expect("a picture");
        let picture = exposed.picture(&job);
        let mut light: Vec<(f64, f64)> = picture
            .pixels
            .iter()
            .enumerate()
            .map(|(i, pixel)| {
                let [x, y] = [i % 120, i / 120].map(|p| 3.0 * (p as f64 + 0.5 - 60.0));
                (x.hypot(y), f64::from(pixel[1]))
            })
            .collect();
        light.sort_by(|a, b| a.0.total_cmp(&b.0));
        let all: f64 = light.iter().map(|(_, light)| light).sum();
        let mut inside = 0.0;
        let radius = light.iter().find(|(_, light)| {
            inside += light;
            inside > 0.838 * all
        });
        let said = match job.plan.effects.iter().find(|row| row.effect == Effect::Diffraction) {
            Some(row) => row.error,
            None => None,
        };
        let Some(Harm::Blur { um, .. }) = said else { panic!("{said:?}") };
        (radius.expect("light").0, um, all)
    };
    let (with, said, all) = seen("auto");
    let (without, same, before) = seen("none");
    println!("{said:.1} um said; {without:.1} um without, {with:.1} um with");
    assert_eq!(said, same);
    assert!(without < 5.0 && (with / said - 1.0).abs() < 0.2, "{with} um, {said} said");
    assert!((all / before - 1.0).abs() < 0.03, "light is kept, but for what leaves the film");
}

#[test]
fn a_lamp_that_makes_a_star_needs_diffraction() {
    // Grey ground, and a lamp as large as 2 pixels that is a million times as bright, or is not.
    // Pixels of 100 um: no disc could be seen.
    let planned = |bright: f64| {
        let world = format!(
            "LightSource \"infinite\" AttributeBegin AreaLightSource \"diffuse\"
             \"rgb L\" [{bright} {bright} {bright}] Translate 0.3 0.2 50
             Shape \"sphere\" \"float radius\" 0.5 AttributeEnd"
        );
        let film = "\"integer xresolution\" 150 \"integer yresolution\" 100 \"float diagonal\" 18";
        let changes = Changes { f_number: Some(16.0), ..Changes::default() };
        let plan = job("dgauss.50mm.dat", film, &world, &changes).plan;
        plan.effects.into_iter().find(|row| row.effect == Effect::Diffraction).expect("a row")
    };
    let (bright, dim) = (planned(1e5), planned(10.0));
    assert!(bright.on && bright.reason.contains("the brightest lamp"), "{}", bright.reason);
    assert!(!dim.on && !dim.reason.contains("lamp"), "{}", dim.reason);
}

#[test]
fn light_of_one_colour_has_sharp_rings() {
    // A passband of 2 nm: Airy's pattern itself, its first ring dark.
    let lens = dgauss(22.0, Iris::Round);
    let pupil = ExitPupil::seen(&lens, [0.0; 2]).expect("light");
    let narrow = petzval::spectrum::Passband { range: [549.0, 551.0] };
    let spread = Spread::new(&pupil, &narrow.bands(), 500.0, 1.0);
    let white = Spread::new(&pupil, &bands(), 500.0, 1.0);
    let (zero, peak) = (pupil.airy(GREEN), pupil.density([0.0; 2], GREEN));
    for (found, channel) in spread.at([0.0, zero]).into_iter().zip(0..) {
        assert!(found < 3e-4 * peak && white.at([0.0, zero])[channel] > 3e-4 * peak, "{found}");
        let ring = spread.at([0.0, 1.635 / 1.22 * zero])[channel];
        assert!((ring / peak - 0.0175).abs() < 5e-4, "the first bright ring: {}", ring / peak);
    }
}

#[test]
fn a_crop_is_that_part_of_the_whole_bit_for_bit_but_for_diffraction() {
    // A sensor on top: its noise belongs to pixels, wherever a crop begins.
    let world = "LightSource \"infinite\" \"rgb L\" [0.4 0.5 0.6] Translate 0.06 0.02 40
        Material \"diffuse\" \"rgb reflectance\" [0.2 0.3 0.4] Shape \"sphere\" \"float radius\" 0.1";
    let film = "\"integer xresolution\" 60 \"integer yresolution\" 40 \"float diagonal\" 0.36";
    let taken = |effects: &str, sensor: Option<&str>, crop: Option<[[u32; 2]; 2]>| {
        let changes = Changes {
            f_number: Some(16.0),
            effects: effects.parse().expect("effects"),
            sensor: sensor.map(|words| words.parse().expect("a sensor")),
            samples: Some(16),
            crop,
            ..Changes::default()
        };
        let (job, warnings) = warned("dgauss.50mm.dat", film, world, &changes);
        let exposed = render(&job, Backend::Simd, 2, &Default::default()).expect("a picture");
        (exposed.picture(&job).pixels, warnings)
    };
    let [low, high] = [[21, 11], [50, 32]];
    for (effects, sensor) in [
        ("-diffraction", None),
        ("-diffraction", Some("iso=3200,pixel=3")),
        ("-diffraction", Some("iso=3200,pixel=3,bayer=gbrg")),
        ("+diffraction", None),
    ] {
        let ((whole, said), (part, warned)) =
            (taken(effects, sensor, None), taken(effects, sensor, Some([low, high])));
        let inside = (low[1]..high[1]).flat_map(|y| (low[0]..high[0]).map(move |x| y * 60 + x));
        let inside: Vec<[f32; 3]> = inside.map(|i| whole[i as usize]).collect();
        let warns = "beyond the crop";
        assert!(!said.contains(warns), "{said}");
        if effects == "-diffraction" {
            assert!(inside == part, "{effects} {sensor:?}");
            assert!(!warned.contains(warns), "{warned}");
            continue;
        }
        assert!(warned.contains(warns), "{warned}");
        let bright = inside.iter().flatten().fold(0.0f32, |most, &v| most.max(v));
        // Airy's first dark ring has a radius of 2 pixels; the edge of the ball crosses the crop's.
        for (margin, bound) in [(0, 0.15), (2, 0.03), (6, 0.01)] {
            let [width, height] = [high[0] - low[0], high[1] - low[1]].map(|n| n as usize);
            let deep = |i: &usize| {
                let [x, y] = [i % width, i / width];
                x.min(width - 1 - x).min(y).min(height - 1 - y) >= margin
            };
            let off = (0..width * height).filter(deep).flat_map(|i| {
                let (inside, part) = (inside[i], part[i]);
                (0..3).map(move |c| (inside[c] - part[c]).abs() / bright)
            });
            let off = off.fold(0.0, f32::max);
            println!("{margin} pixels inside a crop is off by {off:.5} of the brightest at most");
            assert!(off > 0.0 && off < bound, "{margin}: {off}");
        }
    }
}
