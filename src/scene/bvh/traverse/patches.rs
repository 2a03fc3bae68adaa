//! Intersection of one ray with a packet of bilinear patches, and of eight rays with one patch.
//!
//! The lines of constant u of a patch are straight. The ray meets the one that lies in a plane with
//! it, which gives a quadratic equation for u; v and the distance follow (Reshetov 2019, "Cool
//! patches: a geometric approach to ray/bilinear patch intersections"). The equation is solved in
//! f64 from corners relative to the origin, so that patches far away lose no digits.

use super::LeafIntersector;
use super::nearest::NearestHit;
use super::ray::TraversalRay;
use super::ray_packet::RayPacket;
use crate::bvh::{Bvh, PatchPacket, PrimitiveId};
use petzval_base::lanes::vector::{add, cross, dot, scale, splat, sub};
use petzval_base::lanes::{Real, widen};
use petzval_base::rays::Hit;

/// Slack of u and v, so that no ray slips between two patches that share an edge. It is far above
/// the rounding of f64 and far below the rounding of f32.
const EDGE: f64 = 1e-10;

/// Hits of a ray on eight patches, by lane: the distance, or NaN, and u and v.
type PatchHits = [[f64; 8]; 3];

/// Corners of patches relative to the origins of rays.
type PatchCorners<D> = [[D; 3]; 4];

/// Intersects a ray with a packet of patches. Returns whether it found a nearer hit.
#[inline(never)]
pub(super) fn intersect_patches<R: Real<Scalar = f32>, const ANY: bool>(
    bvh: &Bvh,
    number: u32,
    leaves: &impl LeafIntersector,
    ray: &TraversalRay,
    nearest: &mut NearestHit,
) -> bool {
    let packet = &bvh.patches[number as usize];
    let mut found = false;
    for [t, u, v] in intersect::<R>(packet, ray) {
        for lane in 0..8 {
            let Some(hit) = packet.nearer_hit(lane, [t[lane], u[lane], v[lane]], nearest) else {
                continue;
            };
            if packet.alpha_tested && !leaves.passes_alpha_test(ray, &hit) {
                continue;
            }
            nearest.replace(&hit);
            found = true;
            if ANY {
                return true;
            }
        }
    }
    found
}

impl PatchPacket {
    /// Returns the hit of a ray on a patch, given distance, u and v, if it is nearer.
    #[inline(always)]
    fn nearer_hit(&self, patch: usize, [t, u, v]: [f64; 3], nearest: &NearestHit) -> Option<Hit> {
        let (t, id) = (t as f32, self.ids.0[patch & 7]);
        // False for a miss, which is NaN.
        let is_nearer = t > 0.0 && nearest.is_beyond_patch(t, id);
        let PrimitiveId { shape, triangle: primitive } = id;
        let hit = Hit { t, u: u as f32, v: v as f32, shape, primitive, ..Hit::MISS };
        is_nearer.then_some(hit)
    }

    /// Returns the number of its patches, which come before the missing ones.
    #[inline(always)]
    fn len(&self) -> usize {
        self.corners[0][0].iter().take_while(|x| !x.is_nan()).count()
    }
}

impl RayPacket {
    /// Intersects the rays in `mask` with each patch of a packet. Returns the rays that found a
    /// nearer hit, as a bit mask, or `None` if a patch needs an alpha test or the rays are fewer than
    /// the patches: one ray tests eight patches at once.
    #[inline(never)]
    pub(super) fn intersect_patches<R: Real<Scalar = f32>>(
        &mut self,
        packet: &PatchPacket,
        mask: u32,
    ) -> Option<u32> {
        let count = packet.len();
        if packet.alpha_tested || count > mask.count_ones() as usize {
            return None;
        }
        let mut found = 0;
        for lane in (0..8).step_by(R::LANES) {
            let active = mask >> lane & ((1 << R::LANES) - 1);
            if active == 0 {
                continue;
            }
            let [x, y, z] = self.load_columns::<R>(&self.origin, lane);
            let origin = [widen(x), widen(y), widen(z)];
            let [x, y, z] = self.load_columns::<R>(&self.direction, lane);
            let direction = [widen(x), widen(y), widen(z)];
            for patch in 0..count {
                let mut corners = [[R::Double::splat(0.0); 3]; 4];
                for corner in 0..4 {
                    for axis in 0..3 {
                        let p = f64::from(packet.corners[corner][axis][patch & 7]);
                        corners[corner][axis] = R::Double::splat(p) - origin[axis];
                    }
                }
                let lines = LinesInPlane::new(&corners, direction);
                for root in 0..2 {
                    let found_by_lane = lines.hit(root);
                    let (mut t, mut u, mut v) = ([0.0; 8], [0.0; 8], [0.0; 8]);
                    found_by_lane[0].store(&mut t);
                    found_by_lane[1].store(&mut u);
                    found_by_lane[2].store(&mut v);
                    let mut left = active & hit_lanes::<R>(found_by_lane[0]);
                    while left != 0 {
                        let i = left.trailing_zeros() as usize & 7;
                        left &= left - 1;
                        let ray = (lane + i) & 7;
                        let hit = packet.nearer_hit(patch, [t[i], u[i], v[i]], &self.nearest[ray]);
                        if let Some(hit) = hit {
                            self.nearest[ray].replace(&hit);
                            self.t[ray] = hit.t;
                            found |= 1 << ray;
                        }
                    }
                }
            }
        }
        Some(found)
    }
}

/// Returns the lanes whose distance is not NaN, as a bit mask.
#[inline(always)]
fn hit_lanes<R: Real<Scalar = f32>>(t: R::Double) -> u32 {
    R::Double::bits(t.equals(t))
}

/// Returns both hits of a ray on each patch of a packet.
#[inline(always)]
fn intersect<R: Real<Scalar = f32>>(packet: &PatchPacket, ray: &TraversalRay) -> [PatchHits; 2] {
    let mut hits = [[[0.0; 8]; 3]; 2];
    let direction = splat::<R::Double>(ray.direction.map(f64::from));
    for lane in (0..8).step_by(R::LANES) {
        let mut corners = [[R::Double::splat(0.0); 3]; 4];
        for corner in 0..4 {
            for axis in 0..3 {
                let p = widen(R::load(&packet.corners[corner][axis][lane..]));
                corners[corner][axis] = p - R::Double::splat(f64::from(ray.origin[axis]));
            }
        }
        let lines = LinesInPlane::new(&corners, direction);
        for root in 0..2 {
            let [t, u, v] = lines.hit(root);
            t.store(&mut hits[root][0][lane..]);
            u.store(&mut hits[root][1][lane..]);
            v.store(&mut hits[root][2][lane..]);
        }
    }
    hits
}

/// Lines of constant u of a patch that are in one plane with a ray from the coordinates' origin.
struct LinesInPlane<D> {
    direction: [D; 3],
    /// Corner at (0, 0), and the side from there to (1, 0).
    first: [D; 3],
    bottom: [D; 3],
    /// Side from (0, 0) to (0, 1), and the difference of the opposite side to it.
    left: [D; 3],
    widening: [D; 3],
    /// u of both lines; NaN or outside 0 to 1 if there is none.
    u: [D; 2],
}

impl<D: Real<Scalar = f64>> LinesInPlane<D> {
    #[inline(always)]
    fn new(&[a, b, c, d]: &PatchCorners<D>, direction: [D; 3]) -> Self {
        let (zero, half) = (D::splat(0.0), D::splat(0.5));
        let (bottom, left, right) = (sub(b, a), sub(c, a), sub(d, b));
        let widening = sub(right, left);
        // The line at u starts at q = a + u bottom and runs along s = left + u widening. It is in a
        // plane with the ray where direction . (q x s) = 0.
        let constant = dot(direction, cross(a, left));
        let square = dot(direction, cross(bottom, widening));
        let linear = dot(direction, cross(b, right)) - constant - square;
        let root = (linear * linear - D::splat(4.0) * square * constant).sqrt();
        // The sum of two numbers of the same sign.
        let sum = -half * (linear + D::select(linear.lt(zero), -root, root));
        Self { direction, first: a, bottom, left, widening, u: [sum / square, constant / sum] }
    }

    /// Returns the distance at which the ray meets a line, NaN outside the patch, and u and v.
    #[inline(always)]
    fn hit(&self, line: usize) -> [D; 3] {
        let (zero, one) = (D::splat(0.0), D::splat(1.0));
        let (low, high) = (D::splat(-EDGE), D::splat(1.0 + EDGE));
        let u = self.u[line];
        let q = add(self.first, scale(self.bottom, u));
        let s = add(self.left, scale(self.widening, u));
        let normal = cross(self.direction, s);
        let inverse = one / dot(normal, normal);
        let t = dot(cross(q, s), normal) * inverse;
        let v = dot(cross(q, self.direction), normal) * inverse;
        let inside = low.le(u) & u.le(high) & low.le(v) & v.le(high);
        let t = D::select(inside, t, D::splat(f64::NAN));
        [t, u.max(zero).min(one), v.max(zero).min(one)]
    }
}
