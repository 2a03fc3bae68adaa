//! Estimate of the memory that a job takes, made before it is rendered.
//!
//! A render that the system kills for lack of memory after an hour has cost an hour. The estimate is
//! made once scene and lens are loaded: those count by what the process holds then, the rest by the
//! sizes of later allocations, phase by phase. It is meant as an upper bound. [`machine`] tells what the
//! machine has, and [`ReadContext`](petzval_base::io::ReadContext) refuses a scene that declares too much while
//! it is read.

pub use petzval_base::io::machine;
use petzval_base::io::machine::ResidentMemory;

use std::fmt;

use super::deferred::PathGroup;
use super::wave::Wave;
use crate::aov;
use crate::aov::{Aov, FeatureFilm};
use crate::diffraction::Diffraction;
use crate::film::FilmSums;
use crate::job::Job;
use crate::light_tracing::SplatStage;
use crate::plan::Effect;
use petzval_base::io::ByteSize;
use petzval_image::ImageFormat;
use petzval_lens::LensModel;

/// Task that takes memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MemoryTask {
    /// Renders a job.
    Render {
        /// The number of threads, at least 1.
        threads: usize,
    },
    /// Adds up the parts of a job.
    Merge,
}

/// Memory of the phase that takes the most.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Estimate {
    /// The name and the size (bytes) of each part.
    pub parts: Vec<(&'static str, u64)>,
}

/// Size of a pixel of a picture (bytes).
const PICTURE_BYTES: u64 = 12;
/// Size of a pixel while a file for display is written: its encoded values, and its share of the file, with 8
/// bits in a channel and with 16 (bytes).
const ENCODED_BYTES: [u64; 2] = [7, 16];
/// Allocator overhead: a constant (bytes), and the reciprocal of its share of all memory.
const SLACK: u64 = 8 << 20;
const SLACK_SHARE: u64 = 16;
/// Lines of a block of an EXR.
const BLOCK_LINES: u64 = 16;
/// Copies of a block while it is written: raw, compressed, and waiting for the blocks before it.
const BLOCK_COPIES: u64 = 3;

impl Estimate {
    /// Estimates the memory of a job in a process with this [resident memory](machine::resident) once the
    /// scene is loaded. Without a format, only sums are written.
    pub fn new(
        job: &Job,
        resident: ResidentMemory,
        task: MemoryTask,
        format: Option<ImageFormat>,
    ) -> Self {
        let pixels = job.frame.size().map(u64::from).iter().product::<u64>();
        let threads = match task {
            MemoryTask::Render { threads } => threads as u64,
            MemoryTask::Merge => 0,
        };
        let squares = job.stop_criteria.count_only() && job.layers.contains(&Aov::Variance);
        let extra = job.extra_channels();
        let (buckets, sums) = (extra.bucket_count() as u64, extra_bytes(job));
        let film = pixels * (FilmSums::bytes_per_pixel(squares) + sums);
        let features = pixels * FeatureFilm::bytes(&job.layer_request());
        let splats = match &job.camera.model {
            LensModel::Real(lens) if !job.light_strategies().is_empty() => {
                let stage = SplatStage::bytes(&job.response.filter, lens, threads);
                pixels * (FilmSums::bytes_per_pixel(false) + sums) + stage
            }
            _ => 0,
        };
        let rounds = match job.stop_criteria.count_only() {
            true => 0,
            false => pixels * round_bytes(job),
        };
        let spectral = job.spectral.as_ref().map_or(0, |scene| scene.bytes());
        let always = [
            ("scene, lens and program", resident.now),
            ("scenes by wavelength", spectral),
            ("threads", threads * thread_bytes(job)),
            ("tile results", rounds),
        ];
        let mut phases =
            vec![vec![("film", film), ("features", features), ("light paths", splats)]];
        if let Some(format) = format {
            let layers = match format {
                ImageFormat::Exr => {
                    4 * pixels * (aov::channels(&job.layer_request()) as u64 + buckets)
                }
                ImageFormat::Npy => 4 * pixels * buckets,
                ImageFormat::Png | ImageFormat::Tiff if job.hides_sky() => 4 * pixels,
                _ => 0,
            };
            let [layers, picture] = [("layers", layers), ("picture", PICTURE_BYTES * pixels)];
            // Variance is computed for all channels at once.
            let variance = if squares { PICTURE_BYTES * pixels } else { 0 };
            // The light of one half of the pupil; both halves are read out, and become layers.
            let halves = if extra.left_half { PICTURE_BYTES * pixels } else { 0 };
            let developed = [("film", film), ("features", features), ("variance", variance)];
            let left_half = ("half of the pupil", halves);
            phases.push(developed.into_iter().chain([layers, left_half]).collect());
            if job.plan.has(Effect::Diffraction) {
                let spread = Diffraction::bytes(job.frame.size().map(|n| n as usize));
                let halves = ("halves of the pupil", 2 * halves);
                phases.push(vec![picture, layers, halves, ("diffraction", spread)]);
            }
            let writer = match format {
                ImageFormat::Exr => {
                    let line =
                        u64::from(job.frame.size()[0]) * (PICTURE_BYTES + layers.1 / pixels.max(1));
                    BLOCK_LINES * BLOCK_COPIES * line * (machine::cores() as u64 + 2)
                }
                ImageFormat::Npy => 0,
                ImageFormat::Dng => 2 * pixels,
                ImageFormat::Jpeg => ENCODED_BYTES[0] * pixels,
                // A PNG may have either.
                _ => ENCODED_BYTES[1] * pixels,
            };
            let spreads = job.sensor.is_some_and(|sensor| !sensor.crosstalk.is_none());
            let crosstalk = if spreads { PICTURE_BYTES * pixels + halves } else { 0 };
            let readout = [("halves of the pupil", 3 * halves), ("crosstalk", crosstalk)];
            phases.push([picture, layers].into_iter().chain(readout).collect());
            phases.push(vec![picture, layers, ("writing", writer)]);
        }
        let sum = |parts: &[(_, u64)]| parts.iter().map(|(_, bytes)| bytes).sum::<u64>();
        let largest = phases.into_iter().max_by_key(|parts| sum(parts)).unwrap_or_default();
        let mut parts: Vec<_> = always.into_iter().chain(largest).collect();
        if sum(&parts) < resident.peak {
            parts = vec![("reading the scene", resident.peak)];
        }
        parts.push(("allocator overhead", SLACK + sum(&parts) / SLACK_SHARE));
        parts.retain(|(_, bytes)| *bytes > 0);
        Self { parts }
    }

    /// Returns the estimate with another part added.
    #[must_use]
    pub fn with_extra(mut self, name: &'static str, bytes: u64) -> Self {
        self.parts.push((name, bytes));
        self
    }

    /// Returns the memory of all parts (bytes).
    pub fn bytes(&self) -> u64 {
        self.parts.iter().map(|(_, bytes)| bytes).sum()
    }
}

impl fmt::Display for Estimate {
    /// "about 2.1 GB of memory (film 1.5 GB, ...)"
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let parts: Vec<String> =
            self.parts.iter().map(|(name, bytes)| format!("{name} {}", ByteSize(*bytes))).collect();
        write!(f, "about {} of memory ({})", ByteSize(self.bytes()), parts.join(", "))
    }
}

/// Memory of a thread besides its columns: its stack, its heap and a tile (bytes).
const THREAD_BYTES: u64 = 1 << 18;
/// Memory of the samples of a tile that wait for a wave of their wavelengths (bytes).
const QUEUE_BYTES: u64 = 4 << 20;
/// Largest number of depths with deferred paths in a thread. No known scene has more.
const MAX_DEFERRED_DEPTHS: u64 = 100;

/// Returns the size of the sums of the extra channels of a pixel (bytes).
fn extra_bytes(job: &Job) -> u64 {
    (job.extra_channels().count() * size_of::<f64>()) as u64
}

/// Returns the approximate memory of a thread: its wave, its deferred paths, and the sums of a tile in extra
/// channels with their errors (bytes).
fn thread_bytes(job: &Job) -> u64 {
    let depths = u64::from(job.path_limits.max_depth).min(MAX_DEFERRED_DEPTHS) + 1;
    let queues = if job.spectral.is_some() { QUEUE_BYTES } else { 0 };
    let tile = job.tiles().first().map_or(0, |tile| u64::from(tile.size[0] * tile.size[1]));
    let sums = 2 * extra_bytes(job) * tile;
    queues + sums + Wave::BYTES + THREAD_BYTES + depths * size_of::<PathGroup>() as u64
}

/// Returns the largest memory of a pixel in adaptive rounds: its four quarters, and the results of a
/// round, with features (bytes).
fn round_bytes(job: &Job) -> u64 {
    let sums = FilmSums::bytes_per_pixel(false) + extra_bytes(job);
    4 * sums + 4 * (sums + FeatureFilm::bytes(&job.layer_request()))
}
