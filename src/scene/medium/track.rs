//! Tracking of rays through media that vary: tentative collisions below a majorant, over lanes.
//!
//! Paths scatter by spectral tracking: one majorant for all channels, and a choice between a
//! collision and none that depends on the throughput (Kutz, Habel, Li & Novak 2017, "Spectral and
//! decomposition tracking for rendering heterogeneous volumes", section 5.1). Shadow rays multiply
//! the probabilities that tentative collisions are none (ratio tracking; Novak, Selle & Jarosz 2014,
//! "Residual ratio tracking", section 3). Majorants are constant in the cells of a grid, which rays
//! cross one after the other (Amanatides & Woo 1987).

use glam::{Affine3A, DAffine3, DVec3, Vec3};

use super::field::{Coefficients, Field};
use super::majorant::MajorantGrid;
use crate::lanes::math::ln;
use crate::lanes::{Real, Word};
use crate::sampler::RandomStream;

/// A medium that varies inside a box.
#[derive(Clone, Debug)]
pub struct VaryingMedium {
    /// Coefficients in the unit cube.
    pub(super) field: Field,
    majorants: MajorantGrid,
    /// World space to the coordinates of the majorants' cells.
    cell_from_world: Affine3A,
}

/// A ray's way through a medium.
#[derive(Clone, Copy, Debug)]
pub(super) struct Way {
    pub(super) origin: [f32; 3],
    pub(super) direction: [f32; 3],
    /// Start and end, in multiples of the direction.
    pub(super) range: [f32; 2],
    /// Throughput at the start.
    pub(super) throughput: [f32; 3],
    /// Seed of its random numbers.
    pub(super) seed: u32,
}

/// End of a way.
#[derive(Clone, Copy, Debug)]
pub(super) struct WayEnd {
    /// Multiple of the direction at which the ray scatters; `None` if it does not.
    pub(super) scatters: Option<f32>,
    /// Throughput there, or at the end of the way.
    pub(super) throughput: [f32; 3],
    /// Radiance that the way contributes.
    pub(super) emitted: [f32; 3],
}

impl VaryingMedium {
    /// The medium of a field; the transform maps world space to its unit cube. Returns `None` if the
    /// transform has no inverse.
    pub fn new(field: Field, unit_from_world: &DAffine3) -> Option<Self> {
        let majorants = MajorantGrid::new(&field);
        let cells = DVec3::from(majorants.resolution.map(f64::from));
        let cell_from_world = DAffine3::from_scale(cells) * *unit_from_world;
        let usable = cell_from_world.is_finite() && cell_from_world.inverse().is_finite();
        let cell_from_world = cell_from_world.as_affine3a();
        usable.then_some(Self { field, majorants, cell_from_world })
    }

    /// Returns its memory (bytes).
    pub fn bytes(&self) -> usize {
        size_of::<Self>() + self.field.bytes() + self.majorants.bytes()
    }

    /// Follows rays through the medium. Calls `next` for the ways, one after the other, and `finish`
    /// with the number and the end of each. With `SHADOW`, no ray scatters.
    ///
    /// The lane of a ray that has ended takes the next way at once. What happens to a ray does not
    /// depend on the others.
    pub(super) fn track<R: Real<Scalar = f32>, const SHADOW: bool>(
        &self,
        ways: usize,
        next: impl Fn(usize) -> Way,
        mut finish: impl FnMut(usize, WayEnd),
    ) {
        let mut lanes = WalkLanes::default();
        let (mut taken, mut busy) = (0, 0u32);
        loop {
            for lane in 0..R::LANES {
                while busy >> lane & 1 == 0 && taken < ways {
                    let way = next(taken);
                    match self.start(&way) {
                        Some(walk) => {
                            lanes.set(lane, taken, &way, &walk);
                            busy |= 1 << lane;
                        }
                        None => {
                            let (throughput, emitted) = (way.throughput, [0.0; 3]);
                            finish(taken, WayEnd { scatters: None, throughput, emitted });
                        }
                    }
                    taken += 1;
                }
            }
            if busy == 0 {
                return;
            }
            let mut walk = lanes.load::<R>();
            let (ended, scattered) = loop {
                let (ended, scattered) = self.step::<R, SHADOW>(&mut walk, busy);
                if ended != 0 {
                    break (ended, scattered);
                }
            };
            lanes.store(&walk);
            for lane in (0..R::LANES).filter(|lane| ended >> lane & 1 == 1) {
                finish(lanes.way[lane], lanes.end(lane, scattered >> lane & 1 == 1));
            }
            busy &= !ended;
        }
    }

    /// Returns the state at the point where a ray enters the box, or `None` if it passes by.
    fn start(&self, way: &Way) -> Option<WalkStart> {
        let origin = self.cell_from_world.transform_point3(Vec3::from(way.origin));
        let direction = self.cell_from_world.transform_vector3(Vec3::from(way.direction));
        let size = Vec3::from(self.majorants.resolution.map(|n| n as f32));
        let inverse = direction.recip();
        let (near, far) = ((Vec3::ZERO - origin) * inverse, (size - origin) * inverse);
        let [start, end] = way.range;
        // A ray in the plane of a face has NaN there, which min and max leave out.
        let enter = near.min(far).to_array().into_iter().fold(start, f32::max);
        let exit = near.max(far).to_array().into_iter().fold(end, f32::min);
        let entry = origin + enter * direction;
        if !(enter < exit && entry.is_finite()) {
            return None;
        }
        let cell = entry.floor().clamp(Vec3::ZERO, size - 1.0);
        let ahead = Vec3::select(direction.cmpgt(Vec3::ZERO), Vec3::ONE, Vec3::ZERO);
        let to_next = |axis: usize| match direction[axis] {
            0.0 => f32::INFINITY,
            _ => (cell[axis] + ahead[axis] - origin[axis]) * inverse[axis],
        };
        Some(WalkStart {
            origin: origin.into(),
            direction: direction.into(),
            speed: Vec3::from(way.direction).length(),
            range: [enter, exit],
            cell: cell.into(),
            next: [to_next(0), to_next(1), to_next(2)],
            delta: direction.abs().recip().into(),
            majorant: self.majorants.at(cell.into()),
        })
    }

    /// Moves every ray to its next tentative collision or to the next cell, whichever comes first.
    /// Returns the lanes whose ways end, and those of them whose rays scatter.
    #[inline(always)]
    fn step<R: Real<Scalar = f32>, const SHADOW: bool>(
        &self,
        walk: &mut Walk<R>,
        busy: u32,
    ) -> (u32, u32) {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let random = RandomStream::<R>::resumed(walk.random);
        walk.random = walk.random.wrapping_add(R::Word::splat(0x6c8e_9cf5));
        let [free_path, choice] = random.pair(0);
        let [x, y, z] = walk.next;
        let border = x.min(y.min(z));
        let exit = border.min(walk.end);
        let rate = walk.majorant * walk.speed;
        let depth = rate * (exit - walk.t).max(zero);
        let collides = walk.depth.lt(depth);
        let ends = walk.end.le(border) & !collides;
        walk.t = R::select(collides, walk.t + walk.depth / rate, exit);
        walk.depth = R::select(collides, -ln(one - free_path), walk.depth - depth);
        let colliding = R::bits(collides) & busy;
        let crossing = R::bits(!(collides | ends)) & busy;
        if crossing != 0 {
            // Of axes whose borders are equally near, the ray crosses the first now.
            let in_x = x.le(y) & x.le(z);
            let in_y = !in_x & y.le(z);
            let in_z = !(in_x | in_y);
            for (axis, crosses) in [in_x, in_y, in_z].into_iter().enumerate() {
                let crosses = crosses & !(collides | ends);
                let step = R::select(walk.direction[axis].lt(zero), -one, one);
                walk.cell[axis] = walk.cell[axis] + R::select(crosses, step, zero);
                walk.next[axis] = walk.next[axis] + R::select(crosses, walk.delta[axis], zero);
            }
            walk.majorant = self.majorants_at(walk, crossing);
        }
        if colliding == 0 {
            return (R::bits(ends) & busy, 0);
        }
        let at = self.coefficients(walk, colliding);
        let scatters = match SHADOW {
            true => walk.attenuate(&at, choice, collides),
            false => walk.collide(&at, choice, collides),
        };
        let [r, g, b] = walk.throughput;
        let dark = !zero.lt(r.max(g.max(b.max(zero))));
        let (scattered, dark) = (R::bits(scatters) & colliding, R::bits(dark) & colliding);
        ((R::bits(ends) & busy) | scattered | dark, scattered)
    }

    /// Returns the majorants of the cells of lanes, given as bits; others keep theirs.
    #[inline(always)]
    fn majorants_at<R: Real<Scalar = f32>>(&self, walk: &Walk<R>, lanes: u32) -> R {
        let (mut cells, mut majorants) = ([[0.0; 8]; 3], [0.0; 8]);
        for axis in 0..3 {
            walk.cell[axis].store(&mut cells[axis]);
        }
        walk.majorant.store(&mut majorants);
        let mut rest = lanes;
        while rest != 0 {
            let lane = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            majorants[lane] = self.majorants.at([cells[0][lane], cells[1][lane], cells[2][lane]]);
        }
        R::load(&majorants)
    }

    /// Returns the coefficients where the rays of lanes are, given as bits.
    #[inline(always)]
    fn coefficients<R: Real<Scalar = f32>>(
        &self,
        walk: &Walk<R>,
        lanes: u32,
    ) -> CoefficientLanes<R> {
        let (mut points, mut found) = ([[0.0; 8]; 3], [[[0.0; 8]; 3]; 3]);
        for axis in 0..3 {
            let cells = R::splat(self.majorants.resolution[axis] as f32);
            let at = walk.direction[axis].mul_add(walk.t, walk.origin[axis]) / cells;
            at.store(&mut points[axis]);
        }
        let mut rest = lanes;
        while rest != 0 {
            let lane = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            let point = Vec3::new(points[0][lane], points[1][lane], points[2][lane]);
            let Coefficients { absorption, scattering, emission } = self.field.at(point);
            for channel in 0..3 {
                found[0][channel][lane] = absorption[channel];
                found[1][channel][lane] = scattering[channel];
                found[2][channel][lane] = emission[channel];
            }
        }
        let load = |quantity: usize| {
            let [r, g, b] = &found[quantity];
            [R::load(r), R::load(g), R::load(b)]
        };
        CoefficientLanes { absorption: load(0), scattering: load(1), emission: load(2) }
    }
}

/// State of a ray where it enters the box.
struct WalkStart {
    origin: [f32; 3],
    direction: [f32; 3],
    speed: f32,
    range: [f32; 2],
    cell: [f32; 3],
    next: [f32; 3],
    delta: [f32; 3],
    majorant: f32,
}

/// [`Coefficients`] lane by lane.
struct CoefficientLanes<R> {
    absorption: [R; 3],
    scattering: [R; 3],
    emission: [R; 3],
}

/// Rays inside the box, lane by lane. Points are in coordinates of cells.
struct Walk<R: Real> {
    origin: [R; 3],
    direction: [R; 3],
    /// World units per multiple of the direction.
    speed: R,
    /// Position and end, in multiples of the direction.
    t: R,
    end: R,
    /// Optical depth that is left to the next tentative collision.
    depth: R,
    cell: [R; 3],
    /// Multiples of the direction at which the ray leaves the cell, by axis.
    next: [R; 3],
    /// Multiples of the direction between the borders of cells, by axis.
    delta: [R; 3],
    /// Majorant of the cell.
    majorant: R,
    throughput: [R; 3],
    /// Radiance so far.
    emitted: [R; 3],
    /// State of the random numbers.
    random: R::Word,
}

impl<R: Real<Scalar = f32>> Walk<R> {
    /// Decides whether rays scatter in the lanes that collide, and weights them. Adds the emission.
    #[inline(always)]
    fn collide(&mut self, at: &CoefficientLanes<R>, choice: R, collides: R::Mask) -> R::Mask {
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
    fn attenuate(&mut self, at: &CoefficientLanes<R>, choice: R, collides: R::Mask) -> R::Mask {
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

/// The rays of a [`Walk`], one after the other.
#[derive(Default)]
struct WalkLanes {
    columns: [[f32; 8]; COLUMNS],
    random: [u32; 8],
    /// Number of each lane's way.
    way: [usize; 8],
}

impl WalkLanes {
    /// Puts a ray into a lane.
    fn set(&mut self, lane: usize, number: usize, way: &Way, start: &WalkStart) {
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

    fn load<R: Real<Scalar = f32>>(&self) -> Walk<R> {
        let number = |i: usize| R::load(&self.columns[i]);
        let vector = |i: usize| [number(i), number(i + 1), number(i + 2)];
        Walk {
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
    fn store<R: Real<Scalar = f32>>(&mut self, walk: &Walk<R>) {
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
    fn end(&self, lane: usize, scatters: bool) -> WayEnd {
        let vector = |i: usize| [0, 1, 2].map(|axis| self.columns[i + axis][lane]);
        WayEnd {
            scatters: scatters.then_some(self.columns[0][lane]),
            throughput: vector(11),
            emitted: vector(14),
        }
    }
}
