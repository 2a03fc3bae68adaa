//! Colours of a scene file: linear sRGB, and the spectrum that they stand for.

use std::sync::{Arc, LazyLock};

use super::{BandSpectrum, uplift_unbounded};

/// A colour, and the spectrum that it stands for.
///
/// The spectrum is split into bands when it is first asked for: pictures in RGB do not pay for it.
#[derive(Clone, Debug)]
pub struct Colour {
    /// Linear sRGB.
    pub rgb: [f32; 3],
    /// Values by wavelength, those of a light relative to daylight; `None` if only RGB is known.
    spectrum: Option<Arc<LazySpectrum>>,
}

type LazySpectrum = LazyLock<BandSpectrum, Box<dyn FnOnce() -> BandSpectrum + Send>>;

impl From<[f32; 3]> for Colour {
    fn from(rgb: [f32; 3]) -> Self {
        Self { rgb, spectrum: None }
    }
}

impl Colour {
    /// A colour of a known spectrum, which a function splits into bands.
    pub fn new(rgb: [f32; 3], spectrum: impl FnOnce() -> BandSpectrum + Send + 'static) -> Self {
        Self { rgb, spectrum: Some(Arc::new(LazyLock::new(Box::new(spectrum)))) }
    }

    /// Returns the values by wavelength, those of a light relative to daylight, if they are known.
    pub fn spectrum(&self) -> Option<&BandSpectrum> {
        self.spectrum.as_ref().map(|spectrum| &***spectrum)
    }

    /// Returns whether the spectrum is known.
    pub fn has_spectrum(&self) -> bool {
        self.spectrum.is_some()
    }

    /// The colour times a factor by channel. A factor that is not grey counts as the reflectance of
    /// that colour.
    pub fn scaled(&self, factor: [f32; 3]) -> Self {
        let rgb = [0, 1, 2].map(|c| self.rgb[c] * factor[c]);
        self.with_changed_spectrum(rgb, move |spectrum| match factor {
            [r, g, b] if r == g && g == b => spectrum.scaled(r),
            _ => spectrum.times(&uplift_unbounded(factor)),
        })
    }

    /// The colour divided by a number.
    pub fn divided(&self, by: f32) -> Self {
        self.with_changed_spectrum(self.rgb.map(|c| c / by), move |s| s.scaled(1.0 / by))
    }

    /// Returns the values by wavelength of a quantity without an upper limit; those of a smooth spectrum
    /// if only RGB is known.
    pub fn unbounded_spectrum(&self) -> BandSpectrum {
        self.spectrum().cloned().unwrap_or_else(|| uplift_unbounded(self.rgb))
    }

    /// The colour as a light, whose spectrum is known: one made of its RGB if none is given.
    #[must_use]
    pub fn into_light(self) -> Self {
        let rgb = self.rgb;
        if self.has_spectrum() { self } else { Self::new(rgb, move || uplift_unbounded(rgb)) }
    }

    fn with_changed_spectrum(
        &self,
        rgb: [f32; 3],
        change: impl FnOnce(&BandSpectrum) -> BandSpectrum + Send + 'static,
    ) -> Self {
        match self.spectrum.clone() {
            None => rgb.into(),
            Some(spectrum) => Self::new(rgb, move || change(&spectrum)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_factor_scales_both_the_colour_and_its_spectrum() {
        let lamp = Colour::new([1.0, 0.5, 0.25], || uplift_unbounded([1.0, 0.5, 0.25]));
        for factor in [[3.0; 3], [1.0, 0.5, 0.2]] {
            let scaled = lamp.scaled(factor);
            let rgb = scaled.spectrum().expect("it is known").to_rgb();
            assert_eq!(scaled.rgb, [0, 1, 2].map(|c| lamp.rgb[c] * factor[c]));
            assert!((rgb[0] / f64::from(scaled.rgb[0]) - 1.0).abs() < 0.1, "{rgb:?}");
        }
        let half = lamp.divided(2.0);
        let rgb = half.spectrum().expect("it is known").to_rgb();
        assert!(half.rgb == [0.5, 0.25, 0.125] && (rgb[0] - 0.5).abs() < 2e-3, "{rgb:?}");
    }

    #[test]
    fn a_light_without_a_spectrum_gets_one_of_its_colour() {
        let light = Colour::from([4.0, 2.0, 0.5]).into_light();
        for (found, wanted) in
            light.spectrum().expect("one is made").to_rgb().into_iter().zip(light.rgb)
        {
            assert!((found - f64::from(wanted)).abs() < 1e-2, "{found} for {wanted}");
        }
    }

    #[test]
    fn a_spectrum_is_not_split_before_it_is_asked_for() {
        let colour = Colour::new([1.0; 3], || panic!("nobody asked for it"));
        assert!(colour.scaled([2.0; 3]).divided(3.0).into_light().has_spectrum());
    }
}
