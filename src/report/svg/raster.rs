//! Rasteriser of SVG drawings, with a typeface of its own.

use std::sync::Arc;

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb};

use petzval_image::{Picture, srgb_decode};

/// Pixels of a PNG file per px of the drawing.
const SCALE: f32 = 2.0;

/// Returns a drawing as a PNG file, two pixels per px.
///
/// # Errors
/// Returns an error if the text is no SVG or has no size.
pub fn png(svg: &str) -> Result<Vec<u8>, Box<dyn std::error::Error>> {
    Ok(rasterise(svg, SCALE)?.encode_png()?)
}

/// Returns an opaque drawing as a picture in linear light, one pixel per px.
///
/// # Errors
/// As [`png`].
pub fn picture(svg: &str) -> Result<Picture, Box<dyn std::error::Error>> {
    let drawn = rasterise(svg, 1.0)?;
    let decoded: Vec<f32> = (0..=255u8).map(|code| srgb_decode(f32::from(code) / 255.0)).collect();
    let light = |code: u8| decoded[usize::from(code)];
    let colours = drawn.pixels().iter().map(|pixel| [pixel.red(), pixel.green(), pixel.blue()]);
    let size = [drawn.width(), drawn.height()].map(|n| n as usize);
    Ok(Picture { size, pixels: colours.map(|rgb| rgb.map(light)).collect() })
}

fn rasterise(svg: &str, scale: f32) -> Result<Pixmap, Box<dyn std::error::Error>> {
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
    use super::super::Sheet;
    use super::*;

    #[test]
    fn text_and_lines_are_drawn() {
        let drawn = |words: &str| {
            let mut sheet = Sheet::default();
            sheet.path(&[[2.0, 20.0], [60.0, 20.0]], false, "stroke=\"currentColor\"");
            sheet.text([2.0, 15.0], 12.0, "", words);
            let file = png(&sheet.finish([64.0, 24.0], "")).expect("a picture");
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
