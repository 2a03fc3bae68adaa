//! One sample of a picture once more, with all that happens on its way.
//!
//! It goes through the same stages as in a render, as the only one of its wave, and comes to the
//! same bits: no number depends on what else is in a wave. What stages do not keep is found by
//! witnesses, who do the same work again beside them.

use super::{Backend, Job, Share, Wave};
use crate::film::{SampleName, Tile};
use crate::lanes::{Real, f32x8};
use crate::lens::{LensColumns, Model, Passage};
use crate::rays::{Column, Hit, LandingBatch, NONE, Ray, RayBatch, SampleBatch};
use crate::scene::TraversalStack;
use crate::shade::{Account, ShadeColumns, Vertex, shade};
use crate::spectrum::sharing;
use crate::stats::{Clock, LensStats};
use glam::Vec3;

/// What happens on the way of a sample.
#[derive(Clone, Debug)]
pub struct Replay {
    /// Which.
    pub name: SampleName,
    /// Where it leaves the film, as [`SampleBatch::film`].
    pub film: [f32; 2],
    /// When, as [`SampleBatch::time`], where anything moves.
    pub time: Option<f32>,
    /// The band of the light that its ray is traced in, where the lens takes it apart.
    pub band: Option<usize>,
    /// What it counts for its pixel; negative where the filter is.
    pub weight: f32,
    /// Its way through a real lens.
    pub passage: Option<Passage>,
    /// The bands that share its ray, and what comes of them to the film; the first is its own.
    pub shared: Vec<Shared>,
    /// The ray in the world, and what it carries, if it comes so far.
    pub ray: Option<(Ray, [f32; 3])>,
    /// The surfaces that its path comes to; the last step may meet none.
    pub steps: Vec<Step>,
    /// All light that it brings.
    pub radiance: [f32; 3],
    /// What it adds to the sum of its pixel, bit for bit; `None` where it is dropped.
    pub value: Option<[f64; 3]>,
}

/// A band that shares a ray.
#[derive(Clone, Copy, Debug)]
pub struct Shared {
    /// nm.
    pub wavelength: f64,
    /// Where its light of the ray comes to the film, and what share of it the lens lets through;
    /// `None` where none of it does.
    pub landing: Option<([f32; 2], f32)>,
}

/// What happens to a path from one surface to the next.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// The ray that comes to the surface.
    pub ray: Ray,
    /// What it carries.
    pub throughput: [f32; 3],
    /// What it meets.
    pub hit: Hit,
    /// Where, and the normal of the surface itself, world space; `None` where it meets nothing.
    pub met: Option<[[f32; 3]; 2]>,
    /// The radiance that what it meets sends out by itself.
    pub emits: [f32; 3],
    /// What that adds to the radiance of the sample.
    pub shone: [f32; 3],
    /// What shading did.
    pub account: Account,
    /// The ray to a light.
    pub shadow: Option<Shadow>,
    /// The ray that goes on, what it carries, and the density of its direction, by solid angle;
    /// infinite where nothing else could have chosen it.
    pub next: Option<(Ray, [f32; 3], f32)>,
    /// The radiance of the sample so far.
    pub radiance: [f32; 3],
}

/// A ray to a light.
#[derive(Clone, Copy, Debug)]
pub struct Shadow {
    /// The ray.
    pub ray: Ray,
    /// What it adds to the radiance of the sample if it arrives.
    pub brings: [f32; 3],
    /// Whether nothing is in its way.
    pub arrives: bool,
}

/// Part of a sample's way; surfaces are counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// The ray that leaves the lens.
    Ray,
    /// What a surface, or the sky, sends out by itself.
    Emission(usize),
    /// What a light brings to a surface.
    Light(usize),
    /// The sum of the light so far.
    Sum(usize),
    /// The ray that leaves a surface.
    Next(usize),
}

impl Replay {
    /// The first part of its way where something is no finite number.
    pub fn breaks(&self) -> Option<Place> {
        let bad = |values: &[f32]| values.iter().any(|value| !value.is_finite());
        let lost =
            |ray: &Ray, carried: &[f32]| bad(&ray.origin) || bad(&ray.direction) || bad(carried);
        if self.ray.is_some_and(|(ray, carried)| lost(&ray, &carried)) {
            return Some(Place::Ray);
        }
        let step = |(i, step): (usize, &Step)| {
            let light = step.account.looked.is_some_and(|looked| bad(&looked.radiance));
            let light = light || step.shadow.is_some_and(|shadow| bad(&shadow.brings));
            let next = step.next.is_some_and(|(ray, carried, _)| lost(&ray, &carried));
            let parts = [
                (bad(&step.emits) || bad(&step.shone), Place::Emission(i)),
                (light, Place::Light(i)),
                (bad(&step.radiance), Place::Sum(i)),
                (next, Place::Next(i)),
            ];
            parts.into_iter().find_map(|(breaks, place)| breaks.then_some(place))
        };
        self.steps.iter().enumerate().find_map(step)
    }
}

/// Takes a sample of a job once more. `None` where its pixel takes none, as no light can come to
/// it. Any number of a sample will do, whether the render takes as many or not.
pub fn replay(job: &Job, backend: Backend, name: SampleName) -> Option<Replay> {
    match backend {
        Backend::Simd => follow::<f32x8>(job, name),
        Backend::Scalar => follow::<f32>(job, name),
    }
}

fn follow<R: Real<Scalar = f32>>(job: &Job, name: SampleName) -> Option<Replay> {
    let samples = name.sample..name.sample.saturating_add(1);
    let share = Share { tile: Tile { low: name.pixel(), size: [1, 1] }, samples, seed: name.seed };
    let mut sampler = job.sampler(&share.tile, share.samples.clone());
    let (mut wave, mut clock) = (Wave::new(job), Clock::start());
    if !wave.begin::<R>(job, &share, &mut sampler, &mut clock) {
        return None;
    }
    let samples = &wave.samples;
    let mut replay = Replay {
        name,
        film: samples.film.each_ref().map(|column| column[0]),
        time: job.timing.is_some().then_some(samples.time[0]),
        band: (job.camera.bands() > 1).then_some(samples.band),
        weight: if job.film.filter.signed() { samples.weight[0] } else { 1.0 },
        passage: job.camera.passage(samples),
        shared: shared(job, samples),
        ray: (wave.rays.len > 0).then(|| (wave.rays.ray(0), wave.rays.carried(0))),
        steps: Vec::new(),
        radiance: [0.0; 3],
        value: None,
    };
    let (mut witness, beam) = (Box::<Witness>::default(), job.beam());
    for depth in 0..=job.reach.max_depth {
        if wave.rays.len == 0 {
            break;
        }
        let vertex = Vertex { depth, reach: job.reach, beam };
        witness.rays.clone_from(&wave.rays);
        wave.bounce::<R>(job, vertex, None, &mut clock);
        replay.steps.push(witness.step::<R>(job, vertex, &wave));
    }
    replay.radiance = first(&wave.radiance);
    let mut sums = share.sums(job);
    sums.accumulate(&job.film, &wave.samples, &wave.radiance);
    replay.value = (sums.dropped.count() == 0).then(|| sums.light()[0]);
    Some(replay)
}

fn first(columns: &[Column<f32>; 3]) -> [f32; 3] {
    columns.each_ref().map(|column| column[0])
}

/// Where the bands that share the ray of a sample come to the film.
fn shared(job: &Job, samples: &SampleBatch) -> Vec<Shared> {
    let Model::Real(lens) = &job.camera.model else { return Vec::new() };
    let Some([hero, others @ ..]) = sharing(samples.band, lens.bands.len()) else {
        return Vec::new();
    };
    let (mut columns, mut rays) = (LensColumns::default(), Box::<RayBatch>::default());
    let blocked = vec![0; lens.prescription.rows.len()];
    let mut stats = LensStats { blocked, ..LensStats::default() };
    job.camera.expose::<f32>(samples, &mut columns, &mut rays, &mut stats);
    if rays.len == 0 {
        return Vec::new();
    }
    let mut landing = Box::<LandingBatch>::default();
    columns.passed(samples.len, &mut landing.share);
    let start = samples.film.each_ref().map(|column| column[0]);
    let wavelength = |band: usize| lens.bands[band].wavelength;
    let own = Some((start, landing.share[0]));
    let mut shared = vec![Shared { wavelength: wavelength(hero), landing: own }];
    for band in others {
        job.camera.land::<f32>(band, &mut columns, &mut landing);
        let place = landing.film.each_ref().map(|column| column[0]);
        let landing = (landing.share[0] > 0.0).then(|| (place, landing.share[0]));
        shared.push(Shared { wavelength: wavelength(band), landing });
    }
    shared
}

/// Shades a surface again, for a sample that has received nothing: so it sees what was added by
/// what.
#[derive(Default)]
struct Witness {
    rays: RayBatch,
    columns: ShadeColumns,
    radiance: [Column<f32>; 3],
    shadows: RayBatch,
    next: RayBatch,
    stack: TraversalStack,
}

impl Witness {
    /// What happened to [`Self::rays`] when the wave went on.
    fn step<R: Real<Scalar = f32>>(&mut self, job: &Job, vertex: Vertex, wave: &Wave) -> Step {
        let Self { rays, columns, radiance, shadows, next, .. } = self;
        let (scene, hits, samples) = (&job.scene, &wave.hits, &wave.samples);
        radiance.iter_mut().for_each(|column| column[0] = 0.0);
        shade::<R>(scene, vertex, rays, hits, samples, columns, radiance, shadows, next);
        let (ray, hit) = (rays.ray(0), hits[0]);
        let direction = Vec3::from(ray.direction);
        let (met, emits) = match hit.shape {
            NONE => {
                let skies = scene.lights.skies.iter();
                let skies = skies.map(|&sky| scene.sky_radiance(sky, direction));
                (None, skies.fold([0.0; 3], |sum, light| [0, 1, 2].map(|c| sum[c] + light[c])))
            }
            _ => {
                let (_, point) = scene.surface(&ray, &hit);
                let met = [point.position, point.normal].map(|v| v.to_array());
                (Some(met), scene.emitted(&ray, &hit, point.normal, -direction))
            }
        };
        let (throughput, shone) = (rays.carried(0), first(radiance));
        let account = columns.account(scene, &vertex, rays, hits);
        let on = &wave.rays;
        Step {
            ray,
            throughput,
            hit,
            met,
            emits,
            shone,
            account,
            shadow: self.shadow::<R>(job, samples),
            next: (on.len > 0).then(|| (on.ray(0), on.carried(0), on.density[0])),
            radiance: first(&wave.radiance),
        }
    }

    /// The shadow ray that is left of shading.
    fn shadow<R: Real<Scalar = f32>>(
        &mut self,
        job: &Job,
        samples: &SampleBatch,
    ) -> Option<Shadow> {
        let Self { shadows, radiance, stack, .. } = self;
        if shadows.len == 0 {
            return None;
        }
        let (ray, brings) = (shadows.ray(0), shadows.carried(0));
        radiance.iter_mut().for_each(|column| column[0] = 0.0);
        job.scene.occlude_moving::<R>(shadows, &samples.time, stack);
        job.scene.occlude::<R>(shadows, stack, radiance);
        // What brings nothing in all colours is never sent.
        Some(Shadow { ray, brings, arrives: first(radiance) != [0.0; 3] })
    }
}
