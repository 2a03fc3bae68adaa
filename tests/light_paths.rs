//! Light paths from lamps: the light of camera paths with less noise, and the same bits on any machine.

mod support;

use std::sync::atomic::Ordering;

use petzval::io::image::Picture;
use petzval::job::Job;
use petzval::prepare::{Changes, prepare};
use petzval::render::{Backend, Progress, RenderOptions, render_resumable};
use petzval::scene::pbrt;
use support::workspace::Workspace;
use support::{folder, in_parallel, mean_and_error, picture, root, write};

/// A lamp in the shape of a ball, and dim surroundings.
const BALL: &str = r#"
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

/// A far ball.
const FAR: &str = r#"
    LightSource "infinite" "rgb L" [0.01 0.01 0.02]
    AttributeBegin
        AreaLightSource "diffuse" "rgb L" [50 40 20]
        Translate 0.03 0.015 6 Shape "sphere" "float radius" 0.02
    AttributeEnd"#;

/// A picture with lamps.
struct Case {
    name: &'static str,
    /// File of the repository, or text.
    lens: &'static str,
    /// Diagonal of the film (mm).
    diagonal: f64,
    /// Parameters of the camera.
    camera: &'static str,
    filter: &'static str,
    world: &'static str,
    changes: Changes,
}

fn case(name: &'static str, lens: &'static str, camera: &'static str, world: &'static str) -> Case {
    let changes = Changes { effects: "none".parse().expect("effects"), ..Changes::default() };
    Case { name, lens, diagonal: 22.0, camera, filter: "\"box\"", world, changes }
}

fn cases() -> Vec<Case> {
    let with = |effects: &str, changes: Changes| Changes {
        effects: effects.parse().expect("effects"),
        ..changes
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
        case(
            "fisheye",
            "fisheye.10mm.dat",
            "\"float focusdistance\" 1 \"float aperturediameter\" 4",
            ASIDE,
        ),
    ]
}

fn job(case: &Case, light_paths: bool, seed: u32, samples: u32) -> Job {
    let Case { lens, diagonal, camera, filter, world, .. } = case;
    let folder = folder();
    let lens = match lens.contains('\n') {
        true => write(&folder, "lens.toml", lens),
        false => root().join("lenses").join(lens),
    };
    let text = format!(
        r#"Film "rgb" "integer xresolution" 48 "integer yresolution" 32 "float diagonal" {diagonal}
           PixelFilter {filter}
           Integrator "path" "integer maxdepth" 1
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
    prepare(description, &changes).expect("a job").0
}

/// Returns the sum of all channels of a picture's pixels.
fn light(picture: &Picture) -> f64 {
    picture.pixels.iter().flatten().map(|&c| f64::from(c)).sum()
}

/// Returns the sum of all channels of a picture's pixels, and that of each channel.
fn light_by_channel(picture: &Picture) -> [f64; 4] {
    let channel = |c: usize| picture.pixels.iter().map(|pixel| f64::from(pixel[c])).sum();
    [light(picture), channel(0), channel(1), channel(2)]
}

#[test]
fn light_paths_change_no_light() {
    /// Pictures of each kind, each with another seed.
    const PICTURES: u32 = 12;
    in_parallel(&cases(), |case| {
        let [camera, both] = [(false, 768), (true, 96)].map(|(light_paths, samples)| {
            let sum = |seed| {
                let job = job(case, light_paths, seed, samples);
                assert_eq!(job.direct_light.is_some(), light_paths, "{}", job.plan.light_paths);
                light_by_channel(&picture(&job, Backend::Simd, 1))
            };
            (0..PICTURES).map(sum).collect::<Vec<[f64; 4]>>()
        });
        for part in 0..4 {
            let [camera, both] = [&camera, &both].map(|pictures| {
                mean_and_error(&pictures.iter().map(|light| light[part]).collect::<Vec<f64>>())
            });
            let error = camera[1].hypot(both[1]);
            let off = both[0] - camera[0];
            println!(
                "{} {part}: off by {:.3} +- {:.3} %: {:.2} errors",
                case.name,
                100.0 * off / camera[0],
                100.0 * error / camera[0],
                off / error
            );
            assert!(
                part > 0 || error < 3e-3 * camera[0],
                "{}: {camera:?} and {both:?} are noisy",
                case.name
            );
            // Student's t of 15 degrees of freedom, one in a million: 7.5.
            assert!(
                off.abs() < 7.5 * error,
                "{} {part}: {camera:?}, and {both:?} with light paths",
                case.name
            );
        }
    });
}

#[test]
fn light_paths_find_small_lamps_with_a_fifth_of_the_variance_or_less() {
    let noise = |case: &Case, light_paths| {
        let pictures: Vec<Picture> = (0..12)
            .map(|seed| picture(&job(case, light_paths, seed, 16), Backend::Simd, 1))
            .collect();
        let pixels = pictures[0].pixels.len();
        (0..pixels)
            .map(|i| {
                let values: Vec<f64> = pictures.iter().map(|p| f64::from(p.pixels[i][1])).collect();
                mean_and_error(&values)[1].powi(2)
            })
            .sum::<f64>()
    };
    let all = cases();
    for case in [&all[0], &all[2], &all[3]] {
        let [camera, both] = [false, true].map(|light_paths| noise(case, light_paths));
        println!("{}: variance {camera:.3e} and {both:.3e}", case.name);
        assert!(both < 0.2 * camera, "{}: variance {camera} and {both}", case.name);
    }
}

#[test]
fn the_picture_is_the_same_for_all_threads_lanes_and_crops() {
    let all = cases();
    for case in all[2..5].iter().chain(&all[7..9]) {
        let job = job(case, true, 3, 8);
        let whole = picture(&job, Backend::Simd, 1);
        for (backend, threads) in [(Backend::Simd, 2), (Backend::Scalar, 7)] {
            assert_eq!(whole, picture(&job, backend, threads), "{}: {threads} threads", case.name);
        }
        // The crop ends in the image of a lamp, beside which filters reach into it.
        let brightest = (0..48 * 32)
            .max_by(|&i, &k| whole.pixels[i][1].total_cmp(&whole.pixels[k][1]))
            .expect("pixels");
        let [left, top] = [brightest % 48 + 1, brightest / 48];
        let mut part = job.clone();
        (part.frame.low, part.frame.high) = ([left as u32, top as u32], [47, 30]);
        let part = picture(&part, Backend::Simd, 2);
        for y in top..30 {
            for x in left..47 {
                let inside = part.pixels[(y - top) * (47 - left) + x - left];
                assert_eq!(inside, whole.pixels[y * 48 + x], "{}: pixel {x}, {y}", case.name);
            }
        }
    }
}

#[test]
fn shards_and_adaptive_renders_have_the_light_of_a_whole_render() {
    let workspace = Workspace::new();
    let text = format!(
        r#"Film "rgb" "integer xresolution" 48 "integer yresolution" 32
           Camera "realistic" "string lensfile" "{}" "float focusdistance" 3
           WorldBegin {BALL}"#,
        root().join("lenses/dgauss.50mm.dat").display()
    );
    std::fs::write(workspace.path("lamp.pbrt"), text).expect("a scene");
    let render = "render lamp.pbrt --spp 90 --light-paths on --effects none";
    workspace.merges_to_the_whole(render);
    workspace.run_ok(&format!("{render} --noise 0.02 -o adaptive.exr"));
    let [whole, adaptive] = ["whole.exr", "adaptive.exr"]
        .map(|name| light(&Picture::read(&workspace.path(name)).expect("a picture")));
    assert!((adaptive / whole - 1.0).abs() < 0.02, "{adaptive} and {whole}");
    workspace.run_ok(
        "render lamp.pbrt --spp 90 --effects none -o off.petzval --shard 3/3 --light-paths off",
    );
    workspace.refuses("merge 2.petzval 1.petzval off.petzval -o x.exr", "--light-paths");
}

#[test]
fn shards_have_the_colours_of_a_whole_render() {
    let workspace = Workspace::new();
    let text = format!(
        r#"Film "rgb" "integer xresolution" 48 "integer yresolution" 32
           Camera "realistic" "string lensfile" "{}" "float focusdistance" 3
           WorldBegin {BALL}"#,
        root().join("lenses/triplet.toml").display()
    );
    std::fs::write(workspace.path("lamp.pbrt"), text).expect("a scene");
    let effects = "--effects +dispersion,-ghosts,-diffraction";
    workspace.merges_to_the_whole(&format!("render lamp.pbrt --spp 90 --light-paths on {effects}"));
}

#[test]
fn a_picture_stopped_in_its_first_pass_has_the_light_of_lamps() {
    let case = &cases()[0];
    let whole = light(&picture(&job(case, true, 1, 16), Backend::Simd, 2));
    let job = job(case, true, 1, 100_000);
    let progress = Progress::default();
    let options = RenderOptions { threads: 1, progress: Some(&progress), ..Default::default() };
    let stopped = std::thread::scope(|scope| {
        scope.spawn(|| {
            // A tile of the first pass has 65,536 samples.
            while progress.samples.load(Ordering::Relaxed) < 70_000 {
                std::thread::yield_now();
            }
            progress.stop.store(true, Ordering::Relaxed);
        });
        render_resumable(&job, options, None, None).expect("a partial picture")
    });
    let spp = stopped.partial_mean_spp.expect("a partial picture");
    assert!(spp < 256.0, "{spp} samples a pixel: it was stopped too late");
    let partial = light(&stopped.picture(&job));
    assert!(partial > 0.5 * whole, "{partial} of {whole}");
}

#[test]
fn pictures_without_small_bright_lamps_take_no_light_paths() {
    let auto = |world: &str, more: &str| {
        let text = format!(
            r#"Film "rgb" "integer xresolution" 48 "integer yresolution" 32 {more}
               Camera "realistic" "string lensfile" "{}" "float focusdistance" 3
               WorldBegin {world}"#,
            root().join("lenses/dgauss.50mm.dat").display()
        );
        let folder = folder();
        let description = pbrt::read(&write(&folder, "lamp.pbrt", text)).expect("a scene");
        prepare(description, &Changes::default()).expect("a job").0
    };
    let wall = r#"
        AreaLightSource "diffuse" "rgb L" [2 2 2]
        Shape "trianglemesh" "point3 P" [-5 -5 7  5 -5 7  5 5 7  -5 5 7]
            "integer indices" [0 2 1 0 3 2]"#;
    let behind = r#"
        LightSource "infinite" "rgb L" [0.5 0.5 0.5]
        AreaLightSource "diffuse" "rgb L" [900 900 900]
        Translate 0 0 -5 Shape "sphere" "float radius" 0.1"#;
    let clamped = "\"float maxcomponentvalue\" 5";
    for (world, more, reason) in [
        (wall, "", "no lamp in view is small and bright enough"),
        (behind, "", "no lamp in view is small and bright enough"),
        ("LightSource \"infinite\"", "", "no surface emits light"),
        (BALL, clamped, "bright samples are clamped"),
    ] {
        let job = auto(world, more);
        assert!(job.direct_light.is_none(), "{reason}: {}", job.plan.light_paths);
        assert!(job.plan.light_paths.reason.contains(reason), "{}", job.plan.light_paths);
    }
    let job = auto(BALL, "");
    assert!(job.direct_light.is_some(), "{}", job.plan.light_paths);
}
