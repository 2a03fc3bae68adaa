//! Tracing rays through surfaces.
//!
//! Whether surfaces take their share of the light is a parameter of the kernels' loop: without
//! losses the machine code is that of a program that knows of none. [`trace`] is a call of its
//! own, so that this can be seen: `objdump -dC` shows the same instructions of it in both.

use super::asphere::AsphereLanes;
use super::ideal::IdealLanes;
use super::opening::{Disk, Opening, Stop};
use super::polynomial::PolynomialLanes;
use super::prescription::Axis;
use super::refract::{Conic, Crossed, Cylinder, Kernel, Lanes, LensRay, Sphere};
use super::surface::{Kind, Surface};
use super::turn::TurnLanes;
use crate::lanes::Real;
use crate::rays::LensBatch;

/// Something to do with the kernel of a surface. Every kernel gets its own machine code.
trait With<R: Real> {
    type Answer;
    fn with(self, kernel: impl Kernel<R>) -> Self::Answer;
}

/// Picks the kernel of a surface.
#[inline(always)]
fn dispatch<R: Real, W: With<R>>(surface: &Surface<R::Scalar>, what: W) -> W::Answer {
    let lanes = Lanes::of(surface);
    match (&surface.kind, surface.far) {
        (Kind::Stop, _) => what.with(Stop(lanes)),
        (Kind::Sphere, false) => what.with(Sphere::<R, false>::of(surface)),
        (Kind::Sphere, true) => what.with(Sphere::<R, true>::of(surface)),
        (Kind::Conic(k1), false) => what.with(Conic::<R, false>(lanes, R::splat(*k1))),
        (Kind::Conic(k1), true) => what.with(Conic::<R, true>(lanes, R::splat(*k1))),
        (Kind::Cylinder(Axis::X), false) => what.with(Cylinder::<R, true, false>(lanes)),
        (Kind::Cylinder(Axis::X), true) => what.with(Cylinder::<R, true, true>(lanes)),
        (Kind::Cylinder(Axis::Y), false) => what.with(Cylinder::<R, false, false>(lanes)),
        (Kind::Cylinder(Axis::Y), true) => what.with(Cylinder::<R, false, true>(lanes)),
        (Kind::Asphere(asphere), far) => match (asphere.odd, far) {
            (false, false) => what.with(AsphereLanes::<R, false, false>(lanes, asphere)),
            (false, true) => what.with(AsphereLanes::<R, false, true>(lanes, asphere)),
            (true, false) => what.with(AsphereLanes::<R, true, false>(lanes, asphere)),
            (true, true) => what.with(AsphereLanes::<R, true, true>(lanes, asphere)),
        },
        (Kind::Ideal(ideal), _) => what.with(IdealLanes::<R>::of(lanes, ideal)),
        (Kind::Polynomial(part), _) => match part.round {
            true => what.with(PolynomialLanes::<R, true>(lanes, part)),
            false => what.with(PolynomialLanes::<R, false>(lanes, part)),
        },
        (Kind::Iris(shape), _) => what.with(Opening::<R>(shape)),
        (Kind::Obstruction(h2), _) => what.with(Disk(R::splat(*h2))),
        (Kind::Turn(turn), _) => what.with(TurnLanes::<R>::of(turn)),
    }
}

/// One surface for every ray of the batch: a stage. Blocked rays get a NaN in x, which no
/// later comparison lets through. Answers how many rays are alive behind the surface.
struct Stage<'a, R: Real, const LOSSY: bool, const MIRROR: bool> {
    batch: &'a mut LensBatch<R::Scalar>,
    surface: &'a Surface<R::Scalar>,
}

impl<R: Real, const LOSSY: bool, const MIRROR: bool> With<R> for Stage<'_, R, LOSSY, MIRROR> {
    type Answer = u64;

    fn with(self, kernel: impl Kernel<R>) -> u64 {
        cross::<R, _, LOSSY, MIRROR>(self.batch, self.surface, kernel)
    }
}

fn cross<R: Real, K: Kernel<R>, const LOSSY: bool, const MIRROR: bool>(
    batch: &mut LensBatch<R::Scalar>,
    surface: &Surface<R::Scalar>,
    kernel: K,
) -> u64 {
    let (limit, doubt) = (R::splat(surface.limit), R::splat(surface.doubt));
    let sure = limit + doubt;
    let blocked = R::constant(f64::NAN);
    let rays = batch.len;
    let doubtful = &mut batch.doubtful;
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
            weight: if K::SHADES { weight[i] } else { blocked },
        };
        let Crossed { ray, met, inside, incidence } = kernel.cross(before);
        let mut passed = met & inside;
        if K::REFRACTS {
            // Near total reflection and tangency: rare, and settled in f64 after the wave.
            let unsure = R::bits(incidence.lt(sure));
            if unsure != 0 {
                // A cylinder does not see that a ray is blocked in the number along it.
                let alive = R::bits(before.p[0].same(before.p[0]));
                let near = R::bits((limit - doubt).le(incidence));
                note(doubtful, unsure & near & alive, i * R::LANES);
            }
            passed = passed & sure.le(incidence);
        }
        x[i] = R::select(passed, ray.p[0], blocked);
        y[i] = ray.p[1];
        z[i] = ray.p[2];
        [tx[i], ty[i], tz[i]] = ray.t;
        if K::SHADES {
            weight[i] = ray.weight;
        }
        if MIRROR {
            [tx[i], ty[i], tz[i]] =
                reflected(before.t, ray.t, incidence, R::splat(surface.n2_step));
            z[i] = -z[i];
            weight[i] = weight[i] * surface.coat.reflectance::<R>(incidence);
        } else if LOSSY && K::REFRACTS {
            weight[i] = weight[i] * surface.coat.transmittance::<R>(incidence);
        }
        alive += u64::from(R::bits(passed).count_ones());
    }
    alive
}

/// The direction of a reflected ray, in a frame whose +z is the new direction of travel.
///
/// Kernels only refract. From the directions before and behind a surface of any step of n^2 comes
/// the normal, T' - T = (sqrt(xi^2 + step) - xi) N, and with it the reflection T - 2 xi N.
#[inline(always)]
fn reflected<R: Real>(before: [R; 3], behind: [R; 3], incidence: R, step: R) -> [R; 3] {
    let xi = incidence.sqrt();
    let share = -(xi + xi) / ((incidence + step).sqrt() - xi);
    let [x, y, z] = [0, 1, 2].map(|i| share.mul_add(behind[i] - before[i], before[i]));
    [x, y, -z]
}

/// Adds the lanes of a packet, whose bits are set, to a list of rays.
#[cold]
#[inline(never)]
fn note(doubtful: &mut Vec<u32>, mut lanes: u32, first: usize) {
    while lanes != 0 {
        doubtful.push(first as u32 + lanes.trailing_zeros());
        lanes &= lanes - 1;
    }
}

/// Takes a batch through a sequence of surfaces, one surface after another over the whole
/// batch, which hides the latency of root and division as well as interleaving would.
///
/// `blocked[row]` grows by the number of rays that end at a row of the prescription. Rays that
/// come out have a number in `x`, relative to the last vertex; the others NaN. Rays that this
/// precision cannot decide or not trace exactly enough are in [`LensBatch::doubtful`]; they
/// count as neither until [`settle`] has traced them.
#[inline(never)]
pub fn trace<R: Real>(
    batch: &mut LensBatch<R::Scalar>,
    surfaces: &[Surface<R::Scalar>],
    blocked: &mut [u64],
) {
    pass::<R, false>(batch, surfaces, blocked);
}

/// As [`trace`], and every surface takes from the weight what it does not let through
/// ([`Coat`](super::Coat)).
#[inline(never)]
pub fn trace_lossy<R: Real>(
    batch: &mut LensBatch<R::Scalar>,
    surfaces: &[Surface<R::Scalar>],
    blocked: &mut [u64],
) {
    pass::<R, true>(batch, surfaces, blocked);
}

#[inline(always)]
fn pass<R: Real, const LOSSY: bool>(
    batch: &mut LensBatch<R::Scalar>,
    surfaces: &[Surface<R::Scalar>],
    blocked: &mut [u64],
) {
    batch.doubtful.clear();
    let (mut alive, mut doubtful) = (batch.living as u64, 0);
    for surface in surfaces {
        let behind = dispatch::<R, _>(surface, Stage::<R, LOSSY, false> { batch, surface });
        let newly = batch.doubtful.len() as u64 - doubtful;
        blocked[surface.row] += alive - behind - newly;
        (alive, doubtful) = (behind, doubtful + newly);
    }
}

/// As [`trace_lossy`], through surfaces some of which mirror ([`super::ghost_sequence`]).
/// Nothing is noted as doubtful, and nothing needs to be settled: what
/// f32 cannot decide in a ghost nobody sees. Answers how many rays come out.
#[inline(never)]
pub fn trace_ghost<R: Real>(
    batch: &mut LensBatch<R::Scalar>,
    surfaces: &[Surface<R::Scalar>],
) -> u64 {
    let mut alive = batch.living as u64;
    for surface in surfaces {
        alive = match surface.mirror {
            true => dispatch::<R, _>(surface, Stage::<R, true, true> { batch, surface }),
            false => dispatch::<R, _>(surface, Stage::<R, true, false> { batch, surface }),
        };
        if alive == 0 {
            break;
        }
    }
    batch.doubtful.clear();
    alive
}

/// Traces the doubtful rays of a batch again, in f64, from where they started.
///
/// `start` answers the start of a ray by its place in the batch, on the film side of the
/// surfaces; `surfaces` are those that the batch was traced through, in f64.
pub fn settle<R: Real>(
    batch: &mut LensBatch<R::Scalar>,
    surfaces: &[Surface<f64>],
    blocked: &mut [u64],
    start: impl Fn(usize) -> LensRay<f64>,
) {
    retrace::<R, false>(batch, surfaces, blocked, start);
}

/// As [`settle`], for a batch that [`trace_lossy`] traced.
pub fn settle_lossy<R: Real>(
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
    for k in 0..batch.doubtful.len() {
        let i = batch.doubtful[k] as usize;
        match follow::<f64, LOSSY>(start(i), surfaces) {
            Err(end) => blocked[end.row] += 1,
            Ok(ray) => {
                [batch.x[i], batch.y[i], batch.z[i]] = ray.p.map(R::scalar);
                [batch.tx[i], batch.ty[i], batch.tz[i]] = ray.t.map(R::scalar);
                batch.weight[i] = R::scalar(ray.weight);
            }
        }
    }
}

/// Why a ray ends at a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Why {
    /// It meets the surface outside the clear aperture.
    Clip,
    /// It meets the stop outside the opening.
    Stop,
    /// It does not meet the surface's sheet on its way forward.
    Miss,
    /// It is totally reflected.
    Tir,
}

/// Where and why a ray ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Blocked {
    /// Row of the prescription, from 0 at the scene side.
    pub row: usize,
    /// What happened there.
    pub why: Why,
}

/// Takes one ray (or several in step) through a sequence of surfaces, as exactly as the
/// precision can: without a doubt.
///
/// # Errors
/// Where and why the ray of the first lane ends.
pub fn trace_one<R: Real>(
    ray: LensRay<R>,
    surfaces: &[Surface<R::Scalar>],
) -> Result<LensRay<R>, Blocked> {
    follow::<R, false>(ray, surfaces)
}

/// As [`trace_one`], and every surface takes from the weight what it does not let through.
///
/// # Errors
/// Where and why the ray of the first lane ends.
pub(super) fn trace_one_lossy<R: Real>(
    ray: LensRay<R>,
    surfaces: &[Surface<R::Scalar>],
) -> Result<LensRay<R>, Blocked> {
    follow::<R, true>(ray, surfaces)
}

fn follow<R: Real, const LOSSY: bool>(
    mut ray: LensRay<R>,
    surfaces: &[Surface<R::Scalar>],
) -> Result<LensRay<R>, Blocked> {
    for surface in surfaces {
        ray = dispatch::<R, _>(surface, One::<R, LOSSY> { ray, surface })?;
    }
    Ok(ray)
}

struct One<'a, R: Real, const LOSSY: bool> {
    ray: LensRay<R>,
    surface: &'a Surface<R::Scalar>,
}

impl<R: Real, const LOSSY: bool> With<R> for One<'_, R, LOSSY> {
    type Answer = Result<LensRay<R>, Blocked>;

    fn with(self, kernel: impl Kernel<R>) -> Self::Answer {
        one::<R, _, LOSSY>(self.ray, self.surface, kernel)
    }
}

fn one<R: Real, K: Kernel<R>, const LOSSY: bool>(
    ray: LensRay<R>,
    surface: &Surface<R::Scalar>,
    kernel: K,
) -> Result<LensRay<R>, Blocked> {
    let holds = |mask: R::Mask| R::bits(mask) & 1 == 1;
    let end = |why| Err(Blocked { row: surface.row, why });
    let near = (0..kernel.passes()).fold(ray, |ray, pass| kernel.approach(ray, pass));
    let Crossed { ray, met, inside, incidence } = kernel.cross(near);
    // Not a number where there is no point to refract at.
    let nowhere = !holds(ray.p[0].same(ray.p[0]));
    if nowhere || !holds(met) {
        end(Why::Miss)
    } else if !holds(inside) {
        end(if surface.stop { Why::Stop } else { Why::Clip })
    } else if K::REFRACTS && !holds(R::splat(surface.limit).le(incidence)) {
        end(Why::Tir)
    } else if LOSSY && K::REFRACTS {
        Ok(LensRay { weight: ray.weight * surface.coat.transmittance::<R>(incidence), ..ray })
    } else {
        Ok(ray)
    }
}
