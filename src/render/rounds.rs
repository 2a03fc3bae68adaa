//! Rounds of samples, each where those before say that they are needed.
//!
//! Samples come in four quarters with seeds of their own; each quarter of a pixel has a mean. The
//! first two are a pair, the others another. The quarters of a pair have the same counts, so that
//! the square of their difference tells the variance without bias. How many samples a tile of one
//! pair takes, and when the pair has enough, is said by the variance in the other, and the picture
//! is the mean of both: no sample has a say in how much it counts (Rousselle, Knaus & Zwicker
//! 2012, "Adaptive rendering with non-local means filtering"). Errors of a tile's
//! pixels are added up, as those of single pixels are known badly.

use std::io;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use super::haunt::Haunt;
use super::keeper::Keep;
use super::ledger::Ledger;
use super::partial::{self, Part};
use super::spread::{Spread, cost};
use super::{Crew, Exposed, Job, Progress, Reached, RenderError, Share, Until};
use crate::aov::{FeatureFilm, Features};
use crate::checkpoint::{Reader, Saved, Writer};
use crate::film::{FilmSums, Tile, TileSums};
use crate::lanes::Real;
use crate::sampler::hash;
use crate::spectrum::xyz_from_srgb;
use crate::stats::Stats;

/// Samples of every quarter of a pixel before anything is known of it; in a hurry, one.
const FIRST: u32 = 4;
/// Samples of a quarter after which a pair that has met no light does not look on for it.
const BLIND: u32 = 64;
/// What is added to a pixel's luminance when its error is divided by it, as a share of the mean.
const FLOOR: f64 = 0.1;

/// No count is larger than this.
const MOST: usize = 1 << 29;

/// Two quarters of all samples.
struct Pair {
    /// Samples that a pixel has taken in each of the two, by tile.
    counts: Vec<u32>,
    quarters: [Vec<TileSums>; 2],
}

impl Pair {
    fn new(tiles: &[Tile]) -> Self {
        let quarter = || tiles.iter().map(|tile| TileSums::new(tile, false)).collect();
        Self { counts: vec![0; tiles.len()], quarters: [quarter(), quarter()] }
    }

    /// The means of both quarters, for each pixel of a tile.
    fn means(&self, tile: usize) -> impl Iterator<Item = [[f64; 3]; 2]> {
        let scale = 1.0 / f64::from(self.counts[tile].max(1));
        let [one, other] = self.quarters.each_ref().map(|quarter| quarter[tile].light().iter());
        one.zip(other).map(move |(one, other)| [*one, *other].map(|sum| sum.map(|s| s * scale)))
    }

    /// The mean luminance over so many pixels of the picture.
    fn luminance(&self, pixels: f64) -> f64 {
        let means = (0..self.counts.len()).flat_map(|tile| self.means(tile));
        means.map(|[one, other]| (luminance(one) + luminance(other)) / 2.0).sum::<f64>() / pixels
    }

    /// The relative variance of the pair's mean, as far as the pair alone knows, added up over
    /// the pixels of each tile, times its count: so that it does not depend on the count.
    fn variances(&self, tiles: &[Tile], floor: f64) -> Vec<f64> {
        let tile = |(i, tile): (usize, &Tile)| {
            let [one, other]: [Vec<f64>; 2] =
                [0, 1].map(|of| self.means(i).map(|means| luminance(means[of])).collect());
            let light: Vec<f64> = one.iter().zip(&other).map(|(a, b)| (a + b) / 2.0).collect();
            let light = despeckled(&light, tile.size[0] as usize);
            let errors = one.iter().zip(&other).zip(light);
            let errors =
                errors.map(|((a, b), light)| relative((a - b).powi(2) / 4.0, light, floor));
            f64::from(self.counts[i]) * errors.sum::<f64>()
        };
        tiles.iter().enumerate().map(tile).collect()
    }
}

/// No pixel brighter than the brightest of its neighbours in the tile. A single sample that
/// brings much light must not make its own error look small.
fn despeckled(light: &[f64], width: usize) -> Vec<f64> {
    let rows = light.len() / width;
    let around = |at: usize, count: usize| at.saturating_sub(1)..(at + 2).min(count);
    let pixel = |(i, &own): (usize, &f64)| {
        let (x, y) = (i % width, i / width);
        let near = around(y, rows).flat_map(|y| around(x, width).map(move |x| y * width + x));
        let brightest = near.filter(|&j| j != i).map(|j| light[j]).reduce(f64::max);
        brightest.map_or(own, |brightest| own.min(brightest))
    };
    light.iter().enumerate().map(pixel).collect()
}

fn luminance(light: [f64; 3]) -> f64 {
    xyz_from_srgb(light)[1]
}

/// A variance over the square of what it is an error of.
fn relative(variance: f64, light: f64, floor: f64) -> f64 {
    let whole = light.max(0.0) + floor;
    if whole > 0.0 { variance / (whole * whole) } else { 0.0 }
}

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
    pairs: [Pair; 2],
    features: Vec<Option<Features>>,
    /// The counts of the present round, by pair.
    wanted: [Vec<u32>; 2],
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
        Self {
            job,
            pairs: [Pair::new(&tiles), Pair::new(&tiles)],
            features: tiles.iter().map(|tile| Features::new(job, tile)).collect(),
            wanted: [(); 2].map(|()| vec![first.min(most).max(1); tiles.len()]),
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
    fn next(&self, progress: &Progress) -> [Vec<u32>; 2] {
        let most = self.lit() * self.job.samples.len() as f64 / 4.0;
        let more = self.job.until.time.map_or(f64::INFINITY, |time| {
            let gone = self.start.elapsed();
            let rate = self.taken() / gone.max(Duration::from_micros(1)).as_secs_f64();
            rate * time.saturating_sub(gone).as_secs_f64() / 4.0
        });
        let wanted = [0, 1].map(|pair| {
            let own = &self.pairs[pair].counts;
            self.wanted(own, &self.pairs[1 - pair], most.min(self.cost(own) + more))
        });
        let expected = 2.0 * wanted.iter().map(|counts| self.cost(counts)).sum::<f64>();
        progress.expected.store(expected as u64, Ordering::Relaxed);
        [0, 1].map(|pair| {
            let own = self.pairs[pair].counts.iter();
            own.zip(&wanted[pair]).map(|(&count, &wanted)| step(count, wanted)).collect()
        })
    }

    /// The counts that one pair wants, by what the other knows; `budget` is for a quarter.
    fn wanted(&self, own: &[u32], other: &Pair, budget: f64) -> Vec<u32> {
        let mean = other.luminance(self.whole());
        let variances = other.variances(&self.tiles, FLOOR * mean);
        let spread = Spread::new(&self.pixels, own, &variances);
        if mean <= 0.0 && self.cost(&other.counts) < f64::from(BLIND) * self.lit() {
            return spread.wanted(None, budget.min(2.0 * self.cost(own)));
        }
        // The errors of both pairs are halved in their mean, and their squares added up.
        let bound = self.job.until.noise.map(|noise| 2.0 * self.whole() * noise * noise);
        spread.wanted(bound, budget)
    }

    /// The shares of the present round.
    fn shares(&self) -> (Vec<Place>, Vec<Share>) {
        let seed = hash(self.job.seed);
        let mut shares = (Vec::new(), Vec::new());
        for (i, &tile) in self.tiles.iter().enumerate() {
            for quarter in 0..4 {
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
        for ((i, quarter), (sums, features)) in places.into_iter().zip(received) {
            self.pairs[quarter / 2].quarters[quarter % 2][i].add(&sums);
            if let (Some(all), Some(features)) = (&mut self.features[i], features) {
                all.add(&features);
            }
        }
        for (pair, counts) in self.pairs.iter_mut().zip(&self.wanted) {
            pair.counts.clone_from(counts);
        }
        let mean = (self.taken() / self.lit().max(1.0)) as u32;
        crew.haunt::<R>(self, mean);
    }

    /// The picture, its layers, and how good it is.
    fn finish(self, stats: Stats) -> Exposed {
        let frame = self.job.frame;
        let mut means = vec![[0.0; 3]; frame.size().map(|n| n as usize).iter().product()];
        let mut variances = vec![[0.0; 3]; means.len()];
        let floor = self.pairs.iter().map(|pair| pair.luminance(self.whole())).sum::<f64>() / 2.0;
        let mut error = 0.0;
        for (i, tile) in self.tiles.iter().enumerate() {
            let [one, other] = self.pairs.each_ref().map(|pair| pair.means(i));
            let pixel = |([a, b], [c, d]): ([[f64; 3]; 2], [[f64; 3]; 2])| {
                let mean = [0, 1, 2].map(|k| (a[k] + b[k] + c[k] + d[k]) / 4.0);
                let variance = |a: f64, b: f64| (a - b).powi(2) / 16.0;
                let [p, q, r, s] = [a, b, c, d].map(luminance);
                let both = variance(p, q) + variance(r, s);
                error += relative(both, luminance(mean), FLOOR * floor);
                (mean, [0, 1, 2].map(|k| (variance(a[k], b[k]) + variance(c[k], d[k])) as f32))
            };
            let (mean, variance): (Vec<_>, Vec<_>) = one.zip(other).map(pixel).unzip();
            tile.paste(&frame, &mean, &mut means);
            tile.paste(&frame, &variance, &mut variances);
        }
        let mut film = FilmSums::settled(frame, means, variances);
        self.haunt.put_mean(&mut film);
        let quarters = self.pairs.iter().flat_map(|pair| &pair.quarters).flatten();
        film.dropped = quarters.map(|sums| sums.dropped).sum();
        let [one, other] = self.pairs.each_ref().map(|pair| pair.counts.iter());
        let counts = || one.clone().zip(other.clone()).map(|(one, other)| 2 * (one + other));
        let reached = Reached {
            noise: (error / self.whole()).sqrt(),
            mean: self.taken() / self.lit().max(1.0),
            least: counts().min().unwrap_or(0),
            most: counts().max().unwrap_or(0),
        };
        let features = FeatureFilm::of(self.job, self.tiles.iter().zip(&self.features));
        Exposed { film, features, stats, reached: Some(reached), partial: None }
    }

    /// What there is of the picture: all samples of a pixel alike.
    fn partial(self, stats: Stats) -> Exposed {
        let (places, shares) = self.shares();
        let quarter = |tile: usize, quarter: usize| {
            let pair = &self.pairs[quarter / 2];
            // Features are those of all quarters.
            let features = self.features[tile].as_ref().filter(|_| quarter == 0);
            let sums = &pair.quarters[quarter % 2][tile];
            Part { tile, sums, features, samples: pair.counts[tile] }
        };
        let own = (0..self.tiles.len()).flat_map(|tile| (0..4).map(move |q| quarter(tile, q)));
        let present = self.ledger.done().map(|(i, (sums, features))| {
            let samples = shares[i].samples.len() as u32;
            Part { tile: places[i].0, sums, features: features.as_ref(), samples }
        });
        partial::exposed(self.job, &self.tiles, own.chain(present), &self.haunt, stats)
    }
}

impl Keep for Rounds<'_> {
    fn ledger(&self) -> &Ledger {
        &self.ledger
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
        let counts = self.pairs.iter_mut().map(|pair| &mut pair.counts).chain(&mut self.wanted);
        for count in counts.flatten() {
            *count = from.below(MOST, "samples")? as u32;
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
    fn a_speck_is_as_bright_as_its_neighbours() {
        let light = [1.0, 2.0, 3.0, 1.0, 9.0, 2.0, 4.0, 1.0];
        assert_eq!(despeckled(&light, 4), [1.0, 2.0, 3.0, 1.0, 2.0, 2.0, 3.0, 1.0]);
        assert_eq!(despeckled(&[5.0], 1), [5.0]);
    }

    #[test]
    fn counts_come_near_by_steps() {
        assert_eq!(step(8, 8), 8);
        assert_eq!(step(8, 5), 8);
        assert_eq!(step(8, 100), 16);
        assert_eq!(step(80, 120), 110);
        assert_eq!(step(80, 90), 90);
    }
}
