//! Intersection stages: the nearest hit of rays, and the occlusion of shadow rays.
//!
//! The rays of a wave are sorted by the octant of their direction and traverse the hierarchy in
//! packets of eight. The result for a ray does not depend on the other rays of its packet.

mod animated;

use glam::{Affine3A, Vec3};

use super::bvh::{
    Bvh, LeafIntersector, NearestHit, PackedChild, RayPacket, RayQueue, TraversalRay,
    TraversalStack, traverse,
};
use super::geometry::CurveSet;
use super::{Geometry, Scene};
use petzval_base::lanes::Real;
use petzval_base::rays::{Column, Hit, HitBatch, Ray, RayBatch};
use petzval_base::stats::LaneOccupancy;

impl Scene {
    /// Finds the nearest hit of every ray: a stage. Returns how full the packets were.
    pub fn intersect<R: Real<Scalar = f32>>(
        &self,
        rays: &RayBatch,
        hits: &mut HitBatch,
        stack: &mut TraversalStack,
    ) -> LaneOccupancy {
        hits[..rays.len].fill(Hit::MISS);
        for i in 0..rays.len {
            hits[i].t = rays.t_max[i];
        }
        self.trace_packets::<R, false>(rays, stack, |i, nearest, _| {
            hits[i] = nearest.hit(&self.world)
        })
    }

    /// Tests the shadow rays of a wave, and adds the contribution of each unoccluded ray to the
    /// radiance of its sample: a stage. Returns how full the packets were.
    pub fn occlude<R: Real<Scalar = f32>>(
        &self,
        rays: &RayBatch,
        stack: &mut TraversalStack,
        radiance: &mut [Column<f32>; 3],
    ) -> LaneOccupancy {
        let mut blocked = [false; petzval_base::rays::WAVE_SIZE];
        let lanes = self.trace_packets::<R, true>(rays, stack, |i, _, hit| blocked[i] = hit);
        // In the order of the rays, because sums round.
        for i in 0..rays.len {
            if !blocked[i] {
                let slot = rays.slot[i] as usize;
                for (column, carried) in radiance.iter_mut().zip(rays.throughput(i)) {
                    column[slot] += carried;
                }
            }
        }
        lanes
    }

    /// Returns the nearest hit of one ray.
    pub fn closest<R: Real<Scalar = f32>>(&self, ray: &Ray, stack: &mut TraversalStack) -> Hit {
        let mut nearest = NearestHit::new(ray.t_max);
        self.trace_one::<R, false>(ray, &mut nearest, stack);
        nearest.hit(&self.world)
    }

    /// Returns whether one ray hits anything.
    pub fn occluded<R: Real<Scalar = f32>>(&self, ray: &Ray, stack: &mut TraversalStack) -> bool {
        self.trace_one::<R, true>(ray, &mut NearestHit::new(ray.t_max), stack)
    }

    fn trace_one<R: Real<Scalar = f32>, const ANY: bool>(
        &self,
        ray: &Ray,
        nearest: &mut NearestHit,
        stack: &mut TraversalStack,
    ) -> bool {
        let Some(ray) = TraversalRay::new(ray.origin, ray.direction) else { return false };
        traverse::<R, ANY>(
            &self.world,
            self,
            PackedChild::ROOT,
            &ray,
            nearest,
            self.stack_slots(stack),
        )
    }

    /// Traces the rays of a wave through the world. Calls `report` with the index, the nearest hit
    /// and whether there is a hit, for every ray that can hit anything. Returns how full the
    /// packets were.
    fn trace_packets<R: Real<Scalar = f32>, const ANY: bool>(
        &self,
        rays: &RayBatch,
        stack: &mut TraversalStack,
        mut report: impl FnMut(usize, &NearestHit, bool),
    ) -> LaneOccupancy {
        let mut lanes = LaneOccupancy::default();
        let pending = self.stack_slots(stack);
        let (mut queues, mut packet) = ([RayQueue::default(); 8], RayPacket::default());
        let mut flush = |queue: &mut RayQueue| {
            let len = queue.len;
            if len == 0 {
                return;
            }
            lanes.add(LaneOccupancy::packed(len));
            packet.load::<R>(queue);
            queue.len = 0;
            let hits = packet.traverse::<R, ANY>(len, &self.world, self, pending);
            for lane in 0..len {
                report(queue.index[lane] as usize, &packet.nearest[lane], hits >> lane & 1 == 1);
            }
        };
        for i in 0..rays.len {
            if let Some(full) = RayQueue::push(&mut queues, &rays.ray(i), i) {
                flush(full);
            }
        }
        queues.iter_mut().for_each(flush);
        lanes
    }

    /// Returns stack slots for the deepest hierarchy of the world plus that of an object.
    fn stack_slots<'a>(&self, stack: &'a mut TraversalStack) -> &'a mut [u64] {
        let instances = self.world.stack_size.max(self.animated.stack_size());
        stack.slots(instances + self.object_stack_size)
    }
}

impl LeafIntersector for Scene {
    #[inline(never)]
    fn intersect_instance<R: Real<Scalar = f32>, const ANY: bool>(
        &self,
        number: u32,
        ray: &TraversalRay,
        nearest: &mut NearestHit,
        pending: &mut [u64],
    ) -> bool {
        let instance = &self.instances[number as usize];
        let bvh: &Bvh = &self.objects[instance.object as usize];
        let Some(ray) = to_object_space(ray, &instance.pose.object_from_world) else {
            return false;
        };
        let mut inner = NearestHit::new(nearest.t);
        let is_hit = traverse::<R, ANY>(bvh, self, PackedChild::ROOT, &ray, &mut inner, pending);
        if is_hit {
            nearest.replace(&Hit { instance: number, ..inner.hit(bvh) });
        }
        is_hit
    }

    fn curves(&self, shape: u32) -> Option<&CurveSet> {
        match &self.shapes[shape as usize].geometry {
            Geometry::Curves(curves) => Some(curves),
            Geometry::Mesh(_) | Geometry::Patches(_) | Geometry::Quadric(_) => None,
        }
    }

    fn passes_alpha_test(&self, ray: &TraversalRay, hit: &Hit) -> bool {
        self.shapes[hit.shape as usize].passes_alpha_test(ray.origin, ray.direction, hit)
    }
}

/// Transforms a ray into the space of an instanced object. Distances along it do not change.
fn to_object_space(ray: &TraversalRay, matrix: &Affine3A) -> Option<TraversalRay> {
    let origin = matrix.transform_point3(Vec3::from(ray.origin));
    let direction = matrix.transform_vector3(Vec3::from(ray.direction));
    TraversalRay::new(origin.to_array(), direction.to_array())
}
