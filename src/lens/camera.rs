//! A camera: a lens model, a film behind it, and a place in the world.

use glam::{DAffine3, DVec3};

use super::aim::{RingColumns, aim};
use super::paraxial::Paraxial;
use super::prescription::Prescription;
use super::pupil::{Aim, PupilBound};
use super::surface::{From, Surface, sequence};
use super::trace::trace;
use crate::lanes::Real;
use crate::rays::{Column, LensBatch, Ray, RayBatch, SampleBatch};
use crate::sampler::disk;

/// What makes rays of film samples.
#[derive(Clone, Debug)]
pub struct Camera {
    /// How light gets from the scene to the film.
    pub model: Model,
    /// Width and height of the film: mm behind a real lens, of the plane z = 1 for a thin one.
    pub film: [f64; 2],
    /// Camera space (+z to the scene) to world space.
    pub world_from_camera: DAffine3,
    /// What a weight of 1 adds to a pixel: exposure time x ISO / 100.
    pub imaging_ratio: f64,
    /// Nearest and farthest depth that is seen, camera units.
    pub depth: [f64; 2],
}

/// A model of the lens.
#[derive(Clone, Debug)]
pub enum Model {
    /// Every surface of a real lens.
    Real(Box<RealLens>),
    /// A point, or a disk that focuses perfectly on one plane.
    Thin(ThinLens),
}

/// A real lens and the film behind it.
#[derive(Clone, Debug)]
pub struct RealLens {
    /// The lens as its designer wrote it down, the stop closed as asked.
    pub prescription: Prescription,
    /// Its first-order data.
    pub paraxial: Paraxial,
    /// The f-number of a traced marginal ray.
    pub f_number: f64,
    /// Rear vertex to film, mm.
    pub film_distance: f64,
    /// Camera units in a millimetre.
    pub unit: f64,
    /// Depth of the front vertex in camera space, camera units.
    pub front: f64,
    surfaces: Vec<Surface<f32>>,
    bound: PupilBound,
}

impl RealLens {
    /// A lens ready to trace, with a film of this half diagonal, mm, at this distance behind
    /// the rear vertex.
    pub fn new(
        prescription: Prescription,
        film_distance: f64,
        half_diagonal: f64,
        aiming: Aim,
        unit: f64,
        front: f64,
    ) -> Self {
        let paraxial = Paraxial::of(&prescription);
        Self {
            f_number: super::paraxial::f_number(&prescription, paraxial.focal_length),
            surfaces: sequence::<f32>(&prescription, From::Film(film_distance)),
            bound: PupilBound::new(&prescription, film_distance, half_diagonal, aiming),
            prescription,
            paraxial,
            film_distance,
            unit,
            front,
        }
    }

    /// How many surfaces a ray crosses, the stop among them.
    pub fn surfaces(&self) -> usize {
        self.surfaces.len()
    }
}

/// The lens of textbooks: one plane, no aberration, no vignetting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinLens {
    /// Radius of its disk, camera units; 0 for a pinhole.
    pub radius: f64,
    /// Depth of the plane in focus, camera units.
    pub focus: f64,
}

/// The columns that the lens stage works in.
#[derive(Clone, Debug, Default)]
pub struct LensColumns {
    batch: LensBatch<f32>,
    rings: RingColumns,
    weight: Column<f32>,
}

impl Camera {
    /// Half the diagonal of the film.
    pub fn half_diagonal(&self) -> f64 {
        self.film[0].hypot(self.film[1]) / 2.0
    }

    /// Whether any light can come to a pixel of a picture of this resolution.
    pub fn sees(&self, pixel: [u32; 2], resolution: [u32; 2]) -> bool {
        let Model::Real(lens) = &self.model else { return true };
        // Nearest and farthest point of the pixel from the axis, by axis.
        let reach = [0, 1].map(|i| {
            let pitch = self.film[i] / f64::from(resolution[i]);
            let low = f64::from(pixel[i]) * pitch - self.film[i] / 2.0;
            let (low, high) = (low.min(low + pitch), low.max(low + pitch));
            [low.max(-high).max(0.0), high.max(-low)]
        });
        let radius = |i: usize| reach[0][i].hypot(reach[1][i]) as f32;
        lens.bound.any_open(radius(0), radius(1))
    }

    /// From film samples to rays in world space, as many as leave the lens: a stage.
    ///
    /// `blocked[i]` grows by the rays that end at the i-th surface on their way out.
    pub fn expose<R: Real<Scalar = f32>>(
        &self,
        samples: &SampleBatch,
        columns: &mut LensColumns,
        rays: &mut RayBatch,
        blocked: &mut [u64],
    ) {
        match &self.model {
            Model::Real(lens) => {
                let LensColumns { batch, rings, weight } = columns;
                let film_index = lens.prescription.rear().index as f32;
                let distance = lens.film_distance as f32;
                aim::<R>(samples, &lens.bound, distance, film_index, rings, weight, batch);
                trace::<R>(batch, &lens.surfaces, blocked);
                self.emerge(lens, batch, weight, rays);
            }
            Model::Thin(lens) => self.project(*lens, samples, rays),
        }
    }

    /// Moves the rays that came out into world space, without gaps.
    fn emerge(
        &self,
        lens: &RealLens,
        batch: &LensBatch<f32>,
        weight: &Column<f32>,
        rays: &mut RayBatch,
    ) {
        let place = self.placement(lens.unit, DVec3::new(0.0, 0.0, lens.front));
        let ratio = self.imaging_ratio as f32;
        rays.len = 0;
        for i in 0..batch.len {
            if batch.x[i].is_nan() {
                continue;
            }
            let origin = [batch.x[i], batch.y[i], batch.z[i]];
            let direction = [batch.tx[i], batch.ty[i], batch.tz[i]];
            rays.push(place.ray(origin, direction), [weight[i] * ratio; 3], i as u32);
        }
    }

    /// The rays of a thin lens or pinhole.
    fn project(&self, lens: ThinLens, samples: &SampleBatch, rays: &mut RayBatch) {
        let place = self.placement(1.0, DVec3::ZERO);
        let ratio = self.imaging_ratio as f32;
        let (radius, focus) = (lens.radius as f32, lens.focus as f32);
        rays.len = 0;
        for i in 0..samples.len {
            // The film point's picture lies mirrored in the plane z = 1.
            let seen = [-samples.film[0][i], -samples.film[1][i]];
            let (origin, direction) = if radius > 0.0 {
                let [x, y] = disk(samples.pupil[0][i], samples.pupil[1][i]).map(|d| d * radius);
                let to = [seen[0] * focus - x, seen[1] * focus - y, focus];
                ([x, y, 0.0], to)
            } else {
                ([0.0; 3], [seen[0], seen[1], 1.0])
            };
            rays.push(place.ray(origin, direction), [ratio; 3], i as u32);
        }
    }

    fn placement(&self, unit: f64, offset: DVec3) -> Placement {
        let world = self.world_from_camera;
        let depth = self.depth;
        Placement {
            linear: world.matrix3.to_cols_array_2d().map(|column| column.map(|v| v as f32)),
            unit: unit as f32,
            origin: world.transform_point3(offset).to_array().map(|v| v as f32),
            near: depth[0] as f32,
            far: depth[1] as f32,
            clips: depth[0] > 0.0 || depth[1] < f64::from(f32::MAX),
        }
    }
}

/// Takes local rays to the world: small offsets and directions first, the place last, so
/// that nothing is lost far from the world's origin.
struct Placement {
    linear: [[f32; 3]; 3],
    unit: f32,
    origin: [f32; 3],
    near: f32,
    far: f32,
    clips: bool,
}

impl Placement {
    #[inline(always)]
    fn ray(&self, origin: [f32; 3], direction: [f32; 3]) -> Ray {
        let mut start = origin.map(|v| v * self.unit);
        let mut t_max = f32::INFINITY;
        if self.clips {
            let per_depth = 1.0 / direction[2];
            let near = self.near * per_depth;
            start = [0, 1, 2].map(|i| start[i] + near * direction[i]);
            t_max = (self.far - self.near) * per_depth;
        }
        let offset = self.turn(start);
        let direction = self.turn(direction);
        let length = direction.iter().map(|d| d * d).sum::<f32>().sqrt();
        Ray {
            origin: [0, 1, 2].map(|i| self.origin[i] + offset[i]),
            direction: direction.map(|d| d / length),
            t_max: t_max * length,
        }
    }

    #[inline(always)]
    fn turn(&self, v: [f32; 3]) -> [f32; 3] {
        let [x, y, z] = &self.linear;
        [0, 1, 2].map(|i| x[i] * v[0] + y[i] * v[1] + z[i] * v[2])
    }
}
