//! Random numbers of a shading stage, generated for a whole wave at once: loops over columns
//! compile to eight lanes.

use super::PathVertex;
use crate::rays::{Column, RayBatch, SampleBatch};
use crate::sampler::{Dimension, fill_2d, hash};

/// A pair of random numbers for every ray.
type PairColumns = [Column<f32>; 2];

/// Random numbers in [0, 1) for the rays of a wave at one vertex of their paths.
#[derive(Clone, Debug, Default)]
pub(super) struct RandomColumns {
    key: Column<u32>,
    sample: Column<u32>,
    choice: PairColumns,
    light: PairColumns,
    bounce: PairColumns,
    roulette: PairColumns,
}

/// The random numbers of one ray at one vertex of its path.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct VertexRandom {
    /// Chooses a light, and a triangle of it.
    pub(super) choice: [f32; 2],
    /// Chooses a point of the light.
    pub(super) light: [f32; 2],
    /// Chooses the next direction.
    pub(super) bounce: [f32; 2],
    /// The first decides Russian roulette, the second chooses a lobe of the BSDF.
    pub(super) roulette: [f32; 2],
    /// Seed of random walks inside the surface.
    pub(super) seed: u32,
}

impl RandomColumns {
    /// Generates the numbers of all rays of a wave.
    pub(super) fn fill(&mut self, vertex: &PathVertex, rays: &RayBatch, samples: &SampleBatch) {
        let (len, depth) = (rays.len, vertex.depth);
        for i in 0..len {
            let slot = rays.slot[i] as usize;
            self.key[i] = samples.key[slot];
            self.sample[i] = samples.sample[slot];
        }
        let (keys, indices) = (&self.key[..len], &self.sample[..len]);
        let fill = |[x, y]: &mut PairColumns, dimension| {
            fill_2d(keys, indices, dimension, &mut x[..], &mut y[..]);
        };
        fill(&mut self.choice, Dimension::LightChoice(depth));
        fill(&mut self.light, Dimension::Light(depth));
        fill(&mut self.bounce, Dimension::Bounce(depth));
        fill(&mut self.roulette, Dimension::Roulette(depth));
    }

    /// Returns the numbers of the i-th ray.
    pub(super) fn at(&self, i: usize) -> VertexRandom {
        let both = |pair: &PairColumns| [pair[0][i], pair[1][i]];
        VertexRandom {
            choice: both(&self.choice),
            light: both(&self.light),
            bounce: both(&self.bounce),
            roulette: both(&self.roulette),
            seed: hash(self.key[i] ^ hash(self.sample[i])),
        }
    }
}
