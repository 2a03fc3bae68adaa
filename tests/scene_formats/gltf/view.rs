//! Cameras, real lenses in their place, and copies of meshes.

use std::fs;

use serde_json::json;

use super::{Builder, mean, middle, render};
use crate::support::{folder, petzval, root};

fn lamp(builder: &mut Builder) -> usize {
    builder.square(json!({ "emissiveFactor": [1, 1, 1] }))
}

#[test]
fn the_camera_sees_its_field_of_view() {
    let mut builder = Builder::new();
    let mesh = lamp(&mut builder);
    // Half as wide and a quarter as high as the picture, in its upper right.
    builder.node(json!({ "mesh": mesh, "scale": [0.5, 0.25, 1], "translation": [0.5, 0.5, 0] }));
    builder.json["cameras"][0]["perspective"]["aspectRatio"] = json!(2);
    let (picture, _) = builder.render_whole(&["--spp", "4"]);
    assert_eq!(picture.size, [1440, 720]);
    // At x from 0 to 1 and y from 0.25 to 0.75 of a picture from -2 to 2 and from -1 to 1.
    let inside = |x: usize, y: usize| mean(&picture, [x, y], [x + 1, y + 1])[0] == 1.0;
    for (x, y, expected) in [
        (725, 95, true),
        (715, 95, false),
        (1075, 265, true),
        (1085, 265, false),
        (900, 85, false),
        (900, 275, false),
    ] {
        assert_eq!(inside(x, y), expected, "{x} {y}");
    }
    // The scale of the camera's node does not count, a mirrored one neither.
    builder.json["nodes"][0]["scale"] = json!([-3, 0.5, 2]);
    assert_eq!(builder.render_whole(&["--spp", "4"]).0.pixels, picture.pixels);
}

#[test]
fn an_orthographic_camera_sees_its_magnification() {
    let mut builder = Builder::new();
    let mesh = lamp(&mut builder);
    builder.node(json!({ "mesh": mesh, "translation": [0, 0, -50] }));
    builder.json["cameras"][0] = json!({
        "type": "orthographic",
        "orthographic": { "xmag": 4, "ymag": 2, "znear": 0, "zfar": 100 },
    });
    let (picture, _) = builder.render_whole(&["--spp", "1", "--resolution", "80x40"]);
    let lit = picture.pixels.iter().filter(|pixel| pixel[0] > 0.5).count();
    assert!((380..=420).contains(&lit), "{lit}");
}

#[test]
fn a_real_lens_takes_the_place_of_the_camera() {
    let mut builder = Builder::new();
    let texture = builder.texture([2, 2], &[[255; 4], [0; 4], [0; 4], [255; 4]]);
    builder.json["samplers"] = json!([{ "magFilter": 9728 }]);
    builder.json["textures"][texture]["sampler"] = json!(0);
    let mesh = builder.square(json!({
        "emissiveFactor": [1, 1, 1], "emissiveTexture": { "index": texture },
    }));
    builder.node(json!({ "mesh": mesh }));
    builder.json["cameras"][0]["perspective"]["aspectRatio"] = json!(1.5);
    let folder = folder();
    fs::write(folder.path().join("a.gltf"), builder.text()).expect("a file");
    let lens = root().join("lenses/dgauss.50mm.dat");
    let lens = lens.to_str().expect("a path");
    let sized = |options: &[&'static str]| {
        let all = [&["--lens", lens, "--resolution", "90x60", "--spp", "16"], options].concat();
        render(folder.path(), "a.gltf", &all).0
    };
    // Upright, and in focus without being told: the corners of the checks are dark and bright.
    let picture = sized(&[]);
    assert_eq!(picture.size, [90, 60]);
    let quarter = |x: usize, y: usize| mean(&picture, [x, y], [x + 20, y + 15])[0];
    let [a, b, c, d] = [quarter(20, 10), quarter(50, 10), quarter(20, 35), quarter(50, 35)];
    assert!(a > 20.0 * b && d > 20.0 * c, "{a} {b} {c} {d}");
    let edge = |picture: &petzval::Picture| {
        mean(picture, [42, 15], [43, 20])[0] / mean(picture, [47, 15], [48, 20])[0]
    };
    let near = sized(&["--focus", "0.5"]);
    assert!(edge(&picture) > 5.0 * edge(&near), "{} {}", edge(&picture), edge(&near));
    assert_eq!(picture.pixels, sized(&["--focus", "auto"]).pixels);
    assert_ne!(picture.pixels, sized(&["--focus", "inf"]).pixels);
    // Other options of the lens need one.
    let (code, _, said) = petzval(folder.path(), &["render", "a.gltf", "--fstop", "4"]);
    assert!(code == 2 && said.contains("--fstop is given"), "{code}: {said}");
}

#[test]
fn a_scene_without_a_camera_is_seen_from_the_front() {
    let mut builder = Builder::new();
    let mesh = lamp(&mut builder);
    builder.json["nodes"][0] = json!({ "mesh": mesh, "translation": [100, 5, 3] });
    let (picture, said) = builder.render_whole(&["--spp", "4", "--resolution", "64x36"]);
    assert!(said.contains("the scene has no camera"), "{said}");
    assert_eq!(mean(&picture, [28, 14], [36, 22]), [1.0; 3]);
    let border: f32 = picture.pixels[..64].iter().map(|pixel| pixel[0]).sum();
    assert_eq!(border, 0.0);
}

#[test]
fn only_the_first_camera_photographs() {
    let mut builder = Builder::new();
    let mesh = lamp(&mut builder);
    builder.node(json!({ "mesh": mesh }));
    builder.node(json!({ "camera": 0, "translation": [0, 0, -9] }));
    let (picture, said) = builder.render(&["--spp", "1"]);
    assert!(said.contains("nodes[2].camera: only the first camera photographs"), "{said}");
    assert_eq!(middle(&picture), [1.0; 3]);
}

#[test]
fn copies_of_a_mesh_are_where_their_nodes_are() {
    // Four matt squares as nodes of one mesh, as instances of one node, and as four meshes.
    let places = [[-0.5f32, -0.5, 0.0], [0.5, -0.5, 0.0], [0.5, 0.5, 0.0], [-0.5, 0.5, 0.0]];
    let grey = json!({ "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": 1 } });
    let scene = |kind: usize| {
        let mut builder = Builder::new();
        let scale = json!([0.25, 0.25, 0.25]);
        let mesh = builder.square(grey.clone());
        match kind {
            0 => {
                for place in places {
                    builder.node(json!({ "mesh": mesh, "translation": place, "scale": scale }));
                }
            }
            1 => {
                let translations = builder.vectors(&places.map(|place| place.map(|x| 4.0 * x)));
                let attributes = json!({ "TRANSLATION": translations });
                builder.node(json!({ "mesh": mesh, "scale": scale, "extensions": {
                    "EXT_mesh_gpu_instancing": { "attributes": attributes } } }));
            }
            _ => {
                for place in places {
                    let mesh = builder.square(grey.clone());
                    builder.node(json!({ "mesh": mesh, "translation": place, "scale": scale }));
                }
            }
        }
        builder.light(json!({ "type": "directional" }), json!({}));
        builder.render(&["--spp", "16"]).0
    };
    let [nodes, instances, meshes] = [0, 1, 2].map(scene);
    for (i, pixel) in meshes.pixels.iter().enumerate() {
        for other in [nodes.pixels[i], instances.pixels[i]] {
            assert!((pixel[0] - other[0]).abs() < 1e-3, "{i}: {pixel:?} {other:?}");
        }
    }
    assert!(meshes.pixels[16 * 64 + 16][0] > 0.2 && meshes.pixels[32 * 64 + 32][0] == 0.0);
}

#[test]
fn lights_among_copies_emit_in_every_place() {
    let mut builder = Builder::new();
    let mesh = lamp(&mut builder);
    for x in [-0.5, 0.5] {
        builder.node(json!({ "mesh": mesh, "translation": [x, 0, 0], "scale": [0.25, 0.25, 1] }));
    }
    let (picture, said) = builder.render(&["--spp", "4"]);
    assert!(!said.contains("no light"), "{said}");
    for x in [16, 48] {
        assert_eq!(mean(&picture, [x - 4, 28], [x + 4, 36]), [1.0; 3]);
    }
}
