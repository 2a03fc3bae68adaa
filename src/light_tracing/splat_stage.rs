//! Splat stage: traces waves of light paths on all threads, and adds their light to the film.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};

use rayon::prelude::*;

use super::light_paths::{LightPathInput, Splat};
use super::strategy::{Strategy, StrategyColumns};
use crate::film::{FilmSums, PixelFilter};
use crate::lanes::Real;
use crate::lens::{LensModel, RealLens};
use crate::rays::{ColumnPool, WAVE_SIZE};
use crate::stats::{Stage, StageStats, Stats, thread_time};

/// Number of splats that wait to be added to the film from which on no further wave begins: 2.6 MB.
const MOST_WAITING: usize = 1 << 17;

/// The stage after all others. It keeps the columns of its workers from call to call.
#[derive(Default)]
pub struct SplatStage {
    columns: ColumnPool<StrategyColumns>,
}

impl SplatStage {
    /// Traces the light paths of these sample numbers by some strategies and adds their light to the
    /// film. `goes_on` is asked before each sample number but the first. Returns how many of them were
    /// added, each as a whole.
    ///
    /// Workers take waves in the order of the sample numbers, of the strategies and of the numbers of
    /// the waves, and their light is added in this order. So the sum depends on seed and sample numbers
    /// only, and the sums of disjoint ranges add up.
    pub fn run<R: Real<Scalar = f32>>(
        &self,
        input: &LightPathInput<'_>,
        strategies: &[Strategy<'_>],
        samples: Range<u32>,
        goes_on: &(dyn Fn() -> bool + Sync),
        film: &mut FilmSums,
        stats: &mut Stats,
    ) -> u32 {
        let LensModel::Real(lens) = &input.camera.model else { return samples.len() as u32 };
        let waves: Vec<(Strategy<'_>, u32)> = strategies
            .iter()
            .flat_map(|of| (0..of.waves(input.frame)).map(move |wave| (*of, wave)))
            .collect();
        if waves.is_empty() {
            return samples.len() as u32;
        }
        let per_sample = waves.len() as u64;
        let end = samples.len() as u64 * per_sample;
        let stats = &mut stats.stages[Stage::LightPaths as usize];
        let sums =
            Mutex::new(OrderedSums { input, film, stats, added: 0, waiting: BTreeMap::new() });
        let begins = |i: &u64| *i == 0 || !i.is_multiple_of(per_sample) || goes_on();
        let mut next = 0;
        while next < end && begins(&next) {
            // All waves are added once this ends, so that the next ones find room.
            let numbers = (next..end).take_while(|i| begins(i) && lock(&sums).has_room());
            numbers.par_bridge().for_each(|i| {
                let (strategy, wave) = waves[(i % per_sample) as usize];
                let sample = samples.start + (i / per_sample) as u32;
                let start = thread_time();
                let splats = match input.is_stopped() {
                    true => Vec::new(),
                    false => self.columns.lend(Box::default, |columns| {
                        strategy.trace::<R>(input, lens, columns, [wave, sample])
                    }),
                };
                let time = thread_time().saturating_sub(start);
                let mut sums = lock(&sums);
                sums.stats.time += time;
                sums.stats.rays += WAVE_SIZE as u64;
                sums.add(i, splats);
            });
            next = lock(&sums).added;
        }
        (next / per_sample) as u32
    }

    /// Returns the largest memory of the stage (bytes): the columns and the splats of each thread, and
    /// the splats that wait.
    pub fn bytes(
        strategies: &[Strategy<'_>],
        filter: &PixelFilter,
        lens: &RealLens,
        threads: u64,
    ) -> u64 {
        let columns: u64 = strategies.iter().map(|of| of.column_bytes()).sum();
        let of_wave = strategies.iter().map(|of| of.wave_bytes(filter, lens)).max().unwrap_or(0);
        let waiting = (MOST_WAITING * size_of::<Splat>()) as u64;
        if threads == 0 { 0 } else { waiting + threads * (columns + of_wave) }
    }
}

/// Sums of the light of waves that end in any order and are added in one.
struct OrderedSums<'a> {
    input: &'a LightPathInput<'a>,
    film: &'a mut FilmSums,
    stats: &'a mut StageStats,
    /// Number of waves that are added.
    added: u64,
    /// Splats of later waves, by their numbers.
    waiting: BTreeMap<u64, Vec<Splat>>,
}

impl OrderedSums<'_> {
    /// Adds the splats of a wave once those of all waves before it are added.
    fn add(&mut self, wave: u64, splats: Vec<Splat>) {
        self.waiting.insert(wave, splats);
        while let Some(splats) = self.waiting.remove(&self.added) {
            for Splat { pixel, light } in splats {
                let light = self.input.response.apply_colour(light.map(f64::from));
                self.film.add_light(pixel, light);
            }
            self.added += 1;
        }
    }

    fn has_room(&self) -> bool {
        self.waiting.values().map(Vec::len).sum::<usize>() < MOST_WAITING
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
