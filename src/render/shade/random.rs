//! Random numbers of a shading stage, generated for a whole wave at once: loops over columns
//! compile to eight lanes.

use super::PathVertex;
use super::vertices::Vertices;
use petzval_base::lanes::{Real, Word};
use petzval_base::rays::{SampleBatch, SortedColumn};
use petzval_base::sampler::{Dimension, fill_2d, hash};

/// A pair of random numbers for every vertex.
pub(super) type PairColumns = [SortedColumn<f32>; 2];

/// Random numbers in [0, 1) for the vertices of a wave.
#[derive(Clone, Debug, Default)]
pub(super) struct RandomColumns {
    key: SortedColumn<u32>,
    sample: SortedColumn<u32>,
    /// Choose a light, and a triangle of it.
    pub(super) choice: PairColumns,
    /// Choose a point of the light.
    pub(super) light: PairColumns,
    /// Choose the next direction.
    pub(super) bounce: PairColumns,
    /// The first decides Russian roulette, the second chooses a lobe of the BSDF.
    pub(super) roulette: PairColumns,
}

impl RandomColumns {
    /// Generates the numbers of all vertices. `spawning` is the first that has a next direction.
    pub(super) fn fill(
        &mut self,
        vertex: &PathVertex,
        vertices: &Vertices,
        spawning: usize,
        samples: &SampleBatch,
    ) {
        let (len, depth) = (vertices.end(), vertex.depth);
        for at in vertices.indices() {
            let slot = vertices.slot[at] as usize;
            self.key[at] = samples.key[slot];
            self.sample[at] = samples.sample[slot];
        }
        let fill = |[x, y]: &mut PairColumns, first: usize, dimension| {
            let (keys, indices) = (&self.key[first..len], &self.sample[first..len]);
            fill_2d(keys, indices, dimension, &mut x[first..len], &mut y[first..len]);
        };
        fill(&mut self.choice, 0, Dimension::LightChoice(depth));
        fill(&mut self.light, 0, Dimension::Light(depth));
        let spawning = spawning.min(len);
        fill(&mut self.bounce, spawning, Dimension::Bounce(depth));
        fill(&mut self.roulette, spawning, Dimension::Roulette(depth));
    }

    /// Returns the numbers that choose the next directions of the packet that begins at an entry.
    #[inline(always)]
    pub(super) fn bounce<R: Real<Scalar = f32>>(&self, at: usize) -> [R; 2] {
        [R::load(&self.bounce[0][at..]), R::load(&self.bounce[1][at..])]
    }

    /// Returns the seeds of random walks inside the surfaces of the packet that begins at an entry.
    #[inline(always)]
    pub(super) fn seeds<R: Real<Scalar = f32>>(&self, at: usize) -> R::Word {
        hash(R::Word::load(&self.key[at..]) ^ hash(R::Word::load(&self.sample[at..])))
    }
}

/// Returns the two numbers of a vertex.
pub(super) fn pair(columns: &PairColumns, at: usize) -> [f32; 2] {
    [columns[0][at], columns[1][at]]
}
