//! Light sampler: the random selection of a light for a point.

use glam::Vec3;

use super::tree::{Emitter, LightTree};
use super::{Light, mean};
use crate::scene::Shape;

/// All lights of a scene, and the light tree over those at finite distance.
#[derive(Clone, Debug, Default)]
pub struct Lights {
    /// Lights, by index.
    pub all: Vec<Light>,
    /// Indices of the infinite lights.
    pub skies: Vec<u32>,
    /// Indices of the sampled lights at infinite distance: distant lights, and skies with an image.
    distant: Vec<u32>,
    tree: LightTree,
    /// Light and primitive of every emitter of the tree.
    emitters: Vec<EmitterSource>,
}

/// Index of a light, and of a triangle if it is a mesh.
#[derive(Clone, Copy, Debug)]
struct EmitterSource {
    light: u32,
    primitive: u32,
}

/// A selected light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LightChoice {
    /// Index of the light.
    pub(super) light: u32,
    /// Index of its triangle if it is a mesh, otherwise 0.
    pub(super) primitive: u32,
    /// Probability of the selection.
    pub(super) probability: f32,
}

impl Lights {
    /// Builds the light tree.
    ///
    /// Each light at infinite distance has the same probability as all near lights together, as in
    /// pbrt-v4, because the power of a sky depends on the size of the scene. Lights without power
    /// and uniform skies are never selected.
    pub fn new(mut all: Vec<Light>, shapes: &[Shape]) -> Self {
        let mut emitters = Vec::new();
        let mut near = Vec::new();
        let mut far = Vec::new();
        for (light, kind) in (0..).zip(&mut all) {
            match kind {
                Light::Area(area) => {
                    let geometry = &shapes[area.shape as usize].geometry;
                    area.first_emitter = emitters.len() as u32;
                    for primitive in 0..area.emitter_count(geometry) as u32 {
                        let index = emitters.len() as u32;
                        emitters.push(EmitterSource { light, primitive });
                        let bounds = area.bounds(geometry, primitive);
                        near.extend(bounds.map(|bounds| Emitter { bounds, index }));
                    }
                }
                Light::Point(point) => {
                    let index = emitters.len() as u32;
                    emitters.push(EmitterSource { light, primitive: 0 });
                    near.extend(point.bounds().map(|bounds| Emitter { bounds, index }));
                }
                Light::Distant { irradiance, .. } => {
                    if mean(irradiance.map(|e| e.max(0.0))) > 0.0 {
                        far.push(light);
                    }
                }
                Light::Infinite(sky) => {
                    // BSDF sampling is as good as light sampling for a uniform sky.
                    if sky.image.is_some() && !sky.is_dark() {
                        far.push(light);
                    }
                }
            }
        }
        // Normalized to a sum of 1, so that no unit of radiance overflows.
        let sum: f64 = near.iter().map(|emitter| f64::from(emitter.bounds.intensity)).sum();
        for emitter in &mut near {
            let fraction = f64::from(emitter.bounds.intensity) / sum;
            emitter.bounds.intensity = (fraction as f32).max(f32::MIN_POSITIVE);
        }
        let skies = (0..all.len() as u32)
            .filter(|&i| matches!(all[i as usize], Light::Infinite(_)))
            .collect();
        let tree = LightTree::new(near, emitters.len());
        Self { all, skies, distant: far, tree, emitters }
    }

    /// Returns the number of equally probable choices: every light at infinite distance, and the
    /// tree.
    fn choice_count(&self) -> usize {
        self.distant.len() + usize::from(!self.tree.is_empty())
    }

    /// Selects a light for a point. Returns `None` if the rest of the tree cannot contribute.
    pub(super) fn choose(&self, p: Vec3, u: [f32; 2]) -> Option<LightChoice> {
        // Joins two numbers of 24 bits, because the tree may have millions of leaves.
        let u = f64::from(u[0]) + f64::from(u[1]) / f64::from(1 << 24);
        let choices = self.choice_count();
        let scaled = u * choices as f64;
        let choice_probability = 1.0 / choices as f32;
        if let Some(&light) = self.distant.get(scaled as usize) {
            return Some(LightChoice { light, primitive: 0, probability: choice_probability });
        }
        let (emitter, probability) = self.tree.choose(p, scaled - self.distant.len() as f64)?;
        let EmitterSource { light, primitive } = self.emitters[emitter as usize];
        Some(LightChoice { light, primitive, probability: probability * choice_probability })
    }

    /// Returns the probability with which [`Self::choose`] selects an emitter for a point.
    pub(super) fn probability(&self, p: Vec3, emitter: u32) -> f32 {
        self.tree.probability(p, emitter) / self.choice_count() as f32
    }

    /// Returns the probability with which [`Self::choose`] selects a light at infinite distance.
    pub(super) fn distant_probability(&self, light: u32) -> f32 {
        if self.distant.contains(&light) { 1.0 / self.choice_count() as f32 } else { 0.0 }
    }
}
