//! Sensors of measured cameras, as 3 x 3 matrices of linear sRGB.

use std::sync::Arc;

use glam::{DMat3, DVec3};

use super::camera_matrices::{fit, xyz_from_channels};
use super::camera_tables::{CAMERAS, FIRST_WAVELENGTH, STEP};
use super::colour_space::{ColourSpace, srgb_from_xyz};
use super::observer::{VISIBLE, colour_matching};
use super::wavelength_sets::daylight_in_bands;
use super::{Spectrum, UnorderedWavelengths, d_illuminant, d65};

/// Colour temperature of the daylight that a camera makes white, unless the scene says another (K).
const DEFAULT_WHITE: f64 = 6500.0;

/// Smallest [`independence`] of the channels of a camera with three colours.
const MIN_INDEPENDENCE: f64 = 1e-3;

/// A camera whose spectral response has been measured.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraSensor(Table);

#[derive(Clone, Debug, PartialEq)]
enum Table {
    /// Number of a camera of [`CAMERAS`].
    Known(usize),
    /// A camera of one's own: its responses by whole nanometres. The largest is 1.
    Own(Arc<Sensitivities>),
}

/// Error of a table of responses that are not those of a colour camera.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CameraTableError {
    /// The wavelengths do not ascend.
    #[error(transparent)]
    Unordered(#[from] UnorderedWavelengths),
    /// No light that the table can see reaches a channel.
    #[error("no response of the {channel} channel to visible light")]
    Blind {
        /// The name of the channel.
        channel: &'static str,
    },
    /// The channels do not distinguish three colours.
    #[error("channels that do not tell three colours apart")]
    Dependent,
}

/// The response of a camera in matrices.
///
/// The renderer carries linear sRGB, not spectra. [`Self::from_srgb`] is the linear map that comes
/// nearest to the camera's response to smooth spectra of a colour in daylight, and exact for white.
/// pbrt-v4 evaluates the response by wavelength. Over the colours of the sRGB cube, the difference
/// has a root mean square of 0.01 to 0.02 of white and a maximum of 0.04 to 0.07, in saturated
/// colours. Greys differ by at most 0.005.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraResponse {
    /// Matrix from linear sRGB to the channels of the camera.
    pub from_srgb: DMat3,
    /// Matrix from the channels of the camera to X, Y and Z.
    pub to_xyz: DMat3,
}

impl CameraResponse {
    /// Returns the matrix from linear sRGB to linear sRGB as the camera sees it.
    pub fn to_srgb(&self) -> DMat3 {
        let [x, y, z] = (self.to_xyz * self.from_srgb).to_cols_array_2d();
        DMat3::from_cols_array_2d(&[srgb_from_xyz(x), srgb_from_xyz(y), srgb_from_xyz(z)])
    }
}

/// A quantity by whole nanometres of [`VISIBLE`].
pub(super) type Samples = Vec<f64>;

/// Three sensitivities.
pub(super) type Sensitivities = [Samples; 3];

impl CameraSensor {
    /// Returns the camera of a name, in pbrt-v4's spelling.
    pub fn from_name(name: &str) -> Option<Self> {
        let number = CAMERAS.iter().position(|(known, _)| *known == name);
        number.map(|number| Self(Table::Known(number)))
    }

    /// Creates the camera of a table: rows of a wavelength (nm) and the responses of red, green and
    /// blue, 0 or more. They are linear between the rows and 0 beyond. Their unit does not matter: they
    /// are divided by the largest.
    ///
    /// # Errors
    /// Returns an error if the wavelengths do not ascend, or the channels are not those of a camera that
    /// sees three colours.
    pub fn from_table(rows: &[[f64; 4]]) -> Result<Self, CameraTableError> {
        let sample = |channel: usize| -> Result<Samples, UnorderedWavelengths> {
            let pairs = rows.iter().map(|row| [row[0], row[1 + channel]]).collect();
            let spectrum = Spectrum::samples(pairs)?;
            Ok(nanometres().map(|nm| spectrum.at(nm)).collect())
        };
        let mut channels: Sensitivities = [sample(0)?, sample(1)?, sample(2)?];
        for (samples, channel) in channels.iter().zip(["red", "green", "blue"]) {
            if !samples.iter().any(|&response| response > 0.0) {
                return Err(CameraTableError::Blind { channel });
            }
        }
        let largest = channels.iter().flatten().copied().fold(0.0, f64::max);
        channels.iter_mut().flatten().for_each(|response| *response /= largest);
        match independence(&channels) > MIN_INDEPENDENCE {
            true => Ok(Self(Table::Own(Arc::new(channels)))),
            false => Err(CameraTableError::Dependent),
        }
    }

    /// Returns the name of the camera; `None` for a table of the user.
    pub fn name(&self) -> Option<&'static str> {
        match &self.0 {
            Table::Known(number) => Some(CAMERAS[*number].0),
            Table::Own(_) => None,
        }
    }

    /// Returns the names of all cameras.
    pub fn names() -> impl Iterator<Item = &'static str> {
        CAMERAS.iter().map(|(name, _)| *name)
    }

    /// Returns the response of the camera, whose white balance makes daylight of a temperature (K),
    /// 6500 by default, the white of a colour space.
    ///
    /// As in pbrt-v4, the matrix to X, Y and Z is a linear fit: the channels of the camera for
    /// reflectances in that daylight, to the X, Y and Z of the same reflectances in the white of
    /// the space.
    pub fn response(&self, white: Option<f64>, space: ColourSpace) -> CameraResponse {
        let camera = self.sensitivities();
        let scene = d_illuminant(white.unwrap_or(DEFAULT_WHITE));
        // Both have the same response to the scene's white in their second channel.
        let [green, luminance] =
            [&camera[1], &observer()[1]].map(|c| integral(&by_nanometre(&scene), c));
        let to_xyz = xyz_from_channels(&camera, &scene, &space.illuminant()) * (luminance / green);
        CameraResponse { from_srgb: from_srgb(&camera), to_xyz }
    }

    /// Returns the response of the channels to the daylight in each band, in the unit of
    /// [`CameraResponse::from_srgb`].
    pub fn band_responses(&self) -> [Vec<f64>; 3] {
        self.sensitivities()
            .map(|channel| daylight_in_bands(|nm| channel[(nm - f64::from(VISIBLE[0])) as usize]))
    }

    pub(super) fn sensitivities(&self) -> Sensitivities {
        match &self.0 {
            Table::Known(number) => {
                let (_, channels) = &CAMERAS[*number];
                [0, 1, 2].map(|channel| tabulated(&channels[channel], 1e-4))
            }
            Table::Own(channels) => (**channels).clone(),
        }
    }
}

/// Returns how well channels distinguish colours: the determinant of their matrix from linear sRGB, relative to
/// the product of their responses to white; 0 if they are dependent.
fn independence(channels: &Sensitivities) -> f64 {
    let matrix = from_srgb(channels);
    let white = (matrix * DVec3::ONE).to_array();
    matrix.determinant().abs() / white.into_iter().product::<f64>()
}

/// Returns the matrix from linear sRGB to a camera's channels: the linear fit over edges and bands
/// of several places and widths in daylight (D65), in both signs, with the exact response to white.
fn from_srgb(camera: &Sensitivities) -> DMat3 {
    let daylight: Samples = nanometres().map(|nm| d65().at(nm)).collect();
    let observer = observer();
    let luminance = integral(&daylight, &observer[1]);
    let respond = |light: &Samples| {
        let xyz = (response_to(&observer, light) / luminance).to_array();
        (DVec3::from_array(srgb_from_xyz(xyz)), response_to(camera, light) / luminance)
    };
    let smooth_step = |x: f64| 0.5 + x / (2.0 * x.hypot(1.0));
    let (places, widths) = ([440.0, 490.0, 540.0, 590.0, 640.0], [20.0, 60.0]);
    let mut pairs = Vec::new();
    for place in places {
        for width in widths {
            let half_band: f64 = 50.0;
            let edge = |nm: f64| smooth_step((nm - place) / width);
            let band = |nm: f64| {
                let inside = half_band.powi(2) - (nm - place).powi(2);
                smooth_step(inside / (2.0 * half_band * width))
            };
            let shapes: [&dyn Fn(f64) -> f64; 2] = [&edge, &band];
            for shape in shapes {
                let light = |sign: &dyn Fn(f64) -> f64| {
                    nanometres().zip(&daylight).map(|(nm, day)| sign(shape(nm)) * day).collect()
                };
                pairs.push(respond(&light(&|share| share)));
                pairs.push(respond(&light(&|share| 1.0 - share)));
            }
        }
    }
    fit(pairs.into_iter(), Some(respond(&daylight)))
}

pub(super) fn by_nanometre(spectrum: &Spectrum) -> Samples {
    nanometres().map(|nm| spectrum.at(nm)).collect()
}

pub(super) fn nanometres() -> impl Iterator<Item = f64> {
    (VISIBLE[0]..=VISIBLE[1]).map(f64::from)
}

pub(super) fn observer() -> Sensitivities {
    [0, 1, 2].map(|i| nanometres().map(|nm| colour_matching(nm)[i]).collect())
}

/// Returns the entries of a table times a factor: linear between them, 0 beyond.
pub(super) fn tabulated(entries: &[u16], factor: f64) -> Samples {
    let value = |nm: f64| {
        let x = (nm - f64::from(FIRST_WAVELENGTH)) / f64::from(STEP);
        let below = x.floor();
        let at = |i: f64| match entries.get(i as usize) {
            Some(&entry) if i >= 0.0 => f64::from(entry) * factor,
            _ => 0.0,
        };
        let fraction = x - below;
        let inside = x >= 0.0 && x <= (entries.len() - 1) as f64;
        if inside { at(below) + fraction * (at(below + 1.0) - at(below)) } else { 0.0 }
    };
    nanometres().map(value).collect()
}

pub(super) fn product(a: &Samples, b: &Samples) -> Samples {
    a.iter().zip(b).map(|(a, b)| a * b).collect()
}

pub(super) fn integral(a: &Samples, b: &Samples) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

pub(super) fn response_to(channels: &Sensitivities, light: &Samples) -> DVec3 {
    DVec3::from_array([0, 1, 2].map(|i| integral(&channels[i], light)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Output of pbrt-v4 for a white sky of radiance 1, `maxcomponentvalue` unset.
    const WHITE: [(&str, [f64; 3]); 3] = [
        ("canon_eos_100d", [0.9883, 0.9916, 0.9969]),
        ("nikon_d850", [0.9843, 0.9954, 0.9829]),
        ("sony_ilce_9", [0.9946, 0.9904, 1.0096]),
    ];

    #[test]
    fn white_is_that_of_pbrt() {
        for (name, expected) in WHITE {
            let response = CameraSensor::from_name(name).unwrap().response(None, ColourSpace::Srgb);
            let found = response.to_srgb() * DVec3::ONE;
            assert!(found.abs_diff_eq(DVec3::from_array(expected), 0.006), "{name}: {found}");
        }
    }

    #[test]
    fn every_camera_sees_colours_nearly_as_they_are() {
        for name in CameraSensor::names() {
            let camera = CameraSensor::from_name(name).unwrap();
            for space in [ColourSpace::Srgb, ColourSpace::Aces2065] {
                let matrix = camera.response(None, space).to_srgb();
                for colour in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::ONE] {
                    let off = (matrix * colour - colour).abs().max_element();
                    // White becomes the white of ACES, which is redder.
                    let bound = if space == ColourSpace::Srgb { 0.1 } else { 0.2 };
                    assert!(off < bound, "{name}: {colour} becomes {}", matrix * colour);
                }
            }
        }
    }

    #[test]
    fn a_table_of_any_unit_is_the_camera_that_it_describes() {
        let (name, channels) = &CAMERAS[4];
        let rows = |unit: f64| -> Vec<[f64; 4]> {
            let row = |i: usize| {
                let [red, green, blue] = [0, 1, 2].map(|c| unit * f64::from(channels[c][i]));
                [f64::from(FIRST_WAVELENGTH + STEP * i as u32), red, green, blue]
            };
            (0..channels[0].len()).map(row).collect()
        };
        let known = CameraSensor::from_name(name).unwrap();
        for unit in [1e-4, 2.5e-5, 7.0] {
            let own = CameraSensor::from_table(&rows(unit)).unwrap();
            let largest = channels.iter().flatten().max().copied().unwrap();
            let scale = 1e4 / f64::from(largest);
            for white in [None, Some(3200.0)] {
                let [own, known] =
                    [&own, &known].map(|camera| camera.response(white, ColourSpace::Srgb));
                assert!(own.from_srgb.abs_diff_eq(known.from_srgb * scale, 1e-9));
                assert!(own.to_srgb().abs_diff_eq(known.to_srgb(), 1e-9), "the same picture");
            }
            for (own, known) in own.band_responses().iter().zip(&known.band_responses()) {
                let off = own.iter().zip(known).map(|(own, known)| (own - scale * known).abs());
                assert!(off.fold(0.0, f64::max) < 1e-12);
            }
        }
    }

    #[test]
    fn the_channels_of_known_cameras_are_independent() {
        for name in CameraSensor::names() {
            let camera = CameraSensor::from_name(name).unwrap();
            let found = independence(&camera.sensitivities());
            assert!(found > 100.0 * MIN_INDEPENDENCE, "{name}: {found}");
        }
    }

    #[test]
    fn a_table_without_three_colours_is_refused() {
        let table = |rows: [[f64; 4]; 3]| CameraSensor::from_table(&rows).unwrap_err();
        let grey = [[400.0, 1.0, 2.0, 1.0], [500.0, 1.0, 2.0, 2.0], [600.0, 1.0, 2.0, 1.0]];
        assert_eq!(table(grey), CameraTableError::Dependent);
        let blind = [[400.0, 1.0, 0.0, 1.0], [500.0, 1.0, 0.0, 2.0], [600.0, 2.0, 0.0, 1.0]];
        assert_eq!(table(blind), CameraTableError::Blind { channel: "green" });
        let [first, second, third] = grey;
        let disorder = UnorderedWavelengths { before: 500.0, after: 400.0 };
        assert_eq!(table([second, first, third]), disorder.into());
    }

    #[test]
    fn the_white_of_a_space_is_that_of_its_illuminant() {
        let camera = CameraSensor::from_name("canon_eos_m").unwrap();
        let matrix = camera.response(None, ColourSpace::Aces2065).to_srgb();
        let found = matrix * DVec3::ONE;
        let aces = DVec3::from_array(ColourSpace::Aces2065.light([1.0; 3]));
        assert!((found / found.y).abs_diff_eq(aces / aces.y, 0.02), "{found}, expected {aces}");
    }
}
