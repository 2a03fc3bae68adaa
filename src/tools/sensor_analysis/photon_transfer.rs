//! Parameters of a sensor from its photon transfer curve.

use petzval_render::sensor::Components;

use super::field_stack::{FieldStatistics, Variances};

/// Share of the saturation up to which the curve gives the gain.
const FIT_END: f64 = 0.7;
/// Range of the saturation in which linearity is measured.
const LINEAR_RANGE: [f64; 2] = [0.05, 0.95];
/// Share of the saturation at which PRNU is measured.
const PRNU_LEVEL: f64 = 0.5;
/// Share of the largest temporal noise (variance) below which all photosites are full.
const FULL: f64 = 0.1;
/// Variance of rounding to whole codes.
const ROUNDING: f64 = 1.0 / 12.0;

/// Why pictures tell no parameters.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TransferError {
    /// There are no pictures with light.
    #[error("no pictures with light; expected at least one exposure")]
    NoLight,
    /// An exposure is not brighter than the dark.
    #[error(
        "the mean of exposure {index} is {mean:.2}, that of its dark {dark:.2}; expected more light"
    )]
    Dark {
        /// Number of the exposure, from 1.
        index: usize,
        /// Its mean (codes).
        mean: f64,
        /// Mean of its dark (codes).
        dark: f64,
    },
    /// Noise does not grow with the light.
    #[error(
        "the noise does not grow with the light: variances of {light:.3} with it and {dark:.3} without (in codes); \
         expected linear codes with photon noise that are not clipped"
    )]
    NoPhotonNoise {
        /// Temporal variance of the brightest exposure of the fit (square of codes).
        light: f64,
        /// That of its dark.
        dark: f64,
    },
}

/// An exposure to uniform light, and the same without light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exposure {
    /// Photons a pixel, if they were measured.
    pub photons: Option<f64>,
    /// Pictures with light.
    pub light: FieldStatistics,
    /// Pictures without, of the same exposure time.
    pub dark: FieldStatistics,
}

impl Exposure {
    /// Returns the mean without that of the dark (codes).
    pub fn signal(&self) -> f64 {
        self.light.mean - self.dark.mean
    }

    /// Returns the temporal variance of the light (square of codes).
    fn photon_noise(&self) -> f64 {
        self.light.temporal.total() - self.dark.temporal.total()
    }
}

/// Parameters of a sensor. Source: EMVA 1288, release 4.0 (2021), linear model. The saturation is that of release 3.1:
/// release 4.0 finds it by a few pixels at the last code, which a full well below that code never shows.
#[derive(Clone, Debug, PartialEq)]
pub struct PhotonTransfer {
    /// Exposures, from the darkest.
    pub exposures: Vec<Exposure>,
    /// System gain K (codes an electron).
    pub gain: f64,
    /// Mean of the dark (codes).
    pub dark_mean: f64,
    /// Temporal noise of the dark without that of rounding (electrons): read noise, and shot noise of dark current.
    pub dark_noise: Components,
    /// Non-uniformity of the dark signal (electrons).
    pub dsnu: Components,
    /// Non-uniformity of the response, relative to the signal.
    pub prnu: Components,
    /// Electrons at the largest temporal noise, which falls beyond; `None` if it is that of the last exposure.
    pub saturation: Option<f64>,
    /// Electrons of photosites that are full, or at the last code; `None` if the last exposure does not fill them all.
    pub full_well: Option<f64>,
    /// Electrons a photon; `None` if photons were not measured.
    pub quantum_efficiency: Option<f64>,
    /// Mean deviation from a line, relative to it, between 5 and 95 % of the saturation; `None` without photons or
    /// saturation, or with fewer than three exposures there.
    pub linearity_error: Option<f64>,
}

impl PhotonTransfer {
    /// Evaluates exposures, in any order.
    ///
    /// # Errors
    /// Returns an error if there is no light or no photon noise in them.
    pub fn new(mut exposures: Vec<Exposure>) -> Result<Self, TransferError> {
        for (i, exposure) in exposures.iter().enumerate() {
            if exposure.signal() <= 0.0 {
                let [mean, dark] = [exposure.light.mean, exposure.dark.mean];
                return Err(TransferError::Dark { index: i + 1, mean, dark });
            }
        }
        exposures.sort_by(|a, b| a.signal().total_cmp(&b.signal()));
        let last = exposures.last().ok_or(TransferError::NoLight)?;
        let noisiest = |best: &'_ Exposure, other: &'_ Exposure| {
            best.light.temporal.total() < other.light.temporal.total()
        };
        let peak = exposures
            .iter()
            .fold(&exposures[0], |best, other| if noisiest(best, other) { other } else { best });
        let is_reached = peak.signal() < last.signal();
        let saturation = peak.signal();
        let end = if is_reached { FIT_END * saturation } else { saturation };
        // At least the darkest, whatever their number.
        let fitted = || {
            exposures
                .iter()
                .enumerate()
                .filter(|(i, e)| *i == 0 || e.signal() <= end)
                .map(|(_, e)| e)
        };
        let gain = slope(fitted().map(|e| [e.signal(), e.photon_noise()]));
        if gain.is_nan() || gain <= 0.0 {
            let [light, dark] = [peak.light, peak.dark].map(|field| field.temporal.total());
            return Err(TransferError::NoPhotonNoise { light, dark });
        }
        let responsivity = fitted()
            .map(|e| e.photons.map(|photons| [photons, e.signal()]))
            .collect::<Option<Vec<_>>>()
            .map(slope);
        // Stacks of many pictures know patterns best.
        let pictures = exposures.iter().map(|e| e.light.pictures).max().unwrap_or(0);
        let off = |e: &&Exposure| (e.signal() - PRNU_LEVEL * saturation).abs();
        let half = exposures
            .iter()
            .filter(|e| e.light.pictures == pictures)
            .min_by(|a, b| off(a).total_cmp(&off(b)))
            .unwrap_or(peak);
        let dark =
            exposures.iter().map(|e| e.dark).max_by_key(|dark| dark.pictures).unwrap_or(peak.dark);
        let first = exposures[0].dark;
        let prnu = half.light.spatial.less(dark.spatial, 1.0);
        let mut rounded = first.temporal;
        rounded.pixel -= ROUNDING;
        let is_full = last.light.temporal.total()
            < FULL * peak.light.temporal.total() + last.dark.temporal.total();
        let linearity_error = is_reached.then(|| linearity(&exposures, saturation)).flatten();
        Ok(Self {
            gain,
            dark_mean: first.mean,
            dark_noise: deviations(rounded, gain),
            dsnu: deviations(dark.spatial, gain),
            prnu: deviations(prnu, half.signal()),
            saturation: is_reached.then_some(saturation / gain),
            full_well: (is_reached && is_full).then(|| last.signal() / gain),
            quantum_efficiency: responsivity.map(|responsivity| responsivity / gain),
            linearity_error,
            exposures,
        })
    }

    /// Returns the least signal that is told from the dark (electrons): that of a signal-to-noise ratio of 1 (eq. 27).
    pub fn threshold(&self) -> f64 {
        let rounding = ROUNDING / (self.gain * self.gain);
        (self.dark_noise.variance() + rounding + 0.25).sqrt() + 0.5
    }
}

/// Returns standard deviations in a unit of so many codes; 0 where less than none was estimated.
fn deviations(variances: Variances, unit: f64) -> Components {
    let [pixel, row, column] = [variances.pixel, variances.row, variances.column]
        .map(|variance| variance.max(0.0).sqrt() / unit);
    Components { pixel, row, column }
}

/// Returns the slope of the line through 0 with the least squares.
fn slope(points: impl IntoIterator<Item = [f64; 2]>) -> f64 {
    let add = |[xx, xy]: [f64; 2], [x, y]: [f64; 2]| [xx + x * x, xy + x * y];
    let [xx, xy] = points.into_iter().fold([0.0; 2], add);
    xy / xx
}

/// Returns the mean deviation from the line with the least relative squares; `None` without photons or with less than
/// three exposures in the range.
fn linearity(exposures: &[Exposure], saturation: f64) -> Option<f64> {
    let [low, high] = LINEAR_RANGE.map(|share| share * saturation);
    let inside = exposures.iter().filter(|e| (low..=high).contains(&e.signal()));
    let points: Vec<[f64; 2]> =
        inside.map(|e| Some([e.photons?, e.signal()])).collect::<Option<_>>()?;
    if points.len() < 3 {
        return None;
    }
    // Weights 1/y^2.
    let sum = |f: fn(f64, f64) -> f64| points.iter().map(|&[x, y]| f(x, y) / (y * y)).sum::<f64>();
    let [one, x, xx, y, xy] =
        [sum(|_, _| 1.0), sum(|x, _| x), sum(|x, _| x * x), sum(|_, y| y), sum(|x, y| x * y)];
    let determinant = one * xx - x * x;
    let [offset, slope] = [(xx * y - x * xy) / determinant, (one * xy - x * y) / determinant];
    let off = points.iter().map(|[x, y]| (y / (offset + slope * x) - 1.0).abs());
    Some(off.sum::<f64>() / points.len() as f64)
}
