//! How the film turns the light of a sample into what its pixel adds up.

use glam::{DMat3, DVec3};

use super::filter::Filter;
use crate::spectrum::xyz_from_srgb;

/// What a film does with samples. By default nothing: all count the same, as they are.
#[derive(Clone, Debug, Default)]
pub struct Response {
    /// Where samples lie about their pixel, and what they count.
    pub filter: Filter,
    /// The largest X, Y or Z of a sample; brighter ones are scaled down to it (pbrt-v4's
    /// `maxcomponentvalue`). It costs energy where it works, and fireflies.
    pub brightest: Option<f64>,
    /// Linear sRGB to linear sRGB, so that what lights the scene looks white.
    pub balance: Option<DMat3>,
}

impl Response {
    /// What a sample of this light adds.
    #[inline(always)]
    pub(super) fn to(&self, mut light: [f64; 3]) -> [f64; 3] {
        if let Some(limit) = self.brightest {
            let most = xyz_from_srgb(light).into_iter().fold(0.0, f64::max);
            if most > limit {
                light = light.map(|c| c * limit / most);
            }
        }
        self.balanced(light)
    }

    /// Light that is no single sample's, in the film's white.
    pub fn balanced(&self, light: [f64; 3]) -> [f64; 3] {
        match &self.balance {
            Some(balance) => (*balance * DVec3::from_array(light)).to_array(),
            None => light,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::white_balance;

    #[test]
    fn the_brightest_samples_keep_their_colour() {
        let film = Response { brightest: Some(2.0), ..Response::default() };
        assert_eq!(film.to([0.5, 0.25, 0.125]), [0.5, 0.25, 0.125]);
        let [r, g, b] = film.to([100.0, 50.0, 25.0]);
        assert!((r / g - 2.0).abs() < 1e-12 && (g / b - 2.0).abs() < 1e-12);
        let most = xyz_from_srgb([r, g, b]).into_iter().fold(0.0, f64::max);
        assert!((most - 2.0).abs() < 1e-12);
    }

    #[test]
    fn what_lights_the_scene_looks_white() {
        // Daylight of 9000 K is bluish; a surface white under it comes out white.
        let film = Response { balance: Some(white_balance(9000.0)), ..Response::default() };
        let [r, g, b] = film.to([1.0; 3]);
        assert!(r > 1.05 && b < 0.9, "{r} {g} {b}");
        let neutral = Response { balance: Some(white_balance(6500.0)), ..Response::default() };
        assert!(
            neutral
                .to([1.0, 0.5, 0.2])
                .into_iter()
                .zip([1.0, 0.5, 0.2])
                .all(|(a, b)| (a - b).abs() < 1e-9)
        );
    }
}
