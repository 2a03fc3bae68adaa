//! Where a camera stands: from rays of a lens to rays in the world.

use glam::DVec3;

use super::camera::Camera;
use crate::lanes::Real;

/// Takes local rays to the world: small offsets and directions first, the place last, so
/// that nothing is lost far from the world's origin.
pub(super) struct Placement<R> {
    linear: [[R; 3]; 3],
    unit: R,
    origin: [R; 3],
    /// Nearest depth and what lies between it and the farthest, unless all is seen.
    depth: Option<[R; 2]>,
}

impl<R: Real> Placement<R> {
    /// `unit` is the local unit in camera units, `front` the depth of the local origin.
    pub fn new(camera: &Camera, unit: f64, front: f64) -> Self {
        let world = camera.world_from_camera;
        let [near, far] = camera.depth;
        let all = near == 0.0 && far == f64::INFINITY;
        Self {
            linear: world.matrix3.to_cols_array_2d().map(|column| column.map(R::constant)),
            unit: R::constant(unit),
            origin: world.transform_point3(DVec3::new(0.0, 0.0, front)).to_array().map(R::constant),
            depth: (!all).then(|| [near, far - near].map(R::constant)),
        }
    }

    /// Origin, unit direction and end of a ray in the world.
    #[inline(always)]
    pub fn ray(&self, start: [R; 3], towards: [R; 3]) -> ([R; 3], [R; 3], R) {
        let direction = self.turn(towards);
        let [x, y, z] = direction;
        let length = x.mul_add(x, y.mul_add(y, z * z)).sqrt();
        let per_length = R::constant(1.0) / length;
        let mut start = start.map(|v| v * self.unit);
        let mut end = R::constant(f64::INFINITY);
        if let Some([near, depth]) = self.depth {
            // A fisheye's ray that goes sideways or back meets neither end of the depth.
            let zero = R::constant(0.0);
            let forward = zero.lt(towards[2]);
            let per_depth = R::constant(1.0) / towards[2];
            let near = R::select(forward, near * per_depth, zero);
            start = [0, 1, 2].map(|i| near.mul_add(towards[i], start[i]));
            end = R::select(forward, depth * per_depth * length, end);
        }
        let offset = self.turn(start);
        ([0, 1, 2].map(|i| self.origin[i] + offset[i]), direction.map(|d| d * per_length), end)
    }

    #[inline(always)]
    fn turn(&self, v: [R; 3]) -> [R; 3] {
        let [x, y, z] = &self.linear;
        [0, 1, 2].map(|i| x[i].mul_add(v[0], y[i].mul_add(v[1], z[i] * v[2])))
    }
}
