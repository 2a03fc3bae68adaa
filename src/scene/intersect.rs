//! The stages that find what rays meet: the nearest hit, or any hit.
//!
//! Rays of a wave that go into the same octant walk the tree in bundles of eight. What a ray
//! meets does not depend on which others are in its bundle.

use glam::{Affine3A, DVec3, Vec3};

use super::Scene;
use super::traverse::{Beyond, Bundle, Nearest, Prepared, TraversalStack, walk};
use super::tree::{Child, Code, Tree};
use crate::lanes::Real;
use crate::rays::{Column, Hit, HitBatch, Ray, RayBatch};
use crate::stats::Lanes;

impl Scene {
    /// The nearest hit of every ray: a stage. Answers how full its bundles were.
    pub fn intersect<R: Real<Scalar = f32>>(
        &self,
        rays: &RayBatch,
        hits: &mut HitBatch,
        stack: &mut TraversalStack,
    ) -> Lanes {
        hits[..rays.len].fill(Hit::MISS);
        for i in 0..rays.len {
            hits[i].t = rays.t_max[i];
        }
        self.bundles::<R, false>(rays, stack, |i, nearest, _| hits[i] = nearest.hit(&self.world))
    }

    /// Whether anything is in the way of each shadow ray; what is unshadowed is added to the
    /// radiance of its sample: a stage. Answers how full its bundles were.
    pub fn occlude<R: Real<Scalar = f32>>(
        &self,
        rays: &RayBatch,
        stack: &mut TraversalStack,
        radiance: &mut [Column<f32>; 3],
    ) -> Lanes {
        let mut blocked = [false; crate::rays::WAVE];
        let lanes = self.bundles::<R, true>(rays, stack, |i, _, met| blocked[i] = met);
        // In the order of the rays, since sums round.
        for i in 0..rays.len {
            if !blocked[i] {
                let slot = rays.slot[i] as usize;
                for (column, carried) in radiance.iter_mut().zip(rays.carried(i)) {
                    column[slot] += carried;
                }
            }
        }
        lanes
    }

    /// The nearest hit of one ray.
    pub fn closest<R: Real<Scalar = f32>>(&self, ray: &Ray, stack: &mut TraversalStack) -> Hit {
        let mut nearest = Nearest::new(ray.t_max);
        self.one::<R, false>(ray, &mut nearest, stack);
        nearest.hit(&self.world)
    }

    /// Whether anything is in the way of one ray.
    pub fn occluded<R: Real<Scalar = f32>>(&self, ray: &Ray, stack: &mut TraversalStack) -> bool {
        self.one::<R, true>(ray, &mut Nearest::new(ray.t_max), stack)
    }

    fn one<R: Real<Scalar = f32>, const ANY: bool>(
        &self,
        ray: &Ray,
        nearest: &mut Nearest,
        stack: &mut TraversalStack,
    ) -> bool {
        let Some(ray) = Prepared::new(ray.origin, ray.direction) else { return false };
        walk::<R, ANY>(&self.world, self, Code::ROOT, &ray, nearest, self.room(stack))
    }

    /// Sends the rays of a wave through the world, and tells of each that can meet anything what
    /// it met, and whether. Answers how full the bundles were.
    fn bundles<R: Real<Scalar = f32>, const ANY: bool>(
        &self,
        rays: &RayBatch,
        stack: &mut TraversalStack,
        mut tell: impl FnMut(usize, &Nearest, bool),
    ) -> Lanes {
        let mut lanes = Lanes::default();
        let pending = self.room(stack);
        let mut octants = [Queue::default(); 8];
        let mut flush = |queue: &mut Queue| {
            let len = std::mem::take(&mut queue.len);
            if len == 0 {
                return;
            }
            lanes.add(Lanes::packed(len));
            let (rays, nearest) = (&queue.rays[..len], &mut queue.nearest[..len]);
            let met =
                Bundle::new(rays, nearest).walk::<R, ANY>(&self.world, self, nearest, pending);
            for lane in 0..len {
                tell(queue.index[lane] as usize, &nearest[lane], met >> lane & 1 == 1);
            }
        };
        for i in 0..rays.len {
            let ray = rays.ray(i);
            let Some(prepared) = Prepared::new(ray.origin, ray.direction) else { continue };
            let queue = &mut octants[prepared.octant()];
            queue.rays[queue.len] = prepared;
            queue.nearest[queue.len] = Nearest::new(ray.t_max);
            queue.index[queue.len] = i as u32;
            queue.len += 1;
            if queue.len == 8 {
                flush(queue);
            }
        }
        octants.iter_mut().for_each(flush);
        lanes
    }

    /// Room for all that a ray may have to remember, in the world and in an object.
    pub(super) fn room<'a>(&self, stack: &'a mut TraversalStack) -> &'a mut [u64] {
        let objects = self.objects.iter().map(|tree| tree.pending).max();
        stack.room(self.world.pending.max(self.movers.pending()) + objects.unwrap_or(0))
    }

    /// Meets a quadric.
    fn quadric(&self, shape: u32, ray: &Prepared, nearest: &mut Nearest) -> bool {
        let whole = &self.shapes[shape as usize];
        let Some(quadric) = whole.quadric() else { return false };
        let double = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        let (origin, direction) = (double(ray.origin), double(ray.direction));
        let mut start = 0.0;
        // A ray that passes through a hole on the near side may meet the far one.
        while let Some(t) =
            quadric.intersect(origin + direction * start, direction, f64::from(nearest.t) - start)
        {
            let t = start + t;
            let hit = Hit { t: t as f32, u: 0.0, v: 0.0, shape, primitive: 0, ..Hit::MISS };
            if hit.t <= 0.0 || hit.t >= nearest.t {
                return false;
            }
            if whole.holds(ray.origin, ray.direction, &hit) {
                nearest.replace(&hit);
                return true;
            }
            start = t * (1.0 + 1e-9);
        }
        false
    }
}

/// Rays of one octant that wait for their bundle.
#[derive(Clone, Copy)]
struct Queue {
    rays: [Prepared; 8],
    nearest: [Nearest; 8],
    index: [u32; 8],
    len: usize,
}

impl Default for Queue {
    fn default() -> Self {
        let (rays, nearest) = ([Prepared::default(); 8], [Nearest::new(0.0); 8]);
        Self { rays, nearest, index: [0; 8], len: 0 }
    }
}

impl Beyond for Scene {
    #[inline(never)]
    fn meet<R: Real<Scalar = f32>, const ANY: bool>(
        &self,
        child: Child,
        ray: &Prepared,
        nearest: &mut Nearest,
        pending: &mut [u64],
    ) -> bool {
        match child {
            Child::Quadric(shape) => self.quadric(shape, ray, nearest),
            Child::Instance(number) => {
                let instance = &self.instances[number as usize];
                let tree: &Tree = &self.objects[instance.object as usize];
                let Some(ray) = inside(ray, &instance.object_from_world) else { return false };
                let mut inner = Nearest::new(nearest.t);
                let met = walk::<R, ANY>(tree, self, Code::ROOT, &ray, &mut inner, pending);
                if met {
                    nearest.replace(&Hit { instance: number, ..inner.hit(tree) });
                }
                met
            }
            Child::Node(_) | Child::Triangles(_) | Child::Cutouts(_) => false,
        }
    }

    fn solid(&self, ray: &Prepared, [shape, primitive]: [u32; 2], [u, v]: [f32; 2]) -> bool {
        let hit = Hit { t: 0.0, u, v, shape, primitive, ..Hit::MISS };
        self.shapes[shape as usize].holds(ray.origin, ray.direction, &hit)
    }
}

/// A ray in the space of an instanced object; distances along it stay what they are.
pub(super) fn inside(ray: &Prepared, matrix: &Affine3A) -> Option<Prepared> {
    let origin = matrix.transform_point3(Vec3::from(ray.origin));
    let direction = matrix.transform_vector3(Vec3::from(ray.direction));
    Prepared::new(origin.to_array(), direction.to_array())
}
