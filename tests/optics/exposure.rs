//! Focus and f-number from the command line, and the resulting brightness.

use std::f64::consts::PI;

use crate::support::{LENSES, folder, lens, mean, picture, root, write, write_picture};
use petzval_image::Picture;
use petzval_lens::{
    FocusError, FocusModel, LensModel, LensRay, Paraxial, Prescription, RealRayFocus, Side,
};
use petzval_lens::{sequence, trace_one};
use petzval_render::Backend;
use petzval_render::job::Job;
use petzval_render::prepare::{Changes, FocusOn, prepare};
use petzval_scene_formats::pbrt;

/// Returns a render of the centre of the film under a uniform sky of radiance 1.
fn centre(lens: &str, changes: &Changes) -> Job {
    let folder = folder();
    let text = format!(
        r#"Film "rgb" "integer xresolution" 40 "integer yresolution" 40 "float diagonal" 4
           Sampler "sobol" "integer pixelsamples" 256
           Camera "realistic" "string lensfile" "{}/lenses/{lens}.dat"
               "float aperturediameter" 100 "float focusdistance" 5
           WorldBegin LightSource "infinite" "rgb L" [1 1 1]"#,
        root().display()
    );
    let description = pbrt::read(&write(&folder, "sky.pbrt", text)).expect("a scene");
    let crop = Some([[18, 18], [22, 22]]);
    prepare(description, &Changes { crop, ..changes.clone() }).expect("a job").job
}

#[test]
fn brightness_follows_the_f_number() {
    for (name, _) in LENSES {
        for f_number in [5.6, 8.0, 11.0, 16.0, 22.0] {
            let focus = Some(FocusOn::Distance(f64::INFINITY));
            let job =
                centre(name, &Changes { focus, f_number: Some(f_number), ..Changes::default() });
            let found = mean(&picture(&job, Backend::Simd, 1))[0];
            let expected = PI / (4.0 * f_number * f_number);
            println!("{name} f/{f_number}: {:.4}", found / expected);
            assert!(
                (found / expected - 1.0).abs() < 0.01,
                "{name} f/{f_number}: {found} {expected}"
            );
        }
    }
}

/// Returns the root mean square radius of the spot, mm, on a film behind the rear vertex, of a point on
/// the axis in front of the lens. The rays fill the entrance pupil evenly.
fn spot(lens: &Prescription, object: f64, film: f64) -> f64 {
    let surfaces = sequence::<f64>(lens, Side::Scene(object));
    // Slightly more than the radius of the entrance pupil.
    let reach = 0.6 * Paraxial::new(lens).entrance_pupil.diameter;
    let (mut sum, mut count) = (0.0, 0.0);
    for i in 0..200 {
        for j in 0..200 {
            let place = |k: i32| reach * (f64::from(k) + 0.5 - 100.0) / 100.0;
            let t = [place(i), place(j), object];
            let length = t.iter().map(|v| v * v).sum::<f64>().sqrt();
            let ray = LensRay::new([0.0; 3], t.map(|v| v / length));
            let Ok(ray) = trace_one::<f64>(ray, &surfaces) else { continue };
            let at = |axis: usize| ray.p[axis] + (film - ray.p[2]) / ray.t[2] * ray.t[axis];
            sum += at(0).powi(2) + at(1).powi(2);
            count += 1.0;
        }
    }
    (sum / count).sqrt()
}

#[test]
fn the_film_is_where_the_requested_distance_is_sharpest() {
    for (name, _) in LENSES {
        for metres in [2.0, 5.0, 100.0] {
            let focus = Some(FocusOn::Distance(metres));
            let job = centre(name, &Changes { focus, ..Changes::default() });
            let LensModel::Real(lens) = &job.camera.model else { panic!("{name} is a real lens") };
            let (film, lens) = (lens.film_distance, &lens.prescription);
            let object = metres * 1e3 - lens.length() - film;
            let best = spot(lens, object, film);
            // A step whose effect is far larger than the error of sampling the spot.
            for step in [-0.01, 0.01] {
                let other = spot(lens, object, film + step);
                assert!(best < other, "{name} at {metres} m: {best} mm, {other} at {step} mm");
            }
            let back =
                RealRayFocus::new(lens).object_distance(film).expect("something is in focus");
            assert!((back / object - 1.0).abs() < 1e-6, "{name}: {back} and {object} mm");
        }
    }
}

#[test]
fn a_small_stop_focuses_as_first_order_optics_says() {
    for (name, _) in LENSES {
        let mut lens = lens(name);
        lens.stop_down(lens.rows[lens.stop()].diameter / 200.0);
        for focus in [f64::INFINITY, 5e3, 2e3] {
            let film = RealRayFocus::new(&lens)
                .film_distance(focus)
                .expect("a distance that can be focused");
            let paraxial = Paraxial::new(&lens).film_for_focus(focus).expect("the same");
            assert!((film / paraxial - 1.0).abs() < 2e-6, "{name}: {film} and {paraxial} mm");
        }
    }
}

#[test]
fn distances_below_the_nearest_are_refused_and_the_nearest_is_not() {
    for (name, _) in LENSES {
        let lens = lens(name);
        let focus = RealRayFocus::new(&lens);
        for asked in [0.0, 1.0, lens.length()] {
            let Err(FocusError::TooNear { nearest, .. }) = focus.film_distance(asked) else {
                panic!("{name} cannot focus at {asked} mm");
            };
            assert!(focus.film_distance(nearest * 1.0001).is_ok(), "{name}: {nearest}");
            assert!(focus.film_distance(nearest * 0.9999).is_err(), "{name}: {nearest}");
        }
    }
}

/// Returns the film distance, mm, for a wall at 3 m that fills the view except for sky on the left.
fn wall(changes: &Changes) -> Result<f64, String> {
    let folder = folder();
    let text = format!(
        r#"Film "rgb" "integer xresolution" 60 "integer yresolution" 40 "float diagonal" 43.3
           Camera "realistic" "string lensfile" "{}/lenses/dgauss.50mm.dat"
               "float aperturediameter" 5 "float focusdistance" 1
           WorldBegin LightSource "infinite" "rgb L" [1 1 1]
           Shape "trianglemesh" "integer indices" [0 1 2 0 2 3]
               "point3 P" [-0.5 -5 3  5 -5 3  5 5 3  -0.5 5 3]"#,
        root().display()
    );
    let description = pbrt::read(&write(&folder, "wall.pbrt", text)).expect("a scene");
    let job = prepare(description, changes).map_err(|error| error.to_string())?.job;
    let LensModel::Real(lens) = &job.camera.model else { panic!("a real lens") };
    Ok(lens.film_distance)
}

#[test]
fn auto_focus_uses_the_depth_of_a_pixel() {
    let film = |focus: FocusOn| wall(&Changes { focus: Some(focus), ..Changes::default() });
    let at = |metres: f64| film(FocusOn::Distance(metres)).expect("a distance");
    // At all pixels of the wall the depth counts, not the distance along the ray.
    for pixel in [None, Some([55, 5]), Some([55, 35])] {
        let found = film(FocusOn::Pixel(pixel)).expect("something is there");
        assert!((found - at(3.0)).abs() < 1e-4, "{pixel:?}: {found} mm, not {}", at(3.0));
    }
    let sky = film(FocusOn::Pixel(Some([2, 20]))).expect("the sky is there");
    assert!((sky - at(f64::INFINITY)).abs() < 1e-9, "{sky} mm");
    let beyond = film(FocusOn::Pixel(Some([60, 0]))).unwrap_err();
    assert!(beyond.contains("60 x 40 pixels"), "{beyond}");
}

/// Returns the mean of the centre of a picture under a uniform sky, with a small stop of this shape.
fn brightness_with(folder: &tempfile::TempDir, aperture: &str) -> f64 {
    let text = format!(
        r#"Film "rgb" "integer xresolution" 8 "integer yresolution" 8 "float diagonal" 2
           Sampler "sobol" "integer pixelsamples" 512
           Camera "realistic" "string lensfile" "{}/lenses/dgauss.50mm.dat"
               "float aperturediameter" 3 "float focusdistance" 5 "string aperture" "{aperture}"
           WorldBegin LightSource "infinite" "rgb L" [1 1 1]"#,
        root().display()
    );
    let description = pbrt::read(&write(folder, "sky.pbrt", text)).expect("a scene");
    let job = prepare(description, &Changes::default()).expect("a job").job;
    mean(&picture(&job, Backend::Simd, 1))[1]
}

/// Writes a picture of 16 x 16 pixels of these values.
fn write_mask(folder: &tempfile::TempDir, name: &str, value: impl Fn(usize, usize) -> f32) {
    let pixels = (0..256).map(|i| [value(i % 16, i / 16); 3]).collect();
    write_picture(&Picture { size: [16, 16], pixels }, folder.path().join(name));
}

#[test]
fn every_pbrt_aperture_gives_the_brightness_of_the_round_stop() {
    let folder = folder();
    write_mask(&folder, "white.exr", |_, _| 1.0);
    write_mask(&folder, "ring.exr", |x, y| if x.abs_diff(y) > 5 { 7.0 } else { 0.25 });
    let round = brightness_with(&folder, "circular");
    for aperture in ["gaussian", "square", "pentagon", "star", "white.exr", "ring.exr"] {
        let found = brightness_with(&folder, aperture) / round;
        println!("{aperture}: {found:.4}");
        // The shapes differ by the cosine towards the rim of the pupil: a fiftieth of a percent.
        assert!((found - 1.0).abs() < 0.003, "{aperture}: {found} of the light of the round stop");
    }
}

/// Lens, distance in focus (m) and film distance (mm) of pbrt-v4 (`RealisticCamera::FocusThickLens`) for a
/// film of 70 mm diagonal. pbrt traces two rays in f32 from 1 m away, which leaves four digits.
const PBRT_FILMS: &[(&str, f64, f64)] = &[
    ("dgauss.50mm", 4.0097476, 36.7535353),
    ("dgauss.50mm", 1.5, 37.9131436),
    ("wide.22mm", 1.4798036, 14.6584511),
    ("wide.22mm", 20.0, 14.3413544),
    ("fisheye.10mm", 0.6625528, 23.3209729),
    ("fisheye.10mm", 20.0, 23.1637955),
    ("telephoto.250mm", 3.7208515, 124.774218),
    ("telephoto.250mm", 20.0, 108.269691),
];

#[test]
fn the_focus_model_of_pbrt_gives_the_film_distances_of_pbrt() {
    let mut furthest: f64 = 0.0;
    for &(name, metres, expected) in PBRT_FILMS {
        let film = |focus_model: FocusModel| {
            let focus = Some(FocusOn::Distance(metres));
            let job = centre(name, &Changes { focus, focus_model, ..Changes::default() });
            let LensModel::Real(lens) = &job.camera.model else { panic!("{name} is a real lens") };
            lens.film_distance
        };
        let [pbrt, sharpest] = [FocusModel::Pbrt, FocusModel::Sharpest].map(film);
        println!("{name} at {metres} m: {pbrt:.6}, pbrt-v4 {expected}, sharpest {sharpest:.4} mm");
        assert!((pbrt / expected - 1.0).abs() < 1e-4, "{name} at {metres} m: {pbrt}");
        furthest = furthest.max((pbrt - sharpest).abs());
    }
    // The effect of the spherical aberration of the wide-open telephoto.
    assert!((furthest - 1.03).abs() < 0.01, "{furthest} mm");
}

#[test]
fn the_focus_model_applies_to_distances_of_scenes_and_to_auto_focus() {
    let film = |focus: Option<FocusOn>, focus_model: FocusModel| {
        wall(&Changes { focus, focus_model, ..Changes::default() }).expect("a film")
    };
    let at = |metres: f64| film(Some(FocusOn::Distance(metres)), FocusModel::Pbrt);
    assert_eq!(film(None, FocusModel::Pbrt), at(1.0));
    assert!((film(None, FocusModel::Sharpest) - at(1.0)).abs() > 1e-3);
    let seen = film(Some(FocusOn::Pixel(None)), FocusModel::Pbrt);
    assert!((seen - at(3.0)).abs() < 1e-4, "{seen} mm, not {}", at(3.0));
}

#[test]
fn the_focus_model_is_an_option_checked_on_resume_and_written_into_the_picture() {
    let folder = folder();
    let text = format!(
        r#"Film "rgb" "integer xresolution" 8 "integer yresolution" 8
           Camera "realistic" "string lensfile" "{}/lenses/dgauss.50mm.dat"
           WorldBegin LightSource "infinite" "rgb L" [1 1 1]"#,
        root().display()
    );
    write(&folder, "sky.pbrt", text);
    let run = |line: &str| {
        let arguments: Vec<&str> = line.split(' ').collect();
        crate::support::petzval(folder.path(), &arguments)
    };
    let model = ["--focus-model", "pbrt"].join(" ");
    let part =
        |n: u32, more: &str| run(&format!("render sky.pbrt --shard {n}/2 -o {n}.petzval{more}"));
    assert_eq!(part(1, "").0, 0);
    assert_eq!(part(2, &format!(" {model}")).0, 0);
    let (code, _, stderr) = run("merge 1.petzval 2.petzval -o all.exr");
    assert!(
        code == 2 && stderr.contains("--focus-model was sharpest, and is pbrt"),
        "{code}: {stderr}"
    );
    assert_eq!(run(&format!("render sky.pbrt -o sky.exr {model}")).0, 0);
    let picture = std::fs::read(folder.path().join("sky.exr")).expect("a picture");
    assert!(picture.windows(10).any(|name| name == b"focusModel"));
    for command in ["plan sky.pbrt", "replay sky.pbrt --pixel 4,4 --sample 0"] {
        let (code, stdout, stderr) = run(&format!("{command} {model}"));
        assert_eq!(code, 0, "{command}: {stdout}{stderr}");
    }
    let (code, _, stderr) = run("plan sky.pbrt --focus-model thick");
    assert!(code == 2 && stderr.contains("expected sharpest or pbrt"), "{code}: {stderr}");
    let lens = root().join("lenses/wide.22mm.dat").display().to_string();
    let (code, stdout, _) = run(&format!("lens {lens} --focus 1479.8036mm {model}"));
    assert!(
        code == 0 && stdout.contains("film distance, pbrt-v4           14.6586 mm"),
        "{stdout}"
    );
    assert!(stdout.contains("0.1186 mm  (farther from the lens)"), "{stdout}");
}
