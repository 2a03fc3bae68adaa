//! Transform of rays from a lens to the world.

use glam::DVec3;

use super::Camera;
use petzval_base::lanes::{Real, vector};

/// Transform of local rays to the world. Offsets are transformed first and the position of the
/// camera is added last, so that no precision is lost far from the origin of the world.
pub(crate) struct CameraToWorld<R> {
    /// Columns of the linear part.
    columns: [[R; 3]; 3],
    /// Local unit in camera units.
    unit: R,
    /// Local origin in the world.
    origin: [R; 3],
    /// Nearest visible depth and the depth range behind it, unless everything is visible.
    depth: Option<[R; 2]>,
}

impl<R: Real> CameraToWorld<R> {
    /// Prepares the transform; `unit` is the local unit in camera units, `front` the depth of the
    /// local origin.
    pub fn new(camera: &Camera, unit: f64, front: f64) -> Self {
        let world = camera.world_from_camera;
        let [near, far] = camera.depth;
        let all = near == 0.0 && far == f64::INFINITY;
        Self {
            columns: world.matrix3.to_cols_array_2d().map(|column| column.map(R::constant)),
            unit: R::constant(unit),
            origin: world.transform_point3(DVec3::new(0.0, 0.0, front)).to_array().map(R::constant),
            depth: (!all).then(|| [near, far - near].map(R::constant)),
        }
    }

    /// Returns the origin, unit direction and end of a ray in the world.
    #[inline(always)]
    pub fn ray(&self, start: [R; 3], towards: [R; 3]) -> ([R; 3], [R; 3], R) {
        let direction = vector::transform(&self.columns, towards);
        let [x, y, z] = direction;
        let length = x.mul_add(x, y.mul_add(y, z * z)).sqrt();
        let per_length = R::constant(1.0) / length;
        let mut start = start.map(|v| v * self.unit);
        let mut end = R::constant(f64::INFINITY);
        if let Some([near, depth]) = self.depth {
            // A ray of a fisheye that goes sideways or backwards meets neither end of the range.
            let zero = R::constant(0.0);
            let forward = zero.lt(towards[2]);
            let per_depth = R::constant(1.0) / towards[2];
            let near = R::select(forward, near * per_depth, zero);
            start = [0, 1, 2].map(|i| near.mul_add(towards[i], start[i]));
            end = R::select(forward, depth * per_depth * length, end);
        }
        let offset = vector::transform(&self.columns, start);
        ([0, 1, 2].map(|i| self.origin[i] + offset[i]), direction.map(|d| d * per_length), end)
    }
}
