//! Lights of KHR_lights_punctual, by their values and by each other.

use serde_json::{Value, json};

use super::{Builder, mean, middle};

/// Renders a white square that a light shines on from its node.
fn lit(light: Value, node: Value) -> petzval::Picture {
    let mut builder = Builder::new();
    let white = json!({ "metallicFactor": 0, "roughnessFactor": 1 });
    let mesh = builder.square(json!({ "pbrMetallicRoughness": white }));
    builder.node(json!({ "mesh": mesh }));
    builder.light(light, node);
    builder.render(&["--spp", "16"]).0
}

#[test]
fn point_lights_follow_the_inverse_square_and_directional_ones_do_not() {
    let point = |distance: f64, intensity: f64| {
        let light = json!({ "type": "point", "intensity": intensity, "color": [1, 0.5, 0] });
        middle(&lit(light, json!({ "translation": [0, 0, distance] })))
    };
    let [near, far] = [point(10.0, 100.0), point(20.0, 100.0)];
    assert!((near[0] / far[0] - 4.0).abs() < 0.05, "{near:?} {far:?}");
    assert!((near[1] / near[0] - 0.5).abs() < 1e-3 && near[2] == 0.0, "{near:?}");
    // 100 cd at 10 m are 1 lx.
    let sun = |distance: f64| {
        let light = json!({ "type": "directional", "intensity": 1 });
        middle(&lit(light, json!({ "translation": [0, 0, distance] })))[0]
    };
    assert!((sun(10.0) / near[0] - 1.0).abs() < 0.01, "{} {near:?}", sun(10.0));
    assert_eq!(sun(10.0), sun(-5.0));
    // A white surface of nearly no gloss sends back about E / pi.
    let lambert = std::f32::consts::FRAC_1_PI;
    assert!((near[0] / lambert - 1.0).abs() < 0.1, "{near:?}");
}

#[test]
fn spots_shine_along_minus_z_within_their_cone() {
    let spot = json!({ "type": "spot", "intensity": 100,
                       "spot": { "innerConeAngle": 0.02, "outerConeAngle": 0.03 } });
    let picture = lit(spot.clone(), json!({ "translation": [0, 0, 10] }));
    // The cone ends 0.3 from the axis, and is whole within 0.2.
    let row: Vec<f32> = (0..32).map(|x| mean(&picture, [32 + x, 32], [33 + x, 33])[0]).collect();
    let point =
        lit(json!({ "type": "point", "intensity": 100 }), json!({ "translation": [0, 0, 10] }));
    let whole = middle(&point)[0];
    assert!((row[2] / whole - 1.0).abs() < 0.02 && row[12] == 0.0, "{row:?}");
    assert!(row[8] > 0.05 * whole && row[8] < 0.95 * whole, "{row:?}");
    // Turned about y by a right angle, it misses the square.
    let turned =
        json!({ "translation": [0, 0, 10], "rotation": [0, 0.5f64.sqrt(), 0, 0.5f64.sqrt()] });
    assert_eq!(middle(&lit(spot, turned)), [0.0; 3]);
}

#[test]
fn lights_follow_the_transforms_of_their_parents() {
    let mut builder = Builder::new();
    let white = json!({ "metallicFactor": 0, "roughnessFactor": 1 });
    let mesh = builder.square(json!({ "pbrMetallicRoughness": white }));
    builder.node(json!({ "mesh": mesh }));
    builder
        .light(json!({ "type": "point", "intensity": 100 }), json!({ "translation": [0, 0, 5] }));
    let child = builder.json["nodes"].as_array().expect("nodes").len() - 1;
    builder.json["scenes"][0]["nodes"].as_array_mut().expect("nodes").pop();
    builder.node(json!({ "children": [child], "scale": [2, 2, 2] }));
    let moved = middle(&builder.render(&["--spp", "16"]).0)[0];
    let light = json!({ "type": "point", "intensity": 100 });
    let direct = middle(&lit(light, json!({ "translation": [0, 0, 10] })))[0];
    assert!((moved / direct - 1.0).abs() < 1e-3, "{moved} {direct}");
}

#[test]
fn impossible_lights_are_refused() {
    for (light, expected) in [
        (json!({ "type": "area" }), "lights[0].type: a light of an unknown type"),
        (json!({ "type": "point", "intensity": -1 }), "lights[0]: an intensity of"),
        (json!({ "type": "spot", "spot": { "outerConeAngle": 2 } }), "lights[0].spot: cone angles"),
    ] {
        let mut builder = Builder::new();
        builder.light(light, json!({}));
        let folder = super::folder();
        let path = folder.path().join("a.gltf");
        std::fs::write(&path, builder.text()).expect("a file");
        let said = petzval_scene_formats::read(&path).expect_err("an error").to_string();
        assert!(said.contains(expected), "{said}");
    }
}
