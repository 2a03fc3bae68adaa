//! Record of what shading did with the only ray of a wave, for replays of a sample.

use super::bsdf::BsdfKind;
use super::random::pair;
use super::vertices::vector;
use super::{ShadeColumns, ShadeInputs};
use petzval_base::rays::{Hit, NO_INDEX};
use petzval_scene::{GlossyLobe, LobeColumns, Reception};

/// Outcome of a path at a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PathOutcome {
    /// The path continues.
    Continues,
    /// The ray hit nothing.
    Escapes,
    /// The path has reached its maximum depth; only the light that this surface emits counts.
    DepthLimit,
    /// The throughput became 0.
    Absorbed,
    /// The path ended at its last light, which a shadow ray sampled without a second ray.
    Complete,
    /// Russian roulette ended the path.
    Roulette {
        /// Probability with which the path would have survived, less than 1.
        chance: f32,
    },
}

/// Sample of a light from a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampledLight {
    /// Index of the light in the scene.
    pub light: Option<u32>,
    /// Density of the sample, by solid angle; infinite if no other ray can hit the light.
    pub pdf: f32,
    /// Radiance that arrives if nothing occludes the light, over the density of the sample.
    pub radiance: [f32; 3],
}

/// Record of shading one ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VertexRecord {
    /// Name of the material's kind in pbrt-v4; empty if the surface was not shaded.
    pub kind: &'static str,
    /// Index of the surface's material, the chosen one if it is a mixture.
    pub material: Option<u32>,
    /// Shading normal, world space.
    pub normal: Option<[f32; 3]>,
    /// The sampled light.
    pub light: Option<SampledLight>,
    /// Outcome of the path.
    pub outcome: PathOutcome,
}

impl ShadeColumns {
    /// Returns what [`super::shade`] has just done with the first ray of a wave that has no other.
    pub fn record(&self, inputs: &ShadeInputs) -> VertexRecord {
        let ShadeInputs { scene, vertex, rays, hits, .. } = inputs;
        let outcome = PathOutcome::DepthLimit;
        let mut record =
            VertexRecord { kind: "", material: None, normal: None, light: None, outcome };
        if hits[0].shape == NO_INDEX {
            return VertexRecord { outcome: PathOutcome::Escapes, ..record };
        }
        if hits[0] == Hit::ABSORBED {
            return VertexRecord { outcome: PathOutcome::Absorbed, ..record };
        }
        if vertex.ends_path(rays.flags[0]) {
            return record;
        }
        let Self { random, vertices } = self;
        let (kind, material) = vertices.kinds[0];
        record.kind = kind.stage::<f32>().name();
        record.material = (kind != BsdfKind::Medium).then_some(material);
        let Some(at) = vertices.indices().next() else {
            return VertexRecord { outcome: PathOutcome::Continues, ..record };
        };
        record.normal = (kind != BsdfKind::Medium).then(|| vector(&vertices.normal, at));
        let position = vertices.surfaces.points::<f32>(at).position.into();
        let lobe =
            vertices.lobes.columns(&vertices.wo).and_then(|LobeColumns { wo, alpha2, share }| {
                GlossyLobe::new(vector(wo, at), alpha2[at], share[at])
            });
        let reception = Reception { facing: vector(&vertices.facing, at), lobe };
        let radiance = vector(&vertices.lights.radiance, at);
        record.light = (radiance != [0.0; 3]).then(|| SampledLight {
            light: scene.sampled_light(position, reception, pair(&random.choice, at)),
            pdf: vertices.lights.density[at],
            radiance,
        });
        let dark = vector(&vertices.next_throughput, at).iter().all(|&t| t <= 0.0);
        let complete = kind == BsdfKind::Diffuse && vertex.skips_mis(scene);
        record.outcome = match vertices.survival_probability(vertex, at) {
            _ if dark && complete => PathOutcome::Complete,
            _ if dark => PathOutcome::Absorbed,
            Some(chance) if random.roulette[0][at] >= chance => PathOutcome::Roulette { chance },
            _ => PathOutcome::Continues,
        };
        record
    }
}
