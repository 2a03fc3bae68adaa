//! Things under a sky.

use crate::compare::agree;
use crate::matter::Matter;
use crate::rooms::{glass, metal};
use crate::world::{Shape, World};

/// A sky with a bright window, of 8 x 8 pixels.
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

fn floor(matter: Matter) -> Shape {
    Shape::quad([-4.0, -1.2, 0.0], [0.0, 0.0, 9.0], [8.0, 0.0, 0.0], matter)
}

#[test]
fn rough_metal_and_rough_glass_stand_under_a_picture() {
    let shapes = |alpha| {
        vec![
            floor(Matter::Diffuse([0.5, 0.6, 0.7])),
            Shape::ball([-1.0, 0.0, 4.0], 1.0, metal(alpha)),
            Shape::ball([1.1, -0.1, 4.0], 1.0, glass(alpha)),
        ]
    };
    agree(&under_a_picture(shapes(0.5)), 5);
    agree(&under_a_picture(shapes(0.0)), 5);
}

#[test]
fn a_picture_of_the_sky_lights_diffuse_things() {
    let shapes = vec![
        floor(Matter::Diffuse([0.5, 0.6, 0.7])),
        Shape::ball([0.0, 0.0, 4.0], 1.0, Matter::Diffuse([0.9, 0.6, 0.3])),
        Shape::ball([1.6, -0.2, 3.0], 0.6, Matter::Pane(1.5)),
    ];
    let world = under_a_picture(shapes);
    agree(&world, 4);
}

/// A quad of holes, half of which let a part of the light through, over a chequered floor.
fn holes() -> Shape {
    let matter = Matter::Board([0.9, 0.2, 0.1], [0.1, 0.7, 0.9]);
    let quad = Shape::quad([-1.5, 0.9, 1.5], [0.0, -0.6, 4.0], [3.0, 0.0, 0.0], matter);
    Shape { alpha: [0.0, 0.75], ..quad }
}

#[test]
fn textures_and_holes_are_where_they_are_said_to_be() {
    let board = Matter::Board([0.8, 0.8, 0.2], [0.1, 0.2, 0.6]);
    let lamp = Shape::quad([-2.0, 2.5, 0.0], [4.0, 0.0, 0.0], [0.0, 0.0, 5.0], board.clone());
    let shapes = vec![floor(board), holes(), lamp.shining([3.0, 4.0, 5.0])];
    let world = World { shapes: shapes.clone(), ..World::default() };
    agree(&world, 4);
    agree(&World { shapes, sky: Some([0.5, 0.7, 1.0]), ..World::default() }, 3);
}

#[test]
fn a_ray_may_pass_one_wall_of_a_ball_and_meet_the_other() {
    // Of alpha 1/2 a ball lets a quarter of the light through, and shadows so much less.
    let ball = Shape::ball([0.0, 0.3, 4.0], 1.2, Matter::Diffuse([0.3, 0.5, 0.7]));
    let ball = Shape { alpha: [0.5; 2], ..ball };
    let lamp =
        Shape::quad([-2.0, 3.5, 2.0], [4.0, 0.0, 0.0], [0.0, 0.0, 4.0], Matter::Diffuse([0.0; 3]));
    let shapes = vec![floor(Matter::Diffuse([0.8; 3])), ball, lamp.shining([3.0; 3])];
    let world = World { shapes, sky: Some([1.0; 3]), ..World::default() };
    agree(&world, 3);
}

#[test]
fn lamps_with_holes_shine_where_they_are() {
    let board = Matter::Diffuse([0.5; 3]);
    let lamp = Shape::quad([-3.0, 1.0, -1.0], [6.0, 0.0, 0.0], [0.0, 0.0, 8.0], board.clone());
    let lamp = Shape { alpha: [1.0, 0.0], ..lamp.shining([3.0, 4.0, 5.0]) };
    let world = World { shapes: vec![floor(board), lamp], ..World::default() };
    agree(&world, 1);
}
