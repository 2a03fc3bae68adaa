//! The way of eight rays through a tree, as long as they go together: a box is tested with
//! eight rays at a time, and a ray that is left alone goes on by itself.

use super::Beyond;
use super::nearest::{Nearest, cutouts, packet};
use super::ray::Prepared;
use super::walk::{wait, walk};
use crate::lanes::Real;
use crate::scene::tree::{Child, Code, Node, Tree};

/// Up to eight rays that go into the same octant.
pub(in crate::scene) struct Bundle<'a> {
    rays: &'a [Prepared],
    /// As in [`Prepared`], by axis and ray.
    near: [[[f32; 8]; 2]; 3],
    far: [[[f32; 8]; 2]; 3],
    backward: [usize; 3],
    /// Where each ray ends; -1 for one that is missing or done, which no box is before.
    t: [f32; 8],
}

impl<'a> Bundle<'a> {
    /// Gathers rays.
    pub(in crate::scene) fn new(rays: &'a [Prepared], nearest: &[Nearest]) -> Self {
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
                    bundle.near[axis][i][lane] = ray.near[axis][i];
                    bundle.far[axis][i][lane] = ray.far[axis][i];
                }
            }
            bundle.t[lane] = nearest.t;
        }
        bundle
    }

    /// Walks a tree. With `ANY` a ray stops at its first hit. Answers which rays have a new
    /// nearest hit, as bits.
    pub(in crate::scene) fn walk<R: Real<Scalar = f32>, const ANY: bool>(
        &mut self,
        tree: &Tree,
        beyond: &impl Beyond,
        nearest: &mut [Nearest],
        pending: &mut [u64],
    ) -> u32 {
        let mut found = 0;
        let mut top = 0;
        let mut next = (Code::ROOT, (1u32 << self.rays.len()) - 1);
        loop {
            let (code, mask) = next;
            let entered = match code.node() {
                Some(i) if mask & (mask - 1) != 0 => {
                    self.enter::<R, ANY>(&tree.nodes[i], mask, pending, &mut top)
                }
                _ => {
                    let mut left = mask;
                    while left != 0 {
                        let lane = left.trailing_zeros() as usize;
                        left &= left - 1;
                        let (ray, best) = (&self.rays[lane], &mut nearest[lane]);
                        let rest = &mut pending[top..];
                        let met = match code.child() {
                            Child::Triangles(i) => packet::<R, ANY>(tree, i, ray, best),
                            Child::Cutouts(i) => cutouts::<R>(tree, i, beyond, ray, best),
                            Child::Node(_) => walk::<R, ANY>(tree, beyond, code, ray, best, rest),
                            child => beyond.meet::<R, ANY>(child, ray, best, rest),
                        };
                        found |= u32::from(met) << lane;
                        self.t[lane] = if ANY && met { -1.0 } else { best.t };
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
                    let (enters, mask, code) = unpack(pending[top]);
                    let mask = mask & self.beyond::<R>(enters);
                    if mask != 0 {
                        break (code, mask);
                    }
                },
            };
        }
    }

    /// Which rays do not end before a distance.
    #[inline(always)]
    fn beyond<R: Real<Scalar = f32>>(&self, distance: f32) -> u32 {
        let mut mask = 0;
        for lane in (0..8).step_by(R::LANES) {
            mask |= R::bits(R::splat(distance).le(R::load(&self.t[lane..]))) << lane;
        }
        mask
    }

    /// The child of a node to go on with, and the rays that meet it, if any does; the others
    /// wait, the nearest on top.
    #[inline(always)]
    fn enter<R: Real<Scalar = f32>, const ANY: bool>(
        &self,
        node: &Node,
        mask: u32,
        pending: &mut [u64],
        top: &mut usize,
    ) -> Option<(Code, u32)> {
        let mut enters = [[0.0f32; 8]; 8];
        // Eight bits for the rays that meet each child.
        let mut met = 0u64;
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
                met |= u64::from(R::bits(inside)) << (8 * child + lane);
                let never = R::splat(f32::INFINITY);
                R::select(inside, near, never).store(&mut enters[child][lane..]);
            }
        }
        met &= u64::from(mask) * 0x0101_0101_0101_0101;
        if met == 0 {
            return None;
        }
        let bottom = *top;
        let mut nearest = u64::MAX;
        while met != 0 {
            let child = (met.trailing_zeros() as usize / 8) & 7;
            let rays = met >> (8 * child) & 0xff;
            met &= !(0xff << (8 * child));
            let key = pack(&enters[child], rays, node.children[child]);
            if nearest != u64::MAX {
                wait::<ANY>(key.max(nearest), bottom, pending, top);
            }
            nearest = nearest.min(key);
        }
        let (_, rays, code) = unpack(nearest);
        Some((code, rays))
    }
}

/// A child that waits for rays: where the first of them enters it, rounded down to 24 bits,
/// above the rays, above its code. Keys are in the order of the distances.
#[inline(always)]
fn pack(enters: &[f32; 8], rays: u64, code: Code) -> u64 {
    // Numbers from 0 up are in the order of their bits.
    let first = enters.iter().fold(u32::MAX, |least, t| least.min(t.to_bits()));
    (u64::from(first & !0xff) | rays) << 32 | code.key(0.0)
}

#[inline(always)]
fn unpack(key: u64) -> (f32, u32, Code) {
    let high = (key >> 32) as u32;
    (f32::from_bits(high & !0xff), high & 0xff, Code::from_key(key))
}
