//! The terms of EMVA 1288 (release 4.0, 2021): measured from readings of flat fields, they are those put in.

use petzval_image::Picture;
use petzval_render::sensor::{Sensor, SensorSettings};
use petzval_tools::sensor_analysis::{
    Exposure, FieldStack, FieldStatistics, PhotonTransfer, Variances,
};

/// Returns the sensor of settings, for an exposure of a second.
fn sensor(settings: &str) -> Sensor {
    settings.parse::<SensorSettings>().expect(settings).sensor(100.0, 6.0, 1.0)
}

fn flat(value: f32, side: usize) -> Picture {
    Picture { size: [side, side], pixels: vec![[value; 3]; side * side] }
}

/// Reads a uniform picture out so many times, in codes.
fn measure(sensor: &Sensor, value: f32, side: usize, pictures: u32) -> FieldStatistics {
    let span = f64::from((1u32 << sensor.bits) - 1 - sensor.black_level);
    let mut stack = FieldStack::new([side; 2]);
    for seed in 0..pictures {
        let read = sensor.read_out(flat(value, side), [0, 0], seed);
        stack.add(read.pixels.iter().map(|pixel| span * f64::from(pixel[1])));
    }
    stack.statistics()
}

#[test]
fn emva_1288_parameters_of_flat_fields_are_those_put_in() {
    let text =
        "iso=100,well=20000,bits=14,black=1024,read=4,dark=50,time=2,dsnu=6,prnu=1.2,pattern=5";
    let sensor = sensor(text);
    // Codes an electron.
    let gain = (16383.0 - 1024.0) / 20_000.0;
    let (side, pictures) = (600, 16);
    let dark = measure(&sensor, 0.0, side, pictures);
    let light = measure(&sensor, 0.5, side, pictures);
    let photons = Some(20_000.0);
    let found = PhotonTransfer::new(vec![Exposure { photons, light, dark }]).expect("photon noise");
    let near = |name: &str, found: f64, expected: f64, tolerance: f64| {
        println!("{name} {found:.4}, put in {expected:.4}");
        assert!((found / expected - 1.0).abs() < tolerance, "{name} {found}, not {expected}");
    };
    near("K", found.gain, gain, 5e-3);
    near("quantum efficiency", found.quantum_efficiency.expect("photons"), 0.5, 5e-3);
    // The dark current adds 100 electrons to the mean and to the variance.
    near("dark signal", found.dark.mean / found.gain, 100.0, 1e-3);
    near("dark noise", found.dark_noise.total, 116.0_f64.sqrt(), 5e-3);
    near("read noise", (found.dark_noise.total.powi(2) - 100.0).sqrt(), 4.0, 0.01);
    near("DSNU", found.dsnu.total, 6.0, 0.01);
    near("PRNU", found.prnu.total, 0.012, 0.01);
    for lines in [found.dark_noise.parts, found.dsnu.parts, found.prnu.parts.scaled(100.0)] {
        assert!(lines.row < 0.1 && lines.column < 0.1, "no lines: {lines:?}");
    }
    assert_eq!((found.saturation, found.full_well), (None, None));
}

#[test]
fn the_full_well_saturates_below_the_last_code() {
    // At half of the base speed, the well is full at half of the codes.
    for text in ["iso=50,well=20000,read=0", "iso=50,well=20000,read=0,dark=1e12,time=1e9"] {
        let read = sensor(text).read_out(flat(4.0, 64), [0, 0], 1);
        assert!(read.pixels.iter().flatten().all(|v| (v - 0.5).abs() < 1e-4), "{text}");
    }
}

#[test]
fn no_dark_current_adds_up_to_none_in_any_time() {
    let still = Sensor { seconds: 0.0, ..sensor("well=20000") };
    let expected = still.read_out(flat(0.01, 64), [0, 0], 1);
    for seconds in [1e9, f64::INFINITY, f64::NAN, -1.0] {
        let found = Sensor { seconds, ..still }.read_out(flat(0.01, 64), [0, 0], 1);
        assert_eq!(found, expected, "{seconds} s");
    }
}

/// Returns the deviation over the mean of the readings of a flat field.
fn noise(sensor: &Sensor, value: f32) -> f64 {
    let read = sensor.read_out(flat(value, 1000), [0, 0], 3);
    let values = || read.pixels.iter().map(|pixel| f64::from(pixel[1]));
    let mean = values().sum::<f64>() / 1e6;
    (values().map(|v| (v - mean).powi(2)).sum::<f64>() / 1e6).sqrt() / f64::from(value)
}

#[test]
fn the_estimate_of_noise_counts_every_term() {
    let plain = "well=20000,bits=16,black=20000,read=0";
    // Alone, light of 100 electrons has 10 % of noise.
    for (term, by_lines) in [
        ("dark=300", false),
        ("dark=30,time=10", false),
        ("dsnu=20", false),
        ("dsnu=0/20/20", true),
        ("prnu=20", false),
        ("prnu=0/20/20", true),
        ("read=20", false),
        ("read=0/20/20", true),
    ] {
        let text = match term.starts_with("read") {
            true => format!("well=20000,bits=16,black=20000,{term}"),
            false => format!("{plain},{term}"),
        };
        let sensor = sensor(&text);
        let (found, said) = (noise(&sensor, 0.005), sensor.relative_noise(0.005) / 100.0);
        // A thousand rows and columns know their deviation to 2.2 % each; five of these.
        let tolerance = if by_lines { 0.11 } else { 0.01 };
        assert!((found / said - 1.0).abs() < tolerance, "{term}: {found}, said {said}");
        assert!(said > 0.19, "{term} is counted: {said}");
    }
}

#[test]
fn fields_of_one_sensor_are_independent_of_those_of_others() {
    let side = 256;
    // Fields without shot noise: the well is large, and the code fine.
    let field = |term: &str, value: f32, pattern: u32| {
        let text = format!("well=1e6,bits=16,black=30000,{term},pattern={pattern}");
        let read = sensor(&text).read_out(flat(value, side), [0, 0], pattern);
        let values: Vec<_> = read.pixels.iter().map(|pixel| f64::from(pixel[0])).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let length = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>().sqrt();
        values.into_iter().map(|v| (v - mean) / length).collect::<Vec<_>>()
    };
    let mut fields = Vec::new();
    for pattern in [0, 1, 2, 3, 1000] {
        fields.push((format!("DSNU {pattern}"), field("read=0,dsnu=30000", 0.0, pattern)));
        fields.push((format!("PRNU {pattern}"), field("read=0,prnu=10", 0.5, pattern)));
        fields.push((format!("hot pixels {pattern}"), field("read=0,hot=0.5/50000", 0.0, pattern)));
        fields.push((format!("noise {pattern}"), field("read=30000", 0.0, pattern)));
    }
    let limit = 5.0 / side as f64;
    for (i, (name, one)) in fields.iter().enumerate() {
        for (other_name, other) in &fields[..i] {
            let correlation = one.iter().zip(other).map(|(a, b)| a * b).sum::<f64>();
            assert!(correlation.abs() < limit, "{name} and {other_name}: {correlation}");
        }
    }
}

#[test]
fn rows_and_columns_have_patterns_and_noise_of_their_own() {
    let gain = (16383.0 - 1024.0) / 20_000.0;
    // 700 rows know their deviation to 2.7 %; five of these. Their noise is known from 16 pictures.
    let near = |name: &str, variance: f64, expected: f64, unit: f64, tolerance: f64| {
        let deviation = variance.max(0.0).sqrt() / unit;
        println!("{name} {deviation:.4}, put in {expected}");
        let most = (tolerance * expected).max(0.02);
        assert!((deviation - expected).abs() < most, "{name} {deviation}");
    };
    let fixed = measure(&sensor("well=20000,bits=14,black=1024,read=0,dsnu=0/5/8"), 0.0, 700, 2);
    assert_eq!(fixed.temporal, Variances::default(), "patterns are fixed");
    near("DSNU of rows", fixed.spatial.row, 5.0, gain, 0.14);
    near("DSNU of columns", fixed.spatial.column, 8.0, gain, 0.14);
    let lit = measure(&sensor("well=20000,bits=14,black=1024,read=0,prnu=0/2/3"), 0.5, 700, 8);
    near("PRNU of rows", lit.spatial.row, 2.0, lit.mean / 100.0, 0.14);
    near("PRNU of columns", lit.spatial.column, 3.0, lit.mean / 100.0, 0.14);
    // Noise of rows and columns is new in every picture, and its fixed part is none.
    for (text, [row, column]) in [("read=0/3/0", [3.0, 0.0]), ("read=0/0/3", [0.0, 3.0])] {
        let text = format!("well=20000,bits=14,black=1024,{text}");
        let found = measure(&sensor(&text), 0.0, 700, 16);
        near("noise of rows", found.temporal.row, row, gain, 0.05);
        near("noise of columns", found.temporal.column, column, gain, 0.05);
        let limit = 2.0 * found.temporal.total() / 16.0;
        assert!(found.spatial.total().abs() < limit, "no pattern: {:?}", found.spatial);
    }
    // The filters of a mosaic do not divide a row.
    let mosaic = sensor("well=20000,bits=14,black=1024,read=0/3/0,dsnu=0/4/0,bayer");
    let read = mosaic.read_out(flat(0.0, 64), [0, 0], 1);
    for row in read.pixels.chunks(64) {
        assert!(row.iter().all(|pixel| *pixel == row[0]), "a row of a mosaic: {row:?}");
    }
    assert_ne!(read.pixels[0], read.pixels[64], "rows differ");
}

#[test]
fn hot_pixels_are_those_of_the_pattern_and_grow_with_time() {
    let hot = |text: &str, seed| {
        let read = sensor(text).read_out(flat(0.0, 1000), [0, 0], seed);
        let electrons = |pixel: &[f32; 3]| f64::from(pixel[0]) * 20_000.0;
        let bright = |(i, pixel)| (electrons(pixel) > 30.0).then_some((i, electrons(pixel)));
        read.pixels.iter().enumerate().filter_map(bright).collect::<Vec<_>>()
    };
    let text = "well=20000,bits=16,black=1024,read=2,hot=0.001/1000";
    let (one, other) = (hot(text, 1), hot(text, 2));
    // exp(-30 / 1000) of 1000 photosites, whose number is Poisson-distributed.
    assert!((one.len() as f64 - 970.0).abs() < 160.0, "{} hot pixels", one.len());
    let both = one.iter().filter(|(i, _)| other.iter().any(|(j, _)| i == j)).count();
    assert!(both as f64 > 0.97 * one.len() as f64, "the same in both pictures: {both}");
    let mean = one.iter().map(|(_, electrons)| electrons).sum::<f64>() / one.len() as f64;
    assert!((mean - 1030.0).abs() < 170.0, "mean {mean} electrons");
    let longer = hot(&format!("{text},time=4"), 1);
    let ratio =
        longer.iter().map(|(_, electrons)| electrons).sum::<f64>() / (mean * one.len() as f64);
    assert!((ratio - 4.0).abs() < 0.1, "four times as long: {ratio}");
    let elsewhere = hot(&format!("{text},pattern=9"), 1);
    let both = one.iter().filter(|(i, _)| elsewhere.iter().any(|(j, _)| i == j)).count();
    assert!(both < 20, "another sensor has others: {both}");
}
