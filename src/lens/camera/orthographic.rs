//! Orthographic camera: all rays are parallel to the axis.

use super::Camera;
use super::camera_to_world::CameraToWorld;
use petzval_base::lanes::Real;
use petzval_base::rays::{RayBatch, SampleBatch};

/// Parallel projection onto the plane z = 0 of the camera frame, without depth of field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orthographic {
    /// Centre of the picture in that plane [camera units].
    pub middle: [f64; 2],
}

impl Camera {
    /// Generates parallel rays.
    pub(crate) fn project_parallel<R: Real<Scalar = f32>>(
        &self,
        projection: &Orthographic,
        samples: &SampleBatch,
        rays: &mut RayBatch,
    ) {
        let to_world = CameraToWorld::<R>::new(self, 1.0, 0.0);
        let ratio = R::constant(self.imaging_ratio);
        let middle = projection.middle.map(R::constant);
        let (zero, one) = (R::constant(0.0), R::constant(1.0));
        let film = samples.film.each_ref().map(|column| column.packets::<R>(samples.len));
        for i in 0..film[0].len() {
            // The image on the film is upside down.
            let start = [middle[0] - film[0][i], middle[1] - film[1][i], zero];
            rays.store_packet(i, to_world.ray(start, [zero, zero, one]), ratio);
        }
        rays.number_slots(samples.len);
    }
}
