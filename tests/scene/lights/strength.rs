//! Strength of lights: pbrt-v4's units and falloffs.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};
use petzval_image::Picture;
use petzval_scene::{Light, Scene, luminance};

use super::{Mean, at, closest, patchwork, read, scene};

/// Returns the intensity of a scene's only light, a point light, in a direction.
fn intensity(scene: &Scene, direction: DVec3) -> [f32; 3] {
    let Light::Point(light) = &scene.lights.all[0] else { panic!("a point light") };
    light.towards(direction.as_vec3())
}

/// Integrates a function over all directions.
fn integrate(f: impl Fn(DVec3) -> f64) -> f64 {
    let (columns, rows) = (1200, 1200);
    let mut sum = 0.0;
    for row in 0..rows {
        let z = 1.0 - 2.0 * (f64::from(row) + 0.5) / f64::from(rows);
        let r = (1.0 - z * z).sqrt();
        for column in 0..columns {
            let (y, x) = ((f64::from(column) + 0.5) / f64::from(columns) * TAU).sin_cos();
            sum += f(DVec3::new(x * r, y * r, z));
        }
    }
    sum * 2.0 * TAU / f64::from(rows * columns)
}

fn assert_near(found: f64, expected: f64, tolerance: f64) {
    assert!((found / expected - 1.0).abs() < tolerance, "{found} instead of {expected}");
}

#[test]
fn point_lights_emit_their_power() {
    for world in [
        "LightSource \"point\" \"float power\" 50",
        "LightSource \"spot\" \"float power\" 50 \"float coneangle\" 40 \"float conedeltaangle\" 25",
        "Rotate 90 1 0 0 LightSource \"spot\" \"float power\" 50 \"point3 to\" [1 1 0]",
    ] {
        let scene = scene(world);
        assert_near(integrate(|d| f64::from(intensity(&scene, d)[1])), 50.0, 2e-3);
    }
    let picture = patchwork([12, 12]);
    let world = "LightSource \"goniometric\" \"string filename\" \"it.exr\" \"float power\" 50 \"float scale\" 2";
    let scene = read(&[("it.exr", &picture)], world).expect("a light");
    assert_near(integrate(|d| f64::from(intensity(&scene, d)[0])), 100.0, 5e-3);
    // The power of a projection is weighted by luminance.
    let picture = patchwork([12, 8]);
    let world = "LightSource \"projection\" \"string filename\" \"it.exr\" \"float power\" 50 \"float fov\" 60";
    let scene = read(&[("it.exr", &picture)], world).expect("a light");
    assert_near(integrate(|d| f64::from(luminance(intensity(&scene, d)))), 50.0, 1e-2);
}

#[test]
fn a_spot_fades_by_a_smooth_step_of_the_cosine() {
    let scene = scene(
        "Translate 1 2 3 LightSource \"spot\" \"rgb I\" [2 2 2] \"float scale\" 1.5
         \"point3 from\" [0 1 0] \"point3 to\" [0 -5 0] \"float coneangle\" 30 \"float conedeltaangle\" 10",
    );
    let at_angle = |degrees: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        f64::from(intensity(&scene, DVec3::new(sin * 0.6, -cos, sin * 0.8))[2])
    };
    assert_eq!(at_angle(0.0), 3.0);
    assert_eq!(at_angle(19.9), 3.0);
    assert_eq!(at_angle(30.1), 0.0);
    let cos = |degrees: f64| degrees.to_radians().cos();
    let t = (cos(25.0) - cos(30.0)) / (cos(20.0) - cos(30.0));
    assert_near(at_angle(25.0), 3.0 * t * t * (3.0 - 2.0 * t), 1e-4);
    // The irradiance below falls off with the square of the distance.
    let from = at([1.0, -1.0, 3.0], [0.0, 1.0, 0.0]);
    Mean::irradiance(&scene, &from, 100).assert_is(3.0 / 16.0);
}

#[test]
fn goniometric_diagrams_and_projections_are_upright() {
    let mut picture = Picture { size: [4, 4], pixels: vec![[0.0; 3]; 16] };
    picture.pixels[1] = [1.0, 2.0, 3.0];
    let world = "LightSource \"projection\" \"string filename\" \"it.exr\" \"float fov\" 90";
    let light = read(&[("it.exr", &picture)], world).expect("a light");
    // The second pixel of the top row is slightly towards -x.
    assert_eq!(intensity(&light, DVec3::new(-0.3, 0.8, 1.0)), [1.0, 2.0, 3.0]);
    assert_eq!(intensity(&light, DVec3::new(0.3, 0.8, 1.0)), [0.0; 3]);
    assert_eq!(intensity(&light, DVec3::new(-0.3, -0.8, 1.0)), [0.0; 3]);
    assert_eq!(intensity(&light, DVec3::new(-0.3, 0.8, -1.0)), [0.0; 3]);
    assert_eq!(intensity(&light, DVec3::new(-0.3, 1.2, 1.0)), [0.0; 3]);
    // The pole of a goniometric diagram is y, as in pbrt-v4. Its value is the mean of the channels.
    let mut picture = Picture { size: [3, 3], pixels: vec![[0.0; 3]; 9] };
    picture.pixels[4] = [1.0, 2.0, 6.0];
    let world = "LightSource \"goniometric\" \"string filename\" \"it.exr\" \"rgb I\" [1 2 1]";
    let light = read(&[("it.exr", &picture)], world).expect("a light");
    assert_eq!(intensity(&light, DVec3::Y), [3.0, 6.0, 3.0]);
    assert_eq!(intensity(&light, DVec3::Z), [0.0; 3]);
}

#[test]
fn illuminance_is_that_of_a_patch_facing_the_light() {
    let up = at([0.0; 3], [0.0, 0.0, 1.0]);
    let sun =
        "LightSource \"distant\" \"rgb L\" [1 1 1] \"point3 from\" [0 0 1] \"point3 to\" [0 0 0]";
    let sun = scene(&format!("{sun} \"float illuminance\" 700"));
    Mean::irradiance(&sun, &up, 100).assert_is(700.0);
    for more in ["\"rgb L\" [1 1 1]", ""] {
        let sky = scene(&format!("LightSource \"infinite\" \"float illuminance\" 700 {more}"));
        assert_near(f64::from(sky.sky_radiance(0, Vec3::ZERO, Vec3::Y)[0]) * PI, 700.0, 1e-5);
    }
    // As in pbrt-v4, pixels of a picture count with half their solid angle.
    let grey = Picture { size: [64, 64], pixels: vec![[0.25; 3]; 4096] };
    let world = "LightSource \"infinite\" \"string filename\" \"it.exr\" \"float illuminance\" 700";
    let sky = read(&[("it.exr", &grey)], world).expect("a sky");
    assert_near(f64::from(sky.sky_radiance(0, Vec3::ZERO, Vec3::Y)[0]) * PI, 1400.0, 2e-3);
}

#[test]
fn every_triangle_emits_the_power_of_its_area_light() {
    let seen = |world: &str, from: [f32; 3], towards: [f32; 3]| {
        let scene = scene(world);
        let direction = Vec3::from(towards).normalize();
        let (ray, hit) = closest(&scene, from.into(), direction);
        let (_, point) = scene.surface(&ray, &hit);
        f64::from(scene.emitted_radiance(&ray, &hit, point.normal, -direction)[0])
    };
    let light = "AreaLightSource \"diffuse\" \"float power\" 30";
    let down = [0.0, 0.0, -1.0];
    // A triangle of area 2 and one of area 8.
    let mesh = format!(
        "{light} Shape \"trianglemesh\" \"point3 P\" [0 0 0  2 0 0  0 2 0  8 0 0  8 4 0  4 4 0]
         \"integer indices\" [0 1 2 3 4 5]"
    );
    assert_near(seen(&mesh, [0.5, 0.5, 1.0], down), 30.0 / (2.0 * PI), 1e-5);
    assert_near(seen(&mesh, [7.5, 2.5, 1.0], down), 30.0 / (8.0 * PI), 1e-5);
    let both = format!("{light} \"bool twosided\" true Shape \"disk\" \"float radius\" 2");
    assert_near(seen(&both, [0.5, 0.5, 1.0], down), 30.0 / (2.0 * 4.0 * PI * PI), 1e-3);
    let sphere = format!("{light} \"float scale\" 2 Scale 3 3 3 Shape \"sphere\"");
    assert_near(seen(&sphere, [0.0, 0.0, 9.0], down), 60.0 / (36.0 * PI * PI), 1e-3);
    let grey = Picture { size: [4, 4], pixels: vec![[0.25; 3]; 16] };
    let world = "AreaLightSource \"diffuse\" \"float power\" 30 \"string filename\" \"it.exr\"
        Shape \"disk\"";
    let scene = read(&[("it.exr", &grey)], world).expect("a light");
    let (ray, hit) = closest(&scene, Vec3::Z, Vec3::NEG_Z);
    assert_near(
        f64::from(scene.emitted_radiance(&ray, &hit, Vec3::Z, Vec3::Z)[0]),
        30.0 / (PI * PI),
        1e-3,
    );
}
