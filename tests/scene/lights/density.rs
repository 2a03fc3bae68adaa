//! Densities: light samples follow the densities that they report.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};
use petzval_base::rays::NO_INDEX;
use petzval_scene::SkySampling;

use super::{Mean, at, closest, patchwork, read, sample, scene};
use crate::support::Random;

const SHINES: &str = "AreaLightSource \"diffuse\" \"rgb L\" [1 1 1]";
const QUAD: &str = "Shape \"trianglemesh\" \"point3 P\" [-1 -1 0  1 -1 0  1 1 0  -1 1 0]
    \"integer indices\" [0 1 2 2 3 0]";

/// Returns the irradiance over the radiance at the origin, with normal +z, under a polygon (Lambert
/// 1760): half the sum of the angles of the sides, weighted by the cosines of their planes.
fn lambert(corners: &[DVec3]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    let sides = corners.iter().zip(next);
    let sum: f64 = sides.map(|(a, b)| a.angle_between(*b) * a.cross(*b).normalize().z).sum();
    (sum / 2.0).abs()
}

#[test]
fn the_mean_inverse_density_is_the_solid_angle() {
    let from = at([0.0; 3], [0.0, 0.0, 1.0]);
    let assert_angle = |world: &str, expected: f64| {
        let scene = scene(&format!("{SHINES} {world}"));
        Mean::of(&scene, &from, 100_000, |_| 1.0).assert_is(expected);
    };
    for (distance, radius) in [(1.01, 1.0), (2.0, 1.0), (1e3, 1.0), (5.0, 1e-4)] {
        let sin2 = f64::powi(radius / distance, 2);
        let expected = TAU * sin2 / (1.0 + (1.0 - sin2).sqrt());
        let world = format!("Translate {distance} 0 0 Shape \"sphere\" \"float radius\" {radius}");
        assert_angle(&world, expected);
    }
    // A square of side 2 a at height h: 4 asin (a^2 / (a^2 + h^2)).
    for height in [0.01, 1.0, 30.0, 1e4] {
        let expected = 4.0 * (1.0f64 / (1.0 + height * height)).asin();
        assert_angle(&format!("Translate 0 0 {height} Rotate 180 1 0 0 {QUAD}"), expected);
    }
    let expected = TAU * (1.0 - 2.0 / 5f64.sqrt());
    assert_angle("Translate 0 0 2 Rotate 180 1 0 0 Shape \"disk\"", expected);
    // The inside of a sphere covers all directions.
    assert_angle("ReverseOrientation Translate 0.3 0.2 0 Shape \"sphere\"", 2.0 * TAU);
}

#[test]
fn a_uniform_sky_is_not_sampled() {
    let from = at([0.0; 3], [0.0, 0.0, 1.0]);
    let sky = scene("LightSource \"infinite\" \"rgb L\" [2 2 2]");
    assert!(sample(&sky, &from, &mut Random::new(1)).is_none());
    assert_eq!(sky.sky_density(0, Vec3::ZERO, Vec3::Z, SkySampling::Complete), 0.0);
    // Other lights get all samples.
    let both = scene("LightSource \"infinite\" LightSource \"distant\"");
    let sample = sample(&both, &from, &mut Random::new(1)).expect("the distant light");
    assert!(sample.singular && sample.density == 1.0);
}

#[test]
fn alpha_scales_the_light_of_an_emitter() {
    let from = at([0.0; 3], [0.0, 0.0, 1.0]);
    let corners =
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(a, b)| DVec3::new(a, b, 3.0));
    let whole = lambert(&corners);
    let board = "Texture \"t\" \"float\" \"checkerboard\" \"float uscale\" 40 \"float vscale\" 40
        \"float tex1\" 0.25 \"float tex2\" 0.75";
    for (alpha, share) in [("\"float alpha\" 0.3", 0.3), ("\"texture alpha\" \"t\"", 0.5)] {
        let quad = QUAD.to_owned() + " \"point2 uv\" [0 0  1 0  1 1  0 1] " + alpha;
        let world = format!("{board} {SHINES} Translate 0 0 3 Rotate 180 1 0 0 {quad}");
        Mean::irradiance(&scene(&world), &from, 400_000).assert_is(share * whole);
    }
    // No ray can hit an emitter of alpha 0, so its samples are singular.
    let unseen = format!("{SHINES} Translate 0 0 3 Rotate 180 1 0 0 {QUAD} \"float alpha\" 0");
    let unseen = scene(&unseen);
    Mean::irradiance(&unseen, &from, 400_000).assert_is(whole);
    assert!(sample(&unseen, &from, &mut Random::new(1)).is_some_and(|sample| sample.singular));
    assert_eq!(closest(&unseen, Vec3::ZERO, Vec3::Z).1.shape, NO_INDEX);
}

#[test]
fn samples_of_stretched_spheres_cover_the_solid_angle_that_rays_hit() {
    let scene = scene(&format!(
        "{SHINES} Translate 0.5 0 4 Rotate 30 1 1 0 Scale 1 2 0.5 Shape \"sphere\""
    ));
    let from = at([0.0; 3], [0.0, 0.0, 1.0]);
    // Rays in a cone of 50 degrees half-angle about z.
    let (side, versine) = (1000, 1.0 - f64::to_radians(50.0).cos());
    let mut hits = 0;
    for i in 0..side * side {
        let [u, v] = [i % side, i / side].map(|i| (f64::from(i) + 0.5) / f64::from(side));
        let (z, (sin, cos)) = (1.0 - u * versine, (v * TAU).sin_cos());
        let r = (1.0 - z * z).sqrt();
        let direction = DVec3::new(r * cos, r * sin, z).as_vec3();
        hits += u32::from(closest(&scene, from.position, direction).1.shape != NO_INDEX);
    }
    let expected = TAU * versine * f64::from(hits) / f64::from(side * side);
    Mean::of(&scene, &from, 1_500_000, |_| 1.0).assert_is(expected);
}

#[test]
fn irradiance_has_the_closed_form() {
    let from = at([0.0; 3], [0.0, 0.0, 1.0]);
    let assert_irradiance = |world: &str, expected: f64| {
        let scene = scene(&format!("{SHINES} {world}"));
        Mean::irradiance(&scene, &from, 400_000).assert_is(expected);
    };
    // A sphere above the horizon: pi L sin^2 cos.
    assert_irradiance("Translate 1 0 2 Shape \"sphere\" \"float radius\" 1.5", {
        PI * 2.25 / 5.0 * 2.0 / 5f64.sqrt()
    });
    assert_irradiance(
        "Translate 0 0 2 Rotate 180 1 0 0 Shape \"disk\" \"float radius\" 3",
        PI * 9.0 / 13.0,
    );
    assert_irradiance(
        "Translate 0 0 2 Rotate 180 1 0 0 Shape \"disk\" \"float radius\" 3 \"float innerradius\" 1",
        PI * (9.0 / 13.0 - 1.0 / 5.0),
    );
    for (x, height) in [(0.0, 0.1), (0.7, 1.0), (3.0, 2.0), (40.0, 30.0)] {
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(a, b)| DVec3::new(x + a, b, height));
        let world = format!("Translate {x} 0 {height} Rotate 180 1 0 0 {QUAD}");
        assert_irradiance(&world, lambert(&corners));
    }
}

#[test]
fn sky_pictures_have_the_irradiance_of_their_integral() {
    let from = at([0.0; 3], [0.3, -0.5, 0.8]);
    let turned = "Rotate 50 1 2 3";
    // The density must include the transform's change of solid angles.
    let stretched = "Rotate 20 0 1 0 Scale 1 2 1";
    for (size, transform) in
        [([16, 16], turned), ([16, 16], stretched), ([32, 16], turned), ([32, 16], stretched)]
    {
        let world = format!("{transform} LightSource \"infinite\" \"string filename\" \"sky.exr\"");
        let scene = read(&[("sky.exr", &patchwork(size))], &world).expect("a sky");
        let (columns, rows) = (2000, 1000);
        let mut expected = 0.0;
        for row in 0..rows {
            let (sin, z) = ((f64::from(row) + 0.5) / f64::from(rows) * PI).sin_cos();
            for column in 0..columns {
                let (y, x) = (f64::from(column) / f64::from(columns) * TAU).sin_cos();
                let direction = DVec3::new(x * sin, y * sin, z).as_vec3();
                let cos = f64::from(from.normal.dot(direction));
                if cos > 0.0 {
                    expected +=
                        f64::from(scene.sky_radiance(0, Vec3::ZERO, direction)[0]) * cos * sin;
                }
            }
        }
        expected *= PI / f64::from(rows) * TAU / f64::from(columns);
        Mean::irradiance(&scene, &from, 2_200_000).assert_is(expected);
    }
}

#[test]
fn the_density_of_a_hit_equals_that_of_the_sample() {
    let sky = "LightSource \"infinite\" \"string filename\" \"sky.exr\"";
    let worlds = [
        "Translate 1 0 2 Shape \"sphere\"".to_owned(),
        "ReverseOrientation Shape \"sphere\" \"float radius\" 3".to_owned(),
        "Translate 0 0 2 Rotate 30 1 0 0 Scale 1 2 0.5 Shape \"sphere\"".to_owned(),
        "Translate 0 0 2 Rotate 150 1 0 0 Shape \"disk\" \"float radius\" 3 \"float phimax\" 200"
            .to_owned(),
        "Translate 0 0 1 Rotate 20 0 1 0 Scale 1 1 2 Shape \"cone\"".to_owned(),
        format!("Translate 0 0 1 Rotate 170 1 0 0 {QUAD}"),
        format!("Translate 9 0 90 Rotate 170 1 0 0 {QUAD} Translate 0 0 80 {QUAD} {sky}"),
        format!("{sky} LightSource \"distant\" {sky} LightSource \"point\""),
    ];
    for world in &worlds {
        let shines = "AreaLightSource \"diffuse\" \"bool twosided\" true";
        let world = format!("{shines} {world}");
        let scene = read(&[("sky.exr", &patchwork([16, 16]))], &world).expect("a scene");
        let mut random = Random::new(11);
        let (mut compared, mut wrong) = (0, 0);
        for _ in 0..20_000 {
            let place = [0; 3].map(|_| random.between(-0.5, 0.5) as f32);
            let from = at(place, [0.0, 0.0, 1.0]);
            let Some(sample) = sample(&scene, &from, &mut random) else { continue };
            if sample.singular {
                continue;
            }
            let direction = sample.direction.normalize();
            let mut grazing = 0.0;
            let density = if sample.t_max.is_infinite() {
                // Skies with the same picture have different numbers.
                scene.sky_density(
                    scene.lights.skies[0],
                    Vec3::ZERO,
                    direction,
                    SkySampling::Complete,
                )
            } else {
                let (ray, hit) = closest(&scene, from.position, direction);
                if hit.shape == NO_INDEX {
                    wrong += 1;
                    continue;
                }
                let (_, point) = scene.surface(&ray, &hit);
                if point.position.distance(from.position + sample.direction) > 1e-3 {
                    continue;
                }
                grazing = 1e-5 / point.normal.dot(direction).powi(2);
                scene.area_light_density(from.position, Vec3::ZERO, &hit, &point, direction)
            };
            compared += 1;
            let off = (density / sample.density - 1.0).abs();
            // At grazing incidence, rounding moves the hit point.
            let allowed = 1e-3 + grazing;
            wrong += i32::from(off.is_nan() || off > allowed);
        }
        assert!(compared > 5_000, "{world}: {compared}");
        // At the edges of pixels and triangles, rounding may choose the other side.
        assert!(wrong < compared / 200, "{world}: {wrong} of {compared}");
    }
}

#[test]
fn samples_of_emission_images_have_the_radiance_that_rays_see() {
    let world = "AreaLightSource \"diffuse\" \"string filename\" \"light.exr\" \"float scale\" 3
        Translate 0 0 1 Rotate 180 1 0 0 Shape \"trianglemesh\" \"point3 P\"
        [-1 -1 0  1 -1 0  1 1 0  -1 1 0] \"point2 uv\" [0 0 1 0 1 1 0 1]
        \"integer indices\" [0 1 2 2 3 0]";
    let scene = read(&[("light.exr", &patchwork([8, 8]))], world).expect("a scene");
    let from = at([0.1, 0.2, 0.0], [0.0, 0.0, 1.0]);
    let mut random = Random::new(5);
    for _ in 0..2_000 {
        let Some(sample) = sample(&scene, &from, &mut random) else { continue };
        let (ray, hit) = closest(&scene, from.position, sample.direction.normalize());
        let seen = scene.emitted_radiance(&ray, &hit, Vec3::NEG_Z, -sample.direction.normalize());
        assert!((seen[0] - sample.radiance[0]).abs() < 1e-3 * (1.0 + seen[0]), "{seen:?}");
        assert_eq!(scene.emitted_radiance(&ray, &hit, Vec3::NEG_Z, sample.direction), [0.0; 3]);
    }
    // v points up in the picture, so its lowest row is at (u, v) = (0, 0), the corner (-1, 1) after
    // the rotation.
    let (ray, hit) = closest(&scene, Vec3::ZERO, Vec3::new(-0.999, 0.999, 1.0).normalize());
    let found = scene.emitted_radiance(&ray, &hit, Vec3::NEG_Z, Vec3::NEG_Z);
    let corner = patchwork([8, 8]).pixels[56];
    for channel in 0..3 {
        assert!((found[channel] - 3.0 * corner[channel]).abs() < 0.01, "{found:?} {corner:?}");
    }
}
