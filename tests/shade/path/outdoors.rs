//! Shapes under a sky.

use super::compare::agree;
use super::material::NaiveMaterial;
use super::rooms::{glass, metal};
use super::world::{Shape, World};

/// A sky of 8 x 8 pixels with a few bright ones.
fn picture() -> Vec<Vec<[f64; 3]>> {
    let mut rows = vec![vec![[0.2, 0.3, 0.5]; 8]; 8];
    rows[1][5] = [1.6, 1.3, 1.0];
    rows[4][2] = [0.5, 1.8, 0.7];
    rows[7][7] = [1.2, 0.5, 1.5];
    rows
}

fn under_a_picture(shapes: Vec<Shape>) -> World {
    World { shapes, sky: Some([2.0; 3]), picture: Some(picture()), ..World::default() }
}

fn floor(material: NaiveMaterial) -> Shape {
    Shape::quad([-4.0, -1.2, 0.0], [0.0, 0.0, 9.0], [8.0, 0.0, 0.0], material)
}

#[test]
fn metal_and_glass_under_a_sky_picture_agree() {
    let shapes = |alpha| {
        vec![
            floor(NaiveMaterial::Diffuse([0.5, 0.6, 0.7])),
            Shape::ball([-1.0, 0.0, 4.0], 1.0, metal(alpha)),
            Shape::ball([1.1, -0.1, 4.0], 1.0, glass(alpha)),
        ]
    };
    agree(&under_a_picture(shapes(0.5)), 5);
    agree(&under_a_picture(shapes(0.0)), 5);
}

#[test]
fn diffuse_shapes_under_a_sky_picture_agree() {
    let shapes = vec![
        floor(NaiveMaterial::Diffuse([0.5, 0.6, 0.7])),
        Shape::ball([0.0, 0.0, 4.0], 1.0, NaiveMaterial::Diffuse([0.9, 0.6, 0.3])),
        Shape::ball([1.6, -0.2, 3.0], 0.6, NaiveMaterial::ThinSheet(1.5)),
    ];
    let world = under_a_picture(shapes);
    agree(&world, 4);
}

/// A quad with alpha 0 and 0.75 in a checkerboard.
fn perforated_quad() -> Shape {
    let material = NaiveMaterial::Checkerboard([0.9, 0.2, 0.1], [0.1, 0.7, 0.9]);
    let quad = Shape::quad([-1.5, 0.9, 1.5], [0.0, -0.6, 4.0], [3.0, 0.0, 0.0], material);
    Shape { alpha: [0.0, 0.75], ..quad }
}

#[test]
fn colour_and_alpha_textures_have_the_right_positions() {
    let board = NaiveMaterial::Checkerboard([0.8, 0.8, 0.2], [0.1, 0.2, 0.6]);
    let light = Shape::quad([-2.0, 2.5, 0.0], [4.0, 0.0, 0.0], [0.0, 0.0, 5.0], board.clone());
    let shapes = vec![floor(board), perforated_quad(), light.emitting([3.0, 4.0, 5.0])];
    let world = World { shapes: shapes.clone(), ..World::default() };
    agree(&world, 4);
    agree(&World { shapes, sky: Some([0.5, 0.7, 1.0]), ..World::default() }, 3);
}

#[test]
fn alpha_is_tested_at_each_wall_of_a_ball() {
    // A ball of alpha 1/2 passes a quarter of the light.
    let ball = Shape::ball([0.0, 0.3, 4.0], 1.2, NaiveMaterial::Diffuse([0.3, 0.5, 0.7]));
    let ball = Shape { alpha: [0.5; 2], ..ball };
    let light = Shape::quad(
        [-2.0, 3.5, 2.0],
        [4.0, 0.0, 0.0],
        [0.0, 0.0, 4.0],
        NaiveMaterial::Diffuse([0.0; 3]),
    );
    let shapes = vec![floor(NaiveMaterial::Diffuse([0.8; 3])), ball, light.emitting([3.0; 3])];
    let world = World { shapes, sky: Some([1.0; 3]), ..World::default() };
    agree(&world, 3);
}

#[test]
fn area_lights_with_alpha_emit_where_they_are_opaque() {
    let board = NaiveMaterial::Diffuse([0.5; 3]);
    let light = Shape::quad([-3.0, 1.0, -1.0], [6.0, 0.0, 0.0], [0.0, 0.0, 8.0], board.clone());
    let light = Shape { alpha: [1.0, 0.0], ..light.emitting([3.0, 4.0, 5.0]) };
    let world = World { shapes: vec![floor(board), light], ..World::default() };
    agree(&world, 1);
}
