//! Rays inside a medium that varies, lane by lane.

use super::track::{Way, WayEnd};
use petzval_base::lanes::math::ln;
use petzval_base::lanes::{Real, Word};
use petzval_base::sampler::RandomStream;

/// State of a ray where it enters the box.
pub(super) struct WalkStart {
    pub(super) origin: [f32; 3],
    pub(super) direction: [f32; 3],
    pub(super) speed: f32,
    pub(super) range: [f32; 2],
    pub(super) cell: [f32; 3],
    pub(super) next: [f32; 3],
    pub(super) delta: [f32; 3],
    pub(super) majorant: f32,
}

/// [`Coefficients`] lane by lane.
pub(super) struct CoefficientLanes<R> {
    pub(super) absorption: [R; 3],
    pub(super) scattering: [R; 3],
    pub(super) emission: [R; 3],
}

/// Rays inside the box, lane by lane. Points are in coordinates of cells.
pub(super) struct MediumWalk<R: Real> {
    pub(super) origin: [R; 3],
    pub(super) direction: [R; 3],
    /// World units per multiple of the direction.
    pub(super) speed: R,
    /// Position and end, in multiples of the direction.
    pub(super) t: R,
    pub(super) end: R,
    /// Optical depth that is left to the next tentative collision.
    pub(super) depth: R,
    pub(super) cell: [R; 3],
    /// Multiples of the direction at which the ray leaves the cell, by axis.
    pub(super) next: [R; 3],
    /// Multiples of the direction between the borders of cells, by axis.
    pub(super) delta: [R; 3],
    /// Majorant of the cell.
    pub(super) majorant: R,
    pub(super) throughput: [R; 3],
    /// Radiance so far.
    pub(super) emitted: [R; 3],
    /// State of the random numbers.
    pub(super) random: R::Word,
}

impl<R: Real<Scalar = f32>> MediumWalk<R> {
    /// Decides whether rays scatter in the lanes that collide, and weights them. Adds the emission.
    #[inline(always)]
    pub(super) fn collide(
        &mut self,
        at: &CoefficientLanes<R>,
        choice: R,
        collides: R::Mask,
    ) -> R::Mask {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let inverse = one / self.majorant;
        let (mut real, mut all) = (zero, zero);
        let mut null = [zero; 3];
        for channel in 0..3 {
            let throughput = self.throughput[channel];
            let extinction = (at.absorption[channel] + at.scattering[channel]) * inverse;
            null[channel] = (one - extinction).max(zero);
            real = real + throughput * extinction;
            all = all + throughput;
            let emitted = throughput * at.absorption[channel] * inverse * at.emission[channel];
            self.emitted[channel] = self.emitted[channel] + R::select(collides, emitted, zero);
        }
        // Rounding may put the coefficients of a border above the majorant of the cell.
        let probability = R::select(zero.lt(all), (real / all).min(one), one);
        let scatters = choice.lt(probability);
        let none = one / (one - probability);
        let some = inverse / probability;
        for channel in 0..3 {
            let weight = R::select(scatters, at.scattering[channel] * some, null[channel] * none);
            let after = self.throughput[channel] * weight;
            self.throughput[channel] = R::select(collides, after, self.throughput[channel]);
        }
        scatters & collides
    }

    /// Multiplies the throughput of the lanes that collide by the probability that they do not, and
    /// ends most rays of a small throughput. Returns no lanes.
    #[inline(always)]
    pub(super) fn attenuate(
        &mut self,
        at: &CoefficientLanes<R>,
        choice: R,
        collides: R::Mask,
    ) -> R::Mask {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let inverse = one / self.majorant;
        let mut after = [zero; 3];
        for channel in 0..3 {
            let extinction = (at.absorption[channel] + at.scattering[channel]) * inverse;
            after[channel] = self.throughput[channel] * (one - extinction).max(zero);
        }
        // Shadow rays start with a throughput of 1.
        let left = after[0].max(after[1].max(after[2]));
        let survival = R::select(left.lt(R::splat(ROULETTE_BELOW)), R::splat(SURVIVAL), one);
        let factor = R::select(choice.lt(survival), one / survival, zero);
        for channel in 0..3 {
            let after = after[channel] * factor;
            self.throughput[channel] = R::select(collides, after, self.throughput[channel]);
        }
        zero.lt(zero)
    }
}

/// Transmittance below which shadow rays end at most tentative collisions, and the probability that
/// one does not.
const ROULETTE_BELOW: f32 = 0.05;
const SURVIVAL: f32 = 0.25;

/// Number of columns of [`WalkLanes`].
const COLUMNS: usize = 26;

/// The rays of a [`MediumWalk`], one after the other.
#[derive(Default)]
pub(super) struct WalkLanes {
    pub(super) columns: [[f32; 8]; COLUMNS],
    pub(super) random: [u32; 8],
    /// Number of each lane's way.
    pub(super) way: [usize; 8],
}

impl WalkLanes {
    /// Puts a ray into a lane.
    pub(super) fn set(&mut self, lane: usize, number: usize, way: &Way, start: &WalkStart) {
        self.way[lane] = number;
        let random = RandomStream::<f32>::new(way.seed, []);
        self.random[lane] = random.state();
        let depth = -ln(1.0 - random.substream(0).number(0));
        let [enter, exit] = start.range;
        let WalkStart { origin, direction, cell, next, delta, .. } = start;
        let numbers = [enter, depth, start.majorant, start.speed, exit];
        let vectors = [cell, next, &way.throughput, &[0.0; 3], origin, direction, delta];
        let numbers = numbers.iter().chain(vectors.into_iter().flatten());
        for (column, &number) in self.columns.iter_mut().zip(numbers) {
            column[lane] = number;
        }
    }

    pub(super) fn load<R: Real<Scalar = f32>>(&self) -> MediumWalk<R> {
        let number = |i: usize| R::load(&self.columns[i]);
        let vector = |i: usize| [number(i), number(i + 1), number(i + 2)];
        MediumWalk {
            t: number(0),
            depth: number(1),
            majorant: number(2),
            speed: number(3),
            end: number(4),
            cell: vector(5),
            next: vector(8),
            throughput: vector(11),
            emitted: vector(14),
            origin: vector(17),
            direction: vector(20),
            delta: vector(23),
            random: R::Word::load(&self.random),
        }
    }

    /// Stores what changes on the way.
    pub(super) fn store<R: Real<Scalar = f32>>(&mut self, walk: &MediumWalk<R>) {
        for (i, number) in [walk.t, walk.depth, walk.majorant].into_iter().enumerate() {
            number.store(&mut self.columns[i]);
        }
        let vectors = [(5, walk.cell), (8, walk.next), (11, walk.throughput), (14, walk.emitted)];
        for (first, vector) in vectors {
            for axis in 0..3 {
                vector[axis].store(&mut self.columns[first + axis]);
            }
        }
        walk.random.store(&mut self.random);
    }

    /// Returns the end of a lane's way.
    pub(super) fn end(&self, lane: usize, scatters: bool) -> WayEnd {
        let vector = |i: usize| [0, 1, 2].map(|axis| self.columns[i + axis][lane]);
        WayEnd {
            scatters: scatters.then_some(self.columns[0][lane]),
            throughput: vector(11),
            emitted: vector(14),
        }
    }
}
