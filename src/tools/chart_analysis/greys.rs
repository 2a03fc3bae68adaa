//! Tone, noise and dynamic range from a picture of steps of grey (OECF of ISO 14524, noise of ISO 15739).

use std::ops::Range;

use petzval_image::Picture;

use super::luminance;
use super::patches::{PatchError, PatchMean, patch_mean};
use crate::charts::patch_grid::{PatchGrid, grey_reflectance};

/// Steps from 0.4 to 0.06 of white, by which the exposure is known.
const MIDDLE: Range<usize> = 2..7;
/// Share of the brightest step from which others are clipped, if several are.
const CLIPPED: f64 = 0.98;

/// Why steps of grey cannot be measured.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GreysError {
    /// A step cannot be measured.
    #[error(transparent)]
    Patch(#[from] PatchError),
    /// The exposure clips the steps that tell it.
    #[error("its {0} brightest steps are clipped; expected a darker picture")]
    Clipped(usize),
    /// The steps are not in the order of the chart.
    #[error(
        "its steps do not become darker row after row; expected a picture of petzval chart greys in this region"
    )]
    Order,
}

/// A photographed step of grey.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GreyStep {
    /// Reflectance of the chart.
    pub reflectance: f64,
    /// Mean of its pixels, linear sRGB.
    pub mean: [f64; 3],
    /// Standard deviation of the luminance of its pixels.
    pub noise: f64,
    /// Slope of the logarithm of the value over that of the reflectance, by the steps beside it: 1 for a linear camera, 0
    /// where values are clipped.
    pub slope: f64,
}

impl GreyStep {
    /// Returns the mean luminance.
    pub fn value(&self) -> f64 {
        luminance(self.mean)
    }

    /// Returns the signal-to-noise ratio of the exposure: the incremental gain times the exposure over the noise (ISO
    /// 15739). It is infinite without noise, and 0 where values do not follow the exposure.
    pub fn signal_to_noise(&self) -> f64 {
        let signal = self.slope * self.value();
        if signal > 0.0 { signal / self.noise } else { 0.0 }
    }
}

/// Steps of grey: the opto-electronic conversion of a camera.
#[derive(Clone, Debug, PartialEq)]
pub struct GreySteps {
    /// The steps, from white on.
    pub steps: Vec<GreyStep>,
    /// Value that a reflectance of 1 has by the middle steps.
    pub scale: f64,
}

impl GreySteps {
    /// Measures the steps that fill a region of a picture (pixels): first column and row, and those that no longer belong
    /// to it.
    ///
    /// # Errors
    /// Returns an error if the steps have too few pixels, or are not those of the chart.
    pub fn measure(picture: &Picture, region: [[usize; 2]; 2]) -> Result<Self, GreysError> {
        let grid = PatchGrid::GREYS;
        let region = region.map(|at| at.map(|n| n as f64));
        let mut steps = Vec::new();
        for i in 0..grid.len() {
            let PatchMean { mean, deviation } = patch_mean(picture, grid, region, i)?;
            let reflectance = grey_reflectance(i);
            steps.push(GreyStep { reflectance, mean, noise: deviation, slope: 0.0 });
        }
        for i in 0..steps.len() {
            steps[i].slope = slope_at(&steps, i);
        }
        let brightest = steps[0].value();
        let clipped = steps.iter().take_while(|step| step.value() >= CLIPPED * brightest).count();
        let first = if clipped > 1 { MIDDLE.start.max(clipped) } else { MIDDLE.start };
        if first + 1 >= MIDDLE.end && first < steps.len() {
            return Err(GreysError::Clipped(clipped));
        }
        let middle = steps.get(first..MIDDLE.end).ok_or(GreysError::Order)?;
        let falls = middle.windows(2).all(|pair| pair[0].value() > pair[1].value());
        let logs = middle.iter().map(|step| (step.value() / step.reflectance).ln());
        let scale = (logs.sum::<f64>() / middle.len() as f64).exp();
        match falls && scale.is_finite() && scale > 0.0 {
            true => Ok(Self { steps, scale }),
            false => Err(GreysError::Order),
        }
    }

    /// Returns how much brighter a step is than a linear camera of this exposure would show it (stops); `None` without
    /// light.
    pub fn deviation(&self, step: &GreyStep) -> Option<f64> {
        let ratio = step.value() / (self.scale * step.reflectance);
        (ratio > 0.0).then(|| ratio.log2())
    }

    /// Returns the reflectance at which the signal-to-noise ratio falls to a level, below the middle steps; `None` if it
    /// does not.
    pub fn reflectance_of(&self, level: f64) -> Option<f64> {
        self.steps.windows(2).skip(MIDDLE.start).find_map(|pair| {
            let [above, below] = [pair[0], pair[1]].map(|step| step.signal_to_noise());
            if !(above >= level && below < level) {
                return None;
            }
            // A step without light has the least ratio that counts.
            let [above, below] = [above, below.max(0.01 * level)].map(f64::ln);
            let share = (above - level.ln()) / (above - below);
            let share = if share.is_finite() { share } else { 1.0 };
            Some(pair[0].reflectance * (pair[1].reflectance / pair[0].reflectance).powf(share))
        })
    }

    /// Returns the reflectance that has the value 1, where files and sensors saturate: from the brightest step below it, in
    /// the slope to the next one.
    pub fn saturation(&self) -> f64 {
        let below = self.steps.iter().position(|step| step.value() < CLIPPED).unwrap_or(0);
        let [step, darker] = [below, below + 1].map(|i| &self.steps[i.min(self.steps.len() - 1)]);
        let slope =
            (step.value() / darker.value()).ln() / (step.reflectance / darker.reflectance).ln();
        let slope = if slope > 0.0 && slope.is_finite() { slope } else { 1.0 };
        let found = step.reflectance * (-step.value().ln() / slope).exp();
        // The step before it is saturated.
        match below.checked_sub(1) {
            Some(before) => found.min(self.steps[before].reflectance),
            None => found,
        }
    }

    /// Returns the dynamic range (stops): from saturation to a signal-to-noise ratio of 1 (ISO 15739); `None` if the
    /// darkest step has a larger one.
    pub fn dynamic_range(&self) -> Option<f64> {
        self.reflectance_of(1.0).map(|reflectance| (self.saturation() / reflectance).log2())
    }
}

/// Returns the slope of a step by those beside it that have light, in logarithms.
fn slope_at(steps: &[GreyStep], i: usize) -> f64 {
    let has_light = |i: &usize| steps[*i].value() > 0.0;
    if !has_light(&i) {
        return 0.0;
    }
    let above = i.checked_sub(1).filter(has_light).unwrap_or(i);
    let below = Some(i + 1).filter(|i| *i < steps.len()).filter(has_light).unwrap_or(i);
    let [above, below] = [above, below].map(|i| &steps[i]);
    let slope = (above.value() / below.value()).ln() / (above.reflectance / below.reflectance).ln();
    if slope.is_finite() { slope } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use petzval_base::sampler::hash;

    const REGION: [[usize; 2]; 2] = [[20, 10], [590, 465]];

    /// Draws the chart with values and noise of its reflectances.
    fn chart(value: impl Fn(f64) -> f64, noise: impl Fn(f64) -> f64) -> Picture {
        let size = [620, 480];
        let mut picture = Picture { size, pixels: vec![[0.04; 3]; size[0] * size[1]] };
        for step in 0..20 {
            let borders = REGION.map(|at| at.map(|n| n as f64));
            let [low, high] = PatchGrid::GREYS.borders(borders, step, [0.0, 1.0]);
            let [low, high] = [low, high].map(|at| at.map(|n| n.round() as usize));
            let reflectance = grey_reflectance(step);
            for i in (low[1]..high[1]).flat_map(|y| (low[0]..high[0]).map(move |x| y * size[0] + x))
            {
                let random = f64::from(hash(i as u32)) / 4_294_967_296.0 - 0.5;
                let noise = 12.0_f64.sqrt() * random * noise(reflectance);
                picture.pixels[i] = [(value(reflectance) + noise) as f32; 3];
            }
        }
        picture
    }

    #[test]
    fn a_linear_camera_has_no_deviation_and_its_dynamic_range() {
        for scale in [0.5, 1.0] {
            // Read noise of 0.001 of white: a ratio of 1 at a value of 0.001, 9.97 stops below 1.
            let picture = chart(|r| scale * r, |_| 0.001);
            let found = GreySteps::measure(&picture, REGION).unwrap();
            assert!((found.scale / scale - 1.0).abs() < 2e-3, "{}", found.scale);
            for step in &found.steps[..10] {
                assert!(found.deviation(step).unwrap().abs() < 0.02, "{step:?}");
                let expected = scale * step.reflectance / 0.001;
                assert!((step.signal_to_noise() / expected - 1.0).abs() < 0.05, "{step:?}");
            }
            let range = found.dynamic_range().unwrap();
            assert!((range - 1000.0_f64.log2()).abs() < 0.1, "{range}");
        }
    }

    #[test]
    fn curves_and_clipping_show() {
        // Highlights from 0.4 on are clipped, and have no noise.
        let picture =
            chart(|r| (2.0 * r).min(0.8), |r| if r > 0.4 { 0.0 } else { 0.01 * r.sqrt() });
        let found = GreySteps::measure(&picture, REGION).unwrap();
        assert!((found.deviation(&found.steps[0]).unwrap() + 2.25_f64.log2()).abs() < 0.02);
        assert_eq!(found.steps[0].signal_to_noise(), 0.0);
        assert_eq!(found.steps[19].slope, found.steps[19].slope.clamp(0.8, 1.2));
        // Noise 0.01 sqrt(r) at a value of 2 r: the ratio is 1 at r = 2.5e-5, beyond the chart.
        assert_eq!(found.dynamic_range(), None);
        let gamma = GreySteps::measure(&chart(|r| r.powf(0.8), |_| 0.0), REGION).unwrap();
        let ends = [0, 19].map(|i| gamma.deviation(&gamma.steps[i]).unwrap());
        assert!((ends[1] - ends[0] - 0.2 * 3.8 * 10.0_f64.log2()).abs() < 0.01, "{ends:?}");
        assert_eq!(gamma.reflectance_of(1.0), None);
        // A threshold between the tenth and the eleventh step.
        let black = GreySteps::measure(&chart(|r| r - 0.01, |_| 1e-5), REGION).unwrap();
        assert_eq!(black.deviation(&black.steps[19]), None);
        let threshold = black.reflectance_of(1.0).unwrap();
        assert!((0.009..0.0143).contains(&threshold), "{threshold}");
    }

    #[test]
    fn clipping_at_black_and_white_does_not_change_the_dynamic_range() {
        for noise in [0.004_f64, 0.001] {
            let expected = (1.0 / noise).log2();
            // An overexposed picture, clipped at 1 and at 0 with its noise.
            for exposure in [0.5, 1.0, 3.0] {
                let mut picture = chart(|r| exposure * r, |_| noise);
                for pixel in &mut picture.pixels {
                    *pixel = pixel.map(|value| value.clamp(0.0, 1.0));
                }
                let found = GreySteps::measure(&picture, REGION).unwrap();
                let range = found.dynamic_range().unwrap();
                assert!(
                    (range - expected).abs() < 0.25,
                    "{noise}, {exposure}: {range}, not {expected}"
                );
                assert!((found.scale / exposure - 1.0).abs() < 0.01, "{exposure}: {}", found.scale);
            }
        }
        let clipped = chart(|r| (12.0 * r).min(1.0), |_| 0.0);
        assert_eq!(GreySteps::measure(&clipped, REGION), Err(GreysError::Clipped(6)));
    }

    #[test]
    fn the_noise_of_a_tone_curve_is_that_of_the_exposure() {
        // Before the curve, noise of 0.002 at the reflectance 1 and below.
        let gamma = |r: f64| r.powf(1.0 / 2.2);
        let noise = |r: f64| 0.002 * gamma(r) / r / 2.2;
        let found = GreySteps::measure(&chart(gamma, noise), REGION).unwrap();
        let step = &found.steps[4];
        assert!(
            (step.signal_to_noise() / (step.reflectance / 0.002) - 1.0).abs() < 0.05,
            "{step:?}"
        );
        assert!((found.saturation() - 1.0).abs() < 0.01, "{}", found.saturation());
    }

    #[test]
    fn other_pictures_are_refused() {
        let grey = Picture { size: [620, 480], pixels: vec![[0.3; 3]; 620 * 480] };
        assert_eq!(GreySteps::measure(&grey, REGION), Err(GreysError::Order));
        let turned = chart(|r| 1e-4 / r, |_| 0.0);
        assert_eq!(GreySteps::measure(&turned, REGION), Err(GreysError::Order));
        let small = GreySteps::measure(&grey, [[0, 0], [40, 30]]).unwrap_err();
        assert!(small.to_string().contains("expected at least 6 x 6"), "{small}");
    }
}
