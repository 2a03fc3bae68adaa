//! Intersection of rays with triangles: one ray with a packet of eight, or eight rays with one.
//!
//! The edge functions of Woop, Benthin & Wald (2013, "Watertight ray/triangle intersection") make
//! it watertight: two triangles that share an edge compute the same number for it, so no ray
//! slips between them.

use super::ray::TraversalRay;
use crate::bvh::TrianglePacket;
use crate::geometry::gamma;
use petzval_base::lanes::Real;

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

/// Corners of triangles relative to the origins of rays, by corner and axis. The axis of the largest
/// component of the direction comes last, after those that follow it in turn.
pub(super) type Corners<R> = [[R; 3]; 3];

/// Hits of rays on triangles, with the numbers of [`Candidates`].
pub(super) struct EdgeTest<R: Real> {
    pub(super) mask: R::Mask,
    pub(super) t: R,
    pub(super) edge: [R; 2],
    pub(super) sum: R,
}

/// Intersects rays with triangles. Hits are at a distance between 0 and `t_max`, to rounding.
#[inline(always)]
pub(super) fn test_edges<R: Real<Scalar = f32>>(
    corners: &Corners<R>,
    shear: [R; 3],
    t_max: R,
) -> EdgeTest<R> {
    let corner = |i: usize| {
        let [x, y, z] = corners[i];
        [(-shear[0]).mul_add(z, x), (-shear[1]).mul_add(z, y), z]
    };
    let [[ax, ay, az], [bx, by, bz], [cx, cy, cz]] = [corner(0), corner(1), corner(2)];
    // Never fused: an edge shared by two triangles must give the same number, up to its
    // sign, for both. Products round monotonically, so a sign is never wrong; at worst the
    // number is 0, which counts as inside on both sides.
    let (u, v, w) = (cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax);
    let zero = R::constant(0.0);
    let inside = zero.le(u.min(v).min(w)) | u.max(v).max(w).le(zero);
    let sum = u + v + w;
    let t = u.mul_add(az, v.mul_add(bz, w * cz)) * shear[2];
    // A ray in the plane of its triangle has a sum of 0 and fails the last comparison, even
    // if t_max is infinite, because 0 * inf is NaN.
    let ahead = R::select(zero.lt(sum), t, -t);
    let before = ahead.le(sum.abs() * t_max);
    EdgeTest { mask: inside & zero.lt(ahead) & before, t, edge: [v, w], sum }
}

/// Returns the triangles that a ray hits at a distance between 0 and `t_max`, to rounding.
#[inline(always)]
pub(super) fn intersect_triangles<R: Real<Scalar = f32>>(
    packet: &TrianglePacket,
    ray: &TraversalRay,
    t_max: f32,
) -> Candidates {
    let mut hits = Candidates { mask: 0, t: [0.0; 8], edge: [[0.0; 8]; 2], sum: [0.0; 8] };
    let shear = [R::splat(ray.shear[0]), R::splat(ray.shear[1]), R::splat(ray.shear[2])];
    for lane in (0..8).step_by(R::LANES) {
        let corners = relative_corners::<R>(packet, lane, ray);
        let test = test_edges(&corners, shear, R::splat(t_max));
        hits.mask |= R::bits(test.mask) << lane;
        test.t.store(&mut hits.t[lane..]);
        test.edge[0].store(&mut hits.edge[0][lane..]);
        test.edge[1].store(&mut hits.edge[1][lane..]);
        test.sum.store(&mut hits.sum[lane..]);
    }
    hits
}

/// Returns the corners of the triangles from a lane on, relative to the origin of a ray.
#[inline(always)]
fn relative_corners<R: Real<Scalar = f32>>(
    packet: &TrianglePacket,
    lane: usize,
    ray: &TraversalRay,
) -> Corners<R> {
    // The axes are a permutation of 0, 1 and 2; `min` spares the bounds checks.
    let [x, y, z] = ray.axes;
    let axes = [x.min(2), y.min(2), z.min(2)];
    let mut corners = [[R::constant(0.0); 3]; 3];
    for corner in 0..3 {
        for i in 0..3 {
            let axis = axes[i];
            let p = R::load(&packet.corners[corner][axis][lane..]);
            corners[corner][i] = p - R::splat(ray.origin[axis]);
        }
    }
    corners
}

/// Returns whether a hit is certainly ahead of the ray's origin, and not on the surface that the
/// ray leaves.
#[inline(always)]
pub(super) fn is_ahead(packet: &TrianglePacket, lane: usize, ray: &TraversalRay, t: f32) -> bool {
    let corners = relative_corners::<f32>(packet, lane & 7, ray);
    are_ahead(&corners, ray.shear, t, true)
}

/// Returns which hits are certainly ahead of the rays' origins, and not on the surfaces that the
/// rays leave.
#[inline(always)]
pub(super) fn are_ahead<R: Real<Scalar = f32>>(
    corners: &Corners<R>,
    shear: [R; 3],
    t: R,
    hits: R::Mask,
) -> R::Mask {
    // The signs of differences are exact, and a hit lies between the corners of its triangle. If
    // all corners are ahead, the hit is too, however large the error of the edge functions is.
    let zero = R::constant(0.0);
    let before = |corner: usize| zero.lt(corners[corner][2] * shear[2]);
    let sure = before(0) & before(1) & before(2);
    if R::bits(hits & !sure) == 0 {
        return sure;
    }
    sure | t_error(corners, shear).lt(t)
}

/// Returns a bound on the absolute error of the distance to a hit. A nearer hit may be on the
/// surface that the ray leaves (Pharr, Jakob & Humphreys, "Physically Based Rendering", 6.8.7).
#[inline(always)]
fn t_error<R: Real<Scalar = f32>>(corners: &Corners<R>, shear: [R; 3]) -> R {
    let zero = R::constant(0.0);
    let (mut x, mut y, mut z) = ([zero; 3], [zero; 3], [zero; 3]);
    for corner in 0..3 {
        let [across, up, along] = corners[corner];
        x[corner] = across - shear[0] * along;
        y[corner] = up - shear[1] * along;
        z[corner] = shear[2] * along;
    }
    let edge = [x[2] * y[1] - y[2] * x[1], x[0] * y[2] - y[0] * x[2], x[1] * y[0] - y[1] * x[0]];
    let sum = edge[0] + edge[1] + edge[2];
    let largest = |[a, b, c]: [R; 3]| a.abs().max(b.abs()).max(c.abs());
    let (x, y, z, edge) = (largest(x), largest(y), largest(z), largest(edge));
    let [g2, g3, g5] = [R::splat(gamma(2)), R::splat(gamma(3)), R::splat(gamma(5))];
    let (dx, dy, dz) = (g5 * (x + z), g5 * (y + z), g3 * z);
    let d_edge = R::constant(2.0) * (g2 * x * y + dy * x + dx * y);
    R::constant(3.0) * (g3 * edge * z + d_edge * z + dz * edge) / sum.abs()
}
