//! Bump maps and normal maps, against analytic slopes.

use super::compare::{agree, agree_with, assert_same, expected, job, well_known};
use super::material::NaiveMaterial;
use super::rooms::{glass, lit_room};
use super::world::{PointLike, Shape, World};

#[test]
fn bump_maps_tilt_the_normal_by_their_slope() {
    let bent = |slopes, r| NaiveMaterial::Bumped(slopes, Box::new(NaiveMaterial::Diffuse(r)));
    let wall = |slopes, reversed| {
        let material = bent(slopes, [0.7, 0.8, 0.9]);
        let shape = Shape::quad([-1.9, -1.5, 4.0], [0.0, 3.0, 0.0], [3.5, 0.0, 0.0], material);
        Shape { reversed, ..shape }
    };
    for reversed in [false, true] {
        let world = World {
            lights: vec![PointLike::Point { from: [0.5, 1.0, 0.0], intensity: [30.0, 20.0, 10.0] }],
            ..lit_room([wall([-2.0, 1.0], reversed)])
        };
        agree(&world, 2);
    }
}

#[test]
fn on_meshes_with_normals_both_bump_slopes_are_scaled_by_the_u_tangent() {
    // As in pbrt-v4, the second tangent is orthogonal to the first and has its length, whatever v
    // is.
    let wall = |slope| {
        let material =
            NaiveMaterial::Bumped([0.0, slope], Box::new(NaiveMaterial::Diffuse([0.7, 0.8, 0.9])));
        Shape::quad([-1.9, -1.5, 4.0], [0.0, 1.5, 0.0], [3.5, 0.0, 0.0], material)
    };
    let lights = vec![PointLike::Distant { from: [1.0, 1.0, -0.7], irradiance: [3.0, 2.0, 1.0] }];
    let world = World { shapes: vec![wall(1.5 * 3.5 / 1.5)], lights, ..World::default() };
    let normals = r#""normal N" [0 0 -1 0 0 -1 0 0 -1 0 0 -1] "integer indices""#;
    let text =
        world.light_directives() + &wall(1.5).text(0).replace(r#""integer indices""#, normals);
    agree_with(&text, &world, 1);
}

#[test]
fn perturbed_normals_stay_on_the_side_of_the_geometric_normal() {
    // The sides of glass differ.
    let pane = |reversed| {
        let material = NaiveMaterial::Bumped([0.6, -0.4], Box::new(glass(0.2)));
        let shape = Shape::quad([-1.9, -1.5, 2.5], [0.0, 3.0, 0.0], [3.5, 0.0, 0.0], material);
        Shape { reversed, ..shape }
    };
    for reversed in [false, true] {
        agree(&lit_room([pane(reversed)]), 2);
    }
}

#[test]
fn normal_maps_are_relative_to_the_u_tangent_and_the_normal() {
    let [x, y, z] = [0.4, 0.3, 0.75f64.sqrt()];
    let wall =
        |material| Shape::quad([-1.9, -1.5, 4.0], [0.0, 3.0, 0.0], [3.5, 0.0, 0.0], material);
    let plain = NaiveMaterial::Diffuse([0.7, 0.8, 0.9]);
    // A height with this normal has the slopes -x / z and -y / z along unit vectors.
    let bent = NaiveMaterial::Bumped([-3.0 * x / z, -3.5 * y / z], Box::new(plain.clone()));
    let lights = vec![PointLike::Distant { from: [1.0, 1.0, -0.7], irradiance: [3.0, 2.0, 1.0] }];
    let world = |material| World {
        shapes: vec![wall(material)],
        lights: lights.clone(),
        ..World::default()
    };
    let plain = world(plain);
    let map = World {
        picture: Some(vec![vec![[x, y, z].map(|c| (c + 1.0) / 2.0); 2]; 2]),
        ..World::default()
    };
    let text = plain.text().replace("\"diffuse\"", "\"diffuse\" \"string normalmap\" \"sky.pfm\"");
    assert_same(well_known(job(&text, map.pfm(), 1)), expected(&world(bent), 1));
}
