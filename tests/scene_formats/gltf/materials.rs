//! Materials and textures, by pictures whose values are known.

use serde_json::{Value, json};

use super::{Builder, mean, middle, render};
use crate::support::{folder, petzval};

const RED: [u8; 4] = [255, 0, 0, 255];
const GREEN: [u8; 4] = [0, 255, 0, 255];
const BLUE: [u8; 4] = [0, 0, 255, 255];

/// Renders a square of a material under a sky of radiance 1.
pub fn under_sky(material: Value, options: &[&str]) -> [f32; 3] {
    let mut builder = Builder::new();
    let mesh = builder.square(material);
    builder.node(json!({ "mesh": mesh }));
    let (picture, said) = builder.render(options);
    assert!(said.contains("a white sky of radiance 1"), "{said}");
    middle(&picture)
}

pub fn assert_near(found: [f32; 3], expected: [f32; 3], within: f32, name: &str) {
    for channel in 0..3 {
        let off = (found[channel] - expected[channel]).abs();
        assert!(off < within, "{name}: {found:?}, expected {expected:?}");
    }
}

#[test]
fn textures_are_upright_and_their_colours_are_srgb() {
    let mut builder = Builder::new();
    let texture = builder.texture([2, 2], &[RED, GREEN, BLUE, [188, 188, 188, 255]]);
    let image = json!({ "index": texture });
    let emissive = builder.square(json!({
        "emissiveFactor": [1, 1, 1], "emissiveTexture": image,
        "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 3 } },
        "pbrMetallicRoughness": { "baseColorFactor": [0, 0, 0, 1], "metallicFactor": 1 },
    }));
    builder.node(json!({ "mesh": emissive }));
    let (picture, _) = builder.render(&["--spp", "16"]);
    let corner = |x: usize, y: usize| mean(&picture, [x, y], [x + 6, y + 6]);
    assert_near(corner(2, 2), [3.0, 0.0, 0.0], 0.02, "upper left");
    assert_near(corner(56, 2), [0.0, 3.0, 0.0], 0.02, "upper right");
    assert_near(corner(2, 56), [0.0, 0.0, 3.0], 0.02, "lower left");
    assert_near(corner(56, 56), [1.5; 3], 0.05, "lower right: half of the light");
    // The same of a base colour that a white sky lights: a perfect mirror of each colour.
    let mut builder = Builder::new();
    let texture = builder.texture([2, 2], &[RED, GREEN, BLUE, [188, 188, 188, 255]]);
    builder.json["samplers"] = json!([{ "magFilter": 9728 }]);
    builder.json["textures"][texture]["sampler"] = json!(0);
    let base = json!({ "baseColorTexture": { "index": texture },
                       "baseColorFactor": [1, 0.5, 1, 1], "roughnessFactor": 0 });
    let mesh = builder.square(json!({ "pbrMetallicRoughness": base }));
    builder.node(json!({ "mesh": mesh }));
    let (picture, _) = builder.render(&["--spp", "16"]);
    let corner = |x: usize, y: usize| mean(&picture, [x, y], [x + 6, y + 6]);
    assert_near(corner(2, 2), [1.0, 0.0, 0.0], 0.03, "upper left");
    assert_near(corner(56, 2), [0.0, 0.5, 0.0], 0.03, "upper right");
    assert_near(corner(2, 56), [0.0, 0.0, 1.0], 0.03, "lower left");
    assert_near(corner(56, 56), [0.5, 0.25, 0.5], 0.03, "lower right");
}

#[test]
fn texture_transforms_and_other_sets_of_coordinates_are_read() {
    let mut builder = Builder::new();
    let texture = builder.texture([2, 1], &[RED, GREEN]);
    builder.json["samplers"] = json!([{ "magFilter": 9728 }]);
    builder.json["textures"][texture]["sampler"] = json!(0);
    let transform = json!({ "scale": [0.5, 1], "offset": [0.5, 0] });
    let image = json!({ "index": texture, "extensions": { "KHR_texture_transform": transform } });
    let mesh = builder.square(json!({
        "emissiveFactor": [1, 1, 1], "emissiveTexture": image,
    }));
    builder.node(json!({ "mesh": mesh }));
    // Only the right half of the image is seen.
    let (picture, _) = builder.render(&["--spp", "4"]);
    let left = mean(&picture, [4, 20], [12, 40]);
    assert!(left[1] > 0.9 && left[0] < 0.1, "{left:?}");
    // Coordinates of the second set, which are all in the left half.
    let second = builder.vectors(&[[0.1, 0.5]; 4]);
    builder.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"] = json!(second);
    builder.json["materials"][0]["emissiveTexture"] = json!({ "index": texture, "texCoord": 1 });
    let (picture, _) = builder.render(&["--spp", "4"]);
    let found = middle(&picture);
    assert!(found[0] > 0.9 && found[1] < 0.1, "{found:?}");
}

#[test]
fn texture_transforms_turn_the_image_against_the_clock() {
    let transform = json!({ "rotation": std::f64::consts::FRAC_PI_2, "offset": [0, 1] });
    let mut builder = Builder::new();
    let texture = builder.texture([2, 2], &[RED, GREEN, BLUE, [255; 4]]);
    builder.json["samplers"] = json!([{ "magFilter": 9728 }]);
    builder.json["textures"][texture]["sampler"] = json!(0);
    let turned = json!({ "index": texture, "extensions": { "KHR_texture_transform": transform } });
    let mesh =
        builder.square(json!({ "emissiveFactor": [1, 1, 1], "emissiveTexture": turned.clone() }));
    builder.node(json!({ "mesh": mesh }));
    // (s, t) = (v, 1 - u): the upper left corner of the square shows the lower left of the image.
    let expected = [
        ([2, 2], [0.0, 0.0, 1.0]),
        ([56, 2], [1.0, 0.0, 0.0]),
        ([2, 56], [1.0, 1.0, 1.0]),
        ([56, 56], [0.0, 1.0, 0.0]),
    ];
    let emissive = builder.render(&["--spp", "4"]).0;
    // As a base colour, it is filtered.
    builder.json["materials"][0] = json!({
        "pbrMetallicRoughness": { "baseColorTexture": turned, "roughnessFactor": 0 },
    });
    let base = builder.render(&["--spp", "16"]).0;
    for (picture, name) in [(emissive, "emissive"), (base, "base colour")] {
        for ([x, y], colour) in expected {
            let found = mean(&picture, [x, y], [x + 6, y + 6]);
            assert_near(found, colour, 0.03, &format!("{name} at {x}, {y}"));
        }
    }
}

#[test]
fn colours_of_vertices_multiply_the_base_colour() {
    // Red at the left, green at the right, and half of the blue everywhere.
    let corners = [[0.8f32, 0.0, 0.5, 1.0], [0.0, 0.8, 0.5, 1.0]];
    let corners = [corners[0], corners[1], corners[1], corners[0]];
    let base = json!({ "pbrMetallicRoughness": { "roughnessFactor": 0,
                                                 "baseColorFactor": [1, 0.5, 1, 1] } });
    let integers = |most: f32| corners.map(|c| c.map(|v| (v * most).round() as u32));
    for kind in ["floats", "floats of four", "bytes", "shorts"] {
        let mut builder = Builder::new();
        let mesh = builder.square(base.clone());
        let (bytes, component, channels): (Vec<u8>, _, _) = match kind {
            "floats" => {
                let rgb = corners.iter().flat_map(|c| &c[..3]);
                (rgb.flat_map(|v| v.to_le_bytes()).collect(), 5126, "VEC3")
            }
            "floats of four" => {
                (corners.iter().flatten().flat_map(|v| v.to_le_bytes()).collect(), 5126, "VEC4")
            }
            "bytes" => (integers(255.0).iter().flatten().map(|&v| v as u8).collect(), 5121, "VEC4"),
            _ => {
                let all = integers(65535.0).into_iter().flatten();
                (all.flat_map(|v| (v as u16).to_le_bytes()).collect(), 5123, "VEC4")
            }
        };
        let view = builder.view(&bytes);
        let accessor = builder.push(
            "accessors",
            json!({
                "bufferView": view, "componentType": component, "count": 4, "type": channels,
                "normalized": component != 5126,
            }),
        );
        builder.json["meshes"][mesh]["primitives"][0]["attributes"]["COLOR_0"] = json!(accessor);
        builder.node(json!({ "mesh": mesh }));
        let (picture, said) = builder.render(&["--spp", "16"]);
        assert!(!said.contains("COLOR_0"), "{said}");
        // Pixels of 64 across the square.
        for x in [4, 30, 60] {
            let u = (x as f32 + 1.0) / 64.0;
            let expected = [0.8 * (1.0 - u), 0.5 * 0.8 * u, 0.5];
            assert_near(
                mean(&picture, [x, 20], [x + 2, 40]),
                expected,
                0.01,
                &format!("{kind} at {x}"),
            );
        }
    }
}

#[test]
fn vertex_colours_reach_albedo_instances_and_textures() {
    let mut builder = Builder::new();
    let texture = builder.texture([1, 1], &[[255, 188, 255, 255]]);
    let mesh = builder.square(json!({
        "pbrMetallicRoughness": { "metallicFactor": 0, "baseColorTexture": { "index": texture } },
    }));
    let colours = builder.vectors(&[[0.5f32, 0.5, 0.25]; 4]);
    builder.json["meshes"][mesh]["primitives"][0]["attributes"]["COLOR_0"] = json!(colours);
    builder.node(json!({ "mesh": mesh, "scale": [0.5, 1, 1], "translation": [-0.5, 0, 0] }));
    builder.node(json!({ "mesh": mesh, "scale": [0.5, 1, 1], "translation": [0.5, 0, 0] }));
    // The same material on a mesh without colours.
    let other = builder.json["meshes"][mesh].clone();
    let other = builder.push("meshes", other);
    let attributes = &mut builder.json["meshes"][other]["primitives"][0]["attributes"];
    attributes.as_object_mut().expect("attributes").remove("COLOR_0");
    builder.node(json!({ "mesh": other, "translation": [0, 1.5, 0.01] }));
    let folder = folder();
    std::fs::write(folder.path().join("a.gltf"), builder.text()).expect("a file");
    let options = ["--resolution", "64x64", "--spp", "4", "--aov", "albedo"];
    render(folder.path(), "a.gltf", &options);
    let image = exr::prelude::read_all_flat_layers_from_file(folder.path().join("a.exr"));
    let image = image.expect("a picture");
    let channel = |name: &str| {
        let all = &image.layer_data[0].channel_data.list;
        let found = all.iter().find(|channel| channel.name.to_string() == name).expect(name);
        match &found.sample_data {
            exr::prelude::FlatSamples::F32(values) => values.clone(),
            _ => panic!("floats"),
        }
    };
    let [r, g, b] = ["albedo.R", "albedo.G", "albedo.B"].map(channel);
    for (x, y, expected) in
        [(10, 40, [0.5, 0.25, 0.25]), (50, 40, [0.5, 0.25, 0.25]), (30, 4, [1.0, 0.5, 1.0])]
    {
        let at = y * 64 + x;
        assert_near([r[at], g[at], b[at]], expected, 0.003, &format!("{x}, {y}"));
    }
}

#[test]
fn the_opacity_of_vertices_counts_in_blends() {
    let mut builder = Builder::new();
    let mesh = builder.square(json!({
        "emissiveFactor": [2, 2, 2], "alphaMode": "BLEND",
        "pbrMetallicRoughness": { "baseColorFactor": [1, 1, 1, 0.5] },
    }));
    let colours = builder.vectors(&[[1.0f32, 1.0, 1.0, 0.5]; 4]);
    builder.json["meshes"][mesh]["primitives"][0]["attributes"]["COLOR_0"] = json!(colours);
    builder.node(json!({ "mesh": mesh }));
    let found = middle(&builder.render(&["--spp", "256"]).0)[0];
    assert!((found - 0.5).abs() < 0.02, "{found}");
}

#[test]
fn colours_that_do_not_fit_are_errors() {
    let refused = |accessor: Value, expected: &str| {
        let mut builder = Builder::new();
        let mesh = builder.square(json!({}));
        let view = builder.view(&[0; 64]);
        let mut accessor = accessor;
        accessor["bufferView"] = json!(view);
        let accessor = builder.push("accessors", accessor);
        builder.json["meshes"][mesh]["primitives"][0]["attributes"]["COLOR_0"] = json!(accessor);
        builder.node(json!({ "mesh": mesh }));
        let folder = folder();
        std::fs::write(folder.path().join("a.gltf"), builder.text()).expect("a file");
        let (code, _, said) = petzval(folder.path(), &["render", "a.gltf", "-o", "a.exr"]);
        assert!(code == 2 && said.contains(expected), "{code} {said}");
    };
    let accessor = |component: u32, count: u32, kind: &str, normalized: bool| json!({ "componentType": component, "count": count, "type": kind, "normalized": normalized });
    refused(accessor(5126, 3, "VEC4", false), "COLOR_0: 3 elements; there are 4 positions");
    refused(accessor(5121, 4, "VEC4", false), "expected floats or normalized integers");
    refused(accessor(5126, 4, "VEC2", false), "vectors of 2 components");
}

#[test]
fn white_surfaces_under_a_white_sky_are_white() {
    for roughness in [0.0, 0.3, 1.0] {
        let pbr = json!({ "metallicFactor": 0, "roughnessFactor": roughness });
        let found = under_sky(json!({ "pbrMetallicRoughness": pbr }), &["--spp", "64"]);
        assert_near(found, [1.0; 3], 0.01, &format!("roughness {roughness}"));
    }
}

#[test]
fn the_metallic_factor_mixes_and_its_texture_is_blue_and_that_of_roughness_green() {
    let smooth = |metallic: f64| {
        json!({ "metallicFactor": metallic, "roughnessFactor": 0,
                "baseColorFactor": [0.5, 0.25, 0, 1] })
    };
    let at = |metallic: f64| {
        under_sky(json!({ "pbrMetallicRoughness": smooth(metallic) }), &["--spp", "256"])
    };
    let (metal, plastic) = (at(1.0), at(0.0));
    assert_near(metal, [0.5, 0.25, 0.0], 0.005, "metal");
    // The interface reflects 4 %; the base reflects its share of what is left.
    assert!(plastic[2] > 0.035 && plastic[2] < 0.06 && plastic[0] > 0.5, "{plastic:?}");
    let between: [f32; 3] = std::array::from_fn(|c| 0.25 * metal[c] + 0.75 * plastic[c]);
    assert_near(at(0.25), between, 0.01, "a quarter of metal");
    // Green is full roughness, blue is a quarter of metal.
    let mut builder = Builder::new();
    let texture = builder.texture([1, 1], &[[77, 0, 64, 255]]);
    let mut pbr = smooth(1.0);
    pbr["roughnessFactor"] = json!(1);
    pbr["metallicRoughnessTexture"] = json!({ "index": texture });
    let mesh = builder.square(json!({ "pbrMetallicRoughness": pbr }));
    builder.node(json!({ "mesh": mesh }));
    let (picture, _) = builder.render(&["--spp", "256"]);
    assert_near(middle(&picture), between, 0.012, "textures");
}

#[test]
fn roughness_is_squared() {
    // A highlight of half the roughness is narrower: its peak is about 16 times as high.
    let peak = |roughness: f64, texture: bool| {
        let mut builder = Builder::new();
        let mut pbr = json!({ "metallicFactor": 1, "roughnessFactor": roughness });
        if texture {
            let code = (roughness * 255.0).round() as u8;
            let texture = builder.texture([1, 1], &[[0, code, 255, 255]]);
            pbr["roughnessFactor"] = json!(1);
            pbr["metallicRoughnessTexture"] = json!({ "index": texture });
        }
        let mesh = builder.square(json!({ "pbrMetallicRoughness": pbr }));
        builder.node(json!({ "mesh": mesh }));
        builder.light(json!({ "type": "directional" }), json!({}));
        let (picture, _) = builder.render_whole(&["--spp", "4", "--resolution", "65x65"]);
        mean(&picture, [32, 32], [33, 33])[0]
    };
    // D of the normal is 1 / (pi alpha^2), and half vector and normal agree: D / 4.
    for roughness in [0.4f64, 0.6, 1.0] {
        let alpha = roughness * roughness;
        let expected = 1.0 / (4.0 * std::f64::consts::PI * alpha * alpha);
        for texture in [false, true] {
            let found = f64::from(peak(roughness, texture));
            let off = (found / expected - 1.0).abs();
            assert!(off < 0.03, "{roughness} {texture}: {found}, expected {expected}");
        }
    }
}

/// Renders a rough metal whose normal map tilts the normal, lit from `towards`, and returns its
/// brightness. `uvs` are the coordinates of the corners of the square.
fn tilted(tilt: [f64; 2], towards: [f64; 3], uvs: [[f32; 2]; 4], node: Value) -> f32 {
    let mut builder = Builder::new();
    let z = (1.0 - tilt[0] * tilt[0] - tilt[1] * tilt[1]).sqrt();
    let code = |v: f64| ((v + 1.0) * 127.5).round() as u8;
    let texture = builder.texture([1, 1], &[[code(tilt[0]), code(tilt[1]), code(z), 255]]);
    let mesh = builder.square_with(
        json!({
            "pbrMetallicRoughness": { "roughnessFactor": 0.7 },
            "normalTexture": { "index": texture },
        }),
        uvs,
    );
    let mut node = node;
    node["mesh"] = json!(mesh);
    builder.node(node);
    // A rotation that takes +z, against which lights shine, to `towards`.
    let [x, y, z] = towards;
    let length = (x * x + y * y + z * z).sqrt();
    let (x, y, z) = (x / length, y / length, z / length);
    let rotation = [-y, x, 0.0, 1.0 + z];
    let norm = rotation.iter().map(|v| v * v).sum::<f64>().sqrt();
    let rotation = rotation.map(|v| v / norm);
    builder.light(json!({ "type": "directional" }), json!({ "rotation": rotation }));
    middle(&builder.render(&["--spp", "4"]).0)[0]
}

#[test]
fn normal_maps_tilt_to_the_right_and_up_whatever_the_side_of_the_coordinates() {
    let upright = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
    let mirrored = [[1.0, 1.0], [0.0, 1.0], [0.0, 0.0], [1.0, 0.0]];
    let (right, left, up, down) =
        ([0.6, 0.0, 1.0], [-0.6, 0.0, 1.0], [0.0, 0.6, 1.0], [0.0, -0.6, 1.0]);
    let plain = json!({});
    let at = |tilt, towards, uvs, node: &Value| tilted(tilt, towards, uvs, node.clone());
    // Red tilts towards u, green against v.
    let (x, y) = ([0.28, 0.0], [0.0, 0.28]);
    let bright = at(x, right, upright, &plain);
    let dark = at(x, left, upright, &plain);
    assert!(bright > 2.0 * dark, "{bright} {dark}");
    let close = |found: f32, expected: f32, name: &str| {
        assert!((found / expected - 1.0).abs() < 0.02, "{name}: {found}, expected {expected}");
    };
    close(at(y, up, upright, &plain), bright, "green is up");
    close(at(y, down, upright, &plain), dark, "green is not down");
    // In mirrored coordinates u grows to the left, but green is still up.
    close(at(x, left, mirrored, &plain), bright, "red is to the left");
    close(at(y, up, mirrored, &plain), bright, "mirrored: green is up");
    close(at(y, down, mirrored, &plain), dark, "mirrored: green is not down");
    // A node that mirrors the mesh mirrors its coordinates. It turns it to its front again.
    let node = json!({ "scale": [-1, 1, 1] });
    close(at(x, left, upright, &node), bright, "a mirrored node: red is to the left");
    close(at(y, up, upright, &node), bright, "a mirrored node: green is up");
}

#[test]
fn tangents_of_the_document_decide_over_the_coordinates() {
    // The tangent points up, so that red tilts up.
    let render = |towards: [f64; 2]| {
        let mut builder = Builder::new();
        let texture = builder.texture([1, 1], &[[200, 128, 230, 255]]);
        let mesh = builder.square(json!({
            "pbrMetallicRoughness": { "roughnessFactor": 0.7 },
            "normalTexture": { "index": texture },
        }));
        let tangents = builder.vectors(&[[0.0f32, 1.0, 0.0, 1.0]; 4]);
        builder.json["meshes"][0]["primitives"][0]["attributes"]["TANGENT"] = json!(tangents);
        builder.node(json!({ "mesh": mesh }));
        let rotation = [-towards[1], towards[0], 0.0, 2.0];
        let norm = rotation.iter().map(|v| v * v).sum::<f64>().sqrt();
        builder.light(
            json!({ "type": "directional" }),
            json!({ "rotation": rotation.map(|v| v / norm) }),
        );
        middle(&builder.render(&["--spp", "4"]).0)[0]
    };
    let (up, down, right) = (render([0.0, 0.6]), render([0.0, -0.6]), render([0.6, 0.0]));
    assert!(up > 2.0 * down && up > 1.3 * right, "{up} {down} {right}");
}

#[test]
fn masks_cut_and_blends_are_transparent() {
    let at = |mode: &str, alpha: u8, factor: f64, cutoff: f64| {
        let mut builder = Builder::new();
        let texture = builder.texture([1, 1], &[[255, 255, 255, alpha]]);
        let mesh = builder.square(json!({
            "pbrMetallicRoughness": { "baseColorTexture": { "index": texture },
                                      "baseColorFactor": [1, 1, 1, factor] },
            "emissiveFactor": [2, 2, 2], "alphaMode": mode, "alphaCutoff": cutoff,
        }));
        builder.node(json!({ "mesh": mesh }));
        middle(&builder.render(&["--spp", "256"]).0)[0]
    };
    // Behind it there is nothing. A blend lets through what its alpha does not take.
    for (mode, alpha, factor, cutoff, expected) in [
        ("OPAQUE", 10, 0.5, 0.5, 2.0),
        ("MASK", 140, 1.0, 0.5, 2.0),
        ("MASK", 140, 0.5, 0.5, 0.0),
        ("MASK", 60, 1.0, 0.2, 2.0),
        ("BLEND", 128, 1.0, 0.5, 1.0),
        ("BLEND", 128, 0.5, 0.5, 0.5),
    ] {
        let found = at(mode, alpha, factor, cutoff);
        assert!((found - expected).abs() < 0.03, "{mode} {alpha} {factor} {cutoff}: {found}");
    }
}

#[test]
fn a_volume_absorbs_by_its_attenuation() {
    // A slab 0.5 thick, without reflections: both faces of a box of index 1.
    let mut builder = Builder::new();
    let glass = json!({
        "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": 0 },
        "extensions": {
            "KHR_materials_transmission": { "transmissionFactor": 1 },
            "KHR_materials_ior": { "ior": 1 },
            "KHR_materials_volume": { "thicknessFactor": 0.5, "attenuationDistance": 0.25,
                                      "attenuationColor": [0.9, 0.5, 1] },
        },
    });
    let mesh = builder.square(glass);
    builder.node(json!({ "mesh": mesh }));
    builder.node(json!({ "mesh": mesh, "translation": [0, 0, -0.5], "rotation": [0, 1, 0, 0] }));
    let lamp = builder.square(json!({ "emissiveFactor": [1, 1, 1] }));
    builder.node(json!({ "mesh": lamp, "translation": [0, 0, -1], "scale": [3, 3, 3] }));
    let found = middle(&builder.render(&["--spp", "64"]).0);
    assert_near(found, [0.81, 0.25, 1.0], 0.01, "twice the attenuation distance");
}

#[test]
fn thin_glass_transmits_and_only_the_dielectric_does() {
    let at = |metallic: f64, factor: f64| {
        let mut builder = Builder::new();
        let glass = builder.square(json!({
            "pbrMetallicRoughness": { "metallicFactor": metallic, "roughnessFactor": 0 },
            "extensions": { "KHR_materials_transmission": { "transmissionFactor": factor } },
        }));
        builder.node(json!({ "mesh": glass }));
        let lamp = builder.square(json!({
            "emissiveFactor": [1, 1, 1],
            "pbrMetallicRoughness": { "baseColorFactor": [0, 0, 0, 1] },
        }));
        builder.node(json!({ "mesh": lamp, "translation": [0, 0, -1], "scale": [3, 3, 3] }));
        middle(&builder.render(&["--spp", "256"]).0)[0]
    };
    // A sheet reflects 2 R / (1 + R) of the light, with R = 0.04 (at normal incidence).
    let sheet = 1.0 - 2.0 * 0.04 / 1.04;
    for (metallic, factor, expected) in
        [(0.0, 1.0, sheet), (0.0, 0.5, 0.5 * sheet), (0.5, 1.0, 0.5 * sheet), (1.0, 1.0, 0.0)]
    {
        let found = at(metallic, factor);
        assert!((found - expected).abs() < 0.02, "{metallic} {factor}: {found}");
    }
}

#[test]
fn the_base_colour_tints_what_passes_through_each_face() {
    let through = |base: Value, extensions: Value, faces: usize| {
        let mut builder = Builder::new();
        let mut base = base;
        base["metallicFactor"] = json!(0);
        base["roughnessFactor"] = json!(0);
        let texture = builder.texture([1, 1], &[[255, 188, 255, 255]]);
        if base["baseColorTexture"] == json!(true) {
            base["baseColorTexture"] = json!({ "index": texture });
        }
        let mesh =
            builder.square(json!({ "pbrMetallicRoughness": base, "extensions": extensions }));
        builder.node(json!({ "mesh": mesh }));
        if faces == 2 {
            let back =
                json!({ "mesh": mesh, "translation": [0, 0, -0.5], "rotation": [0, 1, 0, 0] });
            builder.node(back);
        }
        let lamp = builder.square(json!({
            "emissiveFactor": [1, 1, 1],
            "pbrMetallicRoughness": { "baseColorFactor": [0, 0, 0, 1] },
        }));
        builder.node(json!({ "mesh": lamp, "translation": [0, 0, -1], "scale": [3, 3, 3] }));
        let (picture, said) = builder.render(&["--spp", "128"]);
        assert!(!said.contains("does not tint"), "{said}");
        middle(&picture)
    };
    let sheet = json!({ "KHR_materials_transmission": { "transmissionFactor": 1 } });
    let tint = json!({ "baseColorFactor": [0.9, 0.5, 0.1, 1] });
    let share = 1.0 - 2.0 * 0.04 / 1.04;
    let found = through(tint.clone(), sheet.clone(), 1);
    assert_near(found, [0.9 * share, 0.5 * share, 0.1 * share], 0.01, "sheet");
    let found = through(json!({ "baseColorTexture": true }), sheet, 1);
    assert_near(found, [share, 0.5 * share, share], 0.01, "texture");
    // Both faces of a body of index 1, which reflects nothing.
    let body = json!({
        "KHR_materials_transmission": { "transmissionFactor": 1 },
        "KHR_materials_ior": { "ior": 1 },
        "KHR_materials_volume": { "thicknessFactor": 0.5 },
    });
    assert_near(through(tint, body, 2), [0.81, 0.25, 0.01], 0.01, "body");
}

#[test]
fn a_clear_coat_reflects_over_its_coverage() {
    let at = |factor: f64| {
        let material = json!({
            "pbrMetallicRoughness": { "metallicFactor": 1, "roughnessFactor": 0.5,
                                      "baseColorFactor": [0, 0, 0, 1] },
            "extensions": { "KHR_materials_clearcoat": { "clearcoatFactor": factor } },
        });
        under_sky(material, &["--spp", "256"])[0]
    };
    let (none, half, whole) = (at(0.0), at(0.5), at(1.0));
    assert!(none < 0.01, "{none}");
    // Glass of index 1.5 reflects 4 % at normal incidence.
    assert!((whole - 0.04).abs() < 0.006, "{whole}");
    assert!((half - 0.5 * whole).abs() < 0.005, "{half} {whole}");
}

#[test]
fn what_is_not_read_is_said() {
    let mut builder = Builder::new();
    let mesh = builder.square(json!({
        "extensions": { "KHR_materials_unlit": {} },
    }));
    builder.json["extensionsUsed"] = json!(["KHR_materials_unlit", "KHR_materials_sheen"]);
    builder.json["animations"] = json!([{ "channels": [], "samplers": [] }]);
    let colours = builder.vectors(&[[1.0f32, 0.0, 0.0]; 4]);
    builder.json["meshes"][mesh]["primitives"][0]["attributes"]["COLOR_1"] = json!(colours);
    builder.node(json!({ "mesh": mesh }));
    let more = builder.json["meshes"][mesh].clone();
    let more = builder.push("meshes", more);
    builder.node(json!({ "mesh": more }));
    let (_, said) = builder.render(&["--spp", "1"]);
    for expected in [
        "the extension KHR_materials_sheen is not read",
        "animations are not read",
        "only the first colours of vertices are read (and 1 more like this)",
        "an unlit material is read as one that light falls on",
        "the scene has no light",
    ] {
        assert!(said.contains(expected), "{expected}: {said}");
    }
    assert!(!said.contains("KHR_materials_unlit is not read"), "{said}");
}

#[test]
fn white_is_not_an_accident() {
    // A grey base darkens what the sky lights.
    let grey = json!({ "metallicFactor": 0, "baseColorFactor": [0.5, 0.5, 0.5, 1] });
    let found = under_sky(json!({ "pbrMetallicRoughness": grey }), &["--spp", "64"]);
    assert!(found[0] > 0.48 && found[0] < 0.56, "{found:?}");
}
