//! White furnaces: where light is the same from everywhere, nothing but a loss can be seen.

use crate::compare::{agree, found, job};
use crate::matter::Matter;
use crate::rooms::glass;
use crate::world::{Shape, World};

/// A ball and a leaning quad under a sky of radiance 1.
fn furnace(matter: Matter) -> World {
    let shapes = vec![
        Shape::ball([-0.5, 0.2, 3.0], 1.0, matter.clone()),
        Shape::quad([-0.5, -1.5, 2.5], [2.0, 0.3, 1.0], [0.0, 1.5, 1.5], matter),
    ];
    World { shapes, sky: Some([1.0; 3]), ..World::default() }
}

fn brightness(world: &World, depth: u32, samples: u32) -> [f64; 3] {
    let mut job = job(&world.text(), None, depth);
    job.samples.end = samples;
    found(&job).mean
}

const MIRROR: Matter = Matter::Metal { alpha: 0.0, eta: [1.0; 3], k: [1e4; 3] };

#[test]
fn what_takes_no_light_cannot_be_seen() {
    let grey = |r: f64, t: f64| Matter::Sheet([r; 3], [t; 3]);
    let white = || Matter::Diffuse([1.0; 3]);
    for matter in [
        white(),
        grey(1.0, 0.0),
        grey(0.0, 1.0),
        grey(0.3, 0.7),
        MIRROR,
        Matter::Pane(1.5),
        Matter::Mix(0.4, Box::new([white(), MIRROR])),
    ] {
        let world = furnace(matter.clone());
        let said = brightness(&world, 100, 16);
        let lost = said.map(|c| (c - 1.0).abs());
        assert!(lost.iter().all(|&l| l < 2e-3), "{matter:?}: {said:?}");
    }
    // The inside of a quad of glass would be infinitely large.
    let ball =
        World { shapes: vec![Shape::ball([0.0, 0.0, 3.0], 1.4, glass(0.0))], ..furnace(MIRROR) };
    let said = brightness(&ball, 100, 64);
    assert!(said.iter().all(|&c| (c - 1.0).abs() < 2e-3), "{said:?}");
}

#[test]
fn shares_below_one_are_seen_as_they_are() {
    // Alone and convex, so that no light meets it twice.
    let ball = |matter| {
        let shapes = vec![Shape::ball([0.0, 0.0, 0.0], 5.0, matter)];
        World { shapes, sky: Some([1.0; 3]), ..World::default() }
    };
    let seen = |matter: Matter| {
        // The camera stands inside; a ball that is turned around looks the same from there.
        brightness(&ball(matter), 1, 4)
    };
    let said = seen(Matter::Sheet([0.0; 3], [0.1, 0.4, 0.7]));
    for (found, expected) in said.into_iter().zip([0.1, 0.4, 0.7]) {
        assert!((found - expected).abs() < 2e-3, "{said:?}");
    }
}

#[test]
fn roughness_loses_what_it_should_and_adds_nothing() {
    for matter in [
        Matter::Metal { alpha: 0.5, eta: [1.0; 3], k: [1e4; 3] },
        glass(0.6),
        Matter::Varnish { alpha: 0.0, reflectance: [1.0; 3] },
    ] {
        let shapes = vec![Shape::ball([0.0, 0.0, 3.0], 1.4, matter.clone())];
        let world = World { shapes, sky: Some([1.0; 3]), ..World::default() };
        let said = brightness(&world, 100, 16)[0];
        agree(&world, 20);
        assert!(0.6 < said && said < 1.0, "{matter:?}: {said}");
    }
}
