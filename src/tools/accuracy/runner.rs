//! Renders and measures the rungs of a ladder within a budget.
//!
//! 1. A first pass renders the reference and every rung with the fewest samples, so that there is a
//!    table.
//! 2. The reference gets about half of the time: what is left after the rungs' share.
//! 3. The rungs go up level by level, each with twice the samples of the level before. The richest
//!    goes first, as the errors of the others are measured against it, then the rung that renders
//!    use. Within a level, all rungs take one quarter of their samples in turns before the next
//!    quarter.
//!
//! A level takes as many samples as all levels before it, so its time is known. A level that does
//! not fit is not begun; a timer is the last resort.

use std::ops::Range;
use std::time::{Duration, Instant};

use super::frontier::frontier;
use super::ladder::Ladder;
use super::monitor::RunMonitor;
use super::point::{Pass, Point, Reference, RenderCost};
use super::run::{Budget, LadderError, LadderRun, RunEnd, with_count};
use super::split_picture::{QUARTERS, SplitPicture, part_seed};
use petzval_base::stats::Stats;
use petzval_image::Picture;
use petzval_render::{RenderError, RenderOptions, render};

/// Largest share of the time after the first pass that the rungs get.
const RUNG_SHARE: f64 = 0.6;

/// Least and largest share of that time that the reference gets.
const REFERENCE_SHARE: [f64; 2] = [0.4, 0.6];

/// Safety factor on the predicted time of a level.
const SAFETY: f64 = 1.1;

/// Picture and cost of one rung so far.
struct RungState {
    picture: SplitPicture<4>,
    cost: RenderCost,
}

/// One render of a part of a rung's samples.
struct Exposure {
    picture: Picture,
    time: Duration,
    stats: Stats,
}

pub(super) struct LadderRunner<'a> {
    ladder: &'a mut Ladder,
    budget: &'a Budget,
    monitor: &'a RunMonitor,
    /// Seed of the job.
    seed: u32,
    states: Vec<RungState>,
    /// The richest rung's picture before its last level.
    before: Option<SplitPicture<4>>,
    reference: (SplitPicture<2>, RenderCost),
    measured: Option<Reference>,
    points: Vec<Point>,
    /// Time to measure one point.
    measuring: Duration,
}

impl<'a> LadderRunner<'a> {
    pub fn new(ladder: &'a mut Ladder, budget: &'a Budget, monitor: &'a RunMonitor) -> Self {
        let size = ladder.size();
        let state = |_| RungState { picture: SplitPicture::new(size), cost: RenderCost::default() };
        let states: Vec<RungState> = (0..ladder.rungs.len()).map(state).collect();
        let seed = ladder.job.seed;
        let reference = (SplitPicture::new(size), RenderCost::default());
        Self {
            ladder,
            budget,
            monitor,
            seed,
            states,
            before: None,
            reference,
            measured: None,
            points: Vec::new(),
            measuring: Duration::ZERO,
        }
    }

    pub fn run(&mut self) -> Result<(), LadderError> {
        self.deepen_reference(1)?;
        for rung in self.order() {
            self.double_samples(&[rung])?;
        }
        // One measurement, against the still noisy reference, tells how long measuring takes.
        let begun = Instant::now();
        let reference = self.reference();
        let richest = &self.states[self.richest()];
        let first = &self.states[0];
        reference.point(0, &first.picture, Some(&richest.picture), &first.cost)?;
        self.measuring = begun.elapsed();

        self.improve_reference()?;
        self.measure_all()?;
        while self.level()? {}
        Ok(())
    }

    fn richest(&self) -> usize {
        self.states.len() - 1
    }

    /// Returns the rungs in the order of rendering: the richest first, then the one that renders
    /// use.
    fn order(&self) -> impl Iterator<Item = usize> + use<> {
        let (richest, usual) = (self.richest(), self.ladder.usual());
        let others = (0..richest).filter(move |&rung| Some(rung) != usual);
        std::iter::once(richest).chain(usual).chain(others)
    }

    /// Returns the time left for rendering and measuring.
    fn left(&self) -> Duration {
        self.budget.end().saturating_duration_since(Instant::now())
    }

    /// Renders the reference in the time that the rungs are not expected to need.
    fn improve_reference(&mut self) -> Result<(), RenderError> {
        let left = self.left();
        let all: Duration = self.states.iter().map(|state| state.cost.time).sum();
        let measuring = self.measuring * self.states.len() as u32;
        let mut rungs = measuring;
        // Total time of all levels up to the next one.
        let (mut level, mut factor) = (measuring, 1);
        while let Some(more) = all.checked_mul(factor) {
            level += more + measuring;
            if level > left.mul_f64(RUNG_SHARE) {
                break;
            }
            rungs = level;
            factor *= 2;
        }
        // Times of a first pass are too uncertain to let either side go short.
        let [low, high] = REFERENCE_SHARE.map(|share| left.mul_f64(share));
        let until = left.saturating_sub(rungs.mul_f64(SAFETY)).clamp(low, high);
        let begun = Instant::now();
        loop {
            let (picture, cost) = &self.reference;
            let one = cost.time.as_secs_f64() / f64::from(picture.count.max(1));
            let left = until.saturating_sub(begun.elapsed()).as_secs_f64();
            let fits = (left / one.max(1e-6)) as u32;
            let most = (self.budget.samples / 2).saturating_sub(picture.count);
            let more = picture.count.min(fits).min(most);
            // A small rest is not worth the start-up cost of a render.
            if more == 0 || more < picture.count / 16 {
                return Ok(());
            }
            self.deepen_reference(more)?;
        }
    }

    fn deepen_reference(&mut self, more: u32) -> Result<(), RenderError> {
        let first = self.reference.0.count;
        let activity = format!("reference, {} samples", 2 * (first + more));
        let mut half =
            |part| self.expose(self.richest(), QUARTERS + part, first..first + more, &activity);
        let halves = [half(0)?, half(1)?];
        let (picture, cost) = &mut self.reference;
        for half in &halves {
            cost.add(half.time, &half.stats);
        }
        picture.add(halves.map(|half| half.picture), more);
        Ok(())
    }

    /// Renders and measures one level of all rungs. Returns false if it was the last.
    fn level(&mut self) -> Result<bool, LadderError> {
        // The richest rung alone is of no use.
        let first: Vec<usize> = self.order().take(2).collect();
        if !self.fits(&first) {
            return Ok(false);
        }
        let mut rungs = first;
        for rung in self.order().skip(rungs.len()) {
            rungs.push(rung);
            if !self.fits(&rungs) {
                rungs.pop();
            }
        }
        self.double_samples(&rungs)?;
        for &rung in &rungs {
            self.measure(rung)?;
        }
        Ok(rungs.len() == self.states.len())
    }

    /// Returns whether there is time for the next level of these rungs.
    fn fits(&self, rungs: &[usize]) -> bool {
        let states = || rungs.iter().map(|&rung| &self.states[rung]);
        let time: Duration = states().map(|state| state.cost.time).sum();
        let few = states().all(|state| 2 * state.picture.samples() <= self.budget.samples);
        few && time.mul_f64(SAFETY) + self.measuring * rungs.len() as u32 <= self.left()
    }

    /// Doubles the samples of these rungs, quarter by quarter in turns, so that other load on the
    /// machine slows all of them alike.
    fn double_samples(&mut self, rungs: &[usize]) -> Result<(), RenderError> {
        let mut exposures: Vec<Vec<Exposure>> = rungs.iter().map(|_| Vec::new()).collect();
        for part in 0..QUARTERS {
            for (&rung, exposures) in rungs.iter().zip(&mut exposures) {
                let first = self.states[rung].picture.count;
                let last = first + first.max(1);
                let activity = format!("{}, {} samples", self.ladder.rungs[rung].name, 4 * last);
                exposures.push(self.expose(rung, part, first..last, &activity)?);
            }
        }
        for (&rung, exposures) in rungs.iter().zip(exposures) {
            let first = self.states[rung].picture.count;
            if rung == self.richest() && first > 0 {
                self.before = Some(self.states[rung].picture.clone());
            }
            let RungState { picture, cost } = &mut self.states[rung];
            let pass = if first == 0 { Pass::First } else { Pass::Later };
            for (part, Exposure { time, stats, .. }) in exposures.iter().enumerate() {
                cost.add_quarter(part, *time, stats, pass);
            }
            let pictures: Vec<Picture> =
                exposures.into_iter().map(|exposure| exposure.picture).collect();
            if let Ok(pictures) = pictures.try_into() {
                picture.add(pictures, first.max(1));
            }
        }
        Ok(())
    }

    fn expose(
        &mut self,
        rung: usize,
        part: u32,
        samples: Range<u32>,
        activity: &str,
    ) -> Result<Exposure, RenderError> {
        self.monitor.set_activity(activity.to_owned());
        let Ladder { job, rungs, .. } = &mut *self.ladder;
        let count = samples.end - samples.start;
        job.samples = samples;
        job.seed = part_seed(self.seed, part);
        let view = &mut rungs[rung].variant;
        view.swap(job);
        let progress = Some(&self.monitor.progress);
        let options = RenderOptions { progress, ..RenderOptions::default() };
        let begun = Instant::now();
        let exposed = render(job, options);
        let time = begun.elapsed();
        view.swap(job);
        let exposed = exposed?;
        let mut picture = exposed.film.picture(count);
        let factor = self.ladder.rungs[rung].exposure;
        picture.pixels.iter_mut().for_each(|pixel| *pixel = pixel.map(|v| v * factor));
        Ok(Exposure { picture, time, stats: exposed.stats })
    }

    fn reference(&self) -> Reference {
        let (picture, cost) = &self.reference;
        Reference::new(picture, cost.time.as_secs_f64())
    }

    /// Measures the pictures of the first pass.
    fn measure_all(&mut self) -> Result<(), LadderError> {
        if self.reference.0.count == 0 {
            return Ok(());
        }
        self.measured = Some(self.reference());
        for rung in self.order() {
            if self.states[rung].picture.count > 0 {
                self.measure(rung)?;
            }
        }
        Ok(())
    }

    fn measure(&mut self, rung: usize) -> Result<(), LadderError> {
        let Some(reference) = &self.measured else { return Ok(()) };
        self.monitor.set_activity(format!("measuring {}", self.ladder.rungs[rung].name));
        let RungState { picture, cost } = &self.states[rung];
        let richest = &self.states[self.richest()].picture;
        let other = with_count(picture.count, richest, self.before.as_ref());
        let other = other.filter(|_| rung != self.richest());
        let point = reference.point(rung, picture, other, cost)?;
        self.monitor.add_point(point.clone());
        self.points.push(point);
        Ok(())
    }

    /// Returns a point's error for the frontier; NaN if the rung has an effect that the reference
    /// lacks.
    fn frontier_error(&self, point: &Point) -> f64 {
        match self.ladder.rungs[point.rung].adds {
            Some(_) => f64::NAN,
            None => point.error,
        }
    }

    /// Measures what a stopped first pass rendered, and marks the frontier.
    pub fn finish(mut self) -> Result<LadderRun, LadderError> {
        if self.measured.is_none() {
            self.measure_all()?;
        }
        let whole = self.states.iter().all(|state| state.picture.count > 0);
        let end = match (self.monitor.interrupted(), whole) {
            (true, _) => RunEnd::Interrupted,
            (false, true) => RunEnd::Planned,
            (false, false) => RunEnd::Early,
        };
        self.points.sort_by_key(|point| (point.rung, point.samples));
        let pairs: Vec<[f64; 2]> =
            self.points.iter().map(|point| [point.seconds, self.frontier_error(point)]).collect();
        for (point, on) in self.points.iter_mut().zip(frontier(&pairs)) {
            point.on_frontier = on;
        }
        Ok(LadderRun {
            points: self.points,
            reference: self.measured,
            end,
            seconds: self.budget.begun.elapsed().as_secs_f64(),
            pictures: self.states.into_iter().map(|state| state.picture).collect(),
            before: self.before,
        })
    }
}
