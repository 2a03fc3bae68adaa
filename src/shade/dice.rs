//! The random numbers of a shading stage, thrown for the whole wave at once: the loops over
//! columns compile to eight lanes.

use super::Vertex;
use crate::rays::{Column, RayBatch, SampleBatch};
use crate::sampler::{Dimension, hash, pairs};

/// A pair of random numbers for every ray.
type Pairs = [Column<f32>; 2];

/// Columns of random numbers.
#[derive(Clone, Debug, Default)]
pub struct Dice {
    key: Column<u32>,
    sample: Column<u32>,
    choice: Pairs,
    light: Pairs,
    bounce: Pairs,
    roulette: Pairs,
}

/// The random numbers of one ray at one surface.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Throw {
    /// Which light, and which triangle of it.
    pub(super) choice: [f32; 2],
    /// Where on the light.
    pub(super) light: [f32; 2],
    /// Where the path goes on.
    pub(super) bounce: [f32; 2],
    /// Whether it does, and by which lobe of the surface.
    pub(super) roulette: [f32; 2],
    /// Of what random walks inside the surface begin with.
    pub(super) seed: u32,
}

impl Dice {
    /// Throws for all rays of a wave at one vertex of their paths.
    pub(super) fn throw(&mut self, vertex: &Vertex, rays: &RayBatch, samples: &SampleBatch) {
        let (len, depth) = (rays.len, vertex.depth);
        for i in 0..len {
            let slot = rays.slot[i] as usize;
            self.key[i] = samples.key[slot];
            self.sample[i] = samples.sample[slot];
        }
        let (keys, indices) = (&self.key[..len], &self.sample[..len]);
        let fill =
            |[x, y]: &mut Pairs, dimension| pairs(keys, indices, dimension, &mut x[..], &mut y[..]);
        fill(&mut self.choice, Dimension::Choice(depth));
        fill(&mut self.light, Dimension::Light(depth));
        fill(&mut self.bounce, Dimension::Bounce(depth));
        fill(&mut self.roulette, Dimension::Roulette(depth));
    }

    /// What was thrown for a ray.
    pub(super) fn at(&self, i: usize) -> Throw {
        let both = |pairs: &Pairs| [pairs[0][i], pairs[1][i]];
        Throw {
            choice: both(&self.choice),
            light: both(&self.light),
            bounce: both(&self.bounce),
            roulette: both(&self.roulette),
            seed: hash(self.key[i] ^ hash(self.sample[i])),
        }
    }
}
