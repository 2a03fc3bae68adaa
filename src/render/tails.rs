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

/// The paths of a tile that wait, each with the number of surfaces that they have met. A tail that is
/// empty serves for any number: paths of a million surfaces take no more room than short ones.
#[derive(Default)]
pub(super) struct Tails(Vec<(u32, Box<Tail>)>);

impl Tails {
    /// Takes the rays of a wave, fewer than [`FEW`], and their samples out of it.
    pub(super) fn defer(
        &mut self,
        depth: u32,
        samples: &mut SampleBatch,
        rays: &mut RayBatch,
        radiance: &[Column<f32>; 3],
    ) {
        if rays.len == 0 {
            return;
        }
        let tail = self.of(depth);
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
        let least = if last { 1 } else { WAVE - FEW + 1 };
        let ready = self.0.iter_mut().filter(|(_, tail)| tail.rays.len >= least);
        let full = |(depth, tail): &&mut (u32, Box<Tail>)| (tail.rays.len <= WAVE - FEW, *depth);
        ready.min_by_key(full).map(|(depth, tail)| (*depth, &mut **tail))
    }

    /// The tail of a depth, which may be a new one.
    fn of(&mut self, depth: u32) -> &mut Tail {
        let tails = &mut self.0;
        let known = tails.iter().position(|(of, tail)| *of == depth && tail.rays.len > 0);
        let place = known.or_else(|| tails.iter().position(|(_, tail)| tail.rays.len == 0));
        let place = place.unwrap_or_else(|| {
            tails.push((depth, Box::default()));
            tails.len() - 1
        });
        tails[place].0 = depth;
        &mut tails[place].1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rays::Ray;

    #[test]
    fn paths_of_any_depth_wait_in_the_room_of_those_that_wait_at_once() {
        let mut tails = Tails::default();
        let mut samples = SampleBatch::default();
        let mut rays = RayBatch::default();
        let mut radiance = <[Column<f32>; 3]>::default();
        let ray = Ray { origin: [0.0; 3], direction: [0.0, 0.0, 1.0], t_max: 1.0 };
        let mut defer = |tails: &mut Tails, depth: u32, count: usize| {
            for i in 0..count {
                rays.push(ray, [1.0; 3], i as u32);
            }
            tails.defer(depth, &mut samples, &mut rays, &radiance);
            assert_eq!(rays.len, 0);
        };
        for depth in [3, 1_000_000, 3, 70] {
            defer(&mut tails, depth, 1);
        }
        assert_eq!(tails.0.len(), 3);
        assert!(tails.next(false).is_none(), "none is full");
        let mut seen = Vec::new();
        let (mut samples, mut rays) = (SampleBatch::default(), RayBatch::default());
        while let Some((depth, tail)) = tails.next(true) {
            seen.push((depth, tail.rays.len));
            tail.swap(&mut samples, &mut rays, &mut radiance);
        }
        assert_eq!(seen, [(3, 2), (70, 1), (1_000_000, 1)]);
    }
}
