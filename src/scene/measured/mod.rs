//! Measured reflection of a surface (Dupuy & Jakob 2018, "An adaptive parameterization for efficient
//! material acquisition and rendering"), the `.bsdf` files of the RGL's material database.

mod spectra;
mod tensor;
mod warp;

use std::f32::consts::PI;
use std::sync::Arc;

use spectra::MeasuredSpectra;
use tensor::{Tensor, TensorFile};
use warp::{Grid, Warp, Warped};

use petzval_spectrum::BandSpectrum;

/// Table of the reflection of a measured surface.
///
/// `theta` and `phi` are the spherical coordinates of the direction to the viewer in the shading
/// frame. Microfacet normals are points of the unit square: the square root of their angle from the
/// normal over 90 degrees, and their azimuth, for isotropic surfaces relative to the viewer.
#[derive(Clone, Debug)]
pub struct MeasuredSurface {
    directions: Arc<MeasuredDirections>,
    /// Reflection in linear sRGB, or at the wavelengths of a set, over the uniform points of the visible
    /// normals, relative to a surface of microfacets that reflect all light.
    colour: Arc<Grid>,
    /// The same by wavelength, if it is known.
    spectra: Option<Arc<MeasuredSpectra>>,
}

/// Microfacets of a measured surface, and directions of the light that it reflects.
#[derive(Debug)]
struct MeasuredDirections {
    isotropic: bool,
    /// Density of the microfacet normals.
    normals: Grid,
    /// Projected area of the microfacets by the direction to the viewer.
    projected_area: Grid,
    /// Density of the visible normals.
    visible: Warp,
    /// Density of the brightness over the uniform points of `visible`.
    brightness: Warp,
}

/// A microfacet normal that was sampled.
#[derive(Clone, Copy, Debug)]
pub struct MeasuredSample {
    /// Unit square of the normal.
    normal: [f32; 2],
    /// Uniform point of the visible normals.
    uniform: [f32; 2],
    /// Density by the area of the unit square of normals.
    density: f32,
}

/// The point of the unit square of an angle from the normal and an azimuth.
fn to_square(theta: f32, phi: f32) -> [f32; 2] {
    let turn = phi / (2.0 * PI) + 0.5;
    [(theta * (2.0 / PI)).max(0.0).sqrt(), turn]
}

impl MeasuredSurface {
    /// Reads a `.bsdf` file, with `spectra` over `wavelengths` or with `rgb` in linear sRGB.
    ///
    /// # Errors
    /// Returns the fault of a file that is not of this kind.
    pub fn read(bytes: &[u8]) -> Result<Self, String> {
        let file = TensorFile::new(bytes)?;
        let [theta, phi] = [file.floats("theta_i", 1)?, file.floats("phi_i", 1)?];
        for (name, list) in [("theta_i", &theta.values), ("phi_i", &phi.values)] {
            if !list.is_sorted_by(|a, b| a < b) {
                return Err(format!("\"{name}\" does not ascend"));
            }
        }
        let parameters = [phi.values, theta.values];
        let none = || [vec![0.0], vec![0.0]];
        let warp = |name: &str| {
            let tensor = file.floats(name, 4)?;
            let grid = grid(name, tensor, parameters.clone(), 1)?;
            if grid.values.iter().any(|&value| value < 0.0) {
                return Err(format!("the field \"{name}\" has a value below 0"));
            }
            Warp::new(grid).ok_or_else(|| format!("the field \"{name}\" has a slice of zeros"))
        };
        let (colour, spectra) = match file.has("spectra") {
            true => {
                let wavelengths = file.floats("wavelengths", 1)?.values;
                if !wavelengths.is_sorted_by(|a, b| a < b) {
                    return Err("\"wavelengths\" does not ascend".to_owned());
                }
                let tensor = file.floats("spectra", 5)?;
                let spectra = grid("spectra", tensor, parameters.clone(), wavelengths.len())?;
                let spectra = MeasuredSpectra::new(&wavelengths, spectra);
                (spectra.to_srgb(), Some(Arc::new(spectra)))
            }
            false => (grid("rgb", file.floats("rgb", 5)?, parameters.clone(), 3)?, None),
        };
        let isotropic = parameters[0].len() <= 2;
        if let ([first, .., last], false) = (&parameters[0][..], isotropic)
            && (2.0 * PI / (last - first)).round() != 1.0
        {
            return Err(format!("azimuths from {first} to {last}, a part of the circle"));
        }
        let directions = MeasuredDirections {
            isotropic,
            normals: grid("ndf", file.floats("ndf", 2)?, none(), 1)?,
            projected_area: grid("sigma", file.floats("sigma", 2)?, none(), 1)?,
            visible: warp("vndf")?,
            brightness: warp("luminance")?,
        };
        Ok(Self { directions: Arc::new(directions), colour: Arc::new(colour), spectra })
    }

    /// Returns the mean spectrum of its table; `None` if the file has none.
    pub(super) fn mean_spectrum(&self) -> Option<BandSpectrum> {
        self.spectra.as_ref().map(|spectra| spectra.mean())
    }

    /// Returns whether its reflection is known by wavelength.
    pub(super) fn has_spectra(&self) -> bool {
        self.spectra.is_some()
    }

    /// Returns the surface in linear sRGB alone.
    pub(super) fn in_rgb(&self) -> Self {
        Self { spectra: None, ..self.clone() }
    }

    /// Returns the surface at the wavelengths of a set; `None` if it is known in linear sRGB alone.
    pub(super) fn in_set(&self, set: usize) -> Option<Self> {
        let colour = self.spectra.as_ref()?.in_set(set);
        Some(Self { colour, spectra: None, ..self.clone() })
    }

    /// Returns the memory of its reflection at the wavelengths of all sets (bytes).
    pub(super) fn bytes_of_sets(&self) -> usize {
        self.spectra.as_ref().map_or(0, |spectra| spectra.bytes_of_sets())
    }

    /// Returns the microfacet normal to a viewer, as angle from the surface's normal and azimuth,
    /// from two uniform numbers.
    pub fn sample(&self, viewer: [f32; 2], u: [f32; 2]) -> ([f32; 2], MeasuredSample) {
        let parameters = [viewer[1], viewer[0]];
        let bright = self.directions.brightness.sample(u, parameters);
        let visible = self.directions.visible.sample(bright.uv, parameters);
        let [x, y] = visible.uv;
        let azimuth =
            (2.0 * y - 1.0) * PI + if self.directions.isotropic { viewer[1] } else { 0.0 };
        let sample = MeasuredSample {
            normal: visible.uv,
            uniform: bright.uv,
            density: bright.density * visible.density,
        };
        ([x * x * (PI / 2.0), azimuth], sample)
    }

    /// Returns a microfacet normal, as [`Self::sample`] would have sampled it for a viewer.
    pub fn sample_of(&self, viewer: [f32; 2], normal: [f32; 2]) -> MeasuredSample {
        let parameters = [viewer[1], viewer[0]];
        let azimuth = normal[1] - if self.directions.isotropic { viewer[1] } else { 0.0 };
        let [x, y] = to_square(normal[0], azimuth);
        let normal = [x, y - y.floor()];
        let Warped { uv, density } = self.directions.visible.invert(normal, parameters);
        let bright = self.directions.brightness.at(uv, parameters);
        MeasuredSample { normal, uniform: uv, density: density * bright }
    }

    /// Returns the reflected colour: f |cos wi| of the BRDF f.
    pub fn reflected(&self, viewer: [f32; 2], sample: &MeasuredSample) -> [f32; 3] {
        let none = [0.0; 2];
        let area = self.directions.projected_area.at(to_square(viewer[0], viewer[1]), none, 0);
        let factor = self.directions.normals.at(sample.normal, none, 0) / (4.0 * area);
        let parameters = [viewer[1], viewer[0]];
        [0, 1, 2].map(|channel| {
            let value = self.colour.at(sample.uniform, parameters, channel).max(0.0) * factor;
            if value.is_finite() { value } else { 0.0 }
        })
    }
}

impl MeasuredSample {
    /// Returns the density by solid angle of the mirrored directions, given the cosine between the
    /// viewer and the normal, and the sine of the normal's angle.
    pub fn density(&self, cosine: f32, sine: f32) -> f32 {
        // The area of the square per solid angle of normals, and of those per that of directions.
        let area = (2.0 * PI * PI * self.normal[0] * sine).max(1e-6);
        let density = self.density / (4.0 * cosine * area);
        if density.is_finite() { density } else { 0.0 }
    }
}

/// Makes a grid of a tensor, whose shape is checked: the parameters, the channels, rows, columns.
fn grid(
    name: &str,
    tensor: Tensor,
    parameters: [Vec<f32>; 2],
    channels: usize,
) -> Result<Grid, String> {
    let Tensor { shape, values } = tensor;
    let lists = parameters.each_ref().map(Vec::len);
    let expected = match shape.len() {
        2 => Vec::new(),
        4 => lists.to_vec(),
        _ => vec![lists[0], lists[1], channels],
    };
    let (lead, size) = shape.split_at(shape.len() - 2);
    match *size {
        [height, width] if lead == expected && width >= 2 && height >= 2 => {
            Ok(Grid { size: [width, height], parameters, channels, values })
        }
        _ => Err(format!("the field \"{name}\" has shape {shape:?}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file() -> Vec<u8> {
        let path = "tests/pbrt_language/isotropic.bsdf";
        std::fs::read(format!("{}/../../{path}", env!("CARGO_MANIFEST_DIR"))).expect(path)
    }

    #[test]
    fn cut_and_foreign_files_are_refused() {
        let whole = file();
        assert!(MeasuredSurface::read(&whole).is_ok());
        for length in (0..whole.len()).step_by(97) {
            assert!(MeasuredSurface::read(&whole[..length]).is_err(), "{length} bytes");
        }
        let fault = MeasuredSurface::read(b"ply\nformat ascii 1.0\n").unwrap_err();
        assert!(fault.contains("tensor_file"), "{fault}");
    }

    #[test]
    fn damaged_files_are_read_or_refused_without_a_panic() {
        let whole = file();
        for at in 0..600 {
            for value in [0, 1, 255] {
                let mut damaged = whole.clone();
                damaged[at] = value;
                if let Ok(surface) = MeasuredSurface::read(&damaged) {
                    let ([theta, _], sample) = surface.sample([0.4, 0.0], [0.3, 0.6]);
                    assert!(theta.is_finite());
                    let _ = surface.reflected([0.4, 0.0], &sample);
                }
            }
        }
    }
}
