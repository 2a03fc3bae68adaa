//! Colour channels: the bands of white light that they see, and the field of each.

use super::CalibrationSetup;
use super::ray_field::{FieldBand, RayField};
use petzval_spectrum::IndexRangeError;
use petzval_spectrum::{BANDS, LightBand, bands};

/// Bands of white light. Lateral colour is smooth, so that fewer than for pictures do.
pub(super) const COARSE_BANDS: usize = 8;

/// The fields of red, green and blue in white light.
#[derive(Clone, Debug)]
pub struct ChannelFields(pub(super) [RayField; 3]);

/// Returns bands of white light, each the mean of some of those that pictures are made of.
pub(super) fn coarse_bands() -> Vec<LightBand> {
    let (all, merged) = (bands(), BANDS / COARSE_BANDS);
    let mean = |part: &[LightBand]| LightBand {
        wavelength: part.iter().map(|band| band.wavelength).sum::<f64>() / merged as f64,
        response: [0, 1, 2]
            .map(|c| part.iter().map(|band| band.response[c]).sum::<f64>() / merged as f64),
    };
    all.chunks(merged).map(mean).collect()
}

impl CalibrationSetup<'_> {
    /// Returns whether any glass of the lens disperses light.
    pub fn disperses(&self) -> bool {
        self.lens.rows.iter().any(|row| row.glass.disperses())
    }

    /// Traces the fields of the channels in white light; `None` if no glass disperses it. They are
    /// always those of centroid rays.
    ///
    /// # Errors
    /// Returns an error if the data of a glass do not cover visible light.
    pub fn channel_fields(&self) -> Result<Option<ChannelFields>, IndexRangeError> {
        if !self.disperses() {
            return Ok(None);
        }
        let bands = self.checked_bands()?;
        let mut lens = self.real_lens();
        lens.disperse(&bands);
        lens.bound_all_bands();
        let channel = |c: usize| {
            let weights: Vec<f64> = bands.iter().map(|band| band.response[c]).collect();
            self.field(&lens, super::FieldRay::Centroid, FieldBand::Mean(&weights))
        };
        Ok(Some(ChannelFields([0, 1, 2].map(channel))))
    }

    /// Returns the bands of white light, or one band at the primary wavelength if no glass disperses
    /// light.
    pub(super) fn checked_bands(&self) -> Result<Vec<LightBand>, IndexRangeError> {
        if !self.disperses() {
            let wavelength = self.lens.design.primary_wavelength();
            return Ok(vec![LightBand { wavelength, response: [1.0; 3] }]);
        }
        let bands = coarse_bands();
        let [first, last] = [0, bands.len() - 1].map(|i| bands[i].wavelength);
        self.lens.check_wavelengths([first, last])?;
        Ok(bands)
    }
}
