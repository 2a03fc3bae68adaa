//! Caustics by light paths: the light of camera paths with less noise, and the same bits on any machine.

use std::fmt::Debug;
use std::fs::read_to_string;

use crate::light_paths::cases::{assert_agrees, light_of_camera_paths, means_and_errors};
use crate::support::reference::{changed_fields, full};
use crate::support::workspace::Workspace;
use crate::support::{folder, mean_and_error, picture, root, write};
use petzval_image::Picture;
use petzval_render::Backend;
use petzval_render::job::Job;
use petzval_render::prepare::{Changes, prepare};
use petzval_scene_formats::pbrt;

/// A table, seen from above, and a lamp large enough for camera paths to find.
const TABLE: &str = r#"
    LightSource "infinite" "rgb L" [0.02 0.02 0.03]
    AttributeBegin
        AreaLightSource "diffuse" "rgb L" [40 36 30]
        Translate -0.3 0.5 0.2 Shape "sphere" "float radius" 0.1
    AttributeEnd
    Material "diffuse" "rgb reflectance" [0.5 0.4 0.3]
    Shape "bilinearmesh" "point3 P" [-3 0 -3  3 0 -3  -3 0 3  3 0 3]"#;

/// A ball of glass.
const BALL: &str = r#"
    Material "dielectric" "float eta" 1.5
    AttributeBegin Translate 0 0.05 0 Shape "sphere" "float radius" 0.05 AttributeEnd"#;

/// A coated floor that is lit only by a mirror: a stretched instance with interpolated normals, above a
/// lamp that faces away from the floor.
const MIRROR: &str = r#"
    AttributeBegin
        AreaLightSource "diffuse" "rgb L" [40 36 30]
        Shape "trianglemesh" "integer indices" [0 1 2 1 3 2]
            "point3 P" [-0.385 0.3 -0.15  -0.385 0.3 0.15  -0.215 0.2 -0.15  -0.215 0.2 0.15]
    AttributeEnd
    Material "coateddiffuse" "rgb reflectance" [0.4 0.5 0.5] "float roughness" 0.1
    Shape "bilinearmesh" "point3 P" [-3 0 -3  3 0 -3  -3 0 3  3 0 3]
    ObjectBegin "mirror"
        Material "conductor" "float roughness" 0 "rgb reflectance" [0.9 0.8 0.7]
        Shape "trianglemesh" "integer indices" [0 1 2 0 2 3]
            "point3 P" [-0.08 0.072 -0.1  -0.08 0.072 0.1  0.08 -0.072 0.1  0.08 -0.072 -0.1]
            "normal N" [-0.6 -0.8 -0.1  -0.6 -0.8 0.1  -0.6 -0.8 0.1  -0.6 -0.8 -0.1]
    ObjectEnd
    AttributeBegin Translate 0.15 0.45 0 Scale 1 1 1.5 ObjectInstance "mirror" AttributeEnd"#;

/// A pane before a curtain that transmits, and a lamp on both of its sides.
const PANE: &str = r#"
    AttributeBegin
        AreaLightSource "diffuse" "rgb L" [30 30 60] "bool twosided" true
        Shape "bilinearmesh" "point3 P" [-0.2 0.2 -0.1  0 0.2 -0.1  -0.2 0.2 0.1  0 0.2 0.1]
    AttributeEnd
    MakeNamedMaterial "pane" "string type" "thindielectric" "float eta" 1.6
    MakeNamedMaterial "curtain" "string type" "diffusetransmission"
        "rgb reflectance" [0.3 0.2 0.2] "rgb transmittance" [0.3 0.4 0.4]
    NamedMaterial "pane"
    Shape "bilinearmesh" "point3 P" [-0.2 0.12 -0.1  0.2 0.12 -0.1  -0.2 0.1 0.2  0.2 0.1 0.2]
    NamedMaterial "curtain"
    Shape "bilinearmesh" "point3 P" [-0.2 0.05 -0.1  0.2 0.05 -0.1  -0.2 0.03 0.2  0.2 0.03 0.2]"#;

/// A ball of a mixture of glass and paint beside a wall, so that caustics light other surfaces.
const MIXTURE: &str = r#"
    MakeNamedMaterial "glass" "string type" "dielectric" "float eta" 1.5
    MakeNamedMaterial "paint" "string type" "diffuse" "rgb reflectance" [0.7 0.2 0.2]
    MakeNamedMaterial "dotted" "string type" "mix" "string materials" ["glass" "paint"] "float amount" 0.4
    NamedMaterial "dotted"
    AttributeBegin Translate 0 0.05 0 Scale 1 0.8 1 Shape "sphere" "float radius" 0.05 AttributeEnd
    NamedMaterial "paint"
    Shape "bilinearmesh" "point3 P" [0.1 0 -0.2  0.1 0 0.2  0.1 0.3 -0.2  0.1 0.3 0.2]"#;

/// A ball of glass that rolls, and one that stays.
const ROLLING: &str = r#"
    Material "dielectric" "float eta" 1.5
    AttributeBegin
        Translate -0.03 0.05 0 ActiveTransform EndTime Translate 0.06 0 0.02 Rotate 70 0 0 1 ActiveTransform All
        Scale 1 1 0.9 Shape "sphere" "float radius" 0.05
    AttributeEnd
    AttributeBegin Translate -0.15 0.03 0.03 Shape "sphere" "float radius" 0.03 AttributeEnd"#;

/// A picture with caustics.
#[derive(Debug)]
struct Case {
    name: &'static str,
    lens: &'static str,
    /// Motion of the camera.
    motion: &'static str,
    filter: &'static str,
    world: String,
    /// Samples per pixel of camera paths alone.
    samples: u32,
    changes: Changes,
}

impl Case {
    /// Returns all that its picture depends on, besides files.
    fn subject(&self) -> impl Debug {
        let Self { name, lens, motion, filter, world, samples, changes } = self;
        let changes = changed_fields(changes, &Changes::default());
        (*name, *lens, [*motion, *filter, world.as_str()].map(str::to_owned), *samples, changes)
    }
}

fn cases() -> Vec<Case> {
    let case = |name, lens, world: &[&str]| Case {
        name,
        lens,
        motion: "",
        filter: "\"box\"",
        world: world.concat(),
        samples: 384,
        changes: Changes { effects: "none".parse().expect("effects"), ..Changes::default() },
    };
    let tilted = Changes {
        effects: "+tilt_shift,+fresnel,-ghosts,-diffraction".parse().expect("effects"),
        film_tilt: Some([6.0, -4.0]),
        film_shift: Some([1.0, -1.0]),
        ..Changes::default()
    };
    let moving = |shutter: &str, rolling: Option<&str>| Changes {
        effects: "-ghosts,-diffraction".parse().expect("effects"),
        shutter: Some(shutter.parse().expect(shutter)),
        rolling: rolling.map(|text| text.parse().expect(text)),
        ..Changes::default()
    };
    vec![
        case("ball", "dgauss.50mm.dat", &[TABLE, BALL]),
        Case {
            filter: "\"gaussian\" \"float xradius\" 1.5 \"float yradius\" 1.2",
            samples: 2048,
            ..case("mirror", "dgauss.50mm.dat", &[MIRROR])
        },
        Case { changes: tilted, ..case("pane", "dgauss.50mm.dat", &[TABLE, PANE]) },
        case("mixture", "wide.22mm.pentagon.toml", &[TABLE, MIXTURE]),
        Case {
            changes: Changes {
                effects: "+dispersion,-ghosts,-diffraction".parse().expect("effects"),
                assume_vd: true,
                ..Changes::default()
            },
            ..case("colours", "dgauss.50mm.dat", &[TABLE, BALL])
        },
        Case {
            changes: moving("open=0,close=1,opening=0.5", None),
            ..case("rolling ball", "dgauss.50mm.dat", &[TABLE, ROLLING])
        },
        Case {
            motion: "ActiveTransform EndTime Translate 0.05 0.02 0 ActiveTransform All",
            changes: moving("open=0,close=0.4", Some("0.6,up")),
            ..case("rolling ball and shutter", "dgauss.50mm.dat", &[TABLE, ROLLING])
        },
    ]
}

fn job(case: &Case, light_paths: Option<bool>, seed: u32, samples: u32) -> Job {
    let Case { lens, motion, filter, world, .. } = case;
    let text = format!(
        r#"Film "rgb" "integer xresolution" 48 "integer yresolution" 32 "float diagonal" 22
           PixelFilter {filter}
           Integrator "path" "integer maxdepth" 5
           {motion} LookAt 0 0.35 -0.6  0 0.03 0  0 1 0
           Camera "realistic" "string lensfile" "{}" "float focusdistance" 0.65
           WorldBegin {world}"#,
        root().join("lenses").join(lens).display()
    );
    let folder = folder();
    let description = pbrt::read(&write(&folder, "caustics.pbrt", text)).expect("a scene");
    let changes =
        Changes { light_paths, samples: Some(samples), seed: Some(seed), ..case.changes.clone() };
    prepare(description, &changes).expect("a job").job
}

/// Returns the light of a picture's pixels, once of all and once of each third of its columns.
fn light(picture: &Picture) -> Vec<f64> {
    let mut sums = vec![0.0; 4];
    for (i, pixel) in picture.pixels.iter().enumerate() {
        let value: f64 = pixel.iter().map(|&c| f64::from(c)).sum();
        sums[0] += value;
        sums[1 + i % 48 / 16] += value;
    }
    sums
}

#[test]
fn light_paths_change_no_light() {
    /// Pictures of each kind, each with another seed.
    const PICTURES: u32 = 12;
    for case in &cases() {
        let light_of = |light_paths, samples| {
            let first = job(case, Some(light_paths), 0, samples);
            assert_eq!(first.caustics.is_some(), light_paths, "{}", first.plan.light_paths);
            let of_seed = |seed| {
                let job = match full() {
                    true => job(case, Some(light_paths), seed, samples),
                    false => Job { seed, ..first.clone() },
                };
                light(&picture(&job, Backend::Simd, 1))
            };
            means_and_errors(&(0..PICTURES).map(of_seed).collect::<Vec<Vec<f64>>>())
        };
        let lens = read_to_string(root().join("lenses").join(case.lens)).expect("a lens");
        let label = format!("caustics: {}", case.name);
        let camera = light_of_camera_paths(&label, (case.subject(), lens, PICTURES), || {
            light_of(false, case.samples)
        });
        assert_agrees(case.name, &camera, &light_of(true, 128), |part| {
            Some(if part == 0 { 8e-3 } else { 2e-2 })
        });
    }
}

/// A lamp that camera paths hardly ever find through the glass.
fn small_lamp() -> Case {
    let mut case = cases().swap_remove(0);
    case.world = case.world.replace("[40 36 30]", "[4000 3600 3000]");
    case.world = case.world.replace("\"float radius\" 0.1", "\"float radius\" 0.01");
    case
}

#[test]
fn caustics_of_small_lamps_have_a_quarter_of_the_variance_or_less() {
    let case = small_lamp();
    let noise = |light_paths| {
        let pictures: Vec<Picture> = (0..12)
            .map(|seed| picture(&job(&case, light_paths, seed, 64), Backend::Simd, 1))
            .collect();
        (0..48 * 32)
            .map(|i| {
                let values: Vec<f64> = pictures.iter().map(|p| f64::from(p.pixels[i][1])).collect();
                mean_and_error(&values)[1].powi(2)
            })
            .sum::<f64>()
    };
    // The plan chooses light paths by itself. The lamp's reflections in the ball stay as noisy.
    let [camera, both] = [Some(false), None].map(noise);
    println!("variance {camera:.3e} and {both:.3e}");
    assert!(both < camera / 4.0, "variance {camera} and {both}");
}

#[test]
fn the_picture_is_the_same_for_all_threads_lanes_and_crops() {
    for case in &cases() {
        let job = job(case, Some(true), 3, 8);
        let whole = picture(&job, Backend::Simd, 1);
        for (backend, threads) in [(Backend::Simd, 2), (Backend::Scalar, 7)] {
            assert_eq!(whole, picture(&job, backend, threads), "{}: {threads} threads", case.name);
        }
        let mut part = job.clone();
        (part.frame.low, part.frame.high) = ([20, 10], [40, 25]);
        let part = picture(&part, Backend::Simd, 2);
        for (i, inside) in part.pixels.iter().enumerate() {
            let [x, y] = [20 + i % 20, 10 + i / 20];
            assert_eq!(*inside, whole.pixels[y * 48 + x], "{}: pixel {x}, {y}", case.name);
        }
    }
}

#[test]
fn shards_have_the_caustics_of_a_whole_render() {
    let workspace = Workspace::new();
    let text = format!(
        r#"Film "rgb" "integer xresolution" 48 "integer yresolution" 32
           LookAt 0 0.35 -0.6  0 0.03 0  0 1 0
           Camera "realistic" "string lensfile" "{}" "float focusdistance" 0.65
           WorldBegin {TABLE} {BALL}"#,
        root().join("lenses/dgauss.50mm.dat").display()
    );
    std::fs::write(workspace.path("ball.pbrt"), text).expect("a scene");
    let render = "render ball.pbrt --spp 90 --light-paths on --effects none";
    workspace.merges_to_the_whole(render);
    workspace.run_ok(
        "render ball.pbrt --spp 90 --effects none -o off.petzval --shard 3/3 --light-paths off",
    );
    workspace.refuses("merge 2.petzval 1.petzval off.petzval -o x.exr", "--light-paths");
}

#[test]
fn the_plan_says_why_there_are_no_light_paths_for_caustics() {
    let rough = BALL.replace("1.5", "1.5 \"float roughness\" 0.3");
    let below = r#"
        Material "subsurface" Shape "sphere" "float radius" 0.02"#;
    for (more, world, reason) in [
        ("", TABLE.to_owned(), "nothing reflects or refracts"),
        ("", [TABLE, &rough].concat(), "nothing reflects or refracts"),
        ("", [TABLE, BALL, below].concat(), "the scene has media"),
        ("\"float maxcomponentvalue\" 5", [TABLE, BALL].concat(), "bright samples are clamped"),
    ] {
        let mut case = small_lamp();
        case.world = world;
        case.filter = "\"box\"";
        let text = case.world.clone();
        let lens = root().join("lenses/dgauss.50mm.dat");
        let scene = format!(
            r#"Film "rgb" "integer xresolution" 48 "integer yresolution" 32 {more}
               LookAt 0 0.35 -0.6  0 0.03 0  0 1 0
               Camera "realistic" "string lensfile" "{}" "float focusdistance" 0.65
               WorldBegin {text}"#,
            lens.display()
        );
        let folder = folder();
        let description = pbrt::read(&write(&folder, "none.pbrt", scene)).expect("a scene");
        let job = prepare(description, &Changes::default()).expect("a job").job;
        assert!(job.caustics.is_none(), "{reason}: {}", job.plan.light_paths);
        assert!(job.plan.light_paths.reason.contains(reason), "{}", job.plan.light_paths);
    }
}
