//! Textures and colours of scene files, and their errors.

use std::path::Path;

use glam::Vec3;
use petzval_scene::{MaterialModel, Texture, TexturePoint};
use petzval_scene_formats::pbrt;

/// Reads a scene in a folder and returns the reflectance of its last material, or the error.
fn reflectance(folder: &Path, world: &str) -> Result<Texture, String> {
    let path = folder.join("test.pbrt");
    std::fs::write(&path, format!("Camera \"perspective\"\nWorldBegin\n{world}")).unwrap();
    let scene = pbrt::read(&path).map_err(|error| error.to_string())?.scene;
    match &scene.materials.last().unwrap().model {
        MaterialModel::Diffuse { reflectance } => Ok(reflectance.clone()),
        other => panic!("{other:?}"),
    }
}

fn colour(folder: &Path, textures: &str, at: TexturePoint) -> [f32; 3] {
    let world = format!("{textures}\nMaterial \"diffuse\" \"texture reflectance\" \"t\"");
    reflectance(folder, &world).unwrap().colour(&at)
}

fn folder_with_pictures() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    // A code of 51 is a fifth of the range.
    let rgb = image::RgbImage::from_pixel(4, 2, image::Rgb([51, 102, 255]));
    rgb.save(folder.path().join("rgb.png")).unwrap();
    rgb.save(folder.path().join("rgb.tga")).unwrap();
    let rgba = image::RgbaImage::from_pixel(2, 2, image::Rgba([51, 51, 51, 102]));
    rgba.save(folder.path().join("rgba.png")).unwrap();
    folder
}

fn assert_near(found: [f32; 3], expected: [f32; 3]) {
    let off = (0..3).map(|i| (found[i] - expected[i]).abs()).fold(0.0, f32::max);
    assert!(off < 1e-5, "{found:?}, expected {expected:?}");
}

#[test]
fn pictures_are_decoded_as_their_encoding_says() {
    let folder = folder_with_pictures();
    let of = |file: &str, more: &str| {
        let texture = format!(
            "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"{file}\" {more}"
        );
        colour(folder.path(), &texture, TexturePoint::default())
    };
    // 0.2 and 0.4 decoded by IEC 61966-2-1.
    let srgb = [0.033_104_77, 0.132_868_32, 1.0];
    assert_near(of("rgb.png", ""), srgb);
    assert_near(of("rgb.png", "\"string encoding\" \"linear\""), [0.2, 0.4, 1.0]);
    assert_near(of("rgb.png", "\"string encoding\" \"gamma 2\""), [0.04, 0.16, 1.0]);
    assert_near(of("rgb.tga", "\"string encoding\" \"linear\""), srgb);
    assert_near(
        of("rgb.png", "\"string encoding\" \"linear\" \"float scale\" 0.5"),
        [0.1, 0.2, 0.5],
    );
    let inverted = "\"string encoding\" \"linear\" \"float scale\" 2 \"bool invert\" true";
    assert_near(of("rgb.png", inverted), [0.6, 0.2, 0.0]);
}

#[test]
fn float_textures_have_their_own_names_and_use_alpha_or_the_mean() {
    let folder = folder_with_pictures();
    let mixed = |file: &str| {
        let text = format!(
            "Texture \"t\" \"float\" \"imagemap\" \"string filename\" \"{file}\" \
             \"string encoding\" \"linear\"\n\
             Texture \"t\" \"spectrum\" \"mix\" \"rgb tex1\" [0 0 0] \"rgb tex2\" [1 0.5 0] \
             \"texture amount\" \"t\""
        );
        colour(folder.path(), &text, TexturePoint::default())
    };
    assert_near(mixed("rgba.png"), [0.4, 0.2, 0.0]);
    assert_near(mixed("rgb.png"), [1.6 / 3.0, 0.8 / 3.0, 0.0]);
    let message = reflectance(
        folder.path(),
        "Texture \"t\" \"float\" \"constant\"\nMaterial \"diffuse\" \"texture reflectance\" \"t\"",
    );
    let message = message.unwrap_err();
    assert!(message.contains("test.pbrt:4:20: \"t\" is a texture of type float"), "{message}");
}

#[test]
fn texture_space_is_that_of_the_texture_directive() {
    let folder = tempfile::tempdir().unwrap();
    let text = "AttributeBegin Translate 10 0 0 Scale 2 2 2\n\
        Texture \"t\" \"spectrum\" \"checkerboard\" \"integer dimension\" 3\n\
        \"rgb tex1\" [1 1 1] \"rgb tex2\" [0 0 0]\nAttributeEnd";
    let at = |x: f32| {
        let position = Vec3::new(x, 1.0, 1.0);
        let at = TexturePoint { position: position.to_array(), ..TexturePoint::default() };
        colour(folder.path(), text, at)[0]
    };
    assert_eq!([at(11.0), at(13.0), at(9.0)], [1.0, 0.0, 0.0]);
    let planar = "Translate 0 0 5\nTexture \"t\" \"spectrum\" \"bilerp\" \"string mapping\" \"planar\" \
        \"vector3 v1\" [0 0 0.25] \"float udelta\" 0.5 \"rgb v00\" [0 0 0] \"rgb v10\" [1 0 0] \
        \"rgb v01\" [0 1 0] \"rgb v11\" [1 1 0]";
    let position = Vec3::new(0.0, 0.125, 6.0);
    let at = TexturePoint { position: position.to_array(), ..TexturePoint::default() };
    assert_near(colour(folder.path(), planar, at), [0.75, 0.125, 0.0]);
}

#[test]
fn dots_have_the_texture_outside_as_in_pbrt() {
    let folder = tempfile::tempdir().unwrap();
    let texture = |more: &str| {
        format!(
            "Texture \"t\" \"spectrum\" \"dots\" \"rgb inside\" [0.1 0.2 0.3] \"rgb outside\" [0.9 0.8 0.7] \
             {more}"
        )
    };
    // The middles of two dots and of two squares without one, in pbrt-v4.
    let at = |u: f32, v: f32| TexturePoint { uv: [u, v], ..TexturePoint::default() };
    let of = |more: &str, at: TexturePoint| colour(folder.path(), &texture(more), at);
    for (u, v) in [(0.12, -2.7), (-2.87, -2.33)] {
        assert_near(of("", at(u, v)), [0.9, 0.8, 0.7]);
        let scaled = "\"float uscale\" 0.5 \"float vscale\" 2 \"float udelta\" 1";
        assert_near(of(scaled, at(2.0 * (u - 1.0), v / 2.0)), [0.9, 0.8, 0.7]);
    }
    for (u, v) in [(-3.1, -2.7), (0.0, -1.6)] {
        assert_near(of("", at(u, v)), [0.1, 0.2, 0.3]);
    }
}

#[test]
fn solid_textures_have_pbrts_values_in_the_space_of_their_directive() {
    let folder = tempfile::tempdir().unwrap();
    let place = "Translate 5 -1 2 Scale 2 2 2";
    // The point (0.3, 0.6, 0.1) of texture space, and steps there, for which the values are those
    // that pbrt-v4 prints.
    let at = TexturePoint {
        position: [5.6, 0.2, 2.2],
        position_steps: [[0.02, 0.006, 0.0], [0.0, 0.04, 0.01]],
        ..TexturePoint::default()
    };
    let marble =
        "\"float scale\" 2.5 \"float variation\" 1.5 \"integer octaves\" 6 \"float roughness\" 0.7";
    for (kind, value_type, more, expected) in [
        ("fbm", "float", "\"float roughness\" 0.6", [0.215_939_28; 3]),
        ("wrinkled", "float", "\"float roughness\" 0.6", [0.495_548_58; 3]),
        ("windy", "float", "", [0.008_712_111; 3]),
        // As in pbrt-v3, scalar patterns are grey where colours are expected.
        ("fbm", "spectrum", "\"float roughness\" 0.6", [0.215_939_28; 3]),
        ("marble", "spectrum", marble, [0.620_661_74, 0.620_661_74, 0.722_838_64]),
    ] {
        let textures = format!(
            "AttributeBegin {place} Texture \"s\" \"{value_type}\" \"{kind}\" {more} AttributeEnd\n"
        );
        let textures = match value_type {
            // An operand that leaves a float texture as a colour.
            "float" => format!(
                "{textures} Texture \"t\" \"spectrum\" \"mix\" \"rgb tex1\" [0 0 0] \
                 \"rgb tex2\" [1 1 1] \"texture amount\" \"s\""
            ),
            _ => format!(
                "{textures} Texture \"t\" \"spectrum\" \"scale\" \"texture tex\" \"s\" \
                 \"float scale\" 1"
            ),
        };
        assert_near(colour(folder.path(), &textures, at), expected);
    }
}

#[test]
fn a_scaled_image_is_scaled_before_it_is_inverted_as_in_pbrt() {
    let folder = folder_with_pictures();
    let text = "Texture \"i\" \"spectrum\" \"imagemap\" \"string filename\" \"rgb.png\" \
        \"string encoding\" \"linear\" \"bool invert\" true\n\
        Texture \"t\" \"spectrum\" \"scale\" \"texture tex\" \"i\" \"float scale\" 0.5";
    assert_near(colour(folder.path(), text, TexturePoint::default()), [0.9, 0.8, 0.5]);
}

#[test]
fn colour_spaces_end_with_their_block() {
    let folder = tempfile::tempdir().unwrap();
    let grey = "Material \"diffuse\" \"rgb reflectance\" [0.2 0.5 0.2]";
    let of =
        |world: &str| reflectance(folder.path(), world).unwrap().colour(&TexturePoint::default());
    let space = "AttributeBegin ColorSpace \"rec2020\"";
    assert!(of(&format!("{space} {grey} AttributeEnd"))[0] < 0.1);
    assert_near(of(&format!("{space} AttributeEnd {grey}")), [0.2, 0.5, 0.2]);
}

#[test]
fn errors_in_textures_name_their_position() {
    let folder = folder_with_pictures();
    std::fs::write(folder.path().join("bad.png"), b"no picture").unwrap();
    let image = "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\"";
    for (world, expected) in [
        (format!("{image} \"none.png\""), "test.pbrt:3:35: cannot read the picture"),
        (format!("{image} \"bad.png\""), "test.pbrt:3:35: cannot read the picture"),
        (format!("{image} \"rgb.psd\""), "names no picture format"),
        ("Texture \"t\" \"spectrum\" \"imagemap\"".to_owned(), "without \"string filename\""),
        (format!("{image} \"rgb.png\" \"string wrap\" \"mirror\""), "the wrap mode \"mirror\""),
        (format!("{image} \"rgb.png\" \"string filter\" \"box\""), "the filter \"box\""),
        (format!("{image} \"rgb.png\" \"string encoding\" \"gamma 0\""), "a gamma of 0"),
        (format!("{image} \"rgb.png\" \"string encoding\" \"srgb\""), "the encoding \"srgb\""),
        (format!("{image} \"rgb.png\" \"string mapping\" \"cubic\""), "the mapping \"cubic\""),
        (
            "Texture \"t\" \"float\" \"fbm\" \"integer octaves\" 65".to_owned(),
            "\"octaves\" is 65; expected a whole number from 0 to 64",
        ),
        (
            "Texture \"t\" \"float\" \"wrinkled\" \"float octaves\" 2.5".to_owned(),
            "\"octaves\" is 2.5",
        ),
        (
            "Texture \"t\" \"float\" \"marble\"".to_owned(),
            "marble of type float; expected type spectrum",
        ),
        (
            "Texture \"t\" \"float\" \"windy\" \"float roughness\" 1".to_owned(),
            "unknown parameter \"roughness\"",
        ),
        ("Scale 0 1 1 Texture \"t\" \"float\" \"windy\"".to_owned(), "flattens"),
        (format!("Scale 0 1 1 {image} \"rgb.png\" \"string mapping\" \"planar\""), "flattens"),
        (
            "Texture \"t\" \"float\" \"checkerboard\" \"integer dimension\" 4".to_owned(),
            "4 dimensions",
        ),
        ("Texture \"t\" \"float\" \"mix\" \"texture amount\" \"x\"".to_owned(), "no texture \"x\""),
        (
            "Texture \"t\" \"float\" \"directionmix\" \"vector3 dir\" [0 0 0]".to_owned(),
            "a direction of length 0",
        ),
        ("ColorSpace \"rec709\"".to_owned(), "unknown colour space \"rec709\""),
    ] {
        let world = format!("{world}\nMaterial \"diffuse\"");
        let message = reflectance(folder.path(), &world).map(|_| ()).unwrap_err();
        assert!(message.contains(expected), "{world}: {message}");
        assert!(message.contains("test.pbrt:3:"), "{message}");
    }
}
