//! Buckets of wavelength of a spectral film, and the share that each band of light has in them.

use super::observer::{LUMINOSITY, VISIBLE};
use super::wavelength_sets::{
    WAVELENGTH_SETS, WAVELENGTHS, WAVELENGTHS_PER_PATH, bands_of_set, daylight_between,
    wavelength_bands,
};

/// Shortest range of all buckets together (nm).
const LEAST_RANGE: f64 = 1.0;

/// Equal buckets of wavelength, side by side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Buckets {
    count: u32,
    range: [f64; 2],
}

impl Buckets {
    /// Largest number of buckets: that of the bands of paths, beyond which there is nothing to tell apart.
    pub const MOST: u32 = WAVELENGTHS as u32;

    /// The buckets of pbrt-v4, if a film does not say which.
    pub const DEFAULT: Self = Self { count: 16, range: Self::VISIBLE };

    /// The longest range of buckets (nm).
    pub const VISIBLE: [f64; 2] = [VISIBLE[0] as f64, VISIBLE[1] as f64];

    /// Makes so many buckets of a range of wavelengths (nm).
    ///
    /// # Errors
    /// Returns a text that says what is expected.
    pub fn new(count: u32, range: [f64; 2]) -> Result<Self, String> {
        let [first, last] = Self::VISIBLE;
        if !(1..=Self::MOST).contains(&count) {
            let most = Self::MOST;
            return Err(format!("expected 1 to {most} buckets: light is split into {most} bands"));
        }
        let inside = range.iter().all(|nm| (first..=last).contains(nm));
        match inside && range[1] - range[0] >= LEAST_RANGE {
            true => Ok(Self { count, range }),
            false => Err(format!(
                "expected two wavelengths from {first} to {last} nm, the shorter first, at least \
                 {LEAST_RANGE} nm apart"
            )),
        }
    }

    /// Returns the number of buckets.
    pub fn count(&self) -> usize {
        self.count as usize
    }

    /// Returns the shortest and the longest wavelength (nm).
    pub fn range(&self) -> [f64; 2] {
        self.range
    }

    /// Returns the width of a bucket (nm).
    pub fn width(&self) -> f64 {
        (self.range[1] - self.range[0]) / f64::from(self.count)
    }

    /// Returns the wavelengths in the middle of the buckets, in ascending order (nm).
    pub fn middles(&self) -> Vec<f64> {
        (0..self.count).map(|i| self.range[0] + self.width() * (f64::from(i) + 0.5)).collect()
    }
}

/// Shares of the light of the bands of paths in the buckets of a film.
///
/// Within a band, light has the shape of daylight: that is all that a path knows of it.
#[derive(Clone, Debug, PartialEq)]
pub struct BucketShares {
    buckets: Buckets,
    /// By band: a bucket, and the mean spectral radiance in it of light that is daylight in the band.
    shares: Vec<Vec<(usize, f64)>>,
}

impl BucketShares {
    /// Finds the shares of all bands.
    pub fn new(buckets: Buckets) -> Self {
        let width = buckets.width();
        let of_band = |[first, last]: [f64; 2]| {
            let share = |bucket: usize| {
                let low = buckets.range[0] + width * bucket as f64;
                let (from, to) = (first.max(low), last.min(low + width));
                (from < to).then(|| (bucket, daylight_within([from, to]) / width))
            };
            (0..buckets.count()).filter_map(share).collect()
        };
        let shares = wavelength_bands().iter().map(|band| of_band(band.range)).collect();
        Self { buckets, shares }
    }

    /// Returns the buckets.
    pub fn buckets(&self) -> &Buckets {
        &self.buckets
    }

    /// Calls `add` with each bucket that a path contributes to, and with its spectral radiance there.
    /// The values of the path at the wavelengths of its set are relative to daylight. As it stands for
    /// the paths of all sets, the mean over them is the spectral radiance of all light.
    ///
    /// The unit is that of a spectrum S whose luminance is the integral of S times the luminosity
    /// function over the integral of that function: a constant spectrum of luminance 1 is 1.
    #[inline]
    pub fn spread(
        &self,
        set: usize,
        light: [f64; WAVELENGTHS_PER_PATH],
        mut add: impl FnMut(usize, f64),
    ) {
        for (band, light) in bands_of_set(set).into_iter().zip(light) {
            let light = light * WAVELENGTH_SETS as f64;
            self.shares[band].iter().for_each(|&(bucket, share)| add(bucket, light * share));
        }
    }
}

/// Returns the integral of daylight of luminance 1 over a part of the visible range (nm).
fn daylight_within([from, to]: [f64; 2]) -> f64 {
    let (mut sum, mut nm) = (0.0, from);
    while nm < to {
        let end = (nm.floor() + 1.0).min(to);
        // Daylight is linear between whole nanometres.
        sum += (end - nm) * daylight_between(0.5 * (nm + end));
        nm = end;
    }
    sum * *LUMINOSITY
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BandSpectrum, Spectrum, d65, named_spectrum};

    /// Returns the mean over all sets of what paths of this light leave in the buckets.
    fn seen(buckets: Buckets, light: &BandSpectrum) -> Vec<f64> {
        let (shares, mut sums) = (BucketShares::new(buckets), vec![0.0; buckets.count()]);
        for set in 0..WAVELENGTH_SETS {
            shares.spread(set, light.in_set(set).map(f64::from), |bucket, radiance| {
                sums[bucket] += radiance / WAVELENGTH_SETS as f64;
            });
        }
        sums
    }

    /// Returns the means of a spectrum over the buckets, by steps of 1/200 nm or less.
    fn means(buckets: Buckets, spectrum: &Spectrum) -> Vec<f64> {
        let steps = (200.0 * buckets.width()).ceil();
        let mean = |middle: f64| {
            let step = buckets.width() / steps;
            let nm = |i: u32| middle - 0.5 * buckets.width() + step * (f64::from(i) + 0.5);
            (0..steps as u32).map(|i| spectrum.at(nm(i))).sum::<f64>() / steps
        };
        buckets.middles().into_iter().map(mean).collect()
    }

    fn buckets(count: u32, range: [f64; 2]) -> Buckets {
        Buckets::new(count, range).expect("sound buckets")
    }

    #[test]
    fn daylight_has_its_own_spectrum_in_any_buckets() {
        let day = d65();
        let luminance = day.to_xyz()[1];
        for buckets in [
            Buckets::DEFAULT,
            buckets(192, [360.0, 830.0]),
            buckets(31, [397.3, 702.9]),
            buckets(1, [500.0, 501.0]),
        ] {
            let found = seen(buckets, &BandSpectrum::from_bands(|_| 0.5));
            for (found, expected) in found.into_iter().zip(means(buckets, &day)) {
                let expected = 0.5 * expected / luminance;
                assert!((found / expected - 1.0).abs() < 1e-4, "{found} for {expected}");
            }
        }
    }

    #[test]
    fn lamps_have_their_spectra_as_far_as_bands_tell_them_apart() {
        for name in ["stdillum-A", "stdillum-F2", "stdillum-F11"] {
            let lamp = named_spectrum(name).expect("it is known");
            let found = seen(Buckets::DEFAULT, &BandSpectrum::light(&lamp));
            let expected = means(Buckets::DEFAULT, &lamp);
            let most = expected.iter().copied().fold(0.0, f64::max);
            for (found, expected) in found.into_iter().zip(expected) {
                assert!((found - expected).abs() < 0.01 * most, "{name}: {found} for {expected}");
            }
        }
    }

    #[test]
    fn buckets_are_checked() {
        assert!(Buckets::new(Buckets::MOST, [360.0, 830.0]).is_ok());
        for (count, range) in [
            (0, [400.0, 700.0]),
            (193, [400.0, 700.0]),
            (4, [359.0, 700.0]),
            (4, [400.0, 831.0]),
            (4, [700.0, 400.0]),
            (4, [500.0, 500.5]),
            (4, [f64::NAN, 700.0]),
        ] {
            assert!(Buckets::new(count, range).is_err(), "{count} of {range:?}");
        }
        assert_eq!(Buckets::DEFAULT.middles()[0], 374.6875);
    }
}
