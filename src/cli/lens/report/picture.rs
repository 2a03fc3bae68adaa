//! Pictures of point images and wavefronts.

use petzval::io::image::{Picture, srgb_decode};
use petzval::lens::{PointImage, PupilGrid};

/// A picture of a section.
#[derive(Debug)]
pub(super) struct SectionPicture {
    /// Name of the file, without the section's name.
    pub name: String,
    pub caption: String,
    /// The picture as a PNG file.
    pub png: Vec<u8>,
}

/// Pixels along each side of a sample.
const ENLARGED: usize = 3;
/// Decades of brightness from white to black.
const DECADES: f64 = 4.0;

/// Returns the picture of a point image on a logarithmic scale, y up.
pub(super) fn point_image(image: &PointImage) -> std::io::Result<Vec<u8>> {
    let peak = image.values.iter().copied().fold(0.0, f64::max);
    enlarged(image.side, |i| {
        let signal = 1.0 + (image.values[i] / peak).log10() / DECADES;
        [srgb_decode(signal.clamp(0.0, 1.0) as f32); 3]
    })
}

/// Returns the map of a wavefront, y up: red where light is ahead by `reach` wavelengths, blue where
/// it is behind, white for none, grey outside the pupil.
pub(super) fn wavefront(grid: &PupilGrid, reach: f64) -> std::io::Result<Vec<u8>> {
    let waves = grid.nm * 1e-6;
    enlarged(grid.side, |i| {
        let Some(cell) = &grid.cells[i] else { return [srgb_decode(0.5); 3] };
        let share = (-cell.path_difference / waves / reach).clamp(-1.0, 1.0) as f32;
        let [warm, cold] = [1.0 - share.max(0.0), 1.0 + share.min(0.0)];
        [cold, cold.min(warm), warm].map(srgb_decode)
    })
}

fn enlarged(side: usize, pixel: impl Fn(usize) -> [f32; 3]) -> std::io::Result<Vec<u8>> {
    let wide = side * ENLARGED;
    let place = |i: usize| {
        let (x, y) = (i % wide / ENLARGED, i / wide / ENLARGED);
        pixel((side - 1 - y) * side + x)
    };
    Picture { size: [wide; 2], pixels: (0..wide * wide).map(place).collect() }.png(1.0)
}
