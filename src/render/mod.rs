//! The wavefront: the only module that knows the order of the stages.

mod bytes;
mod crew;
mod disperse;
mod even;
mod gathered;
mod haunt;
mod keeper;
mod ledger;
mod pair;
mod partial;
mod replay;
mod rounds;
mod spread;
mod tails;
mod until;

use std::ops::Range;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use crate::aov::{Aov, FeatureFilm, Features};
use crate::checkpoint::{CheckpointError, Saved};
use crate::diffraction::Diffraction;
use crate::film::{FilmSums, Frame, Response, Tile, TileSampler, TileSums, sample};
use crate::ghosts::Ghosts;
use crate::image::Picture;
use crate::lanes::{Real, f32x8};
use crate::lens::{Camera, LensColumns, Model};
use crate::plan::{EFFECTS, Effect, Plan};
use crate::rays::{Column, HitBatch, RayBatch, SampleBatch, WAVE};
use crate::scene::{Scene, TraversalStack};
use crate::sensor::Sensor;
use crate::shade::{Beam, Reach, ShadeColumns, Vertex, shade};
use crate::shutter::Timing;
use crate::source::Files;
use crate::spectrum::{BANDS, LightBand};
use crate::stats::{BounceLanes, Clock, Stage, Stats};
use crew::Crew;
use keeper::Received;
use tails::{FEW, Tails};

pub use bytes::{bytes_of_round, bytes_of_thread};
pub use disperse::{DisperseColumns, disperse};
pub use keeper::Keeper;
pub use replay::{Place, Replay, Shadow, Shared, Step, replay};
pub use until::{Reached, Until};

/// Everything that decides what a picture looks like.
#[derive(Clone, Debug)]
pub struct Job {
    /// What is seen.
    pub scene: Scene,
    /// Through what it is seen.
    pub camera: Camera,
    /// Which effects are simulated, and why.
    pub plan: Plan,
    /// The pixels.
    pub frame: Frame,
    /// How samples become pixels.
    pub film: Response,
    /// Which samples of every pixel; where something else ends the render, at most so many in the
    /// mean.
    pub samples: Range<u32>,
    /// What else ends the render.
    pub until: Until,
    /// Which of all random choices.
    pub seed: u32,
    /// How far paths go: over 1 surface is direct light only, over 0 what shines by itself.
    pub reach: Reach,
    /// What is wanted beside the colours.
    pub layers: Vec<Aov>,
    /// The light that the film sees, in bands.
    pub light: [LightBand; BANDS],
    /// The ghosts in the lens, where they are simulated.
    pub ghosts: Option<Ghosts>,
    /// What reads the finished picture out; without one it stays as the film has it.
    pub sensor: Option<Sensor>,
    /// When samples are taken, where it matters.
    pub timing: Option<Timing>,
    /// What scene and lens were read from.
    pub files: Files,
}

impl Job {
    /// What a pixel sees.
    pub fn beam(&self) -> Beam {
        Beam::new(&self.camera, self.frame.resolution)
    }

    /// Samples of a tile, but for pixels that no light can come to.
    pub fn sampler(&self, tile: &Tile, samples: Range<u32>) -> TileSampler {
        let reach = self.film.filter.reach();
        TileSampler::new(tile, samples, self.camera.bands(), |low, high| {
            let low = [0, 1].map(|i| f64::from(low[i]) - reach[i]);
            let high = [0, 1].map(|i| f64::from(high[i]) + reach[i]);
            self.camera.sees(low, high, self.frame.resolution)
        })
    }
}

/// One lane or eight; the picture is the same bit for bit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Backend {
    /// Eight lanes.
    #[default]
    Simd,
    /// One lane.
    Scalar,
}

/// How far a render has come; shared with whoever watches it or stops it.
#[derive(Debug, Default)]
pub struct Progress {
    /// Film samples taken.
    pub samples: AtomicU64,
    /// Film samples that it will take in all, as far as is known by now; 0 where the count of the
    /// job's samples says it.
    pub expected: AtomicU64,
    /// Set to stop the workers at their next wave.
    pub stop: AtomicBool,
}

/// A finished render.
#[derive(Clone, Debug)]
pub struct Exposed {
    /// What the film received.
    pub film: FilmSums,
    /// What its first surfaces are like, where a layer asks for it.
    pub features: Option<FeatureFilm>,
    /// How that came about.
    pub stats: Stats,
    /// How good it became, where more than the count of samples could end it.
    pub reached: Option<Reached>,
    /// Of a render that was stopped: the mean of the samples that its pixels took.
    pub partial: Option<f64>,
}

impl Exposed {
    /// The picture of this job: what the film received, spread by diffraction where that is planned,
    /// and read out by the sensor where there is one. Layers are of the film.
    pub fn picture(&self, job: &Job) -> Picture {
        develop(self.film.picture(job.samples.end - job.samples.start), job)
    }

    /// [`Exposed::picture`] of a film that is not needed any more, which takes less memory.
    pub fn into_picture(self, job: &Job) -> Picture {
        let Self { film, features, .. } = self;
        drop(features);
        develop(film.into_picture(job.samples.end - job.samples.start), job)
    }
}

/// What becomes of a picture behind the film.
fn develop(mut picture: Picture, job: &Job) -> Picture {
    if job.plan.has(Effect::Diffraction) {
        picture = Diffraction::new(&job.camera, &job.frame, &job.light).spread(&picture);
    }
    match &job.sensor {
        Some(sensor) => sensor.read_out(&picture, job.frame.low, job.seed),
        None => picture,
    }
}

/// Why a render ended without a picture.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// [`Progress::stop`] was set.
    #[error("stopped before the picture was complete")]
    Stopped,
    /// The threads could not be started.
    #[error("cannot start the render threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// What it has come to could not be written down, or gone on from.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
}

/// Renders a picture on this many threads; 0 means one per core.
///
/// The picture depends on the job alone: not on threads, backend or the order of work.
///
/// # Errors
/// Where it was told to stop, or threads could not be had.
pub fn render(
    job: &Job,
    backend: Backend,
    threads: usize,
    progress: &Progress,
) -> Result<Exposed, RenderError> {
    let exposed = render_kept(job, backend, threads, progress, None, None)?;
    match exposed.partial {
        None => Ok(exposed),
        Some(_) => Err(RenderError::Stopped),
    }
}

/// [`render`] that writes down what it has come to, or goes on from there. Where it is told to stop
/// it does so once more, and answers with what there is.
///
/// The picture is the same bit for bit whether the render was interrupted or not, but for one that
/// ends by time.
///
/// # Errors
/// Where threads could not be had, what it is to go on from is not of this job, or the last thing
/// to write down cannot be written.
pub fn render_kept(
    job: &Job,
    backend: Backend,
    threads: usize,
    progress: &Progress,
    keeper: Option<&Keeper>,
    from: Option<Saved>,
) -> Result<Exposed, RenderError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    pool.install(|| {
        let crew = Crew::new(job, progress, keeper, from.as_ref().map(|saved| &saved.head));
        match backend {
            Backend::Simd => expose::<f32x8>(&crew, from),
            Backend::Scalar => expose::<f32>(&crew, from),
        }
    })
}

fn expose<R: Real<Scalar = f32>>(crew: &Crew, from: Option<Saved>) -> Result<Exposed, RenderError> {
    match crew.job.until.count_only() {
        true => even::expose::<R>(crew, from),
        false => rounds::expose::<R>(crew, from),
    }
}

/// Adds up the parts of a picture that were rendered apart: their samples, one after another, are
/// all of the job's.
///
/// # Errors
/// Where a part cannot be read, or is not of this job.
pub fn merge(job: &Job, parts: &[PathBuf]) -> Result<Exposed, CheckpointError> {
    even::merge(job, parts.iter().map(|path| Saved::open(path)))
}

/// Samples that all pixels of a tile take.
struct Share {
    tile: Tile,
    samples: Range<u32>,
    seed: u32,
}

impl Share {
    /// Sums of its tile that have received nothing.
    fn sums(&self, job: &Job) -> TileSums {
        let squares = job.until.count_only() && job.layers.contains(&Aov::Variance);
        TileSums::new(&self.tile, squares)
    }
}

/// The columns of one worker.
#[derive(Default)]
struct Wave {
    samples: SampleBatch,
    lens: LensColumns,
    disperse: DisperseColumns,
    rays: RayBatch,
    next: RayBatch,
    shadows: RayBatch,
    hits: HitBatch,
    stack: TraversalStack,
    columns: ShadeColumns,
    radiance: [Column<f32>; 3],
    tails: Tails,
    stats: Stats,
}

impl Wave {
    fn new(job: &Job) -> Box<Self> {
        let mut wave = Box::<Self>::default();
        if let Model::Real(lens) = &job.camera.model {
            wave.stats.lens.blocked = vec![0; lens.prescription.rows.len()];
        }
        wave
    }

    /// Samples of one tile, wave by wave, and how many they are; nothing where it is told to stop.
    fn expose_tile<R: Real<Scalar = f32>>(
        &mut self,
        job: &Job,
        share: &Share,
        progress: &Progress,
    ) -> Option<(Received, u64)> {
        let tile = &share.tile;
        let mut sums = share.sums(job);
        let mut features = Features::new(job, tile);
        let mut sampler = job.sampler(tile, share.samples.clone());
        let mut clock = Clock::start();
        let mut taken = 0;
        while self.begin::<R>(job, share, &mut sampler, &mut clock) {
            if progress.stop.load(Ordering::Relaxed) {
                self.tails = Tails::default();
                return None;
            }
            let samples = self.samples.len as u64;
            self.follow::<R>(job, 0, features.as_mut(), &mut sums, &mut clock);
            while let Some((depth, tail)) = self.tails.next(false) {
                tail.swap(&mut self.samples, &mut self.rays, &mut self.radiance);
                self.follow::<R>(job, depth, None, &mut sums, &mut clock);
            }
            taken += samples;
            progress.samples.fetch_add(samples, Ordering::Relaxed);
        }
        while let Some((depth, tail)) = self.tails.next(true) {
            tail.swap(&mut self.samples, &mut self.rays, &mut self.radiance);
            self.follow::<R>(job, depth, None, &mut sums, &mut clock);
        }
        clock.stop(&mut self.stats);
        Some(((sums, features), taken))
    }

    /// The rays of the next samples of a tile; false where there are none.
    fn begin<R: Real<Scalar = f32>>(
        &mut self,
        job: &Job,
        share: &Share,
        sampler: &mut TileSampler,
        clock: &mut Clock,
    ) -> bool {
        let Self { samples, lens, disperse: columns, rays, radiance, stats, .. } = self;
        let Job { camera, frame, film, timing, .. } = job;
        if !sample(sampler, frame, &film.filter, camera.film, share.seed, samples) {
            return false;
        }
        let timing = timing.as_ref().filter(|_| EFFECTS);
        if let Some(timing) = timing {
            timing.tell(&share.tile, frame, samples);
        }
        clock.lap(stats, Stage::Sample, samples.len);
        camera.expose::<R>(samples, lens, rays, &mut stats.lens);
        if EFFECTS {
            disperse::<R>(job, samples, lens, columns, rays);
        }
        if let Some(ride) = timing.and_then(|timing| timing.ride.as_ref()) {
            ride.carry(&samples.time, rays);
        }
        clock.lap(stats, Stage::Lens, samples.len);
        stats.aim(samples.len, rays.len);
        radiance.iter_mut().for_each(|column| column[..samples.len].fill(0.0));
        true
    }

    /// Follows the paths of a wave that have met `first` surfaces, until they end or are few.
    fn follow<R: Real<Scalar = f32>>(
        &mut self,
        job: &Job,
        first: u32,
        mut features: Option<&mut Features>,
        sums: &mut TileSums,
        clock: &mut Clock,
    ) {
        let beam = job.beam();
        for depth in first..=job.reach.max_depth {
            let vertex = Vertex { depth, reach: job.reach, beam };
            self.bounce::<R>(job, vertex, features.as_deref_mut(), clock);
            if self.rays.len < FEW {
                self.tails.defer(depth + 1, &mut self.samples, &mut self.rays, &self.radiance);
                break;
            }
        }
        sums.accumulate(&job.film, &self.samples, &self.radiance);
        clock.lap(&mut self.stats, Stage::Accumulate, self.samples.len);
    }

    /// Takes paths to the surfaces that they meet next, and turns them there.
    fn bounce<R: Real<Scalar = f32>>(
        &mut self,
        job: &Job,
        vertex: Vertex,
        features: Option<&mut Features>,
        clock: &mut Clock,
    ) {
        let Self { samples, rays, next, shadows, hits, stack, columns, radiance, .. } = self;
        let (stats, scene) = (&mut self.stats, &job.scene);
        let moves = EFFECTS && !scene.movers().is_empty();
        let intersect = scene.intersect::<R>(rays, hits, stack);
        if moves {
            scene.intersect_moving::<R>(rays, &samples.time, hits, stack);
        }
        clock.lap(stats, Stage::Intersect, rays.len);
        if let (0, Some(features)) = (vertex.depth, features) {
            features.record(scene, rays, hits, samples);
            clock.lap(stats, Stage::Record, rays.len);
        }
        let shade =
            shade::<R>(scene, vertex, rays, hits, samples, columns, radiance, shadows, next);
        clock.lap(stats, Stage::Shade, rays.len);
        let shaded = shadows.len;
        if moves {
            scene.occlude_moving::<R>(shadows, &samples.time, stack);
        }
        let occlude = scene.occlude::<R>(shadows, stack, radiance);
        clock.lap(stats, Stage::Occlude, shaded);
        stats.bounce(vertex.depth, BounceLanes { intersect, shade, occlude });
        std::mem::swap(rays, next);
    }
}

const _: () = assert!(WAVE.is_multiple_of(8), "waves are whole packets");
