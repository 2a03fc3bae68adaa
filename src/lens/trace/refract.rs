//! Kernels of quadrics: spheres, planes, conics of revolution and circular cylinders.
//!
//! They work from the vertex of each surface with its curvature, so that a plane is an ordinary
//! sphere with c = 0 and a radius of 1e9 mm loses nothing (Feder 1951, "Optical calculations with
//! automatic computing machinery"; Spencer & Murty 1962). T is the unit direction times the index
//! n; D is diag(1, 1, 1 + k) for a conic of constant k, with a 0 for x or y in a cylinder along it;
//! and N = e_z - c D P is the normal:
//!
//! ```text
//! F = c P.DP - 2 z    G = T_z - c T.DP    A = c T.DT    T.N = sqrt(G^2 - A F)
//! s = F / (G + T.N)   P' = P + s T
//! xi = T.N / |N|      T' = T + (sqrt(xi^2 + n'^2 - n^2) - xi) N / |N|
//! ```
//!
//! On a sphere |N| = 1, and its two square roots do not depend on each other. Total reflection is
//! the sign of the second radicand.

use super::kernel::{KernelOutput, LensRay, SurfaceKernel, SurfaceLanes};
use super::surface::Surface;
use petzval_base::lanes::Real;

/// Returns the distance s to a quadric in units of T, T.N there, and its square.
#[inline(always)]
fn solve_quadric<R: Real>(f: R, g: R, a: R) -> (R, R, R) {
    let disc = g.mul_add(g, -(a * f));
    let t_n = disc.sqrt();
    (f / (g + t_n), t_n, disc)
}

/// Kernel of a sphere or plane; the second number is A = c n^2. Rays meet an `ENTRANCE` from any
/// side of the plane of its vertex.
#[derive(Clone, Copy)]
pub(crate) struct SphereKernel<R, const FAR: bool, const ENTRANCE: bool>(
    pub SurfaceLanes<R>,
    pub R,
);

impl<R: Real, const FAR: bool, const ENTRANCE: bool> SphereKernel<R, FAR, ENTRANCE> {
    #[inline(always)]
    pub fn of(surface: &Surface<R::Scalar>) -> Self {
        let lanes = SurfaceLanes::of(surface);
        Self(lanes, lanes.c * lanes.n2)
    }
}

impl<R: Real, const FAR: bool, const ENTRANCE: bool> SurfaceKernel<R>
    for SphereKernel<R, FAR, ENTRANCE>
{
    #[inline(always)]
    fn cross(&self, ray: LensRay<R>) -> KernelOutput<R> {
        let Self(surface, c_n2) = *self;
        let ray = surface.arrive::<FAR>(ray);
        let SurfaceLanes { c, n2_step, .. } = surface;
        let ([x, y, z], [tx, ty, tz]) = (ray.p, ray.t);
        let p_p = x.mul_add(x, y.mul_add(y, z * z));
        let p_t = x.mul_add(tx, y.mul_add(ty, z * tz));
        let f = c.mul_add(p_p, -(z + z));
        let g = (-c).mul_add(p_t, tz);
        let (s, xi, disc) = solve_quadric(f, g, c_n2);
        let bend = (disc + n2_step).sqrt() - xi;
        let (x, y, z) = (s.mul_add(tx, x), s.mul_add(ty, y), s.mul_add(tz, z));
        let bend_c = -(bend * c);
        let normal_z = (-c).mul_add(z, R::constant(1.0));
        let t = [bend_c.mul_add(x, tx), bend_c.mul_add(y, ty), bend.mul_add(normal_z, tz)];
        KernelOutput {
            ray: LensRay { p: [x, y, z], t, ..ray },
            met: forward::<R, ENTRANCE>(normal_z, tz),
            inside: surface.clear(x, y),
            xi2: disc,
        }
    }
}

/// Returns whether a ray meets the sheet at the vertex, going forward. Where it may come from
/// behind the plane of the vertex, the sign of T.N alone tells forward from backward, and the
/// kernels choose the root at which it is positive.
#[inline(always)]
fn forward<R: Real, const ENTRANCE: bool>(normal_z: R, tz: R) -> R::Mask {
    let zero = R::constant(0.0);
    if ENTRANCE { zero.lt(normal_z) } else { zero.lt(normal_z) & zero.lt(tz) }
}

/// Kernel of a conic of revolution; the second number is 1 + k. Rays meet an `ENTRANCE` from any
/// side of the plane of its vertex.
#[derive(Clone, Copy)]
pub(crate) struct ConicKernel<R, const FAR: bool, const ENTRANCE: bool>(pub SurfaceLanes<R>, pub R);

impl<R: Real, const FAR: bool, const ENTRANCE: bool> SurfaceKernel<R>
    for ConicKernel<R, FAR, ENTRANCE>
{
    #[inline(always)]
    fn cross(&self, ray: LensRay<R>) -> KernelOutput<R> {
        let Self(surface, k1) = *self;
        let ray = surface.arrive::<FAR>(ray);
        let ([over, under], disc) = meet_conic(&ray, surface.c, k1);
        let s = over / under;
        let ([x, y, z], [tx, ty, tz]) = (ray.p, ray.t);
        let (x, y, z) = (s.mul_add(tx, x), s.mul_add(ty, y), s.mul_add(tz, z));
        let normal_z = (-(surface.c * k1)).mul_add(z, R::constant(1.0));
        let normal = [-(surface.c * x), -(surface.c * y), normal_z];
        let crossed = refracted(&surface, LensRay { p: [x, y, z], ..ray }, normal);
        // A ray that misses by rounding alone is uncertain: its negative square decides.
        let missed = disc.lt(R::constant(0.0));
        let xi2 = R::select(missed, disc, crossed.xi2);
        match ENTRANCE {
            true => {
                let met = R::constant(0.0).lt(normal_z) & R::constant(0.0).lt(disc);
                KernelOutput { met, xi2, ..crossed }
            }
            false => KernelOutput { xi2, ..crossed },
        }
    }
}

/// Returns the distance s to a conic in units of T, as numerator and denominator, and the square of
/// T.N there.
#[inline(always)]
pub(crate) fn meet_conic<R: Real>(ray: &LensRay<R>, c: R, k1: R) -> ([R; 2], R) {
    let ([x, y, z], [tx, ty, tz]) = (ray.p, ray.t);
    let (k1_z, k1_tz) = (k1 * z, k1 * tz);
    let p_p = x.mul_add(x, y.mul_add(y, k1_z * z));
    let p_t = x.mul_add(tx, y.mul_add(ty, k1_z * tz));
    let t_t = tx.mul_add(tx, ty.mul_add(ty, k1_tz * tz));
    let f = c.mul_add(p_p, -(z + z));
    let g = (-c).mul_add(p_t, tz);
    let disc = g.mul_add(g, -(c * t_t * f));
    ([f, g + disc.sqrt()], disc)
}

/// Refracts a ray at its position, by a normal of any length.
#[inline(always)]
pub(crate) fn refracted<R: Real>(
    surface: &SurfaceLanes<R>,
    ray: LensRay<R>,
    normal: [R; 3],
) -> KernelOutput<R> {
    let ([x, y, _], [tx, ty, tz]) = (ray.p, ray.t);
    let [nx, ny, nz] = normal;
    let n_n = nx.mul_add(nx, ny.mul_add(ny, nz * nz));
    let t_n = tx.mul_add(nx, ty.mul_add(ny, tz * nz));
    // Both roots contain the length of the normal, so that one division removes it.
    let t_n2 = t_n * t_n;
    let bend = surface.n2_step.mul_add(n_n, t_n2).sqrt() - t_n;
    let per_n_n = R::constant(1.0) / n_n;
    let bend = bend * per_n_n;
    let zero = R::constant(0.0);
    KernelOutput {
        ray: LensRay {
            t: [bend.mul_add(nx, tx), bend.mul_add(ny, ty), bend.mul_add(nz, tz)],
            ..ray
        },
        met: zero.lt(nz) & zero.lt(tz) & zero.lt(t_n),
        inside: surface.clear(x, y),
        xi2: t_n2 * per_n_n,
    }
}

/// Kernel of a circular cylinder that is straight along x or along y.
#[derive(Clone, Copy)]
pub(crate) struct CylinderKernel<R, const ALONG_X: bool, const FAR: bool>(pub SurfaceLanes<R>);

impl<R: Real, const ALONG_X: bool, const FAR: bool> SurfaceKernel<R>
    for CylinderKernel<R, ALONG_X, FAR>
{
    #[inline(always)]
    fn cross(&self, ray: LensRay<R>) -> KernelOutput<R> {
        let surface = self.0;
        let ray = surface.arrive::<FAR>(ray);
        let SurfaceLanes { c, n2, n2_step, .. } = surface;
        let ([x, y, z], [tx, ty, tz]) = (ray.p, ray.t);
        // h is the coordinate along which it is curved.
        let (h, th, straight) = if ALONG_X { (y, ty, tx) } else { (x, tx, ty) };
        let p_p = h.mul_add(h, z * z);
        let p_t = h.mul_add(th, z * tz);
        let f = c.mul_add(p_p, -(z + z));
        let g = (-c).mul_add(p_t, tz);
        let a = c * (-straight).mul_add(straight, n2);
        let (s, xi, disc) = solve_quadric(f, g, a);
        let bend = (disc + n2_step).sqrt() - xi;
        let (x, y, z) = (s.mul_add(tx, x), s.mul_add(ty, y), s.mul_add(tz, z));
        let bend_c = -(bend * c);
        let normal_z = (-c).mul_add(z, R::constant(1.0));
        let (tx, ty) =
            if ALONG_X { (tx, bend_c.mul_add(y, ty)) } else { (bend_c.mul_add(x, tx), ty) };
        let zero = R::constant(0.0);
        KernelOutput {
            ray: LensRay { p: [x, y, z], t: [tx, ty, bend.mul_add(normal_z, tz)], ..ray },
            met: zero.lt(normal_z) & zero.lt(tz),
            inside: surface.clear(x, y),
            xi2: disc,
        }
    }
}
