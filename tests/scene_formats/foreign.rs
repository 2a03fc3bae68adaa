//! Files that are not what a scene needs: placeholders of downloads, files of other programs, other
//! encodings.

use crate::support::{folder, petzval, write};
use petzval_scene_formats::pbrt;

const POINTER: &str = "version https://git-lfs.github.com/spec/v1\n\
                       oid sha256:4d7a214614ab2935c943f9e0ff69d22eadbb8f32b1258daaa5e2ca24d17e2393\n\
                       size 12345\n";
const PAGE: &str = "<!DOCTYPE html>\n<html><head><title>404</title></head></html>\n";

/// Returns the errors of a scene in a folder.
fn errors(folder: &tempfile::TempDir, text: &str) -> String {
    pbrt::read(&write(folder, "a.pbrt", text)).map(|_| ()).expect_err(text).to_string()
}

#[test]
fn a_placeholder_is_named_with_its_remedy_where_data_is_expected() {
    let folder = folder();
    for (content, expected) in [(POINTER, "git lfs pull"), (PAGE, "web page")] {
        for (name, world) in [
            ("a.png", "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"a.png\""),
            ("a.exr", "LightSource \"infinite\" \"string filename\" \"a.exr\""),
            ("a.pfm", "LightSource \"infinite\" \"string filename\" \"a.pfm\""),
            ("a.ply", "Shape \"plymesh\" \"string filename\" \"a.ply\""),
            ("part.pbrt", "Include \"part.pbrt\""),
            ("a.spd", "Material \"diffuse\" \"spectrum reflectance\" \"a.spd\""),
        ] {
            write(&folder, name, content);
            let found = errors(&folder, &format!("WorldBegin\n{world}\n"));
            assert!(found.contains(expected) && found.contains(name), "{found}");
            assert!(found.contains("a.pbrt:2:"), "the place that names it: {found}");
        }
        write(&folder, "own.csv", content);
        let film = errors(&folder, "Film \"rgb\"\n\"string sensor\" \"own.csv\"\nWorldBegin\n");
        assert!(film.contains(expected) && film.contains("a.pbrt:2:"), "{film}");
        write(&folder, "lens.dat", content);
        let scene = "Camera \"realistic\" \"string lensfile\" \"lens.dat\"\nWorldBegin\n";
        write(&folder, "lens.pbrt", scene);
        let (code, _, stderr) = petzval(folder.path(), &["plan", "lens.pbrt"]);
        assert!(code == 2 && stderr.contains(expected), "{stderr}");
        write(&folder, "whole.pbrt", content);
        let (code, _, stderr) = petzval(folder.path(), &["render", "whole.pbrt"]);
        assert!(code == 2 && stderr.contains(expected), "{stderr}");
    }
}

#[test]
fn a_file_of_another_program_is_named_once() {
    let folder = folder();
    for (content, expected) in [
        (&b"# Blender\nmtllib a.mtl\no Cube\nv 1 1 1\nv 1 1 2\n"[..], "an OBJ mesh"),
        (b"{\n \"asset\": { \"version\": \"2.0\" }\n}", "a glTF scene"),
        (b"glTF\x02\0\0\0\x10\0\0\0", "a glTF scene (GLB)"),
        (b"<?xml version=\"1.0\"?>\n<scene version=\"3.0.0\">\n</scene>", "Mitsuba"),
        (b"#usda 1.0\n", "a USD scene"),
        (b"BLENDER-v402RENDH", "a Blender file"),
        (b"ply\nformat ascii 1.0\n", "a PLY mesh"),
        (b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", "a picture (PNG)"),
        (b"\x05\0\0\0\x01\0\0\0", ".pbf"),
        (b"F\0i\0l\0m\0", "UTF-16; save it as UTF-8"),
        (b"\xff\xfeF\0i\0l\0m\0", "UTF-16; save it as UTF-8"),
    ] {
        write(&folder, "a.pbrt", content);
        let (code, _, stderr) = petzval(folder.path(), &["render", "a.pbrt"]);
        assert_eq!(code, 2, "{stderr}");
        assert!(stderr.contains(expected) && stderr.lines().count() == 1, "{expected}: {stderr}");
        assert!(stderr.starts_with("petzval: error: a.pbrt:1:1: "), "{stderr}");
        // Included, too.
        write(&folder, "part.pbrt", content);
        let found = errors(&folder, "WorldBegin\nInclude \"part.pbrt\"");
        assert!(found.contains(expected), "{found}");
    }
    let found = errors(&folder, "");
    assert!(
        found.contains("the file ends without WorldBegin: it is empty; expected a scene"),
        "{found}"
    );
}

#[test]
fn a_byte_order_mark_of_utf_8_is_skipped() {
    let folder = folder();
    let part = "\u{feff}Shape \"sphere\"";
    write(&folder, "part.pbrt", part);
    let text = "\u{feff}Camera \"perspective\"\nWorldBegin\nInclude \"part.pbrt\"";
    let scene = pbrt::read(&write(&folder, "a.pbrt", text)).expect("a scene").scene;
    assert_eq!(scene.shapes.len(), 1);
    let found = errors(&folder, "\u{feff}Camra \"perspective\"\nWorldBegin");
    assert!(found.contains("a.pbrt:1:1: ") && found.contains("| Camra \"persp"), "{found}");
    assert!(found.contains("\n      | ^^^^^\n") || found.ends_with("| ^^^^^"), "{found}");
}
