//! Tracing of one ray, with the reason for which it ends.

use super::absorption::absorb;
use super::batch::reflected;
use super::kernel::{KernelOutput, KernelVisitor, LensRay, SurfaceKernel, dispatch};
use super::surface::Surface;
use petzval_base::lanes::Real;

/// Reason for which a ray ends at a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlockReason {
    /// The ray meets the surface outside the clear aperture.
    Clip,
    /// The ray meets the stop outside its opening.
    Stop,
    /// The ray does not meet the sheet of the surface at the vertex, going forward.
    Miss,
    /// The ray is totally reflected.
    Tir,
}

/// Place and reason of the end of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Blocked {
    /// Row of the prescription, from 0 at the scene side.
    pub row: usize,
    /// Reason for which the ray ends there.
    pub reason: BlockReason,
}

/// Traces one ray, or a packet in step, through a sequence of surfaces. No ray is refused as too
/// uncertain for the precision.
///
/// # Errors
/// Returns the place and the reason if the ray of the first lane ends.
pub fn trace_one<R: Real>(
    ray: LensRay<R>,
    surfaces: &[Surface<R::Scalar>],
) -> Result<LensRay<R>, Blocked> {
    follow::<R, false>(ray, surfaces)
}

/// Traces like [`trace_one`]; every surface multiplies the weight by its transmittance,
/// and glass that absorbs by the share of light that it lets pass.
///
/// # Errors
/// Returns the place and the reason if the ray of the first lane ends.
pub(crate) fn trace_one_lossy<R: Real>(
    ray: LensRay<R>,
    surfaces: &[Surface<R::Scalar>],
) -> Result<LensRay<R>, Blocked> {
    follow::<R, true>(ray, surfaces)
}

pub(super) fn follow<R: Real, const LOSSY: bool>(
    mut ray: LensRay<R>,
    surfaces: &[Surface<R::Scalar>],
) -> Result<LensRay<R>, Blocked> {
    for surface in surfaces {
        let from = ray.p;
        ray = dispatch::<R, _>(surface, Crossing::<R, LOSSY> { ray, surface })?;
        if LOSSY {
            ray = absorb(from, ray, surface);
        }
    }
    Ok(ray)
}

/// One ray at one surface.
struct Crossing<'a, R: Real, const LOSSY: bool> {
    ray: LensRay<R>,
    surface: &'a Surface<R::Scalar>,
}

impl<R: Real, const LOSSY: bool> KernelVisitor<R> for Crossing<'_, R, LOSSY> {
    type Output = Result<LensRay<R>, Blocked>;

    fn visit(self, kernel: impl SurfaceKernel<R>) -> Self::Output {
        cross::<R, _, LOSSY>(self.ray, self.surface, kernel)
    }
}

fn cross<R: Real, K: SurfaceKernel<R>, const LOSSY: bool>(
    ray: LensRay<R>,
    surface: &Surface<R::Scalar>,
    kernel: K,
) -> Result<LensRay<R>, Blocked> {
    let holds = |mask: R::Mask| R::bits(mask) & 1 == 1;
    let end = |reason| Err(Blocked { row: surface.row, reason });
    let near = (0..kernel.passes()).fold(ray, |ray, pass| kernel.approach(ray, pass));
    let KernelOutput { ray, met, inside, xi2 } = kernel.cross(near);
    // Without a point to refract at, the position is NaN.
    let nowhere = !holds(ray.p[0].equals(ray.p[0]));
    if nowhere || !holds(met) {
        end(BlockReason::Miss)
    } else if !holds(inside) {
        end(if surface.stop { BlockReason::Stop } else { BlockReason::Clip })
    } else if K::REFRACTS && !holds(R::splat(surface.limit).le(xi2)) {
        end(BlockReason::Tir)
    } else if K::REFRACTS && surface.mirror {
        let [x, y, z] = ray.p;
        let t = reflected(near.t, ray.t, xi2, R::splat(surface.n2_step));
        Ok(LensRay { p: [x, y, -z], t, ..ray })
    } else if LOSSY && K::REFRACTS {
        Ok(LensRay { weight: ray.weight * surface.coating.transmittance::<R>(xi2), ..ray })
    } else {
        Ok(ray)
    }
}
