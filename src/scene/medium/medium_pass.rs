//! The ways of a wave's rays through one medium.

use glam::Vec3;

use super::homogeneous::Homogeneous;
use super::stage::{MediumColumns, Surroundings};
use super::track::{Way, WayEnd};
use super::{Medium, MediumModel};
use crate::Scene;
use petzval_base::lanes::vector::max_component;
use petzval_base::lanes::{LaneIndices, Real};
use petzval_base::rays::{Column, Hit, HitBatch, NO_INDEX, RayBatch};
use petzval_base::sampler::{Dimension, RandomStream, hash, sample_2d};

/// Rays that travel in one medium.
pub(super) struct MediumPass<'a, const SHADOW: bool> {
    pub(super) scene: &'a Scene,
    pub(super) surroundings: &'a Surroundings<'a>,
    /// Number of interfaces crossed since the last scattering.
    pub(super) crossing: u32,
    pub(super) medium: u32,
    pub(super) group: &'a [u32],
    pub(super) rays: &'a mut RayBatch,
    pub(super) hits: &'a mut HitBatch,
    pub(super) columns: &'a mut MediumColumns,
    pub(super) radiance: &'a mut [Column<f32>; 3],
}

impl<const SHADOW: bool> MediumPass<'_, SHADOW> {
    /// Moves the rays to their collisions or to the ends of their ways.
    pub(super) fn follow<R: Real<Scalar = f32>>(&mut self, medium: &Medium) {
        match &medium.model {
            MediumModel::Varying(varying) => {
                let mut ends = Vec::with_capacity(self.group.len());
                let next = |k: usize| self.way(self.group[k] as usize);
                varying.track::<R, SHADOW>(self.group.len(), next, |k, end| ends.push((k, end)));
                for (k, end) in ends {
                    self.finish(self.group[k] as usize, &end);
                }
            }
            MediumModel::Homogeneous(homogeneous) => self.follow_packets::<R>(homogeneous),
        }
    }

    /// Moves the rays in a homogeneous medium, packet by packet.
    fn follow_packets<R: Real<Scalar = f32>>(&mut self, homogeneous: &Homogeneous) {
        for chunk in self.group.chunks(R::LANES) {
            let lanes = LaneIndices::new::<R>(chunk);
            let (mut length, mut speed) = ([0.0; 8], [0.0; 8]);
            let mut u = [[0.0; 8]; 2];
            for (lane, &i) in chunk.iter().enumerate() {
                let i = i as usize;
                let [start, end] = self.range(i);
                speed[lane] = Vec3::from(self.rays.ray(i).direction).length();
                length[lane] = (end - start).max(0.0) * speed[lane];
                if !SHADOW {
                    [u[0][lane], u[1][lane]] = self.numbers(i);
                }
            }
            let length = R::load(&length);
            if SHADOW {
                let passed = homogeneous.transmittance(length);
                let columns = &mut self.columns.transmittance;
                let before = lanes.load_vector::<R, _>(columns);
                let mut after = before;
                for channel in 0..3 {
                    after[channel] = before[channel] * passed[channel];
                }
                lanes.store_vector(after, columns);
                continue;
            }
            let throughput = lanes.load_vector::<R, _>(&self.rays.throughput);
            let u = [R::load(&u[0]), R::load(&u[1])];
            let passage = homogeneous.sample(length, throughput, u);
            let mut along = [0.0; 8];
            (passage.distance / R::load(&speed)).store(&mut along);
            let (mut throughput, mut emitted) = ([[0.0; 8]; 3], [[0.0; 8]; 3]);
            for channel in 0..3 {
                passage.throughput[channel].store(&mut throughput[channel]);
                passage.emitted[channel].store(&mut emitted[channel]);
            }
            let scatters = R::bits(passage.scatters);
            for (lane, &i) in chunk.iter().enumerate() {
                let t = self.columns.start[i as usize] + along[lane];
                let end = WayEnd {
                    scatters: (scatters >> lane & 1 == 1).then_some(t),
                    throughput: throughput.map(|channel| channel[lane]),
                    emitted: emitted.map(|channel| channel[lane]),
                };
                self.finish(i as usize, &end);
            }
        }
    }

    /// Returns where the way of a ray begins and ends, in multiples of its direction.
    fn range(&self, i: usize) -> [f32; 2] {
        let hit = &self.hits[i];
        let end = if hit.shape == NO_INDEX { self.rays.t_max[i] } else { hit.t };
        [self.columns.start[i], end]
    }

    /// Returns the way of a ray through a medium that varies.
    fn way(&self, i: usize) -> Way {
        let ray = self.rays.ray(i);
        Way {
            origin: ray.origin,
            direction: ray.direction,
            range: self.range(i),
            throughput: if SHADOW { [1.0; 3] } else { self.rays.throughput(i) },
            seed: self.seed(i),
        }
    }

    /// Returns the seed of a ray's random numbers.
    pub(super) fn seed(&self, i: usize) -> u32 {
        let samples = self.surroundings.samples;
        let slot = self.rays.slot[i] as usize;
        let ray = hash(samples.key[slot] ^ hash(samples.sample[slot]));
        let part = (self.surroundings.depth << 1 | u32::from(SHADOW)).wrapping_mul(0x85eb_ca6b);
        hash(hash(ray ^ part).wrapping_add(self.crossing))
    }

    /// Returns two numbers in [0, 1) for a ray's way through a homogeneous medium.
    fn numbers(&self, i: usize) -> [f32; 2] {
        if self.crossing > 0 {
            return RandomStream::<f32>::new(self.seed(i), []).pair(0);
        }
        let samples = self.surroundings.samples;
        let slot = self.rays.slot[i] as usize;
        let dimension = Dimension::Medium(self.surroundings.depth);
        sample_2d(samples.key[slot], samples.sample[slot], dimension)
    }

    /// Takes over the end of a ray's way.
    fn finish(&mut self, i: usize, end: &WayEnd) {
        let WayEnd { scatters, throughput, emitted } = end;
        let before = max_component::<f32>(self.rays.throughput(i));
        let absorbed = !throughput.iter().any(|&channel| channel > 0.0);
        if SHADOW {
            for channel in 0..3 {
                self.columns.transmittance[channel][i] *= throughput[channel];
            }
        } else {
            let slot = self.rays.slot[i] as usize;
            for channel in 0..3 {
                self.rays.throughput[channel][i] = throughput[channel];
                if !self.surroundings.last {
                    self.radiance[channel][slot] += emitted[channel];
                }
            }
        }
        if absorbed {
            self.hits[i] = Hit::ABSORBED;
        } else if let Some(t) = *scatters {
            self.hits[i] = Hit { t, shape: Hit::IN_MEDIUM, primitive: self.medium, ..Hit::MISS };
        }
        let Medium { g, boundary, .. } = self.scene.media[self.medium as usize];
        if let (Some(boundary), false) = (boundary, SHADOW) {
            self.walk(i, g, &boundary, before);
        }
    }
}
