//! Aspheres: a conic of revolution and a polynomial in the height.
//!
//! With P(h) the polynomial and w = z - P(h), a point lies on the surface where
//! c (h^2 + (1 + k) w^2) - 2 w = 0 on the sheet 1 - c (1 + k) w > 0: no root in the function
//! that Newton's iteration sees, one division a step. It starts from the conic. Its answer
//! counts where the height along the ray rises over the surface everywhere, so that there is
//! but one crossing; every other ray is searched for its first crossing inside the slab that
//! holds the surface, by halving a bracket. A ray without a crossing misses.

use super::prescription::Row;
use super::refract::{Crossed, Kernel, Lanes, LensRay, meet_conic, refracted};
use crate::lanes::Real;

/// The numbers of an asphere, +z along the way of the ray.
#[derive(Clone, Debug, PartialEq)]
pub struct Asphere<T> {
    /// Whether there are odd powers.
    pub odd: bool,
    /// 1 + k.
    k1: T,
    /// From the highest power to the square: a_p and p a_p.
    terms: Vec<[T; 2]>,
    /// Lowest and highest sag inside the clear diameter, a little widened, mm.
    slab: [T; 2],
    /// Square of the steepest slope inside the clear diameter, a little widened.
    slope2: T,
    /// Half the clear diameter, mm.
    half: T,
    /// A step of the iteration below this ends it, mm.
    tolerance: T,
    /// Steps that almost every ray needs.
    passes: usize,
}

impl<T: Copy> Asphere<T> {
    /// A row's asphere for rays along +z (`sign` 1) or -z (-1) of lens space.
    pub fn new<R: Real<Scalar = T>>(row: &Row, sign: f64) -> Self {
        let odd = row.asphere.iter().any(|(power, _)| power % 2 == 1);
        let highest = row.asphere.iter().map(|&(power, _)| power).max().unwrap_or(2);
        let coefficient =
            |p: u32| row.asphere.iter().filter(|(q, _)| *q == p).map(|(_, a)| sign * a).sum();
        let terms = (2..=highest)
            .rev()
            .filter(|power| odd || power % 2 == 0)
            .map(|p| (p, coefficient(p)))
            .map(|(p, a): (u32, f64)| [R::scalar(a), R::scalar(f64::from(p) * a)])
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
        // Between two samples the sag may go on for half a step at the steepest slope.
        let margin = half / f64::from(SAMPLES) * slope.min(1e3) + 1e-6 * half;
        let slope = slope * 1.01 + 1e-6;
        // From the conic the error, in units of the aperture, is squared by every step.
        let tolerance = 16.0 * R::EPSILON;
        let error = |steps: usize| departure.min(0.5).powi(1 << steps);
        let passes = 1 + (1..4).find(|&steps| error(steps) <= tolerance).unwrap_or(4);
        Self {
            odd,
            k1: R::scalar(1.0 + row.conic),
            terms,
            slab: [R::scalar(low - margin), R::scalar(high + margin)],
            slope2: R::scalar((slope * slope).min(1e30)),
            half: R::scalar(half),
            tolerance: R::scalar(half * tolerance),
            passes,
        }
    }
}

/// Heights at which a surface is measured when it is made.
const SAMPLES: u32 = 512;
/// Steps of Newton's iteration, which doubles the digits with every one; what needs more is
/// searched.
const STEPS: usize = 8;
/// The shortest step on the way through the slab to a first crossing is the way divided by this.
const PARTS: usize = 1024;

/// An asphere in every lane.
pub(super) struct AsphereLanes<'a, R: Real, const ODD: bool, const FAR: bool>(
    pub Lanes<R>,
    pub &'a Asphere<R::Scalar>,
);

/// The implicit function at a point.
struct Local<R> {
    /// w - c (h^2 + (1 + k) w^2) / 2: how far the point lies over the surface, nearly.
    over: R,
    /// The normal, of any length: minus the function's gradient, forward.
    normal: [R; 3],
}

impl<R: Real, const ODD: bool, const FAR: bool> AsphereLanes<'_, R, ODD, FAR> {
    /// P(h) and P'(h) / h.
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

    /// Newton's step from a point of the ray, in units of T, and the normal there.
    #[inline(always)]
    fn step(&self, p: [R; 3], [tx, ty, tz]: [R; 3]) -> (R, [R; 3]) {
        let Local { over, normal: [nx, ny, nz] } = self.local(p);
        let fall = tx.mul_add(nx, ty.mul_add(ny, tz * nz));
        (-(over / fall), [nx, ny, nz])
    }

    /// Points and normals of the lanes of a packet that not all are settled: first by more of
    /// Newton's steps, then by a search. A settled lane stands still, so that its neighbours
    /// change nothing.
    #[cold]
    #[inline(never)]
    fn settle(
        &self,
        ray: &LensRay<R>,
        once: R::Mask,
        settled: R::Mask,
        p: [R; 3],
        normal: [R; 3],
    ) -> ([R; 3], [R; 3]) {
        let mut end = p;
        let mut done = settled | !ray.p[0].same(ray.p[0]);
        for _ in 0..STEPS {
            let (step, _) = self.step(end, ray.t);
            let next = advanced(end, step, ray.t);
            end = [0, 1, 2].map(|i| R::select(done, end[i], next[i]));
            done = done | self.ended(step, ray.t[2]);
            if R::bits(!done) == 0 {
                break;
            }
        }
        let there = self.local(end).normal;
        let late = done & self.counts(end, there, ray.t[2], once);
        let found = self.search(ray, once);
        let end = [0, 1, 2].map(|i| R::select(late, end[i], found[i]));
        // A point beyond the clear diameter is on the level part, whatever the polynomial says:
        // the ray is clipped there and does not miss.
        let there = self.local(end).normal;
        let clear = self.0.clear(end[0], end[1]);
        let level = [R::constant(0.0), R::constant(0.0), R::constant(1.0)];
        let there = [0, 1, 2].map(|i| R::select(clear, there[i], level[i]));
        (
            [0, 1, 2].map(|i| R::select(settled, p[i], end[i])),
            [0, 1, 2].map(|i| R::select(settled, normal[i], there[i])),
        )
    }

    /// Whether a step is short enough to be the last.
    #[inline(always)]
    fn ended(&self, step: R, tz: R) -> R::Mask {
        (step * tz).abs().le(R::splat(self.1.tolerance))
    }

    /// Whether the end of an iteration is the crossing: beyond the clear diameter the polynomial
    /// may run wild and have one of its own, and the conic has another sheet.
    #[inline(always)]
    fn counts(&self, p: [R; 3], normal: [R; 3], tz: R, once: R::Mask) -> R::Mask {
        let zero = R::constant(0.0);
        once & self.0.clear(p[0], p[1]) & zero.lt(normal[2]) & zero.lt(tz)
    }

    /// How far a point lies over the surface along z; beyond the clear diameter over a surface
    /// that goes on level.
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

    /// The first crossing inside the slab, by halving a bracket. The lanes in `once` cross but
    /// once; lanes without a crossing are not numbers.
    #[cold]
    #[inline(never)]
    fn search(&self, ray: &LensRay<R>, once: R::Mask) -> [R; 3] {
        let per_tz = R::constant(1.0) / ray.t[2];
        let [low, high] = self.1.slab.map(|z| (R::splat(z) - ray.p[2]) * per_tz);
        let zero = R::constant(0.0);
        let above = |s: R| zero.le(self.height_over(advanced(ray.p, s, ray.t)));
        // The slab begins under the surface and ends over it.
        let (mut under, mut over, mut found) = (low, high, once);
        if R::bits(!once) != 0 {
            // No step is longer than it takes to come up to the surface where it is steepest.
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
        // As many halvings as a number has digits, and some for the place of the slab.
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

#[inline(always)]
fn advanced<R: Real>(p: [R; 3], s: R, t: [R; 3]) -> [R; 3] {
    [s.mul_add(t[0], p[0]), s.mul_add(t[1], p[1]), s.mul_add(t[2], p[2])]
}

impl<R: Real, const ODD: bool, const FAR: bool> Kernel<R> for AsphereLanes<'_, R, ODD, FAR> {
    #[inline(always)]
    fn passes(&self) -> usize {
        self.1.passes
    }

    /// To the conic, then by Newton's steps.
    #[inline(always)]
    fn approach(&self, ray: LensRay<R>, pass: usize) -> LensRay<R> {
        let zero = R::constant(0.0);
        let (ray, s) = if pass == 0 {
            let ray = self.0.arrive::<FAR>(ray);
            let ([over, under], disc) = meet_conic(&ray, self.0.c, R::splat(self.1.k1));
            let met = zero.le(disc) & zero.lt(under.abs());
            // Where it misses the conic, to the plane of the vertex.
            let (z, tz) = (-ray.p[2], ray.t[2]);
            (ray, R::select(met, over, z) / R::select(met, under, tz))
        } else {
            let (step, _) = self.step(ray.p, ray.t);
            // A step that leads away, where the slope turns, is none.
            let away = R::constant(4.0) * R::splat(self.1.half);
            let near = (step * ray.t[2]).abs().le(away);
            (ray, R::select(near, step, zero))
        };
        LensRay { p: advanced(ray.p, s, ray.t), ..ray }
    }

    #[inline(always)]
    fn cross(&self, ray: LensRay<R>) -> Crossed<R> {
        let [tx, ty, tz] = ray.t;
        let (step, mut normal) = self.step(ray.p, ray.t);
        let mut p = advanced(ray.p, step, ray.t);
        // Steeper than the surface is anywhere: it crosses once.
        let across2 = tx.mul_add(tx, ty * ty);
        let once = (across2 * R::splat(self.1.slope2)).lt(tz * tz);
        let settled = self.ended(step, tz) & self.counts(p, normal, tz, once);
        let living = ray.p[0].same(ray.p[0]);
        if R::bits(living & !settled) != 0 {
            // Copies, so that what the cold call takes by reference stays in registers elsewhere.
            let ([x, y, z], [u, v, w], [nx, ny, nz]) = (p, ray.t, normal);
            let [from_x, from_y, from_z] = ray.p;
            let ray = LensRay { p: [from_x, from_y, from_z], t: [u, v, w], weight: ray.weight };
            (p, normal) = self.settle(&ray, once, settled, [x, y, z], [nx, ny, nz]);
        }
        refracted(&self.0, LensRay { p, ..ray }, normal)
    }
}
