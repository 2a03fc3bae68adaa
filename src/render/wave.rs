//! The wave: the columns of one worker, and the way of camera paths through the stages: sample, lens,
//! advances from vertex to vertex, accumulate.

use std::ops::Range;
use std::sync::atomic::Ordering;

use super::Progress;
use super::deferred::{DEFER_BELOW, DeferredPaths};
use super::disperse::{DisperseColumns, disperse};
use crate::advance::{PathColumns, VertexStages};
use crate::aov::{Aov, TileFeatures};
use crate::film::{Tile, TileSampler, TileSums, sample};
use crate::job::Job;
use crate::shade::{PathVertex, shade};
use petzval_base::lanes::Real;
use petzval_base::rays::{SampleBatch, WAVE_SIZE};
use petzval_base::stats::{LensStats, Stage, StageClock, Stats};
use petzval_lens::{LensColumns, LensModel};
use petzval_scene::Surroundings;

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
        TileSums::with_squares(&self.tile, squares).with_extra(&job.extra_channels())
    }
}

/// Light and features that a work item adds to its tile.
pub(super) struct TileResult {
    pub sums: TileSums,
    /// `None` if no layer needs them.
    pub features: Option<TileFeatures>,
}

/// The columns of one worker.
#[derive(Default)]
pub(super) struct Wave {
    pub samples: Box<SampleBatch>,
    lens: Box<LensColumns>,
    disperse: Box<DisperseColumns>,
    pub paths: PathColumns,
    deferred: DeferredPaths,
    pub stats: Stats,
}

impl Wave {
    /// Memory of a wave (bytes).
    pub const BYTES: u64 = (size_of::<Self>()
        + size_of::<SampleBatch>()
        + size_of::<LensColumns>()
        + size_of::<DisperseColumns>()
        + PathColumns::BOXED_BYTES) as u64;

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
                    features.launch(&self.paths.rays, &self.samples);
                    clock.lap(&mut self.stats, Stage::Record, 0);
                }
                self.follow_paths::<R>(job, 0, features.as_mut(), &mut sums, &mut clock);
                taken += samples;
                progress.samples.fetch_add(samples, Ordering::Relaxed);
            }
            // Only paths of the same wavelengths continue together.
            let ends = exhausted || sampler.ends_group();
            while let Some((depth, group)) = self.deferred.next(ends) {
                let PathColumns { rays, radiance, .. } = &mut self.paths;
                group.swap(&mut self.samples, rays, radiance);
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
        let Self { samples, lens, disperse: columns, paths, stats, .. } = self;
        let Job { camera, frame, response, timing, .. } = job;
        if !sample(sampler, frame, &response.filter, camera.film, item.seed, samples) {
            return false;
        }
        if let Some(timing) = timing {
            timing.assign_times(&item.tile, frame, samples);
        }
        clock.lap(stats, Stage::Sample, samples.len);
        let rays = &mut paths.rays;
        if job.records_halves() {
            camera.find_pupil_halves::<R>(samples, lens);
        }
        camera.generate_rays::<R>(samples, lens, rays, &mut stats.lens);
        disperse::<R>(job, samples, lens, columns, rays);
        if job.lamp_image_weights().is_some_and(|weights| weights.need_camera_pdf(&job.scene)) {
            lens.write_densities(rays);
        }
        if let Some(motion) = timing.as_ref().and_then(|timing| timing.camera_motion.as_ref()) {
            motion.transform_rays(&samples.time, rays);
        }
        if job.scene.has_media() {
            rays.medium[..rays.len].fill(job.scene.camera_medium);
        }
        clock.lap(stats, Stage::Lens, samples.len);
        stats.add_camera_packets(samples.len, rays.len);
        paths.clear_radiance(samples.len);
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
            self.advance::<R>(job, vertex, features.as_deref_mut(), clock);
            let PathColumns { rays, radiance, .. } = &mut self.paths;
            if rays.len < DEFER_BELOW {
                self.deferred.defer(depth + 1, &mut self.samples, rays, radiance);
                break;
            }
        }
        sums.accumulate(&job.response, &self.samples, &self.paths.radiance);
        clock.lap(&mut self.stats, Stage::Accumulate, self.samples.len);
    }

    /// Advances the paths by one vertex.
    pub fn advance<R: Real<Scalar = f32>>(
        &mut self,
        job: &Job,
        vertex: PathVertex,
        features: Option<&mut TileFeatures>,
        clock: &mut StageClock,
    ) {
        let Self { samples, paths, stats, .. } = self;
        let mut stages = CameraPaths { job, features, clock, stats };
        paths.advance::<R>(job.scene_of(samples), samples, vertex, &mut stages);
        stats.add_bounce(vertex.depth, paths.occupancy);
    }
}

/// The stages of camera paths.
struct CameraPaths<'a> {
    job: &'a Job,
    features: Option<&'a mut TileFeatures>,
    clock: &'a mut StageClock,
    stats: &'a mut Stats,
}

impl<R: Real<Scalar = f32>> VertexStages<R> for CameraPaths<'_> {
    fn arrive(&mut self, surroundings: &Surroundings, paths: &mut PathColumns) {
        if let (0, Some(features)) = (surroundings.depth, &mut self.features) {
            let PathColumns { rays, hits, .. } = paths;
            features.record(&self.job.scene, rays, hits, surroundings.samples);
            self.clock.lap(self.stats, Stage::Record, rays.len);
        }
    }

    fn shade(&mut self, vertex: PathVertex, samples: &SampleBatch, paths: &mut PathColumns) {
        let PathColumns { rays, hits, shade: columns, radiance, shadows, next, .. } = paths;
        let weights = self.job.lamp_image_weights();
        let inputs = self.job.shade_inputs(vertex, samples, (rays, hits), weights.as_ref());
        paths.occupancy.shade = shade::<R>(&inputs, samples, columns, radiance, shadows, next);
    }

    fn connect(&mut self, surroundings: &Surroundings, paths: &mut PathColumns) {
        let scene = self.job.scene_of(surroundings.samples);
        paths.trace_shadows::<R>(scene, surroundings);
    }

    fn lap(&mut self, stage: Stage, rays: usize) {
        self.clock.lap(self.stats, stage, rays);
    }
}

const _: () = assert!(WAVE_SIZE.is_multiple_of(8), "a wave is a whole number of SIMD packets");
