//! Weights of camera paths that end at a light which light paths find too.

use std::fmt::Debug;

use petzval_base::rays::{Hit, RayBatch};
use petzval_scene::{Scene, SurfacePoint};

/// Light source that a ray found.
#[derive(Clone, Copy, Debug)]
pub enum LightSource<'a> {
    /// A point of a shape, and its hit.
    Shape(&'a Hit, &'a SurfacePoint),
    /// A sky, by its index among the lights.
    Sky(u32),
}

/// Multiple importance sampling of camera paths against light paths that find the same light.
pub trait LampWeights: Debug {
    /// Returns the weight of the light that the `i`-th camera ray of a wave found. `time` is that of
    /// its sample.
    fn camera_weight(
        &self,
        scene: &Scene,
        rays: &RayBatch,
        i: usize,
        time: f32,
        source: LightSource,
    ) -> f32;
}
