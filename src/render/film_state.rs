//! Film during a render whose tiles have different numbers of samples.

use super::RenderOutput;
use super::splat_accumulator::SplatAccumulator;
use super::wave::TileResult;
use crate::aov::{Aov, FeatureFilm, FeatureSums};
use crate::film::{DroppedSamples, FilmSums, Tile, TileSums};
use crate::job::Job;
use petzval_base::stats::Stats;

/// Film of a uniform render in the course of a pass. It holds every pixel once, for all workers.
pub(super) struct FilmState {
    film: FilmSums,
    features: Option<FeatureFilm>,
    /// The dropped samples of each tile.
    dropped: Vec<DroppedSamples>,
    /// Whether each tile holds the samples of the current pass.
    pub done: Vec<bool>,
}

impl FilmState {
    pub fn new(job: &Job, tiles: usize) -> Self {
        Self {
            film: FilmSums::with_squares(job.frame, job.layers.contains(&Aov::Variance))
                .with_extra(&job.extra_channels()),
            features: FeatureFilm::new(&job.layer_request()),
            dropped: vec![DroppedSamples::default(); tiles],
            done: vec![false; tiles],
        }
    }

    /// Adds the result of a tile in the current pass.
    pub fn add_result(&mut self, number: usize, tile: &Tile, result: &TileResult) {
        let mut sums = self.film.tile(tile);
        sums.add(&result.sums);
        self.film.set_tile(tile, &sums);
        self.dropped[number].add(&result.sums.dropped);
        if let (Some(film), Some(features)) = (&mut self.features, &result.features) {
            film.add(tile, features);
        }
        self.done[number] = true;
    }

    /// Returns the film, including the dropped samples of all tiles, and the features.
    pub fn into_film(mut self) -> (FilmSums, Option<FeatureFilm>) {
        self.dropped.iter().for_each(|dropped| self.film.dropped.add(dropped));
        (self.film, self.features)
    }

    /// Returns the sums of a tile.
    pub fn tile(&self, number: usize, tile: &Tile) -> (TileSums, Option<FeatureSums>) {
        let mut sums = self.film.tile(tile);
        sums.dropped = self.dropped[number].clone();
        (sums, self.features.as_ref().map(|features| features.tile(tile)))
    }

    /// Replaces the sums of a tile.
    pub fn set_tile(
        &mut self,
        number: usize,
        tile: &Tile,
        sums: &TileSums,
        features: Option<&FeatureSums>,
    ) {
        self.film.set_tile(tile, sums);
        self.dropped[number] = sums.dropped.clone();
        if let (Some(film), Some(features)) = (&mut self.features, features) {
            film.put(tile, features);
        }
    }
}

/// Returns the output of a render that was stopped, given the number of samples per pixel of each tile.
/// Pixels are means over their own samples, or black without any. Their noise is unknown.
pub(super) fn partial_output(
    tiles: &[Tile],
    samples: &[u32],
    (mut film, features): (FilmSums, Option<FeatureFilm>),
    splats: &SplatAccumulator,
    stats: Stats,
) -> RenderOutput {
    film.normalize(tiles.iter().zip(samples.iter().copied()));
    splats.add_mean_to(&mut film);
    let (mut taken, mut pixels) = (0.0, 0.0);
    for (tile, &samples) in tiles.iter().zip(samples) {
        let own = tile.size.map(f64::from).iter().product::<f64>();
        taken += own * f64::from(samples);
        pixels += own;
    }
    let partial_mean_spp = Some(taken / f64::max(pixels, 1.0));
    RenderOutput { film, features, stats, convergence: None, partial_mean_spp }
}
