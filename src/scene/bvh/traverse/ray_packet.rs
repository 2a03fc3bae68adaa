//! Traversal by packets of eight rays. All rays that reach a node test its boxes at once; a ray
//! that is the only one to reach a node continues with single-ray traversal.

use super::LeafIntersector;
use super::nearest::{NearestHit, intersect_alpha_tested, intersect_packet};
use super::ray::TraversalRay;
use super::single_ray::{push_child, traverse};
use crate::lanes::Real;
use crate::scene::bvh::{Bvh, Child, Node, PackedChild};

/// Up to eight rays whose directions are in the same octant.
pub(in crate::scene) struct RayPacket<'a> {
    rays: &'a [TraversalRay],
    /// As in [`TraversalRay`], by axis, term and ray.
    near: [[[f32; 8]; 2]; 3],
    far: [[[f32; 8]; 2]; 3],
    backward: [usize; 3],
    /// End of each ray; -1 for a missing or finished ray, so that it enters no box.
    t: [f32; 8],
}

impl<'a> RayPacket<'a> {
    /// Collects up to eight rays; the `t` of `nearest` is their ends.
    pub(in crate::scene) fn new(rays: &'a [TraversalRay], nearest: &[NearestHit]) -> Self {
        let mut bundle = Self {
            rays,
            near: [[[0.0; 8]; 2]; 3],
            far: [[[0.0; 8]; 2]; 3],
            backward: rays.first().map_or([0; 3], |ray| ray.backward),
            t: [-1.0; 8],
        };
        for (lane, (ray, nearest)) in rays.iter().zip(nearest).take(8).enumerate() {
            for axis in 0..3 {
                for i in 0..2 {
                    bundle.near[axis][i][lane] = ray.entry[axis][i];
                    bundle.far[axis][i][lane] = ray.exit[axis][i];
                }
            }
            bundle.t[lane] = nearest.t;
        }
        bundle
    }

    /// Traverses a hierarchy. With `ANY`, a ray stops at its first hit. Returns the rays that found
    /// a nearer hit, as a bit mask.
    pub(in crate::scene) fn traverse<R: Real<Scalar = f32>, const ANY: bool>(
        &mut self,
        bvh: &Bvh,
        leaves: &impl LeafIntersector,
        nearest: &mut [NearestHit],
        pending: &mut [u64],
    ) -> u32 {
        let mut found = 0;
        let mut top = 0;
        let mut next = (PackedChild::ROOT, (1u32 << self.rays.len()) - 1);
        loop {
            let (packed, mask) = next;
            let entered = match packed.node() {
                Some(i) if mask & (mask - 1) != 0 => {
                    self.intersect_children::<R, ANY>(&bvh.nodes[i], mask, pending, &mut top)
                }
                _ => {
                    let mut left = mask;
                    while left != 0 {
                        let lane = left.trailing_zeros() as usize;
                        left &= left - 1;
                        let (ray, best) = (&self.rays[lane], &mut nearest[lane]);
                        let rest = &mut pending[top..];
                        let is_hit = match packed.unpack() {
                            Child::Triangles(i) => intersect_packet::<R, ANY>(bvh, i, ray, best),
                            Child::AlphaTestedTriangles(i) => {
                                intersect_alpha_tested::<R>(bvh, i, leaves, ray, best)
                            }
                            Child::Node(_) => {
                                traverse::<R, ANY>(bvh, leaves, packed, ray, best, rest)
                            }
                            child => leaves.intersect_leaf::<R, ANY>(child, ray, best, rest),
                        };
                        found |= u32::from(is_hit) << lane;
                        self.t[lane] = if ANY && is_hit { -1.0 } else { best.t };
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
                let ([nx, ny, nz], [fx, fy, fz]) = (&self.near, &self.far);
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
