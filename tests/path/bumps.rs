//! Normals bent by heights and by maps, against analytic slopes.

use crate::compare::{agree, agree_with, assert_same, expected, job, well_known};
use crate::matter::Matter;
use crate::rooms::{glass, lit_room};
use crate::world::{Lamp, Shape, World};

#[test]
fn bumps_bend_the_normal_by_their_slope() {
    let bent = |slopes, r| Matter::Bent(slopes, Box::new(Matter::Diffuse(r)));
    let wall = |slopes, reversed| {
        let matter = bent(slopes, [0.7, 0.8, 0.9]);
        let shape = Shape::quad([-1.9, -1.5, 4.0], [0.0, 3.0, 0.0], [3.5, 0.0, 0.0], matter);
        Shape { reversed, ..shape }
    };
    for reversed in [false, true] {
        let world = World {
            lamps: vec![Lamp::Point { from: [0.5, 1.0, 0.0], intensity: [30.0, 20.0, 10.0] }],
            ..lit_room([wall([-2.0, 1.0], reversed)])
        };
        agree(&world, 2);
    }
}

#[test]
fn bumps_of_meshes_with_normals_are_measured_along_u_in_both_directions() {
    // As in pbrt-v4: the second tangent is the first one turned, as long as that, whatever v says.
    let wall = |slope| {
        let matter = Matter::Bent([0.0, slope], Box::new(Matter::Diffuse([0.7, 0.8, 0.9])));
        Shape::quad([-1.9, -1.5, 4.0], [0.0, 1.5, 0.0], [3.5, 0.0, 0.0], matter)
    };
    let lamps = vec![Lamp::Distant { from: [1.0, 1.0, -0.7], irradiance: [3.0, 2.0, 1.0] }];
    let world = World { shapes: vec![wall(1.5 * 3.5 / 1.5)], lamps, ..World::default() };
    let normals = r#""normal N" [0 0 -1 0 0 -1 0 0 -1 0 0 -1] "integer indices""#;
    let told = world.lights() + &wall(1.5).text(0).replace(r#""integer indices""#, normals);
    agree_with(&told, &world, 1);
}

#[test]
fn bent_normals_stay_on_the_side_of_the_surface() {
    // Glass tells its sides apart.
    let pane = |reversed| {
        let matter = Matter::Bent([0.6, -0.4], Box::new(glass(0.2)));
        let shape = Shape::quad([-1.9, -1.5, 2.5], [0.0, 3.0, 0.0], [3.5, 0.0, 0.0], matter);
        Shape { reversed, ..shape }
    };
    for reversed in [false, true] {
        agree(&lit_room([pane(reversed)]), 2);
    }
}

#[test]
fn maps_hold_normals_about_u_and_the_normal() {
    let [x, y, z] = [0.4, 0.3, 0.75f64.sqrt()];
    let wall = |matter| Shape::quad([-1.9, -1.5, 4.0], [0.0, 3.0, 0.0], [3.5, 0.0, 0.0], matter);
    let plain = Matter::Diffuse([0.7, 0.8, 0.9]);
    // The heights whose normal is that: the slopes along unit vectors are -x / z and -y / z.
    let bent = Matter::Bent([-3.0 * x / z, -3.5 * y / z], Box::new(plain.clone()));
    let lamps = vec![Lamp::Distant { from: [1.0, 1.0, -0.7], irradiance: [3.0, 2.0, 1.0] }];
    let world =
        |matter| World { shapes: vec![wall(matter)], lamps: lamps.clone(), ..World::default() };
    let plain = world(plain);
    let map = World {
        picture: Some(vec![vec![[x, y, z].map(|c| (c + 1.0) / 2.0); 2]; 2]),
        ..World::default()
    };
    let told = plain.text().replace("\"diffuse\"", "\"diffuse\" \"string normalmap\" \"sky.pfm\"");
    assert_same(well_known(job(&told, map.pfm(), 1)), expected(&world(bent), 1));
}
