//! Light sampler: the random selection of a light for a point.

use std::sync::Arc;

use super::tree::{Emitter, LightTree, Receiver};
use super::{AreaLight, Light, mean};
use crate::{Geometry, Shape};
use petzval_base::lanes::Real;

/// All lights of a scene, and the light tree over those at finite distance.
#[derive(Clone, Debug, Default)]
pub struct Lights {
    /// Lights, by index.
    pub all: Vec<Light>,
    /// Indices of the infinite lights.
    pub skies: Vec<u32>,
    /// Indices of the sampled lights at infinite distance: distant lights, and skies with an image.
    distant: Vec<u32>,
    tree: Arc<LightTree>,
    /// Light and primitive of every emitter of the tree.
    emitters: Arc<[EmitterSource]>,
}

/// Index of a light, and of a triangle if it is a mesh.
#[derive(Clone, Copy, Debug)]
struct EmitterSource {
    light: u32,
    primitive: u32,
    class: EmitterClass,
}

/// Kind of an emitter. Points on emitters of one class are sampled together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum EmitterClass {
    /// A triangle of uniform emission.
    Triangle,
    /// A whole disk of uniform emission.
    Disk,
    /// A whole sphere of uniform emission.
    Sphere,
    /// All others, and lights at infinite distance: sampled one at a time.
    General,
}

impl EmitterClass {
    /// Returns the class of the emitters of an area light.
    fn of(light: &AreaLight, shape: &Shape) -> Self {
        match &shape.geometry {
            _ if light.emission.image.is_some() || !shape.is_opaque() => Self::General,
            Geometry::Mesh(_) => Self::Triangle,
            Geometry::Quadric(_) if light.disk.is_some() => Self::Disk,
            Geometry::Quadric(_) if light.sphere.is_some() => Self::Sphere,
            Geometry::Patches(_) | Geometry::Curves(_) | Geometry::Quadric(_) => Self::General,
        }
    }
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
                    let shape = &shapes[area.shape as usize];
                    let (geometry, class) = (&shape.geometry, EmitterClass::of(area, shape));
                    area.first_emitter = emitters.len() as u32;
                    for primitive in 0..area.emitter_count(geometry) as u32 {
                        let index = emitters.len() as u32;
                        emitters.push(EmitterSource { light, primitive, class });
                        let bounds = area.bounds(geometry, primitive);
                        near.extend(bounds.map(|bounds| Emitter { bounds, index }));
                    }
                }
                Light::Point(point) => {
                    let index = emitters.len() as u32;
                    let class = EmitterClass::General;
                    emitters.push(EmitterSource { light, primitive: 0, class });
                    near.extend(point.bounds().map(|bounds| Emitter { bounds, index }));
                }
                Light::Distant { irradiance, .. } => {
                    if mean(irradiance.rgb.map(|e| e.max(0.0))) > 0.0 {
                        far.push(light);
                    }
                }
                Light::Infinite(sky) => {
                    // BSDF sampling is as good as light sampling for a uniform sky.
                    if sky.image.is_some() && !sky.is_dark() {
                        far.push(light);
                    }
                }
                Light::Portal(portal) => {
                    if !portal.is_dark() {
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
            .filter(|&i| matches!(all[i as usize], Light::Infinite(_) | Light::Portal(_)))
            .collect();
        let tree = LightTree::new(near, emitters.len());
        let (tree, emitters) = (Arc::new(tree), emitters.into());
        Self { all, skies, distant: far, tree, emitters }
    }

    /// Returns lights that emit other colours, and are sampled as these are.
    pub(crate) fn with_emission(&self, change: impl Fn(&mut Light)) -> Self {
        let mut lights = self.clone();
        lights.all.iter_mut().for_each(change);
        lights
    }

    /// Returns the number of equally probable choices: every light at infinite distance, and the
    /// tree.
    fn choice_count(&self) -> usize {
        self.distant.len() + usize::from(!self.tree.is_empty())
    }

    /// Selects a light for one receiver by two numbers in [0, 1). Returns `None` if the rest of the
    /// tree cannot contribute.
    pub(super) fn choose(&self, receiver: &Receiver<f32>, u: [f32; 2]) -> Option<LightChoice> {
        let (index, rest) = self.split(u[0]);
        let probability = self.choice_probability();
        if let Some(&light) = self.distant.get(index as usize) {
            return Some(LightChoice { light, primitive: 0, probability });
        }
        if self.tree.is_empty() {
            return None;
        }
        let (emitter, in_tree) = match self.tree.only_emitter() {
            Some(only) => (only, 1.0),
            None => self.tree.choose(receiver, [rest, u[1]])?,
        };
        Some(self.emitter_choice(emitter, in_tree * probability))
    }

    /// Returns the choice of an emitter of the tree.
    pub(super) fn emitter_choice(&self, emitter: u32, probability: f32) -> LightChoice {
        let EmitterSource { light, primitive, .. } = self.emitters[emitter as usize];
        LightChoice { light, primitive, probability }
    }

    /// Returns the choice of a light at infinite distance.
    pub(super) fn distant_choice(&self, index: usize) -> LightChoice {
        let probability = self.choice_probability();
        LightChoice { light: self.distant[index], primitive: 0, probability }
    }

    /// Returns whether there is a choice that depends on how a surface receives light.
    pub fn choose_by_reception(&self) -> bool {
        !self.tree.is_empty() && self.tree.only_emitter().is_none()
    }

    /// Returns the class of an emitter.
    pub(super) fn class(&self, emitter: u32) -> EmitterClass {
        self.emitters[emitter as usize].class
    }

    /// Returns the tree of the lights at finite distance.
    pub(super) fn tree(&self) -> &LightTree {
        &self.tree
    }

    /// Returns the number of lights at infinite distance that are selected.
    pub(super) fn distant_count(&self) -> usize {
        self.distant.len()
    }

    /// Splits a number in [0, 1): returns which of the equally probable choices it selects, as an
    /// integer, and another number in [0, 1). Lights at infinite distance come first.
    #[inline(always)]
    pub(super) fn split<R: Real<Scalar = f32>>(&self, u: R) -> (R, R) {
        let scaled = u * R::splat(self.choice_count() as f32);
        let index = scaled.floor().min(R::splat(self.choice_count().max(1) as f32 - 1.0));
        (index, (scaled - index).min(R::splat(1.0 - f32::EPSILON / 2.0)))
    }

    /// Returns the probability of each of the equally probable choices.
    pub(super) fn choice_probability(&self) -> f32 {
        1.0 / self.choice_count() as f32
    }

    /// Returns the probability with which [`Self::choose`] selects an emitter.
    pub(super) fn probability(&self, receiver: &Receiver<f32>, emitter: u32) -> f32 {
        let in_tree = match self.tree.only_emitter() {
            Some(only) if only == emitter => 1.0,
            _ => self.tree.probability(receiver, emitter),
        };
        in_tree * self.choice_probability()
    }

    /// Returns the indices of the skies that are sampled: those with an image, and portals.
    pub fn sampled_skies(&self) -> impl Iterator<Item = u32> {
        self.skies.iter().copied().filter(|sky| self.distant.contains(sky))
    }

    /// Returns the probability with which [`Self::choose`] selects a light at infinite distance.
    pub(super) fn distant_probability(&self, light: u32) -> f32 {
        if self.distant.contains(&light) { self.choice_probability() } else { 0.0 }
    }
}
