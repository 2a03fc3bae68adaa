//! One ray against eight triangles.
//!
//! Watertight by the edge functions of Woop, Benthin & Wald (2013, "Watertight ray/triangle
//! intersection"): two triangles that share an edge compute the same number for it, so no ray
//! slips between them.

use super::ray::Prepared;
use crate::lanes::Real;
use crate::scene::point::gamma;
use crate::scene::tree::Packet;

/// The triangles of a packet that a ray meets, as bits, and where. Distances and weights are
/// multiplied by the sum of the edge functions: most hits are not the nearest, and are never
/// divided.
#[derive(Clone, Copy)]
pub(super) struct Candidates {
    pub(super) mask: u32,
    t: [f32; 8],
    edge: [[f32; 8]; 2],
    sum: [f32; 8],
}

impl Candidates {
    /// The distance of one of them.
    #[inline(always)]
    pub(super) fn distance(&self, lane: usize) -> f32 {
        self.t[lane & 7] / self.sum[lane & 7]
    }

    /// The barycentric weights of the second and the third corner.
    #[inline(always)]
    pub(super) fn weights(&self, lane: usize) -> [f32; 2] {
        let [v, w] = &self.edge;
        [v[lane & 7] / self.sum[lane & 7], w[lane & 7] / self.sum[lane & 7]]
    }
}

/// Which triangles a ray meets not behind `t_max`, to rounding.
#[inline(always)]
pub(super) fn triangles<R: Real<Scalar = f32>>(
    packet: &Packet,
    ray: &Prepared,
    t_max: f32,
) -> Candidates {
    let [kx, ky, kz] = axes(ray);
    let mut met = Candidates { mask: 0, t: [0.0; 8], edge: [[0.0; 8]; 2], sum: [0.0; 8] };
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
        // Never fused: the edge shared by two triangles must give the same number, up to its
        // sign, from both. Products round monotonically, so a sign is never wrong; at worst a
        // number is 0, and 0 counts as inside on both sides.
        let (u, v, w) = (cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax);
        let zero = R::constant(0.0);
        let inside = zero.le(u.min(v).min(w)) | u.max(v).max(w).le(zero);
        let sum = u + v + w;
        let t = u.mul_add(az, v.mul_add(bz, w * cz)) * R::splat(ray.shear[2]);
        // A ray in the plane of its triangle has a sum of 0 and fails the last comparison,
        // as 0 * inf is NaN.
        let ahead = R::select(zero.lt(sum), t, -t);
        let before = ahead.le(sum.abs() * R::splat(t_max));
        met.mask |= R::bits(inside & zero.lt(ahead) & before) << lane;
        t.store(&mut met.t[lane..]);
        v.store(&mut met.edge[0][lane..]);
        w.store(&mut met.edge[1][lane..]);
        sum.store(&mut met.sum[lane..]);
    }
    met
}

#[inline(always)]
fn axes(ray: &Prepared) -> [usize; 3] {
    // They are 0, 1 and 2 in some order, which spares the bounds checks.
    let [x, y, z] = ray.axes;
    [x.min(2), y.min(2), z.min(2)]
}

/// Whether a candidate is certainly ahead of the ray's origin, and not the surface that the ray
/// leaves.
#[inline(always)]
pub(super) fn ahead(packet: &Packet, lane: usize, ray: &Prepared, t: f32) -> bool {
    let kz = axes(ray)[2];
    // The signs of differences are exact, and where a ray meets a triangle it is between its
    // corners: no error of the edges, be the triangle ever so far away, can take it out.
    let before = |corner: usize| {
        (packet.corners[corner][kz][lane & 7] - ray.origin[kz]) * ray.shear[2] > 0.0
    };
    (before(0) && before(1) && before(2)) || t_error(packet, lane, ray) < t
}

/// A bound on the absolute error of the distance of a candidate: what is nearer than that may be
/// the surface that the ray leaves (Pharr, Jakob & Humphreys, "Physically Based Rendering",
/// 6.8.7).
fn t_error(packet: &Packet, lane: usize, ray: &Prepared) -> f32 {
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
