//! Rendering the ladder within a budget.
//!
//! 1. A first pass: the reference and every rung with the fewest samples, so that there is a table.
//! 2. The reference with about half of the time: what is left when the rungs get their share.
//! 3. The rungs level by level, each with twice the samples of the one before; the richest first,
//!    as the others' errors are told against it, and then the one that renders take. A level goes a
//!    quarter of the samples of all its rungs after the other.
//!
//! What a level takes is known from the one before, as it takes as many samples as all before it.
//! What does not fit is not begun; and if all else fails, a timer ends it.

use std::time::{Duration, Instant};

use super::frontier::frontier;
use super::point::{Point, Reference, Work};
use super::quarters::{Parts, QUARTERS, seed};
use super::rung::Ladder;
use super::watch::Watch;
use crate::image::Picture;
use crate::render::{Backend, RenderError, render};
use crate::stats::Stats;

/// The budget's share that the rungs get behind the first pass, at most.
const RUNGS: f64 = 0.6;

/// The least and most of it that the reference gets.
const REFERENCE: [f64; 2] = [0.4, 0.6];

/// What is kept of the time to write the report.
const WRITING: Duration = Duration::from_millis(800);

/// How much longer than the last level a level may take, for its samples.
const CARE: f64 = 1.1;

/// Why a climb ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// Its time was used as planned.
    Planned,
    /// The time was over before every rung had a picture.
    Early,
    /// Somebody stopped it.
    Interrupted,
}

/// When a climb ends, and how far it goes.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    /// When its time began: reading the scene counts.
    pub begun: Instant,
    /// How long it may take in all, with writing the report.
    pub time: Duration,
    /// The most samples a pixel.
    pub samples: u32,
}

/// What a climb found.
#[derive(Clone, Debug)]
pub struct Climb {
    /// By rung and number of samples.
    pub points: Vec<Point>,
    /// What they are measured by; none where there was no time for it.
    pub reference: Option<Reference>,
    /// Why it ended.
    pub ended: Ended,
    /// What it took, s.
    pub seconds: f64,
    /// The last picture of every rung.
    parts: Vec<Parts<4>>,
    /// That of the richest before its last level.
    before: Option<Parts<4>>,
}

impl Climb {
    /// The last picture of a rung, and that of the richest with as many samples and the same seeds.
    pub(super) fn pair(&self, rung: usize) -> Option<[&Parts<4>; 2]> {
        let own = self.parts.get(rung).filter(|parts| parts.count > 0)?;
        Some([own, facing(own.count, self.parts.last()?, self.before.as_ref())?])
    }

    /// How many rungs there are.
    pub(super) fn rungs(&self) -> usize {
        self.parts.len()
    }

    /// The last point of a rung.
    pub fn last(&self, rung: usize) -> Option<&Point> {
        self.points.iter().rfind(|point| point.rung == rung)
    }
}

/// The richest rung's picture of this count, if there is one.
fn facing<'a>(count: u32, now: &'a Parts<4>, before: Option<&'a Parts<4>>) -> Option<&'a Parts<4>> {
    [Some(now), before].into_iter().flatten().find(|parts| parts.count == count)
}

/// Renders a ladder within a budget.
///
/// # Errors
/// Where threads cannot be had.
pub fn climb(ladder: &mut Ladder, budget: &Budget, watch: &Watch) -> Result<Climb, RenderError> {
    let end = budget.begun + budget.time - writing(budget);
    watch.until(end, || {
        let mut climber = Climber::new(ladder, budget, watch);
        match climber.run() {
            Ok(()) | Err(RenderError::Stopped) => Ok(climber.finish()),
            Err(other) => Err(other),
        }
    })
}

/// What is kept of a budget for writing.
fn writing(budget: &Budget) -> Duration {
    WRITING.min(budget.time / 4)
}

/// What one rung has so far.
struct State {
    parts: Parts<4>,
    work: Work,
}

struct Climber<'a> {
    ladder: &'a mut Ladder,
    budget: &'a Budget,
    watch: &'a Watch,
    /// The seed of the job.
    seed: u32,
    states: Vec<State>,
    /// The richest rung's picture before its last level.
    before: Option<Parts<4>>,
    reference: (Parts<2>, Work),
    measured: Option<Reference>,
    points: Vec<Point>,
    /// What measuring a point takes.
    measuring: Duration,
}

impl<'a> Climber<'a> {
    fn new(ladder: &'a mut Ladder, budget: &'a Budget, watch: &'a Watch) -> Self {
        let size = ladder.size();
        let state = |_| State { parts: Parts::new(size), work: Work::default() };
        let states: Vec<State> = (0..ladder.rungs.len()).map(state).collect();
        let seed = ladder.job.seed;
        let reference = (Parts::new(size), Work::default());
        Self {
            ladder,
            budget,
            watch,
            seed,
            states,
            before: None,
            reference,
            measured: None,
            points: Vec::new(),
            measuring: Duration::ZERO,
        }
    }

    fn richest(&self) -> usize {
        self.states.len() - 1
    }

    /// The order in which rungs go up: the richest first, then the one that renders take.
    fn order(&self) -> impl Iterator<Item = usize> + use<> {
        let (richest, usual) = (self.richest(), self.ladder.usual());
        let others = (0..richest).filter(move |&rung| Some(rung) != usual);
        std::iter::once(richest).chain(usual).chain(others)
    }

    /// Time until everything must be rendered and measured.
    fn left(&self) -> Duration {
        let end = self.budget.begun + self.budget.time - writing(self.budget);
        end.saturating_duration_since(Instant::now())
    }

    fn run(&mut self) -> Result<(), RenderError> {
        self.deepen_reference(1)?;
        for rung in self.order() {
            self.rise(&[rung])?;
        }
        // How long measuring takes is known when it was done once; the reference is a poor one yet.
        let begun = Instant::now();
        let reference = self.reference();
        let richest = &self.states[self.richest()];
        reference.point(0, &self.states[0].parts, Some(&richest.parts), &self.states[0].work);
        self.measuring = begun.elapsed();

        self.improve_reference()?;
        self.measure_all();
        while self.level()? {}
        Ok(())
    }

    /// The reference with the time that the rungs are not expected to need.
    fn improve_reference(&mut self) -> Result<(), RenderError> {
        let left = self.left();
        let all: Duration = self.states.iter().map(|state| state.work.time).sum();
        let measuring = self.measuring * self.states.len() as u32;
        let mut rungs = measuring;
        // What levels up to the next one take, all together.
        let (mut level, mut factor) = (measuring, 1);
        while let Some(more) = all.checked_mul(factor) {
            level += more + measuring;
            if level > left.mul_f64(RUNGS) {
                break;
            }
            rungs = level;
            factor *= 2;
        }
        // Times of a first pass are not to be trusted so far that either goes short.
        let [low, high] = REFERENCE.map(|share| left.mul_f64(share));
        let until = left.saturating_sub(rungs.mul_f64(CARE)).clamp(low, high);
        let begun = Instant::now();
        loop {
            let (parts, work) = &self.reference;
            let one = work.time.as_secs_f64() / f64::from(parts.count.max(1));
            let left = until.saturating_sub(begun.elapsed()).as_secs_f64();
            let fits = (left / one.max(1e-6)) as u32;
            let most = (self.budget.samples / 2).saturating_sub(parts.count);
            let more = parts.count.min(fits).min(most);
            // The last bit is not worth its beginning.
            if more == 0 || more < parts.count / 16 {
                return Ok(());
            }
            self.deepen_reference(more)?;
        }
    }

    fn deepen_reference(&mut self, more: u32) -> Result<(), RenderError> {
        let first = self.reference.0.count;
        let what = format!("reference, {} samples", 2 * (first + more));
        let mut half =
            |part| self.expose(self.richest(), QUARTERS + part, first..first + more, &what);
        let [one, other] = [half(0)?, half(1)?];
        let (parts, work) = &mut self.reference;
        for exposed in [&one, &other] {
            work.add(exposed.1, &exposed.2);
        }
        parts.add([one.0, other.0], more);
        Ok(())
    }

    /// One level of all rungs; false where it was the last.
    fn level(&mut self) -> Result<bool, RenderError> {
        // The richest alone is of no use.
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
        self.rise(&rungs)?;
        for &rung in &rungs {
            self.measure(rung);
        }
        Ok(rungs.len() == self.states.len())
    }

    /// Whether there is time for the next level of these rungs.
    fn fits(&self, rungs: &[usize]) -> bool {
        let states = || rungs.iter().map(|&rung| &self.states[rung]);
        let time: Duration = states().map(|state| state.work.time).sum();
        let few = states().all(|state| 2 * state.parts.samples() <= self.budget.samples);
        few && time.mul_f64(CARE) + self.measuring * rungs.len() as u32 <= self.left()
    }

    /// These rungs, each with twice its samples; quarter by quarter in turns, so that what else the
    /// machine does meets all of them.
    fn rise(&mut self, rungs: &[usize]) -> Result<(), RenderError> {
        let mut exposed: Vec<Vec<(Picture, Duration, Stats)>> = vec![Vec::new(); rungs.len()];
        for part in 0..QUARTERS {
            for (&rung, exposed) in rungs.iter().zip(&mut exposed) {
                let first = self.states[rung].parts.count;
                let last = first + first.max(1);
                let what = format!("{}, {} samples", self.ladder.rungs[rung].name, 4 * last);
                exposed.push(self.expose(rung, part, first..last, &what)?);
            }
        }
        for (&rung, exposed) in rungs.iter().zip(exposed) {
            let first = self.states[rung].parts.count;
            if rung == self.richest() && first > 0 {
                self.before = Some(self.states[rung].parts.clone());
            }
            let State { parts, work } = &mut self.states[rung];
            for (part, (_, time, stats)) in exposed.iter().enumerate() {
                work.add_quarter(part, *time, stats, first == 0);
            }
            let pictures: Vec<Picture> = exposed.into_iter().map(|(picture, ..)| picture).collect();
            if let Ok(pictures) = pictures.try_into() {
                parts.add(pictures, first.max(1));
            }
        }
        Ok(())
    }

    fn expose(
        &mut self,
        rung: usize,
        part: u32,
        samples: std::ops::Range<u32>,
        what: &str,
    ) -> Result<(Picture, Duration, Stats), RenderError> {
        self.watch.does(what.to_owned());
        let Ladder { job, rungs, .. } = &mut *self.ladder;
        let count = samples.end - samples.start;
        job.samples = samples;
        job.seed = seed(self.seed, part);
        let view = &mut rungs[rung].view;
        view.swap(job);
        let begun = Instant::now();
        let exposed = render(job, Backend::Simd, 0, &self.watch.progress);
        let time = begun.elapsed();
        view.swap(job);
        let exposed = exposed?;
        Ok((exposed.film.picture(count), time, exposed.stats))
    }

    fn reference(&self) -> Reference {
        let (parts, work) = &self.reference;
        Reference::new(parts, work.time.as_secs_f64())
    }

    /// Measures what the first pass rendered.
    fn measure_all(&mut self) {
        if self.reference.0.count == 0 {
            return;
        }
        self.measured = Some(self.reference());
        for rung in self.order() {
            if self.states[rung].parts.count > 0 {
                self.measure(rung);
            }
        }
    }

    fn measure(&mut self, rung: usize) {
        let Some(reference) = &self.measured else { return };
        self.watch.does(format!("measuring {}", self.ladder.rungs[rung].name));
        let State { parts, work } = &self.states[rung];
        let richest = &self.states[self.richest()].parts;
        let other = facing(parts.count, richest, self.before.as_ref());
        let other = other.filter(|_| rung != self.richest());
        self.points.push(reference.point(rung, parts, other, work));
    }

    /// A point's error; none of a rung whose effect the reference lacks.
    fn judged(&self, point: &Point) -> f64 {
        match self.ladder.rungs[point.rung].adds {
            Some(_) => f64::NAN,
            None => point.error,
        }
    }

    fn finish(mut self) -> Climb {
        if self.measured.is_none() {
            self.measure_all();
        }
        let whole = self.states.iter().all(|state| state.parts.count > 0);
        let ended = match (self.watch.interrupted(), whole) {
            (true, _) => Ended::Interrupted,
            (false, true) => Ended::Planned,
            (false, false) => Ended::Early,
        };
        self.points.sort_by_key(|point| (point.rung, point.samples));
        let pairs: Vec<[f64; 2]> =
            self.points.iter().map(|point| [point.seconds, self.judged(point)]).collect();
        for (point, on) in self.points.iter_mut().zip(frontier(&pairs)) {
            point.on_frontier = on;
        }
        Climb {
            points: self.points,
            reference: self.measured,
            ended,
            seconds: self.budget.begun.elapsed().as_secs_f64(),
            parts: self.states.into_iter().map(|state| state.parts).collect(),
            before: self.before,
        }
    }
}
