//! Drawings as pixels, for where SVG cannot go.

use std::sync::Arc;

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb};

use crate::image::{Picture, srgb_decode};

/// Pixels of the picture to one px of the drawing.
const SCALE: f32 = 2.0;

/// A drawing as a PNG file, two pixels to a px, its words in a typeface that comes along.
///
/// # Errors
/// Where it is no SVG, or has no size.
pub(crate) fn raster(svg: &str) -> Result<Vec<u8>, Box<dyn std::error::Error>> {
    Ok(drawn(svg, SCALE)?.encode_png()?)
}

/// A drawing that covers its sheet as a picture, a pixel to a px; linear light.
///
/// # Errors
/// As [`raster`].
pub(crate) fn picture(svg: &str) -> Result<Picture, Box<dyn std::error::Error>> {
    let drawn = drawn(svg, 1.0)?;
    let decoded: Vec<f32> = (0..=255u8).map(|code| srgb_decode(f32::from(code) / 255.0)).collect();
    let light = |code: u8| decoded[usize::from(code)];
    let colours = drawn.pixels().iter().map(|pixel| [pixel.red(), pixel.green(), pixel.blue()]);
    let size = [drawn.width(), drawn.height()].map(|n| n as usize);
    Ok(Picture { size, pixels: colours.map(|rgb| rgb.map(light)).collect() })
}

fn drawn(svg: &str, scale: f32) -> Result<Pixmap, Box<dyn std::error::Error>> {
    let mut fonts = fontdb::Database::new();
    fonts.load_font_data(epaint_default_fonts::UBUNTU_LIGHT.to_vec());
    let family = fonts.faces().find_map(|face| Some(face.families.first()?.0.clone()));
    fonts.set_sans_serif_family(family.unwrap_or_default());
    let options = Options { fontdb: Arc::new(fonts), ..Options::default() };
    let tree = Tree::from_str(svg, &options)?;
    let [width, height] = [tree.size().width(), tree.size().height()].map(|v| (v * scale) as u32);
    let mut pixels = Pixmap::new(width, height).ok_or("the drawing has no size")?;
    resvg::render(&tree, Transform::from_scale(scale, scale), &mut pixels.as_mut());
    Ok(pixels)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::svg::Sheet;

    #[test]
    fn words_and_lines_are_drawn() {
        let drawn = |words: &str| {
            let mut sheet = Sheet::default();
            sheet.path(&[[2.0, 20.0], [60.0, 20.0]], false, "stroke=\"currentColor\"");
            sheet.text([2.0, 15.0], 12.0, "", words);
            let file = raster(&sheet.finish([64.0, 24.0], "")).expect("a picture");
            let pixels = image::load_from_memory(&file).expect("a PNG").into_luma8();
            assert_eq!(pixels.dimensions(), (128, 48));
            let dark = |rows: std::ops::Range<u32>| {
                pixels
                    .enumerate_pixels()
                    .filter(|(_, y, p)| rows.contains(y) && p.0[0] < 128)
                    .count()
            };
            [dark(0..36), dark(36..48)]
        };
        let [words, line] = drawn("time, %");
        assert!(words > 100 && line > 100, "{words} {line}");
        assert_eq!(drawn("")[0], 0);
    }
}
