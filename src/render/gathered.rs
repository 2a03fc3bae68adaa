//! What the pixels of an even render have received by now, each of its own number of samples.

use super::Job;
use super::keeper::Received;
use crate::aov::{Aov, FeatureFilm, FeatureSums};
use crate::film::{Dropped, FilmSums, Tile, TileSums};

/// The film while tiles of it are exposed. Every pixel is there once, whoever works on its tile.
pub(super) struct Gathered {
    film: FilmSums,
    features: Option<FeatureFilm>,
    /// Samples of each tile that were left out.
    dropped: Vec<Dropped>,
    /// The tiles that have received the samples of the present pass.
    pub entered: Vec<bool>,
}

impl Gathered {
    pub fn new(job: &Job, tiles: usize) -> Self {
        Self {
            film: FilmSums::new(job.frame, job.layers.contains(&Aov::Variance)),
            features: FeatureFilm::new(job),
            dropped: vec![Dropped::default(); tiles],
            entered: vec![false; tiles],
        }
    }

    /// Adds what a tile has received in the present pass.
    pub fn enter(&mut self, number: usize, tile: &Tile, (more, met): &Received) {
        let mut sums = self.film.tile(tile);
        sums.add(more);
        self.film.put(tile, &sums);
        self.dropped[number].add(&more.dropped);
        if let (Some(features), Some(met)) = (&mut self.features, met) {
            features.add(tile, met);
        }
        self.entered[number] = true;
    }

    /// The film, with all that was left out.
    pub fn into_film(mut self) -> (FilmSums, Option<FeatureFilm>) {
        self.dropped.iter().for_each(|dropped| self.film.dropped.add(dropped));
        (self.film, self.features)
    }

    /// What a tile has received.
    pub fn tile(&self, number: usize, tile: &Tile) -> (TileSums, Option<FeatureSums>) {
        let mut sums = self.film.tile(tile);
        sums.dropped = self.dropped[number].clone();
        (sums, self.features.as_ref().map(|features| features.tile(tile)))
    }

    /// Takes over what a tile has received, and what its paths met.
    pub fn put(
        &mut self,
        number: usize,
        tile: &Tile,
        sums: &TileSums,
        features: Option<&FeatureSums>,
    ) {
        self.film.put(tile, sums);
        self.dropped[number] = sums.dropped.clone();
        if let (Some(film), Some(features)) = (&mut self.features, features) {
            film.put(tile, features);
        }
    }
}
