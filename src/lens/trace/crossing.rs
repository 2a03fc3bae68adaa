//! Crossing of a ray with a surface that has no closed formula.
//!
//! Newton's iteration starts near the surface. Its result is accepted if the ray is steeper than
//! the surface everywhere, so that there is only one crossing. For every other ray the first
//! crossing is searched by bisection inside the slab that contains the surface. A ray without a
//! crossing misses.

use super::kernel::{KernelOutput, LensRay, SurfaceLanes};
use super::refract::{meet_conic, refracted};
use petzval_base::lanes::Real;

/// Greatest number of Newton steps, each of which doubles the digits; rays that need more are
/// searched.
const STEPS: usize = 8;
/// Greatest number of steps through the slab to a first crossing.
const PARTS: usize = 1024;
/// Length of a step below which the iteration ends, in units of the precision and the aperture.
const TOLERANCE: f64 = 16.0;

/// Bounds of a surface inside its clear diameter.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SurfaceBounds<T> {
    /// Lowest and highest sag, with a margin (mm).
    slab: [T; 2],
    /// Square of the steepest slope, with a margin.
    slope2: T,
    /// Semi-diameter (mm).
    pub half: T,
    /// Length of a step below which the iteration ends (mm).
    tolerance: T,
}

impl<T: Copy> SurfaceBounds<T> {
    /// Returns the bounds of a surface of this lowest and highest sag (mm), steepest slope and
    /// semi-diameter (mm).
    pub fn new<R: Real<Scalar = T>>([low, high]: [f64; 2], slope: f64, half: f64) -> Self {
        let slope = slope * 1.01 + 1e-6;
        Self {
            slab: [R::from_f64(low), R::from_f64(high)],
            slope2: R::from_f64((slope * slope).min(1e30)),
            half: R::from_f64(half),
            tolerance: R::from_f64(half * (TOLERANCE * R::EPSILON)),
        }
    }
}

/// Returns the number of approaches that almost every ray needs, for a start that is off by at most
/// `departure` semi-diameters. Every step squares the error.
pub(super) fn newton_passes<R: Real>(departure: f64) -> usize {
    let error = |steps: usize| departure.min(0.5).powi(1 << steps);
    1 + (1..4).find(|&steps| error(steps) <= TOLERANCE * R::EPSILON).unwrap_or(4)
}

/// The implicit function of a surface at a point.
pub(super) struct Local<R> {
    /// Value of the function: about the height of the point over the surface.
    pub over: R,
    /// Normal of any length, forward: the gradient of the function.
    pub normal: [R; 3],
}

/// A surface given by an implicit function.
pub(super) trait ImplicitSurface<R: Real> {
    fn lanes(&self) -> &SurfaceLanes<R>;

    fn bounds(&self) -> &SurfaceBounds<R::Scalar>;

    /// Returns the function at a point.
    fn local(&self, p: [R; 3]) -> Local<R>;

    /// Returns the height of a point over the surface along z. Beyond the clear diameter the
    /// surface is taken to be level in the radial direction.
    fn height_over(&self, p: [R; 3]) -> R;
}

/// Returns P(h) and P'(h) / h of a polynomial in the height, from h^2. `terms` are a_p and p a_p from
/// the highest power to the square, without the odd powers unless `odd`.
#[inline(always)]
pub(super) fn polynomial<R: Real>(terms: &[[R::Scalar; 2]], odd: bool, h2: R) -> (R, R) {
    let v = if odd { h2.sqrt() } else { h2 };
    let zero = R::constant(0.0);
    let (mut value, mut slope) = (zero, zero);
    for &[a, pa] in terms {
        value = value.mul_add(v, R::splat(a));
        slope = slope.mul_add(v, R::splat(pa));
    }
    (value * h2, slope)
}

/// Moves a ray to a conic, the start of the iteration.
#[inline(always)]
pub(super) fn start_on_conic<R: Real>(ray: LensRay<R>, c: R, k1: R) -> LensRay<R> {
    let zero = R::constant(0.0);
    let ([over, under], disc) = meet_conic(&ray, c, k1);
    let met = zero.le(disc) & zero.lt(under.abs());
    // A ray that misses the conic goes to the plane of the vertex.
    let (z, tz) = (-ray.p[2], ray.t[2]);
    let s = R::select(met, over, z) / R::select(met, under, tz);
    LensRay { p: advanced(ray.p, s, ray.t), ..ray }
}

/// Moves a ray by a Newton step.
#[inline(always)]
pub(super) fn newton_pass<R: Real>(
    surface: &impl ImplicitSurface<R>,
    ray: LensRay<R>,
) -> LensRay<R> {
    let (step, _) = newton_step(surface, ray.p, ray.t);
    // A step that leads far away, near a point of zero slope, is not taken.
    let away = R::constant(4.0) * R::splat(surface.bounds().half);
    let near = (step * ray.t[2]).abs().le(away);
    let s = R::select(near, step, R::constant(0.0));
    LensRay { p: advanced(ray.p, s, ray.t), ..ray }
}

/// Takes a ray that is close to the surface to it and through it.
#[inline(always)]
pub(super) fn cross_implicit<R: Real>(
    surface: &impl ImplicitSurface<R>,
    ray: LensRay<R>,
) -> KernelOutput<R> {
    let [tx, ty, tz] = ray.t;
    let (step, mut normal) = newton_step(surface, ray.p, ray.t);
    let mut p = advanced(ray.p, step, ray.t);
    // A ray that is steeper than the surface everywhere crosses it once.
    let across2 = tx.mul_add(tx, ty * ty);
    let crosses_once = (across2 * R::splat(surface.bounds().slope2)).lt(tz * tz);
    let converged = is_final(surface, step, tz) & is_crossing(surface, p, normal, tz, crosses_once);
    let living = ray.p[0].equals(ray.p[0]);
    if R::bits(living & !converged) != 0 {
        // Copies, so that the values passed to the cold call by reference stay in registers
        // elsewhere.
        let ([x, y, z], [u, v, w], [nx, ny, nz]) = (p, ray.t, normal);
        let [from_x, from_y, from_z] = ray.p;
        let ray = LensRay { p: [from_x, from_y, from_z], t: [u, v, w], weight: ray.weight };
        (p, normal) = converge(surface, &ray, crosses_once, converged, [x, y, z], [nx, ny, nz]);
    }
    refracted(surface.lanes(), LensRay { p, ..ray }, normal)
}

/// Returns Newton's step from a point of the ray, in units of T, and the normal there.
#[inline(always)]
fn newton_step<R: Real>(
    surface: &impl ImplicitSurface<R>,
    p: [R; 3],
    [tx, ty, tz]: [R; 3],
) -> (R, [R; 3]) {
    let Local { over, normal: [nx, ny, nz] } = surface.local(p);
    let fall = tx.mul_add(nx, ty.mul_add(ny, tz * nz));
    (-(over / fall), [nx, ny, nz])
}

/// Returns points and normals of a packet in which not all lanes have converged: first by more of
/// Newton's steps, then by a search. Lanes that have converged do not move, so that a result does
/// not depend on its neighbours.
#[cold]
#[inline(never)]
fn converge<R: Real>(
    surface: &impl ImplicitSurface<R>,
    ray: &LensRay<R>,
    crosses_once: R::Mask,
    converged: R::Mask,
    p: [R; 3],
    normal: [R; 3],
) -> ([R; 3], [R; 3]) {
    let mut end = p;
    let mut done = converged | !ray.p[0].equals(ray.p[0]);
    for _ in 0..STEPS {
        let (step, _) = newton_step(surface, end, ray.t);
        let next = advanced(end, step, ray.t);
        end = [0, 1, 2].map(|i| R::select(done, end[i], next[i]));
        done = done | is_final(surface, step, ray.t[2]);
        if R::bits(!done) == 0 {
            break;
        }
    }
    let there = surface.local(end).normal;
    let late = done & is_crossing(surface, end, there, ray.t[2], crosses_once);
    let found = search(surface, ray, crosses_once);
    let end = [0, 1, 2].map(|i| R::select(late, end[i], found[i]));
    // A point beyond the clear diameter is on the level part, whatever the function is there: the
    // ray is clipped and does not miss.
    let there = surface.local(end).normal;
    let clear = surface.lanes().clear(end[0], end[1]);
    let level = [R::constant(0.0), R::constant(0.0), R::constant(1.0)];
    let there = [0, 1, 2].map(|i| R::select(clear, there[i], level[i]));
    (
        [0, 1, 2].map(|i| R::select(converged, p[i], end[i])),
        [0, 1, 2].map(|i| R::select(converged, normal[i], there[i])),
    )
}

/// Returns whether a step is short enough to be the last.
#[inline(always)]
fn is_final<R: Real>(surface: &impl ImplicitSurface<R>, step: R, tz: R) -> R::Mask {
    (step * tz).abs().le(R::splat(surface.bounds().tolerance))
}

/// Returns whether the end of an iteration is the crossing with the surface. Beyond the clear
/// diameter the function may have a crossing of its own, and a conic has another sheet.
#[inline(always)]
fn is_crossing<R: Real>(
    surface: &impl ImplicitSurface<R>,
    p: [R; 3],
    normal: [R; 3],
    tz: R,
    crosses_once: R::Mask,
) -> R::Mask {
    let zero = R::constant(0.0);
    crosses_once & surface.lanes().clear(p[0], p[1]) & zero.lt(normal[2]) & zero.lt(tz)
}

/// Returns the first crossing inside the slab, by bisection. Lanes in `crosses_once` have exactly
/// one crossing; lanes without a crossing become NaN.
#[cold]
#[inline(never)]
fn search<R: Real>(
    surface: &impl ImplicitSurface<R>,
    ray: &LensRay<R>,
    crosses_once: R::Mask,
) -> [R; 3] {
    let per_tz = R::constant(1.0) / ray.t[2];
    let bounds = surface.bounds();
    let [low, high] = bounds.slab.map(|z| (R::splat(z) - ray.p[2]) * per_tz);
    let zero = R::constant(0.0);
    let above = |s: R| zero.le(surface.height_over(advanced(ray.p, s, ray.t)));
    // The near face of the slab is under the surface, the far face over it.
    let (mut under, mut over, mut found) = (low, high, crosses_once);
    if R::bits(!crosses_once) != 0 {
        // A step never overshoots a surface of the steepest slope.
        let [tx, ty, tz] = ray.t;
        let across = tx.mul_add(tx, ty * ty).sqrt();
        let quickest = across.mul_add(R::splat(bounds.slope2).sqrt(), tz);
        let part = (high - low) * R::constant(1.0 / PARTS as f64);
        let mut s = low;
        let mut going = s.lt(high) & !found;
        for _ in 0..=PARTS {
            if R::bits(going) == 0 {
                break;
            }
            under = R::select(going, s, under);
            let below = -surface.height_over(advanced(ray.p, s, ray.t));
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

/// Returns the point at a distance `s` along T.
#[inline(always)]
fn advanced<R: Real>(p: [R; 3], s: R, t: [R; 3]) -> [R; 3] {
    [s.mul_add(t[0], p[0]), s.mul_add(t[1], p[1]), s.mul_add(t[2], p[2])]
}
