//! The wave: the columns of one worker, and the order of the stages that work on them.

use std::ops::Range;
use std::sync::atomic::Ordering;

use super::Progress;
use super::deferred::{DEFER_BELOW, DeferredPaths};
use super::disperse::{DisperseColumns, disperse};
use crate::aov::{Aov, TileFeatures};
use crate::film::{Tile, TileSampler, TileSums, sample};
use crate::job::Job;
use crate::shade::{PathVertex, ShadeColumns, ShadeInputs, shade};
use petzval_base::lanes::Real;
use petzval_base::rays::{Column, HitBatch, RayBatch, SampleBatch, WAVE_SIZE};
use petzval_base::stats::{BounceOccupancy, LensStats, Stage, StageClock, Stats};
use petzval_lens::{LensColumns, LensModel};
use petzval_scene::{MediumColumns, Surroundings, TraversalStack};

/// Samples that all pixels of a tile take: the unit of work of a worker.
pub(super) struct WorkItem {
    pub tile: Tile,
    /// The sample numbers.
    pub samples: Range<u32>,
    pub seed: u32,
}

impl WorkItem {
    /// Returns empty sums of its tile.
    pub fn sums(&self, job: &Job) -> TileSums {
        let squares = job.stop_criteria.count_only() && job.layers.contains(&Aov::Variance);
        TileSums::with_squares(&self.tile, squares)
    }
}

/// Light and features that a work item adds to its tile.
pub(super) struct TileResult {
    pub sums: TileSums,
    /// `None` if no layer needs them.
    pub features: Option<TileFeatures>,
}

/// The columns of one worker. Each batch is made on the stack before it moves to the heap, so it has a box
/// of its own: threads may have small stacks.
#[derive(Default)]
pub(super) struct Wave {
    pub samples: Box<SampleBatch>,
    lens: Box<LensColumns>,
    disperse: Box<DisperseColumns>,
    pub rays: Box<RayBatch>,
    pub next: Box<RayBatch>,
    shadows: Box<RayBatch>,
    pub hits: HitBatch,
    stack: TraversalStack,
    columns: Box<ShadeColumns>,
    media: Box<MediumColumns>,
    pub radiance: [Column<f32>; 3],
    deferred: DeferredPaths,
    pub stats: Stats,
}

impl Wave {
    /// Memory of a wave (bytes).
    pub const BYTES: u64 = (size_of::<Self>()
        + size_of::<SampleBatch>()
        + size_of::<LensColumns>()
        + size_of::<DisperseColumns>()
        + 3 * size_of::<RayBatch>()
        + ShadeColumns::BYTES
        + MediumColumns::BYTES) as u64;

    pub fn new(job: &Job) -> Box<Self> {
        let mut wave = Box::<Self>::default();
        if let LensModel::Real(lens) = &job.camera.model {
            wave.stats.lens = LensStats::new(lens.prescription.rows.len());
        }
        wave
    }

    /// Renders a work item, wave by wave. Returns its result, whose sums are not rounded, and the
    /// number of film samples, or `None` if the render is stopped.
    pub fn render_item<R: Real<Scalar = f32>>(
        &mut self,
        job: &Job,
        item: &WorkItem,
        progress: &Progress,
    ) -> Option<(TileResult, u64)> {
        let mut sums = item.sums(job);
        let mut features = TileFeatures::new(&job.layer_request(), &item.tile);
        let mut sampler = job.sampler(&item.tile, item.samples.clone());
        let mut clock = StageClock::start();
        let mut taken = 0;
        let mut exhausted = false;
        while !exhausted {
            exhausted = !self.start_paths::<R>(job, item, &mut sampler, &mut clock);
            if !exhausted {
                if progress.stop.load(Ordering::Relaxed) {
                    self.deferred = DeferredPaths::default();
                    return None;
                }
                let samples = self.samples.len as u64;
                if let Some(features) = features.as_mut().filter(|_| job.hides_sky()) {
                    features.launch(&self.rays, &self.samples);
                    clock.lap(&mut self.stats, Stage::Record, 0);
                }
                self.follow_paths::<R>(job, 0, features.as_mut(), &mut sums, &mut clock);
                taken += samples;
                progress.samples.fetch_add(samples, Ordering::Relaxed);
            }
            while let Some((depth, group)) = self.deferred.next(exhausted) {
                group.swap(&mut self.samples, &mut self.rays, &mut self.radiance);
                self.follow_paths::<R>(job, depth, None, &mut sums, &mut clock);
            }
        }
        clock.stop(&mut self.stats);
        Some((TileResult { sums, features }, taken))
    }

    /// Samples the film and traces the samples through the lens. Returns false if the tile has no
    /// samples left.
    pub fn start_paths<R: Real<Scalar = f32>>(
        &mut self,
        job: &Job,
        item: &WorkItem,
        sampler: &mut TileSampler,
        clock: &mut StageClock,
    ) -> bool {
        let Self { samples, lens, disperse: columns, rays, radiance, stats, .. } = self;
        let Job { camera, frame, response, timing, .. } = job;
        if !sample(sampler, frame, &response.filter, camera.film, item.seed, samples) {
            return false;
        }
        if let Some(timing) = timing {
            timing.assign_times(&item.tile, frame, samples);
        }
        clock.lap(stats, Stage::Sample, samples.len);
        camera.generate_rays::<R>(samples, lens, rays, &mut stats.lens);
        disperse::<R>(job, samples, lens, columns, rays);
        if job.lamp_image_weights().is_some_and(|weights| weights.need_camera_pdf(&job.scene)) {
            lens.write_densities(rays);
        }
        if let Some(ride) = timing.as_ref().and_then(|timing| timing.camera_motion.as_ref()) {
            ride.transform_rays(&samples.time, rays);
        }
        if job.scene.has_media() {
            rays.medium[..rays.len].fill(job.scene.camera_medium);
        }
        clock.lap(stats, Stage::Lens, samples.len);
        stats.add_camera_packets(samples.len, rays.len);
        radiance.iter_mut().for_each(|column| column[..samples.len].fill(0.0));
        true
    }

    /// Follows paths that have met `first` surfaces until they end. Defers them once they are few.
    fn follow_paths<R: Real<Scalar = f32>>(
        &mut self,
        job: &Job,
        first: u32,
        mut features: Option<&mut TileFeatures>,
        sums: &mut TileSums,
        clock: &mut StageClock,
    ) {
        let footprint = job.pixel_footprint();
        for depth in first..=job.path_limits.max_depth {
            let vertex = PathVertex { depth, limits: job.path_limits, footprint };
            self.bounce::<R>(job, vertex, features.as_deref_mut(), clock);
            if self.rays.len < DEFER_BELOW {
                self.deferred.defer(depth + 1, &mut self.samples, &mut self.rays, &self.radiance);
                break;
            }
        }
        sums.accumulate(&job.response, &self.samples, &self.radiance);
        clock.lap(&mut self.stats, Stage::Accumulate, self.samples.len);
    }

    /// Traces paths to the next surface, shades it and traces the shadow rays.
    pub fn bounce<R: Real<Scalar = f32>>(
        &mut self,
        job: &Job,
        vertex: PathVertex,
        features: Option<&mut TileFeatures>,
        clock: &mut StageClock,
    ) {
        let Self { samples, rays, next, shadows, hits, stack, columns, media, radiance, .. } = self;
        let (stats, scene) = (&mut self.stats, &job.scene);
        let surroundings = Surroundings::of(scene, samples, vertex.depth, vertex.limits.max_depth);
        let intersect = scene.intersect_all::<R>(&surroundings, rays, hits, stack);
        clock.lap(stats, Stage::Intersect, rays.len);
        if surroundings.media {
            scene.travel::<R>(&surroundings, rays, hits, radiance, media, stack);
            clock.lap(stats, Stage::Media, rays.len);
        }
        if let (0, Some(features)) = (vertex.depth, features) {
            features.record(scene, rays, hits, samples);
            clock.lap(stats, Stage::Record, rays.len);
        }
        let weights = job.lamp_image_weights();
        let lamp_weights = weights.as_ref().map(|weights| weights as _);
        let caustics = job.caustics.is_some();
        let hides_sky = job.hides_sky();
        let inputs = ShadeInputs { scene, vertex, rays, hits, lamp_weights, caustics, hides_sky };
        let shade = shade::<R>(&inputs, samples, columns, radiance, shadows, next);
        clock.lap(stats, Stage::Shade, rays.len);
        let shaded = shadows.len;
        let occlude = scene.receive::<R>(&surroundings, shadows, radiance, media, stack);
        clock.lap(stats, Stage::Occlude, shaded);
        stats.add_bounce(vertex.depth, BounceOccupancy { intersect, shade, occlude });
        std::mem::swap(rays, next);
    }
}

const _: () = assert!(WAVE_SIZE.is_multiple_of(8), "a wave is a whole number of SIMD packets");
