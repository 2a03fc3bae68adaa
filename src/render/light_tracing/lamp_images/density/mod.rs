//! Density of light paths, and the weight of the camera paths that find the same light.

use glam::Vec3;

use super::LampImages;
use crate::film::Frame;
use crate::light_tracing::light_paths::{CameraPoses, FilmHit};
use crate::shade::{LampWeights, LightSource};
use crate::timing::Timing;
use petzval_base::rays::{Ray, RayBatch};
use petzval_base::sampler::mis::power_heuristic;
use petzval_lens::{Camera, LensModel, RealLens};
use petzval_scene::{Scene, SkySampling};

/// Parts of a job that the weights of camera paths depend on.
#[derive(Clone, Copy, Debug)]
pub struct LampImageWeights<'a> {
    lamp_images: &'a LampImages,
    frame: &'a Frame,
    poses: CameraPoses<'a>,
}

impl<'a> LampImageWeights<'a> {
    /// The weights for light paths, a camera, the pixels of the picture, and the times of the samples if
    /// anything moves.
    pub fn new(
        lamp_images: &'a LampImages,
        camera: &'a Camera,
        frame: &'a Frame,
        timing: Option<&'a Timing>,
    ) -> Self {
        Self { lamp_images, frame, poses: CameraPoses::new(camera, timing) }
    }

    /// Returns the sampling weight of the i-th camera ray of a wave: the reciprocal of its density over
    /// etendue and over the area of the film (mm^2 sr), times the transmission of the lens.
    fn sampling_weight(&self, scene: &Scene, rays: &RayBatch, i: usize) -> f64 {
        match self.need_camera_pdf(scene) {
            false => {
                let brightest = rays.throughput(i).into_iter().fold(0.0f32, f32::max);
                f64::from(brightest) / self.poses.camera.imaging_ratio
            }
            true => 1.0 / f64::from(rays.pdf[i]),
        }
    }

    /// Returns whether camera rays need their pdf beside their throughput, which is that of all
    /// bands that share a ray, and contains the transmittance of media.
    pub(crate) fn need_camera_pdf(&self, scene: &Scene) -> bool {
        self.poses.camera.bands() > 1 || scene.has_media()
    }

    /// Returns the weight of a light path of this density over etendue (mm^-2 sr^-1). The etendue at the
    /// film contains the square of the index before it.
    pub(super) fn light_weight(&self, lens: &RealLens, density: f64, hit: &FilmHit) -> f32 {
        if self.lamp_images.exclusive {
            return 1.0;
        }
        let [x, y, z] = hit.towards;
        let normal = lens.film_pose.film_normal();
        let cos = (normal[0] * x + normal[1] * y + normal[2] * z) / (x * x + y * y + z * z).sqrt();
        let etendue = lens.prescription.rear().index.powi(2) * cos;
        let camera = self.row_exposure() * lens.sampling_density(hit.point, hit.towards)
            / (hit.transmission * etendue * self.pixel_area());
        power_heuristic((density * self.light_paths()) as f32, camera as f32)
    }

    /// Returns the area of a pixel (mm^2). The camera takes one path per pixel.
    fn pixel_area(&self) -> f64 {
        let [width, height] = self.poses.camera.pixel_pitch(self.frame.resolution);
        width * height
    }

    /// Returns the density of the camera over time relative to that of light paths, in a row that is
    /// exposed. Its mean is enough, as it is the same for both kinds of paths.
    fn row_exposure(&self) -> f64 {
        self.poses.timing.map_or(1.0, Timing::mean_row_exposure)
    }

    /// Returns the number of light paths per sample number.
    fn light_paths(&self) -> f64 {
        self.lamp_images.path_count(self.frame).paths()
    }

    /// Returns the density over etendue (mm^-2 sr^-1) of a light path at the path of a camera ray in the
    /// world. `None` if no light path finds it.
    fn light_path_density(
        &self,
        scene: &Scene,
        ray: &Ray,
        time: f32,
        source: LightSource,
    ) -> Option<f64> {
        let (origin, direction) = (Vec3::from(ray.origin), Vec3::from(ray.direction));
        let LensModel::Real(lens) = &self.poses.camera.model else { return None };
        let lamps = self.lamp_images;
        let light = match source {
            LightSource::Shape(hit, _) => scene.shapes[hit.shape as usize].light,
            LightSource::Sky(sky) => sky,
        };
        let lamp = &lamps.lamps[(*lamps.by_light.get(light as usize)?)? as usize];
        let pose = self.poses.at(time);
        let (at_front, towards) = pose.crossing(lens, origin, direction)?;
        let uv = lamps.front.square.point(at_front)?;
        if !lamp.is_traced(uv) {
            return None;
        }
        let entry = f64::from(lamp.entry.density(uv));
        let from = pose.front_point(lens, at_front);
        let to_light = match source {
            LightSource::Shape(hit, point) => {
                scene.emitter_density(hit, from, point, direction)
                    * lamp.primitives.probability(hit.primitive as usize)
            }
            LightSource::Sky(sky) => {
                scene.sky_direction_density(sky, from, direction, SkySampling::Complete)
            }
        };
        Some(lamps.density(f64::from(lamp.share), entry, f64::from(to_light), towards.z))
    }
}

impl LampWeights for LampImageWeights<'_> {
    fn camera_weight(
        &self,
        scene: &Scene,
        rays: &RayBatch,
        i: usize,
        time: f32,
        source: LightSource,
    ) -> f32 {
        let Some(density) = self.light_path_density(scene, &rays.ray(i), time, source) else {
            return 1.0;
        };
        if self.lamp_images.exclusive {
            return if density > 0.0 { 0.0 } else { 1.0 };
        }
        let weight = self.sampling_weight(scene, rays, i);
        let camera = self.row_exposure() / (self.pixel_area() * weight);
        power_heuristic(camera as f32, (density * self.light_paths()) as f32)
    }
}

impl LampImages {
    /// Returns the density over etendue (mm^-2 sr^-1) of one light path: with the probability of
    /// its lamp, the density of its entry point over the unit square, that of its direction (1/sr)
    /// and its cosine to the axis.
    pub(super) fn density(&self, share: f64, entry: f64, to_light: f64, cos: f64) -> f64 {
        share * entry / self.front.square.area() * to_light / cos
    }
}

#[cfg(test)]
mod tests;
