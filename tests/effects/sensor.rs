//! Sensor simulation on whole pictures, and its options and reports.

use std::process::{Command, Stdio};

use crate::support::nasty::nasty_f32;
use crate::support::{folder, root, write};
use petzval_image::Picture;
use petzval_render::film::Frame;
use petzval_render::job::Job;
use petzval_render::prepare::{Changes, prepare};
use petzval_render::sensor::{
    Bayer, Components, Crosstalk, FixedPattern, HotPixels, Sensor, SensorSettings,
};
use petzval_render::{RenderOptions, render};
use petzval_scene_formats::pbrt;

/// Read noise of photosites alone.
const fn read_noise(pixel: f64) -> Components {
    Components { pixel, row: 0.0, column: 0.0 }
}

/// A sensor of few bits, so that steps can be counted.
const COARSE: Sensor = Sensor {
    iso: 100.0,
    full_well: 40_000.0,
    read_noise: read_noise(3.0),
    dark_current: 0.0,
    seconds: 0.0,
    fixed_pattern: FixedPattern {
        seed: 0,
        dark_signal: read_noise(0.0),
        response: read_noise(0.0),
        hot: HotPixels { share: 0.0, dark_current: 0.0 },
    },
    crosstalk: Crosstalk([0.0; 3]),
    bits: 8,
    black_level: 15,
    hdr: 1.0,
    vignetting: None,
    bayer: None,
    filters: None,
};

#[test]
fn crosstalk_spreads_light_and_keeps_photon_noise() {
    let size = [400, 300];
    let sensor = Sensor {
        full_well: 10_000.0,
        read_noise: read_noise(0.0),
        bits: 16,
        black_level: 100,
        bayer: Some(Bayer::Rggb),
        crosstalk: Crosstalk([0.2, 0.1, 0.3]),
        ..COARSE
    };
    let light = [0.1, 0.4, 0.2];
    let picture = sensor.read_out(flat(light, size), [0, 0], 1);
    // Red and blue have four green neighbours, green has two of either.
    let expected =
        [0.8 * 0.1 + 0.1 * 0.4, 0.9 * 0.4 + 0.5 * (0.2 * 0.1 + 0.3 * 0.2), 0.7 * 0.2 + 0.1 * 0.4];
    let electrons = |[x, y]: [usize; 2]| 1e4 * f64::from(picture.pixels[y * size[0] + x][0]);
    for (first, channel) in [([0, 0], 0), ([1, 0], 1), ([0, 1], 1), ([1, 1], 2)] {
        let places =
            (0..150).flat_map(|y| (0..200).map(move |x| [first[0] + 2 * x, first[1] + 2 * y]));
        let values: Vec<f64> = places.map(electrons).collect();
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / n;
        let exact = 1e4 * expected[channel];
        // Five standard errors of mean and variance.
        assert!((mean - exact).abs() < 5.0 * (exact / n).sqrt(), "{channel}: {mean}, not {exact}");
        assert!(
            (variance / exact - 1.0).abs() < 5.0 * (2.0 / n).sqrt(),
            "{channel}: {variance}, not {exact}"
        );
    }
    // Neighbours have independent noise.
    let at = |x: usize, y: usize| {
        electrons([x, y]) - 1e4 * expected[Bayer::Rggb.channel([x as u32, y as u32])]
    };
    let pairs = (0..300).flat_map(|y| (0..399).map(move |x| (x, y)));
    let product: f64 = pairs.map(|(x, y)| at(x, y) * at(x + 1, y)).sum::<f64>() / (300.0 * 399.0);
    let bound = 5.0 * 1e4 * (expected[0] * expected[1]).sqrt().max(expected[1] * expected[2])
        / (300.0_f64 * 399.0).sqrt();
    assert!(product.abs() < bound, "{product}, bound {bound}");
}

#[test]
fn crosstalk_of_a_crop_is_that_of_the_frame_within_its_border() {
    let size = [40, 30];
    let pixel = |i: usize| [(i % 7) as f32 / 9.0, (i % 5) as f32 / 9.0, (i % 3) as f32 / 9.0];
    let whole = Picture { size, pixels: (0..1200).map(pixel).collect() };
    for bayer in [None, Some(Bayer::Gbrg), Some(Bayer::QuadBggr)] {
        let sensor = Sensor { crosstalk: Crosstalk([0.3, 0.2, 0.1]), bayer, ..COARSE };
        let read = sensor.read_out(whole.clone(), [0, 0], 3);
        let row = |y: usize| whole.pixels[y * 40..][5..25].to_vec();
        let crop = Picture { size: [20, 12], pixels: (7..19).flat_map(row).collect() };
        let crop = sensor.read_out(crop, [5, 7], 3);
        for (x, y) in (1..11).flat_map(|y| (1..19).map(move |x| (x, y))) {
            assert_eq!(
                crop.pixels[y * 20 + x],
                read.pixels[(y + 7) * 40 + x + 5],
                "{bayer:?} {x}, {y}"
            );
        }
        let none = Sensor { crosstalk: Crosstalk::default(), ..sensor };
        assert_ne!(none.read_out(whole.clone(), [0, 0], 3), read);
    }
}

fn flat(value: [f32; 3], size: [usize; 2]) -> Picture {
    Picture { size, pixels: vec![value; size[0] * size[1]] }
}

/// Returns mean and variance of one channel.
fn moments(picture: &Picture, channel: usize) -> [f64; 2] {
    let n = picture.pixels.len() as f64;
    let values = || picture.pixels.iter().map(|pixel| f64::from(pixel[channel]));
    let mean = values().sum::<f64>() / n;
    [mean, values().map(|value| (value - mean).powi(2)).sum::<f64>() / (n - 1.0)]
}

#[test]
fn noise_of_a_picture_follows_the_light_of_every_channel() {
    let sensor = Sensor { iso: 800.0, bits: 16, black_level: 2048, ..COARSE };
    assert_eq!(sensor.white_electrons(), 5000.0);
    let value = [0.05, 0.3, 0.8];
    let read = sensor.read_out(flat(value, [1000, 800]), [0, 0], 3);
    let n: f64 = 800_000.0;
    for channel in 0..3 {
        let electrons = f64::from(value[channel]) * 5000.0;
        let [mean, variance] = moments(&read, channel);
        let expected = electrons + 9.0;
        assert!((mean * 5000.0 - electrons).abs() < 5.0 * (expected / n).sqrt() + 0.002, "{mean}");
        // Five standard errors, which are 0.8 %.
        let off = variance * 5000.0 * 5000.0 / expected - 1.0;
        assert!(off.abs() < 5.0 * (2.0 / n).sqrt(), "channel {channel}: {off}");
    }
}

/// Returns mean and variance of the readings of a uniform picture, relative to white, over all channels.
fn readings(options: &str, value: f32) -> [f64; 2] {
    let settings: SensorSettings = options.parse().expect("settings");
    let size = [1000, 800];
    let read = settings.sensor(100.0, 6.0, 0.0).read_out(flat([value; 3], size), [0, 0], 17);
    let n = (3 * size[0] * size[1]) as f64;
    let values = || read.pixels.iter().flatten().map(|&value| f64::from(value));
    let mean = values().sum::<f64>() / n;
    [mean, values().map(|value| (value - mean).powi(2)).sum::<f64>() / (n - 1.0)]
}

/// Five standard errors of a variance of 2.4 million readings: 0.5 %.
const VARIANCE: f64 = 0.005;

#[test]
fn every_source_of_noise_is_as_strong_as_its_definition() {
    // Expected values computed by hand: electrons of white, light, read noise, and the quantisation step,
    // whose error is uniform. In each row one of the sources dominates.
    for (options, value, white, read, codes) in [
        // Photons, at the base speed and above it.
        ("iso=100,well=50000,read=0,bits=16,black=0", 0.25, 50_000.0, 0.0, 65_535.0),
        ("iso=800,well=40000,read=0,bits=16,black=2048", 0.5, 5_000.0, 0.0, 63_487.0),
        ("iso=6400,well=64000,read=0,bits=16,black=0", 0.03, 1_000.0, 0.0, 65_535.0),
        // The full well follows from the pixel pitch: 1500 electrons per square micrometre.
        ("pixel=4,read=0,bits=16,black=0", 0.25, 24_000.0, 0.0, 65_535.0),
        ("read=0,bits=16,black=0", 0.25, 54_000.0, 0.0, 65_535.0),
        // Read noise with 500 and 200 electrons of light.
        ("iso=100,well=50000,read=80,bits=16,black=4096", 0.01, 50_000.0, 80.0, 61_439.0),
        ("iso=3200,well=32000,read=20,bits=14,black=512", 0.2, 1_000.0, 20.0, 15_871.0),
        ("iso=3200,well=32000,bits=16,black=0", 0.02, 1_000.0, 2.5, 65_535.0),
        // Quantisation: a step is 100 electrons, and the read noise dithers it.
        ("iso=100,well=25500,read=60,bits=8,black=0", 0.02, 25_500.0, 60.0, 255.0),
        ("iso=400,well=94000,read=60,bits=8,black=20", 0.1, 23_500.0, 60.0, 235.0),
    ] {
        let electrons = f64::from(value) * white;
        let step: f64 = white / codes;
        let expected = electrons + read * read + step * step / 12.0;
        let [mean, variance] = readings(options, value);
        let error = 5.0 * (expected / 2.4e6).sqrt();
        assert!((mean * white - electrons).abs() < error + 1e-6 * white, "{options}: mean {mean}");
        let off = variance * white * white / expected - 1.0;
        assert!(off.abs() < VARIANCE, "{options}: the variance is {off} off");
    }
}

/// Noise below black is kept: a dark frame has the mean 0 and the variance of read noise and rounding.
#[test]
fn a_dark_frame_has_no_bias() {
    for options in ["", "iso=6400,read=2.5,bits=12", "iso=1600,read=3,bits=10,bayer=gbrg"] {
        let sensor = options.parse::<SensorSettings>().expect("settings").sensor(100.0, 4.0, 0.0);
        let read = sensor.read_out(flat([0.0; 3], [1000, 800]), [0, 0], 5);
        let step = sensor.white_electrons() / f64::from(sensor.max_code() - sensor.black_level);
        let expected = sensor.read_noise.variance() + step * step / 12.0;
        let [mean, variance] = moments(&read, 1).map(|m| m * sensor.white_electrons());
        let (variance, n) = (variance * sensor.white_electrons(), 8e5f64);
        assert!(mean.abs() < 5.0 * (expected / n).sqrt(), "{options}: {mean} electrons");
        let off = variance / expected - 1.0;
        assert!(off.abs() < 5.0 * (2.0 / n).sqrt() + 1e-3, "{options}: the variance is {off} off");
        assert!(read.pixels.iter().any(|pixel| pixel[1] < 0.0), "{options}: codes below black");
    }
}

#[test]
fn the_full_well_clips_at_its_definition() {
    // At a quarter of the base ISO the well is full at a quarter of white. Read noise remains.
    let options = "iso=25,well=10000,bits=16,black=1000";
    let [mean, variance] = readings(&format!("{options},read=50"), 0.5);
    let white = 40_000.0f64;
    assert!((mean - 0.25).abs() < 1e-5, "{mean}");
    let step: f64 = white / 64_535.0;
    let off = variance * white * white / (2500.0 + step * step / 12.0) - 1.0;
    assert!(off.abs() < VARIANCE, "{off}");
    // Light as strong as the full well fills half of the photosites. The mean of min(X, mean) of a
    // Gaussian X is a standard deviation / sqrt(2 pi) below its mean.
    let [mean, _] = readings(&format!("{options},read=0"), 0.25);
    let missing = (10_000.0 - mean * white) / (10_000.0f64 / std::f64::consts::TAU).sqrt();
    assert!((missing - 1.0).abs() < 0.01, "{missing}");
}

#[test]
fn the_estimated_noise_equals_the_noise_of_readings() {
    for (options, value) in [
        ("iso=100,well=50000,read=0,bits=16", 0.18),
        ("iso=3200,well=32000,read=20,bits=14", 0.18),
        ("iso=100,well=50000,read=80,bits=16", 0.02),
        ("iso=100,well=25500,read=60,bits=8,black=0", 0.05),
    ] {
        let settings: SensorSettings = options.parse().expect("settings");
        let estimate = settings.sensor(100.0, 6.0, 0.0).relative_noise(f64::from(value));
        let [mean, variance] = readings(options, value);
        let off = estimate / (100.0 * variance.sqrt() / mean) - 1.0;
        // The tolerance of a standard deviation is half that of the variance.
        assert!(off.abs() < VARIANCE / 2.0, "{options}: {off}");
    }
}

#[test]
fn light_beyond_white_or_the_full_well_is_clipped() {
    let bright = flat([1.5, 40.0, 1e30], [64, 64]);
    let read = COARSE.read_out(bright.clone(), [0, 0], 0);
    assert!(read.pixels.iter().all(|pixel| *pixel == [1.0; 3]));
    // At half the base ISO the full well is half of white.
    let slow =
        Sensor { iso: 50.0, read_noise: read_noise(0.0), bits: 16, black_level: 0, ..COARSE };
    let read = slow.read_out(bright.clone(), [0, 0], 0);
    assert!(read.pixels.iter().flatten().all(|&v| (v - 0.5).abs() < 1e-5), "{:?}", read.pixels[0]);
}

#[test]
fn values_are_codes_and_every_code_occurs() {
    let ramp = (0..100_000).map(|i| [i as f32 * 1.02e-5 - 0.01; 3]).collect();
    let read = COARSE.read_out(Picture { size: [1000, 100], pixels: ramp }, [0, 0], 0);
    let mut seen = [0; 241];
    for value in read.pixels.iter().flatten() {
        let code = value * 240.0;
        assert!((code - code.round()).abs() < 1e-4, "{value} is no code");
        seen[code.round() as usize] += 1;
    }
    assert!(seen.iter().all(|&count| count > 0), "{seen:?}");
    // All codes except the ends are equally wide.
    assert!(seen[20..220].iter().all(|count| (800..1700).contains(count)), "{seen:?}");
}

#[test]
fn a_pixel_of_the_mosaic_keeps_the_channel_of_its_filter() {
    let quiet =
        Sensor { read_noise: read_noise(0.0), bits: 16, black_level: 0, full_well: 1e12, ..COARSE };
    let value = [0.2, 0.5, 0.8];
    let channels = |bayer: Bayer, origin: [u32; 2]| -> String {
        let sensor = Sensor { bayer: Some(bayer), ..quiet };
        let read = sensor.read_out(flat(value, [2, 2]), origin, 0);
        let letter = |pixel: &[f32; 3]| {
            assert!(pixel[0] == pixel[1] && pixel[1] == pixel[2], "grey");
            let near = |channel: usize| (pixel[0] - value[channel]).abs() < 1e-4;
            [(0, 'r'), (1, 'g'), (2, 'b')].into_iter().find(|(c, _)| near(*c)).expect("a channel").1
        };
        read.pixels.iter().map(letter).collect()
    };
    for bayer in Bayer::ALL {
        let side = if bayer.is_quad() { 2 } else { 1 };
        for origin in [[0, 0], [8, 4]] {
            let found: String = [[0, 0], [1, 0], [0, 1], [1, 1]]
                .map(|[x, y]| {
                    let origin = [origin[0] + x * side, origin[1] + y * side];
                    channels(bayer, origin).remove(0)
                })
                .iter()
                .collect();
            assert_eq!(found, bayer.name().trim_start_matches("quad-"));
        }
    }
    // Crops that begin a pixel to the right, below, or both.
    assert_eq!(channels(Bayer::Rggb, [1, 0]), "grbg");
    assert_eq!(channels(Bayer::Rggb, [0, 1]), "gbrg");
    assert_eq!(channels(Bayer::Rggb, [5, 3]), "bggr");
}

#[test]
fn a_pixel_of_the_mosaic_equals_the_pixel_without_it() {
    let picture = flat([0.1, 0.2, 0.4], [32, 16]);
    let all = COARSE.read_out(picture.clone(), [3, 5], 9);
    let mosaic = Sensor { bayer: Some(Bayer::Gbrg), ..COARSE }.read_out(picture.clone(), [3, 5], 9);
    for (i, (all, one)) in all.pixels.iter().zip(&mosaic.pixels).enumerate() {
        let at = [3 + i as u32 % 32, 5 + i as u32 / 32];
        assert_eq!(one[0], all[Bayer::Gbrg.channel(at)]);
    }
}

#[test]
fn readings_of_any_light_lie_between_the_first_code_and_the_last() {
    let nasty = nasty_f32();
    let pixels: Vec<[f32; 3]> = nasty.iter().flat_map(|&a| nasty.map(|b| [a, b, 0.5])).collect();
    let picture = Picture { size: [nasty.len(), nasty.len()], pixels };
    for iso in [1e-300, 1e-3, 100.0, 1e7, 1e300] {
        for pitch in [0.0, 1e-9, 6.0, 1e9, f64::INFINITY] {
            for text in [
                "",
                "bits=1,read=0",
                "bits=16,black=65534,read=1e6",
                "bayer",
                "crosstalk=40,bayer=quad-gbrg",
                "crosstalk=40/0/5",
                "well=1",
                "dark=1e12,time=1e9,dsnu=1e12/1e12/1e12,prnu=30/30/30,hot=1/1e12",
            ] {
                let settings: SensorSettings = text.parse().expect("settings");
                let seconds = [f64::INFINITY, f64::NAN, -1.0][text.len() % 3];
                let sensor = settings.sensor(iso, pitch, seconds);
                let read = sensor.read_out(picture.clone(), [u32::MAX - 3, u32::MAX - 30], 1);
                let black = f64::from(sensor.black_level);
                let lowest = (-black / (f64::from(sensor.max_code()) - black)) as f32;
                assert!(
                    read.pixels.iter().flatten().all(|v| (lowest..=1.0).contains(v)),
                    "{sensor}: {read:?}"
                );
                let noise = sensor.relative_noise(0.18);
                assert!(noise >= 0.0, "{sensor}: {noise}");
            }
        }
    }
    // NaN and negative light give the reading of darkness.
    let quiet = Sensor { read_noise: read_noise(0.0), ..COARSE };
    let dark = quiet.read_out(flat([f32::NAN, -1.0, f32::NEG_INFINITY], [4, 4]), [0, 0], 0);
    assert!(dark.pixels.iter().all(|pixel| *pixel == [0.0; 3]));
    let nothing = Picture { size: [0, 0], pixels: Vec::new() };
    assert_eq!(quiet.read_out(nothing.clone(), [0, 0], 0), nothing);
}

/// Prepares a small render through a real lens of a grey sky.
fn job(sensor: &str, extra: &str) -> Job {
    let folder = folder();
    let text = format!(
        r#"Film "rgb" "integer xresolution" 37 "integer yresolution" 29 "float diagonal" 35 {extra}
           Sampler "sobol" "integer pixelsamples" 4
           Camera "realistic" "string lensfile" "{}/lenses/dgauss.50mm.dat"
             "float aperturediameter" 17 "float focusdistance" 4
           WorldBegin LightSource "infinite" "rgb L" [1 0.7 0.4]"#,
        root().display()
    );
    let path = write(&folder, "sky.pbrt", text);
    let changes = Changes { sensor: Some(sensor.parse().expect("settings")), ..Changes::default() };
    prepare(pbrt::read(&path).expect("a scene"), &changes).expect("a job").job
}

fn rendered(job: &Job, threads: usize) -> Picture {
    let pool = rayon(threads);
    let exposed =
        render(job, RenderOptions { threads, ..RenderOptions::default() }).expect("a render");
    pool.install(|| exposed.picture(job))
}

fn rayon(threads: usize) -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads")
}

#[test]
fn threads_and_crops_do_not_change_the_noise() {
    let terms = "read=3/1/2,dark=5,dsnu=2/1/1,prnu=1/1/1,hot=0.01/100";
    let job = job(&format!("iso=3200,pixel=4,{terms}"), "");
    let one = rendered(&job, 1);
    for threads in [2, 7] {
        assert_eq!(one, rendered(&job, threads), "{threads} threads");
    }
    let part = Job { frame: Frame { low: [5, 3], high: [30, 20], ..job.frame }, ..job.clone() };
    let pixels = (3..20).flat_map(|y| one.pixels[y * 37 + 5..y * 37 + 30].iter().copied());
    assert_eq!(rendered(&part, 2), Picture { size: [25, 17], pixels: pixels.collect() });
    let other = Job { seed: 1, ..job.clone() };
    assert_ne!(one, rendered(&other, 2));
    let ideal = Job { sensor: None, ..job.clone() };
    let exposed =
        render(&ideal, RenderOptions { threads: 1, ..RenderOptions::default() }).expect("a render");
    assert_eq!(
        exposed.picture(&ideal),
        exposed.film.picture(4),
        "a picture without a sensor differs"
    );
}

#[test]
fn the_full_well_follows_from_the_pixel_pitch_of_the_film() {
    let job = job("", "\"float iso\" 400");
    let sensor = job.sensor.expect("a sensor");
    assert_eq!((sensor.iso, sensor.read_noise.pixel, sensor.bits), (400.0, 2.5, 14));
    // A pitch of 744.5 um: 35 mm over 47.01 pixels.
    let pitch = 35e3 / f64::from(37 * 37 + 29 * 29).sqrt();
    assert!(
        (sensor.full_well / (1500.0 * pitch * pitch) - 1.0).abs() < 1e-12,
        "{}",
        sensor.full_well
    );
}

#[test]
fn the_command_reports_and_records_the_settings_of_the_camera() {
    let folder = folder();
    let out = folder.path().join("a.exr");
    let run = |more: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_petzval"));
        command.args(["render", "scenes/wide.pbrt", "--spp", "1", "--resolution", "30x20"]);
        command.args(["--threads", "1", "-v", "-o"]).arg(&out).args(more);
        let output = command.current_dir(root()).stdin(Stdio::null()).output().expect("it starts");
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (code, stderr) = run(&[]);
    assert_eq!(code, Some(0), "{stderr}");
    assert!(stderr.contains(" at ISO 100\n") && !stderr.contains("sensor:"), "{stderr}");
    let (code, stderr) = run(&["--sensor", "iso=800,well=40000", "--bayer", "gbrg"]);
    assert_eq!(code, Some(0), "{stderr}");
    for expected in [
        "sensor: iso=800,well=40000,read=2.5,bits=14,black=512,bayer=gbrg; white is 5000 electrons",
        "middle grey has 3.3 % of noise",
        "the picture is the mosaic, gbrg: one channel a pixel, in grey",
        "ISO 800: EV",
    ] {
        assert!(stderr.contains(expected), "{expected} is not in\n{stderr}");
    }
    let (picture, grey) = Picture::read_with_grey(&out).expect("a picture");
    assert!(grey && picture.pixels.iter().all(|p| p[0] == p[1] && p[1] == p[2]));
    let meta = exr::meta::MetaData::read_from_file(&out, true).expect("an EXR");
    let own = &meta.headers[0].own_attributes;
    assert_eq!(own.iso_speed, Some(800.0));
    let channels = &meta.headers[0].channels.list;
    assert_eq!(channels.iter().map(|channel| channel.name.to_string()).collect::<Vec<_>>(), ["Y"]);
    for name in ["sensor", "exposureValue"] {
        assert!(own.other.contains_key(&exr::meta::attribute::Text::from(name)), "{name}");
    }
    // Noise does not count as light.
    let dark = write(&folder, "dark.pbrt", "Camera \"perspective\"\nWorldBegin");
    let dark = Command::new(env!("CARGO_BIN_EXE_petzval"))
        .args(["render", "--resolution", "8x8", "--spp", "1", "--sensor=pixel=4", "-o"])
        .args([&out, &dark])
        .output()
        .expect("it starts");
    let stderr = String::from_utf8_lossy(&dark.stderr);
    assert!(stderr.contains("the picture is black"), "{stderr}");
    for (more, expected) in [
        (&["--sensor", "iso=-1"][..], "iso: expected a speed from 1 to 10000000, found \"-1\""),
        (&["--sensor", "x"], "put another option after --sensor"),
        (&["--bayer", "x"], "expected rggb, bggr, grbg or gbrg"),
    ] {
        let (code, stderr) = run(more);
        assert_eq!(code, Some(2), "{stderr}");
        assert!(stderr.contains(expected) && !stderr.contains("panicked"), "{stderr}");
    }
}

/// The channels of a mosaic would repeat one reading.
#[test]
fn the_file_of_a_mosaic_has_one_channel() {
    let folder = folder();
    for (sensor, names) in [("bayer", &["Y"][..]), ("bits=12", &["B", "G", "R"])] {
        for name in ["a.exr", "a.png", "a.jpg"] {
            let arguments = ["scenes/dgauss.pbrt", "--resolution", "16x12", "--spp", "2"];
            let path = folder.path().join(name);
            let more = ["--sensor", sensor, "-o", path.to_str().expect("a path")];
            let (code, _, stderr) =
                crate::support::petzval(root(), &[&["render"], &arguments[..], &more].concat());
            assert_eq!(code, 0, "{stderr}");
            if name == "a.exr" {
                let meta = exr::meta::MetaData::read_from_file(&path, true).expect("an EXR");
                let found = meta.headers[0].channels.list.iter().map(|one| one.name.to_string());
                assert_eq!(found.collect::<Vec<_>>(), names, "{sensor}");
            } else {
                let colour = image::open(&path).expect("a picture").color();
                assert_eq!(colour.has_color(), names.len() == 3, "{sensor}, {name}: {colour:?}");
            }
        }
    }
}
