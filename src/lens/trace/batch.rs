//! Tracing of a batch of rays, one surface after another over the whole batch.

use super::absorption::{absorb_batch, depart};
use super::kernel::{KernelOutput, KernelVisitor, LensRay, SurfaceKernel, dispatch};
use super::single::follow;
use super::surface::Surface;
use petzval_base::lanes::Real;
use petzval_base::rays::LensBatch;

/// Traces a batch through a sequence of surfaces. One surface at a time over the whole batch hides
/// the latency of square root and division as well as interleaving would.
///
/// `blocked[row]` grows by the number of rays that end at a row of the prescription. In `x`, rays
/// that come out have a number, relative to the last vertex, and blocked rays a NaN. Rays that this
/// precision cannot trace exactly enough are listed in [`LensBatch::needs_f64`]; they count as
/// neither until [`retrace_in_f64`] has traced them.
#[inline(never)]
pub fn trace<R: Real>(
    batch: &mut LensBatch<R::Scalar>,
    surfaces: &[Surface<R::Scalar>],
    blocked: &mut [u64],
) {
    trace_batch::<R, false>(batch, surfaces, blocked);
}

/// Traces a batch like [`trace`]; every surface multiplies the weight by its transmittance
/// ([`CoatingModel`](crate::CoatingModel)), and glass that absorbs by the share of light that it lets
/// pass.
#[inline(never)]
pub fn trace_lossy<R: Real>(
    batch: &mut LensBatch<R::Scalar>,
    surfaces: &[Surface<R::Scalar>],
    blocked: &mut [u64],
) {
    trace_batch::<R, true>(batch, surfaces, blocked);
}

#[inline(always)]
fn trace_batch<R: Real, const LOSSY: bool>(
    batch: &mut LensBatch<R::Scalar>,
    surfaces: &[Surface<R::Scalar>],
    blocked: &mut [u64],
) {
    batch.needs_f64.clear();
    let (mut alive, mut uncertain) = (batch.live as u64, 0);
    for surface in surfaces {
        if LOSSY {
            depart::<R>(batch, surface);
        }
        let behind = match surface.mirror {
            true => dispatch::<R, _>(surface, Stage::<R, false, true> { batch, surface }),
            false => dispatch::<R, _>(surface, Stage::<R, LOSSY, false> { batch, surface }),
        };
        if LOSSY {
            absorb_batch::<R>(batch, surface);
        }
        let newly = batch.needs_f64.len() as u64 - uncertain;
        blocked[surface.row] += alive - behind - newly;
        (alive, uncertain) = (behind, uncertain + newly);
    }
}

/// Traces a batch like [`trace_lossy`] through surfaces some of which reflect
/// ([`ghost_sequence`](crate::ghost_sequence)), and returns the number of rays that come out.
/// No ray is listed for f64: rays that f32 cannot decide are invisible in a ghost.
#[inline(never)]
pub fn trace_ghost<R: Real>(
    batch: &mut LensBatch<R::Scalar>,
    surfaces: &[Surface<R::Scalar>],
) -> u64 {
    let mut alive = batch.live as u64;
    for surface in surfaces {
        depart::<R>(batch, surface);
        alive = match surface.mirror {
            true => dispatch::<R, _>(surface, Stage::<R, true, true> { batch, surface }),
            false => dispatch::<R, _>(surface, Stage::<R, true, false> { batch, surface }),
        };
        absorb_batch::<R>(batch, surface);
        if alive == 0 {
            break;
        }
    }
    batch.needs_f64.clear();
    alive
}

/// Traces the rays in [`LensBatch::needs_f64`] again, in f64, from their starts.
///
/// `start` returns the start of a ray by its index in the batch. `surfaces` are those of [`trace`],
/// in f64.
pub fn retrace_in_f64<R: Real>(
    batch: &mut LensBatch<R::Scalar>,
    surfaces: &[Surface<f64>],
    blocked: &mut [u64],
    start: impl Fn(usize) -> LensRay<f64>,
) {
    retrace::<R, false>(batch, surfaces, blocked, start);
}

/// Traces rays again like [`retrace_in_f64`], for a batch of [`trace_lossy`].
pub fn retrace_in_f64_lossy<R: Real>(
    batch: &mut LensBatch<R::Scalar>,
    surfaces: &[Surface<f64>],
    blocked: &mut [u64],
    start: impl Fn(usize) -> LensRay<f64>,
) {
    retrace::<R, true>(batch, surfaces, blocked, start);
}

#[inline(always)]
fn retrace<R: Real, const LOSSY: bool>(
    batch: &mut LensBatch<R::Scalar>,
    surfaces: &[Surface<f64>],
    blocked: &mut [u64],
    start: impl Fn(usize) -> LensRay<f64>,
) {
    for k in 0..batch.needs_f64.len() {
        let i = batch.needs_f64[k] as usize;
        match follow::<f64, LOSSY>(start(i), surfaces) {
            Err(end) => blocked[end.row] += 1,
            Ok(ray) => {
                [batch.x[i], batch.y[i], batch.z[i]] = ray.p.map(R::from_f64);
                [batch.tx[i], batch.ty[i], batch.tz[i]] = ray.t.map(R::from_f64);
                batch.weight[i] = R::from_f64(ray.weight);
            }
        }
    }
}

/// One surface for every ray of a batch. Blocked rays get a NaN in x, which fails every later
/// comparison. The output is the number of rays alive behind the surface.
struct Stage<'a, R: Real, const LOSSY: bool, const MIRROR: bool> {
    batch: &'a mut LensBatch<R::Scalar>,
    surface: &'a Surface<R::Scalar>,
}

impl<R: Real, const LOSSY: bool, const MIRROR: bool> KernelVisitor<R>
    for Stage<'_, R, LOSSY, MIRROR>
{
    type Output = u64;

    fn visit(self, kernel: impl SurfaceKernel<R>) -> u64 {
        cross_as::<R, _, LOSSY, MIRROR>(self.batch, self.surface, kernel)
    }
}

/// Calls [`cross`]. Kernels that do not refract neither reflect nor lose light at a coating: all their
/// variants are the same code, which is compiled once.
#[inline(always)]
fn cross_as<R: Real, K: SurfaceKernel<R>, const LOSSY: bool, const MIRROR: bool>(
    batch: &mut LensBatch<R::Scalar>,
    surface: &Surface<R::Scalar>,
    kernel: K,
) -> u64 {
    match K::REFRACTS {
        true => cross::<R, K, LOSSY, MIRROR>(batch, surface, kernel),
        false => cross::<R, K, false, false>(batch, surface, kernel),
    }
}

fn cross<R: Real, K: SurfaceKernel<R>, const LOSSY: bool, const MIRROR: bool>(
    batch: &mut LensBatch<R::Scalar>,
    surface: &Surface<R::Scalar>,
    kernel: K,
) -> u64 {
    let (limit, uncertainty) = (R::splat(surface.limit), R::splat(surface.uncertainty));
    let sure = limit + uncertainty;
    let blocked = R::constant(f64::NAN);
    let rays = batch.len;
    let needs_f64 = &mut batch.needs_f64;
    let x = batch.x.packets_mut::<R>(rays);
    let packets = x.len();
    let y = &mut batch.y.packets_mut::<R>(rays)[..packets];
    let z = &mut batch.z.packets_mut::<R>(rays)[..packets];
    let tx = &mut batch.tx.packets_mut::<R>(rays)[..packets];
    let ty = &mut batch.ty.packets_mut::<R>(rays)[..packets];
    let tz = &mut batch.tz.packets_mut::<R>(rays)[..packets];
    let weight = &mut batch.weight.packets_mut::<R>(rays)[..packets];
    for pass in 0..kernel.passes() {
        for i in 0..packets {
            let ray = LensRay::new([x[i], y[i], z[i]], [tx[i], ty[i], tz[i]]);
            [x[i], y[i], z[i]] = kernel.approach(ray, pass).p;
        }
    }
    let mut alive = 0;
    for i in 0..packets {
        let before = LensRay {
            p: [x[i], y[i], z[i]],
            t: [tx[i], ty[i], tz[i]],
            weight: if K::ATTENUATES { weight[i] } else { blocked },
        };
        let KernelOutput { ray, met, inside, xi2 } = kernel.cross(before);
        let mut passed = met & inside;
        if K::REFRACTS {
            // Rare: next to total reflection or tangency.
            let unsure = R::bits(xi2.lt(sure));
            if unsure != 0 {
                // In a cylinder along x, the NaN of a blocked ray does not reach xi2.
                let alive = R::bits(before.p[0].equals(before.p[0]));
                let near = R::bits((limit - uncertainty).le(xi2));
                push_lanes(needs_f64, unsure & near & alive, i * R::LANES);
            }
            passed = passed & sure.le(xi2);
        }
        x[i] = R::select(passed, ray.p[0], blocked);
        y[i] = ray.p[1];
        z[i] = ray.p[2];
        [tx[i], ty[i], tz[i]] = ray.t;
        if K::ATTENUATES {
            weight[i] = ray.weight;
        }
        if MIRROR {
            [tx[i], ty[i], tz[i]] = reflected(before.t, ray.t, xi2, R::splat(surface.n2_step));
            z[i] = -z[i];
            if LOSSY {
                weight[i] = weight[i] * surface.coating.reflectance::<R>(xi2);
            }
        } else if LOSSY && K::REFRACTS {
            weight[i] = weight[i] * surface.coating.transmittance::<R>(xi2);
        }
        alive += u64::from(R::bits(passed).count_ones());
    }
    alive
}

/// Returns the direction of a reflected ray, in a frame whose +z is the new direction of travel.
///
/// Kernels only refract. The directions before and behind a refraction with any step of n^2 give
/// the normal, T' - T = (sqrt(xi^2 + step) - xi) N, and with it the reflection T - 2 xi N.
#[inline(always)]
pub(super) fn reflected<R: Real>(before: [R; 3], behind: [R; 3], xi2: R, step: R) -> [R; 3] {
    let xi = xi2.sqrt();
    let share = -(xi + xi) / ((xi2 + step).sqrt() - xi);
    let [x, y, z] = [0, 1, 2].map(|i| share.mul_add(behind[i] - before[i], before[i]));
    [x, y, -z]
}

/// Appends the indices of the lanes whose bits are set.
#[cold]
#[inline(never)]
fn push_lanes(rays: &mut Vec<u32>, mut lanes: u32, first: usize) {
    while lanes != 0 {
        rays.push(first as u32 + lanes.trailing_zeros());
        lanes &= lanes - 1;
    }
}
