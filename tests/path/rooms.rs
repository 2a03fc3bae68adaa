//! Closed rooms with lamps of all kinds.

use crate::compare::{agree, agree_with};
use crate::matter::{Colour, Matter};
use crate::world::{Lamp, Shape, World};

pub const COPPER: ([f64; 3], [f64; 3]) = ([0.2, 0.92, 1.1], [3.9, 2.45, 2.14]);

pub fn metal(alpha: f64) -> Matter {
    Matter::Metal { alpha, eta: COPPER.0, k: COPPER.1 }
}

pub fn glass(alpha: f64) -> Matter {
    Matter::Glass { alpha, eta: 1.5 }
}

/// Six walls about the camera, from -2 to 2 and on the z axis from -1 to 5, that look inwards.
pub fn room(colours: [Colour; 6]) -> Vec<Shape> {
    let [left, right, floor, ceiling, front, back] = colours.map(Matter::Diffuse);
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

/// A lamp under the ceiling that shines down.
fn ceiling_light() -> Shape {
    Shape::quad([-1.9, 1.9, 0.0], [3.8, 0.0, 0.0], [0.0, 0.0, 4.5], Matter::Diffuse([0.3; 3]))
        .shining([2.0, 3.0, 4.0])
}

pub fn lit_room(more: impl IntoIterator<Item = Shape>) -> World {
    let mut shapes = room(WALLS);
    shapes.push(ceiling_light());
    shapes.extend(more);
    World { shapes, ..World::default() }
}

#[test]
fn a_lamp_under_the_ceiling_lights_a_room_with_balls_and_walls() {
    let world = lit_room([
        Shape::ball([-0.7, -1.1, 3.0], 0.8, Matter::Diffuse([0.8, 0.6, 0.2])),
        Shape::ball([0.8, -0.9, 2.6], 0.7, metal(0.4)),
    ]);
    for depth in [1, 6] {
        agree(&world, depth);
    }
}

#[test]
fn two_sided_one_sided_and_round_lamps_light_a_room() {
    let white = || Matter::Diffuse([0.6; 3]);
    let mut both = Shape::quad([-1.7, -0.5, 1.0], [0.4, 1.9, 0.0], [0.0, 0.5, 3.0], white())
        .shining([3.0, 1.0, 1.5]);
    both.two_sided = true;
    let ball = Shape::ball([0.8, 0.6, 3.0], 0.9, white()).shining([1.0, 2.0, 3.0]);
    // From inside only: the camera sees a dark ball, the lamp in it lights what is in it.
    let mut shell = Shape::ball([0.2, -1.0, 3.4], 0.6, white()).shining([5.0, 5.0, 5.0]);
    shell.reversed = true;
    // Shines on a wall close behind it, away from the camera.
    let away = Shape::quad([-0.8, 0.6, 4.3], [1.6, 0.0, 0.0], [0.0, 1.0, 0.0], white())
        .shining([2.0, 2.0, 4.0]);
    let mut shapes = room(WALLS);
    shapes.extend([both, ball, shell, away]);
    let world = World { shapes, ..World::default() };
    agree(&world, 4);
}

#[test]
fn a_round_lamp_inside_glass_is_found_by_scattered_rays_alone() {
    let lamp =
        Shape::ball([0.0, 0.0, 3.0], 1.2, Matter::Diffuse([0.5; 3])).shining([9.0, 6.0, 3.0]);
    let bulb = Shape::ball([0.0, 0.0, 3.0], 1.5, glass(0.0));
    let mut shapes = room(WALLS);
    shapes.extend([lamp, bulb]);
    agree(&World { shapes, ..World::default() }, 4);
}

#[test]
fn a_pane_before_a_lamp_takes_what_it_mirrors() {
    let pane = Shape::quad([-1.6, 1.0, 1.5], [1.8, 0.5, 0.0], [0.0, 0.0, 2.0], Matter::Pane(1.8));
    agree(&lit_room([pane]), 4);
}

#[test]
fn a_sheet_is_lit_from_behind() {
    let sheet = Matter::Sheet([0.4, 0.2, 0.2], [0.2, 0.3, 0.6]);
    let sheet = Shape::quad([-2.0, 0.6, 1.0], [2.6, 0.0, 0.0], [0.0, 0.0, 4.0], sheet);
    let world = lit_room([sheet]);
    agree(&world, 5);
}

#[test]
fn mixtures_are_what_they_are_made_of() {
    let mix = Matter::Mix(0.3, Box::new([Matter::Diffuse([0.8, 0.3, 0.1]), metal(0.5)]));
    let nested = Matter::Mix(0.6, Box::new([mix.clone(), Matter::Pane(1.8)]));
    let world = lit_room([
        Shape::ball([-0.7, -0.6, 3.0], 0.9, mix),
        Shape::quad([0.0, -1.5, 2.5], [1.5, 0.0, 0.4], [0.0, 2.0, 0.0], nested),
    ]);
    agree(&world, 4);
}

/// The ball of a room in other words: squeezed, mirrored, turned and copied objects.
#[test]
fn turned_mirrored_and_copied_shapes_are_what_they_look_like() {
    let quad = |r: Colour| {
        Shape::quad([0.3, -1.0, 3.2], [0.9, 0.0, 0.5], [0.0, 1.2, 0.2], Matter::Diffuse(r))
    };
    let ball = Shape::ball([-0.9, -0.8, 3.0], 0.7, glass(0.0));
    let metal_ball = Shape::ball([1.1, 1.0, 2.6], 0.5, metal(0.3));
    let lamp = Shape::ball([-0.8, 0.9, 3.4], 0.9, Matter::Diffuse([0.5; 3]));
    let lamp = lamp.shining([4.0, 3.0, 2.0]);
    let mut shapes = room(WALLS);
    shapes.extend([quad([0.9, 0.5, 0.2]), ball, metal_ball, lamp]);
    let world = World { shapes, ..World::default() };

    let text = |shape: &Shape| shape.text(0);
    // The ball of glass keeps its outside outside, however it is mirrored.
    let told = [
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
    agree_with(&told, &world, 5);
}

#[test]
fn lamps_light_varnish() {
    let varnish = |r| Matter::Varnish { alpha: 0.6, reflectance: r };
    let world = World {
        shapes: vec![
            Shape::quad(
                [-4.0, -1.0, 0.0],
                [0.0, 0.0, 9.0],
                [8.0, 0.0, 0.0],
                varnish([0.7, 0.4, 0.2]),
            ),
            Shape::ball([0.0, 0.0, 4.0], 1.0, varnish([0.2, 0.6, 0.8])),
        ],
        lamps: vec![
            Lamp::Point { from: [2.0, 3.0, 1.0], intensity: [20.0, 10.0, 12.0] },
            Lamp::Spot {
                from: [-3.0, 2.0, 2.0],
                to: [0.0, 0.0, 4.0],
                cone: 40.0,
                fade: 25.0,
                intensity: [5.0, 10.0, 12.0],
            },
            Lamp::Distant { from: [1.0, 2.0, -2.0], irradiance: [1.0, 2.0, 1.0] },
        ],
        ..World::default()
    };
    agree(&world, 1);
}

#[test]
fn varnish_is_lit_by_lamps_that_have_a_size() {
    let varnish = Matter::Varnish { alpha: 0.0, reflectance: [0.7, 0.4, 0.2] };
    agree(&lit_room([Shape::ball([0.0, -0.8, 3.0], 1.0, varnish)]), 3);
}
