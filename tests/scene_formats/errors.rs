//! Errors of scene files: all of one run, each with its line, and none that follows from another.

use crate::support::world::{error, read};
use crate::support::{folder, petzval, root, write};
use petzval_scene_formats::pbrt::{SceneError, SceneErrors};

/// Returns the errors of the world part of a scene. Its first line is line 3.
fn errors(world: &str) -> SceneErrors {
    let text = format!("Camera \"perspective\"\nWorldBegin\n{world}");
    read(&text).map(|_| ()).expect_err(world)
}

/// Returns the line, the column and the message of each error.
fn found(world: &str) -> Vec<(u32, u32, String)> {
    let all = errors(world);
    let found = all.faults().iter().map(|fault| {
        let at = fault.error.location().expect("a location");
        let message = fault.to_string();
        let place = format!(":{}:{}: ", at.line, at.column);
        let (_, message) = message.split_once(&place).expect("its location");
        (at.line, at.column, message.to_owned())
    });
    found.collect()
}

/// Asserts the lines at which the errors of a world are.
fn assert_lines(world: &str, expected: &[u32]) {
    let found = found(world);
    let lines: Vec<u32> = found.iter().map(|(line, _, _)| *line).collect();
    assert_eq!(lines, expected, "{world}\n{found:#?}");
}

#[test]
fn one_run_reports_all_errors_with_their_lines() {
    let world = "Shape \"spere\" \"float radius\" 1\n\
                 Translate 1 2\n\
                 Shape \"sphere\" \"float radius\" [ 1 \"two\" ]\n\
                 Material \"diffuse\" \"rgb reflectanse\" [1 1 1]\n\
                 Shape \"sphere\"\n\
                 Shape \"sphere\" \"flot radius\" 1";
    let found = found(world);
    let places: Vec<(u32, u32)> = found.iter().map(|(line, column, _)| (*line, *column)).collect();
    assert_eq!(places, [(3, 1), (5, 1), (5, 35), (6, 20), (8, 16)], "{found:#?}");
    for ((_, _, message), expected) in found.iter().zip([
        "unknown Shape \"spere\"; did you mean \"sphere\"?",
        "found Shape; expected 3 numbers",
        "found \"two\"; expected a value for \"radius\"",
        "unknown parameter \"reflectanse\" of Material \"diffuse\"; did you mean",
        "unknown parameter type \"flot\"; did you mean \"float\"?",
    ]) {
        assert!(message.starts_with(expected), "{message}");
    }
}

#[test]
fn a_caret_stands_under_the_fault() {
    let message = errors("Shape \"sphere\" \"float radus\" 1").to_string();
    let lines: Vec<&str> = message.lines().skip(1).collect();
    let expected =
        ["    3 | Shape \"sphere\" \"float radus\" 1", "      |                ^^^^^^^^^^^^^"];
    assert_eq!(lines, expected, "{message}");
}

#[test]
fn uses_of_a_definition_that_failed_are_not_errors() {
    assert_lines(
        "MakeNamedMaterial \"m\" \"string type\" \"diffuze\"\nNamedMaterial \"m\"\n\
         MakeNamedMaterial \"x\" \"string type\" \"mix\" \"string materials\" [\"m\" \"m\"]",
        &[3],
    );
    assert_lines(
        "Texture \"t\" \"spectrum\" \"imagmap\"\n\
         Material \"diffuse\" \"texture reflectance\" \"t\"\n\
         Texture \"u\" \"spectrum\" \"scale\" \"texture tex\" \"t\" \"float scale\" 2\n\
         Material \"diffuse\" \"texture reflectance\" \"u\"",
        &[3],
    );
    assert_lines("ObjectBegin 3\n\"o\"\nObjectEnd\nObjectInstance \"o\"", &[3, 5]);
    assert_lines("CoordinateSistem \"c\"\nCoordSysTransform \"c\"", &[3]);
    assert_lines("Include \"none.pbrt\"\nNamedMaterial \"m\"\nObjectInstance \"o\"", &[3]);
    // Others are.
    assert_lines("Texture \"t\" \"spectrum\" \"imagmap\"\nNamedMaterial \"m\"", &[3, 4]);
}

#[test]
fn each_undefined_name_is_an_error() {
    assert_lines(
        "NamedMaterial \"b\"\nNamedMaterial \"a\"\nNamedMaterial \"b\"\n\
         Material \"diffuse\" \"texture reflectance\" \"t\"\n\
         Shape \"sphere\" \"texture alpha\" \"u\"\nObjectInstance \"o\"",
        &[3, 4, 6, 7, 8],
    );
}

#[test]
fn a_misspelt_directive_opens_and_closes_blocks() {
    assert_lines("AtributeBegin\nTranslate 1 2 3\nAttributeEnd\nShape \"spere\"", &[3, 6]);
    assert_lines("AttributeBegin\nTranslate 1 2 3\nAttributEnd\nShape \"sphere\"", &[5]);
    // The rest of the mistake is skipped, whatever it is.
    assert_lines("Shapes \"sphere\" \"flot radius\" [ 1 ]\nShape \"sphere\"", &[3]);
    assert_lines("Nonsense \"a\" [ 1 2 ] \"b\" true\nShape \"sphere\"", &[3]);
}

#[test]
fn one_misplaced_end_is_one_error() {
    assert_lines("AttributeBegin\nTransformBegin\nAttributeEnd\nShape \"sphere\"", &[5]);
    assert_lines("AttributeBegin\nTransformEnd\nAttributeEnd\nShape \"sphere\"", &[4]);
    assert_lines("AttributeBegin\nTransformEnd\nShape \"sphere\"", &[4]);
    assert_lines("ObjectBegin \"o\"\nObjectBegin \"p\"\nObjectEnd\nObjectEnd", &[4]);
    let all = errors("AttributeEnd\nAttributeEnd\nAttributeEnd");
    let [fault] = all.faults() else { panic!("{all}") };
    assert_eq!(fault.more, 2);
    assert!(fault.to_string().ends_with("AttributeBegin; remove it (and 2 more like this)"));
}

#[test]
fn directives_before_the_world_are_one_error() {
    let text = "Shape \"sphere\"\nMaterial \"diffuse\"\nShape \"disk\"";
    let all = read(text).map(|_| ()).expect_err(text);
    let messages: Vec<String> = all.faults().iter().map(ToString::to_string).collect();
    assert_eq!(messages.len(), 2, "{messages:#?}");
    assert!(messages[0].contains(":1:1: Shape before WorldBegin"), "{messages:#?}");
    assert!(messages[1].contains(":3:13: the file ends without WorldBegin"), "{messages:#?}");
}

#[test]
fn the_errors_of_the_camera_and_the_film_are_found_too() {
    let text = "Film \"rgb\" \"integer xresolution\" 0\nCamera \"perspective\" \"float fov\" 270\n\
                Sampler \"halton\" \"integer pixelsamples\" 0.5\nWorldBegin\nShape \"spere\"";
    let all = read(text).map(|_| ()).expect_err(text);
    let lines: Vec<_> =
        all.faults().iter().map(|fault| fault.error.location().expect("it").line).collect();
    assert_eq!(lines, [1, 2, 3, 5], "{all}");
}

#[test]
fn twenty_errors_are_enough() {
    let world: String = (0..1000).map(|i| format!("Shape \"kind{i}\"\n")).collect();
    let all = errors(&world);
    assert_eq!(all.faults().len(), 20);
    assert!(all.is_incomplete());
    let folder = folder();
    write(&folder, "a.pbrt", format!("WorldBegin\n{world}"));
    let (code, _, stderr) = petzval(folder.path(), &["render", "a.pbrt"]);
    assert_eq!(code, 2);
    assert_eq!(stderr.matches("petzval: error: a.pbrt:").count(), 20, "{stderr}");
    assert!(stderr.ends_with("stopped after 20 errors; there may be more\n"), "{stderr}");
    assert!(!stderr.contains('\u{1b}'), "colours in a pipe: {stderr:?}");
}

#[test]
fn an_error_that_makes_the_rest_meaningless_is_the_last() {
    let all = errors("Shape \"spere\"\nIdentity\n\u{1}\u{2} Shape \"spere2\"");
    assert!(matches!(all.faults()[1].error, SceneError::NotText { .. }), "{all}");
    assert_eq!(all.faults().len(), 2, "{all}");
    // Files that include each other twice would be read 2^32 times.
    let folder = folder();
    let text = "Include \"a.pbrt\"\nInclude \"a.pbrt\"\n";
    let all = petzval_scene_formats::pbrt::read(&write(&folder, "a.pbrt", text));
    let all = all.map(|_| ()).expect_err("a circle");
    let [fault] = all.faults() else { panic!("{all}") };
    assert!(matches!(fault.error, SceneError::Limit { .. }), "{all}");
}

#[test]
fn errors_of_included_files_show_their_own_lines() {
    let folder = folder();
    write(
        &folder,
        "part.pbrt",
        "\nShape \"spere\"\nMaterial \"diffuse\" \"texture reflectance\" \"t\"",
    );
    let text = "WorldBegin\nInclude \"part.pbrt\"\nShape \"disc\"";
    write(&folder, "a.pbrt", text);
    let (code, _, stderr) = petzval(folder.path(), &["render", "a.pbrt"]);
    assert_eq!(code, 2, "{stderr}");
    let lines: Vec<&str> = stderr.lines().collect();
    assert!(lines[0].starts_with("petzval: error: part.pbrt:2:1: unknown Shape"), "{stderr}");
    assert_eq!(lines[1], "    2 | Shape \"spere\"", "{stderr}");
    // The file has been closed when this error is found.
    assert!(lines[3].starts_with("petzval: error: part.pbrt:3:20: no texture \"t\""), "{stderr}");
    assert_eq!(lines[4], "    3 | Material \"diffuse\" \"texture reflectance\" \"t\"");
    assert!(lines[6].starts_with("petzval: error: a.pbrt:3:1: unknown Shape"), "{stderr}");
}

#[test]
fn every_missing_file_is_named() {
    let image = |name: &str| {
        format!("Texture \"{name}\" \"spectrum\" \"imagemap\" \"string filename\" \"{name}\"")
    };
    assert_lines(
        &format!(
            "{}\n{}\nShape \"plymesh\" \"string filename\" \"c.ply\"",
            image("a.png"),
            image("b.png")
        ),
        &[3, 4, 5],
    );
}

#[test]
fn a_camera_and_a_lens_that_cannot_be_used_show_their_line_of_the_scene() {
    let folder = folder();
    let text =
        "Camera \"realistic\" \"string lensfile\" \"none.dat\"\nWorldBegin\nShape \"sphere\"";
    write(&folder, "a.pbrt", text);
    let (code, _, stderr) = petzval(folder.path(), &["render", "a.pbrt"]);
    assert_eq!(code, 2, "{stderr}");
    let lines: Vec<&str> = stderr.lines().collect();
    assert!(lines[0].starts_with("petzval: error: a.pbrt:1:20: cannot read the lens"), "{stderr}");
    assert_eq!(lines[1], "    1 | Camera \"realistic\" \"string lensfile\" \"none.dat\"");
    assert_eq!(lines[2], "      |                    ^^^^^^^^^^^^^^^^^");
}

#[test]
fn an_unknown_name_comes_with_a_suggestion_or_with_what_is_expected() {
    for (world, expected) in [
        ("NamedMaterial \"red\"", "expected a name that MakeNamedMaterial defines"),
        ("ObjectInstance \"car\"", "expected a name that ObjectBegin defines before"),
        ("CoordSysTransform \"eye\"", "expected a name that CoordinateSystem defines"),
        (
            "Shape \"sphere\" \"texture alpha\" \"holes\"",
            "expected a name that Texture defines with type float",
        ),
        ("Shape \"sphere\" \"number radius\" 1", "expected one of integer, float, point2"),
        ("Option \"bool quick\" true", "known are rendercoordsys, "),
        ("CoordSysTransform \"wrold\"", "did you mean \"world\"?"),
    ] {
        let message = &found(world)[0].2;
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn a_mesh_that_cannot_be_displaced_and_a_filter_without_a_width_say_why() {
    let folder = folder();
    let plain = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
                 property float z\nelement face 1\nproperty list uchar int vertex_indices\n\
                 end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    let plain = write(&folder, "plain.ply", plain);
    let sheet = root().join("tests/pbrt_language/sheet.ply");
    let texture = "Texture \"h\" \"float\" \"bilerp\"\n";
    let mesh = |path: &std::path::Path, more: &str| {
        let name = path.display();
        format!(
            "Shape \"plymesh\" \"string filename\" \"{name}\" \"texture displacement\" \"h\" {more}\n"
        )
    };
    for (world, expected) in [
        (format!("{texture}{}", mesh(&plain, "")), "without texture coordinates"),
        (format!("{}{texture}", mesh(&sheet, "")), "define it before this Shape"),
        (
            format!("{texture}{}", mesh(&sheet, "\"float edgelength\" 0")),
            "\"edgelength\" is 0; expected more than 0",
        ),
        (
            "Texture \"t\" \"float\" \"imagemap\" \"string filename\" \"a.png\" \"string filter\" \"EWA\" \
             \"float maxanisotropy\" 0.5"
                .to_owned(),
            "a ratio of 0.5; expected 1 to 1024",
        ),
    ] {
        let message = error(&world);
        assert!(message.contains(expected), "{world}: {message}");
    }
}
