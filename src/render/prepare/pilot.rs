//! Pilot render: estimates the brightness and the cost of a picture from a small one.

use super::PrepareError;
use crate::film::Frame;
use crate::job::Job;
use crate::light_tracing::ghosts;
use crate::plan::PilotEstimate;
use crate::{RenderOptions, RenderOutput, render};
use petzval_base::stats::Stage;
use petzval_scene::{Scene, luminance};

/// The longer side of the small picture (pixels).
const SIDE: f64 = 40.0;
/// Samples per pixel of the small picture.
const SAMPLES: u32 = 16;

/// Lower limit of the mean without the brightest tenth, relative to the whole mean: the black level
/// of a display relative to its white. A ratio, so nothing depends on the unit of light.
const BLACK_LEVEL: f64 = 1e-3;

/// Cost of a film sample before its path [ns of one core].
const LENS_NS: f64 = 40.0;
/// Cost of a step down the tree (ns), for nearest hits and for shadow rays. The number of steps is the
/// binary logarithm of the tree's size.
const STEP_NS: [f64; 2] = [17.0, 13.0];
/// Cost of shading a hit, and of each step of choosing a light for it (ns).
const SHADE_NS: [f64; 2] = [140.0, 24.0];

/// Returns the cost of a film sample (ns), given its mean numbers of nearest-hit rays, shaded hits and
/// shadow rays.
///
/// The rates are those of the repository's scenes (every render prints them) and hold within a
/// factor of 2.
fn sample_ns(scene: &Scene, [hits, shaded, shadows]: [f64; 3]) -> f64 {
    let digits = |count: usize| (count as f64 + 1.0).log2();
    let steps = digits(scene.bytes() >> 8);
    let shade = SHADE_NS[0] + SHADE_NS[1] * digits(scene.lights.all.len());
    LENS_NS + steps * (STEP_NS[0] * hits + STEP_NS[1] * shadows) + shade * shaded
}

/// Estimates the brightness and the cost of a picture from about 20,000 samples. The estimate is the
/// same for any number of threads.
///
/// # Errors
/// Returns an error if the small picture cannot be rendered.
pub(super) fn estimate(job: &Job) -> Result<PilotEstimate, PrepareError> {
    let [width, height] = job.frame.resolution.map(f64::from);
    let small = [width, height].map(|n| (n * SIDE / width.max(height)).round().max(1.0) as u32);
    let pilot =
        Job { frame: Frame::whole(small), samples: 0..SAMPLES, layers: Vec::new(), ..job.clone() };
    let RenderOutput { film, stats, .. } = render(&pilot, RenderOptions::default())?;
    let picture = film.picture(SAMPLES);
    let taken = f64::from(small[0] * small[1] * SAMPLES);
    let rays = |stage| stats.stage(stage).rays as f64 / taken;
    let mut light: Vec<f64> =
        picture.pixels.iter().map(|&pixel| f64::from(luminance(pixel))).collect();
    light.sort_by(f64::total_cmp);
    let darker = &light[..light.len() - light.len() / 10];
    let mean_of = |light: &[f64]| light.iter().sum::<f64>() / light.len() as f64;
    let (mean, whole) = (mean_of(darker), mean_of(&light));
    let excess = light.last().map_or(0.0, |light| light - mean);
    // A light may be so small that no sample meets it.
    let seen = excess * width * height / light.len() as f64;
    let highlight = seen.max(ghosts::direct_peak(&job.light_path_input()));
    let rays = [Stage::Intersect, Stage::Shade, Stage::Occlude].map(rays);
    let whole = whole.max(highlight / (width * height));
    Ok(PilotEstimate {
        mean: mean.max(BLACK_LEVEL * whole),
        highlight,
        ns_per_sample: sample_ns(&job.scene, rays),
        rays_per_sample: rays[0] + rays[2],
    })
}
