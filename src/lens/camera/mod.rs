//! Camera: a lens model, the film behind it, and their pose in the world.

pub(crate) mod band;
pub(crate) mod camera_to_world;
mod displacement;
pub mod fidelity;
pub mod film_map;
pub(crate) mod orthographic;
mod pupil_half;
pub(crate) mod ray_path;
pub(crate) mod real_lens;
pub(crate) mod reprojection;
pub(crate) mod spherical;
pub mod thin_lens;
pub mod throughput;

pub use real_lens::{LensColumns, RealLens};

use glam::DAffine3;

use crate::camera::band::Band;
use crate::camera::camera_to_world::CameraToWorld;
use crate::camera::film_map::FilmMap;
use crate::camera::orthographic::Orthographic;
use crate::camera::spherical::SphericalMapping;
use crate::camera::thin_lens::ThinLens;
use petzval_base::lanes;
use petzval_base::lanes::Real;
use petzval_base::rays::{LensBatch, RayBatch, SampleBatch};
use petzval_base::stats::LensStats;

/// Generates rays from film samples.
#[derive(Clone, Debug)]
pub struct Camera {
    /// The lens.
    pub model: LensModel,
    /// Width and height of the film: in mm for a real lens, in the plane z = 1 for a thin lens, in
    /// camera units for parallel rays, and 1 for a spherical camera.
    pub film: [f64; 2],
    /// Camera space (+z to the scene) to world space.
    pub world_from_camera: DAffine3,
    /// Factor from the weight of a ray to the value of a pixel: exposure time x ISO / 100.
    pub imaging_ratio: f64,
    /// Nearest and farthest visible depth, camera units.
    pub depth: [f64; 2],
}

/// A model of the lens.
#[derive(Clone, Debug)]
pub enum LensModel {
    /// A real lens, surface by surface.
    Real(Box<RealLens>),
    /// A pinhole, or a disk that focuses perfectly on one plane.
    Thin(ThinLens),
    /// No lens: parallel rays.
    Orthographic(Orthographic),
    /// No lens: rays in all directions from one point.
    Spherical(SphericalMapping),
}

impl Camera {
    /// Returns half the diagonal of the film.
    pub fn half_diagonal(&self) -> f64 {
        self.film[0].hypot(self.film[1]) / 2.0
    }

    /// Returns the width and height of a pixel of a picture of this resolution (mm).
    pub fn pixel_pitch(&self, resolution: [u32; 2]) -> [f64; 2] {
        [0, 1].map(|i| self.film[i] / f64::from(resolution[i]))
    }

    /// Returns the number of bands into which the light is split.
    pub fn bands(&self) -> usize {
        match &self.model {
            LensModel::Real(lens) => lens.bands.len(),
            _ => 1,
        }
    }

    /// Returns whether any light can reach the part of a picture of this resolution between two
    /// points (pixels).
    pub fn sees_light(&self, low: [f64; 2], high: [f64; 2], resolution: [u32; 2]) -> bool {
        let LensModel::Real(lens) = &self.model else { return true };
        // The picture is mirrored: its left is the right of the film.
        let [left, top] = self.film_point(low, resolution);
        let [right, bottom] = self.film_point(high, resolution);
        lens.any_light([right, top], [left, bottom])
    }

    /// Returns the point of the film (mm from its middle) of a point of a picture of this resolution
    /// (pixels from its upper left corner).
    pub fn film_point(&self, at: [f64; 2], resolution: [u32; 2]) -> [f64; 2] {
        self.film_map(resolution).film_point(at)
    }

    /// Returns the map between the film and a picture of this resolution (pixels).
    pub fn film_map(&self, resolution: [u32; 2]) -> FilmMap {
        FilmMap::new(self.film, resolution)
    }

    /// Returns the distance of the film behind the camera's origin, camera units.
    pub fn film_depth(&self) -> f64 {
        match &self.model {
            LensModel::Real(lens) => {
                let front = lens.prescription.film_position(lens.film_distance) * lens.units_per_mm;
                front - lens.front_depth
            }
            _ => 0.0,
        }
    }

    /// Traces the central ray of a pixel's centre, through the middle of its pupil fan; `rays` is empty
    /// if it is blocked.
    pub fn central_ray(&self, pixel: [u32; 2], resolution: [u32; 2], rays: &mut RayBatch) {
        let mut samples = SampleBatch { len: 1, ..SampleBatch::default() };
        let film = self.film_point(pixel.map(|at| f64::from(at) + 0.5), resolution);
        (samples.film[0][0], samples.film[1][0]) = (film[0] as f32, film[1] as f32);
        // A sample of the fan, not of the rear element, at its centre.
        (samples.pupil[0][0], samples.pupil[1][0]) = (0.5, 0.0);
        let mut stats = LensStats::default();
        self.generate_rays::<f32>(&samples, &mut LensColumns::default(), rays, &mut stats);
    }

    /// Makes rays in world space from film samples, without gaps for rays that are blocked: a
    /// stage.
    pub fn generate_rays<R: Real<Scalar = f32>>(
        &self,
        samples: &SampleBatch,
        columns: &mut LensColumns,
        rays: &mut RayBatch,
        stats: &mut LensStats,
    ) {
        match &self.model {
            LensModel::Real(lens) => {
                lens.trace_samples::<R>(samples, columns, lens.fresnel, stats);
                self.write_world_rays::<R>(lens, &lens.bands[samples.band], &columns.batch, rays);
            }
            LensModel::Thin(lens) => self.project::<R>(lens, samples, rays),
            LensModel::Orthographic(projection) => {
                self.project_parallel::<R>(projection, samples, rays);
            }
            LensModel::Spherical(mapping) => self.project_sphere::<R>(*mapping, samples, rays),
        }
    }

    /// Transforms the rays that leave the lens to world space and writes them without gaps.
    pub fn write_world_rays<R: Real<Scalar = f32>>(
        &self,
        lens: &RealLens,
        band: &Band,
        batch: &LensBatch<f32>,
        rays: &mut RayBatch,
    ) {
        let place = CameraToWorld::<R>::new(self, lens.units_per_mm, lens.front_depth);
        let ratio = band.response.map(|response| R::constant(self.imaging_ratio * response));
        let len = batch.len;
        let x = batch.x.packets::<R>(len);
        let packets = x.len();
        let [y, z] = [&batch.y, &batch.z].map(|column| &column.packets::<R>(len)[..packets]);
        let [tx, ty, tz] =
            [&batch.tx, &batch.ty, &batch.tz].map(|column| &column.packets::<R>(len)[..packets]);
        let weight = &batch.weight.packets::<R>(len)[..packets];
        let mut alive = 0;
        for i in 0..packets {
            let living = R::bits(x[i].equals(x[i]));
            // Every packet is written whole, live rays first; the next packet overwrites the dead
            // ones.
            let order = lanes::pack_order(living);
            let start = [x[i].permute(order), y[i].permute(order), z[i].permute(order)];
            let towards = [tx[i].permute(order), ty[i].permute(order), tz[i].permute(order)];
            let weight = weight[i].permute(order);
            let (origin, direction, end) = place.ray(start, towards);
            let to = alive..alive + R::LANES;
            for axis in 0..3 {
                origin[axis].store(&mut rays.origin[axis][to.clone()]);
                direction[axis].store(&mut rays.direction[axis][to.clone()]);
                (weight * ratio[axis]).store(&mut rays.throughput[axis][to.clone()]);
            }
            end.store(&mut rays.t_max[to.clone()]);
            for (slot, lane) in rays.slot[to].iter_mut().zip(order) {
                *slot = (i * R::LANES) as u32 + lane;
            }
            alive += living.count_ones() as usize;
        }
        rays.len = alive;
    }
}
