//! Photosites of several kinds: binning, a second sensitivity, and microlenses.

use crate::support::{mean_and_error, root};
use petzval_image::{EncodingOptions, ImageError, Picture};
use petzval_lens::{LensModel, Pose};
use petzval_render::film::Frame;
use petzval_render::job::Job;
use petzval_render::prepare::{Changes, PrepareError, prepare};
use petzval_render::sensor::{
    MicrolensError, Microlenses, PixelVignetting, Sensor, SensorSettings,
};

fn sensor(text: &str) -> Sensor {
    text.parse::<SensorSettings>().expect(text).sensor(100.0, 4.0, 1.0)
}

/// Returns the green readings of an even picture.
fn readings(sensor: &Sensor, value: f32, size: [usize; 2], seed: u32) -> Vec<f64> {
    let picture = Picture { size, pixels: vec![[value; 3]; size[0] * size[1]] };
    let read = sensor.read_out(picture, [0, 0], seed);
    read.pixels.iter().map(|pixel| f64::from(pixel[1])).collect()
}

/// Returns the variance of values, with its standard error for normal ones.
fn variance(values: &[f64]) -> [f64; 2] {
    let [mean, _] = mean_and_error(values);
    let n = values.len() as f64;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
    [variance, variance * (2.0 / n).sqrt()]
}

#[test]
fn pixels_of_binned_codes_read_the_sum_of_their_photosites() {
    const SIDE: usize = 512;
    let settings = "well=4000,read=3,dark=40,dsnu=5,prnu=2,bits=16,black=4000";
    let (single, binned) = (sensor(settings), sensor(&format!("{settings},binning=3")));
    for value in [0.0, 0.3] {
        let photosites = readings(&single, value, [3 * SIDE, 3 * SIDE], 1);
        // White is the sum of full wells: a reading is the mean of its photosites.
        let of_sums: Vec<f64> = (0..SIDE * SIDE)
            .map(|i| {
                let [x, y] = [i % SIDE, i / SIDE];
                let at = |k: usize| (3 * y + k / 3) * 3 * SIDE + 3 * x + k % 3;
                (0..9).map(|k| photosites[at(k)]).sum::<f64>() / 9.0
            })
            .collect();
        let pixels = readings(&binned, value, [SIDE, SIDE], 2);
        let [[found, error], [expected, other]] =
            [&pixels, &of_sums].map(|values| mean_and_error(values));
        assert!((found - expected).abs() < 5.0 * error.hypot(other), "{found}, not {expected}");
        let [[found, error], [expected, other]] =
            [&pixels, &of_sums].map(|values| variance(values));
        assert!((found - expected).abs() < 5.0 * error.hypot(other), "{found}, not {expected}");
    }
    // Charge is read once; rows of pixels are independent sums of rows.
    let charge = sensor("read=3/1/0,binning=4/charge");
    assert_eq!(charge.read_noise, sensor("read=3/1/0").read_noise);
    let codes = sensor("read=3/1/0.5,binning=4").read_noise;
    assert_eq!([codes.pixel, codes.row, codes.column], [12.0, 8.0, 4.0]);
    let hot = sensor("hot=0.01/100,binning=16").fixed_pattern.hot;
    assert!((hot.share * hot.dark_current - 256.0).abs() < 1e-9, "{hot:?}");
    // The pixel of the film holds four photosites, each a quarter of its area.
    assert_eq!(sensor("binning=2").full_well, sensor("").full_well);
    assert_eq!(sensor("pixel=1,binning=2").full_well, 6000.0);
    assert_eq!(sensor("well=5000,binning=2").full_well, 20_000.0);
}

#[test]
fn a_second_sensitivity_reads_what_saturates_the_first() {
    let hdr = sensor("iso=100,well=20000,read=2,bits=14,hdr=16");
    let plain = sensor("iso=100,well=20000,read=2,bits=14");
    let size = [300, 300];
    for value in [0.0, 0.2, 0.7, 1.3, 6.0, 14.0] {
        let found = readings(&hdr, value, size, 3);
        let [mean, error] = mean_and_error(&found);
        assert!((mean - f64::from(value)).abs() < 5.0 * error, "{value}: {mean} +- {error}");
        if value < 0.8 {
            assert_eq!(
                found,
                readings(&plain, value, size, 3),
                "the first photosite is as without"
            );
        }
        if value > 0.0 {
            let [variance, error] = variance(&found);
            let expected = (hdr.relative_noise(value.into()) / 100.0 * f64::from(value)).powi(2);
            assert!(
                (variance - expected).abs() < 5.0 * error,
                "{value}: {variance}, not {expected}"
            );
        }
    }
    // The area of the small photosite collects less dark current, whether in all or in hot pixels: 1.5 after scaling.
    for dark in ["dark=30000", "hot=1/30000"] {
        let warm = sensor(&format!("well=20000,hdr=16,bits=14,{dark}"));
        let merged: Vec<f64> =
            readings(&warm, 0.02, size, 4).into_iter().filter(|&v| v > 1.0).collect();
        let [mean, _] = mean_and_error(&merged);
        assert!(merged.len() > 10_000 && mean < 4.0, "{dark}: {mean} in {}", merged.len());
    }
    // Both have hot pixels of their own.
    let warm = sensor("well=20000,hdr=16,hot=0.01/1e6,dark=100,bits=14");
    let bright = readings(&warm, 0.02, size, 4).into_iter().filter(|&v| v > 1.5).count();
    // Of a hundred pixels, one has a first photosite that is hot, and one a second.
    assert!(bright < 40, "{bright} pixels of 90,000");
    assert!(readings(&hdr, 40.0, size, 3).iter().all(|&v| (v - 16.0).abs() < 0.1));
    // Halves of dual pixels add up to the whole in the range of both photosites.
    for value in [0.2, 0.7, 5.0] {
        let half = Picture { size, pixels: vec![[value / 2.0; 3]; size[0] * size[1]] };
        let (whole, halves) = hdr.read_out_halves([half.clone(), half], [0, 0], 9);
        let [whole, left, right] = [&whole, &halves[0], &halves[1]].map(|picture| {
            mean_and_error(&picture.pixels.iter().map(|p| f64::from(p[1])).collect::<Vec<_>>())
        });
        let off = left[0] + right[0] - whole[0];
        assert!(off.abs() < 5.0 * whole[1].hypot(left[1]).hypot(right[1]), "{value}: {off}");
        assert!((whole[0] - f64::from(value)).abs() < 5.0 * whole[1], "{value}: {whole:?}");
    }
}

/// Prepares a picture of white through a lens.
fn job_through(lens: &str, settings: &str) -> Result<Job, PrepareError> {
    let text = format!(
        "Film \"rgb\" \"integer xresolution\" 180 \"integer yresolution\" 120 \"float diagonal\" 43.27\n\
         Camera \"realistic\" \"string lensfile\" \"{}\" \"float aperturediameter\" 6 \
         \"float focusdistance\" 9 \nWorldBegin LightSource \"infinite\"\n",
        root().join("lenses").join(lens).display()
    );
    let folder = crate::support::folder();
    let path = crate::support::write(&folder, "scene.pbrt", text);
    let description = petzval_scene_formats::pbrt::read(&path).expect("a scene");
    let changes = Changes { sensor: Some(settings.parse().expect(settings)), ..Changes::default() };
    prepare(description, &changes).map(|prepared| prepared.job)
}

fn job(settings: &str) -> Job {
    job_through("dgauss.50mm.dat", settings).expect("a job")
}

#[test]
fn microlenses_lose_oblique_light_that_they_are_not_made_for() {
    let job = job("microlens=20");
    let LensModel::Real(lens) = &job.camera.model else { panic!() };
    let vignetting = |half_angle: f64, corner_angle: f64| {
        let microlenses = Microlenses { half_angle, corner_angle };
        PixelVignetting::new(microlenses, &job.camera, &job.frame).expect("a real lens")
    };
    // First-order optics: chief rays come from the middle of the exit pupil.
    let pupil = lens.film_distance - lens.paraxial.exit_pupil.position;
    let share = |vignetting: &PixelVignetting, pixel: [u32; 2]| {
        let white = Picture { size: [1, 1], pixels: vec![[1.0; 3]] };
        let noiseless =
            Sensor { vignetting: Some(*vignetting), ..sensor("well=1e12,read=0,bits=16,black=0") };
        let read = noiseless.read_out(white, pixel, 1).pixels[0][1];
        f64::from(read)
    };
    let pitch = 36.0 / 180.0;
    let plain = vignetting(20.0, 0.0);
    for (pixel, tolerance) in [
        ([90, 60], 0.01),
        ([100, 60], 0.01),
        ([120, 60], 0.03),
        ([90, 20], 0.03),
        ([179, 119], 0.1),
    ] {
        let [x, y] = [pixel[0] as f64 - 89.5, pixel[1] as f64 - 59.5];
        let angle = (x.hypot(y) * pitch / pupil).atan().to_degrees();
        let found = 20.0 * (-share(&plain, pixel).log2()).sqrt();
        // Pupil aberration brings the chief rays of the corner nearer to the axis.
        assert!(
            (found - angle).abs() < tolerance * angle + 0.15,
            "{pixel:?}: {found}, not {angle}"
        );
    }
    let corner = (43.27_f64 / 2.0 / pupil).atan().to_degrees();
    assert!(corner > 10.0, "{corner}");
    assert!(share(&plain, [0, 0]) < 0.9);
    assert!(share(&vignetting(20.0, corner), [0, 0]) > 0.99);
    // Made for a steeper lens, the corner loses light again.
    assert!(share(&vignetting(20.0, corner + 20.0), [0, 0]) < 0.6);
    assert!(job.sensor.expect("a sensor").vignetting.is_some());
    // On a shifted film, microlenses are made for the middle of the sensor, and chief rays come from the axis.
    let mut camera = job.camera.clone();
    let mut pose = |pose: Pose| {
        let LensModel::Real(lens) = &mut camera.model else { panic!() };
        lens.film_pose = pose;
        camera.clone()
    };
    let decentred = pose(Pose { decentre: [10.0, 0.0], ..Pose::ALIGNED });
    let microlenses = Microlenses { half_angle: 10.0, corner_angle: 40.0 };
    let shifted = PixelVignetting::new(microlenses, &decentred, &job.frame).expect("a real lens");
    let radial = |mm: f64| (mm / pupil).atan().to_degrees();
    for column in [40, 90, 140] {
        let pixel = [column, 60];
        // The picture is mirrored: the film moves to its right, and the axis to the right of the picture.
        let [from_axis, from_middle] =
            [140.0, 90.0].map(|foot| (f64::from(column) + 0.5 - foot) * pitch);
        let deviation = radial(from_axis) - 40.0 * from_middle / (43.27 / 2.0);
        let expected = (-(deviation / 10.0).powi(2)).exp2();
        let found = share(&shifted, pixel);
        assert!((found - expected).abs() < 0.05, "{pixel:?}: {found}, not {expected}");
    }
    let tilted = pose(Pose { tilt: [0.0, 5.0], ..Pose::ALIGNED });
    let tilted = PixelVignetting::new(microlenses, &tilted, &job.frame);
    assert_eq!(tilted, Err(MicrolensError::NotRound));
}

#[test]
fn microlenses_need_round_surfaces_behind_the_stop() {
    // Neither blades nor cylinders before the stop change the chief rays behind it.
    for lens in ["wide.22mm.pentagon.toml", "anamorphic.toml"] {
        let job = job_through(lens, "microlens=20").map_err(|error| error.to_string());
        assert!(job.expect(lens).sensor.expect("a sensor").vignetting.is_some());
    }
    let Job { mut camera, frame, .. } = job("");
    let LensModel::Real(lens) = &mut camera.model else { panic!() };
    lens.prescription.rows.last_mut().expect("surfaces").pose.decentre = [0.0, 0.5];
    let microlenses = Microlenses { half_angle: 20.0, corner_angle: 0.0 };
    let vignetting = PixelVignetting::new(microlenses, &camera, &frame);
    assert_eq!(vignetting, Err(MicrolensError::NotRound));
}

#[test]
fn raw_files_hold_sixteen_bits_of_two_sensitivities() {
    for (settings, bits) in [("bits=12,hdr=15,black=0,bayer", 16), ("bits=14,hdr=16,bayer", 18)] {
        let job = job(settings);
        let raw = job.raw_format().expect("a mosaic");
        assert_eq!(raw.bits, bits, "{settings}");
        let encoding = EncodingOptions { grey: true, raw: Some(raw), ..EncodingOptions::default() };
        let checked = encoding.check(std::path::Path::new("a.dng"));
        match bits {
            16 => assert!(checked.is_ok() && raw.saturation == 4095 * 15, "{raw:?}"),
            _ => {
                assert!(
                    matches!(checked, Err(ImageError::RawRange { bits: 18, .. })),
                    "{checked:?}"
                );
            }
        }
    }
}

#[test]
fn a_frame_of_another_size_sees_the_same_microlenses() {
    let job = job("microlens=15/3");
    let large = Frame::whole([1800, 1200]);
    let microlenses = Microlenses { half_angle: 15.0, corner_angle: 3.0 };
    let of = |frame: &Frame| PixelVignetting::new(microlenses, &job.camera, frame).expect("a lens");
    let text = |vignetting| Sensor { vignetting: Some(vignetting), ..sensor("") }.to_string();
    assert_eq!(text(of(&job.frame)), text(of(&large)));
    assert!(text(of(&large)).contains("microlens=15/3"));
}
