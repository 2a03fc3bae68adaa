//! A camera that moves: a stage.

use glam::DVec3;

use super::Motion;
use crate::rays::{Column, RayBatch};

impl Motion {
    /// Takes the rays of a camera at rest to where it stands at the time of each, found by its
    /// slot. Their directions stay of unit length.
    pub fn carry(&self, times: &Column<f32>, rays: &mut RayBatch) {
        for i in 0..rays.len {
            let transform = self.at(f64::from(times[rays.slot[i] as usize]));
            let vector = |columns: &[Column<f32>; 3]| {
                DVec3::from_array([0, 1, 2].map(|axis| f64::from(columns[axis][i])))
            };
            let origin = transform.transform_point3(vector(&rays.origin));
            let direction = transform.transform_vector3(vector(&rays.direction));
            let length = direction.length();
            for axis in 0..3 {
                rays.origin[axis][i] = origin[axis] as f32;
                rays.direction[axis][i] = (direction[axis] / length) as f32;
            }
            rays.t_max[i] *= length as f32;
        }
    }
}
