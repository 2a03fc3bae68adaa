//! Targets of the next round: the number of samples that each tile of each buffer takes.

use std::sync::atomic::Ordering;
use std::time::Duration;

use super::sample_allocation::SampleAllocation;
use super::{Adaptive, FLOOR, INITIAL_SAMPLES};
use crate::Progress;

/// Samples per pixel of a quarter up to which a half buffer that is black takes more to find light.
const DARK_SAMPLES: u32 = 64;
/// Largest ratio between the samples of a half buffer in a tile and those that the other knows it by.
const MAX_RATIO: u32 = 8;
/// Returns the count of the next round on the way to a target. It at most doubles, and stops short of
/// a distant target, as the next round knows the variance better.
fn step(count: u32, target: u32) -> u32 {
    let missing = target.saturating_sub(count);
    let missing = if missing > count / 8 { missing - missing / 4 } else { missing };
    count.saturating_add(missing.min(count))
}

impl Adaptive<'_> {
    /// Returns the counts of the next round, by buffer. Stores the samples expected in total.
    pub(super) fn next_targets(&self, progress: &Progress) -> [Vec<u32>; 4] {
        let more = self.job.stop_criteria.time.map_or(f64::INFINITY, |time| {
            let elapsed = self.start.elapsed();
            let rate = self.taken() / elapsed.max(Duration::from_micros(1)).as_secs_f64();
            rate * time.saturating_sub(elapsed).as_secs_f64() / 4.0
        });
        let limit = self.lit_count() * self.job.samples.len() as f64 / 2.0;
        let pilots = [2, 3].map(|buffer| self.buffers[buffer].counts.clone());
        let left = (limit - pilots.iter().map(|counts| self.cost(counts)).sum::<f64>()) / 2.0;
        let wanted = [0, 1].map(|half| {
            let own = self.cost(&self.buffers[half].counts);
            self.wanted(half, left.min(own + more))
        });
        let more_pilots = [0, 1].map(|half| self.wanted_pilots(half, &wanted[1 - half]));
        let cost = wanted.iter().chain(&more_pilots).map(|counts| self.cost(counts)).sum::<f64>();
        progress.expected.store((2.0 * cost) as u64, Ordering::Relaxed);
        let pilots = if cost > limit { pilots } else { more_pilots };
        let [first, second] = [0, 1].map(|half| {
            let count = |i: usize| {
                let own = self.buffers[half].counts[i];
                let known = self.buffers[1 - half].counts[i].max(pilots[1 - half][i]);
                let most = known.saturating_mul(MAX_RATIO).saturating_add(MAX_RATIO - 1);
                step(own, wanted[half][i]).min(own.max(most))
            };
            (0..self.tiles.len()).map(count).collect()
        });
        let [first_pilots, second_pilots] = pilots;
        [first, second, first_pilots, second_pilots]
    }

    /// Returns the counts that a half buffer wants by the variance of the other. `budget` limits the
    /// samples of a quarter.
    fn wanted(&self, half: usize, budget: f64) -> Vec<u32> {
        let (own, other) = (&self.buffers[half].counts, &self.buffers[1 - half]);
        let mean = other.luminance(self.pixel_count());
        let variances = self.variances(1 - half, FLOOR * mean);
        let allocation = SampleAllocation::new(&self.pixels, own, &variances);
        if mean <= 0.0 && self.cost(&other.counts) < f64::from(DARK_SAMPLES) * self.lit_count() {
            return allocation.wanted(None, budget.min(2.0 * self.cost(own)));
        }
        // The mean of both half buffers halves their errors; their squares add up.
        let bound =
            self.job.stop_criteria.noise.map(|noise| 2.0 * self.pixel_count() * noise * noise);
        allocation.wanted(bound, budget)
    }

    /// Returns the relative variance of one sample, by a half buffer and its pilot samples together.
    fn variances(&self, half: usize, floor: f64) -> Vec<f64> {
        let [own, pilots] = [half, half + 2].map(|buffer| &self.buffers[buffer]);
        let [of_own, of_pilots] = [own, pilots].map(|buffer| buffer.variances(&self.tiles, floor));
        let mean = |i: usize| {
            let [a, b] = [own, pilots].map(|buffer| f64::from(buffer.counts[i]));
            (a * of_own[i] + b * of_pilots[i]) / (a + b)
        };
        (0..self.tiles.len()).map(mean).collect()
    }

    /// Returns the next counts of a half buffer's pilot samples, given the counts that the other one
    /// wants.
    fn wanted_pilots(&self, half: usize, wanted: &[u32]) -> Vec<u32> {
        let [known, pilots] = [half, half + 2].map(|buffer| &self.buffers[buffer].counts);
        let count = |((&known, &own), &wanted): ((&u32, &u32), &u32)| match wanted / MAX_RATIO {
            target if target > known.max(own) => step(known.max(own), target),
            _ => own,
        };
        known.iter().zip(pilots).zip(wanted).map(count).collect()
    }

    /// Returns whether saved targets are possible: not below the counts, not far above the limit of
    /// the job, which half buffers with different counts exceed a little, and not far above the known
    /// counts.
    pub(super) fn targets_are_plausible(&self) -> bool {
        let near = |buffer: usize, i: usize| {
            let [own, known] = [buffer, buffer % 2].map(|buffer| self.buffers[buffer].counts[i]);
            let target = self.targets[buffer][i];
            own <= target && target <= own.max(known).saturating_mul(2).max(INITIAL_SAMPLES)
        };
        let cost = 2.0 * self.targets.iter().map(|counts| self.cost(counts)).sum::<f64>();
        let limit = self.lit_count() * self.job.samples.len() as f64;
        cost <= 2.0 * limit && (0..4).all(|buffer| (0..self.tiles.len()).all(|i| near(buffer, i)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_approach_their_target_by_steps() {
        assert_eq!(step(8, 8), 8);
        assert_eq!(step(8, 5), 8);
        assert_eq!(step(8, 100), 16);
        assert_eq!(step(80, 120), 110);
        assert_eq!(step(80, 90), 90);
    }
}
