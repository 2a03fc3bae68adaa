//! Splat stage: traces waves of light paths by all strategies, and adds their light to the film.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use rayon::prelude::*;

use super::caustics::{CausticColumns, Caustics};
use super::ghosts::Ghosts;
use super::lamp_images::{LampColumns, LampImages};
use super::light_paths::{FrontEntry, LightPathInput, LightPaths};
use super::ordered_film::OrderedFilm;
use crate::film::{FilmSums, Frame, Splat};
use petzval_base::lanes::Real;
use petzval_base::rays::{ColumnPool, WAVE_SIZE};
use petzval_base::stats::{Stage, Stats, thread_time};
use petzval_lens::{LensModel, RealLens};
use petzval_scene::filter::PixelFilter;

/// A kind of light paths, for light that camera paths hardly ever find.
#[derive(Clone, Copy, Debug)]
pub enum Strategy<'a> {
    /// Paths from a lamp or a sky straight to the lens, weighed against camera paths.
    LampImages(&'a LampImages),
    /// Paths from a lamp by mirrors or clear glass to a surface that is connected to the lens. Their
    /// weight is 1, as camera paths leave them out.
    Caustics(&'a Caustics),
    /// Paths from a light by two reflections inside the lens. Their weight is 1, as there are no such
    /// camera paths.
    Ghosts(&'a Ghosts),
}

/// Columns of one worker, made when a strategy first needs them.
#[derive(Default)]
struct StrategyColumns {
    lamps: Option<LampColumns>,
    caustics: Option<CausticColumns>,
    ghosts: Option<Box<LightPaths>>,
}

impl Strategy<'_> {
    /// Returns the number of waves of a sample number: none in a crop that no light can reach.
    fn waves(self, frame: &Frame) -> u32 {
        match self {
            Self::LampImages(lamps) if !lamps.reaches_pixels() => 0,
            Self::LampImages(lamps) => lamps.path_count(frame).waves,
            Self::Caustics(caustics) => caustics.path_count(frame).waves,
            Self::Ghosts(ghosts) => ghosts.path_count(frame).waves,
        }
    }

    /// Traces a wave of a sample number, given as `[wave, sample]`, and returns its splats. They depend
    /// on these numbers and the seed only.
    fn trace<R: Real<Scalar = f32>>(
        self,
        input: &LightPathInput<'_>,
        lens: &RealLens,
        columns: &mut StrategyColumns,
        wave: [u32; 2],
    ) -> Vec<Splat> {
        let StrategyColumns { lamps, caustics, ghosts } = columns;
        match self {
            Self::LampImages(of) => of.trace::<R>(input, lens, lamps.get_or_insert_default(), wave),
            Self::Caustics(of) => {
                of.trace::<R>(input, lens, caustics.get_or_insert_default(), wave)
            }
            Self::Ghosts(of) => of.trace::<R>(input, lens, ghosts.get_or_insert_default(), wave),
        }
    }
}

/// Number of splats that wait to be added to the film, for each thread, from which on no further wave
/// begins: 1.6 MB.
const WAITING_PER_THREAD: usize = 1 << 16;

/// The stage after all others. It keeps the columns of its workers from call to call.
pub struct SplatStage {
    columns: ColumnPool<StrategyColumns>,
    waiting_per_thread: usize,
}

impl Default for SplatStage {
    fn default() -> Self {
        Self { columns: ColumnPool::default(), waiting_per_thread: WAITING_PER_THREAD }
    }
}

impl SplatStage {
    /// Traces the light paths of these sample numbers by some strategies and adds their light to the
    /// film. `goes_on` is asked before each sample number but the first. Returns how many of them were
    /// added, each as a whole.
    ///
    /// Workers take waves in the order of the sample numbers, of the strategies and of the numbers of
    /// the waves, and each pixel receives their light in this order. So the sum depends on seed and sample
    /// numbers only, and the sums of disjoint ranges add up.
    pub fn run<R: Real<Scalar = f32>>(
        &self,
        input: &LightPathInput<'_>,
        strategies: &[Strategy<'_>],
        samples: Range<u32>,
        goes_on: &(dyn Fn() -> bool + Sync),
        film: &mut FilmSums,
        stats: &mut Stats,
    ) -> u32 {
        let LensModel::Real(lens) = &input.camera.model else { return samples.len() as u32 };
        let waves: Vec<(Strategy<'_>, u32)> = strategies
            .iter()
            .flat_map(|of| (0..of.waves(input.frame)).map(move |wave| (*of, wave)))
            .collect();
        if waves.is_empty() {
            return samples.len() as u32;
        }
        let per_sample = waves.len() as u64;
        let end = samples.len() as u64 * per_sample;
        let most_waiting = self.waiting_per_thread * rayon::current_num_threads();
        let sums = OrderedFilm::new(film, input.frame, input.response, most_waiting);
        let nanoseconds = AtomicU64::new(0);
        let begins = |i: &u64| *i == 0 || !i.is_multiple_of(per_sample) || goes_on();
        let mut next = 0;
        while next < end && begins(&next) {
            // All waves are added once this ends, so that the next ones find room.
            let numbers = (next..end).take_while(|i| begins(i) && sums.has_room());
            numbers.par_bridge().for_each(|i| {
                let (strategy, wave) = waves[(i % per_sample) as usize];
                let sample = samples.start + (i / per_sample) as u32;
                timed(&nanoseconds, || {
                    let splats = match input.is_stopped() {
                        true => Vec::new(),
                        false => self.columns.lend(Box::default, |columns| {
                            strategy.trace::<R>(input, lens, columns, [wave, sample])
                        }),
                    };
                    sums.add(i, splats);
                });
            });
            next = timed(&nanoseconds, || sums.finish());
        }
        let stats = &mut stats.stages[Stage::LightPaths as usize];
        stats.time += Duration::from_nanos(nanoseconds.into_inner());
        stats.rays += next * WAVE_SIZE as u64;
        (next / per_sample) as u32
    }

    /// Returns the largest memory of the stage (bytes): the columns and the splats of a wave for each
    /// thread, and the splats that wait.
    pub fn bytes(filter: &PixelFilter, lens: &RealLens, threads: u64) -> u64 {
        let columns = (2 * size_of::<LightPaths>() + Caustics::COLUMN_BYTES) as u64;
        let [width, height] = filter.margin().map(|margin| (2.0 * margin).ceil() as u64 + 2);
        let of_path = width * height * FrontEntry::bands_per_path(lens);
        // Those of a wave twice, while they are sorted.
        let splats = WAITING_PER_THREAD as u64 + 2 * of_path * WAVE_SIZE as u64;
        threads * (columns + splats * size_of::<Splat>() as u64)
    }
}

/// Adds the thread's time of some work to a sum (ns).
fn timed<T>(nanoseconds: &AtomicU64, work: impl FnOnce() -> T) -> T {
    let start = thread_time();
    let result = work();
    let time = thread_time().saturating_sub(start);
    nanoseconds.fetch_add(time.as_nanos() as u64, Ordering::Relaxed);
    result
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::atomic::{AtomicU32, Ordering};

    use super::*;
    use crate::prepare::{Changes, prepare};
    use petzval_base::lanes::f32x8;
    use petzval_scene_formats::pbrt;

    #[test]
    fn a_stage_that_ends_early_has_added_whole_sample_numbers_and_can_go_on() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/night.pbrt");
        let changes = Changes {
            effects: "+ghosts,-diffraction,-dispersion".parse().expect("effects"),
            light_paths: Some(true),
            resolution: Some([60, 40]),
            ..Changes::default()
        };
        let job = prepare(pbrt::read(&path).expect("a scene"), &changes).expect("a job").job;
        let strategies = job.light_strategies();
        assert!(strategies.len() > 1, "{strategies:?}");
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("threads");
        let (stage, asked) = (SplatStage::default(), AtomicU32::new(0));
        let run = |stage: &SplatStage,
                   samples: Range<u32>,
                   goes_on: &(dyn Fn() -> bool + Sync),
                   film: &mut FilmSums| {
            let (input, stats) = (job.light_path_input(), &mut Stats::default());
            pool.install(|| stage.run::<f32x8>(&input, &strategies, samples, goes_on, film, stats))
        };
        let [mut whole, mut part, mut crowded] = [(); 3].map(|()| FilmSums::new(job.frame));
        assert_eq!(run(&stage, 7..12, &|| true, &mut whole), 5);
        let once = || asked.fetch_add(1, Ordering::Relaxed) < 1;
        assert_eq!(run(&stage, 7..12, &once, &mut part), 2);
        assert_ne!(part.picture(1).pixels, whole.picture(1).pixels);
        assert_eq!(run(&stage, 9..12, &|| true, &mut part), 3);
        assert_eq!(part.picture(1).pixels, whole.picture(1).pixels);
        // Each wave fills the room.
        let small = SplatStage { waiting_per_thread: 1, ..SplatStage::default() };
        assert_eq!(run(&small, 7..12, &|| true, &mut crowded), 5);
        assert_eq!(crowded.picture(1).pixels, whole.picture(1).pixels);
    }
}
