//! A lens that is no glass: a pinhole, or a disk that focuses.

use super::camera::Camera;
use super::placement::Placement;
use crate::lanes::Real;
use crate::rays::{RayBatch, SampleBatch};
use crate::sampler::disk;

/// The lens of textbooks: one plane, no aberration, no vignetting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinLens {
    /// Radius of its disk, camera units; 0 for a pinhole.
    pub radius: f64,
    /// Depth of the plane in focus, camera units.
    pub focus: f64,
    /// Where the middle of the picture lies in the plane z = 1, camera frame.
    pub middle: [f64; 2],
}

impl Camera {
    /// The rays of a thin lens or pinhole.
    pub(super) fn project<R: Real<Scalar = f32>>(
        &self,
        lens: &ThinLens,
        samples: &SampleBatch,
        rays: &mut RayBatch,
    ) {
        let place = Placement::<R>::new(self, 1.0, 0.0);
        let [ratio, radius, focus] = [self.imaging_ratio, lens.radius, lens.focus].map(R::constant);
        let middle = lens.middle.map(R::constant);
        let (zero, one) = (R::constant(0.0), R::constant(1.0));
        let len = samples.len;
        let film = samples.film.each_ref().map(|column| column.packets::<R>(len));
        let pupil = samples.pupil.each_ref().map(|column| column.packets::<R>(len));
        for i in 0..film[0].len() {
            // The film point's picture lies mirrored in the plane z = 1.
            let seen = [middle[0] - film[0][i], middle[1] - film[1][i]];
            let (start, towards) = if lens.radius > 0.0 {
                let [x, y] = disk(pupil[0][i], pupil[1][i]).map(|d| d * radius);
                ([x, y, zero], [seen[0] * focus - x, seen[1] * focus - y, focus])
            } else {
                ([zero; 3], [seen[0], seen[1], one])
            };
            let (origin, direction, end) = place.ray(start, towards);
            let to = i * R::LANES..(i + 1) * R::LANES;
            for axis in 0..3 {
                origin[axis].store(&mut rays.origin[axis][to.clone()]);
                direction[axis].store(&mut rays.direction[axis][to.clone()]);
                ratio.store(&mut rays.carried[axis][to.clone()]);
            }
            end.store(&mut rays.t_max[to]);
        }
        for i in 0..len {
            rays.slot[i] = i as u32;
        }
        rays.len = len;
    }
}
