//! Path depth and Russian roulette.

use super::compare::{found, job};
use super::material::NaiveMaterial;
use super::rooms::{glass, room};
use super::world::{Shape, World};

/// A closed room whose walls emit 1, 2 and 3 by channel and reflect 0.8.
fn bright_room(more: Vec<Shape>) -> World {
    let mut shapes: Vec<Shape> =
        room([[0.8; 3]; 6]).into_iter().map(|wall| wall.emitting([1.0, 2.0, 3.0])).collect();
    shapes.extend(more);
    World { shapes, ..World::default() }
}

fn assert_series(world: &World, depth: u32, samples: u32, terms: i32) {
    let mut job = job(&world.text(), None, depth);
    job.samples.end = samples;
    let found = found(&job);
    for c in 0..3 {
        let expected = (c + 1) as f64 * (1.0 - 0.8f64.powi(terms)) / 0.2;
        let (mean, error) = (found.mean[c], 5.0 * found.error[c] + 1e-5 * expected);
        println!("depth {depth}: {mean:.5}, expected {expected:.5} +- {error:.5}");
        assert!(error < 0.008 * expected, "depth {depth}: {mean} is known to {error} only");
        assert!((mean - expected).abs() < error, "depth {depth}: {mean}, not {expected}");
    }
}

#[test]
fn every_surface_adds_a_term_to_the_series() {
    let world = bright_room(Vec::new());
    for depth in [0, 1, 2, 3, 5, 10] {
        assert_series(&world, depth, 128, depth as i32 + 1);
    }
}

#[test]
fn roulette_keeps_the_mean_of_long_paths() {
    assert_series(&bright_room(Vec::new()), 100, 96, 101);
}

#[test]
fn lossless_shapes_are_invisible_in_a_uniform_room() {
    // Refraction scales radiance by the squared index, which roulette must ignore.
    let shapes = vec![
        Shape::ball([-0.8, 0.0, 3.0], 0.7, glass(0.0)),
        Shape::ball([-0.8, 0.0, 3.0], 0.4, NaiveMaterial::Glass { alpha: 0.0, eta: 1.0 / 1.5 }),
        Shape::quad(
            [0.3, -1.0, 2.5],
            [1.2, 0.0, 0.5],
            [0.0, 2.0, 0.0],
            NaiveMaterial::ThinSheet(1.5),
        ),
        Shape::ball(
            [0.9, 0.5, 4.0],
            0.5,
            NaiveMaterial::Metal { alpha: 0.0, eta: [1.0; 3], k: [1e4; 3] },
        ),
    ];
    assert_series(&bright_room(shapes), 200, 128, 200);
}

#[test]
fn the_mean_does_not_depend_on_the_seed() {
    let world = super::rooms::lit_room([Shape::ball([0.0, -0.8, 3.0], 1.0, glass(0.2))]);
    let of = |seed: u32, samples: u32| {
        let mut job = job(&world.text(), None, 5);
        (job.seed, job.samples.end) = (seed, samples);
        found(&job)
    };
    let long = of(3, 256);
    for seed in [1, 2] {
        super::compare::assert_same(of(seed, 128), long);
    }
}
