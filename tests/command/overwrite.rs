//! Commands refuse to overwrite files that they read.

use std::fs;
use std::path::PathBuf;

use crate::support::workspace::{CAMERA, Workspace};
use crate::support::write_picture;
use petzval_image::Picture;

/// Names a file of each kind that a scene reads: textures, a mesh, an included file, a sensor.
const SCENE: &str = r#"
    Film "rgb" "integer xresolution" 24 "integer yresolution" 16 "float diagonal" 43.27
        "string filename" "wood.png" "string sensor" "camera.csv"
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

const SENSOR: &str = "400 0 0.1 0.8\n500 0.1 0.9 0.2\n600 1 0.3 0\n";

/// All files that the commands of these tests read.
const INPUTS: [&str; 10] = [
    "scene.pbrt",
    "camera.csv",
    "floor.pbrt",
    "lens.dat",
    "lens.svg",
    "mesh.ply",
    "wood.png",
    "a.partial.png",
    "wood_4.png",
    "report/plot.png",
];

/// Creates a workspace with a file of each kind that a scene reads.
fn workspace() -> Workspace {
    let workspace = Workspace::new();
    fs::create_dir(workspace.path("report")).expect("a folder");
    fs::create_dir(workspace.path("sub")).expect("a folder");
    fs::write(workspace.path("scene.pbrt"), format!("{CAMERA}{SCENE}")).expect("a scene");
    fs::write(workspace.path("mesh.ply"), MESH).expect("a mesh");
    fs::write(workspace.path("camera.csv"), SENSOR).expect("a sensor");
    fs::copy(workspace.path("lens.dat"), workspace.path("lens.svg")).expect("a lens");
    let picture = Picture { size: [2, 2], pixels: vec![[0.5; 3]; 4] };
    for name in INPUTS.into_iter().filter(|name| name.ends_with(".png")) {
        write_picture(&picture, workspace.path(name));
    }
    workspace
}

/// Asserts that a command refuses to write `output`, because it reads the file as `input`, and changes
/// no file.
fn refuses_to_overwrite(workspace: &Workspace, arguments: &str, output: &str, input: &str) {
    let all = || {
        let mut files: Vec<PathBuf> = ["", "report", "sub"]
            .iter()
            .flat_map(|folder| fs::read_dir(workspace.path(folder)).expect("a folder"))
            .map(|entry| entry.expect("an entry").path())
            .collect();
        files.sort();
        files.into_iter().map(|path| (fs::read(&path).ok(), path)).collect::<Vec<_>>()
    };
    let before = all();
    let expected = format!("cannot write {output}: it is the same file as {input}, an input");
    workspace.refuses(arguments, &expected);
    assert!(before == all(), "{arguments}: a file has changed");
}

#[test]
fn a_picture_is_not_written_over_a_file_of_its_scene() {
    let workspace = workspace();
    refuses_to_overwrite(&workspace, "render scene.pbrt --effects none", "wood.png", "wood.png");
    refuses_to_overwrite(
        &workspace,
        "render scene.pbrt --effects none -o sub/../wood.png",
        "sub/../wood.png",
        "wood.png",
    );
    let whole = workspace.path("wood.png").display().to_string();
    refuses_to_overwrite(
        &workspace,
        &format!("render scene.pbrt --effects none -o {whole}"),
        &whole,
        "wood.png",
    );
    refuses_to_overwrite(
        &workspace,
        "render scene.pbrt --effects none -o a.png",
        "a.partial.png",
        "a.partial.png",
    );
    refuses_to_overwrite(
        &workspace,
        "render scene.pbrt --effects none -o a.png --checkpoint off",
        "a.partial.png",
        "a.partial.png",
    );
}

#[cfg(unix)]
#[test]
fn an_input_is_recognised_behind_a_link() {
    use std::os::unix::fs::symlink;
    let workspace = workspace();
    let part = "--shard 1/2 -o l.petzval";
    for (input, link, arguments) in [
        ("scene.pbrt", "l.exr", "-o l.exr"),
        ("floor.pbrt", "l.exr", "-o l.exr"),
        ("lens.dat", "l.png", "-o l.png"),
        ("mesh.ply", "l.jpg", "-o l.jpg"),
        ("camera.csv", "l.exr", "-o l.exr"),
        ("wood.png", "l.petzval", part),
        ("scene.pbrt", "l.exr.checkpoint", "-o l.exr"),
        ("scene.pbrt", "l.exr.checkpoint", "-o l.exr --resume"),
        ("lens.dat", "l.petzval.checkpoint", part),
    ] {
        let arguments = format!("render scene.pbrt --effects none {arguments}");
        symlink(input, workspace.path(link)).expect("a link");
        refuses_to_overwrite(&workspace, &arguments, link, input);
        fs::remove_file(workspace.path(link)).expect("the link");
        fs::hard_link(workspace.path(input), workspace.path(link)).expect("a link");
        refuses_to_overwrite(&workspace, &arguments, link, input);
        fs::remove_file(workspace.path(link)).expect("the link");
    }
}

#[test]
fn no_file_of_a_sweep_is_written_over_an_input() {
    let workspace = workspace();
    let sweep = "render scene.pbrt --effects none --sweep fstop=2.8,4";
    refuses_to_overwrite(
        &workspace,
        &format!("{sweep} -o wood_{{fstop}}.png"),
        "wood_4.png",
        "wood_4.png",
    );
    let contact = format!("{sweep} -o sub/{{fstop}}.png --contact");
    refuses_to_overwrite(&workspace, &format!("{contact} wood.png"), "wood.png", "wood.png");
    let lens = "--lens sub/lens.csv";
    fs::rename(workspace.path("lens.svg"), workspace.path("sub/lens.csv")).expect("a lens");
    refuses_to_overwrite(
        &workspace,
        &format!("{contact} sub/lens.png {lens}"),
        "sub/lens.csv",
        "sub/lens.csv",
    );
}

#[test]
fn no_report_is_written_over_an_input() {
    let workspace = workspace();
    refuses_to_overwrite(
        &workspace,
        "accuracy scene.pbrt --budget 5s",
        "report/plot.png",
        "report/plot.png",
    );
}

#[test]
fn no_output_of_the_lens_command_is_written_over_its_file() {
    let workspace = workspace();
    refuses_to_overwrite(&workspace, "lens lens.svg --draw lens.svg", "lens.svg", "lens.svg");
    fs::copy(workspace.path("lens.dat"), workspace.path("lens.png")).expect("a lens");
    refuses_to_overwrite(&workspace, "lens lens.png --psf ./lens.png", "./lens.png", "lens.png");
}

#[test]
fn no_file_of_a_lens_report_is_written_over_its_inputs() {
    let workspace = workspace();
    fs::remove_dir_all(workspace.path("report")).expect("the folder");
    fs::create_dir(workspace.path("report")).expect("a folder");
    let report = "lens report --field-count 2 --pupil-grid 8";
    for name in ["report.json", "prescription.csv", "mtf.csv", "index.html", "distortion-curve.svg"]
    {
        let path = format!("report/{name}");
        if name.ends_with(".csv") {
            fs::copy(workspace.path("lens.dat"), workspace.path(&path)).expect("a lens");
            refuses_to_overwrite(&workspace, &format!("{report} {path} -o report"), &path, &path);
            fs::remove_file(workspace.path(&path)).expect("the lens");
        }
        fs::hard_link(workspace.path("lens.dat"), workspace.path(&path)).expect("a link");
        refuses_to_overwrite(
            &workspace,
            &format!("{report} lens.dat -o report"),
            &path,
            "lens.dat",
        );
        fs::remove_file(workspace.path(&path)).expect("the link");
        // A catalogue of which no glass is needed, under another name.
        fs::hard_link(workspace.path("mesh.ply"), workspace.path(&path)).expect("a link");
        let catalogue = format!("{report} lens.dat --catalogue mesh.ply -o report");
        refuses_to_overwrite(&workspace, &catalogue, &path, "mesh.ply");
        fs::remove_file(workspace.path(&path)).expect("the link");
    }
    workspace.run_ok(&format!("{report} lens.dat -o report"));
}

#[test]
fn two_outputs_are_two_files() {
    let workspace = workspace();
    let tolerance = "lens tolerance lens.dat --trials 1";
    for (csv, output) in [("x.toml", "x.toml"), ("x.toml", "sub/../x.toml"), ("./x.toml", "x.toml")]
    {
        let expected =
            format!("cannot write {output}: it is the same file as {csv}, another output");
        workspace.refuses(&format!("{tolerance} --csv {csv} -o {output}"), &expected);
    }
    let sweep = "render scene.pbrt --effects none --sweep fstop=2.8,4 -o {fstop}.png --contact";
    workspace.refuses(&format!("{sweep} sub/../4.png"), "another output");
    assert!(!workspace.path("x.toml").exists() && !workspace.path("4.png").exists());
}

#[test]
fn no_file_of_a_data_set_is_written_over_an_input_of_any_pair() {
    let workspace = workspace();
    let spec = |lens: &str, scenes: &str| {
        let spec = format!(
            "pairs = 8\nresolution = [16, 12]\nspp = 1\npsf = true\n[draw]\nscene = {scenes}\n\
             lens = \"{lens}\"\n[degraded]\nsensor = \"\"\n"
        );
        fs::write(workspace.path("spec.toml"), spec).expect("a specification");
    };
    let one = "\"scene.pbrt\"";
    for name in ["000000.psf.npy", "000003.clean.exr", "000007.raw.exr", "manifest.jsonl"] {
        let path = format!("sub/{name}");
        fs::copy(workspace.path("lens.dat"), workspace.path(&path)).expect("a lens");
        spec(&path, one);
        let (code, stderr) = workspace.run("dataset spec.toml -o sub");
        assert!(code == 2 && stderr.contains("an input"), "{name}: {stderr}");
        let [lens, kept] = ["lens.dat", &path].map(|path| fs::read(workspace.path(path)).ok());
        assert_eq!(lens, kept, "{name}");
        fs::remove_dir_all(workspace.path("sub")).expect("the folder");
        fs::create_dir(workspace.path("sub")).expect("a folder");
    }
    // A texture of one scene, whose name is that of a picture of the other, wherever it is drawn.
    fs::copy(workspace.path("wood.png"), workspace.path("sub/000000.clean.exr"))
        .expect("a texture");
    let scene = fs::read_to_string(workspace.path("scene.pbrt")).expect("the scene");
    let exr = workspace.path("sub/000000.clean.exr");
    write_picture(&Picture { size: [2, 2], pixels: vec![[0.5; 3]; 4] }, &exr);
    let texture = fs::read(&exr).expect("the texture");
    let other = scene.replacen("wood.png\"\n        Material", "wood.png\"\n Material", 1);
    let other = other.replace("\"report/plot.png\"", "\"sub/000000.clean.exr\"");
    let other =
        other.replace("\"texture reflectance\" \"wood\"", "\"texture reflectance\" \"fourth\"");
    fs::write(workspace.path("other.pbrt"), other).expect("a scene");
    spec("lens.dat", "[\"scene.pbrt\", \"other.pbrt\"]");
    let (code, stderr) = workspace.run("dataset spec.toml -o sub");
    assert!(code == 2 && stderr.contains("an input"), "{stderr}");
    assert_eq!(fs::read(&exr).expect("the texture"), texture);
    let left: Vec<_> = fs::read_dir(workspace.path("sub")).expect("a folder").collect();
    assert_eq!(left.len(), 1, "no empty manifest is left: {left:?}");
}

#[test]
fn a_map_of_differences_is_not_written_over_a_picture() {
    let workspace = workspace();
    let compare = "compare wood.png wood_4.png --map";
    refuses_to_overwrite(&workspace, &format!("{compare} wood.png"), "wood.png", "wood.png");
    refuses_to_overwrite(
        &workspace,
        &format!("{compare} sub/../wood_4.png"),
        "sub/../wood_4.png",
        "wood_4.png",
    );
}

#[cfg(unix)]
#[test]
fn a_merged_picture_is_not_written_over_a_part_or_the_scene() {
    let workspace = workspace();
    for shard in [1, 2] {
        workspace.run_ok(&format!(
            "render scene.pbrt --effects none --shard {shard}/2 -o {shard}.petzval"
        ));
    }
    let merge = "merge 1.petzval 2.petzval -o";
    std::os::unix::fs::symlink("2.petzval", workspace.path("l.exr")).expect("a link");
    refuses_to_overwrite(&workspace, &format!("{merge} l.exr"), "l.exr", "2.petzval");
    refuses_to_overwrite(&workspace, &format!("{merge} wood.png"), "wood.png", "wood.png");
    workspace.run_ok(&format!("{merge} merged.exr"));
}

#[test]
fn an_output_that_is_not_an_input_is_replaced() {
    let workspace = workspace();
    for name in ["a.exr", "map.png", "new.svg"] {
        // A file with the content of an input is not that input.
        fs::copy(workspace.path("lens.dat"), workspace.path(name)).expect("an old file");
    }
    workspace.run_ok("render scene.pbrt --effects none -o a.exr");
    workspace.run_ok("compare wood.png wood_4.png --map map.png");
    workspace.run_ok("lens lens.dat --draw new.svg");
    let lens = fs::read(workspace.path("lens.dat")).expect("the lens");
    for name in ["a.exr", "map.png", "new.svg"] {
        assert_ne!(fs::read(workspace.path(name)).expect("a new file"), lens, "{name}");
    }
}
