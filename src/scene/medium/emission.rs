//! Radiance of hot gas, by temperature.

use std::sync::Arc;

use petzval_spectrum::{BandSpectrum, blackbody, luminosity_integral};
use rayon::prelude::*;

/// Linear RGB of black bodies whose spectrum has the maximum 1, as pbrt-v4 scales them: the integral
/// over the wavelengths in nm, weighted by the colour-matching functions.
#[derive(Clone, Debug)]
pub struct Blackbodies {
    /// Factor of the radiance.
    scale: f32,
    /// Colours at equal steps of the logarithm of the temperature.
    table: Arc<[[f32; 3]]>,
}

/// Temperatures at the ends of the table (K). Black bodies below are invisible; above, the shape of
/// the visible spectrum hardly changes.
const RANGE: [f32; 2] = [100.0, 100_000.0];
/// Number of entries. Between them, radiances are wrong by at most 0.1 % above 1000 K.
const ENTRIES: usize = 2049;

/// Returns the temperature of an entry (K).
fn temperature(entry: usize) -> f64 {
    let step = (RANGE[1] / RANGE[0]).ln() / (ENTRIES - 1) as f32;
    f64::from(RANGE[0] * (step * entry as f32).exp())
}

impl Blackbodies {
    /// Black bodies with a factor of the radiance.
    pub fn new(scale: f32) -> Self {
        let colour = |i: usize| {
            blackbody(temperature(i)).integrated_rgb().map(|channel| channel.max(0.0) as f32)
        };
        Self { scale, table: (0..ENTRIES).map(colour).collect() }
    }

    /// Returns the radiances by wavelength, relative to daylight, of all entries.
    pub(super) fn by_wavelength(&self) -> Vec<BandSpectrum> {
        let entry = |i: usize| {
            BandSpectrum::light(&blackbody(temperature(i))).scaled(luminosity_integral() as f32)
        };
        (0..ENTRIES).into_par_iter().map(entry).collect()
    }

    /// Returns the memory of the table (bytes).
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.table[..])
    }

    /// The same factor, and other radiances of all entries.
    pub(super) fn with_radiances(&self, table: impl Iterator<Item = [f32; 3]>) -> Self {
        Self { scale: self.scale, table: table.collect() }
    }

    /// Returns the radiance at a temperature (K).
    pub(super) fn at(&self, kelvin: f32) -> [f32; 3] {
        let along = (kelvin / RANGE[0]).ln() / (RANGE[1] / RANGE[0]).ln();
        let place = along.clamp(0.0, 1.0) * (ENTRIES - 1) as f32;
        let first = (place as usize).min(ENTRIES - 2);
        let t = place - first as f32;
        let (low, high) = (self.table[first], self.table[first + 1]);
        [0, 1, 2].map(|c| self.scale * ((1.0 - t) * low[c] + t * high[c]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn radiances_at_and_between_all_entries_are_those_of_black_bodies() {
        let table = Blackbodies::new(2.0);
        let step = (RANGE[1] / RANGE[0]).ln() / (ENTRIES - 1) as f32;
        let entries = (0..2 * ENTRIES - 1).map(|i| RANGE[0] * (step * i as f32 / 2.0).exp());
        for kelvin in entries.filter(|kelvin| *kelvin > 1000.0) {
            let exact = blackbody(f64::from(kelvin)).integrated_rgb();
            let sum = exact.iter().sum::<f64>();
            for (found, exact) in table.at(kelvin).into_iter().zip(exact) {
                let off = f64::from(found) / 2.0 - exact.max(0.0);
                assert!(off.abs() < 1e-3 * sum, "{kelvin}: {found}, not {exact}");
            }
        }
        assert_eq!(table.at(1e9), table.at(RANGE[1]));
        assert!(table.at(150.0).iter().all(|&channel| channel < 1e-20));
    }
}
