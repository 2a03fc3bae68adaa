//! The memory that a render takes.

use super::tails::Tail;
use super::{Job, Wave};
use crate::aov::FeatureFilm;
use crate::film::FilmSums;

/// Bytes of a thread beside its columns: its stack, its heap and a tile.
const OF_THREAD: u64 = 1 << 18;
/// Depths at which waves wait in a render, at most: no scene is known where it is more.
const MOST_WAITING: u64 = 100;

/// Bytes that each thread of a render takes, about: its wave, and those that wait at each depth.
pub fn bytes_of_thread(job: &Job) -> u64 {
    let depths = u64::from(job.reach.max_depth).min(MOST_WAITING) + 1;
    size_of::<Wave>() as u64 + OF_THREAD + depths * size_of::<Tail>() as u64
}

/// Bytes of a pixel, at most, that rounds of samples take: four quarters, and what they and the
/// scouts receive in a round, with their features.
pub fn bytes_of_round(job: &Job) -> u64 {
    4 * FilmSums::bytes(false) + 4 * (FilmSums::bytes(false) + FeatureFilm::bytes(job))
}
