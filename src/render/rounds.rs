//! Rounds of samples, each where those before say that they are needed.
//!
//! Samples come in four quarters with seeds of their own; each quarter of a pixel has a mean. The
//! first two are a pair, the others another. The quarters of a pair have the same counts, so that
//! the square of their difference tells the variance without bias. How many samples a tile of one
//! pair takes, and when the pair has enough, is said by the variance in the other, and the picture
//! is the mean of both: no sample has a say in how much it counts (Rousselle, Knaus & Zwicker
//! 2012, "Adaptive rendering with non-local means filtering"). Errors of a tile's
//! pixels are added up, as those of single pixels are known badly.
//!
//! A pair that has met rare and bright light in a tile sends the other after it. It would not learn
//! how rare it is, as its own count there is the other's to say. So where one of the pairs is to take
//! many samples for each that the other knows the tile by, the other looks closer: its scouts, of
//! seeds of their own, tell it more and are no part of the picture.

use std::io;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use super::haunt::Haunt;
use super::keeper::{Keep, Received};
use super::ledger::Ledger;
use super::pair::{Pair, luminance, relative};
use super::partial;
use super::spread::{Spread, cost};
use super::{Crew, Exposed, Job, Progress, Reached, RenderError, Share, Until};
use crate::aov::{FeatureFilm, Features};
use crate::checkpoint::{Reader, Saved, Writer, wrong};
use crate::film::{FilmSums, Tile, single};
use crate::lanes::Real;
use crate::sampler::hash;
use crate::stats::Stats;

/// Samples of every quarter of a pixel before anything is known of it; in a hurry, one.
const FIRST: u32 = 4;
/// Samples of a quarter after which a pair that has met no light does not look on for it.
const BLIND: u32 = 64;
/// The most samples of a pair for each that the other knows a tile by.
const LED: u32 = 8;
/// What is added to a pixel's luminance when its error is divided by it, as a share of the mean.
const FLOOR: f64 = 0.1;

/// No count is larger than this.
const MOST: usize = 1 << 29;

/// The next count on the way to one that is wanted: at most twice as large, and not all of a long
/// way, as the variance falls faster than counts rise and will be known better.
fn step(count: u32, wanted: u32) -> u32 {
    let way = wanted.saturating_sub(count);
    let way = if way > count / 8 { way - way / 4 } else { way };
    count.saturating_add(way.min(count))
}

/// A render between rounds.
struct Rounds<'a> {
    job: &'a Job,
    /// Those that light comes to.
    tiles: Vec<Tile>,
    /// How many of their pixels it comes to.
    pixels: Vec<u64>,
    /// The two of the picture, and the scouts of each.
    pairs: [Pair; 4],
    features: Vec<Option<Features>>,
    /// The counts of the present round, by pair.
    wanted: [Vec<u32>; 4],
    haunt: Haunt,
    ledger: Ledger,
    /// When it began, had it never been interrupted.
    start: Instant,
}

/// A share of a round: the tile and the quarter that it belongs to.
type Place = (usize, usize);

/// Renders a job, or what is left of it, until its picture is good enough.
pub(super) fn expose<R: Real<Scalar = f32>>(
    crew: &Crew,
    from: Option<Saved>,
) -> Result<Exposed, RenderError> {
    let mut rounds = Rounds::new(crew.job);
    if let Some(saved) = from {
        saved.check(crew.job)?;
        saved.body(|body| rounds.receive(body))?;
    }
    let complete = loop {
        rounds.go::<R>(crew);
        if crew.stopped() {
            break false;
        }
        let next = rounds.next(crew.progress);
        if next == rounds.wanted {
            break true;
        }
        rounds.wanted = next;
    };
    crew.end(&rounds, complete)?;
    Ok(match complete {
        true => rounds.finish(crew.stats()),
        false => rounds.partial(crew.stats()),
    })
}

impl<'a> Rounds<'a> {
    fn new(job: &'a Job) -> Self {
        let tiles = job.frame.tiles().into_iter();
        let lit = tiles.map(|tile| (tile, job.sampler(&tile, 0..1).count()));
        let (tiles, pixels): (Vec<Tile>, Vec<u64>) = lit.filter(|(_, count)| *count > 0).unzip();
        let most = job.samples.len() as u32 / Until::FEWEST;
        let first = if job.until.time.is_some() { 1 } else { FIRST };
        let first = first.min(most).max(1);
        Self {
            job,
            pairs: [(); 4].map(|()| Pair::new(tiles.len())),
            features: tiles.iter().map(|tile| Features::new(job, tile)).collect(),
            wanted: [first, first, 0, 0].map(|count| vec![count; tiles.len()]),
            tiles,
            pixels,
            haunt: Haunt::new(job),
            ledger: Ledger::default(),
            start: Instant::now(),
        }
    }

    /// Pixels of the picture.
    fn whole(&self) -> f64 {
        self.job.frame.size().map(f64::from).iter().product()
    }

    /// Pixels that light comes to.
    fn lit(&self) -> f64 {
        self.pixels.iter().sum::<u64>() as f64
    }

    /// Samples that a quarter has in all, if its pixels have these counts.
    fn cost(&self, counts: &[u32]) -> f64 {
        cost(&self.pixels, counts.iter().copied())
    }

    /// Samples taken.
    fn taken(&self) -> f64 {
        2.0 * self.pairs.iter().map(|pair| self.cost(&pair.counts)).sum::<f64>()
    }

    /// The counts of the next round, by pair, and what is expected of those after it.
    fn next(&self, progress: &Progress) -> [Vec<u32>; 4] {
        let more = self.job.until.time.map_or(f64::INFINITY, |time| {
            let gone = self.start.elapsed();
            let rate = self.taken() / gone.max(Duration::from_micros(1)).as_secs_f64();
            rate * time.saturating_sub(gone).as_secs_f64() / 4.0
        });
        let most = self.lit() * self.job.samples.len() as f64 / 2.0;
        let scouts = [2, 3].map(|pair| self.pairs[pair].counts.clone());
        let left = (most - scouts.iter().map(|counts| self.cost(counts)).sum::<f64>()) / 2.0;
        let wanted = [0, 1].map(|pair| {
            let own = self.cost(&self.pairs[pair].counts);
            self.wanted(pair, left.min(own + more))
        });
        let ahead = [0, 1].map(|pair| self.scouts(pair, &wanted[1 - pair]));
        let cost = wanted.iter().chain(&ahead).map(|counts| self.cost(counts)).sum::<f64>();
        progress.expected.store((2.0 * cost) as u64, Ordering::Relaxed);
        let scouts = if cost > most { scouts } else { ahead };
        let [one, other] = [0, 1].map(|pair| {
            let count = |i: usize| {
                let own = self.pairs[pair].counts[i];
                let known = self.pairs[1 - pair].counts[i].max(scouts[1 - pair][i]);
                let led = known.saturating_mul(LED).saturating_add(LED - 1);
                step(own, wanted[pair][i]).min(own.max(led))
            };
            (0..self.tiles.len()).map(count).collect()
        });
        let [of_one, of_other] = scouts;
        [one, other, of_one, of_other]
    }

    /// The counts that a pair wants, by what the other knows; `budget` is for a quarter.
    fn wanted(&self, pair: usize, budget: f64) -> Vec<u32> {
        let (own, other) = (&self.pairs[pair].counts, &self.pairs[1 - pair]);
        let mean = other.luminance(self.whole());
        let variances = self.variances(1 - pair, FLOOR * mean);
        let spread = Spread::new(&self.pixels, own, &variances);
        if mean <= 0.0 && self.cost(&other.counts) < f64::from(BLIND) * self.lit() {
            return spread.wanted(None, budget.min(2.0 * self.cost(own)));
        }
        // The errors of both pairs are halved in their mean, and their squares added up.
        let bound = self.job.until.noise.map(|noise| 2.0 * self.whole() * noise * noise);
        spread.wanted(bound, budget)
    }

    /// What a pair and its scouts know together of the relative variance of one sample.
    fn variances(&self, pair: usize, floor: f64) -> Vec<f64> {
        let [own, scouts] = [pair, pair + 2].map(|pair| &self.pairs[pair]);
        let [of_own, of_scouts] = [own, scouts].map(|pair| pair.variances(&self.tiles, floor));
        let mean = |i: usize| {
            let [a, b] = [own, scouts].map(|pair| f64::from(pair.counts[i]));
            (a * of_own[i] + b * of_scouts[i]) / (a + b)
        };
        (0..self.tiles.len()).map(mean).collect()
    }

    /// The next counts of a pair's scouts, where the other pair wants these.
    fn scouts(&self, pair: usize, wanted: &[u32]) -> Vec<u32> {
        let [known, scouts] = [pair, pair + 2].map(|pair| &self.pairs[pair].counts);
        let count = |((&known, &own), &wanted): ((&u32, &u32), &u32)| match wanted / LED {
            ahead if ahead > known.max(own) => step(known.max(own), ahead),
            _ => own,
        };
        known.iter().zip(scouts).zip(wanted).map(count).collect()
    }

    /// Whether a round of this job may want what it does: no less than there is, not much more than
    /// the job allows, where pairs that are far apart go a little beyond it, and not much more than is
    /// known.
    fn sane(&self) -> bool {
        let near = |pair: usize, i: usize| {
            let [own, known] = [pair, pair % 2].map(|pair| self.pairs[pair].counts[i]);
            let wanted = self.wanted[pair][i];
            own <= wanted && wanted <= own.max(known).saturating_mul(2).max(FIRST)
        };
        let cost = 2.0 * self.wanted.iter().map(|counts| self.cost(counts)).sum::<f64>();
        let most = self.lit() * self.job.samples.len() as f64;
        cost <= 2.0 * most && (0..4).all(|pair| (0..self.tiles.len()).all(|i| near(pair, i)))
    }

    /// The shares of the present round.
    fn shares(&self) -> (Vec<Place>, Vec<Share>) {
        let seed = hash(self.job.seed);
        let mut shares = (Vec::new(), Vec::new());
        for (i, &tile) in self.tiles.iter().enumerate() {
            for quarter in 0..8 {
                let taken = self.pairs[quarter / 2].counts[i];
                let [first, end] = [taken, self.wanted[quarter / 2][i]]
                    .map(|n| self.job.samples.start.saturating_add(n));
                if first < end {
                    let seed = hash(seed ^ (quarter as u32 + 1).wrapping_mul(0x9e37_79b9));
                    shares.0.push((i, quarter));
                    shares.1.push(Share { tile, samples: first..end, seed });
                }
            }
        }
        shares
    }

    /// Takes samples until the pairs have the counts of this round, and ghosts of as many samples
    /// as pixels have taken in the mean.
    fn go<R: Real<Scalar = f32>>(&mut self, crew: &Crew) {
        let (places, shares) = self.shares();
        self.ledger.open(shares.len());
        crew.expose::<R>(&shares, self);
        let Some(received) = self.ledger.settle() else { return };
        for (pair, counts) in self.pairs.iter_mut().zip(&self.wanted) {
            pair.count(&self.tiles, counts);
        }
        for ((i, quarter), (sums, features)) in places.into_iter().zip(received) {
            self.pairs[quarter / 2].quarters[quarter % 2][i].add(&sums);
            if let (Some(all), Some(features)) = (&mut self.features[i], features) {
                all.add(&features);
            }
        }
        let mean = (self.taken() / self.lit().max(1.0)) as u32;
        crew.haunt::<R>(self, mean);
    }

    /// The picture, its layers, and how good it is.
    fn finish(self, stats: Stats) -> Exposed {
        let frame = self.job.frame;
        let mut means = vec![[0.0; 3]; frame.size().map(|n| n as usize).iter().product()];
        let mut variances = vec![[0.0; 3]; means.len()];
        let [one, other, ..] = &self.pairs;
        let floor = [one, other].map(|pair| pair.luminance(self.whole())).iter().sum::<f64>() / 2.0;
        let mut error = 0.0;
        for (i, tile) in self.tiles.iter().enumerate() {
            let pixel = |([a, b], [c, d]): ([[f64; 3]; 2], [[f64; 3]; 2])| {
                let mean = [0, 1, 2].map(|k| (a[k] + b[k] + c[k] + d[k]) / 4.0);
                let variance = |a: f64, b: f64| (a - b).powi(2) / 16.0;
                let [p, q, r, s] = [a, b, c, d].map(luminance);
                let both = variance(p, q) + variance(r, s);
                error += relative(both, luminance(mean), FLOOR * floor);
                (mean, [0, 1, 2].map(|k| single(variance(a[k], b[k]) + variance(c[k], d[k]))))
            };
            let (mean, variance): (Vec<_>, Vec<_>) =
                one.means(i).zip(other.means(i)).map(pixel).unzip();
            tile.paste(&frame, &mean, &mut means);
            tile.paste(&frame, &variance, &mut variances);
        }
        let mut film = FilmSums::settled(frame, means, variances);
        self.haunt.put_mean(&mut film);
        let quarters = self.pairs.iter().flat_map(|pair| &pair.quarters).flatten();
        quarters.for_each(|sums| film.dropped.add(&sums.dropped));
        let count = |i| 2 * self.pairs.iter().map(|pair| pair.counts[i]).sum::<u32>();
        let counts = || (0..self.tiles.len()).map(count);
        let reached = Reached {
            noise: (error / self.whole()).sqrt(),
            mean: self.taken() / self.lit().max(1.0),
            least: counts().min().unwrap_or(0),
            most: counts().max().unwrap_or(0),
        };
        let features = self.features();
        Exposed { film, features, stats, reached: Some(reached), partial: None }
    }

    /// What there is of the picture: all samples of a pixel alike.
    fn partial(self, stats: Stats) -> Exposed {
        let (places, shares) = self.shares();
        let mut film = FilmSums::new(self.job.frame, false);
        let mut features = self.features();
        let mut samples = vec![0; self.tiles.len()];
        for (tile, place) in self.tiles.iter().enumerate() {
            for pair in &self.pairs[..2] {
                samples[tile] += 2 * pair.counts[tile];
                pair.quarters.iter().for_each(|quarter| film.add_tile(place, &quarter[tile]));
            }
        }
        for (i, (sums, met)) in self.ledger.done().filter(|(i, _)| places[*i].1 < 4) {
            let Share { tile, samples: taken, .. } = &shares[i];
            samples[places[i].0] += taken.len() as u32;
            film.add_tile(tile, sums);
            if let (Some(features), Some(met)) = (&mut features, met) {
                features.add(tile, met);
            }
        }
        partial::exposed(&self.tiles, &samples, (film, features), &self.haunt, stats)
    }

    /// What the paths of all tiles met.
    fn features(&self) -> Option<FeatureFilm> {
        let mut features = FeatureFilm::new(self.job);
        for (tile, own) in self.tiles.iter().zip(&self.features) {
            if let (Some(all), Some(own)) = (&mut features, own) {
                all.add(tile, own);
            }
        }
        features
    }
}

impl Keep for Rounds<'_> {
    fn has(&self, share: usize) -> bool {
        self.ledger.has(share)
    }

    fn enter(&self, share: usize, received: Received) {
        self.ledger.enter(share, received);
    }

    fn haunt(&mut self) -> &mut Haunt {
        &mut self.haunt
    }

    fn save(&self, to: &mut Writer) -> io::Result<()> {
        to.u64(self.start.elapsed().as_nanos() as u64)?;
        let counts = self.pairs.iter().map(|pair| &pair.counts).chain(&self.wanted);
        counts.flatten().try_for_each(|&count| to.u32(count))?;
        let quarters = self.pairs.iter().flat_map(|pair| &pair.quarters).flatten();
        quarters.into_iter().try_for_each(|sums| sums.save(to))?;
        self.features.iter().flatten().try_for_each(|features| features.save(to))?;
        self.haunt.save(to)?;
        self.ledger.save(to)
    }

    fn receive(&mut self, from: &mut Reader) -> io::Result<()> {
        let earlier = Duration::from_nanos(from.u64()?);
        self.start = self.start.checked_sub(earlier).unwrap_or(self.start);
        let mut count = || from.below(MOST, "samples").map(|count| count as u32);
        for pair in &mut self.pairs {
            let counts = pair.counts.iter().map(|_| count()).collect::<io::Result<Vec<u32>>>()?;
            pair.count(&self.tiles, &counts);
        }
        for wanted in self.wanted.iter_mut().flatten() {
            *wanted = count()?;
        }
        if !self.sane() {
            return Err(wrong("it is damaged: its counts of samples are none of this render"));
        }
        let quarters = self.pairs.iter_mut().flat_map(|pair| &mut pair.quarters).flatten();
        quarters.into_iter().try_for_each(|sums| sums.receive(from))?;
        self.features.iter_mut().flatten().try_for_each(|features| features.receive(from))?;
        self.haunt.receive(from)?;
        let (_, shares) = self.shares();
        self.ledger.receive(from, self.job, &shares)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_come_near_by_steps() {
        assert_eq!(step(8, 8), 8);
        assert_eq!(step(8, 5), 8);
        assert_eq!(step(8, 100), 16);
        assert_eq!(step(80, 120), 110);
        assert_eq!(step(80, 90), 90);
    }
}
