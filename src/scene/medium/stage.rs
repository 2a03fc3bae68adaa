//! Media stage: the way of rays through media, across the interfaces between them, to the next
//! collision or surface.

use glam::Vec3;

use super::track::{Way, WayEnd};
use super::{DiffuseBoundary, Medium, MediumModel, VACUUM};
use crate::effects::EFFECTS;
use crate::lanes::math::sin_cos_turns;
use crate::lanes::{LaneIndices, Real};
use crate::rays::{
    Column, Hit, HitBatch, NO_INDEX, Ray, RayBatch, RayDifferential, SampleBatch, WAVE_SIZE,
};
use crate::sampler::{Dimension, RandomStream, hash, sample_2d};
use crate::scene::{MaterialModel, Scene, TraversalStack, cosine_hemisphere};
use crate::stats::LaneOccupancy;

/// What the stages of a wave's rays need beside the rays.
#[derive(Clone, Copy, Debug)]
pub struct Surroundings<'a> {
    /// The samples of the rays.
    pub samples: &'a SampleBatch,
    /// Number of scatterings before.
    pub depth: u32,
    /// Whether shapes move.
    pub moves: bool,
    /// Whether there are media.
    pub media: bool,
}

impl<'a> Surroundings<'a> {
    /// The surroundings of paths that have scattered so many times.
    pub fn of(scene: &Scene, samples: &'a SampleBatch, depth: u32) -> Self {
        let moves = EFFECTS && !scene.animated_instances().is_empty();
        Self { samples, depth, moves, media: EFFECTS && scene.has_media() }
    }
}

/// Work columns of the stage.
#[derive(Clone, Debug, Default)]
pub struct MediumColumns {
    /// Where the part of every ray's way begins that is not done, in multiples of its direction.
    start: Column<f32>,
    /// Transmittance of shadow rays.
    transmittance: [Column<f32>; 3],
    /// Rays whose ways are not done.
    active: Vec<u32>,
    /// Those of them that travel in each medium.
    groups: Vec<Vec<u32>>,
    /// Ways behind an interface, and their hits.
    beyond: Box<RayBatch>,
    beyond_hits: HitBatch,
    /// Hits of shadow rays.
    hits: HitBatch,
}

impl MediumColumns {
    /// Memory (bytes).
    pub const BYTES: usize =
        size_of::<Self>() + size_of::<RayBatch>() + 2 * WAVE_SIZE * size_of::<Hit>();
}

/// Share of the way behind an interface to a light on which other surfaces block it.
const BEFORE_END: f32 = 1.0 - 1e-5;

/// Most interfaces that a ray crosses without scattering; it counts as absorbed there. Rays do not
/// meet a surface twice at a point, so that only scenes of as many surfaces reach it.
const MAX_CROSSINGS: u32 = 10_000;

impl Scene {
    /// Moves rays through media to where they scatter or reach a surface that is not only an
    /// interface: a stage. `hits` are those of the rays, and become those of where they end:
    /// [`Hit::IN_MEDIUM`] where they scatter. Changes the throughput and the medium of the rays, and
    /// adds the light of the media to `radiance`.
    pub fn travel<R: Real<Scalar = f32>>(
        &self,
        inputs: &Surroundings,
        rays: &mut RayBatch,
        hits: &mut HitBatch,
        radiance: &mut [Column<f32>; 3],
        columns: &mut MediumColumns,
        stack: &mut TraversalStack,
    ) {
        self.pass_media::<R, false>(inputs, rays, hits, columns, stack, radiance);
    }

    /// Adds the contribution of each shadow ray that reaches its light to the radiance of its
    /// sample: a stage. Returns how full the packets were.
    pub fn receive<R: Real<Scalar = f32>>(
        &self,
        inputs: &Surroundings,
        rays: &mut RayBatch,
        radiance: &mut [Column<f32>; 3],
        columns: &mut MediumColumns,
        stack: &mut TraversalStack,
    ) -> LaneOccupancy {
        if inputs.media {
            return self.transmit::<R>(inputs, rays, radiance, columns, stack);
        }
        if inputs.moves {
            self.occlude_animated::<R>(rays, &inputs.samples.time, stack);
        }
        self.occlude::<R>(rays, stack, radiance)
    }

    /// Traces the shadow rays of a wave through media and their interfaces, and adds the
    /// contribution of each one that no other surface blocks to the radiance of its sample.
    /// Returns how full the packets of the first intersection were.
    fn transmit<R: Real<Scalar = f32>>(
        &self,
        inputs: &Surroundings,
        rays: &mut RayBatch,
        radiance: &mut [Column<f32>; 3],
        columns: &mut MediumColumns,
        stack: &mut TraversalStack,
    ) -> LaneOccupancy {
        let mut hits = std::mem::take(&mut columns.hits);
        let lanes = self.intersect_all::<R>(inputs, rays, &mut hits, stack);
        for channel in &mut columns.transmittance {
            channel[..rays.len].fill(1.0);
        }
        self.pass_media::<R, true>(inputs, rays, &mut hits, columns, stack, radiance);
        for i in 0..rays.len {
            if hits[i].shape == NO_INDEX {
                let slot = rays.slot[i] as usize;
                for (channel, carried) in rays.throughput(i).into_iter().enumerate() {
                    radiance[channel][slot] += carried * columns.transmittance[channel][i];
                }
            }
        }
        columns.hits = hits;
        lanes
    }

    /// Finds the nearest hit of every ray among static and moving shapes: a stage. Returns how full
    /// the packets were.
    pub fn intersect_all<R: Real<Scalar = f32>>(
        &self,
        inputs: &Surroundings,
        rays: &RayBatch,
        hits: &mut HitBatch,
        stack: &mut TraversalStack,
    ) -> LaneOccupancy {
        let lanes = self.intersect::<R>(rays, hits, stack);
        if inputs.moves {
            self.intersect_animated::<R>(rays, &inputs.samples.time, hits, stack);
        }
        lanes
    }

    /// Follows rays through media and across interfaces.
    fn pass_media<R: Real<Scalar = f32>, const SHADOW: bool>(
        &self,
        inputs: &Surroundings,
        rays: &mut RayBatch,
        hits: &mut HitBatch,
        columns: &mut MediumColumns,
        stack: &mut TraversalStack,
        radiance: &mut [Column<f32>; 3],
    ) {
        columns.start[..rays.len].fill(0.0);
        columns.active.clear();
        columns.active.extend(0..rays.len as u32);
        columns.groups.resize(self.media.len(), Vec::new());
        for crossing in 0..=MAX_CROSSINGS {
            let groups = &mut columns.groups;
            groups.iter_mut().for_each(Vec::clear);
            for &i in &columns.active {
                if rays.medium[i as usize] != VACUUM {
                    groups[rays.medium[i as usize] as usize].push(i);
                }
            }
            for (index, medium) in self.media.iter().enumerate() {
                let group = std::mem::take(&mut columns.groups[index]);
                let mut pass = MediumPass::<SHADOW> {
                    inputs,
                    crossing,
                    scene: self,
                    medium: index as u32,
                    group: &group,
                    rays,
                    hits,
                    columns,
                    radiance,
                };
                pass.follow::<R>(medium);
                columns.groups[index] = group;
            }
            self.cross_interfaces(rays, hits, columns);
            if columns.beyond.len == 0 {
                return;
            }
            if crossing == MAX_CROSSINGS {
                columns.active.iter().for_each(|&i| hits[i as usize] = Hit::ABSORBED);
                return;
            }
            let MediumColumns { beyond, beyond_hits, .. } = columns;
            self.intersect_all::<R>(inputs, beyond, beyond_hits, stack);
            for (k, &i) in columns.active.iter().enumerate() {
                let (i, mut hit) = (i as usize, columns.beyond_hits[k]);
                let (start, end) = (hits[i].t, rays.t_max[i]);
                columns.start[i] = start;
                // A ray with an end is behind the interface as long as the rest of its way.
                hit.t = start + if end < f32::INFINITY { hit.t * (end - start) } else { hit.t };
                hits[i] = hit;
            }
        }
    }

    /// Finds the active rays that have reached an interface and keeps only these active. Writes
    /// their ways behind it.
    fn cross_interfaces(&self, rays: &mut RayBatch, hits: &HitBatch, columns: &mut MediumColumns) {
        let MediumColumns { active, beyond, .. } = columns;
        beyond.len = 0;
        active.retain(|&i| {
            let (i, hit) = (i as usize, &hits[i as usize]);
            if hit.shape == Hit::IN_MEDIUM && self.walks_in(hit.primitive) {
                beyond.push(rays.ray(i), [0.0; 3], rays.slot[i]);
                return true;
            }
            if !self.is_interface(hit) {
                return false;
            }
            let ray = rays.ray(i);
            let (_, point) = self.surface(&ray, hit);
            let direction = Vec3::from(ray.direction);
            rays.medium[i] = self.medium_beyond(hit, rays.medium[i], point.normal, direction);
            let origin = point.offset_origin(direction);
            let way = match ray.t_max < f32::INFINITY {
                // The origin is beside the line, from which a ray of the same direction could end
                // behind the surface of the light instead of before it.
                true => {
                    let end = Vec3::from(ray.origin) + ray.t_max * direction;
                    Ray {
                        origin: origin.into(),
                        direction: (end - origin).into(),
                        t_max: BEFORE_END,
                    }
                }
                false => Ray { origin: origin.into(), ..ray },
            };
            beyond.push(way, [0.0; 3], rays.slot[i]);
            true
        });
    }

    /// Returns whether paths walk through a medium until they leave it.
    fn walks_in(&self, medium: u32) -> bool {
        self.media.get(medium as usize).is_some_and(|medium| medium.boundary.is_some())
    }

    /// Returns whether a hit is on a surface that does nothing but separate media.
    fn is_interface(&self, hit: &Hit) -> bool {
        let Some(shape) = self.shapes.get(hit.shape as usize) else { return false };
        matches!(self.materials[shape.material as usize].model, MaterialModel::Interface)
    }
}

/// Rays that travel in one medium.
struct MediumPass<'a, const SHADOW: bool> {
    scene: &'a Scene,
    inputs: &'a Surroundings<'a>,
    /// Number of interfaces crossed since the last scattering.
    crossing: u32,
    medium: u32,
    group: &'a [u32],
    rays: &'a mut RayBatch,
    hits: &'a mut HitBatch,
    columns: &'a mut MediumColumns,
    radiance: &'a mut [Column<f32>; 3],
}

impl<const SHADOW: bool> MediumPass<'_, SHADOW> {
    /// Moves the rays to their collisions or to the ends of their ways.
    fn follow<R: Real<Scalar = f32>>(&mut self, medium: &Medium) {
        match &medium.model {
            MediumModel::Varying(varying) => {
                let mut ends = Vec::with_capacity(self.group.len());
                let next = |k: usize| self.way(self.group[k] as usize);
                varying.track::<R, SHADOW>(self.group.len(), next, |k, end| ends.push((k, end)));
                for (k, end) in ends {
                    self.finish(self.group[k] as usize, &end);
                }
            }
            MediumModel::Homogeneous(homogeneous) => {
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
                    let along = passage.distance / R::load(&speed);
                    let mut distances = [0.0; 8];
                    along.store(&mut distances);
                    let scatters = R::bits(passage.scatters);
                    for (lane, &i) in chunk.iter().enumerate() {
                        let of = |v: [R; 3]| v.map(|channel| lane_of(channel, lane));
                        let start = self.columns.start[i as usize];
                        let end = WayEnd {
                            scatters: (scatters >> lane & 1 == 1)
                                .then_some(start + distances[lane]),
                            throughput: of(passage.throughput),
                            emitted: of(passage.emitted),
                        };
                        self.finish(i as usize, &end);
                    }
                }
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
    fn seed(&self, i: usize) -> u32 {
        let samples = self.inputs.samples;
        let slot = self.rays.slot[i] as usize;
        let ray = hash(samples.key[slot] ^ hash(samples.sample[slot]));
        let part = (self.inputs.depth << 1 | u32::from(SHADOW)).wrapping_mul(0x85eb_ca6b);
        hash(hash(ray ^ part).wrapping_add(self.crossing))
    }

    /// Returns two numbers in [0, 1) for a ray's way through a homogeneous medium.
    fn numbers(&self, i: usize) -> [f32; 2] {
        if self.crossing > 0 {
            return RandomStream::<f32>::new(self.seed(i), []).pair(0);
        }
        let samples = self.inputs.samples;
        let slot = self.rays.slot[i] as usize;
        let dimension = Dimension::Medium(self.inputs.depth);
        sample_2d(samples.key[slot], samples.sample[slot], dimension)
    }

    /// Takes over the end of a ray's way.
    fn finish(&mut self, i: usize, end: &WayEnd) {
        let WayEnd { scatters, throughput, emitted } = end;
        let before = max_component(self.rays.throughput(i));
        let absorbed = !throughput.iter().any(|&channel| channel > 0.0);
        if SHADOW {
            for channel in 0..3 {
                self.columns.transmittance[channel][i] *= throughput[channel];
            }
        } else {
            let slot = self.rays.slot[i] as usize;
            for channel in 0..3 {
                self.rays.throughput[channel][i] = throughput[channel];
                self.radiance[channel][slot] += emitted[channel];
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

    /// Turns a ray that walks through the medium where it scatters, or where the boundary reflects
    /// it. `before` is its throughput at the start of the way, of which Russian roulette keeps the
    /// size.
    fn walk(&mut self, i: usize, g: f32, boundary: &DiffuseBoundary, before: f32) {
        let (hit, ray) = (self.hits[i], self.rays.ray(i));
        let random = RandomStream::<f32>::new(self.seed(i), []).substream(1);
        let (u, roulette) = (random.pair(0), random.number(2));
        let direction = Vec3::from(ray.direction);
        let (origin, direction) = if hit == Hit::ABSORBED {
            return;
        } else if hit.shape == Hit::IN_MEDIUM {
            let throughput = self.rays.throughput(i);
            let left = max_component(throughput) / before;
            if roulette >= left {
                self.hits[i] = Hit::ABSORBED;
                return;
            }
            for channel in 0..3 {
                self.rays.throughput[channel][i] = throughput[channel] / left.min(1.0);
            }
            let next = deflected(direction, g, u);
            (Vec3::from(ray.origin) + hit.t * direction, next)
        } else if self.scene.is_boundary_of(&hit, self.medium)
            && roulette < boundary.internal_reflectance
        {
            let (_, point) = self.scene.surface(&ray, &hit);
            let inwards =
                if point.normal.dot(direction) > 0.0 { -point.normal } else { point.normal };
            let (next, _) = cosine_hemisphere(inwards, u);
            (point.offset_origin(next), next)
        } else {
            return;
        };
        for axis in 0..3 {
            self.rays.origin[axis][i] = origin[axis];
            self.rays.direction[axis][i] = direction[axis];
        }
        // No other technique finds the light that such a ray may hit.
        self.rays.pdf[i] = f32::INFINITY;
        self.rays.differential[i] = RayDifferential::UNKNOWN;
        self.hits[i] = Hit { t: 0.0, shape: Hit::IN_MEDIUM, primitive: self.medium, ..Hit::MISS };
    }
}

/// Returns the largest channel of a throughput.
fn max_component(throughput: [f32; 3]) -> f32 {
    throughput.into_iter().fold(0.0, f32::max)
}

/// Returns a direction after scattering by the phase function of Henyey & Greenstein 1941.
fn deflected(along: Vec3, g: f32, u: [f32; 2]) -> Vec3 {
    let cos = if g.abs() < 1e-3 {
        1.0 - 2.0 * u[0]
    } else {
        let quotient = (1.0 - g * g) / (1.0 - g + 2.0 * g * u[0]);
        ((1.0 + g * g - quotient * quotient) / (2.0 * g)).clamp(-1.0, 1.0)
    };
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let [y, x] = sin_cos_turns(u[1]);
    let (tangent, bitangent) = along.any_orthonormal_pair();
    (tangent * (sin * x) + bitangent * (sin * y) + along * cos).normalize()
}

/// Returns one lane of a packet.
fn lane_of<R: Real<Scalar = f32>>(packet: R, lane: usize) -> f32 {
    let mut lanes = [0.0; 8];
    packet.store(&mut lanes);
    lanes[lane]
}
