//! Kernels that take a ray to a surface and refract it there.
//!
//! They work from each surface's vertex with its curvature, so a plane is an ordinary sphere
//! with c = 0 and a radius of 1e9 mm loses nothing (Feder 1951, "Optical calculations with
//! automatic computing machinery"; Spencer & Murty 1962). With T the direction scaled to the
//! index n, D the matrix that is diag(1, 1, 1 + k) for a conic with the constant k (and has a
//! 0 for x or y in a cylinder along it), and N = e_z - c D P the normal:
//!
//! ```text
//! F = c P.DP - 2 z    G = T_z - c T.DP    A = c T.DT    T.N = sqrt(G^2 - A F)
//! s = F / (G + T.N)   P' = P + s T
//! xi = T.N / |N|      T' = T + (sqrt(xi^2 + n'^2 - n^2) - xi) N / |N|
//! ```
//!
//! The two roots of a sphere, where |N| = 1, do not wait on each other; total reflection is
//! the sign of the second.

use super::surface::Surface;
use crate::lanes::Real;

/// A ray, or a packet of rays, inside the lens.
#[derive(Clone, Copy, Debug)]
pub struct LensRay<R> {
    /// Position relative to the vertex of the surface last crossed, mm.
    pub p: [R; 3],
    /// Direction, of the length of the refractive index.
    pub t: [R; 3],
    /// What openings of partial transmission, and lossy surfaces, have left of the light.
    pub weight: R,
}

impl<R: Real> LensRay<R> {
    /// A ray that has lost nothing yet.
    #[inline(always)]
    pub fn new(p: [R; 3], t: [R; 3]) -> Self {
        Self { p, t, weight: R::constant(1.0) }
    }
}

/// What a kernel makes of a ray.
#[derive(Clone, Copy)]
pub(super) struct Crossed<R: Real> {
    /// The ray behind the surface.
    pub ray: LensRay<R>,
    /// Whether it meets the sheet at the vertex, on its way forward.
    pub met: R::Mask,
    /// Whether it does so where the surface lets light through.
    pub inside: R::Mask,
    /// Square of the normal component of T before refraction.
    pub incidence: R,
}

/// Takes rays to a surface and through it.
pub(super) trait Kernel<R: Real> {
    /// Whether the direction changes, so that there is total reflection.
    const REFRACTS: bool = true;
    /// Whether the weight changes.
    const SHADES: bool = false;

    /// How many times rays approach the surface before they cross it: stages of their own over
    /// the batch, which hide the latency of an iteration.
    #[inline(always)]
    fn passes(&self) -> usize {
        0
    }

    /// One such step along the ray.
    #[inline(always)]
    fn approach(&self, ray: LensRay<R>, _pass: usize) -> LensRay<R> {
        ray
    }

    fn cross(&self, ray: LensRay<R>) -> Crossed<R>;
}

/// What every surface has, in every lane.
#[derive(Clone, Copy)]
pub(super) struct Lanes<R> {
    pub advance: R,
    pub c: R,
    pub n2: R,
    pub n2_step: R,
    pub aperture2: R,
}

impl<R: Real> Lanes<R> {
    #[inline(always)]
    pub fn of(surface: &Surface<R::Scalar>) -> Self {
        Self {
            advance: R::splat(surface.advance),
            c: R::splat(surface.curvature),
            n2: R::splat(surface.n2),
            n2_step: R::splat(surface.n2_step),
            aperture2: R::splat(surface.aperture2),
        }
    }

    /// The ray in the frame of this surface's vertex; one that comes from afar in the plane of
    /// the vertex, so that nothing is lost to the length of its way.
    #[inline(always)]
    pub fn arrive<const FAR: bool>(&self, ray: LensRay<R>) -> LensRay<R> {
        let ([x, y, z], [tx, ty, tz]) = (ray.p, ray.t);
        let z = z - self.advance;
        if FAR {
            let s = -(z / tz);
            return LensRay { p: [s.mul_add(tx, x), s.mul_add(ty, y), R::constant(0.0)], ..ray };
        }
        LensRay { p: [x, y, z], ..ray }
    }

    /// Whether a point is inside the clear diameter.
    #[inline(always)]
    pub fn clear(&self, x: R, y: R) -> R::Mask {
        x.mul_add(x, y * y).le(self.aperture2)
    }
}

/// How far to a quadric along the ray, in units of T; T.N there, and its square.
#[inline(always)]
fn reach<R: Real>(f: R, g: R, a: R) -> (R, R, R) {
    let disc = g.mul_add(g, -(a * f));
    let t_n = disc.sqrt();
    (f / (g + t_n), t_n, disc)
}

/// A sphere or plane.
#[derive(Clone, Copy)]
pub(super) struct Sphere<R, const FAR: bool>(pub Lanes<R>, pub R);

impl<R: Real, const FAR: bool> Sphere<R, FAR> {
    #[inline(always)]
    pub fn of(surface: &Surface<R::Scalar>) -> Self {
        let lanes = Lanes::of(surface);
        Self(lanes, lanes.c * lanes.n2)
    }
}

impl<R: Real, const FAR: bool> Kernel<R> for Sphere<R, FAR> {
    #[inline(always)]
    fn cross(&self, ray: LensRay<R>) -> Crossed<R> {
        let Self(surface, c_n2) = *self;
        let ray = surface.arrive::<FAR>(ray);
        let Lanes { c, n2_step, .. } = surface;
        let ([x, y, z], [tx, ty, tz]) = (ray.p, ray.t);
        let p_p = x.mul_add(x, y.mul_add(y, z * z));
        let p_t = x.mul_add(tx, y.mul_add(ty, z * tz));
        let f = c.mul_add(p_p, -(z + z));
        let g = (-c).mul_add(p_t, tz);
        let (s, xi, disc) = reach(f, g, c_n2);
        let bend = (disc + n2_step).sqrt() - xi;
        let (x, y, z) = (s.mul_add(tx, x), s.mul_add(ty, y), s.mul_add(tz, z));
        let bend_c = -(bend * c);
        let normal_z = (-c).mul_add(z, R::constant(1.0));
        let t = [bend_c.mul_add(x, tx), bend_c.mul_add(y, ty), bend.mul_add(normal_z, tz)];
        let zero = R::constant(0.0);
        Crossed {
            ray: LensRay { p: [x, y, z], t, ..ray },
            met: zero.lt(normal_z) & zero.lt(tz),
            inside: surface.clear(x, y),
            incidence: disc,
        }
    }
}

/// A conic of revolution; the second number is 1 + k.
#[derive(Clone, Copy)]
pub(super) struct Conic<R, const FAR: bool>(pub Lanes<R>, pub R);

impl<R: Real, const FAR: bool> Kernel<R> for Conic<R, FAR> {
    #[inline(always)]
    fn cross(&self, ray: LensRay<R>) -> Crossed<R> {
        let Self(surface, k1) = *self;
        let ray = surface.arrive::<FAR>(ray);
        let ([over, under], disc) = meet_conic(&ray, surface.c, k1);
        let s = over / under;
        let ([x, y, z], [tx, ty, tz]) = (ray.p, ray.t);
        let (x, y, z) = (s.mul_add(tx, x), s.mul_add(ty, y), s.mul_add(tz, z));
        let normal_z = (-(surface.c * k1)).mul_add(z, R::constant(1.0));
        let normal = [-(surface.c * x), -(surface.c * y), normal_z];
        let crossed = refracted(&surface, LensRay { p: [x, y, z], ..ray }, normal);
        // Next to tangency there is no point, but still a doubt.
        let missed = disc.lt(R::constant(0.0));
        Crossed { incidence: R::select(missed, disc, crossed.incidence), ..crossed }
    }
}

/// How far along a ray its conic is, in units of T, as a fraction; and the square of T.N there.
#[inline(always)]
pub(super) fn meet_conic<R: Real>(ray: &LensRay<R>, c: R, k1: R) -> ([R; 2], R) {
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

/// Refraction at a point that the ray has come to, by a normal of any length.
#[inline(always)]
pub(super) fn refracted<R: Real>(
    surface: &Lanes<R>,
    ray: LensRay<R>,
    normal: [R; 3],
) -> Crossed<R> {
    let ([x, y, _], [tx, ty, tz]) = (ray.p, ray.t);
    let [nx, ny, nz] = normal;
    let n_n = nx.mul_add(nx, ny.mul_add(ny, nz * nz));
    let t_n = tx.mul_add(nx, ty.mul_add(ny, tz * nz));
    // Both roots with the length of the normal in them, so that one division takes it out.
    let t_n2 = t_n * t_n;
    let bend = surface.n2_step.mul_add(n_n, t_n2).sqrt() - t_n;
    let per_n_n = R::constant(1.0) / n_n;
    let bend = bend * per_n_n;
    let zero = R::constant(0.0);
    Crossed {
        ray: LensRay {
            t: [bend.mul_add(nx, tx), bend.mul_add(ny, ty), bend.mul_add(nz, tz)],
            ..ray
        },
        met: zero.lt(nz) & zero.lt(tz) & zero.lt(t_n),
        inside: surface.clear(x, y),
        incidence: t_n2 * per_n_n,
    }
}

/// A circular cylinder that is straight along one axis: X or Y.
#[derive(Clone, Copy)]
pub(super) struct Cylinder<R, const ALONG_X: bool, const FAR: bool>(pub Lanes<R>);

impl<R: Real, const ALONG_X: bool, const FAR: bool> Kernel<R> for Cylinder<R, ALONG_X, FAR> {
    #[inline(always)]
    fn cross(&self, ray: LensRay<R>) -> Crossed<R> {
        let surface = self.0;
        let ray = surface.arrive::<FAR>(ray);
        let Lanes { c, n2, n2_step, .. } = surface;
        let ([x, y, z], [tx, ty, tz]) = (ray.p, ray.t);
        // Where it is curved, and where it is not.
        let (h, th, straight) = if ALONG_X { (y, ty, tx) } else { (x, tx, ty) };
        let p_p = h.mul_add(h, z * z);
        let p_t = h.mul_add(th, z * tz);
        let f = c.mul_add(p_p, -(z + z));
        let g = (-c).mul_add(p_t, tz);
        let a = c * (-straight).mul_add(straight, n2);
        let (s, xi, disc) = reach(f, g, a);
        let bend = (disc + n2_step).sqrt() - xi;
        let (x, y, z) = (s.mul_add(tx, x), s.mul_add(ty, y), s.mul_add(tz, z));
        let bend_c = -(bend * c);
        let normal_z = (-c).mul_add(z, R::constant(1.0));
        let (tx, ty) =
            if ALONG_X { (tx, bend_c.mul_add(y, ty)) } else { (bend_c.mul_add(x, tx), ty) };
        let zero = R::constant(0.0);
        Crossed {
            ray: LensRay { p: [x, y, z], t: [tx, ty, bend.mul_add(normal_z, tz)], ..ray },
            met: zero.lt(normal_z) & zero.lt(tz),
            inside: surface.clear(x, y),
            incidence: disc,
        }
    }
}
