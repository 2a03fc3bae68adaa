//! How bright a picture will be and what it takes, by a small one.

use super::JobError;
use crate::film::Frame;
use crate::ghosts;
use crate::plan::Level;
use crate::render::{Backend, Exposed, Job, Progress, render};
use crate::scene::{Scene, luminance};
use crate::stats::Stage;

/// The longer side of the small picture, pixels, and its samples a pixel.
const SIDE: f64 = 40.0;
const SAMPLES: u32 = 16;

/// The mean without the brightest tenth is at least this share of the whole mean: the black of a
/// display, of its white. Nothing here depends on the unit of light.
const BLACK: f64 = 1e-3;

/// What a film sample takes before its path, ns of one core.
const LENS: f64 = 40.0;
/// A step down the tree, of which there are as many as its bytes have digits; nearest hits and
/// shadow rays.
const STEP: [f64; 2] = [17.0, 13.0];
/// Shading a hit, and choosing a light for it by so many steps.
const SHADE: [f64; 2] = [140.0, 24.0];

/// What a film sample takes, ns, by the rays of three stages: to nearest hits, to shading, to lights.
/// The rates are of the repository's scenes (every render prints them) and hold within a factor of 2.
fn ns(scene: &Scene, [hits, shaded, shadows]: [f64; 3]) -> f64 {
    let digits = |count: usize| (count as f64 + 1.0).log2();
    let steps = digits(scene.bytes() >> 8);
    let shade = SHADE[0] + SHADE[1] * digits(scene.lights.all.len());
    LENS + steps * (STEP[0] * hits + STEP[1] * shadows) + shade * shaded
}

/// How bright a picture will be, and what it takes. Some 20,000 samples, on one thread.
pub(super) fn level(job: &mut Job) -> Result<Level, JobError> {
    let [width, height] = job.frame.resolution.map(f64::from);
    let small = [width, height].map(|n| (n * SIDE / width.max(height)).round().max(1.0) as u32);
    let frame = std::mem::replace(&mut job.frame, Frame::whole(small));
    let samples = std::mem::replace(&mut job.samples, 0..SAMPLES);
    let layers = std::mem::take(&mut job.layers);
    let exposed = render(job, Backend::Simd, 1, &Progress::default());
    (job.frame, job.samples, job.layers) = (frame, samples, layers);
    let Exposed { film, stats, .. } = exposed?;
    let picture = film.picture(SAMPLES);
    let taken = f64::from(small[0] * small[1] * SAMPLES);
    let rays = |stage| stats.stage(stage).rays as f64 / taken;
    let mut light: Vec<f64> =
        picture.pixels.iter().map(|&pixel| f64::from(luminance(pixel))).collect();
    light.sort_by(f64::total_cmp);
    let kept = &light[..light.len() - light.len() / 10];
    let mean_of = |light: &[f64]| light.iter().sum::<f64>() / light.len() as f64;
    let (mean, whole) = (mean_of(kept), mean_of(&light));
    let brightest = light.last().map_or(0.0, |light| light - mean);
    // A lamp may be so small that no sample meets it.
    let lamp = (brightest * width * height / light.len() as f64).max(ghosts::lamp(job));
    let rays = [Stage::Intersect, Stage::Shade, Stage::Occlude].map(rays);
    let sample = ns(&job.scene, rays);
    let whole = whole.max(lamp / (width * height));
    Ok(Level { mean: mean.max(BLACK * whole), lamp, sample, rays: rays[0] + rays[2] })
}
