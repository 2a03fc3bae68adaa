//! Many lights: the choice among them, and its noise.

use std::time::Instant;

use petzval_scene::{Emission, Geometry, Material, Mesh, Scene, SceneBuilder, ShapeSpec};

use super::{Mean, at, closest, sample, scene};
use crate::support::Random;

/// A square of side 4 at height 2 that emits downwards, of n x n squares of two triangles.
fn ceiling(n: u32) -> Scene {
    let mut mesh = Mesh { flipped: true, ..Mesh::default() };
    let place = |i: u32| 4.0 * i as f32 / n as f32 - 2.0;
    for j in 0..=n {
        mesh.positions.extend((0..=n).map(|i| [place(i), place(j), 2.0]));
    }
    for j in 0..n {
        for i in 0..n {
            let [a, b] = [j * (n + 1) + i, (j + 1) * (n + 1) + i];
            mesh.triangles.extend([[a, a + 1, b + 1], [a, b + 1, b]]);
        }
    }
    let mut builder = SceneBuilder::default();
    let material = builder.add_material(Material::diffuse([0.5; 3]));
    builder.add_shape(ShapeSpec {
        emission: Some(Emission::uniform([1.0; 3])),
        ..ShapeSpec::new(Geometry::Mesh(mesh), material)
    });
    builder.build().unwrap()
}

#[test]
fn ten_thousand_triangles_have_at_most_three_times_the_variance_of_two() {
    // Two triangles are sampled exactly by solid angle, so only the cosine adds noise. The light
    // tree estimates solid angles from the bounds of its nodes.
    let (one, many) = (ceiling(1), ceiling(71));
    let mut random = Random::new(1);
    for _ in 0..10 {
        let place = [random.between(-2.0, 2.0), random.between(-2.0, 2.0), 0.0];
        let from = at(place.map(|v| v as f32), [0.0, 0.0, 1.0]);
        let one = Mean::irradiance(&one, &from, 40_000);
        let many = Mean::irradiance(&many, &from, 40_000);
        let noise = (many.error / one.error).powi(2);
        println!("{place:?} {noise} {one:?}");
        assert!(noise < 3.0, "variance {noise} times that of one square at {place:?}");
        let apart = (many.mean - one.mean).abs();
        assert!(apart < 6.0 * (many.error + one.error), "{many:?} {one:?}");
    }
}

#[test]
fn triangles_are_chosen_in_proportion_to_their_density() {
    let scene = ceiling(3);
    let from = at([0.5, 0.3, 1.0], [0.0, 0.0, 1.0]);
    let mut random = Random::new(2);
    let (mut counts, mut means) = ([0.0f64; 18], [0.0f64; 18]);
    let n = 400_000;
    for _ in 0..n {
        let Some(sample) = sample(&scene, &from, &mut random) else { continue };
        let (_, hit) = closest(&scene, from.position, sample.direction.normalize());
        // Rays to the edge may miss by rounding.
        if let Some(count) = counts.get_mut(hit.primitive as usize) {
            *count += 1.0;
        }
        // The expected count, by integrating the density over uniform directions.
        let z = random.next();
        let (y, x) = (random.next() * std::f64::consts::TAU).sin_cos();
        let r = (1.0 - z * z).sqrt();
        let direction = glam::DVec3::new(x * r, y * r, z).as_vec3().normalize();
        let (ray, hit) = closest(&scene, from.position, direction);
        if let Some(mean) = means.get_mut(hit.primitive as usize) {
            let (_, point) = scene.surface(&ray, &hit);
            let density =
                scene.area_light_density(from.position, glam::Vec3::ZERO, &hit, &point, direction);
            *mean += f64::from(density) * std::f64::consts::TAU;
        }
    }
    assert!((means.iter().sum::<f64>() / f64::from(n) - 1.0).abs() < 0.01);
    for (count, mean) in counts.into_iter().zip(means) {
        // Both have standard errors; that of the second depends on the size of a triangle.
        let allowed = 6.0 * (count.sqrt() + mean * 0.01);
        assert!((count - mean).abs() < allowed, "{count} instead of {mean}");
    }
}

#[test]
fn lights_of_all_kinds_add_up() {
    let lights = [
        "LightSource \"point\" \"rgb I\" [3 3 3] \"point3 from\" [0 1 2]",
        "LightSource \"spot\" \"rgb I\" [9 9 9] \"point3 from\" [1 0 3] \"point3 to\" [0.2 0 0]",
        "LightSource \"distant\" \"rgb L\" [0.3 0.3 0.3] \"point3 from\" [0 1 1] \"point3 to\" [0 0 0]",
        "LightSource \"infinite\" \"rgb L\" [0.2 0.2 0.2]",
        "AttributeBegin AreaLightSource \"diffuse\" Translate 1 1 2 Shape \"sphere\" AttributeEnd",
        "AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [0 0 0] Shape \"sphere\" AttributeEnd",
        "AttributeBegin AreaLightSource \"diffuse\" \"bool twosided\" true Translate -2 1 2
         Shape \"disk\" AttributeEnd",
    ];
    let from = at([0.0; 3], [0.0, 0.0, 1.0]);
    let mut expected = 0.0;
    for light in lights {
        expected += Mean::irradiance(&scene(light), &from, 300_000).mean;
    }
    Mean::irradiance(&scene(&lights.join("\n")), &from, 1_500_000).assert_is(expected);
}

#[test]
#[ignore = "measures time; .ci/long runs it"]
fn a_light_tree_of_a_million_triangles_takes_a_second() {
    let start = Instant::now();
    let scene = ceiling(708);
    let whole = start.elapsed();
    let shapes = scene.shapes.clone();
    let lights = scene.lights.all.clone();
    let start = Instant::now();
    let again = petzval_scene::Lights::new(lights, &shapes);
    println!("the light tree {:?}, with the scene {whole:?}", start.elapsed());
    assert_eq!(again.all.len(), 1);
    let from = at([0.1, 0.2, 0.0], [0.0, 0.0, 1.0]);
    let start = Instant::now();
    let mean = Mean::irradiance(&scene, &from, 200_000);
    println!("{mean:?}, {:?} a sample", start.elapsed() / 200_000);
}
