//! Features: properties of the first surfaces on the paths of a pixel.
//!
//! Every path is weighted by the light that the lens transmits along it, so that vignetting does
//! not bias the means.

use std::io;
use std::sync::Arc;

use glam::{Affine3A, DVec3, Vec3};

use super::circle_of_confusion::CircleOfConfusion;
use super::feature_film::FeatureSums;
use super::motion_vectors::{MotionVectors, SeenPoint};
use super::{Aov, LayerRequest};
use crate::film::Tile;
use crate::shade::{PixelFootprint, albedo};
use petzval_base::io::codec::{ChecksumReader, ChecksumWriter};
use petzval_base::rays::{Hit, HitBatch, NO_INDEX, Ray, RayBatch, SampleBatch};
use petzval_scene::motion::Motion;
use petzval_scene::{PlacedShape, Scene};

/// Accumulates the features of a tile.
#[derive(Clone, Debug)]
pub struct TileFeatures {
    pub(super) sums: FeatureSums,
    camera_from_world: Affine3A,
    camera_motion: Option<Motion>,
    confusion: Option<CircleOfConfusion>,
    motion: Option<TileMotion>,
    footprint: PixelFootprint,
}

impl TileFeatures {
    /// Returns whether any requested layer needs features.
    pub fn are_needed(request: &LayerRequest<'_>) -> bool {
        request
            .layers
            .iter()
            .any(|aov| !matches!(aov, Aov::Vignetting | Aov::Variance | Aov::DualPixel))
    }

    /// Returns empty sums for a tile; `None` if no requested layer needs them.
    pub fn new(request: &LayerRequest<'_>, tile: &Tile) -> Option<Self> {
        Self::are_needed(request).then(|| Self {
            sums: FeatureSums::new(request, (tile.size[0] * tile.size[1]) as usize),
            camera_from_world: rounded(&request.camera.world_from_camera.inverse()),
            camera_motion: request.timing.and_then(|timing| timing.camera_motion.clone()),
            confusion: CircleOfConfusion::new(request.camera),
            motion: request.motion_vectors.map(|vectors| TileMotion {
                vectors: Arc::clone(vectors),
                tile: *tile,
                stopped: request.timing.is_none(),
            }),
            footprint: PixelFootprint::new(request.camera, request.frame.resolution),
        })
    }

    pub(crate) fn save(&self, to: &mut ChecksumWriter) -> io::Result<()> {
        self.sums.save(to)
    }

    /// Adds the saved features of later paths of the same tile.
    pub(crate) fn receive(&mut self, from: &mut ChecksumReader) -> io::Result<()> {
        self.sums.receive(from)
    }

    /// Adds the features of later paths of the same tile.
    pub fn add(&mut self, other: &Self) {
        self.sums.add(&other.sums);
    }

    /// Adds the weights of the paths of a wave as they leave the lens, before media change them: a
    /// stage.
    pub fn launch(&mut self, rays: &RayBatch, samples: &SampleBatch) {
        for i in 0..rays.len {
            let weight = weight(rays, i);
            if weight.is_finite() {
                self.sums.pixels[samples.pixel[rays.slot[i] as usize] as usize].beyond[0] += weight;
            }
        }
    }

    /// Adds the first hits of a wave: a stage.
    pub fn record(
        &mut self,
        scene: &Scene,
        rays: &RayBatch,
        hits: &HitBatch,
        samples: &SampleBatch,
    ) {
        for i in 0..samples.len {
            self.sums.pixels[samples.pixel[i] as usize].taken += 1;
        }
        for i in 0..rays.len {
            let slot = rays.slot[i] as usize;
            let pixel = samples.pixel[slot] as usize;
            let sum = &mut self.sums.pixels[pixel];
            let (ray, hit) = (rays.ray(i), hits[i]);
            let weight = weight(rays, i);
            sum.passed += 1;
            // An absorbed path brings no light, whatever it brought before.
            if !weight.is_finite() || hit == Hit::ABSORBED {
                continue;
            }
            sum.weight[0] += weight;
            if let Some(moving) = &self.motion
                && let Some(vector) = moving.vector(&ray, &hit, samples.time[slot], pixel)
            {
                sum.add_motion(weight, vector, hit.shape == NO_INDEX);
            }
            let (motion, time) = (self.camera_motion.as_ref(), samples.time[slot]);
            let depth_of = |point| {
                let position = position_at_rest(motion, point, time);
                f64::from(self.camera_from_world.transform_point3(position).z)
            };
            let film = [0, 1].map(|axis| f64::from(samples.film[axis][slot]));
            let circle =
                |depth| self.confusion.map_or(0.0, |confusion| confusion.diameter(depth, film));
            if matches!(hit.shape, NO_INDEX | Hit::IN_MEDIUM) {
                sum.ids.get_or_insert([0; 3]);
                if hit.shape == NO_INDEX {
                    sum.beyond[1] += weight;
                    sum.add_circle(weight, circle(f64::INFINITY));
                } else {
                    let along = Vec3::from(ray.direction) * hit.t;
                    sum.add_circle(weight, circle(depth_of(Vec3::from(ray.origin) + along)));
                }
                continue;
            }
            if let Some(coverage) = self.sums.coverage.get_mut(pixel) {
                coverage.add(PlacedShape { shape: hit.shape, instance: hit.instance }, weight);
            }
            let (shape, point) = scene.surface(&ray, &hit);
            sum.ids.get_or_insert([
                hit.shape + 1,
                hit.instance.wrapping_add(1),
                shape.material + 1,
            ]);
            let depth = depth_of(point.position);
            sum.add_circle(weight, circle(depth));
            let toward = -Vec3::from(ray.direction);
            let normal = point.shading_normal * point.shading_normal.dot(toward).signum();
            let colour = albedo(scene, &self.footprint, ray, hit);
            let vectors = [point.position.to_array(), normal.to_array(), colour];
            let all = vectors.as_flattened().iter().copied().map(f64::from);
            // A single NaN or infinity would spoil the sums.
            if !all.chain([depth]).all(f64::is_finite) {
                continue;
            }
            sum.weight[1] += weight;
            sum.depth += weight * depth;
            for axis in 0..3 {
                sum.position[axis] += weight * f64::from(point.position[axis]);
                sum.normal[axis] += weight * f64::from(normal[axis]);
                sum.albedo[axis] += weight * f64::from(colour[axis]);
            }
        }
    }
}

/// Motion of what the pixels of a tile see.
#[derive(Clone, Debug)]
struct TileMotion {
    vectors: Arc<MotionVectors>,
    tile: Tile,
    /// Whether the scene stands still while it is seen.
    stopped: bool,
}

impl TileMotion {
    /// Returns the motion across the picture of what a path meets.
    fn vector(&self, ray: &Ray, hit: &Hit, time: f32, pixel: usize) -> Option<[f64; 2]> {
        let [origin, direction] =
            [ray.origin, ray.direction].map(|v| DVec3::from(v.map(f64::from)));
        let along = || origin + direction * f64::from(hit.t);
        let seen = match hit.shape {
            NO_INDEX => SeenPoint::Direction(direction),
            Hit::IN_MEDIUM => SeenPoint::Space(along()),
            _ => SeenPoint::Surface(along(), hit.instance),
        };
        let time = (!self.stopped).then_some(time);
        self.vectors.vector(seen, time, self.tile.pixel(pixel as u32))
    }
}

/// Returns the weight of a ray in the means: the light that the lens transmits along it.
fn weight(rays: &RayBatch, i: usize) -> f64 {
    rays.throughput(i).into_iter().map(f64::from).sum::<f64>() / 3.0
}

/// Returns the position at which a camera at rest would see a point that the moving camera sees at
/// a time.
fn position_at_rest(motion: Option<&Motion>, position: Vec3, time: f32) -> Vec3 {
    motion.map_or(position, |motion| {
        motion.at(f64::from(time)).inverse().transform_point3(position.as_dvec3()).as_vec3()
    })
}

fn rounded(matrix: &glam::DAffine3) -> Affine3A {
    Affine3A::from_cols_array(&matrix.to_cols_array().map(|v| v as f32))
}
