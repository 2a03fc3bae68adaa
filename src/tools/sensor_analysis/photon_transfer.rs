//! Parameters of a sensor from its photon transfer curve.

use petzval_base::least_squares::least_squares;
use petzval_render::sensor::Components;

use super::field_stack::{FieldStatistics, Variances};

/// Share of the saturation up to which the curve gives the gain.
const FIT_END: f64 = 0.7;
/// Range of the saturation in which linearity is measured.
const LINEAR_RANGE: [f64; 2] = [0.05, 0.95];
/// Share of the saturation at which PRNU is measured, and the range for stacks of more pictures.
const PRNU_LEVEL: f64 = 0.5;
const PRNU_RANGE: [f64; 2] = [0.3, 0.7];
/// Share of the largest temporal noise (variance) below which all photosites are full.
const FULL: f64 = 0.1;
/// Variance of rounding to whole codes. Below a variance of the dark, rounding hides its noise, which is then at most a
/// number of codes (eqs. 53 and 54).
const ROUNDING: f64 = 1.0 / 12.0;
const RESOLVED: f64 = 0.24;
const HIDDEN: f64 = 0.40;

/// Why exposures give no parameters.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TransferError {
    /// There are no pictures with light.
    #[error("no pictures with light; expected at least one exposure")]
    NoLight,
    /// An exposure is not brighter than the dark.
    #[error(
        "the mean of pictures with light is {mean:.2}, that of their dark {dark:.2}; expected more light"
    )]
    Dark {
        /// Position of the exposure in the list, from 0.
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
        /// Largest temporal variance (square of codes).
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

/// A standard deviation, and its parts; 0 where less than none was estimated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deviation {
    /// Standard deviation of the whole.
    pub total: f64,
    /// Standard deviations of photosites, rows and columns.
    pub parts: Components,
}

impl Deviation {
    /// Returns the deviation of variances in a unit of so many codes.
    fn new(variances: Variances, unit: f64) -> Self {
        let deviation = |variance: f64| variance.max(0.0).sqrt() / unit;
        let Variances { pixel, row, column } = variances;
        let [pixel, row, column] = [pixel, row, column].map(deviation);
        Self { total: deviation(variances.total()), parts: Components { pixel, row, column } }
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
    /// The dark of which mean, noise and DSNU are stated: of those with the most pictures, that with the lowest mean.
    pub dark: FieldStatistics,
    /// Temporal noise of the dark without that of rounding (electrons): read noise, and shot noise of dark current.
    pub dark_noise: Deviation,
    /// Whether the noise of the dark is resolved; if rounding hides it, its total is an upper bound.
    pub is_dark_noise_resolved: bool,
    /// Non-uniformity of the dark signal (electrons).
    pub dsnu: Deviation,
    /// Non-uniformity of the response, relative to the signal.
    pub prnu: Deviation,
    /// Signal at which PRNU was measured (electrons).
    pub prnu_signal: f64,
    /// Electrons at the largest temporal noise, which falls beyond; `None` if it is that of the last exposure.
    pub saturation: Option<f64>,
    /// Electrons of photosites that are full, or at the last code; `None` if the last exposure does not fill them all.
    pub full_well: Option<f64>,
    /// Electrons a photon; `None` if photons were not measured.
    pub quantum_efficiency: Option<f64>,
    /// Mean deviation from a line, relative to it, between 5 and 95 % of the saturation; `None` without
    /// saturation, or with fewer than three exposures with photons there.
    pub linearity_error: Option<f64>,
}

impl PhotonTransfer {
    /// Evaluates exposures, in any order.
    ///
    /// # Errors
    /// Returns an error if there is no light or no photon noise in them.
    pub fn new(mut exposures: Vec<Exposure>) -> Result<Self, TransferError> {
        for (index, exposure) in exposures.iter().enumerate() {
            if exposure.signal() <= 0.0 {
                let [mean, dark] = [exposure.light.mean, exposure.dark.mean];
                return Err(TransferError::Dark { index, mean, dark });
            }
        }
        exposures.sort_by(|a, b| a.signal().total_cmp(&b.signal()));
        let last = exposures.last().ok_or(TransferError::NoLight)?;
        let noise = |exposure: &Exposure| exposure.light.temporal.total();
        let peak = exposures.iter().fold(&exposures[0], |peak, exposure| {
            if noise(exposure) > noise(peak) { exposure } else { peak }
        });
        let is_reached = peak.signal() < last.signal();
        let saturation = peak.signal();
        let end = if is_reached { FIT_END * saturation } else { saturation };
        // At least the darkest, whatever its signal.
        let count = exposures.iter().filter(|e| e.signal() <= end).count().max(1);
        let fitted = &exposures[..count];
        let gain = slope(fitted.iter().map(|e| [e.signal(), e.photon_noise()]));
        if gain.is_nan() || gain <= 0.0 {
            let [light, dark] = [peak.light, peak.dark].map(|field| field.temporal.total());
            return Err(TransferError::NoPhotonNoise { light, dark });
        }
        let lit: Vec<[f64; 2]> =
            fitted.iter().filter_map(|e| Some([e.photons?, e.signal()])).collect();
        let dark = exposures.iter().map(|e| e.dark).fold(peak.dark, |best, dark| {
            let rank = |dark: &FieldStatistics| (dark.pictures, -dark.mean);
            if rank(&dark) > rank(&best) { dark } else { best }
        });
        let half = half_saturated(&exposures, saturation);
        let mut noise_of_dark = dark.temporal;
        let is_dark_noise_resolved = noise_of_dark.total() >= RESOLVED;
        noise_of_dark.pixel -= ROUNDING;
        let mut dark_noise = Deviation::new(noise_of_dark, gain);
        if !is_dark_noise_resolved {
            dark_noise.total = HIDDEN / gain;
        }
        let is_full = last.light.temporal.total()
            < FULL * peak.light.temporal.total() + last.dark.temporal.total();
        Ok(Self {
            gain,
            dark,
            dark_noise,
            is_dark_noise_resolved,
            dsnu: Deviation::new(dark.spatial, gain),
            prnu: Deviation::new(half.light.spatial.without(half.dark.spatial, 1.0), half.signal()),
            prnu_signal: half.signal() / gain,
            saturation: is_reached.then_some(saturation / gain),
            full_well: (is_reached && is_full).then(|| last.signal() / gain),
            quantum_efficiency: (!lit.is_empty()).then(|| slope(lit) / gain),
            linearity_error: is_reached.then(|| linearity(&exposures, saturation)).flatten(),
            exposures,
        })
    }

    /// Returns the least signal that is told from the dark (electrons): that of a signal-to-noise ratio of 1 (eq. 27).
    pub fn threshold(&self) -> f64 {
        let rounding = ROUNDING / (self.gain * self.gain);
        (self.dark_noise.total.powi(2) + rounding + 0.25).sqrt() + 0.5
    }
}

/// Returns the exposure of which PRNU is stated: of those near half of the saturation the one with the most pictures, and
/// of these the nearest. If none is near, it is the nearest of all.
fn half_saturated(exposures: &[Exposure], saturation: f64) -> &Exposure {
    let [low, high] = PRNU_RANGE;
    let share = |e: &Exposure| e.signal() / saturation;
    let rank = |e: &Exposure| {
        let pictures = if (low..=high).contains(&share(e)) { e.light.pictures } else { 0 };
        (pictures, -(share(e) - PRNU_LEVEL).abs())
    };
    exposures.iter().fold(&exposures[0], |best, e| if rank(e) > rank(best) { e } else { best })
}

/// Returns the slope of the line through 0 with the least squares.
fn slope(points: impl IntoIterator<Item = [f64; 2]>) -> f64 {
    let add = |[xx, xy]: [f64; 2], [x, y]: [f64; 2]| [xx + x * x, xy + x * y];
    let [xx, xy] = points.into_iter().fold([0.0; 2], add);
    xy / xx
}

/// Returns the mean deviation from the line with the least relative squares (eqs. 59 to 63); `None` with less than three
/// exposures with photons in the range.
fn linearity(exposures: &[Exposure], saturation: f64) -> Option<f64> {
    let [low, high] = LINEAR_RANGE.map(|share| share * saturation);
    let inside = exposures.iter().filter(|e| (low..=high).contains(&e.signal()));
    let points: Vec<[f64; 2]> = inside.filter_map(|e| Some([e.photons?, e.signal()])).collect();
    if points.len() < 3 {
        return None;
    }
    let column = |f: fn(f64) -> f64| points.iter().map(|&[x, y]| f(x) / y).collect::<Vec<_>>();
    let line = least_squares(vec![column(|_| 1.0), column(|x| x)], vec![vec![1.0; points.len()]]);
    let off = points.iter().map(|[x, y]| (y / (line[0][0] + line[0][1] * x) - 1.0).abs());
    Some(off.sum::<f64>() / points.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a field of a mean, with temporal and spatial variances of photosites.
    fn field(pictures: usize, mean: f64, temporal: f64, spatial: f64) -> FieldStatistics {
        let of = |pixel| Variances { pixel, ..Variances::default() };
        FieldStatistics { pictures, mean, temporal: of(temporal), spatial: of(spatial) }
    }

    /// Returns an exposure of a sensor of 0.5 codes an electron, a noise of the dark of 4 electrons, a dark non-uniformity
    /// in proportion to its time, and a non-uniformity of 1 %, at 2 photons an electron.
    fn exposure(electrons: f64, pictures: usize, time: f64) -> Exposure {
        let (dark, dsnu) = (100.0 + 10.0 * time, 3.0 * time);
        let temporal = 16.0 * 0.25 + ROUNDING;
        let prnu = 0.01 * electrons;
        Exposure {
            photons: Some(2.0 * electrons),
            light: field(
                pictures,
                dark + 0.5 * electrons,
                temporal + 0.25 * electrons,
                0.25 * (dsnu * dsnu + prnu * prnu),
            ),
            dark: field(pictures, dark, temporal, 0.25 * dsnu * dsnu),
        }
    }

    #[test]
    fn exposures_of_several_times_have_their_own_darks() {
        let exposures = (1..=10).map(|i| exposure(1000.0 * f64::from(i), 2, f64::from(i)));
        let found = PhotonTransfer::new(exposures.collect()).unwrap();
        let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-9, "{found}");
        near(found.gain, 0.5);
        near(found.dark_noise.total, 4.0);
        near(found.prnu.total, 0.01);
        near(found.prnu_signal, 5000.0);
        // The shortest time.
        near(found.dark.mean, 110.0);
        near(found.dsnu.total, 3.0);
        near(found.quantum_efficiency.unwrap(), 0.5);
        assert_eq!((found.saturation, found.linearity_error), (None, None));
    }

    #[test]
    fn a_saturated_stack_does_not_state_the_prnu() {
        let mut exposures: Vec<_> =
            (1..=10).map(|i| exposure(1000.0 * f64::from(i), 2, 1.0)).collect();
        let full = |pictures| Exposure { light: field(pictures, 5150.0, 0.5, 0.0), ..exposures[9] };
        exposures.extend([full(16), full(2)]);
        let found = PhotonTransfer::new(exposures.clone()).unwrap();
        assert_eq!((found.prnu_signal.round(), found.saturation), (5000.0, Some(10_000.0)));
        assert!((found.prnu.total - 0.01).abs() < 1e-9);
        assert!((found.full_well.unwrap() - 10_080.0).abs() < 1e-9);
        assert!(found.linearity_error.unwrap() < 1e-12);
        // A stack near half of the saturation is better than a pair.
        exposures.push(exposure(6500.0, 16, 1.0));
        assert_eq!(PhotonTransfer::new(exposures).unwrap().prnu_signal.round(), 6500.0);
    }

    #[test]
    fn noise_that_rounding_hides_is_a_bound() {
        let mut one = exposure(4000.0, 2, 0.0);
        one.dark.temporal = Variances::default();
        one.light.temporal.pixel = 0.25 * 4000.0;
        let found = PhotonTransfer::new(vec![one]).unwrap();
        assert!(!found.is_dark_noise_resolved && (found.dark_noise.total - 0.8).abs() < 1e-9);
        // Parts that are less than none do not add to the total.
        one.dark.spatial = Variances { pixel: -0.3, row: 0.1, column: 0.1 };
        assert_eq!(PhotonTransfer::new(vec![one]).unwrap().dsnu.total, 0.0);
    }
}
