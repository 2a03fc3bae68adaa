//! White furnaces: under uniform light, lossless surfaces are invisible.

use super::compare::{agree, found, job};
use super::material::NaiveMaterial;
use super::rooms::glass;
use super::world::{Shape, World};

/// A ball and a tilted quad under a sky of radiance 1.
fn furnace(material: NaiveMaterial) -> World {
    let shapes = vec![
        Shape::ball([-0.5, 0.2, 3.0], 1.0, material.clone()),
        Shape::quad([-0.5, -1.5, 2.5], [2.0, 0.3, 1.0], [0.0, 1.5, 1.5], material),
    ];
    World { shapes, sky: Some([1.0; 3]), ..World::default() }
}

fn brightness(world: &World, depth: u32, samples: u32) -> [f64; 3] {
    let mut job = job(&world.text(), None, depth);
    job.samples.end = samples;
    found(&job).mean
}

const MIRROR: NaiveMaterial = NaiveMaterial::Metal { alpha: 0.0, eta: [1.0; 3], k: [1e4; 3] };

#[test]
fn lossless_materials_are_invisible_in_a_furnace() {
    let grey = |r: f64, t: f64| NaiveMaterial::DiffuseTransmission([r; 3], [t; 3]);
    let white = || NaiveMaterial::Diffuse([1.0; 3]);
    for material in [
        white(),
        grey(1.0, 0.0),
        grey(0.0, 1.0),
        grey(0.3, 0.7),
        MIRROR,
        NaiveMaterial::ThinSheet(1.5),
        NaiveMaterial::Mix(0.4, Box::new([white(), MIRROR])),
    ] {
        let world = furnace(material.clone());
        let seen_mean = brightness(&world, 100, 16);
        let lost = seen_mean.map(|c| (c - 1.0).abs());
        assert!(lost.iter().all(|&l| l < 2e-3), "{material:?}: {seen_mean:?}");
    }
    // Glass needs a closed shape.
    let ball =
        World { shapes: vec![Shape::ball([0.0, 0.0, 3.0], 1.4, glass(0.0))], ..furnace(MIRROR) };
    let seen_mean = brightness(&ball, 100, 64);
    assert!(seen_mean.iter().all(|&c| (c - 1.0).abs() < 2e-3), "{seen_mean:?}");
}

#[test]
fn transmittances_below_one_are_reproduced() {
    // A single convex shape, so that light meets it only once.
    let ball = |material| {
        let shapes = vec![Shape::ball([0.0, 0.0, 0.0], 5.0, material)];
        World { shapes, sky: Some([1.0; 3]), ..World::default() }
    };
    let seen = |material: NaiveMaterial| {
        // The camera is inside the ball.
        brightness(&ball(material), 1, 4)
    };
    let seen_mean = seen(NaiveMaterial::DiffuseTransmission([0.0; 3], [0.1, 0.4, 0.7]));
    for (found, expected) in seen_mean.into_iter().zip([0.1, 0.4, 0.7]) {
        assert!((found - expected).abs() < 2e-3, "{seen_mean:?}");
    }
}

#[test]
fn rough_materials_lose_light_and_agree_with_the_naive_path_tracer() {
    for material in [
        NaiveMaterial::Metal { alpha: 0.5, eta: [1.0; 3], k: [1e4; 3] },
        glass(0.6),
        NaiveMaterial::Coated { alpha: 0.0, reflectance: [1.0; 3] },
    ] {
        let shapes = vec![Shape::ball([0.0, 0.0, 3.0], 1.4, material.clone())];
        let world = World { shapes, sky: Some([1.0; 3]), ..World::default() };
        let seen_mean = brightness(&world, 100, 16)[0];
        agree(&world, 20);
        assert!(0.6 < seen_mean && seen_mean < 1.0, "{material:?}: {seen_mean}");
    }
}
