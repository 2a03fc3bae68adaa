//! How much memory a picture takes, known before it is rendered.
//!
//! A render that the system ends after an hour for want of memory has cost an hour. So what it will
//! take is estimated when scene and lens are there: those by what the process holds then, the
//! rest by the sizes of what will be allocated, phase by phase. The estimate is meant as a bound, not
//! as a mean; [`machine`] says what the machine has, and [`budget`] refuses a scene that
//! declares too much while it is read.

pub mod budget;
pub mod machine;
mod size;

pub use size::Size;

use std::fmt;

use crate::aov::{self, Aov, FeatureFilm};
use crate::diffraction::Diffraction;
use crate::film::FilmSums;
use crate::ghosts::Ghosts;
use crate::image::Format;
use crate::plan::Effect;
use crate::render::{self, Job};

/// What is to be done with a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Work {
    /// To render it on so many threads.
    Render {
        /// 1 or more.
        threads: usize,
    },
    /// To add up parts of it.
    Merge,
}

/// The memory of the phase that takes most, by what takes it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Estimate {
    /// Bytes.
    pub parts: Vec<(&'static str, u64)>,
}

/// Bytes of a pixel of a picture.
const PICTURE: u64 = 12;
/// Bytes of a pixel that a PNG or JPEG is made of: its codes, and the file before it is written.
const CODES: u64 = 7;
/// Bytes that the heap cannot use, and what share of all.
const SLACK: u64 = 8 << 20;
const SLACK_SHARE: u64 = 16;
/// Lines that an EXR packs together, and how many times a pack of them is there: as it is, packed,
/// and waiting for those before it.
const PACK: [u64; 2] = [16, 3];

impl Estimate {
    /// Of a job, in a process that [holds](machine::held) so many bytes by now, and has held so many
    /// at most. Without a format only sums are written.
    pub fn new(job: &Job, [now, most]: [u64; 2], work: Work, format: Option<Format>) -> Self {
        let pixels = job.frame.size().map(u64::from).iter().product::<u64>();
        let threads = match work {
            Work::Render { threads } => threads as u64 * render::bytes_of_thread(job),
            Work::Merge => 0,
        };
        let squares = job.until.count_only() && job.layers.contains(&Aov::Variance);
        let film = pixels * FilmSums::bytes(squares);
        let features = pixels * FeatureFilm::bytes(job);
        let ghosts = job.ghosts.as_ref().map_or(0, |_| {
            pixels * FilmSums::bytes(false) + Ghosts::bytes_waiting(job.frame.resolution)
        });
        let rounds = match job.until.count_only() {
            true => 0,
            false => pixels * render::bytes_of_round(job),
        };
        let always = [
            ("scene, lens and program", now),
            ("threads", threads),
            ("what tiles received", rounds),
        ];
        let mut phases = vec![vec![("film", film), ("features", features), ("ghosts", ghosts)]];
        if let Some(format) = format {
            let layers = match format {
                Format::Exr => 4 * pixels * aov::channels(job) as u64,
                _ => 0,
            };
            let [layers, picture] = [("layers", layers), ("picture", PICTURE * pixels)];
            // Of all channels at once, before they are taken apart.
            let variance = if squares { PICTURE * pixels } else { 0 };
            let developed = [("film", film), ("features", features), ("variance", variance)];
            phases.push(developed.into_iter().chain([layers]).collect());
            if job.plan.has(Effect::Diffraction) {
                let spread = Diffraction::bytes(job.frame.size().map(|n| n as usize));
                phases.push(vec![picture, layers, ("diffraction", spread)]);
            }
            if job.sensor.is_some() {
                phases.push(vec![picture, layers, ("sensor", PICTURE * pixels)]);
            }
            let writer = match format {
                Format::Exr => {
                    let line =
                        u64::from(job.frame.size()[0]) * (PICTURE + layers.1 / pixels.max(1));
                    PACK[0] * PACK[1] * line * (machine::cores() as u64 + 2)
                }
                _ => CODES * pixels,
            };
            phases.push(vec![picture, layers, ("writing", writer)]);
        }
        let sum = |parts: &[(_, u64)]| parts.iter().map(|(_, bytes)| bytes).sum::<u64>();
        let largest = phases.into_iter().max_by_key(|parts| sum(parts)).unwrap_or_default();
        let mut parts: Vec<_> = always.into_iter().chain(largest).collect();
        if sum(&parts) < most {
            parts = vec![("reading the scene", most)];
        }
        parts.push(("what does not fit together", SLACK + sum(&parts) / SLACK_SHARE));
        parts.retain(|(_, bytes)| *bytes > 0);
        Self { parts }
    }

    /// With what else is held meanwhile.
    #[must_use]
    pub fn beside(mut self, name: &'static str, bytes: u64) -> Self {
        self.parts.push((name, bytes));
        self
    }

    /// Bytes in all.
    pub fn bytes(&self) -> u64 {
        self.parts.iter().map(|(_, bytes)| bytes).sum()
    }
}

impl fmt::Display for Estimate {
    /// "about 2.1 GB of memory (film 1.5 GB, ...)"
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let parts: Vec<String> =
            self.parts.iter().map(|(name, bytes)| format!("{name} {}", Size(*bytes))).collect();
        write!(f, "about {} of memory ({})", Size(self.bytes()), parts.join(", "))
    }
}
