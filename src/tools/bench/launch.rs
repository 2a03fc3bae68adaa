//! The stages from film points to rays in the world, over all waves of a picture.

use std::hint::black_box;
use std::ops::Range;

use petzval_base::lanes::f32x8;
use petzval_base::rays::{RayBatch, SampleBatch};
use petzval_base::stats::LensStats;
use petzval_lens::{Camera, LensColumns};
use petzval_render::film::{Frame, LightSplit, TILE, Tile, TileSampler, sample};
use petzval_render::job::Job;
use petzval_render::{DisperseColumns, disperse};
use petzval_scene::filter::PixelFilter;

/// The buffers of these stages.
#[derive(Debug, Default)]
pub struct Launch {
    samples: SampleBatch,
    lens: LensColumns,
    dispersed: DisperseColumns,
    rays: RayBatch,
    /// Counts over all runs.
    pub stats: LensStats,
}

impl Launch {
    /// Runs all waves of a job, with the bands that share rays. Returns how many rays left the
    /// lens.
    pub fn job(&mut self, job: &Job) -> u64 {
        let dispersed = &mut self.dispersed;
        waves(
            (&mut self.samples, &mut self.lens, &mut self.rays, &mut self.stats),
            &job.camera,
            (&job.frame, &job.response.filter),
            |tile| job.sampler(tile, job.samples.clone()),
            |samples, lens, rays| disperse::<f32x8>(job, samples, lens, dispersed, rays),
        )
    }

    /// Runs all waves of a picture that a camera takes through the default filter, light of all
    /// bands together. Returns how many rays left the lens.
    pub fn camera(&mut self, camera: &Camera, frame: &Frame, samples: Range<u32>) -> u64 {
        let sees = |low: [u32; 2], high: [u32; 2]| {
            camera.sees_light(low.map(f64::from), high.map(f64::from), frame.resolution)
        };
        waves(
            (&mut self.samples, &mut self.lens, &mut self.rays, &mut self.stats),
            camera,
            (frame, &PixelFilter::default()),
            |tile| TileSampler::new(tile, samples.clone(), LightSplit::NONE, sees),
            |_, _, _| {},
        )
    }
}

type Buffers<'a> = (&'a mut SampleBatch, &'a mut LensColumns, &'a mut RayBatch, &'a mut LensStats);

fn waves(
    (samples, lens, rays, stats): Buffers,
    camera: &Camera,
    (frame, filter): (&Frame, &PixelFilter),
    sampler: impl Fn(&Tile) -> TileSampler,
    mut after: impl FnMut(&SampleBatch, &mut LensColumns, &mut RayBatch),
) -> u64 {
    let mut left = 0;
    for tile in frame.tiles(TILE) {
        let mut tile = sampler(&tile);
        while sample(&mut tile, frame, filter, camera.film, 0, samples) {
            camera.generate_rays::<f32x8>(samples, lens, black_box(rays), stats);
            after(samples, lens, rays);
            left += rays.len as u64;
        }
    }
    black_box(rays);
    left
}
