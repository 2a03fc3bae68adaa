//! Density of light paths, and the weight of the camera paths that find the same light.

use glam::Vec3;

use super::{DirectLight, path_count};
use crate::film::Frame;
use crate::lens::{Camera, LensModel};
use crate::rays::Hit;
use crate::sampler::mis::power_heuristic;
use crate::scene::{Scene, SurfacePoint};

/// Parts of a job that the weights of camera paths depend on.
#[derive(Clone, Copy, Debug)]
pub struct DirectLightWeights<'a> {
    /// The lamps.
    pub direct_light: &'a DirectLight,
    /// The camera.
    pub camera: &'a Camera,
    /// The pixels of the picture.
    pub frame: &'a Frame,
}

/// A camera ray that found a light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FoundLight<'a> {
    /// Where the ray leaves the plane of the front vertex, in the world.
    pub origin: Vec3,
    /// Its unit direction.
    pub direction: Vec3,
    /// Its hit.
    pub hit: &'a Hit,
    /// The point that it hit.
    pub point: &'a SurfacePoint,
    /// Its throughput.
    pub throughput: f32,
}

impl DirectLightWeights<'_> {
    /// Returns the weight of a camera path that ends at a light.
    pub(crate) fn camera_weight(&self, scene: &Scene, found: &FoundLight) -> f32 {
        let Some(density) = self.light_path_density(scene, found) else { return 1.0 };
        let pitch = self.camera.pixel_pitch(self.frame.resolution);
        let per_pixel = f64::from(found.throughput) / self.camera.imaging_ratio;
        // The camera takes one path per pixel.
        let camera = 1.0 / (pitch[0] * pitch[1] * per_pixel);
        power_heuristic(camera as f32, density as f32)
    }

    /// Returns the density over etendue (mm^-2 sr^-1) of the light paths of one sample number at
    /// the path of a camera ray. `None` if no light path finds it.
    fn light_path_density(&self, scene: &Scene, found: &FoundLight) -> Option<f64> {
        let FoundLight { origin, direction, hit, point, .. } = *found;
        let LensModel::Real(lens) = &self.camera.model else { return None };
        let lamps = self.direct_light;
        let light = scene.shapes[hit.shape as usize].light;
        let lamp = &lamps.lamps[(*lamps.by_light.get(light as usize)?)? as usize];
        let camera_from_world = self.camera.world_from_camera.inverse();
        let place = camera_from_world.transform_point3(origin.as_dvec3()) / lens.units_per_mm;
        let cos = camera_from_world.transform_vector3(direction.as_dvec3()).normalize().z;
        let uv = [place.x, place.y].map(|v| (v / lamps.front.half + 1.0) / 2.0);
        if !(cos > 0.0 && uv.iter().all(|v| (0.0..1.0).contains(v))) {
            return None;
        }
        let entry = f64::from(lamp.entry.density(uv.map(|v| v as f32)));
        let to_light = scene.emitter_density(hit, origin, point, direction)
            * lamp.primitives.probability(hit.primitive);
        let paths = lamps.density(f64::from(lamp.share), entry, f64::from(to_light), cos);
        Some(paths * path_count(self.frame).paths())
    }
}

impl DirectLight {
    /// Returns the density over etendue (mm^-2 sr^-1) of one light path: with the probability of
    /// its lamp, the density of its entry point over the unit square, that of its direction (1/sr)
    /// and its cosine to the axis.
    pub(super) fn density(&self, share: f64, entry: f64, to_light: f64, cos: f64) -> f64 {
        share * entry / (4.0 * self.front.half * self.front.half) * to_light / cos
    }
}
