//! BVHs of millions of triangles: memory, and completeness.

use crate::support::Random;
use glam::Vec3;
use petzval_base::lanes::f32x8;
use petzval_base::rays::Ray;
use petzval_scene::{Geometry, Material, Mesh, SceneBuilder, ShapeSpec, TraversalStack};

/// Number of quads along a side.
const SIDE: u32 = 710;
/// Memory per triangle that the documentation of the BVH promises, besides vertices and indices.
const BYTES_PER_TRIANGLE: usize = 110;

fn height(x: f32, y: f32) -> f32 {
    0.1 * (7.0 * x).sin() * (5.0 * y).cos() + 0.01 * (90.0 * x).cos() * (70.0 * y).sin()
}

/// Returns a hilly ground of 2 side^2 triangles.
fn ground(side: u32) -> Mesh {
    let mut mesh = Mesh::default();
    let at = |i: u32| i as f32 / side as f32;
    for j in 0..=side {
        for i in 0..=side {
            mesh.positions.push([at(i), at(j), height(at(i), at(j))]);
        }
    }
    for j in 0..side {
        for i in 0..side {
            let a = j * (side + 1) + i;
            mesh.triangles.extend([[a, a + 1, a + side + 2], [a, a + side + 2, a + side + 1]]);
        }
    }
    mesh
}

#[test]
#[ignore = "takes gigabytes; .ci/long runs it"]
fn twenty_million_triangles_are_built_within_24_gib() {
    let mut builder = SceneBuilder::default();
    let material = builder.add_material(Material::diffuse([0.5; 3]));
    builder.add_shape(ShapeSpec::new(Geometry::Mesh(ground(3163)), material));
    let start = std::time::Instant::now();
    let scene = builder.build().unwrap();
    let status = std::fs::read_to_string("/proc/self/status").expect("Linux");
    let peak = status.lines().find(|line| line.starts_with("VmHWM")).expect("its peak");
    let kib: f64 = peak.split_whitespace().nth(1).expect("a number").parse().expect("a number");
    let (tree, seconds) = (scene.bytes() as f64 / 2f64.powi(30), start.elapsed().as_secs_f64());
    println!("{:.1} GiB at most, {tree:.1} GiB of tree, {seconds:.0} s", kib / 2f64.powi(20));
    assert!(kib < 24.0 * 2f64.powi(20), "{peak}");
    let ray = Ray { origin: [0.5, 0.5, 9.0], direction: [0.0, 0.0, -1.0], t_max: f32::INFINITY };
    assert!(scene.closest::<f32x8>(&ray, &mut TraversalStack::default()).t < 9.5);
}

#[test]
fn a_million_triangles_take_a_hundred_megabytes_and_are_all_found() {
    let mesh = ground(SIDE);
    let triangles = mesh.triangles.len();
    assert!(triangles > 1_000_000);
    let centres: Vec<Vec3> = (0..triangles as u32)
        .step_by(101)
        .map(|i| mesh.corners(i).iter().sum::<Vec3>() / 3.0)
        .collect();
    let mut builder = SceneBuilder::default();
    let material = builder.add_material(Material::diffuse([0.5; 3]));
    builder.add_shape(ShapeSpec::new(Geometry::Mesh(mesh), material));
    let scene = builder.build().unwrap();
    let bytes = scene.bytes() / triangles;
    assert!(bytes < BYTES_PER_TRIANGLE, "{bytes} bytes a triangle");
    let mut stack = TraversalStack::default();
    let mut random = Random::new(31);
    for (i, centre) in centres.into_iter().enumerate() {
        let above = Vec3::new(0.0, 0.0, 1.0 + random.next() as f32);
        let origin = (centre + above).to_array();
        let ray = Ray { origin, direction: [0.0, 0.0, -1.0], t_max: f32::INFINITY };
        let hit = scene.closest::<f32x8>(&ray, &mut stack);
        assert_eq!(hit.primitive as usize, i * 101, "{hit:?} for a ray at {centre}");
    }
}
