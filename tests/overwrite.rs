//! No command writes over a file that it reads.

mod support;

use std::fs;
use std::path::PathBuf;

use petzval::image::{Encoding, Picture, Window};
use support::kept::Studio;

/// Three quarters of a scene's kinds of files: texture, mesh, included file; the lens is the fourth.
const SCENE: &str = r#"
    Film "rgb" "integer xresolution" 24 "integer yresolution" 16 "float diagonal" 43.27
        "string filename" "wood.png"
    LookAt 0 0 0  0 0 1  0 1 0
    Camera "realistic" "string lensfile" "lens.dat" "float aperturediameter" 17.1
        "float focusdistance" 4.1
    Sampler "halton" "integer pixelsamples" 4
    WorldBegin
    LightSource "infinite" "rgb L" [0.2 0.25 0.3]
    Texture "wood" "spectrum" "imagemap" "string filename" "wood.png"
    Texture "other" "spectrum" "imagemap" "string filename" "a.partial.png"
    Texture "third" "spectrum" "imagemap" "string filename" "wood_4.png"
    Texture "fourth" "spectrum" "imagemap" "string filename" "report/plot.png"
    Material "diffuse" "texture reflectance" "wood"
    Include "floor.pbrt"
    Translate 0 0 3 Shape "plymesh" "string filename" "mesh.ply""#;

const MESH: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
                    property float z\nelement face 1\nproperty list uchar int vertex_indices\n\
                    end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

/// All files that commands of these tests read.
const INPUTS: [&str; 9] = [
    "scene.pbrt",
    "floor.pbrt",
    "lens.dat",
    "lens.svg",
    "mesh.ply",
    "wood.png",
    "a.partial.png",
    "wood_4.png",
    "report/plot.png",
];

/// A studio with a file of every kind that a scene reads.
fn studio() -> Studio {
    let studio = Studio::new();
    fs::create_dir(studio.path("report")).expect("a folder");
    fs::create_dir(studio.path("sub")).expect("a folder");
    fs::write(studio.path("scene.pbrt"), SCENE).expect("a scene");
    fs::write(studio.path("mesh.ply"), MESH).expect("a mesh");
    fs::copy(studio.path("lens.dat"), studio.path("lens.svg")).expect("a lens");
    let picture = Picture { size: [2, 2], pixels: vec![[0.5; 3]; 4] };
    let window = Window { origin: [0; 2], frame: [2; 2] };
    for name in INPUTS.into_iter().filter(|name| name.ends_with(".png")) {
        let written = picture.write(&studio.path(name), window, Encoding::default(), &Vec::new());
        written.expect("a texture");
    }
    studio
}

/// Runs a command that must refuse to write one name because it reads another, and must leave
/// every file as it was.
fn spares(studio: &Studio, words: &str, output: &str, input: &str) {
    let all = || {
        let mut files: Vec<PathBuf> = ["", "report", "sub"]
            .iter()
            .flat_map(|folder| fs::read_dir(studio.path(folder)).expect("a folder"))
            .map(|entry| entry.expect("an entry").path())
            .collect();
        files.sort();
        files.into_iter().map(|path| (fs::read(&path).ok(), path)).collect::<Vec<_>>()
    };
    let before = all();
    let expected = format!("cannot write {output}: it is the same file as {input}, an input");
    studio.refuses(words, &expected);
    assert!(before == all(), "{words}: a file has changed");
}

#[test]
fn a_picture_is_not_written_over_a_file_of_its_scene() {
    let studio = studio();
    spares(&studio, "render scene.pbrt --effects none", "wood.png", "wood.png");
    spares(
        &studio,
        "render scene.pbrt --effects none -o sub/../wood.png",
        "sub/../wood.png",
        "wood.png",
    );
    let whole = studio.path("wood.png").display().to_string();
    spares(&studio, &format!("render scene.pbrt --effects none -o {whole}"), &whole, "wood.png");
    spares(&studio, "render scene.pbrt --effects none -o a.png", "a.partial.png", "a.partial.png");
    spares(
        &studio,
        "render scene.pbrt --effects none -o a.png --checkpoint off",
        "a.partial.png",
        "a.partial.png",
    );
}

#[cfg(unix)]
#[test]
fn a_link_does_not_hide_that_it_is_an_input() {
    use std::os::unix::fs::symlink;
    let studio = studio();
    let part = "--shard 1/2 -o l.petzval";
    for (input, link, words) in [
        ("scene.pbrt", "l.exr", "-o l.exr"),
        ("floor.pbrt", "l.exr", "-o l.exr"),
        ("lens.dat", "l.png", "-o l.png"),
        ("mesh.ply", "l.jpg", "-o l.jpg"),
        ("wood.png", "l.petzval", part),
        ("scene.pbrt", "l.exr.checkpoint", "-o l.exr"),
        ("scene.pbrt", "l.exr.checkpoint", "-o l.exr --resume"),
        ("lens.dat", "l.petzval.checkpoint", part),
    ] {
        let words = format!("render scene.pbrt --effects none {words}");
        symlink(input, studio.path(link)).expect("a link");
        spares(&studio, &words, link, input);
        fs::remove_file(studio.path(link)).expect("the link");
        fs::hard_link(studio.path(input), studio.path(link)).expect("a link");
        spares(&studio, &words, link, input);
        fs::remove_file(studio.path(link)).expect("the link");
    }
}

#[test]
fn no_file_of_a_sweep_is_written_over_an_input() {
    let studio = studio();
    let sweep = "render scene.pbrt --effects none --sweep fstop=2.8,4";
    spares(&studio, &format!("{sweep} -o wood_{{fstop}}.png"), "wood_4.png", "wood_4.png");
    let contact = format!("{sweep} -o sub/{{fstop}}.png --contact");
    spares(&studio, &format!("{contact} wood.png"), "wood.png", "wood.png");
    let lens = "--lens sub/lens.csv";
    fs::rename(studio.path("lens.svg"), studio.path("sub/lens.csv")).expect("a lens");
    spares(&studio, &format!("{contact} sub/lens.png {lens}"), "sub/lens.csv", "sub/lens.csv");
}

#[test]
fn no_report_is_written_over_an_input() {
    let studio = studio();
    spares(&studio, "accuracy scene.pbrt --budget 5s", "report/plot.png", "report/plot.png");
}

#[test]
fn nothing_that_a_lens_shows_is_written_over_its_file() {
    let studio = studio();
    spares(&studio, "lens lens.svg --draw lens.svg", "lens.svg", "lens.svg");
    fs::copy(studio.path("lens.dat"), studio.path("lens.png")).expect("a lens");
    spares(&studio, "lens lens.png --psf ./lens.png", "./lens.png", "lens.png");
}

#[test]
fn a_map_of_differences_is_not_written_over_a_picture() {
    let studio = studio();
    let compare = "compare wood.png wood_4.png --map";
    spares(&studio, &format!("{compare} wood.png"), "wood.png", "wood.png");
    spares(&studio, &format!("{compare} sub/../wood_4.png"), "sub/../wood_4.png", "wood_4.png");
}

#[cfg(unix)]
#[test]
fn a_merged_picture_is_not_written_over_a_part_or_the_scene() {
    let studio = studio();
    for shard in [1, 2] {
        studio.done(&format!(
            "render scene.pbrt --effects none --shard {shard}/2 -o {shard}.petzval"
        ));
    }
    let merge = "merge 1.petzval 2.petzval -o";
    std::os::unix::fs::symlink("2.petzval", studio.path("l.exr")).expect("a link");
    spares(&studio, &format!("{merge} l.exr"), "l.exr", "2.petzval");
    spares(&studio, &format!("{merge} wood.png"), "wood.png", "wood.png");
    studio.done(&format!("{merge} merged.exr"));
}

#[test]
fn an_output_that_is_no_input_is_replaced() {
    let studio = studio();
    for name in ["a.exr", "map.png", "new.svg"] {
        // The same content is not the same file.
        fs::copy(studio.path("lens.dat"), studio.path(name)).expect("an old file");
    }
    studio.done("render scene.pbrt --effects none -o a.exr");
    studio.done("compare wood.png wood_4.png --map map.png");
    studio.done("lens lens.dat --draw new.svg");
    let lens = fs::read(studio.path("lens.dat")).expect("the lens");
    for name in ["a.exr", "map.png", "new.svg"] {
        assert_ne!(fs::read(studio.path(name)).expect("a new file"), lens, "{name}");
    }
}
