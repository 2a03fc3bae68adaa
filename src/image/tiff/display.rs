//! TIFF files for display: 16-bit signals with the curve of sRGB.

use std::io::{self, Seek, Write};

use tiff::encoder::colortype::{ColorType, Gray16, RGB16};
use tiff::encoder::{Compression, DeflateLevel, Predictor, TiffEncoder};
use tiff::tags::{ExtraSamples, Tag};

use super::{io_error, text_of};
use crate::display::{DisplayMapping, dimensions, encoded};
use crate::{Notes, Picture};

/// Writes a picture, with an opacity if there is one.
pub(crate) fn write_tiff(
    picture: &Picture,
    alpha: Option<&[f32]>,
    mapping: DisplayMapping,
    notes: &Notes,
    file: impl Write + Seek,
) -> io::Result<()> {
    let codes: Vec<u16> = encoded(picture, alpha, mapping)?;
    let write = match mapping.grey {
        true => write_codes::<Gray16, _>,
        false => write_codes::<RGB16, _>,
    };
    write(dimensions(picture), alpha.is_some(), &codes, notes, file).map_err(io_error)
}

fn write_codes<C: ColorType<Inner = u16>, W: Write + Seek>(
    [width, height]: [u32; 2],
    has_alpha: bool,
    codes: &[u16],
    notes: &Notes,
    file: W,
) -> tiff::TiffResult<()> {
    // The encoder's predictor does not know of extra samples.
    let predictor = if has_alpha { Predictor::None } else { Predictor::Horizontal };
    let encoder = TiffEncoder::new(file)?;
    let mut encoder = encoder
        .with_compression(Compression::Deflate(DeflateLevel::Balanced))
        .with_predictor(predictor);
    let mut image = encoder.new_image::<C>(width, height)?;
    if has_alpha {
        image.extra_samples(&[ExtraSamples::UnassociatedAlpha])?;
    }
    image.encoder().write_tag(Tag::ImageDescription, &*text_of(notes))?;
    image.write_data(codes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        ALPHA_LAYER, BitDepth, EncodingOptions, ImageLayer, ImageSamples, Note, PictureWindow,
        Raster, Transfer,
    };
    use petzval_base::io::{FileLog, OutputFile, ReadContext};

    /// Colours of all signals, and more rows than a strip has.
    fn picture() -> Picture {
        let pixel = |i: usize| [0, 1, 2].map(|c| ((i * (c + 1) * 7919) % 65536) as f32 / 65535.0);
        Picture { size: [300, 700], pixels: (0..300 * 700).map(pixel).collect() }
    }

    #[test]
    fn tiff_and_deep_png_hold_the_same_codes() {
        let folder = tempfile::tempdir().unwrap();
        let picture = picture();
        let window = PictureWindow { origin: [0, 0], frame: [300, 700] };
        let opacity = (0..300 * 700).map(|i| (1 + i % 997) as f32 / 1000.0).collect();
        let layer = ImageLayer::new(ALPHA_LAYER, vec![("A".to_owned(), opacity)]);
        for (grey, layers) in [(false, vec![]), (true, vec![]), (false, vec![layer])] {
            let bit_depth = Some(BitDepth::Sixteen);
            let encoding = EncodingOptions { grey, bit_depth, ..EncodingOptions::default() };
            let [png, found] = ["a.png", "a.tiff"].map(|name| {
                let path = folder.path().join(name);
                let file = OutputFile::new(path.clone(), &FileLog::default()).unwrap();
                let notes = vec![("lensModel", Note::Text("Elmar \u{b5}\0".to_owned()))];
                picture.write_with_layers(&layers, &file, window, encoding, &notes).unwrap();
                Raster::read(&path, Transfer::Linear, &ReadContext::default()).unwrap()
            });
            assert_eq!(png, found);
            let file = std::fs::File::open(folder.path().join("a.tiff")).unwrap();
            let mut decoder = tiff::decoder::Decoder::new(file).unwrap();
            let text = decoder.get_tag_ascii_string(Tag::ImageDescription).unwrap();
            assert_eq!(text, "lensModel: Elmar ??\n");
            assert_eq!(found.channels, if grey { 1 } else { 3 + layers.len() });
            let ImageSamples::Floats(floats) = found.samples else { panic!("8 bits") };
            let codes: Vec<u16> = encoded(
                &picture,
                layers.first().map(|layer| &layer.channels[0].1[..]),
                encoding.mapping(),
            )
            .unwrap();
            assert!(floats.iter().map(|v| (v * 65535.0).round() as u16).eq(codes));
        }
    }
}
