//! Sinusoidal Siemens star (ISO 12233:2023, annex E).

use std::f64::consts::TAU;

use petzval_base::sinc::sinc;
use petzval_image::Picture;

/// Cycles around the star.
pub(crate) const CYCLES: f64 = 72.0;
/// Reflectance of the background, about which that of the star varies, and the modulation of the star: a contrast of
/// 4:1, as that of edges.
pub(super) const MIDDLE: f64 = 0.45;
pub(crate) const MODULATION: f64 = 0.6;
/// Texels along each side of a pixel of the camera.
const TEXELS: usize = 6;
/// Highest frequency (cycles a pixel). The middle of the star is grey.
const HIGHEST: f64 = 1.0;

/// Returns a star that fills a square of so many pixels of a camera along each side. Values are reflectances.
///
/// A texel shows one value over its square, which takes modulation at high frequencies. The star has as much more.
pub(super) fn star(pixels: usize) -> Picture {
    let side = pixels * TEXELS;
    let reflectance = |i: usize| {
        let at = |n: usize| (n as f64 + 0.5) / TEXELS as f64 - pixels as f64 / 2.0;
        let [x, y] = [at(i % side), at(i / side)];
        let radius = x.hypot(y);
        let frequency = CYCLES / (TAU * radius);
        if radius > pixels as f64 / 2.0 || frequency > HIGHEST {
            return MIDDLE;
        }
        // Crests are along the radius: the wave vector is across it.
        let texel = |share: f64| sinc(frequency * share / (radius * TEXELS as f64));
        let modulation = MODULATION / (texel(x) * texel(y));
        MIDDLE * (1.0 + modulation * (CYCLES * y.atan2(x)).cos())
    };
    let pixels = (0..side * side).map(|i| [reflectance(i) as f32; 3]).collect();
    Picture { size: [side; 2], pixels }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_star_has_its_cycles_and_its_modulation() {
        let pixels = 120;
        let Picture { size: [side, _], pixels: texels } = star(pixels);
        assert_eq!(side, 720);
        let at = |radius: f64, angle: f64| {
            let place = |offset: f64| ((pixels as f64 / 2.0 + offset) * TEXELS as f64) as usize;
            let [x, y] = [radius * angle.cos(), radius * angle.sin()].map(place);
            f64::from(texels[y * side + x][0])
        };
        let mut middle_crossings = 0;
        let count = 5000;
        let around = |i: usize| at(50.0, TAU * i as f64 / count as f64);
        let (mut low, mut high) = (1.0_f64, 0.0_f64);
        for i in 0..count {
            middle_crossings += usize::from((around(i) > MIDDLE) != (around(i + 1) > MIDDLE));
            (low, high) = (low.min(around(i)), high.max(around(i)));
        }
        assert_eq!(middle_crossings, 144);
        assert!((low - 0.18).abs() < 0.005 && (high - 0.72).abs() < 0.005, "{low} {high}");
        assert_eq!(at(9.0, 0.3), MIDDLE as f32 as f64);
        assert_eq!(f64::from(texels[0][0]), MIDDLE as f32 as f64);
    }
}
