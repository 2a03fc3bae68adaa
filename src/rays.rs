//! Batches of rays, samples and hits that flow between the stages.
//!
//! A *wave* is up to [`WAVE_SIZE`] rays in structure-of-arrays columns, owned by one worker and
//! small enough to stay in its caches. Columns are aligned to a cache line: unaligned columns make
//! the lens stage 40 % slower.

use std::ops::{Deref, DerefMut};

use bytemuck::{Pod, Zeroable};

use crate::lanes::Real;
use crate::sampler::{Dimension, sample_2d};

/// Largest number of rays in a wave. It is a multiple of the lanes, small enough for the caches,
/// and makes a column an odd number of cache lines: columns of 1024 all begin in the same set of an
/// 8-way L1 cache and evict each other, which made the lens stage twice as slow.
pub const WAVE_SIZE: usize = 1008;

/// One quantity of every ray of a wave.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Column<T, const N: usize = WAVE_SIZE>([T; N]);

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
    /// Returns the packets that cover the first `rays` entries; the last one may extend past them.
    #[inline(always)]
    pub fn packets<R: Real<Scalar = T>>(&self, rays: usize) -> &[R] {
        &bytemuck::cast_slice(&self.0[..])[..packet_count::<R>(rays)]
    }

    /// Returns the same packets as [`Column::packets`] for writing.
    #[inline(always)]
    pub fn packets_mut<R: Real<Scalar = T>>(&mut self, rays: usize) -> &mut [R] {
        &mut bytemuck::cast_slice_mut(&mut self.0[..])[..packet_count::<R>(rays)]
    }
}

/// Returns the number of packets that hold this many rays.
#[inline(always)]
pub fn packet_count<R: Real>(rays: usize) -> usize {
    rays.div_ceil(R::LANES)
}

/// Rays inside a lens; +z is the direction of travel. A blocked ray has a NaN in `x`.
#[derive(Clone, Debug)]
pub struct LensBatch<T: Pod> {
    /// Number of rays. Blocked rays pad the last packet behind them.
    pub len: usize,
    /// Number of rays that are not blocked at the start.
    pub live: usize,
    /// Position relative to the vertex of the surface last crossed, x (mm).
    pub x: Column<T>,
    /// Position, y (mm).
    pub y: Column<T>,
    /// Position, z (mm).
    pub z: Column<T>,
    /// Optical direction cosine (unit direction times refractive index), x.
    pub tx: Column<T>,
    /// Optical direction cosine, y.
    pub ty: Column<T>,
    /// Optical direction cosine, z.
    pub tz: Column<T>,
    /// Weight; changed only by apertures of partial transmission and, if losses are simulated, by
    /// surfaces.
    pub weight: Column<T>,
    /// Indices of the rays that this precision cannot trace exactly enough.
    pub needs_f64: Vec<u32>,
}

impl<T: Pod> Default for LensBatch<T> {
    fn default() -> Self {
        let [x, y, z, tx, ty, tz, weight] = std::array::from_fn(|_| Column::default());
        // No ray is listed twice, so nothing is allocated inside a wave.
        let needs_f64 = Vec::with_capacity(WAVE_SIZE);
        Self { len: 0, live: 0, x, y, z, tx, ty, tz, weight, needs_f64 }
    }
}

impl<T: Pod> LensBatch<T> {
    /// Sets the number of rays, none of them blocked, and blocks the lanes behind them up to a
    /// whole packet.
    pub fn resize<R: Real<Scalar = T>>(&mut self, rays: usize) {
        (self.len, self.live) = (rays, rays);
        for i in rays..rays.next_multiple_of(R::LANES) {
            self.x[i] = R::from_f64(f64::NAN);
        }
    }
}

impl LensBatch<f32> {
    /// Returns the sum of the weights of rays that are not blocked.
    pub fn total_weight(&self) -> f64 {
        let living = (0..self.len).filter(|&i| !self.x[i].is_nan());
        living.map(|i| f64::from(self.weight[i])).sum()
    }
}

/// Samples of the film stage for the camera, one per entry.
#[derive(Clone, Debug, Default)]
pub struct SampleBatch {
    /// Number of samples.
    pub len: usize,
    /// Index of the pixel in its tile.
    pub pixel: Column<u32>,
    /// Key of the pixel's random numbers.
    pub key: Column<u32>,
    /// Index of the sample in its pixel.
    pub sample: Column<u32>,
    /// Seed of the random numbers.
    pub seed: u32,
    /// Point on the film [units of the film; mm for a real lens], x to the right and y up as seen
    /// from behind the camera. The image on the film is upside down.
    pub film: [Column<f32>; 2],
    /// The same point relative to the centre of its pixel, to the right and down in the picture
    /// (pixels); set only if the lens disperses light.
    pub offset: [Column<f32>; 2],
    /// Weight of the sample in its pixel; set only if the filter has negative lobes.
    pub weight: Column<f32>,
    /// Spectral band of all samples, if the lens disperses light.
    pub band: usize,
    /// Two numbers in [0, 1) that select a point of the pupil.
    pub pupil: [Column<f32>; 2],
    /// Time as a fraction of the motion in the scene file; set only if something moves
    /// ([`crate::shutter::Timing`]).
    pub time: Column<f32>,
}

impl SampleBatch {
    /// Distributes the samples evenly over a film of this half width and half height and over the
    /// pupil. Different waves get different points.
    pub fn fill_evenly(&mut self, half: [f64; 2], wave: usize) {
        for i in 0..self.len {
            let numbers = |dimension| sample_2d(0, (wave * WAVE_SIZE + i) as u32, dimension);
            let (point, pupil) = (numbers(Dimension::Film), numbers(Dimension::Pupil));
            for axis in 0..2 {
                let film = (2.0 * f64::from(point[axis]) - 1.0) * half[axis];
                (self.film[axis][i], self.pupil[axis][i]) = (film as f32, pupil[axis]);
            }
        }
    }
}

/// Points at which the light of a wave would meet the film if it were of another spectral band.
#[derive(Clone, Debug, Default)]
pub struct ReprojectionBatch {
    /// Point on the film, as in [`SampleBatch`].
    pub film: [Column<f32>; 2],
    /// Transmission of the lens; 0 if the light does not reach the film.
    pub transmission: Column<f32>,
}

/// Rays in world space, with their throughput.
#[derive(Clone, Debug, Default)]
pub struct RayBatch {
    /// Number of rays.
    pub len: usize,
    /// Origin [world units].
    pub origin: [Column<f32>; 3],
    /// Direction. It has unit length for camera rays and bounces; for shadow rays it reaches to the
    /// light at t = 1, or has unit length and an infinite `t_max`.
    pub direction: [Column<f32>; 3],
    /// End of the ray, in multiples of its direction.
    pub t_max: Column<f32>,
    /// RGB throughput of a path; for shadow rays the contribution if they are unoccluded.
    pub throughput: [Column<f32>; 3],
    /// Index of the sample of the ray in its wave.
    pub slot: Column<u32>,
    /// For bounces: the density of the direction by solid angle [1/sr]; infinite if no other
    /// technique could have sampled it.
    pub pdf: Column<f32>,
    /// For bounces: factor of the throughput for Russian roulette. It divides by the throughput of
    /// the camera ray and undoes the change of radiance by refraction.
    pub roulette_scale: Column<f32>,
    /// For bounces: the ray differential, in scenes with filtered textures.
    pub differential: Column<RayDifferential>,
}

/// Differences of the rays of two neighbouring samples to a ray (Igehy 1999, "Tracing ray
/// differentials"), in world space; all zero if unknown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct RayDifferential {
    /// Differences of the origins, for a horizontal and for a vertical step in the picture.
    pub origin: [[f32; 3]; 2],
    /// Differences of the directions.
    pub direction: [[f32; 3]; 2],
}

impl RayDifferential {
    /// The unknown differential.
    pub const UNKNOWN: Self = Self { origin: [[0.0; 3]; 2], direction: [[0.0; 3]; 2] };
}

impl RayBatch {
    /// Appends a ray.
    #[inline(always)]
    pub fn push(&mut self, ray: Ray, throughput: [f32; 3], slot: u32) {
        let i = self.len;
        for axis in 0..3 {
            self.origin[axis][i] = ray.origin[axis];
            self.direction[axis][i] = ray.direction[axis];
            self.throughput[axis][i] = throughput[axis];
        }
        self.t_max[i] = ray.t_max;
        self.slot[i] = slot;
        self.len = i + 1;
    }

    /// Returns ray `i`.
    #[inline(always)]
    pub fn ray(&self, i: usize) -> Ray {
        Ray {
            origin: [self.origin[0][i], self.origin[1][i], self.origin[2][i]],
            direction: [self.direction[0][i], self.direction[1][i], self.direction[2][i]],
            t_max: self.t_max[i],
        }
    }

    /// Returns the throughput of ray `i`.
    #[inline(always)]
    pub fn throughput(&self, i: usize) -> [f32; 3] {
        [self.throughput[0][i], self.throughput[1][i], self.throughput[2][i]]
    }
}

/// One ray in world space: the points `origin + t * direction`, 0 < t < `t_max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Origin [world units].
    pub origin: [f32; 3],
    /// Direction.
    pub direction: [f32; 3],
    /// End, in multiples of the direction.
    pub t_max: f32,
}

/// [`Hit::shape`] of a miss, and [`Hit::instance`] of a shape that is not instanced.
pub const NO_INDEX: u32 = u32::MAX;

/// Nearest intersection of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Hit {
    /// Distance in multiples of the direction of the ray.
    pub t: f32,
    /// Barycentric weight of the second vertex of the triangle.
    pub u: f32,
    /// Barycentric weight of the third vertex of the triangle.
    pub v: f32,
    /// Index of the shape in the scene, or [`NO_INDEX`].
    pub shape: u32,
    /// Index of the triangle in the shape.
    pub primitive: u32,
    /// Index of the instance in the scene, or [`NO_INDEX`] for a shape that is not instanced.
    /// Moving instances follow static ones.
    pub instance: u32,
    /// Time as a fraction of the motion; 0 for static shapes.
    pub time: f32,
}

impl Hit {
    /// No intersection.
    pub const MISS: Self = Self {
        t: f32::INFINITY,
        u: 0.0,
        v: 0.0,
        shape: NO_INDEX,
        primitive: NO_INDEX,
        instance: NO_INDEX,
        time: 0.0,
    };
}

/// Hits of the rays of a [`RayBatch`], in the same order.
#[derive(Clone, Debug)]
pub struct HitBatch(Box<[Hit; WAVE_SIZE]>);

impl Default for HitBatch {
    fn default() -> Self {
        Self(Box::new([Hit::MISS; WAVE_SIZE]))
    }
}

impl Deref for HitBatch {
    type Target = [Hit; WAVE_SIZE];
    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl DerefMut for HitBatch {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.0
    }
}
