//! Wave of light paths.

use glam::DVec3;

use super::LightPathInput;
use super::numbers::WaveNumbers;
use crate::timing::ArrivalTime;
use petzval_base::lanes::Real;
use petzval_base::rays::{Column, LensBatch, Ray, RayBatch, SampleBatch, WAVE_SIZE};
use petzval_lens::{RealLens, Surface, trace_ghost};
use petzval_scene::{MediumColumns, Surroundings, TraversalStack, luminance};

/// A light path that arrives on the film.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FilmArrival {
    /// Position on the film, relative to its width and height: 0 to 1.
    pub position: [f64; 2],
    /// Flux as luminance.
    pub luminance: f64,
    /// Entry point in the square about the front surface, 0 to 1.
    pub entry: [f32; 2],
}

/// The start of a light path.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightPath {
    /// Point at which its ray enters the lens (mm, the frame of its first surface).
    pub start: [f64; 3],
    /// Unit vector to the light in the frame of the camera.
    pub towards: DVec3,
    /// Ray in the world that nothing must occlude: between the light and the lens, where it starts if
    /// there are media.
    pub shadow: Ray,
    /// Time of its arrival.
    pub time: ArrivalTime,
    /// Key and number of its random numbers.
    pub sample: [u32; 2],
}

/// Where a light path meets the film.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FilmHit {
    /// Point on the film (mm).
    pub point: [f64; 2],
    /// Direction to the lens, of any length: x, y, and z towards the scene.
    pub towards: [f64; 3],
    /// Share of the light that the surfaces let through.
    pub transmission: f64,
}

/// A wave of light paths: from lights to the front surface, and through the lens to the film.
#[derive(Clone, Debug, Default)]
pub(crate) struct LightPaths {
    /// Random numbers of the paths that may start.
    pub numbers: WaveNumbers,
    /// Rays at the front surface.
    start: LensBatch<f32>,
    /// Rays behind the rear surface.
    batch: LensBatch<f32>,
    /// Rays from the front surface back to the light, each with its flux: radiance times mm^2 sr,
    /// over the density of the samples.
    rays: RayBatch,
    /// Entry points in the square about the front surface, 0 to 1.
    entry: Vec<[f32; 2]>,
    /// Time of each path.
    arrival_times: Vec<ArrivalTime>,
    /// Random numbers of each path, and its time in the scene.
    samples: SampleBatch,
    shadow_rays: RayBatch,
    stack: TraversalStack,
    unoccluded_flux: [Column<f32>; 3],
    /// Columns for scenes with media.
    media: Option<Box<MediumColumns>>,
    /// A sink: blocked rays are counted only on the way from the film.
    blocked: Vec<u64>,
}

impl LightPaths {
    /// Forgets all paths.
    pub fn clear(&mut self) {
        self.entry.clear();
        self.arrival_times.clear();
        self.rays.len = 0;
    }

    /// Adds a path with its flux and its entry point (0 to 1). There must be room for it.
    pub fn push(&mut self, path: &LightPath, flux: [f32; 3], entry: [f32; 2]) {
        let LightPath { start, towards, shadow, time, sample } = path;
        let k = self.rays.len;
        [self.start.x[k], self.start.y[k], self.start.z[k]] = start.map(|v| v as f32);
        [self.start.tx[k], self.start.ty[k], self.start.tz[k]] =
            [-towards.x, -towards.y, towards.z].map(|v| v as f32);
        self.start.weight[k] = 1.0;
        self.rays.push(*shadow, flux, k as u32);
        self.entry.push(entry);
        self.arrival_times.push(*time);
        self.samples.time[k] = time.scene;
        [self.samples.key[k], self.samples.sample[k]] = *sample;
    }

    /// Returns the time at which a path arrives.
    pub fn arrival_time(&self, i: usize) -> ArrivalTime {
        self.arrival_times[i]
    }

    /// Returns the entry point of a path, 0 to 1.
    pub fn entry(&self, i: usize) -> [f32; 2] {
        self.entry[i]
    }

    /// Returns the ray of a path that nothing must occlude.
    pub fn shadow_ray(&self, i: usize) -> Ray {
        self.rays.ray(i)
    }

    /// Returns the number of light paths.
    pub fn len(&self) -> usize {
        self.rays.len
    }

    /// Returns the paths of the last trace and the last connection that arrive on a film of this
    /// size (mm).
    pub fn arrivals(&self, film: [f64; 2]) -> impl Iterator<Item = FilmArrival> {
        (0..self.rays.len).filter_map(move |i| {
            let position =
                [f64::from(self.batch.x[i]) / film[0], f64::from(self.batch.y[i]) / film[1]];
            let position = position.map(|share| share + 0.5);
            let luminance = f64::from(luminance(self.flux(i)) * self.batch.weight[i]);
            let inside = position.iter().all(|place| (0.0..1.0).contains(place));
            inside.then_some(FilmArrival { position, luminance, entry: self.entry[i] })
        })
    }

    /// Traces the wave from the front surface through a sequence of surfaces to the film
    /// ([`Self::film_hit`]). Returns whether any path arrives.
    pub fn trace<R: Real<Scalar = f32>>(
        &mut self,
        lens: &RealLens,
        surfaces: &[Surface<f32>],
    ) -> bool {
        let mut arrives = false;
        self.trace_with::<R>(lens, |batch, _, _| arrives = trace_ghost::<R>(batch, surfaces) > 0);
        arrives
    }

    /// Traces the wave to the film ([`Self::film_hit`]). `trace` takes the rays to the last vertex;
    /// it gets them, their starts, and a count of blocked rays by row.
    pub fn trace_with<R: Real<Scalar = f32>>(
        &mut self,
        lens: &RealLens,
        trace: impl FnOnce(&mut LensBatch<f32>, &LensBatch<f32>, &mut Vec<u64>),
    ) {
        self.batch.clone_from(&self.start);
        self.batch.resize::<R>(self.rays.len);
        self.blocked.resize(lens.prescription.rows.len(), 0);
        trace(&mut self.batch, &self.start, &mut self.blocked);
        let batch = &mut self.batch;
        if !lens.film_pose.is_aligned() {
            for i in 0..batch.len {
                let of = |v: [f32; 3]| v.map(f64::from);
                let p = of([batch.x[i], batch.y[i], batch.z[i]]);
                let t = of([batch.tx[i], batch.ty[i], batch.tz[i]]);
                [batch.x[i], batch.y[i]] = lens.film_intersection(p, t).map(|v| v as f32);
            }
            return;
        }
        let distance = lens.film_distance as f32;
        for i in 0..batch.len {
            let s = (distance - batch.z[i]) / batch.tz[i];
            batch.x[i] += s * batch.tx[i];
            batch.y[i] += s * batch.ty[i];
        }
    }

    /// Returns where a path meets the film; `None` if it does not.
    pub fn film_hit(&self, i: usize) -> Option<FilmHit> {
        let hits = &self.batch;
        let [tx, ty, tz] = [-hits.tx[i], -hits.ty[i], hits.tz[i]].map(f64::from);
        hits.x[i].is_finite().then(|| FilmHit {
            point: [hits.x[i], hits.y[i]].map(f64::from),
            towards: [tx, ty, tz],
            transmission: f64::from(hits.weight[i]),
        })
    }

    /// Tests which of these paths are unoccluded in the scene, and how much light its media let through.
    /// A path may occur several times.
    pub fn connect<R: Real<Scalar = f32>>(
        &mut self,
        input: &LightPathInput<'_>,
        paths: impl Iterator<Item = u32>,
    ) {
        self.shadow_rays.len = 0;
        let mut asked = [false; WAVE_SIZE];
        for path in paths {
            asked[path as usize] = true;
        }
        for (i, _) in asked.iter().enumerate().filter(|(_, asked)| **asked) {
            self.unoccluded_flux.iter_mut().for_each(|column| column[i] = 0.0);
            self.shadow_rays.push(self.shadow_ray(i), self.rays.throughput(i), i as u32);
        }
        let Self { shadow_rays, samples, stack, unoccluded_flux, media, .. } = self;
        // The depth is that of shadow rays from the lens.
        let surroundings = Surroundings::of(input.scene, samples, 0, 1);
        match surroundings.media {
            false => {
                let (rays, flux) = (shadow_rays, unoccluded_flux);
                input.scene.receive_in_vacuum::<R>(&surroundings, rays, flux, stack);
            }
            true => {
                let (rays, flux) = (shadow_rays, unoccluded_flux);
                let (len, media) = (rays.len, media.get_or_insert_default());
                rays.medium[..len].fill(input.scene.camera_medium);
                input.scene.receive::<R>(&surroundings, rays, flux, media, stack);
            }
        }
    }

    /// Returns the flux of a path that was passed to [`Self::connect`]; 0 if it is in shadow.
    pub fn flux(&self, i: usize) -> [f32; 3] {
        [0, 1, 2].map(|c| self.unoccluded_flux[c][i])
    }

    /// Discards a path.
    pub fn discard(&mut self, i: usize) {
        self.start.x[i] = f32::NAN;
    }
}
