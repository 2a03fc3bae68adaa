//! The picture of a render that was stopped.

use super::haunt::Haunt;
use super::{Exposed, Job};
use crate::aov::{FeatureFilm, Features};
use crate::film::{FilmSums, Tile, TileSums};
use crate::stats::Stats;

/// What some samples of a tile have received.
pub(super) struct Part<'a> {
    /// Its number.
    pub tile: usize,
    pub sums: &'a TileSums,
    pub features: Option<&'a Features>,
    /// Of every pixel.
    pub samples: u32,
}

/// What there is: every pixel divided by its own count, and black where it has none. How exact
/// that is nobody knows.
pub(super) fn exposed<'a>(
    job: &Job,
    tiles: &[Tile],
    parts: impl Iterator<Item = Part<'a>>,
    haunt: &Haunt,
    stats: Stats,
) -> Exposed {
    let mut sums: Vec<TileSums> = tiles.iter().map(|tile| TileSums::new(tile, false)).collect();
    let mut features: Vec<_> = tiles.iter().map(|tile| Features::new(job, tile)).collect();
    let mut counts = vec![0; tiles.len()];
    for part in parts {
        counts[part.tile] += part.samples;
        sums[part.tile].add(part.sums);
        if let (Some(all), Some(more)) = (&mut features[part.tile], part.features) {
            all.add(more);
        }
    }
    let mut means = vec![[0.0; 3]; job.frame.size().map(|n| n as usize).iter().product()];
    let (mut taken, mut pixels) = (0.0, 0.0);
    for ((tile, sums), &count) in tiles.iter().zip(&sums).zip(&counts) {
        let scale = 1.0 / f64::from(count.max(1));
        let mean: Vec<[f64; 3]> = sums.light().iter().map(|sum| sum.map(|s| s * scale)).collect();
        tile.paste(&job.frame, &mean, &mut means);
        taken += mean.len() as f64 * f64::from(count);
        pixels += mean.len() as f64;
    }
    let mut film = FilmSums::settled(job.frame, means, Vec::new());
    sums.iter().for_each(|sums| film.dropped.add(&sums.dropped));
    haunt.put_mean(&mut film);
    Exposed {
        film,
        features: FeatureFilm::of(job, tiles.iter().zip(&features)),
        stats,
        reached: None,
        partial: Some(taken / f64::max(pixels, 1.0)),
    }
}
