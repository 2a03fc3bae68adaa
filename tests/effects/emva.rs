//! The terms of EMVA 1288 (release 4.0, 2021): measured from readings of flat fields, they are those put in.

use petzval_image::Picture;
use petzval_render::sensor::{Sensor, SensorSettings};

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
        let read = |seed| sensor.read_out(&flat(value, side), [0, 0], seed);
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
    let settings: SensorSettings = text.parse().expect("settings");
    let sensor = settings.sensor(100.0, 6.0, 0.0);
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
    assert!((dsnu / 6.0 - 1.0).abs() < 0.02, "DSNU {dsnu}");
    let prnu = (light.spatial - dark.spatial).sqrt() / (light.mean - dark.mean);
    assert!((prnu / 0.012 - 1.0).abs() < 0.02, "PRNU {prnu}");
    // The full well saturates.
    let full = sensor.read_out(&flat(4.0, 64), [0, 0], 1);
    let mean = full.pixels.iter().map(|pixel| f64::from(pixel[0])).sum::<f64>() / 4096.0;
    assert!((mean - 1.0).abs() < 5e-3, "saturation at {mean}");
    let noise = (light.temporal + light.spatial).sqrt() / (gain * 10_000.0);
    let said = sensor.relative_noise(0.5) / 100.0;
    assert!((noise / said - 1.0).abs() < 0.02, "noise {noise}, said {said}");
}

#[test]
fn rows_and_columns_have_patterns_and_noise_of_their_own() {
    let parse = |text: &str| {
        let settings: SensorSettings = text.parse().expect(text);
        settings.sensor(100.0, 6.0, 1.0)
    };
    let fixed = parse("well=20000,bits=14,black=1024,read=0,dsnu=0/5/8");
    let gain = (16383.0 - 1024.0) / 20_000.0;
    let found = measure(&fixed, 0.0, 700, 2);
    assert_eq!(found.temporal, 0.0, "patterns are fixed");
    // 700 rows know their deviation to 2.7 %; five of these.
    for (variance, expected) in [(found.rows, 5.0), (found.columns, 8.0)] {
        let deviation = variance.sqrt() / gain;
        assert!((deviation / expected - 1.0).abs() < 0.14, "{deviation}, not {expected}");
    }
    let response = parse("well=20000,bits=14,black=1024,read=0,prnu=0/2/0");
    let lit = measure(&response, 0.5, 700, 8);
    let share = (lit.rows - lit.temporal / (700.0 * 8.0)).sqrt() / lit.mean;
    assert!((share / 0.02 - 1.0).abs() < 0.14, "PRNU of rows {share}");
    // Noise of rows is new in every picture, and its fixed part is none.
    let noisy = measure(&parse("well=20000,bits=14,black=1024,read=0/3/0"), 0.0, 700, 16);
    let deviation = (noisy.temporal - 1.0 / 12.0).sqrt() / gain;
    assert!((deviation / 3.0 - 1.0).abs() < 0.05, "row noise {deviation}");
    assert!(noisy.rows < 2.0 * noisy.temporal / 16.0 && noisy.columns < 0.01, "no pattern");
    // The filters of a mosaic do not divide a row.
    let mosaic = parse("well=20000,bits=14,black=1024,read=0/3/0,dsnu=0/4/0,bayer");
    let read = mosaic.read_out(&flat(0.0, 64), [0, 0], 1);
    for row in read.pixels.chunks(64) {
        assert!(row.iter().all(|pixel| *pixel == row[0]), "a row of a mosaic: {row:?}");
    }
}

#[test]
fn hot_pixels_are_those_of_the_pattern_and_grow_with_time() {
    let hot = |text: &str, seed| {
        let settings: SensorSettings = text.parse().expect(text);
        let sensor = settings.sensor(100.0, 6.0, 1.0);
        let read = sensor.read_out(&flat(0.0, 1000), [0, 0], seed);
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
