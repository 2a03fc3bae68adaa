//! Shading stage: light that the surfaces hit by a wave's rays send towards the film.
//!
//! Every surface of a path collects light in two ways: through a shadow ray to a sampled point of
//! a light, and through the path's next ray, which may hit a light. The power heuristic weights the
//! two (`mis`). Hits are sorted by the kind of their material, and the BSDFs of a kind are
//! evaluated eight at a time.

pub mod bsdf;
mod emission;
mod evaluate;
mod footprint;
mod glossy_lobe;
mod hit_material;
mod kind_stage;
mod lamp_weights;
mod light_path;
mod light_sampling;
mod materials;
mod neighbour_ray;
mod random;
mod shading_context;
mod sort;
mod spawn;
mod vertex_record;
mod vertices;

pub use footprint::PixelFootprint;
pub use hit_material::albedo;
pub use lamp_weights::{LampWeights, LightSource};
pub use light_path::shade_light_paths;
pub use vertex_record::{PathOutcome, SampledLight, VertexRecord};

use evaluate::Evaluation;
use petzval_base::lanes::Real;
use petzval_base::rays::{Column, HitBatch, PathFlags, RayBatch, SampleBatch};
use petzval_base::stats::LaneOccupancy;
use petzval_scene::{PathLimits, Scene};
use random::RandomColumns;
use vertices::Vertices;

/// The vertex of its paths at which a wave is shaded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathVertex {
    /// Number of surfaces that the path has met before.
    pub depth: u32,
    /// Limits of the path's length.
    pub limits: PathLimits,
    /// Footprint of a pixel as the camera sees it.
    pub footprint: PixelFootprint,
}

impl PathVertex {
    /// Returns whether a path ends at this vertex, given the flags of its last ray.
    fn ends_path(&self, flags: PathFlags) -> bool {
        let PathLimits { max_depth, direct_only, .. } = self.limits;
        let ends_direct = self.depth > 0 && !flags.contains(PathFlags::SPECULAR);
        self.depth >= max_depth || direct_only && ends_direct
    }

    /// Returns whether diffuse surfaces receive light through shadow rays only, without multiple
    /// importance sampling. This holds for the last light of a path if the scene has no sky: point
    /// and area lights need no second ray.
    fn skips_mis(&self, scene: &Scene) -> bool {
        let last = self.limits.direct_only || self.depth + 1 == self.limits.max_depth;
        last && scene.lights.skies.is_empty()
    }
}

/// Rays of a wave and the surfaces that they hit.
#[derive(Clone, Copy, Debug)]
pub struct ShadeInputs<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The vertex at which the paths are.
    pub vertex: PathVertex,
    /// The rays.
    pub rays: &'a RayBatch,
    /// The nearest hit of each ray.
    pub hits: &'a HitBatch,
    /// Weights of camera rays that find a light, if light paths find images of lamps too.
    pub lamp_weights: Option<&'a dyn LampWeights>,
    /// Whether light paths find caustics, so that camera paths leave them out.
    pub caustics: bool,
    /// Whether camera rays do not see the light of a sky.
    pub hides_sky: bool,
}

impl ShadeInputs<'_> {
    /// Returns the flags of the path of the i-th ray; camera rays have none.
    fn flags(&self, i: usize) -> PathFlags {
        if self.vertex.depth > 0 { self.rays.flags[i] } else { PathFlags::NONE }
    }
}

/// Work columns of the stage.
#[derive(Clone, Debug, Default)]
pub struct ShadeColumns {
    random: Box<RandomColumns>,
    vertices: Vertices,
}

impl ShadeColumns {
    /// Memory of the columns (bytes).
    pub(crate) const BYTES: usize =
        size_of::<Self>() + size_of::<RandomColumns>() + Vertices::BOXED_BYTES;
}

/// Shades the hits of a wave and returns the lane occupancy of its packets.
///
/// Adds emitted light to `radiance` by sample. Writes to `shadows` one ray for each sampled light,
/// with the radiance that it contributes if nothing occludes it, and to `next` the next rays of the
/// paths.
pub fn shade<R: Real<Scalar = f32>>(
    inputs: &ShadeInputs,
    samples: &SampleBatch,
    columns: &mut ShadeColumns,
    radiance: &mut [Column<f32>; 3],
    shadows: &mut RayBatch,
    next: &mut RayBatch,
) -> LaneOccupancy {
    let ShadeInputs { scene, vertex, .. } = *inputs;
    let ShadeColumns { random, vertices } = columns;
    shadows.len = 0;
    next.len = 0;
    inputs.add_emitted_light(samples, radiance);
    if vertex.depth >= vertex.limits.max_depth {
        return LaneOccupancy::default();
    }
    let skip_mis = vertex.skips_mis(scene);
    vertices.sort(inputs);
    vertices.load_surfaces::<R>(inputs);
    vertices.load_paths(inputs);
    vertices.load_materials::<R>(inputs);
    if vertex.limits.regularize {
        vertices.regularize();
    }
    vertices.load_lobes::<R>(inputs);
    random.fill(&vertex, vertices, vertices.first_spawning(skip_mis), samples);
    vertices.sample_lights::<R>(scene, random);
    vertices.evaluate::<R>(&Evaluation { scene, random, skip_mis });
    if inputs.caustics && vertex.depth == 0 {
        vertices.flag_receivers();
    }
    vertices.spawn::<R>(inputs, random, shadows, next);
    vertices.occupancy()
}
