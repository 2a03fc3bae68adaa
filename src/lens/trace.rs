//! Tracing rays through surfaces.
//!
//! The kernels work from each surface's vertex with its curvature, so a plane is an
//! ordinary sphere with c = 0 and a radius of 1e9 mm loses nothing (Feder 1951, "Optical
//! calculations with automatic computing machinery"; Spencer & Murty 1962). With T the
//! direction scaled to the index n and N = (-cx, -cy, 1 - cz) the unit normal:
//!
//! ```text
//! F = c P.P - 2 z     G = T_z - c P.T     xi = T.N = sqrt(G^2 - c n^2 F)
//! s = F / (G + xi)    P' = P + s T        T' = T + (sqrt(xi^2 + n'^2 - n^2) - xi) N
//! ```
//!
//! The two roots do not wait on each other; total reflection is the sign of the second.

use super::surface::{Kind, Surface};
use crate::lanes::Real;
use crate::rays::LensBatch;

/// A ray, or a packet of rays, inside the lens.
#[derive(Clone, Copy, Debug)]
pub struct LensRay<R> {
    /// Position relative to the vertex of the surface last crossed, mm.
    pub p: [R; 3],
    /// Direction, of the length of the refractive index.
    pub t: [R; 3],
}

/// A surface's numbers in every lane.
#[derive(Clone, Copy)]
struct Lanes<R> {
    advance: R,
    c: R,
    c_n2: R,
    n2_step: R,
    aperture2: R,
}

impl<R: Real> Lanes<R> {
    #[inline(always)]
    fn of(surface: &Surface<R::Scalar>) -> Self {
        Self {
            advance: R::splat(surface.advance),
            c: R::splat(surface.curvature),
            c_n2: R::splat(surface.curvature_n2),
            n2_step: R::splat(surface.n2_step),
            aperture2: R::splat(surface.aperture2),
        }
    }
}

/// Takes rays to a sphere or plane and refracts them there. The mask says which rays hit
/// the sheet at the vertex inside the clear aperture and are not totally reflected.
#[inline(always)]
fn refract<R: Real, const FAR: bool>(ray: LensRay<R>, surface: Lanes<R>) -> (LensRay<R>, R::Mask) {
    let Lanes { advance, c, c_n2, n2_step, aperture2 } = surface;
    let [x, y, z] = ray.p;
    let [tx, ty, tz] = ray.t;
    let z = z - advance;
    let p_p = x.mul_add(x, y.mul_add(y, z * z));
    let p_t = x.mul_add(tx, y.mul_add(ty, z * tz));
    let f = c.mul_add(p_p, -(z + z));
    let g = (-c).mul_add(p_t, tz);
    let disc = g.mul_add(g, -(c_n2 * f));
    let radicand = disc + n2_step;
    let xi = disc.sqrt();
    let xi_after = radicand.sqrt();
    let s = if FAR { (g - xi) / c_n2 } else { f / (g + xi) };
    let (x, y, z) = (s.mul_add(tx, x), s.mul_add(ty, y), s.mul_add(tz, z));
    let bend = xi_after - xi;
    let bend_c = -(bend * c);
    let normal_z = (-c).mul_add(z, R::constant(1.0));
    let bent = [bend_c.mul_add(x, tx), bend_c.mul_add(y, ty), bend.mul_add(normal_z, tz)];
    let zero = R::constant(0.0);
    let passed = x.mul_add(x, y * y).le(aperture2) & zero.lt(normal_z) & zero.le(radicand);
    (LensRay { p: [x, y, z], t: bent }, passed)
}

/// Takes rays to the plane of a stop. The mask says which pass through its opening.
#[inline(always)]
fn clip<R: Real>(ray: LensRay<R>, stop: Lanes<R>) -> (LensRay<R>, R::Mask) {
    let [x, y, z] = ray.p;
    let [tx, ty, tz] = ray.t;
    let s = (stop.advance - z) / tz;
    let (x, y) = (s.mul_add(tx, x), s.mul_add(ty, y));
    let passed = x.mul_add(x, y * y).le(stop.aperture2);
    (LensRay { p: [x, y, R::constant(0.0)], t: ray.t }, passed)
}

/// One surface for every ray of the batch: a stage. Blocked rays get a NaN in x, which no
/// later comparison lets through. Answers how many rays are alive behind the surface.
fn cross<R: Real>(
    batch: &mut LensBatch<R::Scalar>,
    surface: &Surface<R::Scalar>,
    kernel: impl Fn(LensRay<R>, Lanes<R>) -> (LensRay<R>, R::Mask),
) -> u64 {
    let surface = Lanes::of(surface);
    let blocked = R::constant(f64::NAN);
    let rays = batch.len;
    let x = batch.x.packets_mut::<R>(rays);
    let packets = x.len();
    let y = &mut batch.y.packets_mut::<R>(rays)[..packets];
    let z = &mut batch.z.packets_mut::<R>(rays)[..packets];
    let tx = &mut batch.tx.packets_mut::<R>(rays)[..packets];
    let ty = &mut batch.ty.packets_mut::<R>(rays)[..packets];
    let tz = &mut batch.tz.packets_mut::<R>(rays)[..packets];
    let mut alive = 0;
    for i in 0..packets {
        let ray = LensRay { p: [x[i], y[i], z[i]], t: [tx[i], ty[i], tz[i]] };
        let (ray, passed) = kernel(ray, surface);
        x[i] = R::select(passed, ray.p[0], blocked);
        y[i] = ray.p[1];
        z[i] = ray.p[2];
        [tx[i], ty[i], tz[i]] = ray.t;
        alive += u64::from(R::bits(passed).count_ones());
    }
    alive
}

/// Takes a batch through a sequence of surfaces, one surface after another over the whole
/// batch, which hides the latency of root and division as well as interleaving would.
///
/// `blocked[i]` grows by the number of rays that end at surface i. Rays that come out
/// have a number in `x`, relative to the last vertex; the others NaN.
pub fn trace<R: Real>(
    batch: &mut LensBatch<R::Scalar>,
    surfaces: &[Surface<R::Scalar>],
    blocked: &mut [u64],
) {
    let mut alive = batch.len as u64;
    for (surface, blocked) in surfaces.iter().zip(blocked) {
        let behind = match surface.kind {
            Kind::Stop => cross::<R>(batch, surface, clip),
            Kind::Sphere => cross::<R>(batch, surface, refract::<R, false>),
            Kind::FarSphere => cross::<R>(batch, surface, refract::<R, true>),
        };
        *blocked += alive - behind;
        alive = behind;
    }
}

/// Why a ray ends at a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Why {
    /// It meets the surface outside the clear aperture.
    Clip,
    /// It meets the plane of the stop outside the opening.
    Stop,
    /// It does not meet the surface's sheet.
    Miss,
    /// It is totally reflected.
    Tir,
}

/// Where and why a ray ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Blocked {
    /// Place of the surface in the sequence.
    pub surface: usize,
    /// What happened there.
    pub why: Why,
}

/// Takes one ray (or several in step) through a sequence of surfaces.
///
/// # Errors
/// Where and why the ray of the first lane ends.
pub fn trace_one<R: Real>(
    mut ray: LensRay<R>,
    surfaces: &[Surface<R::Scalar>],
) -> Result<LensRay<R>, Blocked> {
    for (i, surface) in surfaces.iter().enumerate() {
        let lanes = Lanes::of(surface);
        let (behind, passed) = match surface.kind {
            Kind::Stop => clip(ray, lanes),
            Kind::Sphere => refract::<R, false>(ray, lanes),
            Kind::FarSphere => refract::<R, true>(ray, lanes),
        };
        if R::bits(passed) & 1 == 0 {
            let why = match surface.kind {
                Kind::Stop => Why::Stop,
                Kind::Sphere | Kind::FarSphere => why(behind, lanes),
            };
            return Err(Blocked { surface: i, why });
        }
        ray = behind;
    }
    Ok(ray)
}

/// Why the kernel of a sphere let a ray not pass, from what it made of it.
fn why<R: Real>(behind: LensRay<R>, surface: Lanes<R>) -> Why {
    let [x, y, z] = behind.p;
    let holds = |mask: R::Mask| R::bits(mask) & 1 == 1;
    let normal_z = (-surface.c).mul_add(z, R::constant(1.0));
    if !holds(x.same(x)) || !holds(R::constant(0.0).lt(normal_z)) {
        Why::Miss
    } else if !holds(x.mul_add(x, y * y).le(surface.aperture2)) {
        Why::Clip
    } else {
        Why::Tir
    }
}
