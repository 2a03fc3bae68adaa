//! The extension KHR_materials_specular.

use std::fs;

use petzval_scene_formats::read;
use serde_json::{Value, json};

use super::materials::{assert_near, under_sky};
use super::{Builder, middle};
use crate::support::folder;

#[test]
fn the_specular_factor_and_colour_change_the_reflection_of_the_dielectric() {
    let at = |metallic: f64, ior: f64, specular: Value| {
        let material = json!({
            "pbrMetallicRoughness": { "metallicFactor": metallic, "roughnessFactor": 0,
                                      "baseColorFactor": [0, 0, 0, 1] },
            "extensions": { "KHR_materials_ior": { "ior": ior }, "KHR_materials_specular": specular },
        });
        under_sky(material, &["--spp", "256"])
    };
    let plain = at(0.0, 1.5, json!({}));
    // The reflectance of an index of 1.5 is 4 % at normal incidence; the picture's middle is near it.
    assert!(plain[0] > 0.04 && plain[0] < 0.042, "{plain:?}");
    let half = at(0.0, 1.5, json!({ "specularFactor": 0.5 }));
    assert_near(half, plain.map(|v| v / 2.0), 0.0005, "half");
    assert_near(at(0.0, 1.5, json!({ "specularFactor": 0 })), [0.0; 3], 1e-6, "none");
    // The colour leaves the light at grazing incidence, here 0.1 % of a channel.
    let coloured = at(0.0, 1.5, json!({ "specularColorFactor": [1, 0.25, 3] }));
    assert_near(coloured, [plain[0], 0.25 * plain[0], 3.0 * plain[0]], 0.002, "colour");
    // (2.5 / 4.5)^2 = 0.31 times 4 reflects all light, and no more.
    let all = at(0.0, 3.5, json!({ "specularColorFactor": [4, 1, 1] }));
    assert_near(all, [1.0, 0.309, 0.309], 0.002, "all light");
    let metal = at(1.0, 1.5, json!({ "specularFactor": 0.2, "specularColorFactor": [0, 0, 0] }));
    assert_near(metal, at(1.0, 1.5, json!({})), 1e-6, "metal");
}

#[test]
fn textures_of_the_specular_extension_are_alpha_and_colour() {
    let render = |specular: Value, alpha: u8| {
        let mut builder = Builder::new();
        let strength = builder.texture([1, 1], &[[9, 9, 9, alpha]]);
        // 188 is half of white in sRGB.
        let colour = builder.texture([1, 1], &[[255, 188, 0, 7]]);
        let mut specular = specular;
        specular["specularTexture"] = json!({ "index": strength });
        specular["specularColorTexture"] = json!({ "index": colour });
        let mesh = builder.square(json!({
            "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": 0,
                                      "baseColorFactor": [0, 0, 0, 1] },
            "extensions": { "KHR_materials_specular": specular },
        }));
        builder.node(json!({ "mesh": mesh }));
        middle(&builder.render(&["--spp", "256"]).0)
    };
    let whole = render(json!({}), 255);
    assert_near(whole, [0.0405, 0.0203, 0.0005], 0.001, "textures");
    let both = render(json!({ "specularFactor": 0.5, "specularColorFactor": [0.5, 1, 1] }), 128);
    assert_near(both, [whole[0] / 8.0, whole[1] / 4.0, 0.0], 0.0005, "times factors");
}

#[test]
fn white_surfaces_stay_white_under_any_specular_strength() {
    for (strength, roughness) in [(0.0, 0.5), (0.3, 0.0), (0.3, 0.5), (1.0, 0.5)] {
        let material = json!({
            "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": roughness },
            "extensions": { "KHR_materials_specular": { "specularFactor": strength } },
        });
        let found = under_sky(material, &["--spp", "64"]);
        assert_near(found, [1.0; 3], 0.01, &format!("strength {strength}, roughness {roughness}"));
    }
}

#[test]
fn wrong_values_of_the_specular_extension_are_refused() {
    for (specular, found) in [
        (json!([1]), "found [1]"),
        (json!({ "specularFactor": -3 }), "a specularFactor of -3"),
        (json!({ "specularFactor": 1.5 }), "a specularFactor of 1.5"),
        (json!({ "specularColorFactor": [-1, 2, 1] }), "a specularColorFactor of -1, 2, 1"),
        (json!({ "specularColorFactor": [1, 1] }), "invalid length 2"),
        (json!("strong"), "found \"strong\""),
    ] {
        let mut builder = Builder::new();
        let extensions = json!({ "KHR_materials_specular": specular });
        let mesh = builder.square(json!({ "extensions": extensions }));
        builder.node(json!({ "mesh": mesh }));
        let folder = folder();
        let path = folder.path().join("a.gltf");
        fs::write(&path, builder.text()).expect("a file");
        let error = read(&path).expect_err("an error").to_string();
        assert!(error.contains(found) && error.contains("KHR_materials_specular"), "{error}");
    }
}

#[test]
fn textures_of_other_coordinates_cause_a_warning() {
    let warns = |extension: &str, texture: &str, more: Value| {
        let mut builder = Builder::new();
        let image = builder.texture([1, 1], &[[255; 4]]);
        let mut values = more;
        values[texture] = json!({ "index": image, "texCoord": 1 });
        let mut extensions = json!({});
        extensions[extension] = values;
        let mesh = builder.square(json!({
            "pbrMetallicRoughness": { "baseColorTexture": { "index": image } },
            "extensions": extensions,
        }));
        builder.node(json!({ "mesh": mesh }));
        let (_, said) = builder.render(&["--spp", "1"]);
        assert!(said.contains("all its textures use set 0"), "{texture}: {said}");
    };
    warns("KHR_materials_specular", "specularTexture", json!({}));
    warns("KHR_materials_specular", "specularColorTexture", json!({}));
    warns("KHR_materials_clearcoat", "clearcoatTexture", json!({ "clearcoatFactor": 1 }));
    warns("KHR_materials_transmission", "transmissionTexture", json!({ "transmissionFactor": 1 }));
}
