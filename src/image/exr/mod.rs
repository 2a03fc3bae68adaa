//! OpenEXR files. This is the only module that uses the `exr` crate.

mod layers;
mod read;
mod write;

pub use layers::PictureLayers;
pub(crate) use read::{read, read_raster};
pub(crate) use write::{write, write_channels};

#[cfg(test)]
mod tests {
    use exr::math::Vec2;
    use exr::meta::MetaData;

    use super::read::convert;
    use crate::{EncodingOptions, Picture, PictureWindow, Raster};
    use petzval_base::io::ReadContext;
    use petzval_base::io::{FileLog, OutputFile};
    use petzval_spectrum::Primaries;

    /// ACES2065-1 (SMPTE ST 2065-1).
    const ACES: Primaries = Primaries {
        red: [0.7347, 0.2653],
        green: [0.0, 1.0],
        blue: [0.0001, -0.077],
        white: [0.32168, 0.33767],
    };

    fn written(space: Option<Primaries>, half: bool) -> (tempfile::TempDir, std::path::PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let picture = Picture { size: [2, 1], pixels: vec![[1.0; 3], [0.6, 0.3, 0.1]] };
        let window = PictureWindow { origin: [0, 0], frame: [2, 1] };
        let encoding = EncodingOptions { space, half, ..EncodingOptions::default() };
        let to = OutputFile::new(&path, &FileLog::default()).unwrap();
        picture.write(&to, window, encoding, &Vec::new()).unwrap();
        (folder, path)
    }

    #[test]
    fn a_file_in_another_space_says_so_and_is_read_back_as_srgb() {
        for half in [false, true] {
            let (_folder, path) = written(Some(ACES), half);
            let meta = MetaData::read_from_file(&path, false).unwrap();
            let found = meta.headers[0].shared_attributes.chromaticities.expect("an attribute");
            assert_eq!(found.white, Vec2(0.32168, 0.33767));
            let picture = Picture::read(&path).unwrap();
            for (found, expected) in picture.pixels.iter().zip([[1.0; 3], [0.6, 0.3, 0.1]]) {
                let off = (0..3).map(|i| (found[i] - expected[i]).abs()).fold(0.0, f32::max);
                assert!(off < if half { 2e-3 } else { 1e-5 }, "{found:?}");
            }
        }
    }

    #[test]
    fn a_texture_of_another_space_is_adapted_from_white_to_white() {
        let (_folder, path) = written(Some(ACES), false);
        let raster = Raster::read(&path, Default::default(), &ReadContext::default()).unwrap();
        let found = raster.into_picture().pixels[1];
        let to_file = Primaries::SRGB.to(&ACES).unwrap();
        let matrix = ACES.adapted_to(&Primaries::SRGB).unwrap() * to_file;
        let expected = convert(&matrix, [0.6, 0.3, 0.1]);
        let off = (0..3).map(|i| (found[i] - expected[i]).abs()).fold(0.0, f32::max);
        assert!(off < 1e-5, "{found:?}, expected {expected:?}");
        assert!((found[2] / 0.1 - 1.0).abs() > 0.02, "{found:?}");
    }

    #[test]
    fn a_file_in_srgb_has_no_attribute() {
        let (_folder, path) = written(None, false);
        let meta = MetaData::read_from_file(&path, false).unwrap();
        assert!(meta.headers[0].shared_attributes.chromaticities.is_none());
        assert_eq!(Picture::read(&path).unwrap().pixels[1], [0.6, 0.3, 0.1]);
    }
}
