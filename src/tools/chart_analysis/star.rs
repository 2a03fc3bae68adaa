//! Spatial frequency response of a sinusoidal Siemens star (s-SFR of ISO 12233:2023, annex E and F).

use std::f64::consts::TAU;

use petzval_image::Picture;

use super::star_fit::{SEGMENTS, StarFit};
use crate::charts::star::{CYCLES, MODULATION};

/// Least side of a region (pixels).
const LEAST: usize = 64;
/// Share of the star's radius that its largest ring has, clear of its border.
const OUTER: f64 = 0.97;
/// Pixels of a ring from which its segments can be fitted.
const LEAST_PIXELS: usize = 96;
/// Least agreement of the phases of the segments: 1 if all are the same.
const COHERENT: f64 = 0.9;
/// Least modulation of a star, relative to that of the chart, in its largest ring.
const FAINT: f64 = 0.05;

/// Why a star cannot be measured.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StarError {
    /// The region is small.
    #[error("{width} x {height} pixels; expected at least {LEAST} x {LEAST}")]
    Small {
        /// Width (pixels).
        width: usize,
        /// Height (pixels).
        height: usize,
    },
    /// The picture has a value that is not finite, or no light.
    #[error("it has pixels that are dark or not finite; expected a star of {0} cycles")]
    Dark(f64),
    /// The region shows no star.
    #[error(
        "its largest ring has {found:.3} of the modulation of a star of {cycles} cycles; expected a star in the middle \
         that fills the region"
    )]
    Faint {
        /// Modulation relative to that of the chart.
        found: f64,
        /// Cycles around the star.
        cycles: f64,
    },
    /// Segments have other phases: no centre makes them one star.
    #[error(
        "its segments are not those of one star of {cycles} cycles; expected the whole star, in the middle of the region, \
         and its number of cycles"
    )]
    Incoherent {
        /// Cycles around the star.
        cycles: f64,
    },
    /// The region has no frequency below that of the pixels.
    #[error(
        "no frequency of a star of {cycles} cycles is below 0.5 cycles/pixel in this region; expected a larger star, or fewer \
         cycles"
    )]
    Fine {
        /// Cycles around the star.
        cycles: f64,
    },
}

/// A star as its chart shows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StarChart {
    /// Cycles around the star.
    pub cycles: f64,
    /// Modulation of the reflectance.
    pub modulation: f64,
}

impl Default for StarChart {
    /// Returns the star of `petzval chart star`.
    fn default() -> Self {
        Self { cycles: CYCLES, modulation: MODULATION }
    }
}

/// Response at one frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StarRing {
    /// Frequency (cycles a pixel).
    pub frequency: f64,
    /// Response of each segment, that of the pixel included, counted clockwise from the right. Frequencies of a segment
    /// are across its radius.
    pub segments: [f64; SEGMENTS],
}

impl StarRing {
    /// Returns the least and the largest response of a segment.
    pub fn range(&self) -> [f64; 2] {
        let ends = [f64::INFINITY, 0.0];
        self.segments.into_iter().fold(ends, |[low, high], r| [low.min(r), high.max(r)])
    }

    /// Returns the mean response.
    pub fn mean(&self) -> f64 {
        self.segments.iter().sum::<f64>() / SEGMENTS as f64
    }
}

/// Spatial frequency response of a star.
#[derive(Clone, Debug, PartialEq)]
pub struct StarResponse {
    /// Centre of the star (pixels, that of the first pixel at 0).
    pub centre: [f64; 2],
    /// Rings at hundredths of a cycle a pixel, from that of the whole star to Nyquist, or to the smallest that can be
    /// fitted.
    pub rings: Vec<StarRing>,
}

impl StarResponse {
    /// Measures the star that fills a region of a picture (pixels): first column and row, and those that no longer belong
    /// to it. `value` is the channel.
    ///
    /// In each ring and segment, a sinusoid is fitted to the pixels, whose amplitude is linear in the radius. Its amplitude
    /// over their mean is the modulation, without the noise of the squared amplitude.
    ///
    /// # Errors
    /// Returns an error if the region is too small or shows no star.
    pub fn measure(
        picture: &Picture,
        [low, high]: [[usize; 2]; 2],
        chart: StarChart,
        value: impl Fn([f32; 3]) -> f64,
    ) -> Result<Self, StarError> {
        let [width, height] = [0, 1].map(|i| high[i] - low[i]);
        if width.min(height) < LEAST {
            return Err(StarError::Small { width, height });
        }
        let row = |y: usize| &picture.pixels[y * picture.size[0]..][low[0]..high[0]];
        let values: Vec<f64> = (low[1]..high[1]).flat_map(row).map(|pixel| value(*pixel)).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        if !(mean.is_finite() && mean > 0.0) {
            return Err(StarError::Dark(chart.cycles));
        }
        let outer = OUTER * width.min(height) as f64 / 2.0;
        let star = StarFit::new(values, [width, height], chart.cycles, outer);
        let response = |frequency: f64| {
            let radius = chart.cycles / (TAU * frequency);
            let segments = star.ring(radius).map(|wave| wave.modulation() / chart.modulation);
            StarRing { frequency, segments }
        };
        let largest = response(chart.cycles / (TAU * outer));
        if largest.mean() < FAINT {
            return Err(StarError::Faint { found: largest.mean(), cycles: chart.cycles });
        }
        let is_coherent = star.coherence(outer) >= COHERENT;
        if !is_coherent {
            return Err(StarError::Incoherent { cycles: chart.cycles });
        }
        let first = (100.0 * largest.frequency).ceil() as u32;
        let is_wide =
            |frequency: &f64| star.pixel_count(chart.cycles / (TAU * frequency)) >= LEAST_PIXELS;
        let frequencies = (first..=50).map(|i| f64::from(i) / 100.0);
        let rings: Vec<StarRing> = frequencies.take_while(is_wide).map(response).collect();
        if rings.is_empty() {
            return Err(StarError::Fine { cycles: chart.cycles });
        }
        Ok(Self { centre: [0, 1].map(|i| star.centre()[i] + low[i] as f64), rings })
    }

    /// Returns the lowest frequency at which the mean response falls to a level (cycles a pixel); `None` if it does not
    /// between the frequencies of the star and Nyquist.
    pub fn frequency_of(&self, level: f64) -> Option<f64> {
        self.rings.windows(2).find_map(|pair| {
            let [[f0, above], [f1, below]] = [pair[0], pair[1]].map(|r| [r.frequency, r.mean()]);
            let crosses = above >= level && below < level;
            crosses.then(|| f0 + (f1 - f0) * (above - level) / (above - below))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use petzval_base::sampler::hash;
    use petzval_base::sinc::sinc;

    /// Draws a star whose modulation is 0.6 times a response to frequency, in a picture of 401 pixels.
    fn star(centre: [f64; 2], cycles: f64, noise: f64, response: impl Fn(f64) -> f64) -> Picture {
        let side = 401;
        let pixels = (0..side * side).map(|i| {
            let [x, y] = [(i % side) as f64 - centre[0], (i / side) as f64 - centre[1]];
            let radius = x.hypot(y).max(1e-9);
            let wave = 0.6 * response(cycles / (TAU * radius)) * (cycles * y.atan2(x)).cos();
            // Uniform noise.
            let random = f64::from(hash(i as u32)) / 4_294_967_296.0 - 0.5;
            [(0.3 * (1.0 + wave) + noise * 12.0_f64.sqrt() * random) as f32; 3]
        });
        Picture { size: [side; 2], pixels: pixels.collect() }
    }

    fn measure(picture: &Picture, cycles: f64) -> Result<StarResponse, StarError> {
        let chart = StarChart { cycles, ..StarChart::default() };
        StarResponse::measure(picture, [[0, 0], [401, 401]], chart, |p| f64::from(p[1]))
    }

    #[test]
    fn responses_and_centres_are_found() {
        for (centre, cycles) in
            [([200.0, 200.0], 72.0), ([203.3, 197.9], 72.0), ([190.4, 208.0], 144.0)]
        {
            let gaussian = |f: f64| sinc(f) * (-2.0 * (TAU / 2.0 * 0.6 * f).powi(2)).exp();
            let found = measure(&star(centre, cycles, 0.0, gaussian), cycles).unwrap();
            for i in 0..2 {
                assert!((found.centre[i] - centre[i]).abs() < 0.02, "{:?}", found.centre);
            }
            assert_eq!(found.rings.last().unwrap().frequency, 0.5);
            for ring in &found.rings {
                let (off, f) = (ring.mean() - gaussian(ring.frequency), ring.frequency);
                assert!(off.abs() < 0.004, "{centre:?}, {cycles}, {f}: off by {off}");
                for segment in ring.segments {
                    assert!((segment - ring.mean()).abs() < 0.02, "{f}: {:?}", ring.segments);
                }
            }
            let half = found.frequency_of(0.5).unwrap();
            assert!((gaussian(half) - 0.5).abs() < 0.004, "{half}");
        }
    }

    #[test]
    fn noise_adds_little() {
        let none = |f: f64| if f > 0.3 { 0.0 } else { 1.0 };
        let found = measure(&star([200.0, 200.0], 72.0, 0.03, none), 72.0).unwrap();
        let beyond: Vec<f64> =
            found.rings.iter().filter(|r| r.frequency > 0.32).map(StarRing::mean).collect();
        let mean = beyond.iter().sum::<f64>() / beyond.len() as f64;
        // Squares of noise are rectified: without the subtraction it would be 0.08.
        assert!(mean < 0.04, "{mean}");
        let below = &found.rings[0];
        assert!((below.mean() - 1.0).abs() < 0.02, "{below:?}");
        assert!((found.frequency_of(0.5).unwrap() - 0.3).abs() < 0.015);
        assert_eq!(
            measure(&star([200.0, 200.0], 72.0, 0.0, |_| 1.0), 72.0).unwrap().frequency_of(0.5),
            None
        );
    }

    #[test]
    fn pictures_without_a_star_are_refused() {
        let grey = Picture { size: [401; 2], pixels: vec![[0.3; 3]; 401 * 401] };
        assert!(matches!(measure(&grey, 72.0), Err(StarError::Faint { .. })));
        let other = star([200.0, 200.0], 36.0, 0.0, |_| 1.0);
        assert!(matches!(measure(&other, 72.0), Err(StarError::Faint { .. })));
        // Far from the middle, or with a cycle more or less.
        for (centre, cycles) in [
            ([225.0, 200.0], 72.0),
            ([220.0, 180.0], 72.0),
            ([200.0, 230.0], 72.0),
            ([200.0; 2], 71.0),
            ([200.0; 2], 73.0),
        ] {
            let found = measure(&star(centre, cycles, 0.0, |_| 1.0), 72.0);
            assert_eq!(found, Err(StarError::Incoherent { cycles: 72.0 }), "{centre:?}, {cycles}");
        }
        let fine = measure(&star([200.0, 200.0], 720.0, 0.0, |_| 1.0), 720.0);
        assert_eq!(fine, Err(StarError::Fine { cycles: 720.0 }));
        // Rings of few pixels are left out.
        let few = measure(&star([200.0, 200.0], 8.0, 0.0, |_| 1.0), 8.0).unwrap();
        assert!(few.rings.last().unwrap().frequency < 0.2, "{:?}", few.rings.last());
        assert!(few.rings.iter().all(|ring| (ring.mean() - 1.0).abs() < 0.01));
        let dark = Picture { size: [401; 2], pixels: vec![[0.0; 3]; 401 * 401] };
        assert!(matches!(measure(&dark, 72.0), Err(StarError::Dark(_))));
        let mut spoiled = star([200.0, 200.0], 72.0, 0.0, |_| 1.0);
        spoiled.pixels[77] = [f32::NAN; 3];
        assert!(matches!(measure(&spoiled, 72.0), Err(StarError::Dark(_))));
        let chart = StarChart::default();
        let small = StarResponse::measure(&grey, [[0, 0], [63, 200]], chart, |p| f64::from(p[0]));
        assert_eq!(small, Err(StarError::Small { width: 63, height: 200 }));
    }
}
