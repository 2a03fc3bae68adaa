//! The part of the picture that is rendered.

use super::{Changes, JobError};
use crate::film::Frame;
use crate::scene::pbrt::FilmSpec;

pub(super) fn frame(film: &FilmSpec, changes: &Changes) -> Result<Frame, JobError> {
    let resolution = changes.resolution.unwrap_or(film.resolution);
    // A crop in the scene file is in its own pixels; it keeps its share of the picture.
    let scaled = |pixel: [u32; 2]| {
        [0, 1].map(|i| {
            let share = f64::from(pixel[i]) / f64::from(film.resolution[i]);
            (share * f64::from(resolution[i])).round() as u32
        })
    };
    let [low, high] = changes.crop.unwrap_or(film.bounds.map(scaled));
    let inside = (0..2).all(|i| low[i] < high[i] && high[i] <= resolution[i]);
    if !inside {
        return Err(JobError::Asked(format!(
            "the crop {},{},{},{} leaves nothing of a picture of {} x {} pixels; \
             it reads X0,Y0,X1,Y1 with X1 and Y1 not included",
            low[0], low[1], high[0], high[1], resolution[0], resolution[1]
        )));
    }
    let pixels = u64::from(high[0] - low[0]) * u64::from(high[1] - low[1]);
    if pixels > MOST_PIXELS {
        return Err(JobError::Asked(format!(
            "a picture of {pixels} pixels is too large; render it in parts of at most {MOST_PIXELS} \
             pixels with --crop"
        )));
    }
    Ok(Frame { resolution, low, high })
}

/// Pixels of one render: more have to be rendered in parts.
const MOST_PIXELS: u64 = 1 << 27;
