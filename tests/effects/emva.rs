//! The terms of EMVA 1288 (release 4.0, 2021): measured from readings of flat fields, they are those put in.

use petzval_image::Picture;
use petzval_render::sensor::{Sensor, SensorSettings};

/// Returns the sensor of settings, for an exposure of a second.
fn sensor(settings: &str) -> Sensor {
    settings.parse::<SensorSettings>().expect(settings).sensor(100.0, 6.0, 1.0)
}

fn flat(value: f32, side: usize) -> Picture {
    Picture { size: [side, side], pixels: vec![[value; 3]; side * side] }
}

/// Mean and spread of stacked pictures, by the methods of EMVA 1288 (release 4.0), in codes.
struct Measured {
    mean: f64,
    /// Temporal variance: half of the mean squared difference of two pictures.
    temporal: f64,
    /// Spatial variance of the mean picture, without what is left of the temporal one.
    spatial: f64,
    /// That of the means of rows and of columns.
    rows: f64,
    columns: f64,
}

/// Reads a uniform picture out so many times.
fn measure(sensor: &Sensor, value: f32, side: usize, pictures: u32) -> Measured {
    let span = f64::from((1u32 << sensor.bits) - 1 - sensor.black_level);
    let mut sums = vec![0.0; side * side];
    let mut temporal = 0.0;
    let count = sums.len() as f64;
    for pair in 0..pictures / 2 {
        let read = |seed| sensor.read_out(flat(value, side), [0, 0], seed);
        let (one, other) = (read(2 * pair), read(2 * pair + 1));
        for (sum, (a, b)) in sums.iter_mut().zip(one.pixels.iter().zip(&other.pixels)) {
            let (a, b) = (span * f64::from(a[1]), span * f64::from(b[1]));
            temporal += (a - b) * (a - b) / 2.0;
            *sum += a + b;
        }
    }
    let n = f64::from(pictures);
    let temporal = temporal / (count * n / 2.0);
    let mean = sums.iter().sum::<f64>() / n / count;
    let variance = |values: &[f64]| {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (values.len() - 1) as f64
    };
    let averages: Vec<f64> = sums.iter().map(|sum| sum / n).collect();
    let average = |of: &dyn Fn(usize) -> f64| (0..side).map(of).sum::<f64>() / side as f64;
    let rows: Vec<_> = (0..side).map(|y| average(&|x| averages[y * side + x])).collect();
    let columns: Vec<_> = (0..side).map(|x| average(&|y| averages[y * side + x])).collect();
    let spatial = variance(&averages) - temporal / n;
    Measured { mean, temporal, spatial, rows: variance(&rows), columns: variance(&columns) }
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

    // The photon transfer curve has the system gain K for a slope.
    let found = (light.temporal - dark.temporal) / (light.mean - dark.mean);
    assert!((found / gain - 1.0).abs() < 5e-3, "K {found}, not {gain}");
    // The dark current adds 100 electrons to the mean and to the variance.
    assert!((dark.mean / gain - 100.0).abs() < 0.1, "dark signal {}", dark.mean / gain);
    let read = (dark.temporal - 1.0 / 12.0) / (gain * gain) - 100.0;
    assert!((read.sqrt() / 4.0 - 1.0).abs() < 0.01, "read noise {}", read.sqrt());
    let dsnu = dark.spatial.sqrt() / gain;
    assert!((dsnu / 6.0 - 1.0).abs() < 0.01, "DSNU {dsnu}");
    let prnu = (light.spatial - dark.spatial).sqrt() / (light.mean - dark.mean);
    assert!((prnu / 0.012 - 1.0).abs() < 0.01, "PRNU {prnu}");
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
    let fixed = sensor("well=20000,bits=14,black=1024,read=0,dsnu=0/5/8");
    let gain = (16383.0 - 1024.0) / 20_000.0;
    let found = measure(&fixed, 0.0, 700, 2);
    assert_eq!(found.temporal, 0.0, "patterns are fixed");
    // 700 rows know their deviation to 2.7 %; five of these.
    for (variance, expected) in [(found.rows, 5.0), (found.columns, 8.0)] {
        let deviation = variance.sqrt() / gain;
        assert!((deviation / expected - 1.0).abs() < 0.14, "{deviation}, not {expected}");
    }
    let response = sensor("well=20000,bits=14,black=1024,read=0,prnu=0/2/3");
    let lit = measure(&response, 0.5, 700, 8);
    for (variance, expected) in [(lit.rows, 0.02), (lit.columns, 0.03)] {
        let share = (variance - lit.temporal / (700.0 * 8.0)).sqrt() / lit.mean;
        assert!((share / expected - 1.0).abs() < 0.14, "PRNU of lines {share}, not {expected}");
    }
    // Noise of rows and columns is new in every picture, and its fixed part is none.
    let rows = measure(&sensor("well=20000,bits=14,black=1024,read=0/3/0"), 0.0, 700, 16);
    let columns = measure(&sensor("well=20000,bits=14,black=1024,read=0/0/3"), 0.0, 700, 16);
    for (noisy, along, across) in
        [(&rows, rows.rows, rows.columns), (&columns, columns.columns, columns.rows)]
    {
        let deviation = (noisy.temporal - 1.0 / 12.0).sqrt() / gain;
        assert!((deviation / 3.0 - 1.0).abs() < 0.05, "noise of lines {deviation}");
        assert!(along < 2.0 * noisy.temporal / 16.0 && across < 0.01, "no pattern");
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
