//! The sensor behind the colour filters of a measured camera: photosites count the camera's channels.

use crate::support::nasty::nasty_f32;
use crate::support::{folder, write};
use petzval_image::{Note, Picture};
use petzval_render::prepare::{Changes, Prepared, prepare};
use petzval_render::sensor::{Bayer, Components, FixedPattern, Sensor};
use petzval_scene_formats::pbrt;
use petzval_spectrum::{CameraSensor, ColourSpace, Passband};

const CAMERA: &str = "canon_eos_5d";

/// Prepares a render by a sensor, with these parameters of the film.
fn prepared(film: &str, changes: Changes) -> Prepared {
    let folder = folder();
    let text = format!(
        "Film \"rgb\" \"integer xresolution\" 6 \"integer yresolution\" 4 {film}
         Camera \"perspective\" WorldBegin LightSource \"infinite\" \"rgb L\" [0.3 0.3 0.3]"
    );
    let settings = "iso=400,well=20000,read=5,bits=16,black=4096".parse().expect("settings");
    let changes = Changes { sensor: Some(settings), ..changes };
    let description = pbrt::read(&write(&folder, "a.pbrt", text)).expect("a scene");
    prepare(description, &changes).expect("a job")
}

fn sensor(film: &str) -> Sensor {
    prepared(film, Changes::default()).job.sensor.expect("a sensor")
}

fn camera() -> Sensor {
    sensor(&format!("\"string sensor\" \"{CAMERA}\""))
}

/// A 3 x 3 matrix, in rows.
type Matrix = [[f64; 3]; 3];

fn product(matrix: Matrix, v: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// Returns the solution of three equations by Cramer's rule.
fn solve(matrix: Matrix, v: [f64; 3]) -> [f64; 3] {
    let determinant = |m: Matrix| {
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
            - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    };
    [0, 1, 2].map(|column| {
        let mut replaced = matrix;
        (0..3).for_each(|row| replaced[row][column] = v[row]);
        determinant(replaced) / determinant(matrix)
    })
}

/// Returns the camera's channels of a grey of 1, relative to the largest, and the matrix from such channels to
/// the picture.
fn naive() -> ([f64; 3], Matrix) {
    let known = CameraSensor::from_name(CAMERA).expect("a camera");
    let response = known.response(None, ColourSpace::Srgb);
    let rows = |m: glam::DMat3| m.transpose().to_cols_array_2d();
    let (from_srgb, seen) = (rows(response.from_srgb), rows(response.to_srgb()));
    // The light whose picture is white, then the channels of that light.
    let white = product(from_srgb, solve(seen, [1.0; 3]));
    let largest = white.iter().fold(0.0f64, |a, &b| a.max(b));
    let columns = [0, 1, 2].map(|channel| {
        let mut one = [0.0; 3];
        one[channel] = largest;
        product(seen, solve(from_srgb, one))
    });
    let matrix = [0, 1, 2].map(|row| columns.map(|column| column[row]));
    (white.map(|channel| channel / largest), matrix)
}

fn grey(value: f32, side: usize) -> Picture {
    Picture { size: [side, side], pixels: vec![[value; 3]; side * side] }
}

/// Returns the mean of a picture and the covariances of its channels.
fn moments(picture: &Picture) -> ([f64; 3], Matrix) {
    let n = picture.pixels.len() as f64;
    let pixels = || picture.pixels.iter().map(|pixel| pixel.map(f64::from));
    let mean = [0, 1, 2].map(|c| pixels().map(|pixel| pixel[c]).sum::<f64>() / n);
    let covariance = |i: usize, j: usize| {
        pixels().map(|p| (p[i] - mean[i]) * (p[j] - mean[j])).sum::<f64>() / (n - 1.0)
    };
    (mean, [0, 1, 2].map(|i| [0, 1, 2].map(|j| covariance(i, j))))
}

#[test]
fn noise_of_a_grey_patch_is_that_of_the_raw_channels_through_the_matrix() {
    let (sensor, side) = (camera(), 700);
    let (white, matrix) = naive();
    assert_eq!(sensor.white_electrons(), 5000.0);
    let n = (side * side) as f64;
    for value in [0.02, 0.3] {
        let (mean, found) = moments(&sensor.read_out(grey(value, side), [0, 0], 3));
        let value = f64::from(value);
        // Poisson: the variance is the mean. Read noise of 5 electrons adds to it.
        let variances = white.map(|share| (value * share * 5000.0 + 25.0) / (5000.0 * 5000.0));
        let expected = |i: usize, j: usize| {
            (0..3).map(|k| matrix[i][k] * matrix[j][k] * variances[k]).sum::<f64>()
        };
        for i in 0..3 {
            let deviation = expected(i, i).sqrt();
            assert!((mean[i] - value).abs() < 5.0 * deviation / n.sqrt(), "{value}: {mean:?}");
            for j in 0..3 {
                let spread = (expected(i, i) * expected(j, j) + expected(i, j).powi(2)) / n;
                let off = found[i][j] - expected(i, j);
                assert!(off.abs() < 5.0 * spread.sqrt(), "{value} {i}{j}: {found:?}");
            }
        }
        // Linear sRGB of its own would have 5000 electrons in each channel, and no correlation.
        assert!(found[0][0] > 3.0 * (value * 5000.0 + 25.0) / (5000.0 * 5000.0), "{found:?}");
        assert!(expected(0, 1) < -0.1 * expected(1, 1), "correlated noise");
        let noisiest = (0..3).map(|i| found[i][i].sqrt() / mean[i]).fold(0.0, f64::max);
        assert!((sensor.relative_noise(value) / noisiest / 100.0 - 1.0).abs() < 0.02);
    }
}

#[test]
fn noise_that_the_channels_have_in_common_is_developed_as_one() {
    let side = 1000;
    for (read, response) in [([0.0, 300.0], [0.0, 0.0]), ([0.0, 0.0], [0.0, 0.2])] {
        let lines = |[pixel, row]: [f64; 2]| Components { pixel, row, column: row };
        let fixed_pattern = FixedPattern { response: lines(response), ..Default::default() };
        let sensor = Sensor { read_noise: lines(read), fixed_pattern, ..camera() };
        let (mean, found) = moments(&sensor.read_out(grey(0.3, side), [0, 0], 3));
        let noisiest = (0..3).map(|i| found[i][i].sqrt() / mean[i]).fold(0.0, f64::max);
        // A thousand rows and columns know their deviation to 2.2 % each; five of these.
        let said = sensor.relative_noise(0.3) / 100.0;
        assert!((said / noisiest - 1.0).abs() < 0.11, "{said}, found {noisiest}");
    }
}

#[test]
fn a_mosaic_holds_the_raw_channels() {
    let sensor = Sensor { bayer: Some(Bayer::Grbg), full_well: 1e12, ..camera() };
    let white = naive().0;
    let read = sensor.read_out(grey(0.4, 2), [0, 0], 0);
    for (pixel, channel) in read.pixels.iter().zip([1, 0, 2, 1]) {
        let expected = 0.4 * white[channel];
        assert!(pixel.iter().all(|v| (f64::from(*v) - expected).abs() < 1e-4), "{read:?}");
    }
    let noisiest = white.iter().fold(1.0f64, |a, &b| a.min(b));
    let sensor = Sensor { full_well: 20_000.0, ..sensor };
    let electrons = 0.4 * noisiest * 5000.0;
    let noise = 100.0 * (electrons + 25.0).sqrt() / electrons;
    assert!((sensor.relative_noise(0.4) / noise - 1.0).abs() < 1e-3);
}

#[test]
fn saturated_light_is_white_and_any_light_is_finite() {
    let sensor = camera();
    let read = sensor.read_out(grey(3.0, 8), [0, 0], 0);
    assert!(read.pixels.iter().flatten().all(|v| (v - 1.0).abs() < 1e-3), "{read:?}");
    let nasty = nasty_f32();
    let pixels = nasty.iter().flat_map(|&a| nasty.map(|b| [a, b, 0.5])).collect();
    let picture = Picture { size: [nasty.len(), nasty.len()], pixels };
    for bayer in [None, Some(Bayer::Rggb)] {
        let read = Sensor { bayer, ..sensor }.read_out(picture.clone(), [0, 0], 0);
        assert!(read.pixels.iter().flatten().all(|v| v.is_finite() && v.abs() < 10.0));
    }
    assert_eq!(sensor.relative_noise(0.0), f64::INFINITY);
}

#[test]
fn a_camera_of_a_passband_or_none_has_no_filters() {
    assert_eq!(sensor("").filters, None);
    assert_eq!(sensor("\"string sensor\" \"cie1931\" \"float whitebalance\" 3000").filters, None);
    let passband = Some(Passband { range: [540.0, 560.0] });
    let changes = Changes { passband, ..Changes::default() };
    let narrow = prepared(&format!("\"string sensor\" \"{CAMERA}\""), changes);
    assert_eq!(narrow.job.sensor.expect("a sensor").filters, None);
}

#[test]
fn a_picture_notes_the_white_and_the_matrix_of_its_camera() {
    let Prepared { notes, .. } =
        prepared(&format!("\"string sensor\" \"{CAMERA}\""), Changes::default());
    let numbers = |name: &str| -> Vec<f64> {
        let note = notes.iter().find(|(other, _)| *other == name).expect("a note");
        let Note::Text(text) = &note.1 else { panic!("{note:?}") };
        text.split(' ').map(|word| word.parse().expect("a number")).collect()
    };
    let (white, to_xyz) = (numbers("sensorWhite"), numbers("sensorToXYZ"));
    let xyz = to_xyz.chunks(3).map(|row| (0..3).map(|i| row[i] * white[i]).sum::<f64>());
    let d65 = [0.9505, 1.0, 1.0891];
    assert!(xyz.zip(d65).all(|(found, expected)| (found - expected).abs() < 2e-3), "{notes:?}");
}
