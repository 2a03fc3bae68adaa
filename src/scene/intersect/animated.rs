//! Intersection stages for animated instances, which run in addition to those for the static world.

use super::to_object_space;
use crate::Scene;
use crate::bvh::{
    Bvh, LeafIntersector, NearestHit, PackedChild, TraversalRay, TraversalStack, may_hit_box,
    traverse,
};
use crate::geometry::CurveSet;
use crate::transform::to_f32;
use petzval_base::lanes::Real;
use petzval_base::rays::{Column, Hit, HitBatch, Ray, RayBatch};

impl Scene {
    /// Returns whether a ray of a wave may hit an animated instance at any time.
    pub fn may_hit_animated(&self, rays: &RayBatch, ray: usize) -> bool {
        self.animated.bounds().is_some_and(|bounds| may_hit_box::<f32>(rays, ray, bounds) != 0)
    }

    /// Replaces the hits that [`Self::intersect`] found by nearer ones on animated instances: a
    /// stage. `times` is indexed by the slots of the rays.
    pub fn intersect_animated<R: Real<Scalar = f32>>(
        &self,
        rays: &RayBatch,
        times: &Column<f32>,
        hits: &mut HitBatch,
        stack: &mut TraversalStack,
    ) {
        let Some(bounds) = self.animated.bounds() else { return };
        let pending = self.stack_slots(stack);
        for first in (0..rays.len).step_by(R::LANES) {
            let mut left = may_hit_box::<R>(rays, first, bounds);
            while left != 0 {
                let i = first + left.trailing_zeros() as usize;
                left &= left - 1;
                if i >= rays.len {
                    break;
                }
                let time = times[rays.slot[i] as usize];
                if let Some(hit) =
                    self.hit_animated::<R, false>(&rays.ray(i), time, hits[i].t, pending)
                {
                    hits[i] = hit;
                }
            }
        }
    }

    /// Removes the shadow rays that hit an animated instance: a stage before [`Self::occlude`].
    pub fn occlude_animated<R: Real<Scalar = f32>>(
        &self,
        rays: &mut RayBatch,
        times: &Column<f32>,
        stack: &mut TraversalStack,
    ) {
        let Some(bounds) = self.animated.bounds() else { return };
        let (len, pending) = (rays.len, self.stack_slots(stack));
        rays.len = 0;
        for first in (0..len).step_by(R::LANES) {
            // Tested before any ray moves to the front, which never overtakes these lanes.
            let near = may_hit_box::<R>(rays, first, bounds);
            for i in first..len.min(first + R::LANES) {
                let (ray, slot) = (rays.ray(i), rays.slot[i]);
                let is_hit = near >> (i - first) & 1 == 1
                    && self
                        .hit_animated::<R, true>(&ray, times[slot as usize], ray.t_max, pending)
                        .is_some();
                if !is_hit {
                    rays.push(ray, rays.throughput(i), slot);
                }
            }
        }
    }

    /// Returns the nearest hit of one ray at a time, on static and animated shapes.
    pub fn closest_at<R: Real<Scalar = f32>>(
        &self,
        ray: &Ray,
        time: f32,
        stack: &mut TraversalStack,
    ) -> Hit {
        let nearest = self.closest::<R>(ray, stack);
        let pending = self.stack_slots(stack);
        self.hit_animated::<R, false>(ray, time, nearest.t, pending).unwrap_or(nearest)
    }

    /// Returns the nearest hit on an animated instance before a distance, or with `ANY` some hit.
    fn hit_animated<R: Real<Scalar = f32>, const ANY: bool>(
        &self,
        ray: &Ray,
        time: f32,
        t_max: f32,
        pending: &mut [u64],
    ) -> Option<Hit> {
        if self.animated.all.is_empty() {
            return None;
        }
        let ray = TraversalRay::new(ray.origin, ray.direction)?;
        let mut nearest = NearestHit::new(t_max);
        let at_time = SceneAtTime { scene: self, time };
        let bvh = self.animated.bvh_at(time);
        traverse::<R, ANY>(bvh, &at_time, PackedChild::ROOT, &ray, &mut nearest, pending)
            .then(|| Hit { time, ..nearest.hit(bvh) })
    }
}

/// A scene at one time.
struct SceneAtTime<'a> {
    scene: &'a Scene,
    time: f32,
}

impl LeafIntersector for SceneAtTime<'_> {
    #[inline(never)]
    fn intersect_instance<R: Real<Scalar = f32>, const ANY: bool>(
        &self,
        number: u32,
        ray: &TraversalRay,
        nearest: &mut NearestHit,
        pending: &mut [u64],
    ) -> bool {
        let scene = self.scene;
        let instance = &scene.animated.all[number as usize];
        let bvh: &Bvh = &scene.objects[instance.object as usize];
        let pose = instance.motion.at(f64::from(self.time));
        let Some(ray) = to_object_space(ray, &to_f32(&pose.inverse())) else { return false };
        let mut inner = NearestHit::new(nearest.t);
        let is_hit = traverse::<R, ANY>(bvh, scene, PackedChild::ROOT, &ray, &mut inner, pending);
        if is_hit {
            let instance = scene.instances.len() as u32 + number;
            nearest.replace(&Hit { instance, ..inner.hit(bvh) });
        }
        is_hit
    }

    fn curves(&self, _: u32) -> Option<&CurveSet> {
        // The hierarchy holds instances only.
        None
    }

    fn passes_alpha_test(&self, _: &TraversalRay, _: &Hit) -> bool {
        // The hierarchy holds instances only.
        true
    }
}
