//! Dual pixels: the pictures of both halves of the pupil, against first-order optics.

use std::f64::consts::PI;

use crate::support::{folder, root, write};
use glam::DVec3;
use petzval_image::{ImageLayer, Picture};
use petzval_lens::{ApertureForm, LensModel, RealLens, SurfaceAperture};
use petzval_render::aov::{Aov, CircleOfConfusion};
use petzval_render::job::Job;
use petzval_render::plan::Effect;
use petzval_render::prepare::{Changes, prepare};
use petzval_render::sensor::SensorSettings;
use petzval_render::{Backend, Progress, ProgressiveRender, RenderOptions, render};
use petzval_scene_formats::pbrt;
use petzval_spectrum::{Buckets, ColourSpace, Primaries};

/// Pixels along each side of the film.
const SIDE: usize = 96;

/// Returns the job of a scene through a lens with a square film of this diagonal (mm).
fn job(lens: &str, diagonal: f64, world: &str, changes: &Changes) -> Job {
    let text = format!(
        "Film \"rgb\" \"integer xresolution\" {SIDE} \"integer yresolution\" {SIDE}
         \"float diagonal\" {diagonal} PixelFilter \"box\" Sampler \"sobol\" \"integer pixelsamples\" 64
         Integrator \"path\" \"integer maxdepth\" 1
         Camera \"realistic\" \"string lensfile\" \"{}\" \"float focusdistance\" 2
         WorldBegin\n{world}",
        root().join("lenses").join(lens).display()
    );
    let folder = folder();
    let description = pbrt::read(&write(&folder, "scene.pbrt", text)).expect("a scene");
    let changes = Changes { layers: vec![Aov::DualPixel], ..changes.clone() };
    prepare(description, &changes).expect("a job").job
}

fn effects(text: &str) -> Changes {
    Changes { effects: text.parse().expect("effects"), ..Changes::default() }
}

/// Returns the layers `left` and `right`, whose sum is the picture.
fn halves(job: &Job, options: RenderOptions) -> [ImageLayer; 2] {
    let exposed = render(job, options).expect("a picture");
    let (picture, layers) = exposed.into_picture_with_layers(job);
    let [.., left, right] = &layers[..] else { panic!("two layers") };
    let halves = [left.clone(), right.clone()];
    assert_eq!(halves.each_ref().map(|layer| layer.name.as_str()), ["left", "right"]);
    for (c, name) in ["R", "G", "B"].iter().enumerate() {
        let [left, right] = halves.each_ref().map(|layer| &layer.channels[c]);
        assert_eq!([&left.0, &right.0], [name; 2]);
        for ((left, right), pixel) in left.1.iter().zip(&right.1).zip(&picture.pixels) {
            assert!(*left >= 0.0 && *right >= -1e-6 * pixel[c], "{left} and {right}");
            assert!((left + right - pixel[c]).abs() <= 1e-6 * pixel[c], "{left} + {right}");
        }
    }
    halves
}

/// Returns the sum of the green channel of a layer and its centroid (pixels).
fn centroid(layer: &ImageLayer) -> (f64, [f64; 2]) {
    let (mut sum, mut moments) = (0.0, [0.0; 2]);
    for (i, &light) in layer.channels[1].1.iter().enumerate() {
        let light = f64::from(light);
        sum += light;
        moments[0] += light * (i % SIDE) as f64;
        moments[1] += light * (i / SIDE) as f64;
    }
    (sum, moments.map(|moment| moment / sum))
}

/// A small lamp at a depth (m), in the direction (right, up) of the scene.
fn lamp(depth: f64, [right, up]: [f64; 2]) -> String {
    format!(
        "AreaLightSource \"diffuse\" \"rgb L\" [1 1 1] Translate {} {} {depth}
         Shape \"sphere\" \"float radius\" {}",
        right * depth,
        up * depth,
        3e-3 * depth
    )
}

/// The centroid of half a disc lies 4 r / (3 pi) from its straight side. So the pictures of a lamp are
/// displaced by 2 / (3 pi) of the diameter of the blur, to opposite sides before and behind the plane in
/// focus: the left half of the pupil sees near things further to the right, as a left eye does.
#[test]
fn the_disparity_of_a_lamp_is_that_of_first_order_optics() {
    for (depth, direction) in [
        (1.0, [0.0; 2]),
        (1.4, [0.0; 2]),
        (4.0, [0.0; 2]),
        (1.0, [0.006, -0.004]),
        (6.0, [-0.005; 2]),
    ] {
        for light_paths in [false, true] {
            let changes = Changes {
                light_paths: Some(light_paths),
                f_number: Some(11.0),
                samples: Some(1024),
                ..effects("none")
            };
            let job = job("dgauss.50mm.dat", 2.0, &lamp(depth, direction), &changes);
            assert_eq!(job.light_strategies().len(), usize::from(light_paths));
            let found = halves(&job, RenderOptions::default());
            let [(left, [x, y]), (right, [to_x, to_y])] = found.each_ref().map(centroid);
            let circle = CircleOfConfusion::new(&job.camera).expect("a lens");
            let pitch = 1e3 * job.camera.pixel_pitch([SIDE as u32; 2])[0];
            let blur =
                circle.diameter(depth, [0.0; 2]) / pitch * if depth < 2.0 { 1.0 } else { -1.0 };
            let expected = 4.0 / (3.0 * PI) * blur;
            let place = format!("{depth} m, {direction:?}, light paths {light_paths}");
            println!("{place}: {} px, not {expected}; {left} {right}", x - to_x);
            assert!(((x - to_x) / expected - 1.0).abs() < 0.02, "{place}: {} {expected}", x - to_x);
            assert!((y - to_y).abs() < 0.02 * expected.abs(), "{place}: {y} {to_y}");
            assert!((left / right - 1.0).abs() < 0.02, "{place}: {left} {right}");
        }
    }
}

const SKY: &str = "LightSource \"infinite\" \"rgb L\" [0.9 0.6 0.3]";

/// Returns the share of the light of a part of the picture that passes the left half of the pupil.
fn left_share(halves: &[ImageLayer; 2], columns: std::ops::Range<usize>) -> f64 {
    let [left, right] = halves.each_ref().map(|layer| {
        let pixels = layer.channels[1].1.iter().enumerate();
        pixels
            .filter(|(i, _)| columns.contains(&(i % SIDE)))
            .map(|(_, &light)| f64::from(light))
            .sum::<f64>()
    });
    left / (left + right)
}

/// The front rims of a lens cut the left half of the pupil at the left edge of the picture, and the right half at
/// the right edge.
#[test]
fn halves_of_a_uniform_sky_are_equal_in_the_middle_and_mirrored_at_the_edges() {
    for (lens, effect) in [
        ("dgauss.50mm.dat", "none"),
        ("double-gauss.50mm.toml", "+dispersion"),
        ("wide.22mm.dat", "none"),
        ("anamorphic.toml", "none"),
    ] {
        let changes = Changes { samples: Some(96), ..effects(effect) };
        let found = halves(&job(lens, 40.0, SKY, &changes), RenderOptions::default());
        let [left, middle, right] = [0..8, SIDE / 2 - 8..SIDE / 2 + 8, SIDE - 8..SIDE]
            .map(|columns| left_share(&found, columns));
        println!("{lens}, {effect}: {left} {middle} {right}");
        assert!((middle - 0.5).abs() < 0.004, "{lens}: {middle}");
        assert!((left + right - 1.0).abs() < 0.008, "{lens}: {left} and {right}");
        assert!(left < 0.48, "{lens}: {left}");
    }
}

#[test]
fn halves_change_neither_the_picture_nor_its_spectrum() {
    let changes = Changes {
        samples: Some(16),
        buckets: Some(Some(Buckets::new(4, [400.0, 700.0]).expect("buckets"))),
        light_paths: Some(true),
        ..effects("+dispersion,+ghosts,+spectra")
    };
    let world = format!("{SKY} {}", lamp(1.0, [0.0; 2]));
    let with = job("double-gauss.50mm.toml", 4.0, &world, &changes);
    assert!(with.camera.bands() > 1 && with.spectral.is_some());
    assert_eq!(with.light_strategies().len(), 2);
    let mut without = with.clone();
    without.layers.clear();
    let [found, expected] =
        [&with, &without].map(|job| render(job, RenderOptions::default()).expect("a picture"));
    assert!(found.film.picture(16) == expected.film.picture(16));
    let spectrum = expected.film.spectrum(16).expect("a spectrum");
    assert!(found.film.spectrum(16) == Some(spectrum));
    let found = halves(&with, RenderOptions::default());
    for (backend, threads) in [(Backend::Simd, 1), (Backend::Scalar, 7)] {
        let options = RenderOptions { backend, threads, ..RenderOptions::default() };
        assert!(halves(&with, options) == found, "{backend:?}, {threads} threads");
    }
}

/// Returns the covariance of two pictures in a channel.
fn covariance(one: &Picture, other: &Picture, channel: usize) -> f64 {
    let mean = |picture: &Picture| {
        let sum: f64 = picture.pixels.iter().map(|pixel| f64::from(pixel[channel])).sum();
        sum / picture.pixels.len() as f64
    };
    let means = [one, other].map(mean);
    let pixels = one.pixels.iter().zip(&other.pixels);
    let products = pixels
        .map(|(a, b)| (f64::from(a[channel]) - means[0]) * (f64::from(b[channel]) - means[1]));
    products.sum::<f64>() / (one.pixels.len() - 1) as f64
}

fn flat(value: f32) -> Picture {
    Picture { size: [1000, 800], pixels: vec![[value; 3]; 800_000] }
}

fn mean(picture: &Picture) -> f64 {
    let sum: f64 = picture.pixels.iter().map(|pixel| f64::from(pixel[1])).sum();
    sum / picture.pixels.len() as f64
}

/// The charge of a photosite is that of both photodiodes, so that its shot noise is theirs; each readout
/// adds its own noise.
#[test]
fn the_picture_of_a_dual_pixel_has_the_shot_noise_of_its_halves() {
    let settings: SensorSettings =
        "iso=400,well=20000,read=6,dark=300,time=1,bits=16,black=2000".parse().expect("a sensor");
    let sensor = settings.sensor(100.0, 4.0, 0.0);
    let white = sensor.white_electrons();
    let [left, right] = [0.12, 0.3];
    let (whole, halves) = sensor.read_out_halves([flat(left), flat(right)], [0, 0], 5);
    let dark = 300.0 / white;
    let expected = [left, right].map(|value| f64::from(value) + dark / 2.0);
    let sum = expected[0] + expected[1];
    for (found, expected) in
        [&halves[0], &halves[1], &whole].into_iter().zip([expected[0], expected[1], sum])
    {
        // Five standard errors are 0.0002.
        assert!((mean(found) - expected).abs() < 2e-4, "{} and {expected}", mean(found));
        let electrons = covariance(found, found, 1) * white * white;
        let step = white / f64::from(sensor.max_code() - sensor.black_level);
        let expected = expected * white + 36.0 + step * step / 12.0;
        assert!((electrons / expected - 1.0).abs() < 0.009, "{electrons} and {expected}");
    }
    let shared = [0, 1].map(|half| covariance(&halves[half], &whole, 1) * white * white);
    for (shared, expected) in shared.into_iter().zip(expected) {
        assert!(
            (shared / (expected * white) - 1.0).abs() < 0.015,
            "{shared}, {}",
            expected * white
        );
    }
    let apart = covariance(&halves[0], &halves[1], 1) * white * white;
    assert!(apart.abs() < 0.01 * sum * white, "{apart}");
    // Channels, and pictures of the same light in one half, have noise of their own.
    let [again, other] = sensor.read_out_halves([flat(right), flat(right)], [0, 0], 5).1;
    assert!(covariance(&again, &other, 1).abs() * white * white < 0.01 * sum * white);
    // At the base speed, a photodiode holds half of the full well.
    let base = SensorSettings { iso: Some(100.0), ..settings }.sensor(100.0, 4.0, 0.0);
    let (whole, [left, _]) = base.read_out_halves([flat(4.0), flat(0.1)], [0, 0], 5);
    assert!((mean(&left) - 0.5).abs() < 1e-4, "{}", mean(&left));
    assert!((mean(&whole) - 0.6 - 150.0 / 20_000.0).abs() < 2e-4, "{}", mean(&whole));
}

/// Returns the largest difference of green in two layers.
fn difference(one: &ImageLayer, other: &ImageLayer) -> f32 {
    let pairs = one.channels[1].1.iter().zip(&other.channels[1].1);
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[test]
fn a_sensor_reads_halves_out_as_it_reads_the_picture() {
    let world = format!("{SKY} {}", lamp(1.0, [0.0; 2]));
    for (effect, sensor) in [
        ("none", "iso=100,well=1e9,read=0,bits=16"),
        ("+diffraction", "iso=100,well=1e9,read=0,bits=16"),
        ("none", "iso=100,well=1e9,read=0,bits=16,bayer=grbg"),
    ] {
        let changes = Changes {
            samples: Some(16),
            sensor: Some(sensor.parse().expect("a sensor")),
            ..effects(effect)
        };
        let mut job = job("dgauss.50mm.dat", 4.0, &world, &changes);
        job.camera.imaging_ratio *= 500.0;
        let exposed = render(&job, RenderOptions::default()).expect("a picture");
        assert!(exposed.picture(&job) == exposed.clone().into_picture(&job));
        let mut progressive = ProgressiveRender::new(&job, 2).expect("threads");
        progressive = progressive.step(16, &Progress::default()).expect("a step");
        assert!(
            job.plan.has(Effect::Diffraction) || progressive.picture() == exposed.picture(&job)
        );
        if !job.has_mosaic() {
            let light = halves(&Job { sensor: None, ..job.clone() }, RenderOptions::default());
            let (_, read) = exposed.clone().into_picture_with_layers(&job);
            assert!(
                difference(&read[0], &light[0]) < 2e-4 && difference(&read[1], &light[1]) < 2e-4
            );
            // Diffraction spreads both halves.
            let effects = "none".parse().expect("effects");
            let changes = Changes { effects, sensor: None, ..changes.clone() };
            let mut plain = self::job("dgauss.50mm.dat", 4.0, &world, &changes);
            plain.camera.imaging_ratio *= 500.0;
            let plain = halves(&plain, RenderOptions::default());
            let spreads = job.plan.has(Effect::Diffraction);
            assert!((0..2).all(|i| (difference(&plain[i], &light[i]) > 1e-3) == spreads));
        }
        let (picture, layers) = exposed.into_picture_with_layers(&job);
        let [left, right] = &layers[..] else { panic!("{} layers", layers.len()) };
        let mosaic = job.has_mosaic();
        assert!((0.05..0.5).contains(&mean(&picture)), "{}", mean(&picture));
        assert_eq!(left.channels.len(), if mosaic { 1 } else { 3 });
        for (i, pixel) in picture.pixels.iter().enumerate() {
            for c in 0..left.channels.len() {
                let [left, right] = [left, right].map(|layer| layer.channels[c].1[i]);
                // Codes are rounded three times, and a billion electrons have noise of 2e-5.
                assert!(
                    (left + right - pixel[c]).abs() < 2e-4,
                    "{left} + {right} and {}",
                    pixel[c]
                );
            }
        }
        println!("{effect} {sensor}: {}", mean(&picture));
    }
}

/// Without rims in the way, the line between the halves passes the middle of the pupil from every point of
/// the film, also behind a film that is shifted.
#[test]
fn halves_of_a_small_stop_are_equal_all_over_the_film() {
    for (lens, f_number, shift) in [
        ("dgauss.50mm.dat", 11.0, 0.0),
        ("telephoto.250mm.dat", 16.0, 0.0),
        ("telephoto.250mm.dat", 16.0, 4.0),
    ] {
        let changes = Changes {
            samples: Some(96),
            f_number: Some(f_number),
            film_shift: Some([shift, 0.0]),
            ..effects("+tilt_shift")
        };
        let found = halves(&job(lens, 22.0, SKY, &changes), RenderOptions::default());
        for columns in [0..8, SIDE / 2 - 4..SIDE / 2 + 4, SIDE - 8..SIDE] {
            let share = left_share(&found, columns.clone());
            println!("{lens} {f_number} {shift} {columns:?}: {share}");
            assert!((share - 0.5).abs() < 0.02, "{lens} {shift} {columns:?}: {share}");
        }
    }
}

/// Returns the picture of a job whose stop is covered on its right, as seen from behind the camera.
fn through_the_left_half_of_the_stop(job: &Job) -> Picture {
    let mut masked = Job { layers: Vec::new(), ..job.clone() };
    let LensModel::Real(lens) = &job.camera.model else { panic!("a real lens") };
    let mut prescription = lens.prescription.clone();
    let stop = prescription.stop();
    prescription.rows[stop].apertures.push(SurfaceAperture {
        form: ApertureForm::Rectangle,
        half_widths: [100.0; 2],
        centre: [100.0, 0.0],
        rotation: 0.0,
        obscures: true,
    });
    let RealLens { film, pupil_sampling, units_per_mm, front_depth, .. } = **lens;
    let masked_lens =
        RealLens::with_film(prescription, &film, pupil_sampling, units_per_mm, front_depth);
    masked.camera.model = LensModel::Real(Box::new(masked_lens));
    render(&masked, RenderOptions::default()).expect("a picture").into_picture(&masked)
}

/// A mask before the iris is an independent way to separate the halves: with a straight film, a tilted one, and a
/// lens whose exit pupil is far away.
#[test]
fn the_left_half_is_the_picture_through_the_left_half_of_the_stop() {
    for (lens, f_number, tilt) in [
        ("dgauss.50mm.dat", 8.0, None),
        ("dgauss.50mm.dat", 8.0, Some([4.0, 12.0])),
        ("telephoto.250mm.dat", 11.0, None),
    ] {
        let changes = Changes {
            samples: Some(512),
            f_number: Some(f_number),
            film_tilt: tilt,
            light_paths: Some(false),
            ..effects("+tilt_shift")
        };
        let job = job(lens, 4.0, &lamp(1.2, [0.002, -0.001]), &changes);
        let [left, right] = halves(&job, RenderOptions::default());
        let masked = through_the_left_half_of_the_stop(&job);
        let distance = |layer: &ImageLayer| {
            let pairs = layer.channels[1].1.iter().zip(&masked.pixels);
            let squares: f64 = pairs.map(|(a, b)| f64::from(a - b[1]).powi(2)).sum();
            let norm: f64 = masked.pixels.iter().map(|pixel| f64::from(pixel[1]).powi(2)).sum();
            (squares / norm).sqrt()
        };
        let [same, other] = [&left, &right].map(distance);
        println!("{lens}, {tilt:?}: {same} {other}");
        assert!(same < 0.05 && other > 0.2, "{lens}, {tilt:?}: {same} {other}");
    }
}

#[test]
fn halves_of_a_film_in_another_colour_space_add_up_in_it() {
    let changes = Changes { samples: Some(16), ..effects("none") };
    let mut job = job("dgauss.50mm.dat", 4.0, SKY, &changes);
    job.colour_space = ColourSpace::Rec2020;
    let (picture, layers) =
        render(&job, RenderOptions::default()).expect("a picture").into_picture_with_layers(&job);
    let space = job.colour_space.primaries();
    let matrix = Primaries::SRGB.to(&space).expect("a space");
    for (i, pixel) in picture.pixels.iter().enumerate() {
        let expected = matrix * DVec3::from_array(pixel.map(f64::from));
        for c in 0..3 {
            let sum: f64 = layers.iter().map(|layer| f64::from(layer.channels[c].1[i])).sum();
            assert!((sum / expected[c] - 1.0).abs() < 1e-5, "{sum}, not {}", expected[c]);
        }
    }
}
