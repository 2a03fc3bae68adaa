//! Shading: what the surfaces that rays met send towards the film.
//!
//! At every surface of a path light is gathered twice: by a ray to a point of a light, and by
//! what the path's next ray runs into. The power heuristic weighs the two (Veach 1995, "Robust
//! Monte Carlo methods for light transport simulation", 9.2.4). Hits are sorted by the kind of
//! their surface, and the scattering functions of a kind are evaluated eight at a time.

pub mod bsdf;
mod dice;
mod gather;
mod kind;
mod look;
mod scatter;
mod vertices;

pub use kind::albedo;

use crate::lanes::Real;
use crate::rays::{Column, HitBatch, RayBatch, SampleBatch};
use crate::scene::Scene;
use crate::stats::Lanes;
use dice::Dice;
use vertices::Vertices;

/// Which part of a path a shading stage works on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Vertex {
    /// Surfaces that the path has met before.
    pub depth: u32,
    /// Surfaces that scatter light; what the path meets after that many only shines.
    pub max_depth: u32,
}

/// The columns that the stage works in.
#[derive(Clone, Debug, Default)]
pub struct ShadeColumns {
    dice: Dice,
    vertices: Vertices,
}

/// Shades the hits of a wave: a stage. Emission goes into `radiance`, what a light would add if
/// nothing were in its way into `shadows`, and the path's next step into `next`. Answers how full
/// its packets were.
#[expect(clippy::too_many_arguments, reason = "a stage names every column that it touches")]
pub fn shade<R: Real<Scalar = f32>>(
    scene: &Scene,
    vertex: Vertex,
    rays: &RayBatch,
    hits: &HitBatch,
    samples: &SampleBatch,
    columns: &mut ShadeColumns,
    radiance: &mut [Column<f32>; 3],
    shadows: &mut RayBatch,
    next: &mut RayBatch,
) -> Lanes {
    shadows.len = 0;
    next.len = 0;
    let ShadeColumns { dice, vertices } = columns;
    let last = vertex.depth >= vertex.max_depth;
    vertices.gather(scene, vertex, rays, hits, radiance, next);
    if last {
        next.len = 0;
        return Lanes::default();
    }
    dice.throw(vertex, rays, samples);
    vertices.light(scene, dice);
    // What is only lit by lamps and shapes needs no second ray for its last light.
    let alone = vertex.depth + 1 == vertex.max_depth && scene.lights.skies.is_empty();
    vertices.scatter::<R>(alone);
    vertices.leave(vertex, shadows, next);
    vertices.lanes()
}
