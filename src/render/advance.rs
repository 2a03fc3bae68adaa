//! Advance of a wave: the order of the stages that take paths from one vertex to the next.

use crate::shade::{PathVertex, ShadeColumns};
use petzval_base::lanes::Real;
use petzval_base::rays::{Column, Hit, HitBatch, RayBatch, SampleBatch, WAVE_SIZE};
use petzval_base::stats::{BounceOccupancy, Stage};
use petzval_scene::{MediumColumns, Scene, Surroundings, TraversalStack};

/// Columns of the paths of a wave. Each batch is made on the stack before it moves to the heap, so it
/// has a box of its own: threads may have small stacks.
#[derive(Default)]
pub(crate) struct PathColumns {
    /// Rays to the present vertices.
    pub rays: Box<RayBatch>,
    /// Rays from there to the next vertices.
    pub next: Box<RayBatch>,
    /// Rays from the present vertices to lights, or to the lens.
    pub shadows: Box<RayBatch>,
    /// Hits of `rays`.
    pub hits: HitBatch,
    pub shade: Box<ShadeColumns>,
    pub media: Box<MediumColumns>,
    pub stack: TraversalStack,
    /// Radiance that the paths have found, by sample.
    pub radiance: [Column<f32>; 3],
    /// Lane occupancy of the last stages.
    pub occupancy: BounceOccupancy,
}

/// The stages in which kinds of paths differ.
pub(crate) trait VertexStages<R: Real<Scalar = f32>> {
    /// Reads the hits, or removes rays, before they are shaded.
    fn arrive(&mut self, _: &Surroundings, _: &mut PathColumns) {}

    /// Shades the hits: writes the shadow rays and the next rays.
    fn shade(&mut self, vertex: PathVertex, samples: &SampleBatch, paths: &mut PathColumns);

    /// Adds the light along the shadow rays.
    fn connect(&mut self, surroundings: &Surroundings, paths: &mut PathColumns);

    /// Counts a stage that has ended, and the rays that entered it.
    fn lap(&mut self, _: Stage, _rays: usize) {}
}

impl PathColumns {
    /// Memory of its boxes (bytes).
    pub const BOXED_BYTES: usize = 3 * size_of::<RayBatch>()
        + WAVE_SIZE * size_of::<Hit>()
        + ShadeColumns::BYTES
        + MediumColumns::BYTES;

    /// Advances the paths by one vertex.
    pub fn advance<R: Real<Scalar = f32>>(
        &mut self,
        scene: &Scene,
        samples: &SampleBatch,
        vertex: PathVertex,
        stages: &mut impl VertexStages<R>,
    ) {
        let surroundings = Surroundings::of(scene, samples, vertex.depth, vertex.limits.max_depth);
        self.trace::<R>(scene, &surroundings, |stage, rays| stages.lap(stage, rays));
        stages.arrive(&surroundings, self);
        stages.shade(vertex, samples, self);
        stages.lap(Stage::Shade, self.rays.len);
        let shadows = self.shadows.len;
        stages.connect(&surroundings, self);
        stages.lap(Stage::Occlude, shadows);
        std::mem::swap(&mut self.rays, &mut self.next);
    }

    /// Traces the rays to surfaces, or to where they scatter in media. `lap` counts the stages.
    pub fn trace<R: Real<Scalar = f32>>(
        &mut self,
        scene: &Scene,
        surroundings: &Surroundings,
        mut lap: impl FnMut(Stage, usize),
    ) {
        let Self { rays, hits, media, stack, radiance, .. } = self;
        self.occupancy.intersect = scene.intersect_all::<R>(surroundings, rays, hits, stack);
        lap(Stage::Intersect, rays.len);
        if surroundings.media {
            scene.travel::<R>(surroundings, rays, hits, radiance, media, stack);
            lap(Stage::Media, rays.len);
        }
    }

    /// Traces the shadow rays, and adds the light of those that nothing occludes to the radiance.
    pub fn trace_shadows<R: Real<Scalar = f32>>(&mut self, scene: &Scene, at: &Surroundings) {
        let Self { shadows, media, stack, radiance, .. } = self;
        self.occupancy.occlude = scene.receive::<R>(at, shadows, radiance, media, stack);
    }

    /// Forgets the radiance of the first `len` samples.
    pub fn clear_radiance(&mut self, len: usize) {
        self.radiance.iter_mut().for_each(|column| column[..len].fill(0.0));
    }
}
