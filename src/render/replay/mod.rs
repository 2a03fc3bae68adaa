//! Replay of one sample of a picture, with a record of its path.
//!
//! The sample passes the same stages as in a render, alone in its wave. The result is the same bit for
//! bit, as no number depends on the rest of a wave. A probe repeats the work of a stage for data that
//! the stage does not keep.

mod record;

pub use record::{Collision, PathStage, PathStep, Replay, ShadowRay, SharedBand};

use super::Backend;
use super::wave::{Wave, WorkItem};
use crate::film::{SampleId, Tile};
use crate::job::Job;
use crate::shade::{PathVertex, ShadeColumns, ShadeInputs, shade};
use glam::Vec3;
use petzval_base::lanes::{Real, f32x8};
use petzval_base::rays::{
    Column, Hit, HitBatch, NO_INDEX, PathFlags, RayBatch, ReprojectionBatch, SampleBatch,
};
use petzval_base::stats::{LensStats, StageClock};
use petzval_lens::{LensColumns, LensModel};
use petzval_scene::{MediumColumns, Surroundings, TraversalStack};
use petzval_spectrum::bands_of_ray;

/// Replays a sample of a job. Returns `None` if no light reaches its pixel. The sample number may exceed
/// those of the job.
pub fn replay(job: &Job, backend: Backend, name: SampleId) -> Option<Replay> {
    match backend {
        Backend::Simd => replay_with::<f32x8>(job, name),
        Backend::Scalar => replay_with::<f32>(job, name),
    }
}

fn replay_with<R: Real<Scalar = f32>>(job: &Job, name: SampleId) -> Option<Replay> {
    let samples = name.sample..name.sample.saturating_add(1);
    let item =
        WorkItem { tile: Tile { low: name.pixel(), size: [1, 1] }, samples, seed: name.seed };
    let mut sampler = job.sampler(&item.tile, item.samples.clone());
    let (mut wave, mut clock) = (Wave::new(job), StageClock::start());
    if !wave.start_paths::<R>(job, &item, &mut sampler, &mut clock) {
        return None;
    }
    let samples = &wave.samples;
    let mut replay = Replay {
        name,
        film: samples.film.each_ref().map(|column| column[0]),
        time: job.timing.is_some().then_some(samples.time[0]),
        band: (job.camera.bands() > 1).then_some(samples.band),
        weight: if job.response.filter.is_signed() { samples.weight[0] } else { 1.0 },
        ray_path: job.camera.ray_path(samples),
        shared: shared_bands(job, samples),
        ray: (wave.rays.len > 0).then(|| (wave.rays.ray(0), wave.rays.throughput(0))),
        steps: Vec::new(),
        radiance: [0.0; 3],
        value: None,
    };
    let (mut probe, footprint) = (Box::<Probe>::default(), job.pixel_footprint());
    for depth in 0..=job.path_limits.max_depth {
        if wave.rays.len == 0 {
            break;
        }
        let vertex = PathVertex { depth, limits: job.path_limits, footprint };
        probe.rays.clone_from(&wave.rays);
        wave.bounce::<R>(job, vertex, None, &mut clock);
        replay.steps.push(probe.step::<R>(job, vertex, &wave));
    }
    replay.radiance = first(&wave.radiance);
    let mut sums = item.sums(job);
    sums.accumulate(&job.response, &wave.samples, &wave.radiance);
    replay.value = (sums.dropped.count() == 0).then(|| sums.sums()[0]);
    Some(replay)
}

fn first(columns: &[Column<f32>; 3]) -> [f32; 3] {
    columns.each_ref().map(|column| column[0])
}

/// Returns the bands that share the ray of a sample.
fn shared_bands(job: &Job, samples: &SampleBatch) -> Vec<SharedBand> {
    let LensModel::Real(lens) = &job.camera.model else { return Vec::new() };
    let Some([hero, others @ ..]) = bands_of_ray(samples.band, lens.bands.len()) else {
        return Vec::new();
    };
    let (mut columns, mut rays) = (LensColumns::default(), Box::<RayBatch>::default());
    let mut stats = LensStats::default();
    job.camera.generate_rays::<f32>(samples, &mut columns, &mut rays, &mut stats);
    if rays.len == 0 {
        return Vec::new();
    }
    let mut landing = Box::<ReprojectionBatch>::default();
    columns.passed(samples.len, &mut landing.transmission);
    let start = samples.film.each_ref().map(|column| column[0]);
    let wavelength = |band: usize| lens.bands[band].wavelength;
    let own = Some((start, landing.transmission[0]));
    let mut shared = vec![SharedBand { wavelength: wavelength(hero), reprojection: own }];
    for band in others {
        job.camera.reproject::<f32>(band, &mut columns, &mut landing);
        let place = landing.film.each_ref().map(|column| column[0]);
        let landing = (landing.transmission[0] > 0.0).then(|| (place, landing.transmission[0]));
        shared.push(SharedBand { wavelength: wavelength(band), reprojection: landing });
    }
    shared
}

/// Shades a surface again for a sample without light, which separates the contributions.
#[derive(Default)]
struct Probe {
    rays: Box<RayBatch>,
    columns: Box<ShadeColumns>,
    radiance: [Column<f32>; 3],
    shadows: Box<RayBatch>,
    next: Box<RayBatch>,
    hits: HitBatch,
    media: Box<MediumColumns>,
    stack: TraversalStack,
}

impl Probe {
    /// Returns the step by which the wave has followed [`Self::rays`].
    fn step<R: Real<Scalar = f32>>(
        &mut self,
        job: &Job,
        vertex: PathVertex,
        wave: &Wave,
    ) -> PathStep {
        let Self { rays, columns, radiance, shadows, next, hits, media, stack } = self;
        let (scene, samples) = (&job.scene, &wave.samples);
        radiance.iter_mut().for_each(|column| column[0] = 0.0);
        let start = rays.throughput(0);
        let surroundings = Surroundings::of(scene, samples, vertex.depth, vertex.limits.max_depth);
        scene.intersect_all::<R>(&surroundings, rays, hits, stack);
        if surroundings.media {
            scene.travel::<R>(&surroundings, rays, hits, radiance, media, stack);
        }
        let weights = job.lamp_image_weights();
        let lamp_weights = weights.as_ref().map(|weights| weights as _);
        let caustics = job.caustics.is_some();
        let hides_sky = job.hides_sky();
        let inputs = ShadeInputs { scene, vertex, rays, hits, lamp_weights, caustics, hides_sky };
        shade::<R>(&inputs, samples, columns, radiance, shadows, next);
        let (ray, hit) = (rays.ray(0), hits[0]);
        let collision = (hit.shape == Hit::IN_MEDIUM && hit != Hit::ABSORBED).then(|| Collision {
            medium: hit.primitive,
            at: (Vec3::from(ray.origin) + hit.t * Vec3::from(ray.direction)).into(),
        });
        let (origin, direction) = (Vec3::from(ray.origin), Vec3::from(ray.direction));
        let (surface, emitted_radiance) = match hit.shape {
            NO_INDEX => {
                let skies = scene.lights.skies.iter();
                let skies = skies.map(|&sky| scene.sky_radiance(sky, origin, direction));
                (None, skies.fold([0.0; 3], |sum, light| [0, 1, 2].map(|c| sum[c] + light[c])))
            }
            Hit::IN_MEDIUM => (None, [0.0; 3]),
            _ => {
                let (_, point) = scene.surface(&ray, &hit);
                let surface = [point.position, point.normal].map(|v| v.to_array());
                (Some(surface), scene.emitted_radiance(&ray, &hit, point.normal, -direction))
            }
        };
        let (throughput, emission) = (start, first(radiance));
        let record = columns.record(&inputs);
        let next_rays = &wave.rays;
        let specular = next_rays.flags[0].contains(PathFlags::SPECULAR);
        let next_pdf = if specular { f32::INFINITY } else { next_rays.pdf[0] };
        PathStep {
            ray,
            throughput,
            hit,
            surface,
            collision,
            emitted_radiance,
            emission,
            record,
            shadow: self.shadow::<R>(job, &surroundings),
            next: (next_rays.len > 0)
                .then(|| (next_rays.ray(0), next_rays.throughput(0), next_pdf)),
            radiance: first(&wave.radiance),
        }
    }

    /// Returns the shadow ray that shading has left.
    fn shadow<R: Real<Scalar = f32>>(
        &mut self,
        job: &Job,
        surroundings: &Surroundings,
    ) -> Option<ShadowRay> {
        let Self { shadows, radiance, media, stack, .. } = self;
        if shadows.len == 0 {
            return None;
        }
        let (ray, contribution) = (shadows.ray(0), shadows.throughput(0));
        radiance.iter_mut().for_each(|column| column[0] = 0.0);
        job.scene.receive::<R>(surroundings, shadows, radiance, media, stack);
        // A shadow ray without any contribution is never sent.
        Some(ShadowRay { ray, contribution, unoccluded: first(radiance) != [0.0; 3] })
    }
}
