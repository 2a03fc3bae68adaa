//! Layers in files: parts, and the attributes of mattes.

use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, Text};
use petzval_base::io::ReadContext;
use petzval_image::{Picture, PictureLayers};

use crate::support::root;
use crate::support::workspace::Workspace;

const BALL: &str = "\nMakeNamedMaterial \"chalk, grün\" \"string type\" \"diffuse\"\nNamedMaterial \"chalk, grün\"\n\
                    Translate 0 0 -2 Shape \"sphere\" \"float radius\" 0.3\n";

#[test]
fn a_file_of_parts_holds_what_one_part_does() {
    let workspace = Workspace::new();
    let scene = std::fs::read_to_string(workspace.path("scene.pbrt")).expect("a scene") + BALL;
    std::fs::write(workspace.path("scene.pbrt"), scene).expect("a file");
    let render = "render scene.pbrt --spp 4 --resolution 24x16 --aov depth,alpha,cryptomatte";
    workspace.run_ok(&format!("{render} -o one.exr"));
    workspace.run_ok(&format!("{render} -o parts.exr --multipart"));
    let read = |name: &str| {
        let path = workspace.path(name);
        let layers = PictureLayers::read(&path, &ReadContext::default()).expect("layers");
        (Picture::read(&path).expect("a picture"), layers)
    };
    let ((one, mut layers), (picture, mut in_parts)) = (read("one.exr"), read("parts.exr"));
    assert_eq!(one, picture);
    for layers in [&mut layers, &mut in_parts] {
        layers.layers.sort_by(|a, b| a.name.cmp(&b.name));
    }
    assert_eq!(layers, in_parts);

    let headers =
        |name: &str| MetaData::read_from_file(workspace.path(name), true).expect("an EXR").headers;
    assert_eq!(headers("one.exr").len(), 1);
    let parts = headers("parts.exr");
    let names: Vec<String> = parts
        .iter()
        .map(|part| part.own_attributes.layer_name.as_ref().map(Text::to_string))
        .map(Option::unwrap_or_default)
        .collect();
    // The opacity is beside the colours.
    assert_eq!(names[..3], ["rgba", "depth", "CryptoObject00"]);
    assert_eq!(names.len(), 11);
    assert_eq!(parts[0].channels.list.len(), 4);
    let manifest = |part: usize| match parts[part]
        .own_attributes
        .other
        .get(&Text::from("cryptomatte/be359d6/manifest"))
    {
        Some(AttributeValue::Text(text)) => text.to_string(),
        other => panic!("{other:?}"),
    };
    // The first part and that of the materials have it. Names are ASCII, their hash is that of UTF-8.
    assert!(manifest(0).contains(r#""chalk, gr\u00fcn":""#), "{}", manifest(0));
    assert_eq!(manifest(0), manifest(5));
}

#[test]
fn parts_are_for_exr_alone() {
    let workspace = Workspace::new();
    let output = workspace
        .command("render scene.pbrt --spp 1 --resolution 24x16 -o one.png --multipart")
        .output()
        .expect("a command");
    let log = String::from_utf8_lossy(&output.stderr);
    assert!(log.contains("--multipart is for EXR; one.png has one part"), "{log}");
}

#[test]
fn mattes_of_gltf_have_the_names_of_nodes_and_materials() {
    let workspace = Workspace::new();
    let scene = root().join("scenes/boxes.gltf");
    let arguments = format!(
        "render {} --spp 1 --resolution 60x40 --aov cryptomatte -o boxes.exr",
        scene.display()
    );
    workspace.run_ok(&arguments);
    let path = workspace.path("boxes.exr");
    let header = MetaData::read_from_file(path, true).expect("an EXR").headers.swap_remove(0);
    let names = |key: &str| {
        let name = Text::from(&*format!("cryptomatte/{key}/manifest"));
        let Some(AttributeValue::Text(text)) = header.own_attributes.other.get(&name) else {
            panic!("no {key}")
        };
        let manifest: serde_json::Value = serde_json::from_str(&text.to_string()).expect("JSON");
        let names = manifest.as_object().expect("names").keys();
        names.cloned().collect::<Vec<String>>()
    };
    assert_eq!(names("3ae39a5"), ["floor", "left", "middle", "right"]);
    assert_eq!(names("be359d6"), ["brass", "floor", "painted steel", "red plastic"]);
}
