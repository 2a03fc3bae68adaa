//! Raw mosaics: how the codes of a sensor behind colour filters follow from a picture.

use crate::LensCorrection;

/// Colours of a camera in the light of an illuminant, as matrices in rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColourCalibration {
    /// From X, Y and Z in that light to the channels: `ColorMatrix` of DNG.
    pub from_xyz: [[f64; 3]; 3],
    /// From the channels relative to those of white to X, Y and Z in D50: `ForwardMatrix`.
    pub to_xyz_d50: [[f64; 3]; 3],
}

/// Camera of a raw file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RawCamera {
    /// None: the channels are linear sRGB.
    LinearSrgb,
    /// A camera of this name.
    Known(&'static str),
    /// A camera without a name, which its colours tell from others.
    Own,
}

/// The sensor of a grey picture, whose pixels are its readings relative to white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RawFormat {
    /// The camera.
    pub camera: RawCamera,
    /// Channels behind the filters of two by two pixels of the frame, in reading order: 0 red, 1 green,
    /// 2 blue.
    pub filters: [u8; 4],
    /// Photosites along each side of a filter: 2 in a quad pattern, whose places count in filters.
    pub filter_side: u32,
    /// Code of no light.
    pub black: u16,
    /// Code of the value 1.
    pub white: u16,
    /// Code from which photosites are saturated: more than `white` if several of a pixel see brighter light.
    pub saturation: u16,
    /// Bits of the codes, of which files hold 16.
    pub bits: u32,
    /// Colours in daylight (D65).
    pub daylight: ColourCalibration,
    /// Colours in the light of a tungsten filament (illuminant A), of a camera that has been measured.
    pub tungsten: Option<ColourCalibration>,
    /// Channels of the white of the picture, relative to the largest.
    pub neutral: [f64; 3],
    /// The largest channel of white, relative to the value 1: more than 1 with the crosstalk of other channels.
    pub largest_neutral: f64,
    /// Correction of the lens that the file holds.
    pub correction: Option<LensCorrection>,
    /// Variance of a reading relative to `white`: the factor of the signal, and that without light.
    pub noise: [f64; 2],
}

impl RawFormat {
    /// Returns the code of a pixel of the picture.
    pub(super) fn code(&self, value: f32) -> u16 {
        let [black, white] = [self.black, self.white].map(f64::from);
        // The cast of NaN is 0.
        let last = white.max(f64::from(self.saturation));
        (black + f64::from(value) * (white - black)).round().clamp(0.0, last) as u16
    }

    /// Returns the name of the camera, which raw converters take for that of its colours.
    pub(super) fn camera_name(&self) -> String {
        match self.camera {
            RawCamera::LinearSrgb => "linear sRGB".to_owned(),
            RawCamera::Known(name) => name.to_owned(),
            RawCamera::Own => {
                let mut sum = flate2::Crc::new();
                let elements = self.daylight.from_xyz.as_flattened().iter();
                elements.for_each(|element| sum.update(&element.to_le_bytes()));
                format!("own camera {:08x}", sum.sum())
            }
        }
    }

    /// Returns the filters of a picture whose first pixel is at this place of the frame.
    pub(super) fn filters_from(&self, [x, y]: [u32; 2]) -> [u8; 4] {
        [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[dx, dy]| {
            let place = ((y + dy) & 1) * 2 + ((x + dx) & 1);
            self.filters[place as usize]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RGGB: RawFormat = RawFormat {
        camera: RawCamera::LinearSrgb,
        filters: [0, 1, 1, 2],
        filter_side: 1,
        correction: None,
        largest_neutral: 1.0,
        black: 512,
        white: 16383,
        bits: 14,
        saturation: 16000,
        daylight: ColourCalibration { from_xyz: [[1.0; 3]; 3], to_xyz_d50: [[1.0; 3]; 3] },
        tungsten: None,
        neutral: [0.5, 1.0, 0.75],
        noise: [1e-4, 1e-7],
    };

    #[test]
    fn every_code_survives_its_value() {
        for (black, white) in [(0, 1), (512, 16383), (2048, 65535), (0, 65535), (65533, 65535)] {
            let format = RawFormat { black, white, ..RGGB };
            for code in (0..=white).step_by(1 + usize::from(white) / 20_000) {
                let value = (f64::from(code) - f64::from(black)) / f64::from(white - black);
                assert_eq!(format.code(value as f32), code, "{black} to {white}");
            }
        }
        let odd = [f32::NAN, f32::NEG_INFINITY, f32::INFINITY, -7.0, 7.0].map(|v| RGGB.code(v));
        assert_eq!(odd, [0, 0, 16383, 0, 16383]);
    }

    #[test]
    fn a_crop_keeps_the_filters_of_its_pixels() {
        // Green and blue, red and green: rows and columns differ.
        let gbrg = RawFormat { filters: [1, 2, 0, 1], ..RGGB };
        assert_eq!(gbrg.filters_from([0, 0]), [1, 2, 0, 1]);
        assert_eq!(gbrg.filters_from([1, 0]), [2, 1, 1, 0]);
        assert_eq!(gbrg.filters_from([4, 3]), [0, 1, 1, 2]);
        assert_eq!(gbrg.filters_from([7, 5]), [1, 0, 2, 1]);
    }
}
