//! Tone curves: from linear light to the light of a screen, for files for display.

use std::str::FromStr;

/// Curve from exposed linear light to the light of a screen, before the sRGB transfer curve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum ToneCurve {
    /// The light itself. Light above 1 is clipped, each channel alone.
    #[default]
    Linear,
    /// The curve of the ACES reference rendering in the fit of Narkowicz (2016), scaled so that
    /// middle grey (0.18) stays. White is reached 3.3 stops above 1. The hue stays; highlights lose
    /// saturation on their way to white.
    Filmic,
}

impl FromStr for ToneCurve {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "linear" => Ok(Self::Linear),
            "filmic" => Ok(Self::Filmic),
            _ => Err("expected linear or filmic".to_owned()),
        }
    }
}

/// Scale of the light by which the curve keeps middle grey: the curve has 0.18 at 0.18 of this.
const FILMIC_SCALE: f32 = 0.7232;

/// Narkowicz, "ACES Filmic Tone Mapping Curve" (2016), for light of at least 0.
fn filmic(light: f32) -> f32 {
    // Further light is white, and its square may overflow.
    let x = (light * FILMIC_SCALE).min(100.0);
    ((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14)).min(1.0)
}

impl ToneCurve {
    /// Applies the curve to a pixel. NaN and light below 0 become black with the filmic curve.
    pub fn apply(self, pixel: [f32; 3]) -> [f32; 3] {
        if self == Self::Linear {
            return pixel;
        }
        let lit = pixel.map(|v| if v > 0.0 { v.min(f32::MAX) } else { 0.0 });
        let largest = lit[0].max(lit[1]).max(lit[2]);
        if largest == 0.0 {
            return [0.0; 3];
        }
        // The curve of the largest channel alone keeps the ratios of the channels. A mixture with
        // grey keeps the hue, and makes bright highlights white as film does.
        let shown = filmic(largest);
        let excess = (largest.max(1.0).log2() / HIGHLIGHT_STOPS).min(1.0);
        let whiteness = excess * excess * (3.0 - 2.0 * excess);
        lit.map(|v| {
            let kept = shown * (v / largest);
            kept + whiteness * (shown - kept)
        })
    }
}

/// Stops above 1 over which a highlight becomes white.
const HIGHLIGHT_STOPS: f32 = 5.0;

#[cfg(test)]
mod tests {
    use super::*;

    const FILMIC: ToneCurve = ToneCurve::Filmic;

    #[test]
    fn middle_grey_stays_and_light_above_white_keeps_its_order() {
        let grey = FILMIC.apply([0.18; 3]);
        assert!((grey[0] - 0.18).abs() < 1e-3, "{grey:?}");
        let mut last = -1.0;
        for step in 0..=130 {
            let shown = FILMIC.apply([0.001 * 1.072_f32.powi(step); 3])[1];
            assert!(shown > last && shown <= 1.0, "step {step}: {shown} after {last}");
            last = shown;
        }
        assert_eq!(ToneCurve::Linear.apply([7.0, -1.0, 0.5]), [7.0, -1.0, 0.5]);
    }

    /// Returns the position of the middle channel between the others: the hue within its sextant.
    fn hue([r, g, b]: [f32; 3]) -> f32 {
        (g - b) / (r - b)
    }

    #[test]
    fn the_hue_stays_and_the_brightest_light_is_white() {
        for stops in -6..5 {
            let light = [1.0, 0.4, 0.1].map(|v| v * (stops as f32).exp2());
            let shown = FILMIC.apply(light);
            assert!((hue(shown) - hue(light)).abs() < 1e-4, "{stops} stops: {shown:?}");
        }
        for light in [[64.0, 6.0, 1.0], [f32::MAX; 3], [f32::INFINITY; 3]] {
            assert!(FILMIC.apply(light).iter().all(|v| (v - 1.0).abs() < 1e-6), "{light:?}");
        }
        let dark = [[f32::NAN; 3], [-1.0, 0.0, -0.0], [0.0; 3]];
        assert!(dark.into_iter().all(|light| FILMIC.apply(light) == [0.0; 3]));
    }
}
