//! Scene language: defaults and units of lights and materials, and interfaces.

use std::f64::consts::PI;

use super::compare::{agree_with, found, job};
use super::material::{Colour, NaiveMaterial};
use super::rooms::{WALLS, lit_room, room};
use super::world::{Shape, World};
use crate::support::world::read_world_with_warnings;

/// Returns the mean of a picture with paths over one surface.
fn mean_of(text: &str) -> Colour {
    found(&job(text, None, 1)).mean
}

fn assert_seen(text: &str, expected: Colour) {
    let found_mean = mean_of(text);
    for c in 0..3 {
        let off = (found_mean[c] - expected[c]).abs();
        assert!(off <= 2e-3 * expected[c], "{text}\n{found_mean:?}, expected {expected:?}");
    }
}

/// A quad that fills the view, at distance 2, facing the camera.
const SCREEN: &str = r#"Shape "trianglemesh" "point3 P" [-9 -9 2  -9 9 2  9 9 2  9 -9 2]
    "integer indices" [0 1 2 0 2 3]"#;

#[test]
fn a_light_of_radiance_one_gives_pixels_of_one() {
    for (light, expected) in [
        (r#"LightSource "infinite""#, [1.0; 3]),
        (r#"LightSource "infinite" "rgb L" [1 2 3]"#, [1.0, 2.0, 3.0]),
        (r#"LightSource "infinite" "rgb L" [1 2 3] "float scale" 0.5"#, [0.5, 1.0, 1.5]),
        (r#"LightSource "infinite" "float illuminance" 6.283185"#, [2.0; 3]),
    ] {
        assert_seen(light, expected);
    }
    for (light, expected) in [
        (r#"AreaLightSource "diffuse""#, [1.0; 3]),
        (r#"AreaLightSource "diffuse" "rgb L" [1 2 3]"#, [1.0, 2.0, 3.0]),
        (r#"AreaLightSource "diffuse" "rgb L" [1 2 3] "float scale" 3"#, [3.0, 6.0, 9.0]),
        // Every triangle emits the power, from its 162 units of area.
        (r#"AreaLightSource "diffuse" "float power" 162"#, [1.0 / PI; 3]),
        (r#"AreaLightSource "diffuse" "float power" 162 "bool twosided" true"#, [0.5 / PI; 3]),
    ] {
        assert_seen(
            &format!(r#"{light} Material "diffuse" "rgb reflectance" [0 0 0] {SCREEN}"#),
            expected,
        );
    }
}

#[test]
fn a_blackbody_has_luminance_one() {
    for kelvin in [2700, 5000, 6500, 9000] {
        let [r, g, b] = mean_of(&format!(r#"LightSource "infinite" "blackbody L" {kelvin}"#));
        // ITU-R BT.709.
        let y = 0.2126 * r + 0.7152 * g + 0.0722 * b;
        assert!((y - 1.0).abs() < 5e-3, "{kelvin} K: {r} {g} {b}");
        assert!((r > b) == (kelvin < 7000), "{kelvin} K: {r} {g} {b}");
    }
}

#[test]
fn omitted_parameters_have_the_defaults_of_pbrt() {
    let sky = r#"LightSource "infinite" "#;
    for (material, expected) in [
        ("", 0.5),
        (r#"Material "diffuse""#, 0.5),
        // The sky behind the screen is as bright as that before it.
        (r#"Material "diffusetransmission""#, 0.5),
        (r#"Material "diffusetransmission" "float scale" 1.5"#, 0.75),
        (r#"Material "thindielectric""#, 1.0),
        (r#"Material "conductor" "rgb reflectance" [0.6 0.6 0.6]"#, 0.6),
    ] {
        let found_mean = mean_of(&format!("{sky} {material} {SCREEN}"));
        // Metals reflect more at the edge of the view than at normal incidence.
        let most = if material.contains("conductor") { 0.01 } else { 2e-3 };
        assert!(
            found_mean.iter().all(|&c| (c - expected).abs() < most),
            "{material}: {found_mean:?}"
        );
    }
    // A screen at distance 2, lit by a light of intensity 1 at the camera: the mean of
    // cos^3 / 4 times 0.5 / pi over the view.
    let steps = 400;
    let half = (super::world::FIELD.to_radians() / 2.0).tan();
    let place = |i: u32| half * ((f64::from(i) + 0.5) * 2.0 / f64::from(steps) - 1.0);
    let cells =
        (0..steps * steps).map(|i| 1.0 + place(i % steps).powi(2) + place(i / steps).powi(2));
    let mean = cells.map(|d2| d2.powf(-1.5)).sum::<f64>() / f64::from(steps * steps);
    assert_seen(&format!(r#"LightSource "point" {SCREEN}"#), [mean / 4.0 * 0.5 / PI; 3]);
    let power = r#"LightSource "point" "rgb I" [1 1 1] "float power" 12.566371"#;
    assert_seen(&format!("{power} {SCREEN}"), [mean / 4.0 * 0.5 / PI; 3]);
    assert_seen(&format!(r#"LightSource "distant" {SCREEN}"#), [0.5 / PI; 3]);
}

#[test]
fn an_interface_material_is_invisible() {
    let shell = r#"AttributeBegin Material "interface" AreaLightSource "diffuse" "rgb L" [9 9 9]
        Translate 0 0 3 Shape "sphere" "float radius" 1.9 AttributeEnd
        AttributeBegin Material "" Shape "sphere" "float radius" 0.1 AttributeEnd"#;
    let description = read_world_with_warnings(shell);
    assert!(
        description.warnings.iter().any(|w| w.message.contains("emits no light")),
        "{:?}",
        description.warnings
    );
    let world =
        lit_room([Shape::ball([0.0, -0.5, 3.0], 1.0, NaiveMaterial::Diffuse([0.9, 0.6, 0.3]))]);
    agree_with(&(world.text() + shell), &world, 3);
    let dark = World { shapes: room(WALLS), ..World::default() };
    assert_eq!(mean_of(&(dark.text() + shell)), [0.0; 3]);
}

/// A path finds a point light by way of a smooth mirror only if the mirror is rougher after the
/// wall, as `regularize` makes it.
#[test]
fn regularize_finds_the_light_that_a_mirror_throws_on_a_wall() {
    let mean_with = |regularize: bool| {
        let text = format!(
            r#"Film "rgb" "integer xresolution" 16 "integer yresolution" 16
               Sampler "independent" "integer pixelsamples" 256
               Integrator "path" "integer maxdepth" 2 "bool regularize" {regularize}
               Camera "perspective" "float fov" 40
               WorldBegin
               LightSource "point" "point3 from" [0 0 1]
               Material "diffuse" "rgb reflectance" [0.8 0.8 0.8]
               Shape "bilinearmesh" "point3 P" [-3 -3 4  3 -3 4  -3 3 4  3 3 4]
               Material "conductor" "rgb reflectance" [0.9 0.9 0.9]
               Shape "bilinearmesh" "point3 P" [2 -3 0  2 -3 4  2 3 0  2 3 4]"#
        );
        super::compare::found(&super::compare::job_of(&text, None)).mean[1]
    };
    let [without, with] = [false, true].map(mean_with);
    let ratio = with / without;
    assert!((1.02..1.5).contains(&ratio), "{with}, without regularize {without}");
}
