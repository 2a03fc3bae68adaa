//! Rays in world space.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

use super::{Column, PathFlags};
use crate::lanes::Real;

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
    /// For bounces that are not [`PathFlags::SPECULAR`]: the density of the direction by solid angle
    /// [1/sr]. For camera rays, if light paths find lamp images and throughputs do not tell it: the
    /// density by etendue and area of the film.
    pub pdf: Column<f32>,
    /// For bounces: the flags of the path.
    pub flags: Column<PathFlags>,
    /// For bounces: factor of the throughput for Russian roulette. It divides by the throughput of
    /// the camera ray and undoes the change of radiance by refraction.
    pub roulette_scale: Column<f32>,
    /// For bounces: the unit normal of the surface that the ray left, on the side from which light
    /// counts; 0 if it counts from both sides.
    pub facing: [Column<f32>; 3],
    /// For bounces in scenes of which a surface chooses lights by its glossy lobe: the unit vector to
    /// where that lobe reflects light.
    pub wo: [Column<f32>; 3],
    /// The squared width alpha of that lobe, and its weight; 0 for surfaces that scatter widely.
    pub gloss: [Column<f32>; 2],
    /// In scenes with media: the index of the medium at the origin, or [`NO_INDEX`](super::NO_INDEX).
    pub medium: Column<u32>,
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

    /// Removes the rays for which `keeps` returns false. It gets the rays in their order, each with its
    /// index.
    pub fn retain(&mut self, mut keeps: impl FnMut(&Self, usize) -> bool) {
        let mut kept = 0;
        for i in 0..self.len {
            if keeps(self, i) {
                self.copy_within(i, kept);
                kept += 1;
            }
        }
        self.len = kept;
    }

    /// Copies ray `from` over ray `to`.
    fn copy_within(&mut self, from: usize, to: usize) {
        for axis in 0..3 {
            self.origin[axis][to] = self.origin[axis][from];
            self.direction[axis][to] = self.direction[axis][from];
            self.throughput[axis][to] = self.throughput[axis][from];
            self.facing[axis][to] = self.facing[axis][from];
            self.wo[axis][to] = self.wo[axis][from];
        }
        for gloss in &mut self.gloss {
            gloss[to] = gloss[from];
        }
        self.t_max[to] = self.t_max[from];
        self.slot[to] = self.slot[from];
        self.pdf[to] = self.pdf[from];
        self.flags[to] = self.flags[from];
        self.roulette_scale[to] = self.roulette_scale[from];
        self.medium[to] = self.medium[from];
        self.differential[to] = self.differential[from];
    }

    /// Writes the i-th packet of a wave: origins, unit directions, ends, and a throughput that is the
    /// same in all channels.
    #[inline(always)]
    pub fn store_packet<R: Real<Scalar = f32>>(
        &mut self,
        i: usize,
        (origin, direction, end): ([R; 3], [R; 3], R),
        throughput: R,
    ) {
        let to = i * R::LANES..(i + 1) * R::LANES;
        for axis in 0..3 {
            origin[axis].store(&mut self.origin[axis][to.clone()]);
            direction[axis].store(&mut self.direction[axis][to.clone()]);
            throughput.store(&mut self.throughput[axis][to.clone()]);
        }
        end.store(&mut self.t_max[to]);
    }

    /// Ends a wave in which every sample has made a ray.
    pub fn number_slots(&mut self, len: usize) {
        for i in 0..len {
            self.slot[i] = i as u32;
        }
        self.len = len;
    }

    /// Appends the rays of a packet that are in a set of lanes, given as bits. `slots` are the
    /// samples of its lanes.
    #[inline(always)]
    pub fn append<R: Real<Scalar = f32>>(
        &mut self,
        lanes: u32,
        rays: &SpawnedRays<R>,
        slots: &[u32],
    ) {
        let first = self.len;
        for axis in 0..3 {
            self.origin[axis].pack(first, lanes, rays.origin[axis]);
            self.direction[axis].pack(first, lanes, rays.direction[axis]);
            self.throughput[axis].pack(first, lanes, rays.throughput[axis]);
        }
        self.t_max.pack(first, lanes, rays.t_max);
        for lane in 0..R::LANES {
            if lanes >> lane & 1 == 1 {
                self.slot[self.len] = slots[lane];
                self.len += 1;
            }
        }
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

    /// Returns the normal of the surface that ray `i` left, or 0; see the field of this name.
    #[inline(always)]
    pub fn facing(&self, i: usize) -> Vec3 {
        Vec3::new(self.facing[0][i], self.facing[1][i], self.facing[2][i])
    }

    /// Sets the normal of the surface that ray `i` left.
    #[inline(always)]
    pub fn set_facing(&mut self, i: usize, facing: [f32; 3]) {
        for axis in 0..3 {
            self.facing[axis][i] = facing[axis];
        }
    }

    /// Returns the throughput of ray `i`.
    #[inline(always)]
    pub fn throughput(&self, i: usize) -> [f32; 3] {
        [self.throughput[0][i], self.throughput[1][i], self.throughput[2][i]]
    }
}

/// Rays of a packet, as [`RayBatch`] holds them.
#[derive(Clone, Copy, Debug)]
pub struct SpawnedRays<R> {
    /// Origin.
    pub origin: [R; 3],
    /// Direction.
    pub direction: [R; 3],
    /// End, in multiples of the direction.
    pub t_max: R,
    /// RGB throughput.
    pub throughput: [R; 3],
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

#[cfg(test)]
mod tests {
    use bytemuck::{cast_mut, cast_slice_mut};

    use super::*;

    /// Returns the entries of ray `i` in all columns.
    fn entries(rays: &mut RayBatch, i: usize) -> Vec<&mut u32> {
        let RayBatch {
            len: _,
            origin,
            direction,
            t_max,
            throughput,
            slot,
            pdf,
            flags,
            roulette_scale,
            facing,
            wo,
            gloss,
            medium,
            differential,
        } = rays;
        let vectors = [origin, direction, throughput, facing, wo].into_iter().flatten();
        let numbers = vectors.chain(gloss).chain([t_max, pdf, roulette_scale]);
        let mut entries: Vec<&mut u32> = numbers.map(|column| cast_mut(&mut column[i])).collect();
        entries.extend([&mut slot[i], &mut medium[i], cast_mut(&mut flags[i])]);
        entries.extend(cast_slice_mut(&mut differential[i..=i]));
        entries
    }

    #[test]
    fn rays_that_are_kept_stay_in_order_with_all_their_columns() {
        let mut rays = RayBatch { len: 5, ..RayBatch::default() };
        let mut before = Vec::new();
        for i in 0..5 {
            for (column, entry) in entries(&mut rays, i).into_iter().enumerate() {
                *entry = (100 * i + column) as u32;
            }
            before.push(entries(&mut rays, i).into_iter().map(|entry| *entry).collect::<Vec<_>>());
        }
        let slots: Vec<u32> = rays.slot[..5].to_vec();
        let mut seen = Vec::new();
        rays.retain(|rays, i| {
            seen.push(rays.slot[i]);
            i % 2 == 0
        });
        assert_eq!(seen, slots);
        assert_eq!(rays.len, 3);
        for (to, from) in [0, 2, 4].into_iter().enumerate() {
            assert_eq!(entries(&mut rays, to), before[from].iter_mut().collect::<Vec<_>>());
        }
    }
}
