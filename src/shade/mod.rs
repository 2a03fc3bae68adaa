//! Shading: what the surfaces that rays met send towards the film.
//!
//! At every surface of a path light is gathered twice: by a ray to a point of a light, and by
//! what the path's next ray runs into. The power heuristic weighs the two (Veach 1995, "Robust
//! Monte Carlo methods for light transport simulation", 9.2.4). Hits are sorted by the kind of
//! their surface, and the scattering functions of a kind are evaluated eight at a time.

mod account;
pub mod bsdf;
mod dice;
mod footprint;
mod gather;
mod kind;
mod look;
mod scatter;
mod vertices;

pub use account::{Account, Fate, Looked};
pub use footprint::Beam;
pub use kind::albedo;

use crate::lanes::Real;
use crate::rays::{Column, HitBatch, RayBatch, SampleBatch};
use crate::scene::Scene;
use crate::stats::Lanes;
use dice::Dice;
use vertices::Vertices;

/// How far paths go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reach {
    /// Surfaces that scatter light; what the path meets after that many only shines.
    pub max_depth: u32,
    /// Whether paths go on from mirrors and clear glass only: what comes to other surfaces is
    /// direct light.
    pub direct: bool,
}

/// Which part of a path a shading stage works on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    /// Surfaces that the path has met before.
    pub depth: u32,
    /// How far it goes.
    pub reach: Reach,
    /// What a pixel sees.
    pub beam: Beam,
}

impl Vertex {
    /// Whether a path, whose last direction was drawn with this density, ends at what it meets
    /// here.
    fn ends(&self, density: f32) -> bool {
        let Reach { max_depth, direct } = self.reach;
        self.depth >= max_depth || direct && self.depth > 0 && density.is_finite()
    }

    /// Whether light comes by shadow rays only where a surface is diffuse: what is only lit by lamps
    /// and shapes needs no second ray for its last light.
    fn alone(&self, scene: &Scene) -> bool {
        let last = self.reach.direct || self.depth + 1 == self.reach.max_depth;
        last && scene.lights.skies.is_empty()
    }
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
    vertices.gather(scene, &vertex, rays, hits, radiance, next);
    if vertex.depth >= vertex.reach.max_depth {
        next.len = 0;
        return Lanes::default();
    }
    dice.throw(&vertex, rays, samples);
    vertices.light(scene, dice);
    vertices.scatter::<R>(vertex.alone(scene));
    vertices.leave(scene, &vertex, rays, hits, shadows, next);
    vertices.lanes()
}
