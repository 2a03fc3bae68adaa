//! Which light, for a point.

use glam::Vec3;

use super::tree::{Emitter, LightTree};
use super::{Light, mean};
use crate::scene::Shape;

/// All lights of a scene, and the tree of those at finite places.
#[derive(Clone, Debug, Default)]
pub struct Lights {
    /// The lights.
    pub all: Vec<Light>,
    /// Those among them that fill the sky.
    pub skies: Vec<u32>,
    /// Those among them that are infinitely far away and sampled: beams and skies with an image.
    far: Vec<u32>,
    tree: LightTree,
    /// Light and triangle of it of every emitter.
    emitters: Vec<[u32; 2]>,
}

/// A light, or a part of one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Choice {
    pub(super) light: u32,
    /// Which triangle of a mesh; 0 for all else.
    pub(super) part: u32,
    pub(super) probability: f32,
}

impl Lights {
    /// Builds the tree. Each light that is infinitely far away gets as much as all that are
    /// near together, as in pbrt-v4: which power a sky has depends on how much empty ground
    /// the scene holds. Lights of no power and uniform skies are never chosen.
    pub fn new(mut all: Vec<Light>, shapes: &[Shape]) -> Self {
        let mut emitters = Vec::new();
        let mut near = Vec::new();
        let mut far = Vec::new();
        for (light, kind) in (0..).zip(&mut all) {
            match kind {
                Light::Area(area) => {
                    let geometry = &shapes[area.shape as usize].geometry;
                    area.first = emitters.len() as u32;
                    for part in 0..area.parts(geometry) as u32 {
                        let index = emitters.len() as u32;
                        emitters.push([light, part]);
                        let bounds = area.bounds(geometry, part);
                        near.extend(bounds.map(|bounds| Emitter { bounds, index }));
                    }
                }
                Light::Lamp(lamp) => {
                    let index = emitters.len() as u32;
                    emitters.push([light, 0]);
                    near.extend(lamp.bounds().map(|bounds| Emitter { bounds, index }));
                }
                Light::Distant { irradiance, .. } => {
                    if mean(irradiance.map(|e| e.max(0.0))) > 0.0 {
                        far.push(light);
                    }
                }
                Light::Infinite(sky) => {
                    // No direction of a uniform sky is better than those that the surface would
                    // choose.
                    if sky.image.is_some() && !sky.is_dark() {
                        far.push(light);
                    }
                }
            }
        }
        // The sum of all is 1, so that no unit of radiance makes them overflow.
        let sum: f64 = near.iter().map(|emitter| f64::from(emitter.bounds.intensity)).sum();
        for emitter in &mut near {
            let share = f64::from(emitter.bounds.intensity) / sum;
            emitter.bounds.intensity = (share as f32).max(f32::MIN_POSITIVE);
        }
        let skies = (0..all.len() as u32)
            .filter(|&i| matches!(all[i as usize], Light::Infinite(_)))
            .collect();
        let tree = LightTree::new(near, emitters.len());
        Self { all, skies, far, tree, emitters }
    }

    /// How many are chosen with equal probability: every far light, and the tree.
    fn groups(&self) -> usize {
        self.far.len() + usize::from(!self.tree.is_empty())
    }

    /// Chooses a light for a point.
    pub(super) fn choose(&self, p: Vec3, u: [f32; 2]) -> Option<Choice> {
        // Both numbers of 24 bits make one: the tree may have millions of leaves.
        let u = f64::from(u[0]) + f64::from(u[1]) / f64::from(1 << 24);
        let groups = self.groups();
        let scaled = u * groups as f64;
        let share = 1.0 / groups as f32;
        if let Some(&light) = self.far.get(scaled as usize) {
            return Some(Choice { light, part: 0, probability: share });
        }
        let (emitter, probability) = self.tree.choose(p, scaled - self.far.len() as f64)?;
        let [light, part] = self.emitters[emitter as usize];
        Some(Choice { light, part, probability: probability * share })
    }

    /// The probability with which [`Self::choose`] chooses an emitter for a point.
    pub(super) fn probability(&self, p: Vec3, emitter: u32) -> f32 {
        self.tree.probability(p, emitter) / self.groups() as f32
    }

    /// The same for a light that is infinitely far away.
    pub(super) fn far_probability(&self, light: u32) -> f32 {
        if self.far.contains(&light) { 1.0 / self.groups() as f32 } else { 0.0 }
    }
}
