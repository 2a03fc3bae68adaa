//! Deferral of sparse paths: merges paths of equal depth into full waves.
//!
//! Few paths of a wave are long, and SIMD packets of few rays are mostly empty. So paths of several
//! waves that have met the same number of surfaces continue together.

use petzval_base::rays::{Column, NO_INDEX, RayBatch, SampleBatch, WAVE_SIZE};

/// Number of rays below which the paths of a wave are deferred.
pub(super) const DEFER_BELOW: usize = WAVE_SIZE / 2;

/// Deferred paths of equal depth, with their samples and their radiance so far.
#[derive(Default)]
pub(super) struct PathGroup {
    samples: SampleBatch,
    rays: RayBatch,
    radiance: [Column<f32>; 3],
}

impl PathGroup {
    /// Swaps contents with a wave, and is empty afterwards.
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

/// Deferred paths of a tile in groups, each with its depth: the number of surfaces that its paths have
/// met. An empty group serves for any depth, so the memory does not grow with path length.
#[derive(Default)]
pub(super) struct DeferredPaths(Vec<(u32, Box<PathGroup>)>);

impl DeferredPaths {
    /// Moves the rays of a wave, fewer than [`DEFER_BELOW`], and their samples to the group of a depth.
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
        let group = self.group(depth);
        group.samples.seed = samples.seed;
        (group.samples.set, group.samples.hero) = (samples.set, samples.hero);
        for i in 0..rays.len {
            let (from, to) = (rays.slot[i] as usize, group.samples.len);
            group.samples.pixel[to] = samples.pixel[from];
            group.samples.key[to] = samples.key[from];
            group.samples.sample[to] = samples.sample[from];
            group.samples.weight[to] = samples.weight[from];
            group.samples.time[to] = samples.time[from];
            group.samples.left_half[to] = samples.left_half[from];
            for channel in 0..3 {
                group.radiance[channel][to] = radiance[channel][from];
            }
            group.samples.len = to + 1;
            group.rays.push(rays.ray(i), rays.throughput(i), to as u32);
            group.rays.pdf[to] = rays.pdf[i];
            group.rays.flags[to] = rays.flags[i];
            group.rays.medium[to] = rays.medium[i];
            group.rays.roulette_scale[to] = rays.roulette_scale[i];
            group.rays.set_facing(to, rays.facing(i).to_array());
            for axis in 0..3 {
                group.rays.wo[axis][to] = rays.wo[axis][i];
            }
            for (to_column, column) in group.rays.gloss.iter_mut().zip(&rays.gloss) {
                to_column[to] = column[i];
            }
            group.rays.differential[to] = rays.differential[i];
            // The sample is accumulated with the wave that its path continues in.
            samples.pixel[from] = NO_INDEX;
        }
        rays.len = 0;
    }

    /// Returns a group that must continue before more paths are deferred: one without room for those of
    /// another wave, or, if no more follow (`last`), the shallowest.
    pub(super) fn next(&mut self, last: bool) -> Option<(u32, &mut PathGroup)> {
        let least = if last { 1 } else { WAVE_SIZE - DEFER_BELOW + 1 };
        let ready = self.0.iter_mut().filter(|(_, group)| group.rays.len >= least);
        let full = |(depth, group): &&mut (u32, Box<PathGroup>)| {
            (group.rays.len <= WAVE_SIZE - DEFER_BELOW, *depth)
        };
        ready.min_by_key(full).map(|(depth, group)| (*depth, &mut **group))
    }

    /// Returns the group of a depth, or adds it.
    fn group(&mut self, depth: u32) -> &mut PathGroup {
        let groups = &mut self.0;
        let known = groups.iter().position(|(of, group)| *of == depth && group.rays.len > 0);
        let index = known.or_else(|| groups.iter().position(|(_, group)| group.rays.len == 0));
        let index = index.unwrap_or_else(|| {
            groups.push((depth, Box::default()));
            groups.len() - 1
        });
        groups[index].0 = depth;
        &mut groups[index].1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use petzval_base::rays::Ray;

    #[test]
    fn memory_depends_on_the_number_of_groups_not_on_depth() {
        let mut groups = DeferredPaths::default();
        let mut samples = SampleBatch::default();
        let mut rays = RayBatch::default();
        let mut radiance = <[Column<f32>; 3]>::default();
        let ray = Ray { origin: [0.0; 3], direction: [0.0, 0.0, 1.0], t_max: 1.0 };
        let mut defer = |groups: &mut DeferredPaths, depth: u32, count: usize| {
            for i in 0..count {
                rays.push(ray, [1.0; 3], i as u32);
            }
            groups.defer(depth, &mut samples, &mut rays, &radiance);
            assert_eq!(rays.len, 0);
        };
        for depth in [3, 1_000_000, 3, 70] {
            defer(&mut groups, depth, 1);
        }
        assert_eq!(groups.0.len(), 3);
        assert!(groups.next(false).is_none(), "none is full");
        let mut seen = Vec::new();
        let (mut samples, mut rays) = (SampleBatch::default(), RayBatch::default());
        while let Some((depth, group)) = groups.next(true) {
            seen.push((depth, group.rays.len));
            group.swap(&mut samples, &mut rays, &mut radiance);
        }
        assert_eq!(seen, [(3, 2), (70, 1), (1_000_000, 1)]);
    }
}
