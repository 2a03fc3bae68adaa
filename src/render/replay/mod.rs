//! Replay of one sample of a picture, with a record of its path.
//!
//! The sample passes the same stages as in a render, alone in its wave. The result is the same bit for
//! bit, as no number depends on the rest of a wave. A probe repeats the work of a stage for data that
//! the stage does not keep.

mod record;

pub use record::{Collision, PathStage, PathStep, Replay, ShadowRay, SharedBand};

use super::Backend;
use super::wave::{Wave, WorkItem};
use crate::advance::{PathColumns, VertexStages};
use crate::film::{SampleId, Tile};
use crate::job::Job;
use crate::shade::{PathVertex, shade};
use glam::Vec3;
use petzval_base::lanes::{Real, f32x8};
use petzval_base::rays::{
    Column, Hit, NO_INDEX, PathFlags, RayBatch, ReprojectionBatch, SampleBatch,
};
use petzval_base::stats::{LensStats, StageClock};
use petzval_lens::{LensColumns, LensModel};
use petzval_scene::Surroundings;
use petzval_spectrum::{bands_of_ray, bands_of_set, wavelength_bands};

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
        wavelengths: job
            .spectral
            .is_some()
            .then(|| bands_of_set(samples.set).map(|band| wavelength_bands()[band].centre)),
        band: (job.camera.bands() > 1).then_some(samples.band),
        weight: if job.response.filter.is_signed() { samples.weight[0] } else { 1.0 },
        ray_path: job.camera.ray_path(samples),
        shared: shared_bands(job, samples),
        ray: (wave.paths.rays.len > 0)
            .then(|| (wave.paths.rays.ray(0), wave.paths.rays.throughput(0))),
        steps: Vec::new(),
        radiance: [0.0; 3],
        value: None,
        buckets: Vec::new(),
    };
    let (mut columns, footprint) = (PathColumns::default(), job.pixel_footprint());
    for depth in 0..=job.path_limits.max_depth {
        if wave.paths.rays.len == 0 {
            break;
        }
        let vertex = PathVertex { depth, limits: job.path_limits, footprint };
        columns.rays.clone_from(&wave.paths.rays);
        columns.clear_radiance(1);
        wave.advance::<R>(job, vertex, None, &mut clock);
        let (throughput, steps) = (columns.rays.throughput(0), &mut replay.steps);
        let mut probe = Probe { job, wave: &wave, throughput, steps };
        columns.advance::<R>(job.scene_of(&wave.samples), &wave.samples, vertex, &mut probe);
    }
    replay.radiance = first(&wave.paths.radiance);
    let mut sums = item.sums(job);
    sums.accumulate(&job.response, &wave.samples, &wave.paths.radiance);
    if sums.dropped.count() == 0 {
        replay.value = Some(sums.sums()[0]);
        replay.buckets = sums.extra_sums()[..job.extra_channels().bucket_count()].to_vec();
    }
    Some(replay)
}

fn first(columns: &[Column<f32>; 3]) -> [f32; 3] {
    columns.each_ref().map(|column| column[0])
}

/// Returns the bands that share the ray of a sample.
fn shared_bands(job: &Job, samples: &SampleBatch) -> Vec<SharedBand> {
    let LensModel::Real(lens) = &job.camera.model else { return Vec::new() };
    let mut others = bands_of_ray(samples.band, lens.bands.len());
    let Some(hero) = others.next() else { return Vec::new() };
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

/// Stages that repeat the last advance of a wave of one path, for a sample without light. This separates
/// the contributions.
struct Probe<'a> {
    job: &'a Job,
    wave: &'a Wave,
    /// Throughput before the advance.
    throughput: [f32; 3],
    steps: &'a mut Vec<PathStep>,
}

impl<R: Real<Scalar = f32>> VertexStages<R> for Probe<'_> {
    fn shade(&mut self, vertex: PathVertex, samples: &SampleBatch, paths: &mut PathColumns) {
        let PathColumns { rays, hits, shade: columns, radiance, shadows, next, .. } = paths;
        let (job, scene) = (self.job, self.job.scene_of(samples));
        let weights = job.lamp_image_weights();
        let inputs = job.shade_inputs(vertex, samples, (rays, hits), weights.as_ref());
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
        let PathColumns { rays: next_rays, radiance: sum, .. } = &self.wave.paths;
        let specular = next_rays.flags[0].contains(PathFlags::SPECULAR);
        let next_pdf = if specular { f32::INFINITY } else { next_rays.pdf[0] };
        self.steps.push(PathStep {
            ray,
            throughput: self.throughput,
            hit,
            surface,
            collision,
            emitted_radiance,
            emission: first(radiance),
            record: columns.record(&inputs),
            shadow: None,
            next: (next_rays.len > 0)
                .then(|| (next_rays.ray(0), next_rays.throughput(0), next_pdf)),
            radiance: first(sum),
        });
    }

    fn connect(&mut self, surroundings: &Surroundings, paths: &mut PathColumns) {
        let shadows = &paths.shadows;
        let shadow = (shadows.len > 0).then(|| (shadows.ray(0), shadows.throughput(0)));
        paths.clear_radiance(1);
        paths.trace_shadows::<R>(self.job.scene_of(surroundings.samples), surroundings);
        // A shadow ray without any contribution is never sent.
        let unoccluded = first(&paths.radiance) != [0.0; 3];
        if let Some(step) = self.steps.last_mut() {
            step.shadow =
                shadow.map(|(ray, contribution)| ShadowRay { ray, contribution, unoccluded });
        }
    }
}
