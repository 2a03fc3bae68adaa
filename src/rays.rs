//! The columns that flow between the stages.
//!
//! A *wave* is up to [`WAVE`] rays in structure-of-arrays columns, owned by one worker
//! and small enough to stay in its caches. Columns are aligned to a cache line:
//! unaligned ones cost 40 % of the lens stage.

use std::ops::{Deref, DerefMut};

use bytemuck::{Pod, Zeroable};

use crate::lanes::Real;
use crate::sampler::{Dimension, pair};

/// The most rays that move together: whole packets, few enough for the caches, and an odd
/// number of cache lines a column. Columns of 1024 would all begin in the same set of an
/// 8-way L1 cache and push each other out; that made the lens stage twice as slow.
pub const WAVE: usize = 1008;

/// One quantity of every ray of a wave.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Column<T, const N: usize = WAVE>([T; N]);

impl<T: Zeroable, const N: usize> Default for Column<T, N> {
    fn default() -> Self {
        Self(std::array::from_fn(|_| T::zeroed()))
    }
}

impl<T, const N: usize> Deref for Column<T, N> {
    type Target = [T; N];
    #[inline(always)]
    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl<T, const N: usize> DerefMut for Column<T, N> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.0
    }
}

impl<T: Pod, const N: usize> Column<T, N> {
    /// The packets that cover the first `rays` entries; the last one may reach past them.
    #[inline(always)]
    pub fn packets<R: Real<Scalar = T>>(&self, rays: usize) -> &[R] {
        &bytemuck::cast_slice(&self.0[..])[..packets::<R>(rays)]
    }

    /// As [`Column::packets`], to write to.
    #[inline(always)]
    pub fn packets_mut<R: Real<Scalar = T>>(&mut self, rays: usize) -> &mut [R] {
        &mut bytemuck::cast_slice_mut(&mut self.0[..])[..packets::<R>(rays)]
    }
}

/// How many packets hold this many rays.
#[inline(always)]
pub fn packets<R: Real>(rays: usize) -> usize {
    rays.div_ceil(R::LANES)
}

/// Rays inside a lens: millimetres, +z along the direction of travel.
///
/// The position is relative to the vertex of the surface last crossed, the direction is
/// scaled to the refractive index of the medium. A blocked ray has a NaN in `x`.
#[derive(Clone, Debug)]
pub struct LensBatch<T: Pod> {
    /// How many rays are in the batch. Behind them, up to a whole packet, stand blocked rays.
    pub len: usize,
    /// How many of them are not blocked from the start.
    pub living: usize,
    /// Position, mm.
    pub x: Column<T>,
    /// Position, mm.
    pub y: Column<T>,
    /// Position, mm.
    pub z: Column<T>,
    /// Direction, length = refractive index.
    pub tx: Column<T>,
    /// Direction, length = refractive index.
    pub ty: Column<T>,
    /// Direction, length = refractive index.
    pub tz: Column<T>,
    /// What the ray counts; changed only by openings of partial transmission, and by the losses of
    /// surfaces where they are asked for.
    pub weight: Column<T>,
    /// Places of the rays that this precision could not trace exactly enough.
    pub doubtful: Vec<u32>,
}

impl<T: Pod> Default for LensBatch<T> {
    fn default() -> Self {
        let [x, y, z, tx, ty, tz, weight] = std::array::from_fn(|_| Column::default());
        // No ray is noted twice, so nothing is allocated inside a wave.
        let doubtful = Vec::with_capacity(WAVE);
        Self { len: 0, living: 0, x, y, z, tx, ty, tz, weight, doubtful }
    }
}

impl<T: Pod> LensBatch<T> {
    /// Sets the number of rays, none of them blocked, and blocks the lanes behind them up to a whole packet.
    pub fn resize<R: Real<Scalar = T>>(&mut self, rays: usize) {
        (self.len, self.living) = (rays, rays);
        for i in rays..rays.next_multiple_of(R::LANES) {
            self.x[i] = R::scalar(f64::NAN);
        }
    }
}

impl LensBatch<f32> {
    /// What its rays that are not blocked count together.
    pub fn light(&self) -> f64 {
        let living = (0..self.len).filter(|&i| !self.x[i].is_nan());
        living.map(|i| f64::from(self.weight[i])).sum()
    }
}

/// What the film stage asks of the camera: one sample per entry.
#[derive(Clone, Debug, Default)]
pub struct SampleBatch {
    /// How many samples are in the batch.
    pub len: usize,
    /// Index of the pixel in its tile.
    pub pixel: Column<u32>,
    /// Key of the pixel's random numbers.
    pub key: Column<u32>,
    /// Index of the sample in its pixel.
    pub sample: Column<u32>,
    /// Seed of the random numbers of all of them.
    pub seed: u32,
    /// Point on the film, in the film's units (mm for a real lens), camera frame: x to the
    /// right and y up as seen from behind the camera; the picture on it is upside down.
    pub film: [Column<f32>; 2],
    /// The same from the middle of its pixel, in pixels, to the right and down in the picture; told
    /// only where a lens takes the light apart.
    pub offset: [Column<f32>; 2],
    /// What the sample counts for its pixel, where the filter is signed.
    pub weight: Column<f32>,
    /// Which part of the light all of them are, where a lens takes it apart.
    pub band: usize,
    /// Two numbers in [0, 1) that choose a point of the pupil.
    pub pupil: [Column<f32>; 2],
    /// When, as a share of the motion that the scene file describes; told only where something
    /// moves ([`crate::shutter::Timing`]).
    pub time: Column<f32>,
}

impl SampleBatch {
    /// Spreads its samples evenly over a film of this half width and height and over the pupil; another
    /// wave of them has other places.
    pub fn spread(&mut self, half: [f64; 2], wave: usize) {
        for i in 0..self.len {
            let of = |dimension| pair(0, (wave * WAVE + i) as u32, dimension);
            let (point, pupil) = (of(Dimension::Film), of(Dimension::Pupil));
            for axis in 0..2 {
                let place = (2.0 * f64::from(point[axis]) - 1.0) * half[axis];
                (self.film[axis][i], self.pupil[axis][i]) = (place as f32, pupil[axis]);
            }
        }
    }
}

/// Where the light of a wave's rays would come to the film if it were of another band.
#[derive(Clone, Debug, Default)]
pub struct LandingBatch {
    /// Point on the film, as that of [`SampleBatch`].
    pub film: [Column<f32>; 2],
    /// What the lens lets through of it; 0 where it does not come to the film.
    pub share: Column<f32>,
}

/// Rays in world space, with what they carry back to the film.
#[derive(Clone, Debug, Default)]
pub struct RayBatch {
    /// How many rays are in the batch.
    pub len: usize,
    /// Origin, world units.
    pub origin: [Column<f32>; 3],
    /// Direction, of unit length for camera rays and bounces; for shadow rays it reaches
    /// to the light at t = 1 (or is unit with an infinite `t_max`).
    pub direction: [Column<f32>; 3],
    /// Where the ray ends, in multiples of its direction.
    pub t_max: Column<f32>,
    /// RGB throughput of a path, or the radiance that a shadow ray brings if nothing is
    /// in its way.
    pub carried: [Column<f32>; 3],
    /// The place of the ray's sample in its wave.
    pub slot: Column<u32>,
    /// For bounces: the density, by solid angle, with which the direction was chosen; infinite
    /// where nothing else could have chosen it.
    pub density: Column<f32>,
    /// For bounces: scales the throughput for Russian roulette. It divides by the throughput of the
    /// camera ray, and takes back what refraction does to radiance.
    pub roulette_scale: Column<f32>,
    /// For bounces: the rays beside it, in scenes that look textures up over an area.
    pub differential: Column<RayDifferential>,
}

/// How the rays of the two samples beside a sample differ from its own (Igehy 1999, "Tracing ray
/// differentials"), world space; all zero where that is not known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct RayDifferential {
    /// Their origins less its own: for a step to the side in the picture, and for one up.
    pub origin: [[f32; 3]; 2],
    /// Their directions less its own.
    pub direction: [[f32; 3]; 2],
}

impl RayDifferential {
    /// No differential is known.
    pub const UNKNOWN: Self = Self { origin: [[0.0; 3]; 2], direction: [[0.0; 3]; 2] };
}

impl RayBatch {
    /// Adds one ray behind the others.
    #[inline(always)]
    pub fn push(&mut self, ray: Ray, carried: [f32; 3], slot: u32) {
        let i = self.len;
        for axis in 0..3 {
            self.origin[axis][i] = ray.origin[axis];
            self.direction[axis][i] = ray.direction[axis];
            self.carried[axis][i] = carried[axis];
        }
        self.t_max[i] = ray.t_max;
        self.slot[i] = slot;
        self.len = i + 1;
    }

    /// The i-th ray.
    #[inline(always)]
    pub fn ray(&self, i: usize) -> Ray {
        Ray {
            origin: [self.origin[0][i], self.origin[1][i], self.origin[2][i]],
            direction: [self.direction[0][i], self.direction[1][i], self.direction[2][i]],
            t_max: self.t_max[i],
        }
    }

    /// What the i-th ray carries.
    #[inline(always)]
    pub fn carried(&self, i: usize) -> [f32; 3] {
        [self.carried[0][i], self.carried[1][i], self.carried[2][i]]
    }
}

/// One ray in world space: the points `origin + t * direction`, 0 < t < `t_max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts, world units.
    pub origin: [f32; 3],
    /// Where it goes.
    pub direction: [f32; 3],
    /// Where it ends, in multiples of the direction.
    pub t_max: f32,
}

/// `Hit::shape` and `Hit::instance` of what is not there.
pub const NONE: u32 = u32::MAX;

/// The nearest surface a ray meets.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Hit {
    /// Distance in multiples of the ray's direction.
    pub t: f32,
    /// Barycentric weight of the triangle's second vertex.
    pub u: f32,
    /// Barycentric weight of the triangle's third vertex.
    pub v: f32,
    /// Index into the scene's shapes, or [`NONE`].
    pub shape: u32,
    /// Which triangle of the shape.
    pub primitive: u32,
    /// Index into the scene's instances, or [`NONE`] for what stands in the world itself. Those
    /// that move come after those that stand still.
    pub instance: u32,
    /// When, as a share of the motion; 0 where it stands still.
    pub time: f32,
}

impl Hit {
    /// Nothing was met.
    pub const MISS: Self = Self {
        t: f32::INFINITY,
        u: 0.0,
        v: 0.0,
        shape: NONE,
        primitive: NONE,
        instance: NONE,
        time: 0.0,
    };
}

/// What the rays of a [`RayBatch`] meet, in the same order.
#[derive(Clone, Debug)]
pub struct HitBatch(Box<[Hit; WAVE]>);

impl Default for HitBatch {
    fn default() -> Self {
        Self(Box::new([Hit::MISS; WAVE]))
    }
}

impl Deref for HitBatch {
    type Target = [Hit; WAVE];
    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl DerefMut for HitBatch {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.0
    }
}
