//! Dead leaves: discs of random size and grey that cover each other, whose spectrum is known.
//!
//! Radii have the density r^-3 between two ends, so that the texture looks alike at all sizes between them
//! (Cao, Guichard & Hornung 2009, and ISO/TS 19567-2). Discs are drawn from the front to the back until
//! nothing shows through, so that the picture is a sample of the stationary model.

use petzval_base::sampler::hash;
use petzval_image::Picture;

/// Texels along each side of a pixel of the camera.
const TEXELS: usize = 6;
/// Smallest radius (pixels of the camera), and the largest relative to the side of the texture.
const SMALLEST: f64 = 1.0;
const LARGEST: f64 = 0.2;
/// Reflectances between which discs are grey: a contrast of 4:1 about 18 %.
const REFLECTANCES: [f64; 2] = [0.072, 0.288];

/// Sequence of uniform random numbers.
struct Random {
    key: u32,
    drawn: u32,
}

impl Random {
    fn uniform(&mut self) -> f64 {
        self.drawn = self.drawn.wrapping_add(1);
        (f64::from(hash(self.key ^ hash(self.drawn))) + 0.5) / 4_294_967_296.0
    }
}

/// Returns a square of leaves for so many pixels of a camera along each side, with [`TEXELS`] texels for each
/// pixel. Values are reflectances.
pub fn leaves(pixels: usize, seed: u32) -> Picture {
    let side = pixels * TEXELS;
    let [smallest, largest] = [SMALLEST * TEXELS as f64, LARGEST * side as f64];
    let mut random = Random { key: hash(seed), drawn: 0 };
    let mut grey = vec![f32::NAN; side * side];
    let mut left = grey.len();
    while left > 0 {
        let radius = radius(random.uniform(), [smallest, largest]);
        // Centres as far outside as the largest disc reaches, so that borders are like the middle.
        let [x, y] = [(); 2].map(|()| random.uniform() * (side as f64 + 2.0 * largest) - largest);
        let [low, high] = REFLECTANCES;
        let reflectance = (low + (high - low) * random.uniform()) as f32;
        let rows = covered(y, radius, side);
        for row in rows {
            let above = row as f64 + 0.5 - y;
            let half = (radius * radius - above * above).max(0.0).sqrt();
            for texel in &mut grey[row * side..][covered(x, half, side)] {
                if texel.is_nan() {
                    (*texel, left) = (reflectance, left - 1);
                }
            }
        }
    }
    Picture { size: [side; 2], pixels: grey.into_iter().map(|value| [value; 3]).collect() }
}

/// Returns the radius at a share of the distribution of density r^-3 between two radii.
fn radius(share: f64, [smallest, largest]: [f64; 2]) -> f64 {
    let [a, b] = [smallest, largest].map(|radius| radius.powi(-2));
    (a - share * (a - b)).powf(-0.5)
}

/// Returns the texels of a row or column whose middles are nearer than a distance to a place.
fn covered(place: f64, distance: f64, side: usize) -> std::ops::Range<usize> {
    let end = |at: f64| (at + 0.5).floor().clamp(0.0, side as f64) as usize;
    let (first, last) = (end(place - distance), end(place + distance));
    first.min(last)..last
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// Returns the covariance of the reflectances at a distance (pixels of the camera), relative to their
    /// variance, of leaves on so many pixels along each side.
    ///
    /// Two points have the same grey if the frontmost disc that covers one of them covers both: of discs of one
    /// radius r, the areas that cover one point, and both, are pi r^2 and the overlap of two discs.
    fn covariance(distance: f64, pixels: usize) -> f64 {
        let ends = [SMALLEST, LARGEST * pixels as f64];
        // Equal steps of the logarithm of the radius: a density r^-3 dr is r^-2 d(ln r).
        let steps = 4000;
        let [low, high] = ends.map(f64::ln);
        let (mut both, mut one) = (0.0, 0.0);
        for i in 0..steps {
            let radius = (low + (high - low) * (f64::from(i) + 0.5) / f64::from(steps)).exp();
            let u = (distance / radius).min(2.0);
            let overlap = 2.0 * (u / 2.0).acos() - u / 2.0 * (4.0 - u * u).max(0.0).sqrt();
            both += overlap;
            one += PI;
        }
        both / (2.0 * one - both)
    }

    #[test]
    fn radii_have_the_density_of_their_third_power() {
        let ends = [2.0, 50.0];
        assert!((radius(0.0, ends) - 2.0).abs() < 1e-12 && (radius(1.0, ends) - 50.0).abs() < 1e-9);
        // The share below r: (1 / 4 - 1 / r^2) / (1 / 4 - 1 / 2500).
        let share = (0.25 - 1.0 / 25.0) / (0.25 - 1.0 / 2500.0);
        assert!((radius(share, ends) - 5.0).abs() < 1e-12);
    }

    #[test]
    fn leaves_have_the_covariance_of_the_model() {
        let pixels = 96;
        let distances = [1, 3, 8, 20];
        let (mut sums, mut variance, mut count) = ([0.0; 4], 0.0, 0.0);
        let [low, high] = REFLECTANCES;
        let middle = (low + high) / 2.0;
        for seed in 0..24 {
            let Picture { size: [side, _], pixels } = leaves(pixels, seed);
            let at = |x: usize, y: usize| f64::from(pixels[y * side + x][0]) - middle;
            for y in 0..side {
                for x in 0..side - 20 * TEXELS {
                    variance += at(x, y) * at(x, y);
                    count += 1.0;
                    for (sum, distance) in sums.iter_mut().zip(distances) {
                        *sum += at(x, y) * at(x + distance * TEXELS, y);
                    }
                }
            }
        }
        let expected = (high - low).powi(2) / 12.0;
        assert!((variance / count / expected - 1.0).abs() < 0.1, "{} {expected}", variance / count);
        for (sum, distance) in sums.into_iter().zip(distances) {
            let (found, expected) = (sum / variance, covariance(distance as f64, pixels));
            println!("{distance}: {found} {expected}");
            assert!((found - expected).abs() < 0.03, "{distance}: {found}, not {expected}");
        }
    }
}
