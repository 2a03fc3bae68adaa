//! Traversal by packets of eight rays. All rays that reach a node test its boxes at once; if only
//! one or two reach it, each continues with single-ray traversal.

use super::LeafIntersector;
use super::nearest::{NearestHit, intersect_packet};
use super::ray::{RayQueue, RayTerms, TraversalRay, backward};
use super::single_ray::{push_child, traverse};
use crate::bvh::{Bvh, Child, Node, PackedChild};
use petzval_base::lanes::Real;

/// Least number of rays that test the boxes of a node in step. Two rays are faster one by one: a
/// single ray tests eight boxes at once.
const LEAST_IN_STEP: u32 = 3;

/// Up to eight rays whose directions are in the same octant, and their nearest hits so far.
#[derive(Debug)]
pub(crate) struct RayPacket {
    /// By axis and ray.
    pub(super) origin: [[f32; 8]; 3],
    pub(super) direction: [[f32; 8]; 3],
    /// As in [`RayTerms`], by axis, term and ray.
    entry: [[[f32; 8]; 2]; 3],
    exit: [[[f32; 8]; 2]; 3],
    pub(super) largest: [f32; 8],
    pub(super) shear: [[f32; 8]; 3],
    backward: [usize; 3],
    /// End of each ray; -1 for a missing or finished ray, so that it enters no box.
    pub(super) t: [f32; 8],
    pub(crate) nearest: [NearestHit; 8],
    /// Rays that went on alone, and which of them are there, as a bit mask.
    single: [TraversalRay; 8],
    singled_out: u32,
}

impl Default for RayPacket {
    fn default() -> Self {
        let columns = [[0.0; 8]; 3];
        let pairs = [[[0.0; 8]; 2]; 3];
        Self {
            origin: columns,
            direction: columns,
            entry: pairs,
            exit: pairs,
            largest: [0.0; 8],
            shear: columns,
            backward: [0; 3],
            t: [-1.0; 8],
            nearest: [NearestHit::new(0.0); 8],
            single: [TraversalRay::default(); 8],
            singled_out: 0,
        }
    }
}

impl RayPacket {
    /// Takes over the rays of a queue.
    pub(crate) fn load<R: Real<Scalar = f32>>(&mut self, queue: &RayQueue) {
        (self.origin, self.direction) = (queue.origin, queue.direction);
        self.backward = backward(queue.octant);
        self.singled_out = 0;
        for lane in (0..8).step_by(R::LANES) {
            let (mut origin, mut direction) = ([R::constant(0.0); 3], [R::constant(0.0); 3]);
            for axis in 0..3 {
                origin[axis] = R::load(&queue.origin[axis][lane..]);
                direction[axis] = R::load(&queue.direction[axis][lane..]);
            }
            let terms = RayTerms::new(origin, direction);
            for axis in 0..3 {
                for i in 0..2 {
                    terms.entry[axis][i].store(&mut self.entry[axis][i][lane..]);
                    terms.exit[axis][i].store(&mut self.exit[axis][i][lane..]);
                }
                terms.shear[axis].store(&mut self.shear[axis][lane..]);
            }
            terms.largest.store(&mut self.largest[lane..]);
        }
        for lane in 0..8 {
            self.t[lane] = if lane < queue.len { queue.t_max[lane] } else { -1.0 };
            self.nearest[lane] = NearestHit::new(self.t[lane]);
        }
    }

    /// Prepares a ray that goes on alone.
    #[inline(always)]
    fn single_out(&mut self, lane: usize) {
        if self.singled_out >> lane & 1 == 1 {
            return;
        }
        self.singled_out |= 1 << lane;
        let lane = lane & 7;
        let (mut entry, mut exit) = ([[0.0; 2]; 3], [[0.0; 2]; 3]);
        let (mut origin, mut direction, mut shear) = ([0.0; 3], [0.0; 3], [0.0; 3]);
        for axis in 0..3 {
            origin[axis] = self.origin[axis][lane];
            direction[axis] = self.direction[axis][lane];
            shear[axis] = self.shear[axis][lane];
            for i in 0..2 {
                entry[axis][i] = self.entry[axis][i][lane];
                exit[axis][i] = self.exit[axis][i][lane];
            }
        }
        let terms = RayTerms { entry, exit, shear, largest: self.largest[lane] };
        self.single[lane] = TraversalRay::from_terms(origin, direction, terms);
    }

    /// Traverses a hierarchy with the first `len` rays. With `ANY`, a ray stops at its first hit.
    /// Returns the rays that found a nearer hit, as a bit mask.
    pub(crate) fn traverse<R: Real<Scalar = f32>, const ANY: bool>(
        &mut self,
        len: usize,
        bvh: &Bvh,
        leaves: &impl LeafIntersector,
        pending: &mut [u64],
    ) -> u32 {
        let mut found = 0;
        let mut top = 0;
        let mut next = (PackedChild::ROOT, (1u32 << len) - 1);
        loop {
            let (packed, mask) = next;
            let is_alone = mask & (mask - 1) == 0;
            let entered = match packed.node() {
                Some(i) if mask.count_ones() >= LEAST_IN_STEP => {
                    self.intersect_children::<R, ANY>(&bvh.nodes[i], mask, pending, &mut top)
                }
                _ => {
                    let in_step = match packed.unpack() {
                        Child::Triangles(i) if !is_alone => {
                            self.intersect_triangles::<R, ANY>(bvh, i, mask)
                        }
                        Child::Quadric(i) if !is_alone => {
                            self.intersect_quadric::<R>(&bvh.quadrics[i as usize], mask)
                        }
                        Child::Patches(i) if !is_alone => {
                            self.intersect_patches::<R>(&bvh.patches[i as usize], mask)
                        }
                        _ => None,
                    };
                    let hit = match in_step {
                        Some(hit) => hit,
                        None => {
                            let rest = &mut pending[top..];
                            self.intersect_one_by_one::<R, ANY>(bvh, leaves, packed, mask, rest)
                        }
                    };
                    found |= hit;
                    if ANY {
                        let mut left = hit;
                        while left != 0 {
                            self.t[left.trailing_zeros() as usize & 7] = -1.0;
                            left &= left - 1;
                        }
                    }
                    None
                }
            };
            next = match entered {
                Some(next) => next,
                None => loop {
                    if top == 0 {
                        return found;
                    }
                    top -= 1;
                    let (enters, mask, packed) = unpack(pending[top]);
                    let mask = mask & self.rays_reaching::<R>(enters);
                    if mask != 0 {
                        break (packed, mask);
                    }
                },
            };
        }
    }

    /// Intersects the rays in `mask` with a child, one after the other. Returns the rays that found
    /// a nearer hit, as a bit mask.
    #[inline(always)]
    fn intersect_one_by_one<R: Real<Scalar = f32>, const ANY: bool>(
        &mut self,
        bvh: &Bvh,
        leaves: &impl LeafIntersector,
        child: PackedChild,
        mask: u32,
        pending: &mut [u64],
    ) -> u32 {
        let (mut left, mut found) = (mask, 0);
        while left != 0 {
            let lane = left.trailing_zeros() as usize & 7;
            left &= left - 1;
            self.single_out(lane);
            let (ray, best) = (&self.single[lane], &mut self.nearest[lane]);
            let is_hit = match child.unpack() {
                Child::Triangles(i) => intersect_packet::<R, ANY>(bvh, i, ray, best),
                _ => traverse::<R, ANY>(bvh, leaves, child, ray, best, pending),
            };
            found |= u32::from(is_hit) << lane;
            self.t[lane] = best.t;
        }
        found
    }

    /// Returns the rays that do not end before a distance, as a bit mask.
    #[inline(always)]
    fn rays_reaching<R: Real<Scalar = f32>>(&self, distance: f32) -> u32 {
        let mut mask = 0;
        for lane in (0..8).step_by(R::LANES) {
            mask |= R::bits(R::splat(distance).le(R::load(&self.t[lane..]))) << lane;
        }
        mask
    }

    /// Intersects the rays in `mask` with the boxes of a node. Returns the nearest child and the
    /// rays that enter it, if any; pushes the other children onto the stack, the nearest on top.
    #[inline(always)]
    fn intersect_children<R: Real<Scalar = f32>, const ANY: bool>(
        &self,
        node: &Node,
        mask: u32,
        pending: &mut [u64],
        top: &mut usize,
    ) -> Option<(PackedChild, u32)> {
        let mut enters = [[0.0f32; 8]; 8];
        // Eight bits for each child: the rays that enter it.
        let mut entered = 0u64;
        let [bx, by, bz] = self.backward;
        let (bx, by, bz) = (bx & 1, by & 1, bz & 1);
        for lane in (0..8).step_by(R::LANES) {
            for child in 0..8 {
                let at = |side: usize, axis: usize, [factor, term]: &[[f32; 8]; 2]| {
                    let plane = R::splat(node.bounds[axis][side][child]);
                    plane.mul_add(R::load(&factor[lane..]), R::load(&term[lane..]))
                };
                let ([nx, ny, nz], [fx, fy, fz]) = (&self.entry, &self.exit);
                let near =
                    at(bx, 0, nx).max(at(by, 1, ny)).max(at(bz, 2, nz).max(R::constant(0.0)));
                let far = at(1 - bx, 0, fx).min(at(1 - by, 1, fy));
                let far = far.min(at(1 - bz, 2, fz).min(R::load(&self.t[lane..])));
                let inside = near.le(far);
                entered |= u64::from(R::bits(inside)) << (8 * child + lane);
                let never = R::splat(f32::INFINITY);
                R::select(inside, near, never).store(&mut enters[child][lane..]);
            }
        }
        entered &= u64::from(mask) * 0x0101_0101_0101_0101;
        if entered == 0 {
            return None;
        }
        let bottom = *top;
        let mut nearest = u64::MAX;
        while entered != 0 {
            let child = (entered.trailing_zeros() as usize / 8) & 7;
            let rays = entered >> (8 * child) & 0xff;
            entered &= !(0xff << (8 * child));
            let key = pack(&enters[child], rays, node.children[child]);
            if nearest != u64::MAX {
                push_child::<ANY>(key.max(nearest), bottom, pending, top);
            }
            nearest = nearest.min(key);
        }
        let (_, rays, packed) = unpack(nearest);
        Some((packed, rays))
    }
}

/// Packs a child and the rays that enter it into a key: the least entry distance, rounded down to
/// 24 bits, above the eight bits of the ray mask, above the child. Keys sort by distance.
#[inline(always)]
fn pack(enters: &[f32; 8], rays: u64, child: PackedChild) -> u64 {
    // Floats of at least 0 sort like their bits.
    let first = enters.iter().fold(u32::MAX, |least, t| least.min(t.to_bits()));
    (u64::from(first & !0xff) | rays) << 32 | child.key(0.0)
}

/// Returns the distance, ray mask and child of a key.
#[inline(always)]
fn unpack(key: u64) -> (f32, u32, PackedChild) {
    let high = (key >> 32) as u32;
    (f32::from_bits(high & !0xff), high & 0xff, PackedChild::from_key(key))
}
