//! Documents, buffers and accessors, and what is refused.

use std::fs;
use std::path::Path;

use petzval_base::io::ReadContext;
use petzval_scene_formats::{read, read_with};
use serde_json::{Value, json};

use super::{Builder, meshes};
use crate::support::{folder, petzval};

fn simple() -> Builder {
    let mut builder = Builder::new();
    let mesh = builder.square(json!({ "emissiveFactor": [1, 0.5, 0.25] }));
    builder.node(json!({ "mesh": mesh }));
    builder
}

/// Returns the error of a document.
fn refused(text: &str) -> String {
    let folder = folder();
    let path = folder.path().join("a.gltf");
    fs::write(&path, text).expect("a file");
    read(&path).expect_err("an error").to_string()
}

#[test]
fn a_document_is_the_same_from_every_container() {
    let folder = folder();
    let builder = simple();
    let write = |name: &str, content: &[u8]| {
        fs::write(folder.path().join(name), content).expect("a file");
    };
    write("a.gltf", builder.text().as_bytes());
    write("b.glb", &builder.glb());
    write("a b\u{fc}.bin", &builder.data);
    let length = builder.data.len();
    let beside = json!({ "byteLength": length, "uri": "a%20b%C3%BC.bin" });
    write("c.gltf", builder.text_with(beside).as_bytes());
    write("D.GLTF", &[b"\xef\xbb\xbf", builder.text().as_bytes()].concat());
    let expected = meshes(folder.path(), "a.gltf");
    assert_eq!(expected[0].triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(expected[0].positions[1], [1.0, -1.0, 0.0]);
    for name in ["b.glb", "c.gltf", "D.GLTF"] {
        assert_eq!(meshes(folder.path(), name), expected, "{name}");
    }
    // The log of files, on which resuming relies, holds the buffer.
    let files = read(&folder.path().join("c.gltf")).expect("a scene").files;
    assert_eq!(files.iter().count(), 2);
}

#[test]
fn integers_may_have_a_fraction_of_zero_or_an_exponent_and_extras_any_value() {
    let folder = folder();
    let text = simple().text();
    let write = |name: &str, text: &str| {
        fs::write(folder.path().join(name), text).expect("a file");
        meshes(folder.path(), name)
    };
    let expected = write("a.gltf", &text);
    let mut changed = text.clone();
    for (plain, other) in [
        ("\"componentType\": 5126", "\"componentType\": 5126.0"),
        ("\"componentType\": 5123", "\"componentType\": 5.123e3"),
        ("\"count\": 4", "\"count\": 0.4e1"),
        ("\"mesh\": 0", "\"mesh\": 0.0"),
        ("\"byteOffset\": 48", "\"byteOffset\": 4.8E+1"),
    ] {
        assert!(changed.contains(plain), "{plain}");
        changed = changed.replace(plain, other);
    }
    assert_eq!(write("b.gltf", &changed), expected);
    for extras in ["5", "\"a\"", "[1, {\"scene\": 4294967296}]", "null", "true", "{\"a\": {}}"] {
        // At every object of the document; the keys of attributes are semantics.
        let object = format!("{{ \"extras\": {extras},");
        let attributes = |object: &str| format!("\"attributes\": {object}\n");
        let with = text.replace("{\n", &format!("{object}\n"));
        let with = with.replace(&attributes(&object), &attributes("{"));
        assert!(with.matches("extras").count() > 15);
        assert_eq!(write("c.gltf", &with), expected, "{extras}");
    }
}

#[test]
fn indices_of_two_to_the_32_are_refused_with_their_place() {
    let text = simple().text();
    for (key, large) in [("mesh", "4294967296"), ("POSITION", "4294967296.0"), ("buffer", "1e30")] {
        let said =
            refused(&text.replacen(&format!("\"{key}\": 0"), &format!("\"{key}\": {large}"), 1));
        assert!(said.contains(&format!("an index of {large}; expected less than 2^32")), "{said}");
        assert!(said.contains(" | ") && said.contains(large), "{said}");
    }
}

#[test]
fn strides_normalized_integers_and_sparse_values_are_read() {
    let expected = {
        let folder = folder();
        fs::write(folder.path().join("a.gltf"), simple().text()).expect("a file");
        meshes(folder.path(), "a.gltf")
    };
    let mut builder = simple();
    // Positions as signed bytes with a stride of four; the third is replaced.
    let bytes: Vec<u8> = [[-127i8, -127, 0, 9], [127, -127, 0, 9], [5, 5, 5, 5], [-127, 127, 0, 9]]
        .as_flattened()
        .iter()
        .map(|&v| v as u8)
        .collect();
    let view = builder.view(&bytes[..15]);
    builder.json["bufferViews"][view]["byteStride"] = json!(4);
    let indices = builder.view(&[2]);
    let values = builder.view(&[127, 127, 0]);
    let positions = builder.push(
        "accessors",
        json!({
            "bufferView": view, "componentType": 5120, "normalized": true, "count": 4,
            "type": "VEC3", "sparse": {
                "count": 1,
                "indices": { "bufferView": indices, "componentType": 5121 },
                "values": { "bufferView": values },
            },
        }),
    );
    // Texture coordinates as shorts, and no indices but a strip.
    let uvs: Vec<u8> =
        [0u16, 65535, 65535, 65535, 65535, 0, 0, 0].iter().flat_map(|v| v.to_le_bytes()).collect();
    let view = builder.view(&uvs);
    let uvs = builder.push(
        "accessors",
        json!({ "bufferView": view, "componentType": 5123, "normalized": true, "count": 4,
                "type": "VEC2" }),
    );
    let primitive = &mut builder.json["meshes"][0]["primitives"][0];
    primitive["attributes"]["POSITION"] = json!(positions);
    primitive["attributes"]["TEXCOORD_0"] = json!(uvs);
    let folder = folder();
    fs::write(folder.path().join("a.gltf"), builder.text()).expect("a file");
    assert_eq!(meshes(folder.path(), "a.gltf"), expected);
}

#[test]
fn faults_are_named_with_their_place() {
    let edit = |pointer: &str, value: Value| {
        let mut builder = simple();
        let (parent, key) = pointer.rsplit_once('/').expect("a pointer");
        let parent = builder.json.pointer_mut(parent).expect(pointer);
        match key.parse::<usize>() {
            Ok(index) => parent[index] = value,
            Err(_) => parent[key] = value,
        }
        refused(&builder.text())
    };
    let view = json!({ "buffer": 0, "byteLength": 1_000_000 });
    let far = json!({ "bufferView": 0, "componentType": 5126, "count": 99, "type": "VEC3" });
    for (pointer, value, expected) in [
        ("/asset/version", json!("1.0"), "asset.version: version 1.0; expected glTF 2.0"),
        ("/scene", json!(7), "scene: there is no scenes[7]; expected 0 to 0"),
        ("/scenes/0/nodes/1", json!(9), "scenes[0].nodes[1]: there is no nodes[9]"),
        ("/nodes/1/children", json!([1]), "nodes[1].children[0]: nodes[1] has two parents"),
        ("/nodes/1/mesh", json!(4), "nodes[1].mesh: there is no meshes[4]"),
        ("/nodes/0/camera", json!(2), "nodes[0].camera: there is no cameras[2]"),
        (
            "/nodes/1/matrix",
            json!([1e39, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]),
            "number out of range",
        ),
        ("/bufferViews/0", view, "bufferViews[0]: bytes 0 to 1000000; its buffer has"),
        ("/accessors/0", far, "99 elements of 12 bytes from byte 0 on; its bufferView has 48"),
        ("/accessors/0/type", json!("VEC2"), "accessors[0]: vectors of 2 components; expected 3"),
        ("/accessors/0/type", json!("VEC9"), "accessors[0]: numbers of no known type"),
        ("/accessors/1/count", json!(3), "attributes.NORMAL: 3 elements; there are 4 positions"),
        ("/bufferViews/0/byteStride", json!(4), "byteStride: a stride of 4; its elements have 12"),
        ("/meshes/0/primitives/0/mode", json!(9), "primitives[0].mode: an unknown mode"),
        ("/meshes/0/primitives/0/indices", json!(0), "accessors[0]: indices of another type"),
        ("/meshes/0/primitives/0/material", json!(5), "material: there is no materials[5]"),
        ("/materials/0/alphaMode", json!("X"), "materials[0].alphaMode: an unknown alpha mode"),
        ("/materials/0/emissiveTexture", json!({ "index": 3 }), "there is no textures[3]"),
        ("/cameras/0/perspective/yfov", json!(4), "cameras[0]: a field of view of 4"),
        ("/cameras/0/perspective/aspectRatio", json!(0), "cameras[0]: a picture 0 times as wide"),
        ("/extensionsRequired", json!(["KHR_draco_mesh_compression"]), "without compression"),
        ("/extensionsRequired", json!(["X_new"]), "extensionsRequired[0]: the extension X_new"),
    ] {
        let said = edit(pointer, value);
        assert!(said.contains(expected), "{pointer}: {said}");
        // File, line and column, and the line itself.
        let place = said.split(": ").next().unwrap_or_default();
        assert!(place.contains("a.gltf:") && !place.ends_with(":1:1"), "{said}");
        assert!(said.contains(" | "), "{said}");
    }
}

#[test]
fn broken_text_and_missing_files_are_refused_with_code_2() {
    let folder = folder();
    let builder = simple();
    let write = |name: &str, content: &[u8]| {
        fs::write(folder.path().join(name), content).expect("a file");
    };
    write("cut.gltf", &builder.text().as_bytes()[..100]);
    write("text.gltf", b"WorldBegin");
    write("none.gltf", builder.text_with(json!({ "byteLength": 4, "uri": "no.bin" })).as_bytes());
    let web = json!({ "byteLength": 4, "uri": "https://example.com/a.bin" });
    write("web.gltf", builder.text_with(web).as_bytes());
    let bad = json!({ "byteLength": 4, "uri": "data:x;base64,!!" });
    write("bad.gltf", builder.text_with(bad).as_bytes());
    let long = json!({ "byteLength": 9_999_999, "uri": "data:x;base64,AAAA" });
    write("long.gltf", builder.text_with(long).as_bytes());
    let glb = builder.glb();
    write("cut.glb", &glb[..glb.len() - 8]);
    write("scene.pbrt", builder.text().as_bytes());
    for (name, expected) in [
        ("cut.gltf", "this is no glTF document: EOF"),
        ("text.gltf", "text.gltf:1:1: this is no glTF document"),
        ("none.gltf", "no.bin"),
        ("web.gltf", "buffers[0].uri: the address https://example.com/a.bin; expected a path"),
        ("bad.gltf", "buffers[0].uri: bad base64"),
        ("long.gltf", "buffers[0]: 3 bytes in place of 9999999; the file may be cut off"),
        ("cut.glb", "the file may be cut off"),
        ("no.glb", "cannot read no.glb"),
        ("scene.pbrt", "or a name that ends in .gltf or .glb"),
    ] {
        let (code, _, said) = petzval(folder.path(), &["render", name]);
        assert!(code == 2 && said.contains(expected), "{name}: {code}, {said}");
    }
}

/// Puts wrong values in the place of every value of a document, one at a time.
fn corrupt(whole: &Value, pointer: &str, at: &Value, report: &mut impl FnMut(&str, Value)) {
    let wrong = [
        json!(null),
        json!(-1),
        json!(0),
        json!(4_294_967_295u32),
        json!(1e308),
        json!("x"),
        json!([]),
        json!({}),
        json!([0, 0, 0]),
    ];
    for value in wrong {
        let mut copy = whole.clone();
        if let Some(place) = copy.pointer_mut(pointer) {
            *place = value;
        }
        report(pointer, copy);
    }
    match at {
        Value::Array(all) => {
            for (i, item) in all.iter().enumerate() {
                corrupt(whole, &format!("{pointer}/{i}"), item, report);
            }
        }
        Value::Object(all) => {
            for (key, item) in all {
                corrupt(whole, &format!("{pointer}/{key}"), item, report);
            }
        }
        _ => {}
    }
}

#[test]
fn no_value_makes_the_reader_panic() {
    let mut builder = Builder::new();
    let texture = builder.texture([1, 1], &[[255; 4]]);
    let material = json!({
        "pbrMetallicRoughness": {
            "baseColorTexture": { "index": texture, "extensions": {
                "KHR_texture_transform": { "scale": [2, 2], "offset": [0, 1] } } },
            "metallicFactor": 0.5,
        },
        "normalTexture": { "index": texture, "scale": 0.5 },
        "emissiveFactor": [1, 1, 1],
        "alphaMode": "MASK",
        "extensions": {
            "KHR_materials_clearcoat": { "clearcoatFactor": 1 },
            "KHR_materials_transmission": { "transmissionFactor": 0.5 },
            "KHR_materials_volume": { "thicknessFactor": 1, "attenuationDistance": 1 },
            "KHR_materials_ior": { "ior": 1.4 },
        },
    });
    let mesh = builder.square(material);
    let places = builder.vectors(&[[0.0, 0.0, 0.0], [0.0, 0.0, -1.0]]);
    let instancing = json!({ "attributes": { "TRANSLATION": places } });
    builder.node(json!({
        "mesh": mesh, "rotation": [0, 0, 0, 1], "scale": [1, -1, 1],
        "extensions": { "EXT_mesh_gpu_instancing": instancing },
    }));
    let spot = json!({ "type": "spot", "intensity": 3, "spot": { "innerConeAngle": 0.1 } });
    builder.light(spot, json!({ "translation": [0, 0, 1] }));
    let whole: Value = serde_json::from_str(&builder.text()).expect("a document");
    let folder = folder();
    let path = folder.path().join("a.gltf");
    let (mut read_ones, mut refused_ones) = (0, 0);
    let context = ReadContext::with_memory(1 << 30);
    corrupt(&whole, "", &whole, &mut |_, document| {
        fs::write(&path, document.to_string()).expect("a file");
        match read_with(&path, &context.temporary()) {
            Ok(_) => read_ones += 1,
            Err(_) => refused_ones += 1,
        }
    });
    assert!(read_ones > 50 && refused_ones > 500, "{read_ones} {refused_ones}");
}

#[test]
fn every_end_of_a_binary_file_is_survived() {
    let folder = folder();
    let path = folder.path().join("a.glb");
    let whole = simple().glb();
    for end in (0..whole.len()).step_by(7) {
        fs::write(&path, &whole[..end]).expect("a file");
        assert!(read(&path).is_err(), "{end}");
    }
}

#[test]
fn a_document_cannot_ask_for_more_memory_than_there_is() {
    let folder = folder();
    let path: &Path = &folder.path().join("a.gltf");
    for count in [4_000_000_000u64, u64::MAX] {
        let mut builder = simple();
        let huge = json!({ "componentType": 5126, "count": count, "type": "VEC3" });
        builder.json["accessors"][0] = huge;
        fs::write(path, builder.text()).expect("a file");
        let said = read_with(path, &ReadContext::with_memory(1 << 28)).expect_err("an error");
        assert!(said.to_string().contains("'memory'"), "{said}");
    }
}
