//! Ray intersection: meshes do not leak, one lane and eight agree, and a naive search has the same hits.

mod agreement;
mod leaks;
mod patches;
mod quadrics;
mod waves;

use std::f64::consts::TAU;

use glam::DVec3;
use petzval_base::rays::Ray;
use petzval_scene::{Geometry, Material, Mesh, Scene, SceneBuilder, ShapeSpec};

fn scene(shapes: Vec<Geometry>) -> Scene {
    let mut builder = SceneBuilder::default();
    let material = builder.add_material(Material::diffuse([0.5; 3]));
    for shape in shapes {
        builder.add_shape(ShapeSpec::new(shape, material));
    }
    builder.build().unwrap()
}

/// Returns a closed torus with bumps. Two triangles share each edge; few edges are aligned with an axis.
fn torus(columns: u32, rows: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for j in 0..rows {
        for i in 0..columns {
            let (a, b) =
                (f64::from(i) / f64::from(columns) * TAU, f64::from(j) / f64::from(rows) * TAU);
            let tube = 0.4 + 0.03 * (5.0 * a).sin() * (3.0 * b).cos();
            let ring = 1.0 + tube * b.cos();
            mesh.positions.push([ring * a.cos(), tube * b.sin(), ring * a.sin()].map(|v| v as f32));
        }
    }
    let at = |i: u32, j: u32| (j % rows) * columns + i % columns;
    for j in 0..rows {
        for i in 0..columns {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

fn ray(origin: DVec3, towards: DVec3) -> Ray {
    let direction = (towards - origin).normalize();
    Ray {
        origin: origin.as_vec3().to_array(),
        direction: direction.as_vec3().to_array(),
        t_max: f32::INFINITY,
    }
}
