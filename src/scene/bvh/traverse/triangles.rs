//! Intersection of one ray with a packet of eight triangles.
//!
//! The edge functions of Woop, Benthin & Wald (2013, "Watertight ray/triangle intersection") make
//! it watertight: two triangles that share an edge compute the same number for it, so no ray
//! slips between them.

use super::ray::TraversalRay;
use crate::lanes::Real;
use crate::scene::bvh::TrianglePacket;
use crate::scene::geometry::gamma;

/// Triangles of a packet that a ray hits, as a bit mask, with their distances and weights. Both are
/// multiplied by the sum of the edge functions, because most hits are not the nearest and never
/// need the division.
#[derive(Clone, Copy)]
pub(super) struct Candidates {
    pub(super) mask: u32,
    t: [f32; 8],
    edge: [[f32; 8]; 2],
    sum: [f32; 8],
}

impl Candidates {
    /// Returns the distance to a triangle.
    #[inline(always)]
    pub(super) fn distance(&self, lane: usize) -> f32 {
        self.t[lane & 7] / self.sum[lane & 7]
    }

    /// Returns the barycentric weights of a triangle's second and third corner.
    #[inline(always)]
    pub(super) fn weights(&self, lane: usize) -> [f32; 2] {
        let [v, w] = &self.edge;
        [v[lane & 7] / self.sum[lane & 7], w[lane & 7] / self.sum[lane & 7]]
    }
}

/// Returns the triangles that a ray hits at a distance between 0 and `t_max`, to rounding.
#[inline(always)]
pub(super) fn intersect_triangles<R: Real<Scalar = f32>>(
    packet: &TrianglePacket,
    ray: &TraversalRay,
    t_max: f32,
) -> Candidates {
    let [kx, ky, kz] = axes(ray);
    let mut hits = Candidates { mask: 0, t: [0.0; 8], edge: [[0.0; 8]; 2], sum: [0.0; 8] };
    for lane in (0..8).step_by(R::LANES) {
        let corner = |i: usize| {
            let relative = |axis: usize| {
                R::load(&packet.corners[i][axis][lane..]) - R::splat(ray.origin[axis])
            };
            let z = relative(kz);
            [
                R::splat(-ray.shear[0]).mul_add(z, relative(kx)),
                R::splat(-ray.shear[1]).mul_add(z, relative(ky)),
                z,
            ]
        };
        let [[ax, ay, az], [bx, by, bz], [cx, cy, cz]] = [corner(0), corner(1), corner(2)];
        // Never fused: an edge shared by two triangles must give the same number, up to its
        // sign, for both. Products round monotonically, so a sign is never wrong; at worst the
        // number is 0, which counts as inside on both sides.
        let (u, v, w) = (cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax);
        let zero = R::constant(0.0);
        let inside = zero.le(u.min(v).min(w)) | u.max(v).max(w).le(zero);
        let sum = u + v + w;
        let t = u.mul_add(az, v.mul_add(bz, w * cz)) * R::splat(ray.shear[2]);
        // A ray in the plane of its triangle has a sum of 0 and fails the last comparison, even
        // if t_max is infinite, because 0 * inf is NaN.
        let ahead = R::select(zero.lt(sum), t, -t);
        let before = ahead.le(sum.abs() * R::splat(t_max));
        hits.mask |= R::bits(inside & zero.lt(ahead) & before) << lane;
        t.store(&mut hits.t[lane..]);
        v.store(&mut hits.edge[0][lane..]);
        w.store(&mut hits.edge[1][lane..]);
        sum.store(&mut hits.sum[lane..]);
    }
    hits
}

#[inline(always)]
fn axes(ray: &TraversalRay) -> [usize; 3] {
    // The axes are a permutation of 0, 1 and 2; `min` spares the bounds checks.
    let [x, y, z] = ray.axes;
    [x.min(2), y.min(2), z.min(2)]
}

/// Returns whether a hit is certainly ahead of the ray's origin, and not on the surface that the
/// ray leaves.
#[inline(always)]
pub(super) fn is_ahead(packet: &TrianglePacket, lane: usize, ray: &TraversalRay, t: f32) -> bool {
    let kz = axes(ray)[2];
    // The signs of differences are exact, and a hit lies between the corners of its triangle. If
    // all corners are ahead, the hit is too, however large the error of the edge functions is.
    let before = |corner: usize| {
        (packet.corners[corner][kz][lane & 7] - ray.origin[kz]) * ray.shear[2] > 0.0
    };
    (before(0) && before(1) && before(2)) || t_error(packet, lane, ray) < t
}

/// Returns a bound on the absolute error of the distance to a hit. A nearer hit may be on the
/// surface that the ray leaves (Pharr, Jakob & Humphreys, "Physically Based Rendering", 6.8.7).
fn t_error(packet: &TrianglePacket, lane: usize, ray: &TraversalRay) -> f32 {
    let [kx, ky, kz] = axes(ray);
    let (mut x, mut y, mut z) = ([0.0f32; 3], [0.0f32; 3], [0.0f32; 3]);
    for corner in 0..3 {
        let relative = |axis: usize| packet.corners[corner][axis][lane & 7] - ray.origin[axis];
        let along = relative(kz);
        x[corner] = relative(kx) - ray.shear[0] * along;
        y[corner] = relative(ky) - ray.shear[1] * along;
        z[corner] = ray.shear[2] * along;
    }
    let edge = [x[2] * y[1] - y[2] * x[1], x[0] * y[2] - y[0] * x[2], x[1] * y[0] - y[1] * x[0]];
    let sum = edge[0] + edge[1] + edge[2];
    let largest = |[a, b, c]: [f32; 3]| a.abs().max(b.abs()).max(c.abs());
    let (x, y, z, edge) = (largest(x), largest(y), largest(z), largest(edge));
    let (dx, dy, dz) = (gamma(5) * (x + z), gamma(5) * (y + z), gamma(3) * z);
    let d_edge = 2.0 * (gamma(2) * x * y + dy * x + dx * y);
    3.0 * (gamma(3) * edge * z + d_edge * z + dz * edge) / sum.abs()
}
