//! Sampling of triangles uniformly by solid angle (Arvo 1995, "Stratified sampling of spherical
//! triangles"), lane by lane.
//!
//! Arvo's formulas cancel for triangles that look small. Here every difference of nearly equal
//! unit vectors comes from an edge of the triangle, and every 1 - cos is a versine, so that f32 is
//! exact to some 1e-5 at all sizes that are sampled by solid angle.

use petzval_base::lanes::Real;
use petzval_base::lanes::angle::{angle_above_axis, sin_versine};
use petzval_base::lanes::vector::{add, cross, dot, normalize, scale, scale_add, select, sub};

/// Projections of triangles onto the unit spheres about points. The first corner here is the nearest
/// one, as the edges from it are not long against the distances of their ends.
pub(super) struct SphericalTriangle<R: Real> {
    /// First corner relative to the point.
    corner: [R; 3],
    /// Edges from the first corner to the second and the third.
    edges: [[R; 3]; 2],
    /// Edges over the distances of their ends.
    tangents: [[R; 3]; 2],
    /// Unit vectors to the first and the second corner.
    directions: [[R; 3]; 2],
    /// Unit vectors to the second and the third corner, minus that to the first.
    chords: [[R; 3]; 2],
    /// Six times the volume of the tetrahedron that the unit vectors span.
    volume: R,
    /// Solid angle (sr).
    pub(super) solid_angle: R,
    /// Lanes that are sampled by solid angle; the others are better sampled by area.
    pub(super) by_solid_angle: R::Mask,
    /// Lanes whose first corner here is the second or the third of the triangle.
    rotated: [R::Mask; 2],
}

/// Least and largest solid angle (sr) that is sampled by solid angle, as in pbrt-v4. Below,
/// sampling by area is as good and cheaper; above, the point is practically on the triangle.
const LIMITS: [f32; 2] = [3e-4, 6.22];

impl<R: Real<Scalar = f32>> SphericalTriangle<R> {
    /// Projects triangles with these corners.
    #[inline(always)]
    pub(super) fn new(corners: &[[R; 3]; 3], from: [R; 3]) -> Self {
        let one = R::splat(1.0);
        let [p, q, r] = *corners;
        let squares = [sub(p, from), sub(q, from), sub(r, from)].map(|to| dot(to, to));
        let second = squares[1].lt(squares[0]) & squares[1].le(squares[2]);
        let third = squares[2].lt(squares[0]) & squares[2].lt(squares[1]);
        let rotate = |p, q, r| select(second, q, select(third, r, p));
        let corners = [rotate(p, q, r), rotate(q, r, p), rotate(r, p, q)];
        let [a, b, c] = [sub(corners[0], from), sub(corners[1], from), sub(corners[2], from)];
        let edges = [sub(corners[1], corners[0]), sub(corners[2], corners[0])];
        let [la, lb, lc] = [dot(a, a).sqrt(), dot(b, b).sqrt(), dot(c, c).sqrt()];
        let [ia, ib, ic] = [one / la, one / lb, one / lc];
        let (ua, ub, uc) = (scale(a, ia), scale(b, ib), scale(c, ic));
        let tangents = [scale(edges[0], ib), scale(edges[1], ic)];
        // u_b - u_a = (edge - u_a (l_b - l_a)) / l_b, and l_b - l_a = edge.(a + b) / (l_a + l_b).
        let longer = |edge: [R; 3], end: [R; 3], length: R| dot(edge, add(a, end)) / (la + length);
        let chords = [
            scale(scale_add(ua, -longer(edges[0], b, lb), edges[0]), ib),
            scale(scale_add(ua, -longer(edges[1], c, lc), edges[1]), ic),
        ];
        // Van Oosterom & Strackee 1983, "The solid angle of a plane triangle".
        let volume = dot(ua, cross(tangents[0], tangents[1])).abs();
        let denominator = one + dot(ua, ub) + dot(ub, uc) + dot(uc, ua);
        let solid_angle = R::splat(2.0) * angle_above_axis(volume, denominator);
        let by_solid_angle =
            R::splat(LIMITS[0]).lt(solid_angle) & solid_angle.lt(R::splat(LIMITS[1]));
        let directions = [ua, ub];
        let rotated = [second, third];
        Self {
            corner: a,
            edges,
            tangents,
            directions,
            chords,
            volume,
            solid_angle,
            by_solid_angle,
            rotated,
        }
    }

    /// Samples points uniformly by solid angle. Returns the barycentric weights of the second and
    /// the third corner, which are NaN where rounding spoils them.
    #[inline(always)]
    pub(super) fn sample(&self, u: [R; 2]) -> [R; 2] {
        let (zero, one, two) = (R::splat(0.0), R::splat(1.0), R::splat(2.0));
        let half = R::splat(0.5);
        let ([a, b], [to_b, to_c]) = (self.directions, self.chords);
        // Angle of the spherical triangle at a.
        let (ab, ca) = (cross(a, self.tangents[0]), cross(self.tangents[1], a));
        let lengths = (dot(ab, ab) * dot(ca, ca)).sqrt();
        let (cos_a, sin_a) = (-dot(ab, ca) / lengths, self.volume / lengths);
        // A point on the side ac such that the part of the triangle up to it has the fraction u of
        // the area. With the area phi of that part and A' = A - phi, Arvo's p and q are
        // cos A' - cos A and sin A cos ab - sin A'.
        let [sin_phi, versine_phi] = sin_versine(u[0] * self.solid_angle);
        let cos_phi = one - versine_phi;
        let sin_rest = sin_a * cos_phi - cos_a * sin_phi;
        let cos_rest = cos_a * cos_phi + sin_a * sin_phi;
        let p = sin_phi * sin_a - versine_phi * cos_a;
        let q = sin_phi * cos_a + versine_phi * sin_a - sin_a * half * dot(to_b, to_b);
        let side = (p * sin_phi + q * versine_phi) / ((p * cos_rest - q * sin_rest) * sin_a);
        // 0 / 0 if u is 0: the point is a itself.
        let side = side.max(zero).min(two);
        let sin_side = (side * (two - side)).sqrt();
        let along = across(to_c, a);
        let from_a = scale_add(along, sin_side, scale(a, -side));
        // A point on the arc from b to that point.
        let chord = sub(from_a, to_b);
        let versine = u[1] * half * dot(chord, chord);
        let sin = (versine * (two - versine)).max(zero).sqrt();
        let from_b = scale_add(across(chord, b), sin, scale(b, -versine));
        let [b, c] = self.meet(add(from_b, to_b));
        let (a, [second, third]) = ((one - b - c).max(zero), self.rotated);
        let nan = b + c;
        let a = R::select(nan.equals(nan), a, nan);
        [R::select(second, a, R::select(third, c, b)), R::select(second, b, R::select(third, a, c))]
    }

    /// Intersects directions with the planes of the triangles (Möller & Trumbore 1997), and clamps
    /// the weights to the triangles against rounding. `from_a` is the direction minus that to the
    /// first corner.
    #[inline(always)]
    fn meet(&self, from_a: [R; 3]) -> [R; 2] {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let [edge, other] = self.edges;
        let direction = add(self.directions[0], from_a);
        let inverse = one / dot(edge, cross(direction, other));
        let moment = cross(self.corner, from_a);
        let weights = [-dot(other, moment) * inverse, dot(edge, moment) * inverse];
        let infinity = R::splat(f32::INFINITY);
        let finite = weights[0].abs().lt(infinity) & weights[1].abs().lt(infinity);
        let (b, c) = (weights[0].max(zero).min(one), weights[1].max(zero).min(one));
        let inside = one / (b + c).max(one);
        let nan = R::splat(f32::NAN);
        [R::select(finite, b * inside, nan), R::select(finite, c * inside, nan)]
    }
}

/// Returns the unit vector perpendicular to `from` on the side of `v`; 0 if they are parallel.
#[inline(always)]
fn across<R: Real<Scalar = f32>>(v: [R; 3], from: [R; 3]) -> [R; 3] {
    normalize(scale_add(from, -dot(v, from), v)).0
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use petzval_base::lanes::f32x8;

    /// Solid angle of a triangle about the origin, in f64.
    fn solid_angle(corners: [DVec3; 3]) -> f64 {
        let [a, b, c] = corners.map(DVec3::normalize);
        2.0 * a.dot(b.cross(c)).abs().atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
    }

    /// Triangles of all sizes, near and far, edge-on and facing.
    fn triangles() -> Vec<[[f32; 3]; 3]> {
        let mut all = Vec::new();
        for size in [0.03, 0.3, 1.0, 10.0, 1000.0] {
            for height in [0.05, 1.0, 20.0] {
                for shift in [0.0, 0.7, 6.0] {
                    let base = [shift, -0.3, height];
                    let one = [shift + size, 0.1, height];
                    let other = [shift + 0.4 * size, 0.9 * size, height + 0.2 * size];
                    all.push([base, one, other]);
                    // Weights of a large triangle in f32 do not place a point near its last corner.
                    if size <= 10.0 {
                        all.extend([[one, other, base], [other, base, one]]);
                    }
                }
            }
        }
        all
    }

    #[test]
    fn a_lane_equals_a_single_number() {
        for corners in triangles() {
            let one = SphericalTriangle::new(&corners, [0.1, 0.2, 0.0]);
            let packet = corners.map(|corner| corner.map(f32x8::splat));
            let eight = SphericalTriangle::new(&packet, [0.1, 0.2, 0.0].map(f32x8::splat));
            assert_eq!(eight.solid_angle.to_array(), [one.solid_angle; 8]);
            let weights = eight.sample([f32x8::splat(0.3), f32x8::splat(0.8)]);
            let single = one.sample([0.3, 0.8]);
            let bits = |w: f32| w.to_bits();
            assert_eq!(weights.map(|w| bits(w.to_array()[5])), single.map(bits));
        }
    }

    #[test]
    fn the_part_of_the_triangle_up_to_a_sample_has_the_fraction_u_of_the_solid_angle() {
        let mut seen = 0;
        for corners in triangles() {
            let seen_triangle = SphericalTriangle::new(&corners, [0.0; 3]);
            // The first corner of the samples is the nearest one.
            let mut exact = corners.map(|c| DVec3::from_array(c.map(f64::from)));
            let near = |i: &usize| corners[*i].map(|x| x * x).iter().sum::<f32>();
            let first = (0..3).min_by(|i, j| near(i).total_cmp(&near(j))).unwrap_or(0);
            exact.rotate_left(first);
            let whole = solid_angle(exact);
            let off = f64::from(seen_triangle.solid_angle) / whole - 1.0;
            assert!(off.abs() < 2e-5, "{corners:?}: {off:e}");
            if !seen_triangle.by_solid_angle {
                continue;
            }
            seen += 1;
            for u in [0.0, 0.001, 0.25, 0.5, 0.9, 0.999] {
                for v in [0.0, 0.3, 1.0 - f32::EPSILON] {
                    let [b, c] = seen_triangle.sample([u, v]).map(f64::from);
                    let mut weights = [1.0 - b - c, b, c];
                    weights.rotate_left(first);
                    let [_, b, c] = weights;
                    assert!(b >= -1e-6 && c >= -1e-6 && b + c <= 1.0 + 1e-6, "{corners:?} {u} {v}");
                    let [pa, pb, pc] = exact;
                    let point = pa + (pb - pa) * b + (pc - pa) * c;
                    // The great circle through b and the sample cuts off the fraction u.
                    let part = if v > 0.0 {
                        let t = c / (1.0 - b).max(1e-300);
                        solid_angle([pa, pb, pa + (pc - pa) * t])
                    } else {
                        assert!((point.normalize() - pb.normalize()).length() < 1e-5);
                        continue;
                    };
                    let off = part / whole - f64::from(u);
                    assert!(off.abs() < 3e-5, "{corners:?} {u} {v}: {off:e}");
                    // Along the arc from b, the versine is the fraction v.
                    let t = c / (1.0 - b).max(1e-300);
                    let far = (pa + (pc - pa) * t).normalize().distance_squared(pb.normalize());
                    let near = point.normalize().distance_squared(pb.normalize());
                    assert!((near / far - f64::from(v)).abs() < 1e-4, "{corners:?} {u} {v}");
                }
            }
        }
        assert!(seen > 30, "{seen}");
    }
}
