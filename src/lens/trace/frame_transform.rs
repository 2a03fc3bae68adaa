//! Change from the frame of one surface to that of the next, if they are tilted or decentred to
//! each other.
//!
//! The change is an entry of its own in the sequence of surfaces, so that the kernels of surfaces
//! need not know of it, and surfaces that move as one body have none between them.

use glam::DAffine3;

use super::kernel::{KernelOutput, LensRay, SurfaceKernel};
use petzval_base::lanes::{Real, vector};

/// A rotation and a translation; mm, +z along the direction of travel in both frames.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameTransform<T> {
    /// Directions of the old axes in the new frame.
    columns: [[T; 3]; 3],
    /// Position of the old origin in the new frame.
    shift: [T; 3],
}

impl<T: Copy> FrameTransform<T> {
    /// Rounds a transform from the old frame to the new one.
    pub(crate) fn new<R: Real<Scalar = T>>(motion: &DAffine3) -> Self {
        Self {
            columns: motion.matrix3.to_cols_array_2d().map(|column| column.map(R::from_f64)),
            shift: motion.translation.to_array().map(R::from_f64),
        }
    }
}

/// A frame transform in every lane.
#[derive(Clone, Copy)]
pub(crate) struct FrameTransformKernel<R> {
    columns: [[R; 3]; 3],
    shift: [R; 3],
}

impl<R: Real> FrameTransformKernel<R> {
    #[inline(always)]
    pub fn of(transform: &FrameTransform<R::Scalar>) -> Self {
        let splat = |v: [R::Scalar; 3]| [R::splat(v[0]), R::splat(v[1]), R::splat(v[2])];
        let [x, y, z] = transform.columns;
        Self { columns: [splat(x), splat(y), splat(z)], shift: splat(transform.shift) }
    }
}

impl<R: Real> SurfaceKernel<R> for FrameTransformKernel<R> {
    const REFRACTS: bool = false;

    #[inline(always)]
    fn cross(&self, ray: LensRay<R>) -> KernelOutput<R> {
        let [x, y, z] = vector::transform(&self.columns, ray.p);
        let [dx, dy, dz] = self.shift;
        let (x, y, z) = (x + dx, y + dy, z + dz);
        let t = vector::transform(&self.columns, ray.t);
        let known = x.equals(x) & y.equals(y) & z.equals(z);
        KernelOutput { ray: LensRay { p: [x, y, z], t, ..ray }, met: known, inside: known, xi2: x }
    }
}
