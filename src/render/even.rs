//! As many samples for every pixel, pass by pass.
//!
//! A pass takes some samples of all tiles; what its shares receive is added in one order, so the
//! picture is the same whether it was interrupted or not.

use std::io;

use super::haunt::Haunt;
use super::keeper::Keep;
use super::ledger::Ledger;
use super::partial::{self, Part};
use super::{Crew, Exposed, Job, RenderError, Share};
use crate::aov::{Aov, FeatureFilm, Features};
use crate::checkpoint::{CheckpointError, Reader, Saved, Writer, wrong};
use crate::film::{FilmSums, Tile, TileSums};
use crate::lanes::Real;
use crate::stats::Stats;

/// Samples of a pixel in a pass: enough for many waves in a tile, also where each has a band of its own,
/// so that few are not full. With 64 a render takes 7 % longer, with these not 1 %.
const PASS: u32 = 256;

/// A render between passes.
pub(super) struct Even<'a> {
    job: &'a Job,
    tiles: Vec<Tile>,
    sums: Vec<TileSums>,
    features: Vec<Option<Features>>,
    /// Samples of every pixel in the sums.
    done: u32,
    haunt: Haunt,
    ledger: Ledger,
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
        let squares = job.layers.contains(&Aov::Variance);
        Self {
            job,
            sums: tiles.iter().map(|tile| TileSums::new(tile, squares)).collect(),
            features: tiles.iter().map(|tile| Features::new(job, tile)).collect(),
            tiles,
            done: 0,
            haunt: Haunt::new(job),
            ledger: Ledger::default(),
        }
    }

    fn complete(&self) -> bool {
        self.holds(self.job.samples.len() as u32)
    }

    /// Whether it holds so many samples of every pixel, with their ghosts, and no more.
    fn holds(&self, samples: u32) -> bool {
        self.done == samples && self.haunt.reaches(samples) && self.ledger.done().next().is_none()
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
        self.ledger.open(shares.len());
        crew.expose::<R>(&shares, self);
        let Some(received) = self.ledger.settle() else { return };
        let own = self.sums.iter_mut().zip(&mut self.features);
        for ((sums, features), (more, met)) in own.zip(received) {
            sums.add(&more);
            if let (Some(features), Some(met)) = (features, met) {
                features.add(&met);
            }
        }
        self.done += shares.first().map_or(0, |share| share.samples.len() as u32);
    }

    fn finish(self, stats: Stats) -> Exposed {
        if !self.complete() {
            return self.partial(stats);
        }
        let frame = self.job.frame;
        let mut film = FilmSums::new(frame, self.job.layers.contains(&Aov::Variance));
        for (tile, sums) in self.tiles.iter().zip(&self.sums) {
            film.put(tile, sums);
        }
        self.haunt.put(&mut film, 1.0);
        let features = FeatureFilm::of(self.job, self.tiles.iter().zip(&self.features));
        Exposed { film, features, stats, reached: None, partial: None }
    }

    /// What there is of the picture.
    fn partial(self, stats: Stats) -> Exposed {
        let pass = self.shares().first().map_or(0, |share| share.samples.len() as u32);
        let own = self.sums.iter().zip(&self.features).enumerate();
        let own = own.map(|(tile, (sums, features))| Part {
            tile,
            sums,
            features: features.as_ref(),
            samples: self.done,
        });
        let present = self.ledger.done().map(|(tile, (sums, features))| Part {
            tile,
            sums,
            features: features.as_ref(),
            samples: pass,
        });
        partial::exposed(self.job, &self.tiles, own.chain(present), &self.haunt, stats)
    }
}

impl Keep for Even<'_> {
    fn ledger(&self) -> &Ledger {
        &self.ledger
    }

    fn haunt(&mut self) -> &mut Haunt {
        &mut self.haunt
    }

    fn save(&self, to: &mut Writer) -> io::Result<()> {
        to.u32(self.done)?;
        // In the first pass there are none.
        let whole = if self.done > 0 { &self.sums[..] } else { &[] };
        for (sums, features) in whole.iter().zip(&self.features) {
            sums.save(to)?;
            features.iter().try_for_each(|features| features.save(to))?;
        }
        self.haunt.save(to)?;
        self.ledger.save(to)
    }

    fn receive(&mut self, from: &mut Reader) -> io::Result<()> {
        let left = self.job.samples.len() as u32 - self.done;
        let done = from.below(left as usize + 1, "samples")? as u32;
        self.done += done;
        let whole = if done > 0 { &mut self.sums[..] } else { &mut [] };
        for (sums, features) in whole.iter_mut().zip(&mut self.features) {
            sums.receive(from)?;
            features.iter_mut().try_for_each(|features| features.receive(from))?;
        }
        self.haunt.receive(from)?;
        if self.haunt.samples > self.done {
            return Err(wrong("it is damaged: it holds more ghosts than samples"));
        }
        let shares = self.shares();
        self.ledger.receive(from, self.job, &shares)
    }
}
