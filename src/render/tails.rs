//! Paths that wait for company: few of a wave's paths go on for long, and packets of few rays
//! are mostly empty. Paths of several waves that have met as many surfaces go on together.

use crate::rays::{Column, NONE, RayBatch, SampleBatch, WAVE};

/// Fewer rays than this wait for others.
pub(super) const FEW: usize = WAVE / 2;

/// Paths that go on from the same depth, with all that is known of their samples.
#[derive(Default)]
pub(super) struct Tail {
    samples: SampleBatch,
    rays: RayBatch,
    radiance: [Column<f32>; 3],
}

impl Tail {
    /// Changes places with a wave, and is empty then.
    pub(super) fn swap(
        &mut self,
        samples: &mut SampleBatch,
        rays: &mut RayBatch,
        radiance: &mut [Column<f32>; 3],
    ) {
        std::mem::swap(&mut self.samples, samples);
        std::mem::swap(&mut self.rays, rays);
        std::mem::swap(&mut self.radiance, radiance);
        (self.samples.len, self.rays.len) = (0, 0);
    }
}

/// The paths of a tile that wait, by the number of surfaces they have met.
#[derive(Default)]
pub(super) struct Tails(Vec<Box<Tail>>);

impl Tails {
    /// Takes the rays of a wave, fewer than [`FEW`], and their samples out of it.
    pub(super) fn defer(
        &mut self,
        depth: u32,
        samples: &mut SampleBatch,
        rays: &mut RayBatch,
        radiance: &[Column<f32>; 3],
    ) {
        let depth = depth as usize;
        if self.0.len() <= depth {
            self.0.resize_with(depth + 1, Box::default);
        }
        let tail = &mut self.0[depth];
        tail.samples.seed = samples.seed;
        for i in 0..rays.len {
            let (from, to) = (rays.slot[i] as usize, tail.samples.len);
            tail.samples.pixel[to] = samples.pixel[from];
            tail.samples.key[to] = samples.key[from];
            tail.samples.sample[to] = samples.sample[from];
            tail.samples.weight[to] = samples.weight[from];
            tail.samples.time[to] = samples.time[from];
            for channel in 0..3 {
                tail.radiance[channel][to] = radiance[channel][from];
            }
            tail.samples.len = to + 1;
            tail.rays.push(rays.ray(i), rays.carried(i), to as u32);
            tail.rays.density[to] = rays.density[i];
            tail.rays.roulette_scale[to] = rays.roulette_scale[i];
            tail.rays.differential[to] = rays.differential[i];
            // It arrives by another wave.
            samples.pixel[from] = NONE;
        }
        rays.len = 0;
    }

    /// The depth and the paths of a tail that must go on before others may come: one that has no
    /// room for those of another wave, or where no more come (`last`) the shallowest of all.
    pub(super) fn next(&mut self, last: bool) -> Option<(u32, &mut Tail)> {
        let full = self.0.iter().position(|tail| tail.rays.len > WAVE - FEW);
        let any = || self.0.iter().position(|tail| tail.rays.len > 0).filter(|_| last);
        let depth = full.or_else(any)?;
        Some((depth as u32, &mut self.0[depth]))
    }
}
