//! How bright a picture will be, by a small one.

use super::JobError;
use crate::film::Frame;
use crate::ghosts;
use crate::plan::Level;
use crate::render::{Backend, Job, Progress, render};
use crate::scene::luminance;

/// The longer side of the small picture, pixels, and its samples a pixel.
const SIDE: f64 = 40.0;
const SAMPLES: u32 = 16;

/// The mean of a picture is at least this: a display's black, when its white is 1.
const BLACK: f64 = 1e-3;

/// How bright a picture will be. Some 20,000 samples, on one thread.
pub(super) fn level(job: &mut Job) -> Result<Level, JobError> {
    let [width, height] = job.frame.resolution.map(f64::from);
    let small = [width, height].map(|n| (n * SIDE / width.max(height)).round().max(1.0) as u32);
    let frame = std::mem::replace(&mut job.frame, Frame::whole(small));
    let samples = std::mem::replace(&mut job.samples, 0..SAMPLES);
    let layers = std::mem::take(&mut job.layers);
    let exposed = render(job, Backend::Simd, 1, &Progress::default());
    (job.frame, job.samples, job.layers) = (frame, samples, layers);
    let picture = exposed?.film.picture(SAMPLES);
    let mut light: Vec<f64> =
        picture.pixels.iter().map(|&pixel| f64::from(luminance(pixel))).collect();
    light.sort_by(f64::total_cmp);
    let kept = &light[..light.len() - light.len() / 10];
    let mean = kept.iter().sum::<f64>() / kept.len() as f64;
    let brightest = light.last().map_or(0.0, |light| light - mean);
    // A lamp may be so small that no sample meets it.
    let lamp = (brightest * width * height / light.len() as f64).max(ghosts::lamp(job));
    Ok(Level { mean: mean.max(BLACK), lamp })
}
