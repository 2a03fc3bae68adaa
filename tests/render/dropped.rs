//! Samples of NaN or infinity: they are left out of pictures and reported.

use crate::support::workspace::Workspace;
use crate::support::{folder, petzval, root, write};
use petzval_image::{EncodingOptions, Notes, Picture};
use petzval_render::aov::Aov;
use petzval_render::job::StopCriteria;
use petzval_render::plan::EffectSelection;
use petzval_render::prepare::{Changes, prepare};
use petzval_render::sensor::SensorSettings;
use petzval_render::{RenderOptions, render};
use petzval_scene_formats::pbrt;

/// A ball so bright that it exceeds f32 at this ISO.
const GLARE: &str = r#"
    Film "rgb" "integer xresolution" 40 "integer yresolution" 30 "float iso" 1000
    Camera "perspective" "float fov" 40
    Integrator "path" "integer maxdepth" 3
    WorldBegin
    LightSource "distant" "rgb L" [1 1 1] "point3 from" [0 1 -1]
    Material "diffuse"
    Shape "trianglemesh" "point3 P" [-5 -1 1  -5 -1 9  5 -1 9  5 -1 1] "integer indices" [0 1 2 0 2 3]
    AttributeBegin AreaLightSource "diffuse" "rgb L" [3e38 3e38 3e38]
    Translate 0 0 4 Shape "sphere" "float radius" 0.3 AttributeEnd"#;

fn glare() -> Workspace {
    let workspace = Workspace::new();
    std::fs::write(workspace.path("scene.pbrt"), GLARE).expect("a scene");
    workspace
}

/// Parses the warning about dropped samples: their number, and the commands that replay the first ones.
fn dropped_samples(stderr: &str) -> (u64, Vec<String>) {
    let from = stderr.find("petzval: warning: ").expect("a warning");
    let mut lines = stderr[from..].lines();
    let warning = lines.next().expect("a line");
    assert!(warning.contains("samples were not finite and were dropped"), "{stderr}");
    let count = warning.split(' ').nth(2).and_then(|count| count.parse().ok()).expect("a count");
    let commands = lines.take_while(|line| line.starts_with("  petzval replay"));
    (count, commands.map(|line| line.trim().to_owned()).collect())
}

/// The reported samples do not depend on threads or shards, and the printed commands replay them.
#[test]
fn dropped_samples_are_reported_and_can_be_replayed() {
    let workspace = glare();
    let whole =
        dropped_samples(&workspace.run_ok("render scene.pbrt --spp 4 -o a.exr --threads 1"));
    let (count, commands) = &whole;
    assert!(*count > 8 && commands.len() == 8, "{whole:?}");
    let scalar = "render scene.pbrt --spp 4 -o b.exr --threads 2 --backend scalar";
    assert_eq!(dropped_samples(&workspace.run_ok(scalar)), whole);
    workspace.run_ok("render scene.pbrt --spp 4 -o 1.petzval --shard 1/2");
    workspace.run_ok("render scene.pbrt --spp 4 -o 2.petzval --shard 2/2");
    assert_eq!(dropped_samples(&workspace.run_ok("merge 2.petzval 1.petzval -o c.exr")), whole);

    let names = |name: &str| {
        let attributes = workspace.contents(name).attributes;
        let own = |line: &String| line.contains("ropped");
        attributes.into_iter().filter(own).collect::<Vec<_>>().join("\n")
    };
    assert!(
        names("a.exr").contains(&format!("droppedSamples: F32({count}.0)")),
        "{}",
        names("a.exr")
    );
    assert!(names("a.exr").contains("firstDropped") && names("a.exr") == names("c.exr"));

    for command in commands {
        let arguments: Vec<&str> = command.split(' ').skip(1).collect();
        let (code, stdout, stderr) = petzval(&workspace.path(""), &arguments);
        assert_eq!(code, 0, "{stderr}");
        assert!(stdout.contains("<- not finite") && stdout.contains("is dropped"), "{stdout}");
        assert!(stdout.contains("the emission at surface"), "{stdout}");
    }
}

/// In adaptive renders the samples of each round have their own seed.
#[test]
fn dropped_samples_of_adaptive_renders_are_named_by_their_seed() {
    let workspace = glare();
    let stderr = workspace.run_ok("render scene.pbrt --spp 40 --noise 0.02 -o a.exr");
    let (count, commands) = dropped_samples(&stderr);
    assert!(count > 8 && commands.iter().all(|line| line.contains("--sample-seed ")), "{stderr}");
    for command in commands {
        let arguments: Vec<&str> = command.split(' ').skip(1).collect();
        let (code, stdout, stderr) = petzval(&workspace.path(""), &arguments);
        assert_eq!(code, 0, "{stderr}");
        assert!(stdout.contains("is dropped"), "{command}: {stdout}");
    }
}

#[test]
fn invalid_replays_are_refused() {
    let workspace = glare();
    let refuses = |arguments: &str, expected: &str| workspace.refuses(arguments, expected);
    let outside = "expected X from 0 to 39 and Y from 0 to 29";
    refuses("replay scene.pbrt --pixel 40,3 --sample 0", outside);
    let cropped = "expected X from 8 to 15 and Y from 4 to 11";
    refuses("replay scene.pbrt --pixel 3,5 --sample 0 --crop 8,4,16,12", cropped);
    refuses("replay scene.pbrt --pixel 3 --sample 0", "two whole numbers X,Y");
    refuses("replay scene.pbrt --pixel 3,4 --sample 4294967295", "4294967295");
    refuses("replay scene.pbrt --pixel 3,4", "--sample");
    refuses("replay none.pbrt --pixel 3,4 --sample 0", "none.pbrt");
    refuses("replay scene.pbrt --pixel 3,4 --sample 0 --fstop 4", "--fstop");
}

/// As text a path fits a terminal; as JSON it is one object.
#[test]
fn a_replay_is_printed_as_text_and_as_json() {
    let scene = root().join("scenes/atelier.pbrt");
    let lens = root().join("lenses/triplet.toml");
    let (scene, lens) = (scene.display().to_string(), lens.display().to_string());
    let mut arguments = vec!["replay", &scene, "--lens", &lens, "--pixel", "600,500"];
    arguments.extend(["--effects", "+dispersion,-spectra", "--sample", "9", "--coating", "mgf2"]);
    let (code, text, stderr) = petzval(root(), &arguments);
    assert_eq!(code, 0, "{stderr}");
    assert!(text.lines().all(|line| line.chars().count() <= 100), "{text}");
    for part in ["band ", "shares its ray", "sphere", "throughput", "hits ", "radiance", "adds"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    arguments.push("--json");
    let (_, json, _) = petzval(root(), &arguments);
    let way: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    let adds = text.lines().find_map(|line| line.strip_prefix("adds ")).expect("a value");
    let number = |digits: &str| -> f64 { digits.trim().parse().expect("a number") };
    let adds: Vec<f64> = adds.split_whitespace().map(number).collect();
    // serde_json rounds some numbers to a neighbour of the nearest f64, so the digits are read here.
    let (_, value) = json.split_once("\"value\": [").expect("a value");
    let (value, _) = value.split_once(']').expect("the end of a list");
    let value: Vec<f64> = value.split(',').map(number).collect();
    assert_eq!(adds, value);
    assert_eq!(way["shared"].as_array().map(Vec::len), Some(4));
    assert_eq!(way["lens"]["surfaces"].as_array().map(Vec::len), Some(6));
    assert!(way["first_not_finite"].is_null());
}

/// Lights and surfaces beyond the range of f32.
const EXTREME: &str = r#"
    Film "rgb" "integer xresolution" 24 "integer yresolution" 16 "float diagonal" 43.27
        "float iso" 2000 "string sensor" "cie1931" "float whitebalance" 3000
    PixelFilter "mitchell"
    Camera "realistic" "string lensfile" "LENS" "float aperturediameter" 17.1
        "float focusdistance" 4.1
    Integrator "path" "integer maxdepth" 4
    WorldBegin
    LightSource "infinite" "rgb L" [1e37 2e37 1e-38]
    LightSource "point" "rgb I" [3e38 1e-38 1] "point3 from" [0 1 3]
    AttributeBegin AreaLightSource "diffuse" "rgb L" [3e38 3e38 3e38]
    Translate 0.6 0.5 5 Shape "sphere" "float radius" 0.05 AttributeEnd
    Material "conductor" "float roughness" 1e-38
    Shape "trianglemesh" "point3 P" [-3 -1 1  -3 -1 9  3 -1 9  3 -1 1] "integer indices" [0 1 2 0 2 3]
    Material "dielectric" "float roughness" 1e-38 "float eta" 1.0000001
    AttributeBegin Translate -0.6 -0.3 4 Shape "sphere" "float radius" 0.4 AttributeEnd
    Material "coateddiffuse" "float roughness" 1e-38 "float thickness" 1e30
    AttributeBegin Translate 0.3 -0.3 4 Shape "sphere" "float radius" 0.4 AttributeEnd
    Material "diffuse"
    Shape "trianglemesh" "point3 P" [-1e37 -2 90  0 1e37 90  1e37 -2 1e37] "integer indices" [0 1 2]"#;

#[test]
fn pictures_of_extreme_scenes_are_finite() {
    let folder = folder();
    let lens = root().join("lenses/dgauss.50mm.dat").display().to_string();
    let path = write(&folder, "scene.pbrt", EXTREME.replace("LENS", &lens));
    let aovs = [
        Aov::Depth,
        Aov::Position,
        Aov::Normal,
        Aov::Albedo,
        Aov::Coc,
        Aov::Samples,
        Aov::Variance,
        Aov::DualPixel,
    ];
    let effects: EffectSelection = "+ghosts,+fresnel,+diffraction".parse().expect("effects");
    for (sensor, until) in [
        (None, StopCriteria::default()),
        (Some(SensorSettings::default()), StopCriteria::default()),
        (None, StopCriteria { noise: Some(0.5), ..StopCriteria::default() }),
    ] {
        let changes = Changes {
            effects: effects.clone(),
            // Light paths find the brightest lamp without a sample that is too bright.
            light_paths: Some(false),
            samples: Some(16),
            layers: aovs.to_vec(),
            holds_layers: true,
            sensor,
            stop_criteria: until,
            ..Changes::default()
        };
        let description = pbrt::read(&path).expect("a scene");
        let job = prepare(description, &changes).expect("a job").job;
        let exposed = render(&job, RenderOptions { threads: 1, ..RenderOptions::default() })
            .expect("a render");
        assert!(exposed.film.dropped.count() > 0, "no sample is dropped");
        let film = exposed.film.picture(16);
        assert!(film.pixels.as_flattened().iter().all(|v| v.is_finite()));
        assert!(film.pixels.as_flattened().iter().any(|&v| v > 1e36));
        let picture = exposed.picture(&job);
        assert!(picture.pixels.as_flattened().iter().all(|v| v.is_finite()));
        // Half floats have a smaller range, for the negative lobes of the filter too.
        let file = folder.path().join("half.exr");
        let window = job.frame.window();
        let encoding = EncodingOptions { half: true, ..EncodingOptions::default() };
        film.write(
            &petzval_base::io::Outputs::without_inputs().claim(&file).unwrap(),
            window,
            encoding,
            &Notes::new(),
        )
        .expect("a file");
        let read = Picture::read(&file).expect("a picture of finite values");
        assert!(read.pixels.as_flattened().iter().all(|v| v.is_finite()));
        assert!(read.pixels.as_flattened().iter().any(|&v| v < -6e4));
        for layer in exposed.layers(&job) {
            for (channel, values) in &layer.channels {
                let name = format!("{}.{channel}", layer.name);
                assert!(values.iter().all(|v| v.is_finite()), "{name}");
            }
        }
    }
}
