//! Absorption on the way of rays through glass.

use super::kernel::LensRay;
use super::surface::Surface;
use petzval_base::lanes::Real;
use petzval_base::rays::LensBatch;

/// Optical depth beyond which glass is opaque: a share of 1e-7 passes.
const OPAQUE: f64 = 16.0;
/// Number of squarings of the exponential's argument, and 2 to its power.
const SQUARINGS: u32 = 4;
const PARTS: f64 = 16.0;
/// Taylor's series of e^-x for x <= 1, from the highest power; the next term is 3e-7.
const SERIES: [f64; 10] = [
    -1.0 / 362_880.0,
    1.0 / 40_320.0,
    -1.0 / 5040.0,
    1.0 / 720.0,
    -1.0 / 120.0,
    1.0 / 24.0,
    -1.0 / 6.0,
    0.5,
    -1.0,
    1.0,
];

/// Returns the share of the light e^-x behind an optical depth x >= 0 (Lambert 1760).
#[inline(always)]
fn passed<R: Real>(depth: R) -> R {
    let x = depth.min(R::constant(OPAQUE)) * R::constant(1.0 / PARTS);
    let mut share = SERIES.iter().fold(R::constant(0.0), |sum, &c| sum.mul_add(x, R::constant(c)));
    for _ in 0..SQUARINGS {
        share = share * share;
    }
    share
}

/// Returns the share of the light that the medium before a surface lets pass, from a point relative
/// to the vertex crossed before to one relative to the vertex of the surface, behind its reflection
/// if it is a mirror.
#[inline(always)]
fn passed_between<R: Real>(
    from: [R; 3],
    to: [R; 3],
    surface: &Surface<R::Scalar>,
    absorption: R::Scalar,
) -> R {
    let z = if surface.mirror { -to[2] } else { to[2] };
    let way = [to[0] - from[0], to[1] - from[1], z - from[2] + R::splat(surface.advance)];
    let length2 = way[0].mul_add(way[0], way[1].mul_add(way[1], way[2] * way[2]));
    passed(length2.sqrt() * R::splat(absorption))
}

/// Takes from a ray at a surface the light that was absorbed on its way from a point.
#[inline(always)]
pub(super) fn absorb<R: Real>(
    from: [R; 3],
    ray: LensRay<R>,
    surface: &Surface<R::Scalar>,
) -> LensRay<R> {
    match surface.absorption {
        None => ray,
        Some(absorption) => {
            LensRay { weight: ray.weight * passed_between(from, ray.p, surface, absorption), ..ray }
        }
    }
}

/// Keeps the positions of a batch, if the medium before the next surface absorbs.
#[inline(always)]
pub(super) fn depart<R: Real>(batch: &mut LensBatch<R::Scalar>, surface: &Surface<R::Scalar>) {
    if surface.absorption.is_some() {
        let LensBatch { len, x, y, z, departure, .. } = batch;
        let kept = departure.get_or_insert_default();
        for (to, from) in kept.iter_mut().zip([x, y, z]) {
            to.packets_mut::<R>(*len).copy_from_slice(from.packets::<R>(*len));
        }
    }
}

/// Takes from a batch at a surface the light that was absorbed since [`depart`].
#[inline(always)]
pub(super) fn absorb_batch<R: Real>(
    batch: &mut LensBatch<R::Scalar>,
    surface: &Surface<R::Scalar>,
) {
    let (Some(absorption), Some(kept)) = (surface.absorption, &batch.departure) else { return };
    let len = batch.len;
    let [from_x, from_y, from_z] = kept.each_ref().map(|column| column.packets::<R>(len));
    let [x, y, z] = [&batch.x, &batch.y, &batch.z].map(|column| column.packets::<R>(len));
    let weight = batch.weight.packets_mut::<R>(len);
    for (i, weight) in weight.iter_mut().enumerate() {
        let from = [from_x[i], from_y[i], from_z[i]];
        let share = passed_between(from, [x[i], y[i], z[i]], surface, absorption);
        *weight = *weight * share;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use petzval_base::lanes::f32x8;

    #[test]
    fn exponentials_are_accurate_in_every_precision() {
        let mut x = 1e-8f64;
        while x < OPAQUE {
            let exact = (-x).exp();
            let tolerance = (1e-6 + 1e-7 * x).max(if x > 8.0 { 1e-5 } else { 0.0 });
            for found in [passed::<f64>(x), f64::from(passed::<f32>(x as f32))] {
                assert!((found / exact - 1.0).abs() < tolerance, "{x}: {found}, not {exact}");
            }
            x *= 1.1;
        }
        assert_eq!(passed::<f32>(0.0), 1.0);
        for x in [17.0, 1e9, f32::INFINITY] {
            assert!((0.0..2e-7).contains(&passed::<f32>(x)), "{x}");
        }
        for k in 0..1000 {
            let x = k as f32 * 0.02;
            let mut lanes = [0.0f32; 8];
            passed(f32x8::splat(x)).store(&mut lanes);
            assert_eq!(lanes.map(f32::to_bits), [passed::<f32>(x).to_bits(); 8]);
        }
    }
}
