//! Development of raw files: from the codes of a sensor to a picture.
//!
//! The order is that of the DNG specification 1.7.1.0 (Adobe, 2023, chapters 5 and 6): black and white level, white
//! balance, demosaicking, colours.

mod colours;
mod demosaic;
mod gain_map;
mod lens_opcodes;

use std::path::Path;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use petzval_base::io::ReadContext;

pub(crate) use colours::{CameraColours, LightColours, Neutral};
use demosaic::demosaic;
pub(crate) use gain_map::Opcodes;
#[cfg(test)]
pub(crate) use gain_map::tests as gain_map_tests;
pub(crate) use lens_opcodes::LensOpcode;

use crate::format::extension;
use crate::{ImageError, Picture, RawCodes, WhiteBalance, declared, tiff};

/// Largest ratio of the channels of white.
const MAX_RATIO: f64 = 1e4;
/// Bytes that the development of a pixel needs: codes in chunks and in rows, readings, two differences, green, a direction, and colours.
const PIXEL_BYTES: u64 = 2 * 2 + 4 + 8 + 4 + 1 + 12;

/// Why a raw file cannot be developed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DevelopError {
    /// It has too few pixels to interpolate colours.
    #[error("it has {width} x {height} pixels; expected 4 x 4 or more behind colour filters")]
    Small {
        /// Width (pixels).
        width: usize,
        /// Height (pixels).
        height: usize,
    },
    /// Green is not on a diagonal of two by two filters.
    #[error("its filters are {filters:?}; expected a Bayer pattern, with green on a diagonal")]
    Filters {
        /// 0 red, 1 green, 2 blue, in reading order.
        filters: [u8; 4],
    },
    /// The light of the white balance is not white to the camera.
    #[error("its camera has no white in this light; choose another 'white_balance', such as D65")]
    NoWhite,
}

/// Readings of a sensor with all that makes a picture of them.
#[derive(Clone, Debug, PartialEq)]
pub struct RawFile {
    pub(crate) codes: RawCodes,
    /// Codes of no light behind the filters of two by two pixels, in reading order.
    pub(crate) black: [f64; 4],
    /// Code from which photosites are saturated.
    pub(crate) white: f64,
    /// Colours of the camera and of the light; `None` for a sensor without filters.
    pub(crate) colours: Option<CameraColours>,
    pub(crate) opcodes: Opcodes,
    /// Stops by which the picture is brighter than its codes.
    pub(crate) exposure: f64,
    /// First column and row of the part that is shown, and those that no longer belong to it.
    pub(crate) crop: Option<[[usize; 2]; 2]>,
    /// Orientation as in Exif: 1 for a first row at the top and a first column at the left.
    pub(crate) orientation: u8,
}

/// A picture of a raw file.
#[derive(Clone, Debug)]
pub struct Developed {
    /// Linear sRGB. Before the exposure of the file, 1 is the white of photosites that saturate.
    pub picture: Picture,
    /// CIE 1931 chromaticities of the light that is white in it; `None` for a sensor without filters.
    pub white: Option<[f64; 2]>,
    /// Names of the corrections of the file that are not applied.
    pub left_out: Vec<String>,
}

impl RawFile {
    /// The word for the white balance of the file, [`WhiteBalance::Off`].
    pub const AS_SHOT: &str = "as-shot";

    /// Reads a DNG, uncompressed or compressed with lossless JPEG.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read, is no DNG, or lacks levels or colours.
    pub fn read(path: &Path, context: &ReadContext) -> Result<Self, ImageError> {
        let found = extension(path);
        if found != "dng" {
            return Err(ImageError::Format { path: path.to_owned(), found, known: ".dng" });
        }
        let io = |source| ImageError::Io { verb: "read", path: path.to_owned(), source };
        context.register(path).map_err(io)?;
        let bytes = context.bytes(path).map_err(|error| io(error.source))?;
        let malformed = |found| ImageError::Malformed { path: path.to_owned(), found };
        let samples = tiff::raw_samples(&bytes).map_err(malformed)?;
        let claimed = context.claim(PIXEL_BYTES.saturating_mul(samples));
        claimed.map_err(|found| declared::too_large(path, found))?;
        tiff::read_raw(&bytes).map_err(malformed)
    }

    /// Develops the picture. [`WhiteBalance::Off`] keeps the white balance of the file.
    ///
    /// # Errors
    /// Returns an error if the camera cannot see this light as white, or if its filters or the size of the picture do not
    /// tell colours.
    pub fn develop(&self, white: WhiteBalance) -> Result<Developed, DevelopError> {
        let size = self.codes.size;
        let gain = self.exposure.exp2() as f32;
        let (pixels, white) = match (&self.colours, self.codes.filters) {
            (Some(colours), Some(filters)) => {
                demosaic::check(size, filters)?;
                let mut readings = self.levelled();
                let neutral = match white {
                    WhiteBalance::Off => colours.as_shot(),
                    WhiteBalance::Auto => Some(mean_channels(size[0], &readings, filters)),
                    WhiteBalance::White(light) => colours.neutral_of(light),
                };
                let neutral = neutral.ok_or(DevelopError::NoWhite)?;
                let neutral = neutral / neutral.max_element();
                let is_light = neutral.is_finite() && neutral.min_element() * MAX_RATIO >= 1.0;
                if !is_light {
                    return Err(DevelopError::NoWhite);
                }
                self.correct(&mut readings);
                // A saturated channel with a larger gain would tint highlights: all are clipped where white saturates.
                let gains = neutral.to_array().map(|share| (1.0 / share) as f32);
                by_filter(size[0], &mut readings, |value, place| {
                    (value * gains[usize::from(filters[place])]).min(1.0)
                });
                let (matrix, light) = colours.to_srgb(neutral)?;
                let matrix = (matrix * f64::from(gain)).as_mat3();
                let mut pixels = demosaic(size, &readings, filters);
                self.correct_lens(&mut pixels);
                pixels.par_iter_mut().for_each(|pixel| {
                    *pixel = (matrix * Vec3::from_array(*pixel)).to_array();
                });
                (pixels, Some(light))
            }
            _ => {
                let mut readings = self.levelled();
                self.correct(&mut readings);
                let mut pixels = readings.iter().map(|&value| [gain * value.min(1.0); 3]).collect();
                self.correct_lens(&mut pixels);
                (pixels, None)
            }
        };
        let picture = oriented(cropped(Picture { size, pixels }, self.crop), self.orientation);
        Ok(Developed { picture, white, left_out: self.opcodes.names_left_out() })
    }

    /// Returns the readings: 0 without light, 1 if saturated.
    fn levelled(&self) -> Vec<f32> {
        let scales = self.black.map(|black| 1.0 / (self.white - black));
        let mut readings: Vec<f32> =
            self.codes.codes.par_iter().map(|&code| f32::from(code)).collect();
        by_filter(self.codes.size[0], &mut readings, |code, place| {
            ((f64::from(code) - self.black[place]) * scales[place]) as f32
        });
        readings
    }

    /// Corrects the falloff and the distortion of the lens in a picture with all channels.
    fn correct_lens(&self, pixels: &mut Vec<[f32; 3]>) {
        for opcode in &self.opcodes.lens {
            opcode.apply(self.codes.size, pixels);
        }
    }

    /// Multiplies readings by the gain maps of the file.
    fn correct(&self, readings: &mut [f32]) {
        self.opcodes.gain_maps.iter().for_each(|map| map.apply(self.codes.size, readings));
    }
}

/// Maps readings, by their place among two by two pixels in reading order.
fn by_filter(width: usize, readings: &mut [f32], map: impl Fn(f32, usize) -> f32 + Sync) {
    readings.par_chunks_exact_mut(width).enumerate().for_each(|(y, row)| {
        for (x, value) in row.iter_mut().enumerate() {
            *value = map(*value, (y & 1) * 2 + (x & 1));
        }
    });
}

/// Returns the means of the channels, without two by two photosites of which one is saturated.
fn mean_channels(width: usize, readings: &[f32], filters: [u8; 4]) -> DVec3 {
    let (mut sums, mut counts) = ([0.0; 3], [0.0; 3]);
    for rows in readings.chunks_exact(2 * width) {
        let (upper, lower) = rows.split_at(width);
        for (a, b) in upper.as_chunks::<2>().0.iter().zip(lower.as_chunks::<2>().0) {
            let cell = [a[0], a[1], b[0], b[1]];
            if cell.iter().all(|&value| value < 1.0) {
                for (value, filter) in cell.into_iter().zip(filters) {
                    sums[usize::from(filter)] += f64::from(value);
                    counts[usize::from(filter)] += 1.0;
                }
            }
        }
    }
    DVec3::from_array([0, 1, 2].map(|c| sums[c] / counts[c]))
}

/// Returns a part of a picture.
fn cropped(picture: Picture, part: Option<[[usize; 2]; 2]>) -> Picture {
    let Some([low, high]) = part else { return picture };
    let rows = picture.pixels.chunks_exact(picture.size[0]).take(high[1]).skip(low[1]);
    let pixels = rows.flat_map(|row| &row[low[0]..high[0]]).copied().collect();
    Picture { size: [high[0] - low[0], high[1] - low[1]], pixels }
}

/// Returns the picture upright, by its orientation in Exif 2.32.
fn oriented(picture: Picture, orientation: u8) -> Picture {
    let [width, height] = picture.size;
    let (turned, mirrored_x, mirrored_y) = match orientation {
        2 => (false, true, false),
        3 => (false, true, true),
        4 => (false, false, true),
        5 => (true, false, false),
        6 => (true, false, true),
        7 => (true, true, true),
        8 => (true, true, false),
        _ => return picture,
    };
    let size = if turned { [height, width] } else { [width, height] };
    let pixel = |i: usize| {
        let at = [i % size[0], i / size[0]];
        let [x, y] = if turned { [at[1], at[0]] } else { at };
        let x = if mirrored_x { width - 1 - x } else { x };
        let y = if mirrored_y { height - 1 - y } else { y };
        picture.pixels[y * width + x]
    };
    Picture { size, pixels: (0..width * height).map(pixel).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LensCorrection, PictureWindow};

    fn grey(codes: Vec<u16>, size: [usize; 2]) -> RawFile {
        RawFile {
            codes: RawCodes { size, codes, filters: None, bits: 16 },
            black: [100.0, 100.0, 100.0, 200.0],
            white: 1100.0,
            colours: None,
            opcodes: Opcodes::default(),
            exposure: 1.0,
            crop: None,
            orientation: 1,
        }
    }

    #[test]
    fn levels_and_exposure_are_those_of_the_file() {
        let raw = grey(vec![100, 2100, 50, 650], [2, 2]);
        let Developed { picture, white, .. } = raw.develop(WhiteBalance::Off).unwrap();
        let found: Vec<f32> = picture.pixels.iter().map(|pixel| pixel[1]).collect();
        assert_eq!((found, white), (vec![0.0, 2.0, -0.1, 1.0], None));
    }

    #[test]
    fn lenses_of_sensors_without_filters_are_corrected_too() {
        let correction =
            LensCorrection { warp: [[1.0, 0.0, 0.0, 0.0]; 3], gain: [1.0, 0.0, 0.0, 0.0, 0.0] };
        let window = PictureWindow { origin: [0, 0], frame: [4, 4] };
        let list = correction.opcodes([4, 4], window).unwrap();
        let mut raw =
            RawFile { opcodes: Opcodes::parse(&list).unwrap(), ..grey(vec![600; 16], [4, 4]) };
        raw.black = [100.0; 4];
        let Developed { picture, left_out, .. } = raw.develop(WhiteBalance::Off).unwrap();
        // 1.5 pixels along both axes of 2.
        assert!((picture.pixels[0][0] - (1.0 + 4.5 / 8.0)).abs() < 1e-6, "{:?}", picture.pixels[0]);
        assert!(left_out.is_empty());
    }

    #[test]
    fn orientations_turn_the_picture() {
        // Row 0 is a b c, row 1 is d e f.
        let codes: Vec<u16> = (0..6).map(|i| 100 + 100 * i).collect();
        let letters = |orientation| {
            let mut raw = RawFile { orientation, ..grey(codes.clone(), [3, 2]) };
            raw.black = [100.0; 4];
            let Developed { picture, .. } = raw.develop(WhiteBalance::Off).unwrap();
            let rows = picture.pixels.chunks(picture.size[0]);
            let letter = |pixel: &[f32; 3]| char::from(b'a' + (pixel[0] * 5.0).round() as u8);
            rows.map(|row| row.iter().map(letter).collect::<String>()).collect::<Vec<_>>().join("/")
        };
        // The 0th row is at the top and the 0th column at the left, at the top and right, and so on (Exif 2.32).
        let expected = [
            "abc/def", "cba/fed", "fed/cba", "def/abc", "ad/be/cf", "da/eb/fc", "fc/eb/da",
            "cf/be/ad",
        ];
        for (orientation, expected) in (1..).zip(expected) {
            assert_eq!(letters(orientation), expected, "{orientation}");
        }
    }

    #[test]
    fn saturated_photosites_do_not_count_in_the_mean() {
        // Two cells beside each other, the second with a saturated photosite.
        let readings = [0.5, 0.2, 0.5, 1.0, 0.2, 0.1, 0.9, 0.8];
        let means = mean_channels(4, &readings, [0, 1, 1, 2]);
        assert!((means - DVec3::new(0.5, 0.2, 0.1)).abs().max_element() < 1e-6, "{means}");
    }
}
