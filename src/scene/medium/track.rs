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
use super::walk::{CoefficientLanes, MediumWalk, WalkLanes, WalkStart};
use petzval_base::lanes::math::ln;
use petzval_base::lanes::{Real, Word};
use petzval_base::sampler::RandomStream;

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

    /// The medium with another field, whose extinction is at most `factor` times that of this one.
    pub(super) fn with_field(&self, field: Field, factor: f32) -> Self {
        Self { field, majorants: self.majorants.scaled(factor), ..*self }
    }

    /// Returns the memory of what [`Self::with_field`] does not share (bytes).
    pub(super) fn own_bytes(&self) -> usize {
        size_of::<Self>() + self.majorants.bytes() + self.field.table_bytes()
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
        walk: &mut MediumWalk<R>,
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
    fn majorants_at<R: Real<Scalar = f32>>(&self, walk: &MediumWalk<R>, lanes: u32) -> R {
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
        walk: &MediumWalk<R>,
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
