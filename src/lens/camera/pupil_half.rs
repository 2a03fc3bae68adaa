//! Halves of the exit pupil, which the two photodiodes of a dual pixel see.
//!
//! The microlens of a dual pixel images the exit pupil onto two photodiodes side by side. As on sensors
//! whose microlenses are shifted towards the axis, the line between them is the image of the middle of the
//! paraxial exit pupil, for all points of the film.

use super::{Camera, LensColumns, LensModel, RealLens};
use petzval_base::lanes::Real;
use petzval_base::rays::SampleBatch;
use petzval_base::stats::LensStats;

impl RealLens {
    /// Returns whether a ray from a point of the film [mm from its centre] passes the left half of the exit
    /// pupil, as seen from behind the camera. The direction is in the frame of the lens, z towards the
    /// scene, of any length.
    pub fn is_left_half(&self, film: [f64; 2], towards: [f64; 3]) -> bool {
        self.is_left_of_axis_in_pupil(self.film_pose.film_point(film), towards)
    }

    /// Returns the same for a ray from a point in the frame of the lens, z from the plane of the aligned film.
    fn is_left_of_axis_in_pupil(&self, [x, _, z]: [f64; 3], [dx, _, dz]: [f64; 3]) -> bool {
        let to_pupil = self.film_distance - z - self.paraxial.exit_pupil.position;
        // Position in the pupil over its distance: finite for a telecentric lens too.
        dx / dz + x / to_pupil < 0.0
    }
}

impl Camera {
    /// Finds the half of the exit pupil through which the ray of each sample passes: a stage before
    /// [`Camera::generate_rays`], which makes the same rays.
    pub fn find_pupil_halves<R: Real<Scalar = f32>>(
        &self,
        samples: &mut SampleBatch,
        columns: &mut LensColumns,
    ) {
        let LensModel::Real(lens) = &self.model else { return };
        lens.launch::<R>(samples, columns, &mut LensStats::default());
        let rays = &columns.batch;
        for i in 0..samples.len {
            let point = [rays.x[i], rays.y[i], rays.z[i]].map(f64::from);
            let towards = [rays.tx[i], rays.ty[i], rays.tz[i]].map(f64::from);
            samples.left_half[i] = lens.is_left_of_axis_in_pupil(point, towards);
        }
    }
}
