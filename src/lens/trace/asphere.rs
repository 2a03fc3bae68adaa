//! Aspheres: a conic of revolution plus a polynomial in the height.
//!
//! With P(h) the polynomial and w = z - P(h), a point lies on the surface if
//! c (h^2 + (1 + k) w^2) = 2 w on the sheet 1 - c (1 + k) w > 0. This equation has no square root,
//! and a step of Newton's iteration costs one division. The iteration starts from the conic. Its
//! result is accepted if the ray is steeper than the surface everywhere, so that there is only one
//! crossing. For every other ray the first crossing is searched by bisection inside the slab that
//! contains the surface. A ray without a crossing misses.

use super::kernel::{KernelOutput, LensRay, SurfaceKernel, SurfaceLanes};
use super::refract::{meet_conic, refracted};
use crate::lanes::Real;
use crate::lens::prescription::Row;

/// Coefficients and bounds of an asphere, +z along the direction of travel.
#[derive(Clone, Debug, PartialEq)]
pub struct Asphere<T> {
    /// Whether there are odd powers.
    pub odd: bool,
    /// 1 + k.
    k1: T,
    /// a_p and p a_p, from the highest power to the square.
    terms: Vec<[T; 2]>,
    /// Lowest and highest sag inside the clear diameter, with a margin (mm).
    slab: [T; 2],
    /// Square of the steepest slope inside the clear diameter, with a margin.
    slope2: T,
    /// Semi-diameter (mm).
    half: T,
    /// Length of a step below which the iteration ends (mm).
    tolerance: T,
    /// Number of steps that almost every ray needs.
    passes: usize,
}

impl<T: Copy> Asphere<T> {
    /// Prepares the asphere of a row for rays along +z (`sign` 1) or -z (-1) of lens space.
    pub fn new<R: Real<Scalar = T>>(row: &Row, sign: f64) -> Self {
        let odd = row.asphere.iter().any(|(power, _)| power % 2 == 1);
        let highest = row.asphere.iter().map(|&(power, _)| power).max().unwrap_or(2);
        let coefficient =
            |p: u32| row.asphere.iter().filter(|(q, _)| *q == p).map(|(_, a)| sign * a).sum();
        let terms = (2..=highest)
            .rev()
            .filter(|power| odd || power % 2 == 0)
            .map(|p| (p, coefficient(p)))
            .map(|(p, a): (u32, f64)| [R::from_f64(a), R::from_f64(f64::from(p) * a)])
            .collect();
        let half = row.diameter / 2.0;
        let heights = (0..=SAMPLES).map(|i| half * f64::from(i) / f64::from(SAMPLES));
        let (mut low, mut high, mut slope) = (0.0f64, 0.0f64, 0.0f64);
        let mut departure = 0.0f64;
        let conic = Row { asphere: Vec::new(), ..row.clone() };
        for h in heights {
            departure = departure.max((row.sag(h) - conic.sag(h)).abs() / half);
            let sag = sign * row.sag(h);
            (low, high) = (low.min(sag), high.max(sag));
            slope = slope.max(row.slope(h).abs());
        }
        // Between two samples the sag may exceed them by half a step at the steepest slope.
        let margin = half / f64::from(SAMPLES) * slope.min(1e3) + 1e-6 * half;
        let slope = slope * 1.01 + 1e-6;
        // The error of the start, in units of the aperture, is squared by every step.
        let tolerance = 16.0 * R::EPSILON;
        let error = |steps: usize| departure.min(0.5).powi(1 << steps);
        let passes = 1 + (1..4).find(|&steps| error(steps) <= tolerance).unwrap_or(4);
        Self {
            odd,
            k1: R::from_f64(1.0 + row.conic),
            terms,
            slab: [R::from_f64(low - margin), R::from_f64(high + margin)],
            slope2: R::from_f64((slope * slope).min(1e30)),
            half: R::from_f64(half),
            tolerance: R::from_f64(half * tolerance),
            passes,
        }
    }
}

/// Number of heights at which a surface is sampled for its bounds.
const SAMPLES: u32 = 512;
/// Greatest number of Newton steps, each of which doubles the digits; rays that need more are
/// searched.
const STEPS: usize = 8;
/// Greatest number of steps through the slab to a first crossing.
const PARTS: usize = 1024;

/// Kernel of an asphere.
pub(crate) struct AsphereKernel<'a, R: Real, const ODD: bool, const FAR: bool>(
    pub SurfaceLanes<R>,
    pub &'a Asphere<R::Scalar>,
);

/// The implicit function at a point.
struct Local<R> {
    /// w - c (h^2 + (1 + k) w^2) / 2: about the height of the point over the surface.
    over: R,
    /// Normal of any length, forward: the negative gradient of the function.
    normal: [R; 3],
}

impl<R: Real, const ODD: bool, const FAR: bool> AsphereKernel<'_, R, ODD, FAR> {
    /// Returns P(h) and P'(h) / h.
    #[inline(always)]
    fn polynomial(&self, h2: R) -> (R, R) {
        let v = if ODD { h2.sqrt() } else { h2 };
        let zero = R::constant(0.0);
        let (mut value, mut slope) = (zero, zero);
        for &[a, pa] in &self.1.terms {
            value = value.mul_add(v, R::splat(a));
            slope = slope.mul_add(v, R::splat(pa));
        }
        (value * h2, slope)
    }

    #[inline(always)]
    fn local(&self, [x, y, z]: [R; 3]) -> Local<R> {
        let (c, k1) = (self.0.c, R::splat(self.1.k1));
        let h2 = x.mul_add(x, y * y);
        let (p, q) = self.polynomial(h2);
        let w = z - p;
        let half_c = c * R::constant(0.5);
        let over = (-half_c).mul_add((k1 * w).mul_add(w, h2), w);
        let normal_z = (-(c * k1)).mul_add(w, R::constant(1.0));
        let across = -q.mul_add(normal_z, c);
        Local { over, normal: [across * x, across * y, normal_z] }
    }

    /// Returns Newton's step from a point of the ray, in units of T, and the normal there.
    #[inline(always)]
    fn step(&self, p: [R; 3], [tx, ty, tz]: [R; 3]) -> (R, [R; 3]) {
        let Local { over, normal: [nx, ny, nz] } = self.local(p);
        let fall = tx.mul_add(nx, ty.mul_add(ny, tz * nz));
        (-(over / fall), [nx, ny, nz])
    }

    /// Returns points and normals of a packet in which not all lanes have converged: first by more
    /// of Newton's steps, then by a search. Lanes that have converged do not move, so that a result
    /// does not depend on its neighbours.
    #[cold]
    #[inline(never)]
    fn converge(
        &self,
        ray: &LensRay<R>,
        crosses_once: R::Mask,
        converged: R::Mask,
        p: [R; 3],
        normal: [R; 3],
    ) -> ([R; 3], [R; 3]) {
        let mut end = p;
        let mut done = converged | !ray.p[0].equals(ray.p[0]);
        for _ in 0..STEPS {
            let (step, _) = self.step(end, ray.t);
            let next = advanced(end, step, ray.t);
            end = [0, 1, 2].map(|i| R::select(done, end[i], next[i]));
            done = done | self.is_final(step, ray.t[2]);
            if R::bits(!done) == 0 {
                break;
            }
        }
        let there = self.local(end).normal;
        let late = done & self.is_crossing(end, there, ray.t[2], crosses_once);
        let found = self.search(ray, crosses_once);
        let end = [0, 1, 2].map(|i| R::select(late, end[i], found[i]));
        // A point beyond the clear diameter is on the level part, whatever the polynomial is there:
        // the ray is clipped and does not miss.
        let there = self.local(end).normal;
        let clear = self.0.clear(end[0], end[1]);
        let level = [R::constant(0.0), R::constant(0.0), R::constant(1.0)];
        let there = [0, 1, 2].map(|i| R::select(clear, there[i], level[i]));
        (
            [0, 1, 2].map(|i| R::select(converged, p[i], end[i])),
            [0, 1, 2].map(|i| R::select(converged, normal[i], there[i])),
        )
    }

    /// Returns whether a step is short enough to be the last.
    #[inline(always)]
    fn is_final(&self, step: R, tz: R) -> R::Mask {
        (step * tz).abs().le(R::splat(self.1.tolerance))
    }

    /// Returns whether the end of an iteration is the crossing with the surface. Beyond the clear
    /// diameter the polynomial may have a crossing of its own, and the conic has another sheet.
    #[inline(always)]
    fn is_crossing(&self, p: [R; 3], normal: [R; 3], tz: R, crosses_once: R::Mask) -> R::Mask {
        let zero = R::constant(0.0);
        crosses_once & self.0.clear(p[0], p[1]) & zero.lt(normal[2]) & zero.lt(tz)
    }

    /// Returns the height of a point over the surface along z. Beyond the clear diameter the
    /// surface is taken to be level.
    #[inline(always)]
    fn height_over(&self, [x, y, z]: [R; 3]) -> R {
        let (c, k1) = (self.0.c, R::splat(self.1.k1));
        let half = R::splat(self.1.half);
        let h2 = x.mul_add(x, y * y).min(half * half);
        let (p, _) = self.polynomial(h2);
        let (zero, one) = (R::constant(0.0), R::constant(1.0));
        let root = (-(k1 * c * c)).mul_add(h2, one).max(zero).sqrt();
        z - p - c * h2 / (one + root)
    }

    /// Returns the first crossing inside the slab, by bisection. Lanes in `crosses_once` have
    /// exactly one crossing; lanes without a crossing become NaN.
    #[cold]
    #[inline(never)]
    fn search(&self, ray: &LensRay<R>, crosses_once: R::Mask) -> [R; 3] {
        let per_tz = R::constant(1.0) / ray.t[2];
        let [low, high] = self.1.slab.map(|z| (R::splat(z) - ray.p[2]) * per_tz);
        let zero = R::constant(0.0);
        let above = |s: R| zero.le(self.height_over(advanced(ray.p, s, ray.t)));
        // The near face of the slab is under the surface, the far face over it.
        let (mut under, mut over, mut found) = (low, high, crosses_once);
        if R::bits(!crosses_once) != 0 {
            // A step never overshoots a surface of the steepest slope.
            let [tx, ty, tz] = ray.t;
            let across = tx.mul_add(tx, ty * ty).sqrt();
            let quickest = across.mul_add(R::splat(self.1.slope2).sqrt(), tz);
            let part = (high - low) * R::constant(1.0 / PARTS as f64);
            let mut s = low;
            let mut going = s.lt(high) & !found;
            for _ in 0..=PARTS {
                if R::bits(going) == 0 {
                    break;
                }
                under = R::select(going, s, under);
                let below = -self.height_over(advanced(ray.p, s, ray.t));
                s = s + (below / quickest).max(part);
                let crossing = above(s) & going;
                over = R::select(crossing, s, over);
                found = found | crossing;
                going = going & s.lt(high) & !crossing;
            }
        }
        // As many bisections as a number has digits, and some for the size of the slab.
        for _ in 0..(8.0 - R::EPSILON.log2()) as usize {
            let middle = (under + over) * R::constant(0.5);
            let above = above(middle);
            over = R::select(above, middle, over);
            under = R::select(above, under, middle);
        }
        let p = advanced(ray.p, over, ray.t);
        let forward = found & zero.lt(ray.t[2]);
        [R::select(forward, p[0], R::constant(f64::NAN)), p[1], p[2]]
    }
}

/// Returns the point at a distance `s` along T.
#[inline(always)]
fn advanced<R: Real>(p: [R; 3], s: R, t: [R; 3]) -> [R; 3] {
    [s.mul_add(t[0], p[0]), s.mul_add(t[1], p[1]), s.mul_add(t[2], p[2])]
}

impl<R: Real, const ODD: bool, const FAR: bool> SurfaceKernel<R>
    for AsphereKernel<'_, R, ODD, FAR>
{
    #[inline(always)]
    fn passes(&self) -> usize {
        self.1.passes
    }

    /// Moves the ray to the conic in the first pass, and by a Newton step in each later one.
    #[inline(always)]
    fn approach(&self, ray: LensRay<R>, pass: usize) -> LensRay<R> {
        let zero = R::constant(0.0);
        let (ray, s) = if pass == 0 {
            let ray = self.0.arrive::<FAR>(ray);
            let ([over, under], disc) = meet_conic(&ray, self.0.c, R::splat(self.1.k1));
            let met = zero.le(disc) & zero.lt(under.abs());
            // A ray that misses the conic goes to the plane of the vertex.
            let (z, tz) = (-ray.p[2], ray.t[2]);
            (ray, R::select(met, over, z) / R::select(met, under, tz))
        } else {
            let (step, _) = self.step(ray.p, ray.t);
            // A step that leads far away, near a point of zero slope, is not taken.
            let away = R::constant(4.0) * R::splat(self.1.half);
            let near = (step * ray.t[2]).abs().le(away);
            (ray, R::select(near, step, zero))
        };
        LensRay { p: advanced(ray.p, s, ray.t), ..ray }
    }

    #[inline(always)]
    fn cross(&self, ray: LensRay<R>) -> KernelOutput<R> {
        let [tx, ty, tz] = ray.t;
        let (step, mut normal) = self.step(ray.p, ray.t);
        let mut p = advanced(ray.p, step, ray.t);
        // A ray that is steeper than the surface everywhere crosses it once.
        let across2 = tx.mul_add(tx, ty * ty);
        let crosses_once = (across2 * R::splat(self.1.slope2)).lt(tz * tz);
        let converged = self.is_final(step, tz) & self.is_crossing(p, normal, tz, crosses_once);
        let living = ray.p[0].equals(ray.p[0]);
        if R::bits(living & !converged) != 0 {
            // Copies, so that the values passed to the cold call by reference stay in registers
            // elsewhere.
            let ([x, y, z], [u, v, w], [nx, ny, nz]) = (p, ray.t, normal);
            let [from_x, from_y, from_z] = ray.p;
            let ray = LensRay { p: [from_x, from_y, from_z], t: [u, v, w], weight: ray.weight };
            (p, normal) = self.converge(&ray, crosses_once, converged, [x, y, z], [nx, ny, nz]);
        }
        refracted(&self.0, LensRay { p, ..ray }, normal)
    }
}
