//! Pictures of lamps, and the comparison of their light.

use std::fmt::Debug;
use std::fs::read_to_string;

use petzval_image::{Picture, write_pfm};
use petzval_render::Backend;
use petzval_render::job::Job;
use petzval_render::prepare::{Changes, prepare};
use petzval_scene_formats::pbrt;
use petzval_spectrum::Passband;

use crate::support::reference::{changed_fields, full, means_agree, reference};
use crate::support::{folder, mean_and_error, picture, root, write};

/// A lamp in the shape of a ball, and dim surroundings.
pub const BALL: &str = r#"
    LightSource "infinite" "rgb L" [0.01 0.01 0.02]
    AttributeBegin
        AreaLightSource "diffuse" "rgb L" [500 400 200]
        Translate 0.3 0.2 6 Shape "sphere" "float radius" 0.04
    AttributeEnd"#;

/// A larger one, nearer to the camera.
const LARGE: &str = r#"
    AttributeBegin
        AreaLightSource "diffuse" "rgb L" [50 40 20]
        Translate 0.3 0.2 3 Shape "sphere" "float radius" 0.1
    AttributeEnd"#;

/// A disk that faces the camera, before a wall.
const DISK: &str = r#"
    AttributeBegin
        AreaLightSource "diffuse" "rgb L" [300 300 900]
        Translate -0.4 -0.3 5 Rotate 180 0 1 0 Shape "disk" "float radius" 0.05
    AttributeEnd
    Material "diffuse" "rgb reflectance" [0.5 0.5 0.5]
    Shape "trianglemesh" "point3 P" [-5 -5 7  5 -5 7  5 5 7  -5 5 7] "integer indices" [0 2 1 0 3 2]"#;

/// Lamps far off the axis.
const ASIDE: &str = r#"
    AttributeBegin
        AreaLightSource "diffuse" "rgb L" [50 40 20]
        Translate 1.5 0.2 2 Shape "sphere" "float radius" 0.05
    AttributeEnd
    AttributeBegin
        AreaLightSource "diffuse" "rgb L" [50 40 20]
        Translate -2 0.2 0.7 Shape "sphere" "float radius" 0.05
    AttributeEnd"#;

/// A rectangle and a triangle of two sizes, the first half hidden by a post near the camera.
const HIDDEN: &str = r#"
    AttributeBegin
        AreaLightSource "diffuse" "rgb L" [200 300 100] "bool twosided" true
        Shape "trianglemesh" "point3 P" [-0.1 0 4  0.1 0 4.1  0.1 0.05 4.1  -0.1 0.05 4
                                         -0.6 -0.4 4  -0.5 -0.4 4  -0.5 -0.3 4]
            "integer indices" [0 1 2 0 2 3 4 5 6]
    AttributeEnd
    Material "diffuse" "rgb reflectance" [0 0 0]
    Shape "trianglemesh" "point3 P" [0 -1 1.5  0.5 -1 1.5  0.5 1 1.5  0 1 1.5]
        "integer indices" [0 1 2 0 2 3]"#;

/// A lens of one flint, about 100 mm of focal length, with colours far apart on the film.
const SINGLET: &str = "[[surface]]\nstop = true\ndiameter = 5.0\nthickness = 30.0
[[surface]]\nradius = 120.0\nthickness = 2.0\ndiameter = 20.0\nglass = \"SF5\"
[[surface]]\nradius = -120.0\nthickness = 90.0\ndiameter = 20.0\n";

/// A lens whose film stands in its last glass.
const FILM_IN_GLASS: &str = "[[surface]]\nstop = true\ndiameter = 12.0\nthickness = 5.0
[[surface]]\nradius = 60.0\nthickness = 6.0\ndiameter = 24.0\nglass = \"SF5\"
[[surface]]\nradius = -120.0\nthickness = 40.0\ndiameter = 24.0
[[surface]]\ndiameter = 24.0\nglass = \"SF5\"\n";

/// A far ball.
const FAR: &str = r#"
    LightSource "infinite" "rgb L" [0.01 0.01 0.02]
    AttributeBegin
        AreaLightSource "diffuse" "rgb L" [50 40 20]
        Translate 0.03 0.015 6 Shape "sphere" "float radius" 0.02
    AttributeEnd"#;

/// A sky with a sun in view, and a lamp before it.
const SUNNY: &str = r#"
    LightSource "infinite" "string filename" "sky.pfm"
    AttributeBegin
        AreaLightSource "diffuse" "rgb L" [500 400 200]
        Translate 0.3 0.2 6 Shape "sphere" "float radius" 0.04
    AttributeEnd"#;

/// The sky behind a window.
const WINDOW: &str = r#"
    LightSource "infinite" "string filename" "sky.pfm"
        "point3 portal" [-0.9 -0.6 3  -0.9 0.6 3  0.9 0.6 3  0.9 -0.6 3]"#;

/// A picture with lamps.
#[derive(Clone, Debug)]
pub struct Case {
    pub name: &'static str,
    /// File of the repository, or text.
    pub lens: &'static str,
    /// Diagonal of the film (mm).
    pub diagonal: f64,
    /// Text before the camera.
    pub before: &'static str,
    /// Parameters of the camera.
    pub camera: &'static str,
    pub filter: &'static str,
    pub world: &'static str,
    pub changes: Changes,
}

impl Case {
    /// Returns all that its picture depends on, besides files.
    fn subject(&self) -> impl Debug {
        let Self { name, lens, diagonal, before, camera, filter, world, changes } = self;
        let changes = changed_fields(changes, &Changes::default());
        (*name, *lens, *diagonal, [*before, *camera, *filter, *world], changes)
    }
}

pub fn case(
    name: &'static str,
    lens: &'static str,
    camera: &'static str,
    world: &'static str,
) -> Case {
    let changes = Changes { effects: "none".parse().expect("effects"), ..Changes::default() };
    Case { name, lens, diagonal: 22.0, before: "", camera, filter: "\"box\"", world, changes }
}

pub fn cases() -> Vec<Case> {
    let with = |effects: &str, changes: Changes| Changes {
        effects: effects.parse().expect("effects"),
        ..changes
    };
    let monochrome = |effects: &str, range: [f64; 2]| Case {
        diagonal: 2.4,
        changes: with(
            effects,
            Changes { passband: Some(Passband { range }), ..Changes::default() },
        ),
        ..case(
            "light of one colour",
            SINGLET,
            "\"float focusdistance\" 6 \"float aperturediameter\" 30",
            FAR,
        )
    };
    vec![
        case("ball, out of focus", "dgauss.50mm.dat", "\"float focusdistance\" 2", BALL),
        case("ball behind a wide angle", "wide.22mm.dat", "\"float focusdistance\" 0.5", LARGE),
        Case {
            filter: "\"gaussian\" \"float xradius\" 1.5 \"float yradius\" 1.2",
            ..case(
                "disk, in focus",
                "dgauss.50mm.dat",
                "\"float focusdistance\" 5 \"float aperturediameter\" 4",
                DISK,
            )
        },
        Case {
            filter: "\"mitchell\"",
            ..case("hidden", "dgauss.50mm.dat", "\"float focusdistance\" 3", HIDDEN)
        },
        Case {
            changes: with(
                "+tilt_shift,-ghosts,-diffraction",
                Changes {
                    film_tilt: Some([8.0, -5.0]),
                    film_shift: Some([2.0, -3.0]),
                    ..Changes::default()
                },
            ),
            ..case("tilted film", "dgauss.50mm.dat", "\"float focusdistance\" 2", BALL)
        },
        Case {
            changes: with("+fresnel,+iris,-ghosts,-diffraction", Changes::default()),
            ..case(
                "pentagon with losses",
                "wide.22mm.pentagon.toml",
                "\"float focusdistance\" 0.4",
                DISK,
            )
        },
        case("anamorphic", "anamorphic.toml", "\"float focusdistance\" 2", BALL),
        Case {
            diagonal: 2.4,
            filter: "\"mitchell\"",
            changes: with("+dispersion,+fresnel,-ghosts,-diffraction", Changes::default()),
            ..case(
                "colours pixels apart",
                SINGLET,
                "\"float focusdistance\" 6 \"float aperturediameter\" 30",
                FAR,
            )
        },
        Case {
            changes: with("+dispersion,-ghosts,-diffraction", Changes::default()),
            ..case(
                "colours in one pixel",
                "triplet.toml",
                "\"float focusdistance\" 2 \"float aperturediameter\" 30",
                BALL,
            )
        },
        monochrome("+dispersion,-ghosts,-diffraction", [405.0, 415.0]),
        monochrome("none", [540.0, 560.0]),
        case(
            "fisheye",
            "fisheye.10mm.dat",
            "\"float focusdistance\" 1 \"float aperturediameter\" 4",
            ASIDE,
        ),
        case("sun, sharp", "dgauss.50mm.dat", "\"float focusdistance\" 2", SUNNY),
        Case {
            filter: "\"gaussian\" \"float xradius\" 1.5 \"float yradius\" 1.2",
            changes: with("+dispersion,-ghosts,-diffraction", Changes::default()),
            ..case(
                "sun behind a window",
                "triplet.toml",
                "\"float focusdistance\" 2 \"float aperturediameter\" 30",
                WINDOW,
            )
        },
        case(
            "sun, out of focus",
            "dgauss.50mm.dat",
            "\"float focusdistance\" 1 \"float aperturediameter\" 12",
            SUNNY,
        ),
        case("film in glass", FILM_IN_GLASS, "\"float focusdistance\" 2", BALL),
        Case {
            changes: with("+dispersion,+fresnel,-ghosts,-diffraction", Changes::default()),
            ..case("colours in glass", FILM_IN_GLASS, "\"float focusdistance\" 2", LARGE)
        },
    ]
}

/// Returns the file of a sky with a sun of 0.8 degrees, 3.5 degrees from the axis of the camera, and light
/// about it.
pub fn sky() -> Vec<u8> {
    let pixel = |i: usize| {
        let [x, y] = [i % 256, i / 256].map(|p| p as f32);
        let distance2 = (x - 131.0).powi(2) + (y - 126.0).powi(2);
        match distance2 {
            0.0 => [9e3, 8e3, 7e3],
            _ => [20.0 / distance2, 30.0 / distance2, 40.0 / distance2],
        }
    };
    let mut file = Vec::new();
    write_pfm([256; 2], pixel, &mut file).expect("a sky");
    file
}

pub fn job(case: &Case, light_paths: bool, seed: u32, samples: u32) -> Job {
    let Case { lens, diagonal, before, camera, filter, world, .. } = case;
    let folder = folder();
    let lens = match lens.contains('\n') {
        true => write(&folder, "lens.toml", lens),
        false => root().join("lenses").join(lens),
    };
    if world.contains("sky.pfm") {
        write(&folder, "sky.pfm", sky());
    }
    let text = format!(
        r#"Film "rgb" "integer xresolution" 48 "integer yresolution" 32 "float diagonal" {diagonal}
           PixelFilter {filter}
           Integrator "path" "integer maxdepth" 1 {before}
           Camera "realistic" "string lensfile" "{}" {camera}
           WorldBegin {world}"#,
        lens.display()
    );
    let description = pbrt::read(&write(&folder, "lamp.pbrt", text)).expect("a scene");
    let changes = Changes {
        light_paths: Some(light_paths),
        samples: Some(samples),
        seed: Some(seed),
        ..case.changes.clone()
    };
    prepare(description, &changes).expect("a job").job
}

/// Checks that a picture of light paths has the same bits for other numbers of threads and lanes, and
/// in crops. Those begin one pixel right of the brightest one, so that filters reach into them, at the
/// middle, and in a corner.
pub fn assert_same_bits(case: &Case) {
    let whole = job(case, true, 3, 8);
    let expected = picture(&whole, Backend::Simd, 1);
    for (backend, threads) in [(Backend::Simd, 2), (Backend::Scalar, 7)] {
        let found = picture(&whole, backend, threads);
        assert_eq!(expected, found, "{}: {threads} threads", case.name);
    }
    let brightest = (0..48 * 32)
        .max_by(|&i, &k| expected.pixels[i][1].total_cmp(&expected.pixels[k][1]))
        .expect("pixels");
    let beside = [(brightest % 48 + 1).min(46) as u32, (brightest / 48).min(29) as u32];
    for (low, high) in [(beside, [47, 30]), ([20, 10], [40, 25]), ([0, 0], [9, 7])] {
        let changes = Changes { crop: Some([low, high]), ..case.changes.clone() };
        let part = job(&Case { changes, ..case.clone() }, true, 3, 8);
        let part = picture(&part, Backend::Simd, 2);
        let width = high[0] - low[0];
        for (i, inside) in (0..).zip(&part.pixels) {
            let [x, y] = [low[0] + i % width, low[1] + i / width];
            let pixel = expected.pixels[(y * 48 + x) as usize];
            assert_eq!(*inside, pixel, "{}: pixel {x}, {y}", case.name);
        }
    }
}

/// Returns the sum of all channels of a picture's pixels.
pub fn light(picture: &Picture) -> f64 {
    picture.pixels.iter().flatten().map(|&c| f64::from(c)).sum()
}

/// Returns the sum of all channels of a picture's pixels, that of each channel, and the moment of
/// inertia about the middle, which tells spread light.
pub fn light_by_channel(picture: &Picture) -> Vec<f64> {
    let radius2 = |i: usize| {
        let [x, y] = [i % 48, i / 48].map(|p| p as f64);
        (x - 23.5).powi(2) + (y - 15.5).powi(2)
    };
    let moment: f64 = (picture.pixels.iter().enumerate())
        .map(|(i, pixel)| radius2(i) * f64::from(pixel[0] + pixel[1] + pixel[2]))
        .sum();
    let channel = |c: usize| picture.pixels.iter().map(|pixel| f64::from(pixel[c])).sum();
    vec![light(picture), channel(0), channel(1), channel(2), moment]
}

/// Samples per pixel of camera paths alone, of camera paths and light paths together, and of light paths
/// alone. Those lose what the weights of both gain.
pub type Samples = [u32; 3];

/// Paths that find the direct light of lamps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Paths {
    Camera,
    Both,
    /// Light paths, and camera paths for what those cannot find.
    Light,
}

/// Returns a job, as prepared with or without light paths, in which these paths find lamps.
pub fn with_paths(paths: Paths, prepare: impl Fn(bool) -> Job) -> Job {
    let mut job = prepare(paths != Paths::Camera);
    let found = job.lamp_images.is_some() || job.caustics.is_some();
    assert_eq!(found, paths != Paths::Camera, "{}", job.plan.light_paths);
    if let (Paths::Light, Some(lamps)) = (paths, &mut job.lamp_images) {
        lamps.make_exclusive();
    }
    job
}

/// Largest difference of two means of a dozen pictures, in standard errors: Student's t of 15 degrees of
/// freedom, one in a million.
const ERRORS: f64 = 7.5;

/// Returns the means over pictures of their parts, and the standard errors of these.
pub fn means_and_errors(pictures: &[Vec<f64>]) -> Vec<[f64; 2]> {
    (0..pictures[0].len())
        .map(|part| mean_and_error(&pictures.iter().map(|parts| parts[part]).collect::<Vec<f64>>()))
        .collect()
}

/// Returns the means and standard errors of the light of camera paths alone, from the file of references,
/// which the full tier computes again.
pub fn light_of_camera_paths(
    label: &str,
    subject: impl Debug,
    compute: impl FnOnce() -> Vec<[f64; 2]>,
) -> Vec<[f64; 2]> {
    let numbers =
        reference("light_paths", label, subject, means_agree(ERRORS), || compute().concat());
    numbers.as_chunks().0.to_vec()
}

/// Asserts that light equals that of camera paths alone, part by part: means and their standard errors.
/// `noisiest` is the largest error of a part relative to it, if the part has one.
pub fn assert_agrees(
    name: &str,
    camera: &[[f64; 2]],
    found: &[[f64; 2]],
    noisiest: impl Fn(usize) -> Option<f64>,
) {
    assert_eq!(found.len(), camera.len(), "parts");
    for (part, (camera, found)) in camera.iter().zip(found).enumerate() {
        let error = camera[1].hypot(found[1]);
        let off = found[0] - camera[0];
        println!(
            "{name} {part}: off by {:.3} +- {:.3} %: {:.2} errors",
            100.0 * off / camera[0],
            100.0 * error / camera[0],
            off / error
        );
        assert!(
            noisiest(part).is_none_or(|noisiest| error < noisiest * camera[0]),
            "{name} {part}: {camera:?} and {found:?} are noisy"
        );
        assert!(off.abs() < ERRORS * error, "{name} {part}: {camera:?}, but {found:?}");
    }
}

/// Compares the light of camera paths with that of light paths, alone and together, whole and in parts.
/// The error of the whole is below `noisiest` of it.
pub fn assert_same_light(
    cases: &[Case],
    samples: Samples,
    noisiest: f64,
    parts: impl Fn(&Picture) -> Vec<f64>,
) {
    /// Pictures of each kind, each with another seed.
    const PICTURES: u32 = 12;
    for case in cases {
        let light_of = |paths, samples| {
            let prepared =
                |seed| with_paths(paths, |light_paths| job(case, light_paths, seed, samples));
            let first = prepared(0);
            let of_seed = |seed| {
                // Surveys take a part of the time. In the fast tier all pictures share one.
                let job = if full() { prepared(seed) } else { Job { seed, ..first.clone() } };
                parts(&picture(&job, Backend::Simd, 1))
            };
            means_and_errors(&(0..PICTURES).map(of_seed).collect::<Vec<Vec<f64>>>())
        };
        let lens = match case.lens.contains('\n') {
            true => case.lens.to_owned(),
            false => read_to_string(root().join("lenses").join(case.lens)).expect("a lens"),
        };
        let sky = case.world.contains("sky.pfm").then(sky);
        let subject = (case.subject(), lens, sky, samples[0], PICTURES);
        let label = format!("{} through {}", case.name, case.lens.lines().next().unwrap_or(""));
        let camera = light_of_camera_paths(&label, subject, || light_of(Paths::Camera, samples[0]));
        for (paths, samples) in [(Paths::Both, samples[1]), (Paths::Light, samples[2])] {
            let found = light_of(paths, samples);
            let name = format!("{}, {paths:?}", case.name);
            assert_agrees(&name, &camera, &found, |part| (part == 0).then_some(noisiest));
        }
    }
}
