//! Description of a sensor for raw files.

use glam::DMat3;

use petzval_image::{ColourCalibration, RawCamera, RawFormat};
use petzval_spectrum::{CameraSensor, D50, Primaries, Spectrum, adapt, d65, named_spectrum};

use super::{BASE_ISO, Bayer, Sensor};

impl Sensor {
    /// Returns the description of the readings behind a mosaic, of this measured camera or of a sensor whose
    /// channels are linear sRGB.
    pub(crate) fn raw_format(&self, bayer: Bayer, camera: Option<&CameraSensor>) -> RawFormat {
        let (black, white) = (self.black_level, self.max_code());
        // Below the base speed, the full well comes first.
        let full = f64::from(black) + self.code_span() * self.iso / BASE_ISO;
        let saturation = full.round().clamp(f64::from(black) + 1.0, f64::from(white));
        let electrons = self.white_electrons();
        let dark = self.reading_noise(0.0).variance();
        RawFormat {
            camera: match camera {
                None => RawCamera::LinearSrgb,
                Some(camera) => camera.name().map_or(RawCamera::Own, RawCamera::Known),
            },
            filters: [[0, 0], [1, 0], [0, 1], [1, 1]].map(|pixel| bayer.channel(pixel) as u8),
            black: black as u16,
            white: white as u16,
            saturation: saturation as u16,
            daylight: camera.map_or_else(linear_srgb, |camera| calibration(camera, &d65())),
            tungsten: camera
                .zip(named_spectrum("stdillum-A"))
                .map(|(camera, tungsten)| calibration(camera, &tungsten)),
            neutral: self.filters.map_or([1.0; 3], |filters| filters.white()),
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
    fn filters_stand_in_reading_order() {
        assert_eq!(raw("bayer=gbrg").filters, [1, 2, 0, 1]);
        assert_eq!(raw("bayer=bggr").filters, [2, 1, 1, 0]);
    }
}
