//! Samples that are no numbers: left out, named, and never in a picture.

mod support;

use petzval::aov::{Aov, layers};
use petzval::image::{Encoding, Notes, Picture, Window};
use petzval::job::{Changes, prepare};
use petzval::plan::Wanted;
use petzval::render::{Backend, Until, render};
use petzval::scene::pbrt;
use petzval::sensor::Settings;
use support::kept::Studio;
use support::{folder, petzval, root, write};

/// A ball so bright that f32 cannot hold it at this sensitivity.
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

fn glare() -> Studio {
    let studio = Studio::new();
    std::fs::write(studio.path("scene.pbrt"), GLARE).expect("a scene");
    studio
}

/// What is said of samples that were left out: how many, and the commands that replay the first.
fn named(said: &str) -> (u64, Vec<String>) {
    let from = said.find("petzval: warning: ").expect("a warning");
    let mut lines = said[from..].lines();
    let warning = lines.next().expect("a line");
    assert!(warning.contains("samples were no numbers and were left out"), "{said}");
    let count = warning.split(' ').nth(2).and_then(|count| count.parse().ok()).expect("a count");
    let commands = lines.take_while(|line| line.starts_with("  petzval replay"));
    (count, commands.map(|line| line.trim().to_owned()).collect())
}

/// The same samples are named whoever takes them; the commands that are said show where they break.
#[test]
fn dropped_samples_are_named_and_can_be_replayed() {
    let studio = glare();
    let whole = named(&studio.done("render scene.pbrt --spp 4 -o a.exr --threads 1"));
    let (count, commands) = &whole;
    assert!(*count > 8 && commands.len() == 8, "{whole:?}");
    let scalar = "render scene.pbrt --spp 4 -o b.exr --threads 2 --backend scalar";
    assert_eq!(named(&studio.done(scalar)), whole);
    studio.done("render scene.pbrt --spp 4 -o 1.petzval --shard 1/2");
    studio.done("render scene.pbrt --spp 4 -o 2.petzval --shard 2/2");
    assert_eq!(named(&studio.done("merge 2.petzval 1.petzval -o c.exr")), whole);

    let names = |name: &str| {
        let attributes = studio.contents(name).attributes;
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
        let words: Vec<&str> = command.split(' ').skip(1).collect();
        let (code, answer, said) = petzval(&studio.path(""), &words);
        assert_eq!(code, 0, "{said}");
        assert!(answer.contains("<- no number") && answer.contains("is dropped"), "{answer}");
        assert!(answer.contains("the emission at surface"), "{answer}");
    }
}

/// Where tiles take as many samples as they need, each share of them has a seed of its own.
#[test]
fn samples_of_adaptive_renders_are_named_by_their_seeds() {
    let studio = glare();
    let said = studio.done("render scene.pbrt --spp 40 --noise 0.02 -o a.exr");
    let (count, commands) = named(&said);
    assert!(count > 8 && commands.iter().all(|line| line.contains("--sample-seed ")), "{said}");
    for command in commands {
        let words: Vec<&str> = command.split(' ').skip(1).collect();
        let (code, answer, said) = petzval(&studio.path(""), &words);
        assert_eq!(code, 0, "{said}");
        assert!(answer.contains("is dropped"), "{command}: {answer}");
    }
}

#[test]
fn what_cannot_be_replayed_is_refused() {
    let studio = glare();
    let refuses = |words: &str, expected: &str| studio.refuses(words, expected);
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

/// A way fits a terminal, and is one object for programs.
#[test]
fn a_way_is_told_to_people_and_to_programs() {
    let scene = root().join("scenes/atelier.pbrt");
    let lens = root().join("lenses/triplet.toml");
    let (scene, lens) = (scene.display().to_string(), lens.display().to_string());
    let mut words =
        vec!["replay", &scene, "--lens", &lens, "--effects", "+dispersion", "--pixel", "600,500"];
    words.extend(["--sample", "9", "--coating", "mgf2"]);
    let (code, text, said) = petzval(root(), &words);
    assert_eq!(code, 0, "{said}");
    assert!(text.lines().all(|line| line.chars().count() <= 100), "{text}");
    for part in ["band ", "nm of its ray", "sphere", "carries", "meets ", "radiance", "adds"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    words.push("--json");
    let (_, json, _) = petzval(root(), &words);
    let way: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    let number = |value: &serde_json::Value| value.as_f64().expect("a number");
    let adds = text.lines().find_map(|line| line.strip_prefix("adds ")).expect("a value");
    let adds: Vec<f64> = adds.split_whitespace().map(|v| v.parse().expect("a number")).collect();
    let value: Vec<f64> = way["value"].as_array().expect("a value").iter().map(number).collect();
    assert_eq!(adds, value);
    assert_eq!(way["shared"].as_array().map(Vec::len), Some(4));
    assert_eq!(way["lens"]["surfaces"].as_array().map(Vec::len), Some(6));
    assert!(way["first_not_finite"].is_null());
}

/// Lights and surfaces beyond what f32 can hold, through everything that makes a picture.
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
fn a_picture_holds_numbers_whatever_the_scene_holds() {
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
    ];
    let effects: Wanted = "+ghosts,+fresnel,+diffraction".parse().expect("effects");
    for (sensor, until) in [
        (None, Until::default()),
        (Some(Settings::default()), Until::default()),
        (None, Until { noise: Some(0.5), ..Until::default() }),
    ] {
        let changes = Changes {
            effects: effects.clone(),
            samples: Some(16),
            layers: aovs.to_vec(),
            holds_layers: true,
            sensor,
            until,
            ..Changes::default()
        };
        let description = pbrt::read(&path).expect("a scene");
        let (job, _, _) = prepare(description, &changes).expect("a job");
        let exposed = render(&job, Backend::Simd, 2, &Default::default()).expect("a render");
        assert!(exposed.film.dropped.count() > 0, "a scene that is not extreme shows nothing");
        let film = exposed.film.picture(16);
        assert!(film.pixels.as_flattened().iter().all(|v| v.is_finite()));
        assert!(film.pixels.as_flattened().iter().any(|&v| v > 1e36));
        let picture = exposed.picture(&job);
        assert!(picture.pixels.as_flattened().iter().all(|v| v.is_finite()));
        // Half as many bits hold less, below zero too, where the filter goes.
        let file = folder.path().join("half.exr");
        let window = Window { origin: job.frame.low, frame: job.frame.resolution };
        let encoding = Encoding { half: true, ..Encoding::default() };
        film.write(&file, window, encoding, &Notes::new()).expect("a file");
        let read = Picture::read(&file, true).expect("a picture of numbers");
        assert!(read.pixels.as_flattened().iter().all(|v| v.is_finite()));
        assert!(read.pixels.as_flattened().iter().any(|&v| v < -6e4));
        for layer in layers(&job, &exposed.film, exposed.features.as_ref()) {
            for (channel, values) in &layer.channels {
                let name = format!("{}.{channel}", layer.name);
                assert!(values.iter().all(|v| v.is_finite()), "{name}");
            }
        }
    }
}
