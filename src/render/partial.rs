//! The picture of a render that was stopped.

use super::Exposed;
use super::haunt::Haunt;
use crate::aov::FeatureFilm;
use crate::film::{FilmSums, Tile};
use crate::stats::Stats;

/// What there is, where the pixels of each tile took so many samples: every pixel divided by its own
/// count, and black where it has none. How exact that is nobody knows.
pub(super) fn exposed(
    tiles: &[Tile],
    samples: &[u32],
    (mut film, features): (FilmSums, Option<FeatureFilm>),
    haunt: &Haunt,
    stats: Stats,
) -> Exposed {
    film.settle(tiles.iter().zip(samples.iter().copied()));
    haunt.put_mean(&mut film);
    let (mut taken, mut pixels) = (0.0, 0.0);
    for (tile, &samples) in tiles.iter().zip(samples) {
        let own = tile.size.map(f64::from).iter().product::<f64>();
        taken += own * f64::from(samples);
        pixels += own;
    }
    let partial = Some(taken / f64::max(pixels, 1.0));
    Exposed { film, features, stats, reached: None, partial }
}
