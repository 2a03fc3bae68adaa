//! Spectral pictures: layers in the layout of Fichet, Pacanowski & Wilkie 2021, "An OpenEXR Layout for
//! Spectral Images" (JCGT 10(3)), as pbrt-v4 writes them too.

use super::{ImageLayer, Note, Notes};

/// Name of the layer of spectral radiance: the first component of Stokes, that of all light. Its channels are
/// called by wavelengths, such as `S0.374,688nm`.
pub const SPECTRAL_LAYER: &str = "S0";

/// Unit of the channels' names.
const UNIT: &str = "nm";

/// Returns the layer of spectral radiance at some wavelengths (nm), in ascending order. `column` returns the
/// values of all pixels at one of them.
pub fn spectral_layer(wavelengths: &[f64], column: impl Fn(usize) -> Vec<f32>) -> ImageLayer {
    // A point would divide layers.
    let name = |nm: &f64| format!("{nm:.3}{UNIT}").replace('.', ",");
    let channels = wavelengths.iter().enumerate().map(|(i, nm)| (name(nm), column(i)));
    ImageLayer::new(SPECTRAL_LAYER, channels.collect())
}

/// Returns the wavelength of a channel of such a layer (nm).
pub fn channel_wavelength(channel: &str) -> Option<f64> {
    channel.strip_suffix(UNIT)?.replace(',', ".").parse().ok()
}

/// Returns the attributes of a file with such a layer.
pub(super) fn spectral_notes() -> Notes {
    let text = |name, text: &str| (name, Note::Text(text.to_owned()));
    vec![text("spectralLayoutVersion", "1.0"), text("emissiveUnits", "W.m^-2.sr^-1")]
}
