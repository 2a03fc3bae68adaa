//! Description of a sensor for raw files.

use glam::{DMat3, DVec3};

use petzval_image::{ColourCalibration, RawCamera, RawFormat};
use petzval_spectrum::{CameraSensor, D50, Primaries, Spectrum, adapt, d65, named_spectrum};

use super::{BASE_ISO, Bayer, Sensor};

/// White of illuminant A (X, Y, Z; CIE 15:2004, table T.3).
const WHITE_A: [f64; 3] = [1.0985, 1.0, 0.355_85];

impl Sensor {
    /// Returns the description of the readings behind a mosaic, of this measured camera or of a sensor whose
    /// channels are linear sRGB.
    pub(crate) fn raw_format(&self, bayer: Bayer, camera: Option<&CameraSensor>) -> RawFormat {
        let (black, white) = (self.black_level, self.max_code());
        // Below the base speed, the full well comes first.
        let share = (self.iso / BASE_ISO).min(1.0);
        let full = f64::from(black) + self.code_span() * share * self.hdr;
        let saturation = full.round().max(f64::from(black) + 1.0);
        let last = f64::from(white).max(saturation);
        let electrons = self.white_electrons();
        let dark = self.reading_noise(0.0).variance();
        let side = if bayer.is_quad() { 2 } else { 1 };
        let white_light = self.filters.map_or([1.0; 3], |filters| filters.white());
        let neutral = self.in_mosaic(bayer, white_light);
        let largest = neutral.into_iter().fold(0.0, f64::max);
        let mixed = |colours: ColourCalibration, white: [f64; 3]| {
            with_crosstalk(&colours, &self.crosstalk.of_mosaic(bayer), white)
        };
        RawFormat {
            camera: match camera {
                None => RawCamera::LinearSrgb,
                Some(camera) => camera.name().map_or(RawCamera::Own, RawCamera::Known),
            },
            filters: [[0, 0], [1, 0], [0, 1], [1, 1]]
                .map(|pixel| bayer.channel(pixel.map(|at| at * side)) as u8),
            filter_side: side,
            correction: None,
            black: black as u16,
            white: white as u16,
            saturation: saturation as u16,
            bits: (last + 1.0).log2().ceil() as u32,
            daylight: mixed(
                camera.map_or_else(linear_srgb, |camera| calibration(camera, &d65())),
                Primaries::SRGB.white_xyz().to_array(),
            ),
            tungsten: camera
                .zip(named_spectrum("stdillum-A"))
                .map(|(camera, tungsten)| mixed(calibration(camera, &tungsten), WHITE_A)),
            neutral: neutral.map(|channel| channel / largest),
            largest_neutral: largest,
            noise: [1.0 / electrons, dark / (electrons * electrons)],
        }
    }
}

fn calibration(camera: &CameraSensor, illuminant: &Spectrum) -> ColourCalibration {
    ColourCalibration {
        from_xyz: camera.colour_matrix(illuminant),
        to_xyz_d50: camera.forward_matrix(illuminant),
    }
}

/// Returns the colours of even surfaces whose channels crosstalk has mixed by a matrix, in rows. `white` is that of the
/// calibration's light.
fn with_crosstalk(
    colours: &ColourCalibration,
    mix: &[[f64; 3]; 3],
    white: [f64; 3],
) -> ColourCalibration {
    let matrix = |rows: &[[f64; 3]; 3]| DMat3::from_cols_array_2d(rows).transpose();
    let rows = |matrix: DMat3| matrix.transpose().to_cols_array_2d();
    let mix = matrix(mix);
    if mix == DMat3::IDENTITY {
        return *colours;
    }
    let from_xyz = matrix(&colours.from_xyz);
    let neutral = from_xyz * DVec3::from_array(white);
    // Forward matrices are for channels relative to those of white.
    let to_neutral = DMat3::from_diagonal(neutral.recip());
    let mixed = DMat3::from_diagonal(mix * neutral);
    ColourCalibration {
        from_xyz: rows(mix * from_xyz),
        to_xyz_d50: rows(matrix(&colours.to_xyz_d50) * to_neutral * mix.inverse() * mixed),
    }
}

/// Returns the colours of a sensor whose channels are linear sRGB.
fn linear_srgb() -> ColourCalibration {
    let to_xyz = Primaries::SRGB.to_xyz();
    let d50 = Primaries { white: D50, ..Primaries::SRGB }.white_xyz();
    let adapted = adapt(Primaries::SRGB.white_xyz(), d50) * to_xyz;
    let rows = |matrix: DMat3| matrix.transpose().to_cols_array_2d();
    ColourCalibration { from_xyz: rows(to_xyz.inverse()), to_xyz_d50: rows(adapted) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::SensorSettings;

    fn raw(settings: &str) -> RawFormat {
        let settings: SensorSettings = settings.parse().unwrap();
        settings.sensor(100.0, 6.0, 0.0).raw_format(settings.bayer.unwrap_or_default(), None)
    }

    #[test]
    fn a_full_well_below_white_is_the_saturation() {
        let base = raw("iso=100,bits=12,black=64");
        assert_eq!([base.black, base.white, base.saturation], [64, 4095, 4095]);
        let slow = raw("iso=50,bits=12,black=64");
        assert_eq!([slow.white, slow.saturation], [4095, 64 + 4031_u16.div_ceil(2)]);
        for well in 1..500 {
            let base = raw(&format!("iso=100,well={}", 977 * well));
            assert_eq!(base.saturation, 16383, "{well}");
        }
        let fast = raw("iso=1600,bits=16,black=0");
        assert_eq!([fast.black, fast.white, fast.saturation], [0, 65535, 65535]);
        assert_eq!(raw("iso=1,bits=2,black=2").saturation, 3);
    }

    #[test]
    fn the_noise_is_that_of_the_electrons() {
        let found = raw("iso=400,well=40000,read=3,dsnu=4,dark=10,time=2,bits=16,black=0").noise;
        let white: f64 = 10_000.0;
        let step = white / 65535.0;
        let dark = (20.0 + 9.0 + 16.0 + step * step / 12.0) / (white * white);
        assert!((found[0] * white - 1.0).abs() < 1e-12 && (found[1] / dark - 1.0).abs() < 1e-12);
    }

    #[test]
    fn colours_undo_the_crosstalk_of_even_surfaces() {
        let plain = raw("bayer=rggb");
        assert_eq!(plain.largest_neutral, 1.0);
        let leaky = raw("bayer=rggb,crosstalk=20/10/5");
        let rows = |m: [[f64; 3]; 3]| DMat3::from_cols_array_2d(&m).transpose();
        for colour in [[1.0, 1.0, 1.0], [0.8, 0.2, 0.1], [0.05, 0.3, 0.9]] {
            let [r, g, b] = colour;
            let light = DVec3::from_array(colour);
            let seen =
                DVec3::new(0.8 * r + 0.1 * g, 0.1 * r + 0.9 * g + 0.025 * b, 0.95 * b + 0.1 * g);
            let white = DVec3::from_array(leaky.neutral);
            // Converters balance by AsShotNeutral, of which the largest channel is 1.
            let balanced = seen / (white * leaky.largest_neutral);
            let found = rows(leaky.daylight.to_xyz_d50) * balanced;
            let expected = rows(plain.daylight.to_xyz_d50) * light;
            assert!(found.abs_diff_eq(expected, 1e-4), "{colour:?}: {found}, not {expected}");
            let xyz = rows(plain.daylight.from_xyz).inverse() * light;
            assert!((rows(leaky.daylight.from_xyz) * xyz).abs_diff_eq(seen, 1e-9));
        }
    }

    #[test]
    fn filters_stand_in_reading_order() {
        assert_eq!(raw("bayer=gbrg").filters, [1, 2, 0, 1]);
        assert_eq!(raw("bayer=bggr").filters, [2, 1, 1, 0]);
        let quad = raw("bayer=quad-gbrg");
        assert_eq!((quad.filters, quad.filter_side), ([1, 2, 0, 1], 2));
    }
}
