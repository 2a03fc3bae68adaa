//! Blur map: the circle of confusion over the picture, for focus peaking.

use petzval::Aov;
use petzval_lens::LensModel;
use petzval_render::film::Frame;
use petzval_render::job::Job;
use petzval_render::{Progress, RenderOptions, render};

/// Pixels of the map at most.
const PIXELS: f64 = 100_000.0;
/// Samples of each.
const SAMPLES: u32 = 4;
/// First bytes of a message.
const MAGIC: [u8; 4] = *b"PZC1";

/// Measures the blur of the surfaces in a picture. Returns the message for the page: the magic, width
/// and height as 32-bit numbers, the generation as a 64-bit number, and the diameter of the circle
/// of confusion in pixels of the picture as 32-bit floats, row by row from the top; that of infinity where
/// there is no surface, and 0 without light. All are little-endian.
///
/// Returns `None` without a real lens, and if `progress` is stopped.
pub(super) fn blur_map(
    job: &Job,
    generation: u64,
    threads: usize,
    progress: &Progress,
) -> Option<Vec<u8>> {
    if !matches!(job.camera.model, LensModel::Real(_)) {
        return None;
    }
    let pitch = 1e3 * job.camera.pixel_pitch(job.frame.resolution)[0];
    let mut map = job.clone();
    map.frame = reduced(&job.frame, PIXELS);
    (map.layers, map.samples) = (vec![Aov::Coc], 0..SAMPLES);
    // Only the first surface counts.
    map.path_limits.max_depth = 0;
    (map.ghosts, map.lamp_images) = (None, None);
    let options = RenderOptions { threads, progress: Some(progress), ..RenderOptions::default() };
    let output = render(&map, options).ok()?;
    let layers = output.layers(&map);
    let (_, um) = layers.first()?.channels.first()?;
    let [width, height] = map.frame.size();
    let mut bytes = MAGIC.to_vec();
    bytes.extend([width, height].into_iter().flat_map(u32::to_le_bytes));
    bytes.extend(generation.to_le_bytes());
    let pixels = um.iter().map(|um| if um.is_finite() { um / pitch as f32 } else { 0.0 });
    bytes.extend(pixels.flat_map(f32::to_le_bytes));
    Some(bytes)
}

/// Returns a frame of the same picture, with so many pixels at most.
pub(super) fn reduced(frame: &Frame, most: f64) -> Frame {
    let pixels: f64 = frame.size().map(f64::from).iter().product();
    let scale = (most / pixels).sqrt().min(1.0);
    let scaled = |pixel: u32| (f64::from(pixel) * scale).round() as u32;
    let [resolution, low, high] =
        [frame.resolution, frame.low, frame.high].map(|point| point.map(scaled));
    // A crop keeps a pixel at least.
    let high = [0, 1].map(|i| high[i].max(low[i] + 1));
    Frame { resolution: [0, 1].map(|i| resolution[i].max(high[i])), low, high }
}
