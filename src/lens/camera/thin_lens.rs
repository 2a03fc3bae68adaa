//! Thin lens: a pinhole, or a disk that focuses on one plane.

use super::Camera;
use super::camera_to_world::CameraToWorld;
use petzval_base::lanes::Real;
use petzval_base::rays::{RayBatch, SampleBatch};
use petzval_base::sampler::concentric_disk;

/// Thin lens without aberration or vignetting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinLens {
    /// Radius of the disk [camera units]; 0 for a pinhole.
    pub radius: f64,
    /// Depth of the plane in focus [camera units].
    pub focus: f64,
    /// Centre of the picture in the plane z = 1 of the camera frame.
    pub middle: [f64; 2],
}

impl Camera {
    /// Generates the rays of a thin lens or pinhole.
    pub(crate) fn project<R: Real<Scalar = f32>>(
        &self,
        lens: &ThinLens,
        samples: &SampleBatch,
        rays: &mut RayBatch,
    ) {
        let to_world = CameraToWorld::<R>::new(self, 1.0, 0.0);
        let [ratio, radius, focus] = [self.imaging_ratio, lens.radius, lens.focus].map(R::constant);
        let middle = lens.middle.map(R::constant);
        let (zero, one) = (R::constant(0.0), R::constant(1.0));
        let len = samples.len;
        let film = samples.film.each_ref().map(|column| column.packets::<R>(len));
        let pupil = samples.pupil.each_ref().map(|column| column.packets::<R>(len));
        for i in 0..film[0].len() {
            // The image on the film is upside down: the plane z = 1 is mirrored.
            let seen = [middle[0] - film[0][i], middle[1] - film[1][i]];
            let (start, towards) = if lens.radius > 0.0 {
                let [x, y] = concentric_disk(pupil[0][i], pupil[1][i]).map(|d| d * radius);
                ([x, y, zero], [seen[0] * focus - x, seen[1] * focus - y, focus])
            } else {
                ([zero; 3], [seen[0], seen[1], one])
            };
            rays.store_packet(i, to_world.ray(start, towards), ratio);
        }
        rays.number_slots(len);
    }
}
