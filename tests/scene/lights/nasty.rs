//! Extreme points, lights and pictures.

use petzval_image::Picture;
use petzval_scene::Scene;

use super::{at, closest, read, sample, scene};
use crate::support::Random;

/// Samples lights from a point, checks that all results are finite, and returns the number of
/// samples.
fn check_samples(scene: &Scene, position: [f32; 3]) -> u32 {
    let mut random = Random::new(9);
    let mut found = 0;
    for _ in 0..500 {
        let from = at(position, [0.0, 0.6, 0.8]);
        let Some(sample) = sample(scene, &from, &mut random) else { continue };
        found += 1;
        assert!(sample.direction.is_finite(), "{position:?} {sample:?}");
        assert!(sample.radiance.iter().all(|r| r.is_finite() && *r >= 0.0), "{sample:?}");
        assert!(sample.density.is_finite() && sample.density > 0.0, "{position:?} {sample:?}");
        let direction = sample.direction.normalize();
        let (ray, hit) = closest(scene, from.position, direction);
        if hit.shape != petzval_base::rays::NO_INDEX {
            let (_, point) = scene.surface(&ray, &hit);
            let density =
                scene.area_light_density(from.position, glam::Vec3::ZERO, &hit, &point, direction);
            assert!(density.is_finite() && density >= 0.0, "{position:?} {density}");
        }
    }
    found
}

const SHAPES: [&str; 6] = [
    "Shape \"sphere\"",
    "Scale 1 2 3 Shape \"sphere\"",
    "Shape \"disk\"",
    "Shape \"cone\"",
    "Shape \"trianglemesh\" \"point3 P\" [0 0 0  1 0 0  0 1 0]",
    // A regular triangle, slivers, a point and a line.
    "Shape \"trianglemesh\" \"point3 P\" [0 0 0  1 0 0  0 1 0  1e-20 0 0  1 1e-30 0  2 0 0]
     \"integer indices\" [0 1 2  0 1 3  0 0 0  0 1 5  0 1 4  1 1 2]",
];

#[test]
fn samples_are_finite_on_lights_and_far_away() {
    for shape in SHAPES {
        let world = format!("AreaLightSource \"diffuse\" \"bool twosided\" true {shape}");
        let scene = scene(&world);
        for position in [
            [0.0; 3],
            [1.0, 0.0, 0.0],
            [0.0, 0.0, 1.0],
            [0.25, 0.25, 0.0],
            [0.5, 0.5, 0.0],
            [1.0 + 1e-7, 0.0, 0.0],
            [1e-20, 0.0, 1e-20],
            [0.3, 0.2, 1e6],
            [1e6, 1e6, 1e6],
            [1e15, 0.0, 1e15],
            [1e30, 1e30, 1e30],
        ] {
            check_samples(&scene, position);
        }
        assert!(check_samples(&scene, [0.2, 0.1, 1e6]) > 100, "{shape} is seen from far away");
        assert!(check_samples(&scene, [0.2, 0.1, 2.0]) > 100, "{shape}");
    }
    let point_lights = scene("LightSource \"point\" LightSource \"spot\" \"point3 from\" [1 0 0]");
    for position in [[0.0; 3], [1.0, 0.0, 0.0], [1e-30, 0.0, 0.0], [1e6; 3]] {
        check_samples(&point_lights, position);
    }
}

#[test]
fn lights_without_power_are_never_chosen() {
    let dark = [
        "LightSource \"point\" \"rgb I\" [0 0 0]",
        "LightSource \"spot\" \"float scale\" 0",
        "LightSource \"distant\" \"rgb L\" [0 0 0]",
        "LightSource \"infinite\" \"rgb L\" [0 0 0]",
        "LightSource \"infinite\" \"string filename\" \"black.exr\"",
        "AreaLightSource \"diffuse\" \"rgb L\" [0 0 0] Translate 0 0 3 Shape \"sphere\"",
        "AreaLightSource \"diffuse\" \"string filename\" \"black.exr\" Shape \"sphere\"",
        "AreaLightSource \"diffuse\" Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 2 0 0]",
    ];
    let black = Picture { size: [4, 4], pixels: vec![[0.0; 3]; 16] };
    let read = |world: &str| read(&[("black.exr", &black)], world).expect("a scene");
    for world in dark {
        assert_eq!(check_samples(&read(world), [0.1, 0.2, -5.0]), 0, "{world}");
    }
    let lit = format!("LightSource \"point\" {}", dark.join("\n"));
    assert_eq!(
        check_samples(&read(&lit), [0.1, 0.2, -5.0]),
        500,
        "only the light with power is chosen"
    );
    assert_eq!(check_samples(&scene(""), [0.0; 3]), 0);
}

#[test]
fn black_pixels_of_the_sky_are_never_chosen() {
    let mut picture = Picture { size: [8, 8], pixels: vec![[0.0; 3]; 64] };
    picture.pixels[27] = [1.0; 3];
    picture.pixels[5] = [-3.0; 3];
    let world = "LightSource \"infinite\" \"string filename\" \"it.exr\"";
    let scene = read(&[("it.exr", &picture)], world).expect("a sky");
    let mut random = Random::new(4);
    for _ in 0..1000 {
        let from = at([0.0; 3], [0.0, 0.0, 1.0]);
        let sample = sample(&scene, &from, &mut random).expect("there is one bright pixel");
        assert_eq!(sample.radiance, [1.0; 3]);
        let expected = 64.0 / (4.0 * std::f32::consts::PI);
        assert!((sample.density / expected - 1.0).abs() < 1e-5, "{}", sample.density);
    }
}

#[test]
fn the_light_tree_is_finite_for_lights_ever_closer_together() {
    let lights: String = (0..300)
        .map(|i| format!("LightSource \"point\" \"point3 from\" [{} 0 0] ", 0.7f32.powi(i)))
        .chain((0..300).map(|_| "LightSource \"point\" \"point3 from\" [0 0 0] ".to_owned()))
        .collect();
    assert_eq!(check_samples(&scene(&lights), [0.5, 0.5, 0.5]), 500);
}

#[test]
fn invalid_lights_are_errors() {
    let infinite = Picture { size: [2, 2], pixels: vec![[f32::INFINITY; 3]; 4] };
    let wide = Picture { size: [4, 2], pixels: vec![[0.0; 3]; 8] };
    for (world, expected) in [
        ("LightSource \"spot\" \"float coneangle\" 0", "3:20: \"coneangle\" is 0; expected more"),
        ("LightSource \"spot\" \"float conedeltaangle\" -1", "\"conedeltaangle\" is -1"),
        ("LightSource \"spot\" \"point3 to\" [0 0 0]", "from and to must differ"),
        ("LightSource \"goniometric\"", "a goniometric light without \"string filename\""),
        ("LightSource \"goniometric\" \"string filename\" \"wide.exr\"", "of 4 x 2 pixels"),
        ("LightSource \"projection\" \"string filename\" \"wide.exr\" \"float fov\" 0", "fov"),
        ("LightSource \"projection\" \"string filename\" \"wide.exr\" \"float power\" 3", "power"),
        ("LightSource \"infinite\" \"string filename\" \"infinite.exr\"", "not finite numbers"),
        (
            "Scale 1e-200 1 1 Scale 1e-200 1 1 LightSource \"spot\"",
            "a spot light that its transform flattens",
        ),
        (
            "LightSource \"infinite\" \"string filename\" \"wide.exr\" \"float illuminance\" 3",
            "black",
        ),
        (
            "AreaLightSource \"diffuse\" \"rgb L\" [1 1 1] \"string filename\" \"wide.exr\"",
            "both \"L\" and \"filename\"",
        ),
        (
            "AreaLightSource \"diffuse\" \"float power\" 1 \"string filename\" \"wide.exr\"",
            "a power for an image that is black",
        ),
    ] {
        let pictures = [("infinite.exr", &infinite), ("wide.exr", &wide)];
        let said = read(&pictures, world).map(|_| ()).expect_err(world).to_string();
        assert!(said.contains(expected), "{world}\n  said {said}");
    }
}
