//! As many samples for every pixel, pass by pass.
//!
//! A pass takes some samples of all tiles. A tile adds what it receives in a pass at once, and all
//! of a pass before the next, so the picture is the same whether it was interrupted or not.

use std::io;
use std::sync::{Mutex, PoisonError};

use super::crew::lock;
use super::gathered::Gathered;
use super::haunt::Haunt;
use super::keeper::{Keep, Received};
use super::partial;
use super::{Crew, Exposed, Job, RenderError, Share};
use crate::checkpoint::{CheckpointError, Reader, Saved, Writer, wrong};
use crate::film::Tile;
use crate::lanes::Real;
use crate::stats::Stats;

/// Samples of a pixel in a pass: enough for many waves in a tile, also where each has a band of its own,
/// so that few are not full. With 64 a render takes 7 % longer, with these not 1 %.
const PASS: u32 = 256;

/// A render between passes.
pub(super) struct Even<'a> {
    job: &'a Job,
    tiles: Vec<Tile>,
    gathered: Mutex<Gathered>,
    /// Samples of every pixel before the present pass.
    done: u32,
    haunt: Haunt,
}

/// Renders a job, or what is left of it.
pub(super) fn expose<R: Real<Scalar = f32>>(
    crew: &Crew,
    from: Option<Saved>,
) -> Result<Exposed, RenderError> {
    let mut even = Even::new(crew.job);
    if let Some(saved) = from {
        saved.check(crew.job)?;
        saved.body(|body| even.receive(body))?;
    }
    loop {
        let done = even.done;
        crew.haunt::<R>(&mut even, done);
        if crew.stopped() || even.complete() {
            break;
        }
        even.pass::<R>(crew);
    }
    crew.end(&even, even.complete())?;
    Ok(even.finish(crew.stats()))
}

/// The whole of parts, which together hold all samples of the job.
pub(super) fn merge(
    job: &Job,
    parts: impl Iterator<Item = Result<Saved, CheckpointError>>,
) -> Result<Exposed, CheckpointError> {
    let mut even = Even::new(job);
    let mut stats = Stats::default();
    for part in parts {
        let part = part?;
        part.check(job)?;
        stats.add(&part.head.stats);
        let end = even.done.saturating_add(part.head.samples.len() as u32);
        part.body(|body| {
            even.receive(body)?;
            match even.holds(end) {
                true => Ok(()),
                false => Err(wrong("it is damaged: it does not hold the samples that it names")),
            }
        })?;
    }
    Ok(even.finish(stats))
}

impl<'a> Even<'a> {
    fn new(job: &'a Job) -> Self {
        let tiles = job.frame.tiles();
        Self {
            job,
            gathered: Mutex::new(Gathered::new(job, tiles.len())),
            tiles,
            done: 0,
            haunt: Haunt::new(job),
        }
    }

    fn complete(&self) -> bool {
        self.holds(self.job.samples.len() as u32)
    }

    /// Whether it holds so many samples of every pixel, with their ghosts, and no more.
    fn holds(&self, samples: u32) -> bool {
        let between = !lock(&self.gathered).entered.contains(&true);
        self.done == samples && self.haunt.reaches(samples) && between
    }

    /// The shares of the present pass.
    fn shares(&self) -> Vec<Share> {
        let start = self.job.samples.start + self.done;
        let samples = start..self.job.samples.end.min(start.saturating_add(PASS));
        let share = |&tile: &Tile| Share { tile, samples: samples.clone(), seed: self.job.seed };
        self.tiles.iter().map(share).collect()
    }

    fn pass<R: Real<Scalar = f32>>(&mut self, crew: &Crew) {
        let shares = self.shares();
        crew.expose::<R>(&shares, self);
        let Gathered { entered, .. } = &mut *lock(&self.gathered);
        if entered.iter().all(|&entered| entered) {
            entered.fill(false);
            self.done += pass(&shares);
        }
    }

    fn finish(self, stats: Stats) -> Exposed {
        let complete = self.complete();
        let samples = [self.done, self.done + pass(&self.shares())];
        let Self { tiles, gathered, haunt, .. } = self;
        let gathered = gathered.into_inner().unwrap_or_else(PoisonError::into_inner);
        if !complete {
            let counts: Vec<u32> =
                gathered.entered.iter().map(|&entered| samples[usize::from(entered)]).collect();
            return partial::exposed(&tiles, &counts, gathered.into_film(), &haunt, stats);
        }
        let (mut film, features) = gathered.into_film();
        haunt.put(&mut film, 1.0);
        Exposed { film, features, stats, reached: None, partial: None }
    }
}

/// Samples of a pixel that a pass takes.
fn pass(shares: &[Share]) -> u32 {
    shares.first().map_or(0, |share| share.samples.len() as u32)
}

impl Keep for Even<'_> {
    fn has(&self, share: usize) -> bool {
        lock(&self.gathered).entered[share]
    }

    fn enter(&self, share: usize, received: Received) {
        lock(&self.gathered).enter(share, &self.tiles[share], &received);
    }

    fn haunt(&mut self) -> &mut Haunt {
        &mut self.haunt
    }

    fn save(&self, to: &mut Writer) -> io::Result<()> {
        to.u32(self.done)?;
        for (number, tile) in self.tiles.iter().enumerate() {
            // Workers that enter tiles do not wait for the disk.
            let (entered, (sums, features)) = {
                let gathered = lock(&self.gathered);
                (gathered.entered[number], gathered.tile(number, tile))
            };
            to.u32(entered.into())?;
            if self.done > 0 || entered {
                sums.save(to)?;
                features.iter().try_for_each(|features| features.save(to))?;
            }
        }
        self.haunt.save(to)
    }

    fn receive(&mut self, from: &mut Reader) -> io::Result<()> {
        let left = self.job.samples.len() as u32 - self.done;
        let done = from.below(left as usize + 1, "samples")? as u32;
        self.done += done;
        // Where all samples are there, no pass is on its way.
        let passes = if self.done < self.job.samples.len() as u32 { 2 } else { 1 };
        let mut gathered = lock(&self.gathered);
        for (number, tile) in self.tiles.iter().enumerate() {
            let entered = from.below(passes, "passes")? == 1;
            gathered.entered[number] = entered;
            if done > 0 || entered {
                let (mut sums, mut features) = gathered.tile(number, tile);
                sums.receive(from)?;
                features.iter_mut().try_for_each(|features| features.receive(from))?;
                gathered.put(number, tile, &sums, features.as_ref());
            }
        }
        self.haunt.receive(from)?;
        match self.haunt.samples > self.done {
            true => Err(wrong("it is damaged: it holds more ghosts than samples")),
            false => Ok(()),
        }
    }
}
