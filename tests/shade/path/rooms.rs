//! Closed rooms with lights of all kinds.

use super::compare::{agree, agree_with};
use super::material::{Colour, NaiveMaterial};
use super::world::{PointLike, Shape, World};

pub const COPPER: ([f64; 3], [f64; 3]) = ([0.2, 0.92, 1.1], [3.9, 2.45, 2.14]);

pub fn metal(alpha: f64) -> NaiveMaterial {
    NaiveMaterial::Metal { alpha, eta: COPPER.0, k: COPPER.1 }
}

pub fn glass(alpha: f64) -> NaiveMaterial {
    NaiveMaterial::Glass { alpha, eta: 1.5 }
}

/// Six walls around the camera that face inwards, from -2 to 2 in x and y and from -1 to 5 in z.
pub fn room(colours: [Colour; 6]) -> Vec<Shape> {
    let [left, right, floor, ceiling, front, back] = colours.map(NaiveMaterial::Diffuse);
    vec![
        Shape::quad([-2.0, -2.0, -1.0], [0.0, 4.0, 0.0], [0.0, 0.0, 6.0], left),
        Shape::quad([2.0, -2.0, -1.0], [0.0, 0.0, 6.0], [0.0, 4.0, 0.0], right),
        Shape::quad([-2.0, -2.0, -1.0], [0.0, 0.0, 6.0], [4.0, 0.0, 0.0], floor),
        Shape::quad([-2.0, 2.0, -1.0], [4.0, 0.0, 0.0], [0.0, 0.0, 6.0], ceiling),
        Shape::quad([-2.0, -2.0, -1.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], front),
        Shape::quad([-2.0, -2.0, 5.0], [0.0, 4.0, 0.0], [4.0, 0.0, 0.0], back),
    ]
}

pub const WALLS: [Colour; 6] = [
    [0.7, 0.2, 0.1],
    [0.2, 0.6, 0.3],
    [0.5, 0.5, 0.6],
    [0.8, 0.8, 0.7],
    [0.4, 0.5, 0.6],
    [0.6, 0.6, 0.8],
];

/// A light under the ceiling that emits downwards.
fn ceiling_light() -> Shape {
    Shape::quad(
        [-1.9, 1.9, 0.0],
        [3.8, 0.0, 0.0],
        [0.0, 0.0, 4.5],
        NaiveMaterial::Diffuse([0.3; 3]),
    )
    .emitting([2.0, 3.0, 4.0])
}

pub fn lit_room(more: impl IntoIterator<Item = Shape>) -> World {
    let mut shapes = room(WALLS);
    shapes.push(ceiling_light());
    shapes.extend(more);
    World { shapes, ..World::default() }
}

#[test]
fn a_room_with_a_ceiling_light_agrees() {
    let world = lit_room([
        Shape::ball([-0.7, -1.1, 3.0], 0.8, NaiveMaterial::Diffuse([0.8, 0.6, 0.2])),
        Shape::ball([0.8, -0.9, 2.6], 0.7, metal(0.4)),
    ]);
    for depth in [1, 6] {
        agree(&world, depth);
    }
}

#[test]
fn two_sided_one_sided_and_round_lights_agree() {
    let white = || NaiveMaterial::Diffuse([0.6; 3]);
    let mut both = Shape::quad([-1.7, -0.5, 1.0], [0.4, 1.9, 0.0], [0.0, 0.5, 3.0], white())
        .emitting([3.0, 1.0, 1.5]);
    both.two_sided = true;
    let ball = Shape::ball([0.8, 0.6, 3.0], 0.9, white()).emitting([1.0, 2.0, 3.0]);
    // Emits inwards only, so the camera sees a dark ball.
    let mut shell = Shape::ball([0.2, -1.0, 3.4], 0.6, white()).emitting([5.0, 5.0, 5.0]);
    shell.reversed = true;
    // Emits away from the camera, to a wall close behind it.
    let away = Shape::quad([-0.8, 0.6, 4.3], [1.6, 0.0, 0.0], [0.0, 1.0, 0.0], white())
        .emitting([2.0, 2.0, 4.0]);
    let mut shapes = room(WALLS);
    shapes.extend([both, ball, shell, away]);
    let world = World { shapes, ..World::default() };
    agree(&world, 4);
}

#[test]
fn a_light_inside_glass_is_found_by_bsdf_sampling() {
    let light = Shape::ball([0.0, 0.0, 3.0], 1.2, NaiveMaterial::Diffuse([0.5; 3]))
        .emitting([9.0, 6.0, 3.0]);
    let bulb = Shape::ball([0.0, 0.0, 3.0], 1.5, glass(0.0));
    let mut shapes = room(WALLS);
    shapes.extend([light, bulb]);
    agree(&World { shapes, ..World::default() }, 4);
}

#[test]
fn a_thin_sheet_before_a_light_agrees() {
    let pane = Shape::quad(
        [-1.6, 1.0, 1.5],
        [1.8, 0.5, 0.0],
        [0.0, 0.0, 2.0],
        NaiveMaterial::ThinSheet(1.8),
    );
    agree(&lit_room([pane]), 4);
}

#[test]
fn diffuse_transmission_agrees() {
    let sheet = NaiveMaterial::DiffuseTransmission([0.4, 0.2, 0.2], [0.2, 0.3, 0.6]);
    let sheet = Shape::quad([-2.0, 0.6, 1.0], [2.6, 0.0, 0.0], [0.0, 0.0, 4.0], sheet);
    let world = lit_room([sheet]);
    agree(&world, 5);
}

#[test]
fn mixtures_and_nested_mixtures_agree() {
    let mix =
        NaiveMaterial::Mix(0.3, Box::new([NaiveMaterial::Diffuse([0.8, 0.3, 0.1]), metal(0.5)]));
    let nested = NaiveMaterial::Mix(0.6, Box::new([mix.clone(), NaiveMaterial::ThinSheet(1.8)]));
    let world = lit_room([
        Shape::ball([-0.7, -0.6, 3.0], 0.9, mix),
        Shape::quad([0.0, -1.5, 2.5], [1.5, 0.0, 0.4], [0.0, 2.0, 0.0], nested),
    ]);
    agree(&world, 4);
}

/// The same room by scaled, mirrored, rotated and instanced objects.
#[test]
fn transformed_instances_agree_with_plain_shapes() {
    let quad = |r: Colour| {
        Shape::quad([0.3, -1.0, 3.2], [0.9, 0.0, 0.5], [0.0, 1.2, 0.2], NaiveMaterial::Diffuse(r))
    };
    let ball = Shape::ball([-0.9, -0.8, 3.0], 0.7, glass(0.0));
    let metal_ball = Shape::ball([1.1, 1.0, 2.6], 0.5, metal(0.3));
    let light = Shape::ball([-0.8, 0.9, 3.4], 0.9, NaiveMaterial::Diffuse([0.5; 3]));
    let light = light.emitting([4.0, 3.0, 2.0]);
    let mut shapes = room(WALLS);
    shapes.extend([quad([0.9, 0.5, 0.2]), ball, metal_ball, light]);
    let world = World { shapes, ..World::default() };

    let text = |shape: &Shape| shape.text(0);
    // The glass ball keeps its inside and outside, although it is mirrored.
    let scene = [
        room(WALLS).iter().map(text).collect::<String>(),
        r#"AttributeBegin Scale 1 -1 1
           Material "diffuse" "rgb reflectance" [0.9 0.5 0.2]
           ObjectBegin "quad" Translate 1 0 0 Shape "trianglemesh"
              "point3 P" [-0.7 1 3.2  0.2 1 3.7  0.2 -0.2 3.9  -0.7 -0.2 3.4]
              "integer indices" [0 1 2 0 2 3] ObjectEnd
           AttributeEnd
           ObjectInstance "quad""#
            .to_owned(),
        r#"Material "dielectric" "float eta" 1.5 ObjectBegin "glass" Shape "sphere" ObjectEnd
           AttributeBegin Translate -0.9 -0.8 3 Scale -0.7 0.7 0.7 ObjectInstance "glass"
           AttributeEnd"#
            .to_owned(),
        format!(
            r#"Material "conductor" "rgb eta" {:?} "rgb k" {:?} "float roughness" 0.3
               "bool remaproughness" false
               ObjectBegin "ball" Shape "sphere" "float radius" 2 ObjectEnd
               AttributeBegin Translate 1.1 1 2.6 Rotate 77 1 2 3 Scale 0.25 0.25 -0.25
               ObjectInstance "ball" AttributeEnd"#,
            COPPER.0, COPPER.1
        )
        .replace(',', " "),
        r#"AttributeBegin AreaLightSource "diffuse" "rgb L" [4 3 2]
           Translate -0.8 0.9 3.4 ReverseOrientation Scale -0.9 0.9 0.9 ReverseOrientation
           Material "diffuse" Shape "sphere" AttributeEnd"#
            .to_owned(),
    ]
    .join("\n");
    agree_with(&scene, &world, 5);
}

#[test]
fn a_coated_surface_under_point_like_lights_agrees() {
    let coated = |r| NaiveMaterial::Coated { alpha: 0.6, reflectance: r };
    let world = World {
        shapes: vec![
            Shape::quad(
                [-4.0, -1.0, 0.0],
                [0.0, 0.0, 9.0],
                [8.0, 0.0, 0.0],
                coated([0.7, 0.4, 0.2]),
            ),
            Shape::ball([0.0, 0.0, 4.0], 1.0, coated([0.2, 0.6, 0.8])),
        ],
        lights: vec![
            PointLike::Point { from: [2.0, 3.0, 1.0], intensity: [20.0, 10.0, 12.0] },
            PointLike::Spot {
                from: [-3.0, 2.0, 2.0],
                to: [0.0, 0.0, 4.0],
                cone: 40.0,
                fade: 25.0,
                intensity: [5.0, 10.0, 12.0],
            },
            PointLike::Distant { from: [1.0, 2.0, -2.0], irradiance: [1.0, 2.0, 1.0] },
        ],
        ..World::default()
    };
    agree(&world, 1);
}

#[test]
fn a_coated_surface_under_an_area_light_agrees() {
    let coated = NaiveMaterial::Coated { alpha: 0.0, reflectance: [0.7, 0.4, 0.2] };
    agree(&lit_room([Shape::ball([0.0, -0.8, 3.0], 1.0, coated)]), 3);
}
