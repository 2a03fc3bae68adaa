//! Output of an adaptive render: the picture, its variance and its features.

use super::half_buffer::{luminance, relative_variance};
use super::{Adaptive, FLOOR};
use crate::aov::FeatureFilm;
use crate::film::{FilmSums, clamp_to_f32};
use crate::film_state::partial_output;
use crate::wave::WorkItem;
use crate::{Convergence, RenderOutput};
use petzval_base::stats::Stats;

impl Adaptive<'_> {
    /// Returns the output of a complete render.
    pub(super) fn finish(self, stats: Stats) -> RenderOutput {
        let frame = self.job.frame;
        let mut means = vec![[0.0; 3]; frame.size().map(|n| n as usize).iter().product()];
        let mut variances = vec![[0.0; 3]; means.len()];
        let [first, second, ..] = &self.buffers;
        let floor =
            [first, second].map(|half| half.luminance(self.pixel_count())).iter().sum::<f64>()
                / 2.0;
        let mut error = 0.0;
        for (i, tile) in self.tiles.iter().enumerate() {
            let pixel = |([a, b], [c, d]): ([[f64; 3]; 2], [[f64; 3]; 2])| {
                let mean = [0, 1, 2].map(|k| (a[k] + b[k] + c[k] + d[k]) / 4.0);
                let variance = |a: f64, b: f64| (a - b).powi(2) / 16.0;
                let [p, q, r, s] = [a, b, c, d].map(luminance);
                let both = variance(p, q) + variance(r, s);
                error += relative_variance(both, luminance(mean), FLOOR * floor);
                (mean, [0, 1, 2].map(|k| clamp_to_f32(variance(a[k], b[k]) + variance(c[k], d[k]))))
            };
            let (mean, variance): (Vec<_>, Vec<_>) =
                first.means(i).zip(second.means(i)).map(pixel).unzip();
            tile.paste(&frame, &mean, &mut means);
            tile.paste(&frame, &variance, &mut variances);
        }
        let mut film =
            FilmSums::from_means(frame, means, variances).with_extra(&self.job.extra_channels());
        for half in [first, second] {
            for (i, tile) in self.tiles.iter().enumerate() {
                let scale = 0.25 / f64::from(half.counts[i].max(1));
                let quarters = half.quarters.iter().map(|quarter| &quarter[i]);
                quarters.for_each(|sums| film.add_extra_means(tile, sums, scale));
            }
        }
        self.splats.add_mean_to(&mut film);
        let quarters = self.buffers.iter().flat_map(|buffer| &buffer.quarters).flatten();
        quarters.for_each(|sums| film.dropped.add(&sums.dropped));
        let count = |i| 2 * self.buffers.iter().map(|buffer| buffer.counts[i]).sum::<u32>();
        let counts = || (0..self.tiles.len()).map(count);
        let reached = Convergence {
            noise: (error / self.pixel_count()).sqrt(),
            mean_spp: self.taken() / self.lit_count().max(1.0),
            min_spp: counts().min().unwrap_or(0),
            max_spp: counts().max().unwrap_or(0),
        };
        let features = self.features();
        RenderOutput { film, features, stats, convergence: Some(reached), partial_mean_spp: None }
    }

    /// Returns the output of a render that was stopped. All samples of a pixel have equal weight.
    pub(super) fn finish_partial(self, stats: Stats) -> RenderOutput {
        let (targets, items) = self.items();
        let mut film = FilmSums::new(self.job.frame).with_extra(&self.job.extra_channels());
        let mut features = self.features();
        let mut samples = vec![0; self.tiles.len()];
        for (i, tile) in self.tiles.iter().enumerate() {
            for half in &self.buffers[..2] {
                samples[i] += 2 * half.counts[i];
                half.quarters.iter().for_each(|quarter| film.add_tile(tile, &quarter[i]));
            }
        }
        let of_picture = self.completed.iter().filter(|(i, _)| targets[*i].quarter < 4);
        for (i, result) in of_picture {
            let WorkItem { tile, samples: taken, .. } = &items[i];
            samples[targets[i].tile] += taken.len() as u32;
            film.add_tile(tile, &result.sums);
            if let (Some(all), Some(features)) = (&mut features, &result.features) {
                all.add(tile, features);
            }
        }
        partial_output(&self.tiles, &samples, (film, features), &self.splats, stats)
    }

    /// Returns the features of all tiles.
    fn features(&self) -> Option<FeatureFilm> {
        let mut features = FeatureFilm::new(&self.job.layer_request());
        for (tile, own) in self.tiles.iter().zip(&self.features) {
            if let (Some(all), Some(own)) = (&mut features, own) {
                all.add(tile, own);
            }
        }
        features
    }
}
