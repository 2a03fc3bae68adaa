//! Trace of rays past rims, with their optical paths.

use super::batch::reflected;
use super::kernel::{KernelOutput, KernelVisitor, LensRay, SurfaceKernel, dispatch};
use super::surface::{Surface, SurfaceKind};
use petzval_base::lanes::Real;

/// Value of [`OpticalPath::clipped`] for a ray that passes.
pub const PASSES: f64 = -1.0;

/// A ray, or a packet of rays, behind a sequence of surfaces, with what happened on the way.
#[derive(Clone, Copy, Debug)]
pub struct OpticalPath<R> {
    /// The ray in the frame of the last surface.
    pub ray: LensRay<R>,
    /// Optical path length from the start of the ray to the last surface (mm); NaN if the ray
    /// misses a surface, is totally reflected or passes an ideal lens.
    pub length: R,
    /// Point in the plane of the stop (mm); NaN if the sequence does not contain it.
    pub stop: [R; 2],
    /// First row whose rim, stop or obstruction would have blocked the ray, or [`PASSES`].
    pub clipped: R,
}

impl<R: Real<Scalar = f64>> OpticalPath<R> {
    fn new(ray: LensRay<R>) -> Self {
        let nan = R::splat(f64::NAN);
        Self { ray, length: R::splat(0.0), stop: [nan; 2], clipped: R::splat(PASSES) }
    }
}

/// Traces rays through a sequence of surfaces as if they had no rims.
pub fn trace_past_rims<R: Real<Scalar = f64>>(
    ray: LensRay<R>,
    surfaces: &[Surface<f64>],
) -> OpticalPath<R> {
    surfaces.iter().fold(OpticalPath::new(ray), |path, surface| {
        dispatch::<R, _>(surface, PathCrossing { path, surface })
    })
}

/// Rays with their paths, at one surface.
struct PathCrossing<'a, R> {
    path: OpticalPath<R>,
    surface: &'a Surface<f64>,
}

impl<R: Real<Scalar = f64>> KernelVisitor<R> for PathCrossing<'_, R> {
    type Output = OpticalPath<R>;

    fn visit(self, kernel: impl SurfaceKernel<R>) -> Self::Output {
        cross(self.path, self.surface, kernel)
    }
}

fn cross<R: Real<Scalar = f64>, K: SurfaceKernel<R>>(
    mut path: OpticalPath<R>,
    surface: &Surface<f64>,
    kernel: K,
) -> OpticalPath<R> {
    let start = path.ray;
    let near = (0..kernel.passes()).fold(start, |ray, pass| kernel.approach(ray, pass));
    let KernelOutput { ray, met, inside, xi2 } = kernel.cross(near);
    let nan = R::splat(f64::NAN);
    path.length = match surface.kind {
        // A frame transform moves the axes, not the ray.
        SurfaceKind::FrameTransform(_) => path.length,
        // First-order optics and fitted polynomials say nothing of the way inside.
        SurfaceKind::Ideal(_) | SurfaceKind::Polynomial(_) => nan,
        _ => {
            let [x, y, z] = [
                ray.p[0] - start.p[0],
                ray.p[1] - start.p[1],
                ray.p[2] - start.p[2] + R::splat(surface.advance),
            ];
            // The direction has the length of the index, which makes this an optical length.
            let along = x.mul_add(start.t[0], y.mul_add(start.t[1], z * start.t[2]));
            path.length + along
        }
    };
    path.length = R::select(met, path.length, nan);
    if K::REFRACTS {
        path.length = R::select(R::splat(surface.limit).le(xi2), path.length, nan);
    }
    let passes = path.clipped.lt(R::splat(0.0));
    let blocked = R::select(inside, path.clipped, R::splat(surface.row as f64));
    path.clipped = R::select(passes, blocked, path.clipped);
    path.ray = if K::REFRACTS && surface.mirror {
        let [x, y, z] = ray.p;
        let t = reflected(near.t, ray.t, xi2, R::splat(surface.n2_step));
        LensRay { p: [x, y, -z], t, ..ray }
    } else {
        ray
    };
    if surface.stop {
        let [x, y] = path.stop;
        let first = x.equals(x);
        path.stop = [R::select(first, x, ray.p[0]), R::select(first, y, ray.p[1])];
    }
    path
}
