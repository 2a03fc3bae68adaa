//! Adaptive sampling: rounds of samples, each where the rounds before show that they are needed.
//!
//! The samples of a pixel fall into four quarters, each with its own seed and its own mean. The first
//! two quarters are one half buffer, the others the second. The quarters of a half buffer have equal
//! counts, so the square of their difference is an unbiased estimate of the variance. The variance of
//! one half buffer decides how many samples a tile of the other takes, and when the other has enough.
//! The picture is the mean of both. So no sample influences its own weight (Rousselle, Knaus &
//! Zwicker 2012, "Adaptive rendering with non-local means filtering"). Errors are added up over the
//! pixels of a tile, as those of single pixels are poorly known.
//!
//! A half buffer that has met rare, bright light in a tile sends the other one there. It would not
//! learn how rare the light is, as the other one decides about its own count in the tile. So if one
//! half buffer is to take many samples for each that the other knows the tile by, the other takes
//! pilot samples: they have seeds of their own, inform the estimate and are no part of the picture.

mod completed_items;
mod half_buffer;
mod output;
mod sample_allocation;
mod targets;

use std::io;
use std::time::{Duration, Instant};

use super::checkpoint::SavedRender;
use super::checkpointer::RenderState;
use super::splat_accumulator::SplatAccumulator;
use super::wave::{TileResult, WorkItem};
use super::workers::Workers;
use super::{RenderError, RenderOutput};
use crate::aov::TileFeatures;
use crate::film::Tile;
use crate::job::{Job, StopCriteria};
use completed_items::CompletedItems;
use half_buffer::HalfBuffer;
use petzval_base::io::codec::{ChecksumReader, ChecksumWriter, invalid_data};
use petzval_base::lanes::Real;
use petzval_base::sampler::hash;
use sample_allocation::cost;

/// Samples per pixel of every quarter in the first round; one if the render ends by time.
const INITIAL_SAMPLES: u32 = 4;
/// Term that is added to the luminance that a pixel's error is divided by, relative to the mean.
const FLOOR: f64 = 0.1;

/// Largest number of samples in a saved state.
const MAX_COUNT: usize = 1 << 29;

/// State of an adaptive render between rounds.
struct Adaptive<'a> {
    job: &'a Job,
    /// The tiles that light reaches.
    tiles: Vec<Tile>,
    /// The number of pixels of each tile that light reaches.
    pixels: Vec<u64>,
    /// The two half buffers of the picture, followed by the pilot samples of each.
    buffers: [HalfBuffer; 4],
    features: Vec<Option<TileFeatures>>,
    /// The counts per tile at the end of this round, by buffer.
    targets: [Vec<u32>; 4],
    splats: SplatAccumulator,
    completed: CompletedItems,
    /// The start of the render, as if it had never been interrupted.
    start: Instant,
}

/// Tile and quarter of a work item.
#[derive(Clone, Copy)]
struct ItemTarget {
    tile: usize,
    /// The quarter, from 0 to 7. Those from 4 on are of pilot samples.
    quarter: usize,
}

/// Renders a job, or the rest of a resumed one, until a stop criterion is met.
pub(super) fn render<R: Real<Scalar = f32>>(
    workers: &Workers,
    resumed: Option<SavedRender>,
) -> Result<RenderOutput, RenderError> {
    let mut state = Adaptive::new(workers.job);
    if let Some(saved) = resumed {
        saved.check(workers.job)?;
        saved.body(|body| state.add_saved(body))?;
    }
    // The render may be stopped in its first round.
    workers.render_splats::<R>(&mut state, 1);
    let complete = loop {
        state.render_round::<R>(workers);
        if workers.stopped() {
            break false;
        }
        let next = state.next_targets(workers.progress);
        if next == state.targets {
            break true;
        }
        state.targets = next;
    };
    workers.write_final(&state, complete)?;
    Ok(match complete {
        true => state.finish(workers.stats()),
        false => state.finish_partial(workers.stats()),
    })
}

impl<'a> Adaptive<'a> {
    fn new(job: &'a Job) -> Self {
        let tiles = job.tiles().into_iter();
        let lit = tiles.map(|tile| (tile, job.sampler(&tile, 0..1).count()));
        let (tiles, pixels): (Vec<Tile>, Vec<u64>) = lit.filter(|(_, count)| *count > 0).unzip();
        let most = job.samples.len() as u32 / StopCriteria::MIN_SAMPLES;
        let first = if job.stop_criteria.time.is_some() { 1 } else { INITIAL_SAMPLES };
        let first = first.min(most).max(1);
        Self {
            job,
            buffers: [(); 4].map(|()| HalfBuffer::new(tiles.len())),
            features: tiles
                .iter()
                .map(|tile| TileFeatures::new(&job.layer_request(), tile))
                .collect(),
            targets: [first, first, 0, 0].map(|count| vec![count; tiles.len()]),
            tiles,
            pixels,
            splats: SplatAccumulator::new(job),
            completed: CompletedItems::default(),
            start: Instant::now(),
        }
    }

    /// Returns the number of pixels of the picture.
    fn pixel_count(&self) -> f64 {
        self.job.frame.size().map(f64::from).iter().product()
    }

    /// Returns the number of pixels that light reaches.
    fn lit_count(&self) -> f64 {
        self.pixels.iter().sum::<u64>() as f64
    }

    /// Returns the number of samples of a quarter with these counts per tile.
    fn cost(&self, counts: &[u32]) -> f64 {
        cost(&self.pixels, counts.iter().copied())
    }

    /// Returns the number of samples taken.
    fn taken(&self) -> f64 {
        2.0 * self.buffers.iter().map(|buffer| self.cost(&buffer.counts)).sum::<f64>()
    }

    /// Returns the work items of this round, and where their results belong.
    fn items(&self) -> (Vec<ItemTarget>, Vec<WorkItem>) {
        let seed = hash(self.job.seed);
        let mut items = (Vec::new(), Vec::new());
        for (i, &tile) in self.tiles.iter().enumerate() {
            for quarter in 0..8 {
                let taken = self.buffers[quarter / 2].counts[i];
                let [first, end] = [taken, self.targets[quarter / 2][i]]
                    .map(|n| self.job.samples.start.saturating_add(n));
                if first < end {
                    let seed = hash(seed ^ (quarter as u32 + 1).wrapping_mul(0x9e37_79b9));
                    items.0.push(ItemTarget { tile: i, quarter });
                    items.1.push(WorkItem { tile, samples: first..end, seed });
                }
            }
        }
        items
    }

    /// Takes samples up to the targets of this round, and the splats of as many sample numbers as
    /// pixels have samples in the mean.
    fn render_round<R: Real<Scalar = f32>>(&mut self, workers: &Workers) {
        let (targets, items) = self.items();
        self.completed.resize(items.len());
        workers.render_items::<R>(&items, self);
        let Some(results) = self.completed.take_all() else { return };
        for (buffer, counts) in self.buffers.iter_mut().zip(&self.targets) {
            buffer.set_counts(self.job, &self.tiles, counts);
        }
        for (ItemTarget { tile, quarter }, TileResult { sums, features }) in
            targets.into_iter().zip(results)
        {
            self.buffers[quarter / 2].quarters[quarter % 2][tile].add(&sums);
            if let (Some(all), Some(features)) = (&mut self.features[tile], features) {
                all.add(&features);
            }
        }
        let mean = (self.taken() / self.lit_count().max(1.0)) as u32;
        workers.render_splats::<R>(self, mean);
    }
}

impl RenderState for Adaptive<'_> {
    fn is_done(&self, item: usize) -> bool {
        self.completed.contains(item)
    }

    fn add_result(&self, item: usize, result: TileResult) {
        self.completed.insert(item, result);
    }

    fn splats(&mut self) -> &mut SplatAccumulator {
        &mut self.splats
    }

    fn save(&self, to: &mut ChecksumWriter) -> io::Result<()> {
        to.u64(self.start.elapsed().as_nanos() as u64)?;
        let counts = self.buffers.iter().map(|buffer| &buffer.counts).chain(&self.targets);
        counts.flatten().try_for_each(|&count| to.u32(count))?;
        let quarters = self.buffers.iter().flat_map(|buffer| &buffer.quarters).flatten();
        quarters.into_iter().try_for_each(|sums| sums.save(to))?;
        self.features.iter().flatten().try_for_each(|features| features.save(to))?;
        self.splats.save(to)?;
        self.completed.save(to)
    }

    fn add_saved(&mut self, from: &mut ChecksumReader) -> io::Result<()> {
        let earlier = Duration::from_nanos(from.u64()?);
        self.start = self.start.checked_sub(earlier).unwrap_or(self.start);
        let mut count = || from.below(MAX_COUNT, "samples").map(|count| count as u32);
        for buffer in &mut self.buffers {
            let counts = buffer.counts.iter().map(|_| count()).collect::<io::Result<Vec<u32>>>()?;
            buffer.set_counts(self.job, &self.tiles, &counts);
        }
        for target in self.targets.iter_mut().flatten() {
            *target = count()?;
        }
        if !self.targets_are_plausible() {
            return Err(invalid_data(
                "it is damaged: its counts of samples are none of this render",
            ));
        }
        let quarters = self.buffers.iter_mut().flat_map(|buffer| &mut buffer.quarters).flatten();
        quarters.into_iter().try_for_each(|sums| sums.receive(from))?;
        self.features.iter_mut().flatten().try_for_each(|features| features.receive(from))?;
        self.splats.add_saved(from)?;
        let (_, items) = self.items();
        self.completed.load(from, self.job, &items)
    }
}
