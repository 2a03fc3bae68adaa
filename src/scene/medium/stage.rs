//! Media stage: the way of rays through media, across the interfaces between them, to the next
//! collision or surface.

use glam::Vec3;

use super::VACUUM;
use super::medium_pass::MediumPass;
use crate::{MaterialModel, Scene, TraversalStack};
use petzval_base::lanes::Real;
use petzval_base::rays::{Column, Hit, HitBatch, NO_INDEX, Ray, RayBatch, SampleBatch, WAVE_SIZE};
use petzval_base::stats::LaneOccupancy;

/// Samples and depth of a wave, and the kinds of work that its scene calls for.
#[derive(Clone, Copy, Debug)]
pub struct Surroundings<'a> {
    /// The samples of the rays.
    pub samples: &'a SampleBatch,
    /// Number of scatterings before.
    pub depth: u32,
    /// Whether paths end at their next vertex. Then they collect the light of surfaces and skies, but
    /// none of media, as in pbrt-v4.
    pub last: bool,
    /// Whether shapes move.
    pub moves: bool,
    /// Whether there are media.
    pub media: bool,
}

impl<'a> Surroundings<'a> {
    /// The surroundings of paths that have scattered `depth` times, of `max_depth`.
    pub fn of(scene: &Scene, samples: &'a SampleBatch, depth: u32, max_depth: u32) -> Self {
        let moves = !scene.animated_instances().is_empty();
        let media = scene.has_media();
        Self { samples, depth, last: depth >= max_depth, moves, media }
    }
}

/// Work columns of the stage.
#[derive(Clone, Debug, Default)]
pub struct MediumColumns {
    /// Point up to which each ray has travelled, in multiples of its direction.
    pub(super) start: Column<f32>,
    /// Transmittance of shadow rays.
    pub(super) transmittance: [Column<f32>; 3],
    /// Active rays: those that have not reached their end.
    active: Vec<u32>,
    /// Active rays by medium.
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
        surroundings: &Surroundings,
        rays: &mut RayBatch,
        hits: &mut HitBatch,
        radiance: &mut [Column<f32>; 3],
        columns: &mut MediumColumns,
        stack: &mut TraversalStack,
    ) {
        self.pass_media::<R, false>(surroundings, rays, hits, columns, stack, radiance);
    }

    /// Adds the contribution of each shadow ray that reaches its light to the radiance of its
    /// sample: a stage. Returns how full the packets were.
    pub fn receive<R: Real<Scalar = f32>>(
        &self,
        surroundings: &Surroundings,
        rays: &mut RayBatch,
        radiance: &mut [Column<f32>; 3],
        columns: &mut MediumColumns,
        stack: &mut TraversalStack,
    ) -> LaneOccupancy {
        if surroundings.media {
            return self.transmit::<R>(surroundings, rays, radiance, columns, stack);
        }
        self.receive_in_vacuum::<R>(surroundings, rays, radiance, stack)
    }

    /// Adds the same contributions in a scene without media.
    pub fn receive_in_vacuum<R: Real<Scalar = f32>>(
        &self,
        surroundings: &Surroundings,
        rays: &mut RayBatch,
        radiance: &mut [Column<f32>; 3],
        stack: &mut TraversalStack,
    ) -> LaneOccupancy {
        if surroundings.moves {
            self.occlude_animated::<R>(rays, &surroundings.samples.time, stack);
        }
        self.occlude::<R>(rays, stack, radiance)
    }

    /// Traces the shadow rays of a wave through media and their interfaces, and adds the
    /// contribution of each one that no other surface blocks to the radiance of its sample.
    /// Returns how full the packets of the first intersection were.
    fn transmit<R: Real<Scalar = f32>>(
        &self,
        surroundings: &Surroundings,
        rays: &mut RayBatch,
        radiance: &mut [Column<f32>; 3],
        columns: &mut MediumColumns,
        stack: &mut TraversalStack,
    ) -> LaneOccupancy {
        let mut hits = std::mem::take(&mut columns.hits);
        let lanes = self.intersect_all::<R>(surroundings, rays, &mut hits, stack);
        for channel in &mut columns.transmittance {
            channel[..rays.len].fill(1.0);
        }
        self.pass_media::<R, true>(surroundings, rays, &mut hits, columns, stack, radiance);
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
        surroundings: &Surroundings,
        rays: &RayBatch,
        hits: &mut HitBatch,
        stack: &mut TraversalStack,
    ) -> LaneOccupancy {
        let lanes = self.intersect::<R>(rays, hits, stack);
        if surroundings.moves {
            self.intersect_animated::<R>(rays, &surroundings.samples.time, hits, stack);
        }
        lanes
    }

    /// Follows rays through media and across interfaces.
    fn pass_media<R: Real<Scalar = f32>, const SHADOW: bool>(
        &self,
        surroundings: &Surroundings,
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
            let MediumColumns { groups, active, .. } = columns;
            groups.iter_mut().for_each(Vec::clear);
            for &i in &*active {
                if rays.medium[i as usize] != VACUUM {
                    groups[rays.medium[i as usize] as usize].push(i);
                }
            }
            for (index, medium) in self.media.iter().enumerate() {
                let group = std::mem::take(&mut columns.groups[index]);
                let mut pass = MediumPass::<SHADOW> {
                    surroundings,
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
            self.intersect_all::<R>(surroundings, beyond, beyond_hits, stack);
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
