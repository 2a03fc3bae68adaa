//! Pictures of point images and wavefronts.

use std::fmt::Write as _;

use crate::number::rounded;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use petzval_image::{Picture, srgb_decode};
use petzval_optics::{PointImage, PupilGrid};

/// A picture of a section.
#[derive(Debug)]
pub(super) struct SectionPicture {
    /// Name of the file, without the section's name.
    pub name: String,
    pub caption: String,
    /// The picture as a PNG file.
    pub png: Vec<u8>,
    pub scale: PictureScale,
}

/// Meaning of the colours of a picture, and its size.
#[derive(Clone, Copy, Debug)]
pub(super) enum PictureScale {
    /// Red is ahead by as many wavelengths, blue behind.
    Waves(f64),
    /// Decades from black to white; the picture is as wide (um).
    Decades {
        /// The width (um).
        width: f64,
    },
}

/// Side of a picture on the page, and its height with the colour bar [px].
const SHOWN: [f64; 2] = [300.0, 342.0];
/// Left end and base line of the labels of the colour bar [px].
const LABELS: f64 = 336.0;

impl SectionPicture {
    /// Returns the picture as a part of a page, with a bar of its colours and of its scale. `id` is
    /// unique on the page. All text is plain.
    pub fn inline(&self, id: &str) -> String {
        let [side, height] = SHOWN;
        let (stops, labels) = match self.scale {
            PictureScale::Waves(reach) => (
                ["#00f", "#fff", "#f00"],
                [
                    format!("−{} waves", rounded(reach)),
                    "0".to_owned(),
                    format!("+{}", rounded(reach)),
                ],
            ),
            PictureScale::Decades { .. } => (
                ["#000", "#808080", "#fff"],
                ["10⁻⁴ of the peak".to_owned(), "10⁻²".to_owned(), "1".to_owned()],
            ),
        };
        let mut svg = format!(
            "<svg viewBox=\"0 0 {side} {height}\" role=\"img\" font-family=\"Helvetica, Arial, \
             sans-serif\" font-size=\"12\" fill=\"currentColor\">\n<image width=\"{side}\" \
             height=\"{side}\" style=\"image-rendering: pixelated\" \
             href=\"data:image/png;base64,{}\"/>\n<defs><linearGradient id=\"{id}\">",
            STANDARD.encode(&self.png)
        );
        for (i, colour) in stops.iter().enumerate() {
            let _ = write!(svg, "<stop offset=\"{}\" stop-color=\"{colour}\"/>", i as f64 / 2.0);
        }
        let _ = writeln!(
            svg,
            "</linearGradient></defs>\n<rect x=\"0.5\" y=\"307\" width=\"299\" height=\"12\" \
             fill=\"url(#{id})\" stroke=\"currentColor\" stroke-opacity=\"0.4\"/>"
        );
        for (i, label) in labels.iter().enumerate() {
            let (x, anchor) = [(0.0, "start"), (side / 2.0, "middle"), (side, "end")][i];
            let _ = writeln!(
                svg,
                "<text x=\"{x}\" y=\"{LABELS}\" text-anchor=\"{anchor}\">{label}</text>"
            );
        }
        if let PictureScale::Decades { width } = self.scale {
            let bar = round_length(width / 3.0);
            let px = side * bar / width;
            let _ = writeln!(
                svg,
                "<path d=\"M12 283v8M12 287h{px:.1}M{:.1} 283v8\" stroke=\"#fff\" \
                 stroke-width=\"1.5\" fill=\"none\"/>\n<text x=\"12\" y=\"276\" \
                 fill=\"#fff\">{} µm</text>",
                12.0 + px,
                rounded(bar)
            );
        }
        svg + "</svg>"
    }
}

/// Returns the largest round length up to this one: 1, 2 or 5 times a power of ten.
fn round_length(most: f64) -> f64 {
    let power = 10f64.powf(most.max(f64::MIN_POSITIVE).log10().floor());
    let round = [5.0, 2.0, 1.0].map(|digit| digit * power);
    round.into_iter().find(|length| *length <= most).unwrap_or(power)
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
