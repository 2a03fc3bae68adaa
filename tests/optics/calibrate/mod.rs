//! `petzval lens calibrate`: its camera models against rendered pictures, and its files.

use std::f64::consts::PI;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use crate::support::{folder, petzval, root, write};
use exr::prelude::{FlatSamples, read_all_flat_layers_from_file};
use petzval_lens::{FocusModel, Pose, Prescription};
use petzval_optics::{Calibration, CalibrationSetup, DistortionModel, FieldRay, Misfit, PixelGrid};
use serde_json::Value;

/// Width and height of the test pictures (pixels).
const SIZE: [u32; 2] = [240, 160];
/// Distance in focus (mm).
const FOCUS: f64 = 2000.0;

fn lens(name: &str) -> Prescription {
    petzval_lens_formats::read(&root().join("lenses").join(name)).expect("a lens of the repository")
}

fn setup<'a>(lens: &'a Prescription, ray: FieldRay, focus: f64) -> CalibrationSetup<'a> {
    let pixels = PixelGrid::new(SIZE, 36.0);
    let diagonal = 2.0 * pixels.half_diagonal();
    let film_distance = FocusModel::Sharpest.film(lens, focus, diagonal).expect("a focus");
    CalibrationSetup { lens, film_distance, film_pose: Pose::ALIGNED, pixels, ray }
}

fn calibrated(name: &str, ray: FieldRay) -> Calibration {
    setup(&lens(name), ray, FOCUS).calibrate().expect("a calibration")
}

/// Radius of a lamp (mm), before scaling.
const LAMP: f64 = 20.0;

/// Points of the scene in focus (mm, x to the right, y down, z from the film), away from each other
/// in the picture; scaled across the axis.
fn lamps(scale: f64) -> Vec<[f64; 3]> {
    [(0.0, 0.0), (450.0, 300.0), (-520.0, 210.0), (260.0, -330.0), (-230.0, -160.0), (610.0, -60.0)]
        .map(|(x, y)| [scale * x, scale * y, FOCUS])
        .to_vec()
}

/// Returns the centre of the area that a polygon covers.
fn centre_of_area(corners: &[[f64; 2]]) -> [f64; 2] {
    let (mut area, mut moment) = (0.0, [0.0; 2]);
    for (i, a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % corners.len()];
        let cross = a[0] * b[1] - a[1] * b[0];
        area += 3.0 * cross;
        (0..2).for_each(|k| moment[k] += cross * (a[k] + b[k]));
    }
    moment.map(|moment| moment / area)
}

/// Renders small disks of light across the axis and returns the centre of each (pixels), in a window
/// around where it is expected. Light that falls off across a disk is evened out.
fn photographed(
    lens: &str,
    calibration: &Calibration,
    scale: f64,
    expected: &[[f64; 2]],
) -> Vec<[f64; 2]> {
    let folder = folder();
    let disk = |[x, y, z]: [f64; 3]| {
        // pbrt's camera has y up and takes metres.
        format!(
            "AttributeBegin\n AreaLightSource \"diffuse\" \"rgb L\" [1 1 1] \"bool twosided\" true\n \
             Translate {} {} {}\n Shape \"disk\" \"float radius\" {}\nAttributeEnd\n",
            x * 1e-3,
            -y * 1e-3,
            z * 1e-3,
            scale * LAMP * 1e-3
        )
    };
    let scene = format!(
        "Film \"rgb\" \"integer xresolution\" {} \"integer yresolution\" {} \"float diagonal\" {}\n\
         Integrator \"path\" \"integer maxdepth\" 0\n\
         Camera \"realistic\" \"string lensfile\" \"{}\" \"float aperturediameter\" 100\n \
         \"float focusdistance\" {}\nWorldBegin\n{}",
        SIZE[0],
        SIZE[1],
        36f64.hypot(24.0),
        root().join("lenses").join(lens).display(),
        FOCUS * 1e-3,
        lamps(scale).into_iter().map(disk).collect::<String>()
    );
    write(&folder, "lamps.pbrt", scene);
    let (code, _, stderr) = petzval(
        folder.path(),
        &["render", "lamps.pbrt", "--effects", "none", "--spp", "512", "-o", "lamps.exr"],
    );
    assert_eq!(code, 0, "{stderr}");
    let image = read_all_flat_layers_from_file(folder.path().join("lamps.exr")).expect("a picture");
    let channels = &image.layer_data[0].channel_data.list;
    let green = channels.iter().find(|channel| channel.name.to_string() == "G").expect("green");
    let FlatSamples::F32(values) = &green.sample_data else { panic!("32-bit floats") };
    expected
        .iter()
        .map(|at| {
            let (mut sum, mut moment) = (0.0, [0.0; 2]);
            for (i, light) in values.iter().enumerate() {
                let pixel = [i % SIZE[0] as usize, i / SIZE[0] as usize].map(|n| n as f64);
                if (0..2).all(|k| (pixel[k] - at[k]).abs() < 11.0) {
                    let light = f64::from(*light) / calibration.relative_illumination(pixel);
                    sum += light;
                    (0..2).for_each(|k| moment[k] += light * pixel[k]);
                }
            }
            moment.map(|moment| moment / sum)
        })
        .collect()
}

/// Returns the largest distance between where a calibration expects the lamps and where they are.
fn worst(name: &str, ray: FieldRay, model: DistortionModel, scale: f64) -> f64 {
    let calibration = calibrated(name, ray);
    let fit = calibration.fitted(model).expect("a model that describes the lens");
    let shows = |[x, y, z]: [f64; 3]| {
        let rim = |i: usize| {
            let (sin, cos) = (PI * i as f64 / 32.0).sin_cos();
            let [x, y] = [x + scale * LAMP * cos, y + scale * LAMP * sin];
            let seen = glam::DVec3::new(x, y, z) - calibration.centre.point;
            fit.project(seen.normalize()).expect("a pixel")
        };
        centre_of_area(&(0..64).map(rim).collect::<Vec<_>>())
    };
    let expected: Vec<[f64; 2]> = lamps(scale).into_iter().map(shows).collect();
    let found = photographed(name, &calibration, scale, &expected);
    let off = found.iter().zip(&expected).map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]));
    off.fold(0.0, f64::max)
}

#[test]
fn lamps_are_photographed_where_the_centroid_model_shows_them() {
    let off = worst("dgauss.50mm.dat", FieldRay::Centroid, DistortionModel::BrownConrady, 1.0);
    assert!(off < 0.02, "{off}");
    let off = worst("fisheye.10mm.dat", FieldRay::Centroid, DistortionModel::KannalaBrandt, 3.0);
    assert!(off < 0.02, "{off}");
}

#[test]
fn chief_rays_miss_the_lamps_of_a_wide_open_lens_by_its_coma() {
    let off = worst("dgauss.50mm.dat", FieldRay::Chief, DistortionModel::BrownConrady, 1.0);
    assert!(off > 0.04, "{off}");
}

#[test]
fn a_fisheye_is_no_brown_conrady() {
    let calibration = calibrated("fisheye.10mm.dat", FieldRay::Centroid);
    let (_, fit) = &calibration.models[1];
    assert!(matches!(fit, Err(Misfit::Folds | Misfit::Coarse { .. } | Misfit::Wide { .. })));
    let suggested = calibration.suggested().expect("a model");
    assert_eq!(suggested.model, DistortionModel::KannalaBrandt);
    assert!(suggested.residual.max < 0.05, "{:?}", suggested.residual);
}

#[test]
fn the_quick_calibration_suggests_the_same_model() {
    for name in ["dgauss.50mm.dat", "fisheye.10mm.dat", "wide.22mm.dat"] {
        let lens = lens(name);
        let setup = setup(&lens, FieldRay::Centroid, FOCUS);
        let (whole, quick) = (setup.calibrate().unwrap(), setup.calibrate_quickly().unwrap());
        assert_eq!(whole.suggested(), quick.suggested(), "{name}");
    }
}

#[test]
fn stopped_down_the_focal_length_is_that_of_the_lens_and_the_centre_its_entrance_pupil() {
    let mut lens = lens("dgauss.50mm.dat");
    lens.stop_down(1.0);
    let calibration = setup(&lens, FieldRay::Chief, f64::INFINITY).calibrate().unwrap();
    assert!(calibration.focus.is_infinite());
    let paraxial = petzval_lens::Paraxial::new(&lens);
    let fit = calibration.fitted(DistortionModel::Rational).expect("a model");
    let focal = fit.matrix.focal[0] * calibration.pixels.pitch;
    assert!((focal / paraxial.focal_length - 1.0).abs() < 2e-4, "{focal} {paraxial:?}");
    let depth = calibration.front_depth - calibration.centre.wander[0];
    let deepest = calibration.front_depth - calibration.centre.wander[1];
    let pupil = paraxial.entrance_pupil.position;
    assert!((deepest - 0.2..depth + 0.2).contains(&pupil), "{pupil} not in {deepest}..{depth}");
}

#[test]
fn a_shifted_film_moves_the_principal_point_the_other_way() {
    let lens = lens("dgauss.50mm.dat");
    let centred = setup(&lens, FieldRay::Centroid, FOCUS);
    // To the right and up in the picture: more of the scene there, so the axis is left and below.
    let pose = Pose::of_film([3.0, 1.5], [0.0; 2]);
    let shifted = CalibrationSetup { film_pose: pose, ..centred }.calibrate().unwrap();
    let fit = shifted.fitted(DistortionModel::Rational).expect("a model");
    let [x, y] = fit.matrix.centre;
    let [cx, cy] = shifted.pixels.centre();
    let pitch = shifted.pixels.pitch;
    assert!((cx - x - 3.0 / pitch).abs() < 1e-9 && (y - cy - 1.5 / pitch).abs() < 1e-9, "{x} {y}");
    assert!(fit.residual.max < 0.1, "{:?}", fit.residual);
}

#[test]
fn a_tilted_element_shows_as_tangential_distortion_and_a_moved_centre() {
    let mut lens = lens("dgauss.50mm.dat");
    lens.rows[0].pose = Pose { decentre: [0.2, 0.0], tilt: [0.0; 2] };
    lens.stop_down(6.0);
    let calibration = setup(&lens, FieldRay::Centroid, FOCUS).calibrate().unwrap();
    assert!(!calibration.round);
    let fit = calibration.fitted(DistortionModel::BrownConrady).expect("a model");
    let [x, y] = fit.matrix.centre;
    let [cx, cy] = calibration.pixels.centre();
    assert!((x - cx).abs() > 0.1 && (y - cy).abs() < 0.02, "{x} {y}");
    assert!(fit.residual.max < 0.1, "{:?}", fit.residual);
}

#[test]
fn maps_are_each_other_s_inverse() {
    for name in ["dgauss.50mm.dat", "wide.22mm.dat"] {
        let calibration = calibrated(name, FieldRay::Centroid);
        let matrix = calibration.pinhole_matrix().expect("a model");
        for pixel in [[119.5, 79.5], [10.0, 20.0], [200.0, 5.0], [30.0, 150.0]] {
            let flat = calibration.undistorted(&matrix, pixel).expect("light");
            let back = calibration.distorted(&matrix, flat, flat).expect("an inverse");
            let off = (back[0] - pixel[0]).hypot(back[1] - pixel[1]);
            assert!(off < 1e-3, "{name} {pixel:?}: {back:?}");
        }
    }
}

#[test]
fn relative_illumination_is_that_of_the_vignetting_analysis() {
    let lens = lens("dgauss.50mm.dat");
    let setup = setup(&lens, FieldRay::Centroid, FOCUS);
    let calibration = setup.calibrate().unwrap();
    let vignetting = petzval_lens::Vignetting::new(&lens, setup.film_distance, 1 << 16);
    let light =
        |r: f64| vignetting.budget([r, 0.0], petzval_lens::Normalization::Stop).unwrap().irradiance;
    for r in [5.0, 10.0, 15.0, 17.5] {
        let found = calibration.relative_illumination(setup.pixels.pixel([-r, 0.0]));
        assert!((found - light(r) / light(0.0)).abs() < 5e-3, "{r} mm: {found}");
    }
}

/// Runs the command for a small picture and returns the folder with its files and what it prints.
fn files(arguments: &[&str]) -> (tempfile::TempDir, String) {
    let folder = folder();
    let mut words = vec!["lens", "calibrate"];
    let path = root().join("lenses").join(arguments[0]);
    let path = path.to_string_lossy();
    words.extend([&*path, "-o", "cal", "--film-size", "36x24"]);
    words.extend(&arguments[1..]);
    let (code, stdout, stderr) = petzval(folder.path(), &words);
    assert_eq!(code, 0, "{stderr}");
    (folder, stdout)
}

fn text(folder: &Path, name: &str) -> String {
    fs::read_to_string(folder.join("cal").join(name)).unwrap_or_else(|_| panic!("{name}"))
}

fn numbers(text: &str) -> Vec<f64> {
    let words = text.split(|c: char| c == ',' || c.is_whitespace() || c == '[' || c == ']');
    words.filter_map(|word| word.parse().ok()).collect()
}

#[test]
fn the_files_agree_with_each_other_in_their_conventions() {
    let arguments = ["dgauss.50mm.dat", "--resolution", "240x160", "--focus", "2m", "--fstop", "4"];
    let (folder, stdout) = files(&arguments);
    let at = folder.path();
    assert!(stdout.contains("suggested model: brown-conrady"), "{stdout}");
    let json: Value = serde_json::from_str(&text(at, "calibration.json")).expect("JSON");
    assert!((json["focus"].as_f64().unwrap() - 2000.0).abs() < 1e-3, "{}", json["focus"]);
    assert!((json["f_number"].as_f64().unwrap() - 4.0).abs() < 1e-6, "{}", json["f_number"]);
    let value = |model: &str, name: &str| json["models"][model]["coefficients"][name].as_f64();
    let fx = |model: &str| json["models"][model]["camera_matrix"][0][0].as_f64().unwrap();

    let yaml = text(at, "opencv_brown_conrady.yaml");
    assert!(yaml.starts_with("%YAML:1.0\n---\n"), "{yaml}");
    let data: Vec<Vec<f64>> =
        yaml.lines().filter(|line| line.contains("data:")).map(numbers).collect();
    assert_eq!(data[0][0], fx("brown-conrady"));
    assert_eq!((data[0][2], data[0][5]), (119.5, 79.5));
    let expected = ["k1", "k2", "p1", "p2", "k3"].map(|name| value("brown-conrady", name).unwrap());
    assert_eq!(data[1], expected);

    let cameras = text(at, "cameras.txt");
    let opencv = cameras.lines().find(|line| line.contains(" OPENCV ")).expect("a line");
    let found = numbers(opencv);
    assert_eq!(found[..3], [1.0, 240.0, 160.0]);
    assert_eq!((found[3], found[5], found[6]), (fx("radtan"), 120.0, 80.0));
    assert_eq!(found[7], value("radtan", "k1").unwrap());
    assert!(cameras.contains(" FULL_OPENCV ") && cameras.contains(" OPENCV_FISHEYE "), "{cameras}");

    let kalibr = text(at, "kalibr_radtan.yaml");
    let line = kalibr.lines().find(|line| line.contains("intrinsics")).expect("intrinsics");
    assert_eq!(numbers(line), [fx("radtan"), fx("radtan"), 119.5, 79.5]);

    let lens: Value = serde_json::from_str(&text(at, "openlensio.json")).expect("JSON");
    let focal = lens["lens"]["pinholeFocalLength"].as_f64().unwrap();
    assert!((focal - fx("brown-conrady") * 0.15).abs() < 1e-9, "{focal}");
    let k1 = lens["lens"]["distortion"][0]["radial"][0].as_f64().unwrap();
    assert!((k1 * focal * focal - expected[0]).abs() < 1e-12, "{k1}");

    let xml = text(at, "lensfun.xml");
    let options = roxmltree::ParsingOptions { allow_dtd: true, ..Default::default() };
    let xml = roxmltree::Document::parse_with_options(&xml, options).expect("XML");
    let distortion = xml.descendants().find(|node| node.has_tag_name("distortion")).unwrap();
    let number = |name: &str| distortion.attribute(name).map_or(0.0, |v| v.parse().unwrap());
    // Readers derive the focal length near the axis from the sum of the terms.
    assert_eq!(distortion.attribute("model"), Some("ptlens"));
    let real: f64 = number("focal") * (1.0 - number("a") - number("b") - number("c"));
    assert!((real / focal - 1.0).abs() < 2e-3, "{real} {focal}");
}

#[test]
fn the_polynomial_of_lensfun_is_the_distortion_of_the_rays() {
    let calibration = calibrated("wide.22mm.dat", FieldRay::Centroid);
    let half = 12.0;
    for distortion in calibration.radial_distortions() {
        let term = |name: &str| {
            distortion.terms.iter().find(|(found, _)| *found == name).map_or(0.0, |(_, v)| *v)
        };
        let k = [term("a"), term("b"), term("c"), term("k1"), term("k2")];
        for r in [4.0, 9.0, 14.0] {
            let pixel = calibration.pixels.pixel([-r, 0.0]);
            let ray = calibration.scene_ray(pixel).unwrap();
            let seen = ray.seen_from(calibration.centre.point, calibration.focus);
            // The focal length of the undistorted radius, by lensfun's rule for real-focal.
            let scale = match distortion.model {
                "ptlens" => 1.0 - k[0] - k[1] - k[2],
                "poly3" => 1.0 - k[3],
                _ => 1.0,
            };
            let u = distortion.real_focal / scale * seen.x / seen.z / half;
            let found = match distortion.model {
                "ptlens" => {
                    k[0] * u.powi(4)
                        + k[1] * u.powi(3)
                        + k[2] * u * u
                        + (1.0 - k[0] - k[1] - k[2]) * u
                }
                "poly3" => k[3] * u.powi(3) + (1.0 - k[3]) * u,
                _ => u * (1.0 + k[3] * u * u + k[4] * u.powi(4)),
            };
            let off = (found * half - r).abs() / calibration.pixels.pitch;
            assert!(off <= distortion.error + 1e-6, "{distortion:?}, {r} mm: {off} pixels");
        }
    }
    let distortions = calibration.radial_distortions();
    let best = distortions.iter().map(|distortion| distortion.error).fold(f64::INFINITY, f64::min);
    assert!(distortions.len() == 3 && best < 0.1, "{distortions:?}");
}

#[test]
fn point_spreads_add_up_and_lie_where_the_model_shows_the_point() {
    let lens = lens("dgauss.50mm.dat");
    let setup = setup(&lens, FieldRay::Centroid, FOCUS);
    let calibration = setup.calibrate().unwrap();
    let spots = setup.spots(&calibration, [3, 3], vec![FOCUS, f64::INFINITY], 33).unwrap();
    let size = spots.side * spots.side * 3;
    for (i, spread) in spots.shares.chunks(size).enumerate() {
        let half = (spots.side / 2) as f64;
        let (mut sum, mut moment) = (0.0, [0.0; 2]);
        for (k, share) in spread.chunks(3).enumerate() {
            let at = [k % spots.side, k / spots.side].map(|n| n as f64 - half);
            sum += f64::from(share[1]);
            (0..2).for_each(|axis| moment[axis] += f64::from(share[1]) * at[axis]);
        }
        assert!((sum - 1.0).abs() < 1e-4, "spread {i}: {sum}");
        // In focus, the centroid of all light is on the pixel; pixels round it.
        let off = moment[0].hypot(moment[1]);
        assert!(i >= 9 || off < 0.3, "spread {i}: {moment:?}");
        // Out of focus, the blur of the middle is round.
        assert!(i != 13 || off < 0.1, "spread {i}: {moment:?}");
    }
    // The blur of distant points has the diameter of the aperture times the defocus.
    let width = |spread: &[f32]| spread.chunks(3).filter(|share| share[1] > 0.0).count() as f64;
    let middle = |distance: usize| &spots.shares[(9 * distance + 4) * size..][..size];
    let blur = (width(middle(1)) / PI).sqrt() * 2.0;
    let expected = 25.0 * 50.0 / (FOCUS - 50.0) / setup.pixels.pitch;
    assert!((blur - expected).abs() < 1.0, "{blur} pixels, expected {expected}");
    assert!(width(middle(0)) < 16.0, "a point in focus is small");
}

#[test]
fn a_fisheye_leaves_no_file_of_an_earlier_lens() {
    let arguments = ["fisheye.10mm.dat", "--resolution", "60x40", "--focus", "inf"];
    let (folder, stdout) = files(&arguments);
    assert!(stdout.contains("brown-conrady  does not describe this lens"), "{stdout}");
    assert!(!folder.path().join("cal/opencv_brown_conrady.yaml").exists());
    let stale = folder.path().join("cal/opencv_thin_prism.yaml");
    fs::write(&stale, "of an earlier run").unwrap();
    let lens = root().join("lenses/fisheye.10mm.dat");
    let again =
        ["lens", "calibrate", &*lens.to_string_lossy(), "-o", "cal", "--film-size", "36x24"];
    let again = [&again[..], &arguments[1..]].concat();
    let (code, _, stderr) = petzval(folder.path(), &again);
    assert_eq!(code, 0, "{stderr}");
    assert!(!stale.exists());
    let array = fs::read(folder.path().join("cal/psf.npy")).unwrap();
    assert!(array.starts_with(b"\x93NUMPY\x01\x00"));
}

#[test]
fn wrong_arguments_are_refused_with_what_is_expected() {
    let folder = folder();
    let path = root().join("lenses/dgauss.50mm.dat");
    let path = path.to_string_lossy();
    let refused = |changed: &[&str], expected: &str| {
        let usual = [("--film-size", "36x24"), ("--resolution", "240x160"), ("--focus", "2m")];
        let mut words = vec!["lens", "calibrate", &*path, "-o", "cal"];
        for (option, value) in usual {
            if changed[0] != option {
                words.extend([option, value]);
            }
        }
        words.extend(changed);
        let (code, _, stderr) = petzval(folder.path(), &words);
        assert_eq!(code, 2, "{changed:?}: {stderr}");
        assert!(stderr.contains(expected), "{changed:?}\n{stderr}");
        assert!(!stderr.contains("panicked"), "{stderr}");
    };
    refused(&["--focus", "2000"], "a number alone is in metres; write 2000mm, or 2000m");
    refused(&["--focus", "-1m"], "expected a distance above 0 such as 2m or 850mm");
    refused(&["--focus", "60mm"], "the lens cannot focus at 60.0000 mm");
    refused(&["--film-size", "36"], "expected WxH in mm, such as 36x24");
    refused(&["--fstop", "1.2"], "opens to f/2.0");
    refused(&["--resolution", "60000x60000"], "expected at most 67108864");
}

#[test]
fn a_render_states_the_camera_model_that_calibrate_exports() {
    let arguments = ["dgauss.50mm.dat", "--resolution", "240x160", "--focus", "2m", "--fstop", "4"];
    let (folder, _) = files(&arguments);
    let scene = format!(
        "Film \"rgb\" \"integer xresolution\" 240 \"integer yresolution\" 160 \"float diagonal\" {}\n\
         Camera \"realistic\" \"string lensfile\" \"{}\" \"float aperturediameter\" 100\n \
         \"float focusdistance\" 2\nWorldBegin\nLightSource \"infinite\"\n",
        36f64.hypot(24.0),
        root().join("lenses/dgauss.50mm.dat").display()
    );
    write(&folder, "sky.pbrt", scene);
    let render = ["render", "sky.pbrt", "--spp", "1", "--fstop", "4", "-o", "sky.exr"];
    let (code, _, stderr) = petzval(folder.path(), &render);
    assert_eq!(code, 0, "{stderr}");
    let image = read_all_flat_layers_from_file(folder.path().join("sky.exr")).expect("a picture");
    let attribute = |name: &str| {
        let own = &image.layer_data[0].attributes.other;
        let mut all = image.attributes.other.iter().chain(own);
        let found = all.find(|(found, _)| *found == name);
        format!("{:?}", found.unwrap_or_else(|| panic!("no attribute {name}")).1)
    };
    assert!(attribute("cameraModel").contains("brown-conrady"));
    let digits = |text: String| numbers(&text.replace(['"', '(', ')'], " "));
    let yaml = text(folder.path(), "opencv_brown_conrady.yaml");
    let data: Vec<Vec<f64>> =
        yaml.lines().filter(|line| line.contains("data:")).map(numbers).collect();
    let same = |found: &[f64], expected: &[f64]| {
        assert_eq!(found.len(), expected.len(), "{found:?} {expected:?}");
        for (a, b) in found.iter().zip(expected) {
            assert!((a - b).abs() <= 1e-6 * b.abs(), "{found:?}, expected {expected:?}");
        }
    };
    same(&digits(attribute("cameraMatrix")), &data[0]);
    same(&digits(attribute("distortionCoefficients")), &data[1]);
    same(&digits(attribute("projectionCentre")), &data[2]);
}

#[test]
#[ignore = "needs Python with opencv-python-headless, numpy and OpenEXR; .ci/run installs them"]
fn opencv_finds_the_exported_camera_in_photographs_of_a_checkerboard() {
    let python = std::env::var("PETZVAL_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let folder = folder();
    let output = Command::new(python)
        .arg(root().join("tests/optics/calibrate/checkerboard.py"))
        .arg(env!("CARGO_BIN_EXE_petzval"))
        .arg(root().join("lenses/dgauss.50mm.dat"))
        .arg(folder.path())
        .stdin(Stdio::null())
        .output()
        .expect("Python");
    println!("{}", String::from_utf8_lossy(&output.stdout));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}
