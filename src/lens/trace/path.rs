//! Trace of one ray past rims, with its optical path.

use super::batch::reflected;
use super::kernel::{KernelOutput, KernelVisitor, LensRay, SurfaceKernel, dispatch};
use super::single::{BlockReason, Blocked};
use super::surface::{Surface, SurfaceKind};

/// A ray behind a sequence of surfaces, with what happened on its way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OpticalPath {
    /// The ray in the frame of the last surface.
    pub ray: LensRay<f64>,
    /// Optical path length from the start of the ray to the last surface (mm); NaN behind an ideal
    /// lens.
    pub length: f64,
    /// Point in the plane of the stop (mm), if the sequence contains it.
    pub stop: Option<[f64; 2]>,
    /// First row whose rim, stop or obstruction would have blocked the ray.
    pub clipped: Option<usize>,
}

/// Traces a ray through a sequence of surfaces as if they had no rims.
///
/// # Errors
/// Returns the place and the reason if the ray misses a surface or is totally reflected.
pub(crate) fn trace_past_rims(
    ray: LensRay<f64>,
    surfaces: &[Surface<f64>],
) -> Result<OpticalPath, Blocked> {
    let mut path = OpticalPath { ray, length: 0.0, stop: None, clipped: None };
    for surface in surfaces {
        path = dispatch::<f64, _>(surface, PathCrossing { path, surface })?;
    }
    Ok(path)
}

/// A ray with its path, at one surface.
struct PathCrossing<'a> {
    path: OpticalPath,
    surface: &'a Surface<f64>,
}

impl KernelVisitor<f64> for PathCrossing<'_> {
    type Output = Result<OpticalPath, Blocked>;

    fn visit(self, kernel: impl SurfaceKernel<f64>) -> Self::Output {
        cross(self.path, self.surface, kernel)
    }
}

fn cross<K: SurfaceKernel<f64>>(
    mut path: OpticalPath,
    surface: &Surface<f64>,
    kernel: K,
) -> Result<OpticalPath, Blocked> {
    let start = path.ray;
    let near = (0..kernel.passes()).fold(start, |ray, pass| kernel.approach(ray, pass));
    let KernelOutput { ray, met, inside, xi2 } = kernel.cross(near);
    let end = |reason| Err(Blocked { row: surface.row, reason });
    if ray.p[0].is_nan() || !met {
        return end(BlockReason::Miss);
    }
    let refracts = xi2 >= surface.limit;
    if K::REFRACTS && !refracts {
        return end(BlockReason::Tir);
    }
    match surface.kind {
        // A frame transform moves the axes, not the ray.
        SurfaceKind::FrameTransform(_) => {}
        // First-order optics and fitted polynomials say nothing of the way inside.
        SurfaceKind::Ideal(_) | SurfaceKind::Polynomial(_) => path.length = f64::NAN,
        _ => {
            let [x, y, z] = [0, 1, 2].map(|i| ray.p[i] - start.p[i]);
            let along = [x, y, z + surface.advance];
            // The direction has the length of the index, which makes this an optical length.
            path.length += (0..3).map(|i| along[i] * start.t[i]).sum::<f64>();
        }
    }
    if !inside && path.clipped.is_none() {
        path.clipped = Some(surface.row);
    }
    path.ray = if K::REFRACTS && surface.mirror {
        let [x, y, z] = ray.p;
        let t = reflected(near.t, ray.t, xi2, surface.n2_step);
        LensRay { p: [x, y, -z], t, ..ray }
    } else {
        ray
    };
    if surface.stop && path.stop.is_none() {
        path.stop = Some([ray.p[0], ray.p[1]]);
    }
    Ok(path)
}
