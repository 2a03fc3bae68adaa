//! Record of the path of a sample.

use crate::film::SampleId;
use crate::shade::VertexRecord;
use petzval_base::rays::{Hit, Ray};
use petzval_lens::RayPath;

/// Record of the path of a sample.
#[derive(Clone, Debug)]
pub struct Replay {
    /// The pixel, number and seed of the sample.
    pub name: SampleId,
    /// The film point, as in [`SampleBatch::film`](petzval_base::rays::SampleBatch::film).
    pub film: [f32; 2],
    /// The time, as in [`SampleBatch::time`](petzval_base::rays::SampleBatch::time), if anything moves.
    pub time: Option<f32>,
    /// The wavelengths of the three channels of the path (nm), if paths carry spectra. Throughputs and
    /// radiances are then those at these wavelengths, relative to daylight.
    pub wavelengths: Option<[f64; 3]>,
    /// The hero band, which the ray is traced in, if the lens has dispersion.
    pub band: Option<usize>,
    /// The filter weight, which may be negative.
    pub weight: f32,
    /// The ray path through a real lens.
    pub ray_path: Option<RayPath>,
    /// The bands that share the ray, the hero first.
    pub shared: Vec<SharedBand>,
    /// The ray in world space and its throughput, if it leaves the lens.
    pub ray: Option<(Ray, [f32; 3])>,
    /// The steps of the path. The last one may hit no surface.
    pub steps: Vec<PathStep>,
    /// The radiance of the path.
    pub radiance: [f32; 3],
    /// The value that is added to the sum of the pixel, bit for bit; `None` if the sample is dropped.
    pub value: Option<[f64; 3]>,
    /// The values that are added to the sums of the pixel by bucket, bit for bit; empty if the film has no
    /// buckets of wavelength, or the sample is dropped.
    pub buckets: Vec<f64>,
}

/// Band that shares a ray.
#[derive(Clone, Copy, Debug)]
pub struct SharedBand {
    /// The wavelength (nm).
    pub wavelength: f64,
    /// The film point and the transmission of the ray in this band; `None` if the lens blocks it.
    pub reprojection: Option<([f32; 2], f32)>,
}

/// Step of a path to its next surface.
#[derive(Clone, Copy, Debug)]
pub struct PathStep {
    /// The ray to the surface.
    pub ray: Ray,
    /// The throughput of the ray.
    pub throughput: [f32; 3],
    /// The hit.
    pub hit: Hit,
    /// The point and the geometric normal of the surface, world space; `None` if the ray hits none.
    pub surface: Option<[[f32; 3]; 2]>,
    /// The collision in a medium before a surface, if there is one.
    pub collision: Option<Collision>,
    /// The radiance that the surface or the sky emits.
    pub emitted_radiance: [f32; 3],
    /// The contribution of that emission, and of media on the way, to the radiance of the sample.
    pub emission: [f32; 3],
    /// The record of shading.
    pub record: VertexRecord,
    /// The shadow ray.
    pub shadow: Option<ShadowRay>,
    /// The next ray, its throughput, and the density of its direction by solid angle, which is infinite
    /// for a discrete direction.
    pub next: Option<(Ray, [f32; 3], f32)>,
    /// The radiance of the sample after this step.
    pub radiance: [f32; 3],
}

/// Collision of a ray in a medium, where it scatters.
#[derive(Clone, Copy, Debug)]
pub struct Collision {
    /// The index of the medium.
    pub medium: u32,
    /// The point, world space.
    pub at: [f32; 3],
}

/// Shadow ray of a step.
#[derive(Clone, Copy, Debug)]
pub struct ShadowRay {
    /// The ray.
    pub ray: Ray,
    /// The contribution to the radiance of the sample if nothing occludes it.
    pub contribution: [f32; 3],
    /// Whether nothing occludes it.
    pub unoccluded: bool,
}

/// Stage of a sample's path. Steps are counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PathStage {
    /// The ray that leaves the lens.
    Ray,
    /// The emission of a surface or the sky.
    Emission(usize),
    /// The light that a surface receives by a shadow ray.
    Light(usize),
    /// The radiance after a step.
    Sum(usize),
    /// The ray that leaves a surface.
    Next(usize),
}

impl Replay {
    /// Returns the first stage with a value that is not finite.
    pub fn first_non_finite(&self) -> Option<PathStage> {
        let bad = |values: &[f32]| values.iter().any(|value| !value.is_finite());
        let lost = |ray: &Ray, throughput: &[f32]| {
            bad(&ray.origin) || bad(&ray.direction) || bad(throughput)
        };
        if self.ray.is_some_and(|(ray, throughput)| lost(&ray, &throughput)) {
            return Some(PathStage::Ray);
        }
        let step = |(i, step): (usize, &PathStep)| {
            let light = step.record.light.is_some_and(|sampled| bad(&sampled.radiance));
            let light = light || step.shadow.is_some_and(|shadow| bad(&shadow.contribution));
            let next = step.next.is_some_and(|(ray, throughput, _)| lost(&ray, &throughput));
            let stages = [
                (bad(&step.emitted_radiance) || bad(&step.emission), PathStage::Emission(i)),
                (light, PathStage::Light(i)),
                (bad(&step.radiance), PathStage::Sum(i)),
                (next, PathStage::Next(i)),
            ];
            stages.into_iter().find_map(|(bad, stage)| bad.then_some(stage))
        };
        self.steps.iter().enumerate().find_map(step)
    }
}
