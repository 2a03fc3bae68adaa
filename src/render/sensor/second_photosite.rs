//! A second photosite in each pixel, which sees less light and is read where the first saturates.

use super::Sensor;
use petzval_base::sampler::hash;

/// Share of saturation from which the less sensitive of two photosites is read.
const MERGING_SHARE: f64 = 0.9;

impl Sensor {
    /// Returns the sensor of the less sensitive photosites. Their area collects less dark current too, and their fixed
    /// pattern is their own.
    pub(super) fn second_photosite(&self) -> Self {
        let mut fixed_pattern = self.fixed_pattern;
        fixed_pattern.seed = salted(fixed_pattern.seed, 1);
        fixed_pattern.hot.dark_current /= self.hdr;
        let dark_current = self.dark_current / self.hdr;
        Self { hdr: 1.0, dark_current, fixed_pattern, ..*self }
    }

    /// Makes something for each photosite of a pixel: the sensitive one and, if there is one, the other, with a salt for
    /// its noise.
    pub(super) fn photosites<'a, T>(
        &'a self,
        second: &'a Self,
        make: impl Fn(&'a Self, u32) -> T,
    ) -> Vec<T> {
        let second = (self.hdr > 1.0).then_some((second, 1));
        std::iter::once((self, 0)).chain(second).map(|(sensor, salt)| make(sensor, salt)).collect()
    }

    /// Returns the value of a pixel from the codes of its photosites: that of the sensitive one, or of the other where
    /// the first is close to saturation. `code` gets what [`Self::photosites`] made, and the relative sensitivity.
    pub(super) fn merged<T>(&self, photosites: &[T], code: impl Fn(&T, f32) -> u32) -> f32 {
        self.merged_below(1.0, photosites, code)
    }

    /// Does the same for a part of the photosites that has this share of their full wells.
    pub(super) fn merged_below<T>(
        &self,
        share_of_well: f64,
        photosites: &[T],
        code: impl Fn(&T, f32) -> u32,
    ) -> f32 {
        let value = self.value(code(&photosites[0], 1.0));
        match photosites {
            [_, other] if f64::from(value) > share_of_well * self.merging_value() => {
                let value = self.value(code(other, (1.0 / self.hdr) as f32));
                (f64::from(value) * self.hdr) as f32
            }
            _ => value,
        }
    }

    /// Returns the picture value from which the less sensitive photosite is read.
    pub(super) fn merging_value(&self) -> f64 {
        MERGING_SHARE * (self.full_well / self.white_electrons()).min(1.0)
    }
}

/// Returns the seed of another photosite; that of the first is the seed itself.
pub(super) fn salted(seed: u32, salt: u32) -> u32 {
    if salt == 0 { seed } else { hash(seed ^ hash(salt)) }
}
