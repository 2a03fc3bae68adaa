//! Pixel filters: how far from its pixel a sample may lie, and what it counts there.
//!
//! A sample belongs to one pixel and lies where the pixel's filter is large (Ernst, Stamminger &
//! Greiner 2006, "Filter importance sampling"), so that all samples count the same, but for
//! filters that go below 0: there they count less than nothing.

use std::f64::consts::PI;

/// A function of the distance from the pixel's centre, in pixels, that is 0 beyond a radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Profile {
    /// The same everywhere.
    Box,
    /// radius - |x|.
    Triangle,
    /// A normal density, less its value at the radius, where that is above 0.
    Gaussian {
        /// Standard deviation, pixels.
        sigma: f64,
    },
    /// The cubic of Mitchell & Netravali 1988, "Reconstruction filters in computer graphics",
    /// stretched from its radius of 2.
    Mitchell {
        /// Their B.
        b: f64,
        /// Their C.
        c: f64,
    },
    /// sinc(x) sinc(x / tau), sinc(x) = sin(pi x) / (pi x) (Lanczos).
    Sinc {
        /// How many lobes the window is wide.
        tau: f64,
    },
}

impl Profile {
    /// Its value at a distance within the radius, up to a factor.
    fn at(self, x: f64, radius: f64) -> f64 {
        let x = x.abs();
        match self {
            Self::Box => 1.0,
            Self::Triangle => radius - x,
            Self::Gaussian { sigma } => {
                let normal = |x: f64| (-x * x / (2.0 * sigma * sigma)).exp();
                (normal(x) - normal(radius)).max(0.0)
            }
            Self::Mitchell { b, c } => {
                let x = 2.0 * x / radius;
                if x <= 1.0 {
                    ((12.0 - 9.0 * b - 6.0 * c) * x - 18.0 + 12.0 * b + 6.0 * c) * x * x + 6.0
                        - 2.0 * b
                } else {
                    (((-b - 6.0 * c) * x + 6.0 * b + 30.0 * c) * x - 12.0 * b - 48.0 * c) * x
                        + 8.0 * b
                        + 24.0 * c
                }
            }
            Self::Sinc { tau } => {
                let sinc = |x: f64| if x < 1e-5 { 1.0 } else { (PI * x).sin() / (PI * x) };
                sinc(x) * sinc(x / tau)
            }
        }
    }
}

/// Steps of the table of a radius.
const STEPS: usize = 2048;

/// A filter along one axis.
#[derive(Clone, Debug)]
struct Axis {
    radius: f64,
    /// Where the distribution of the filter's magnitude reaches each share of its whole, of
    /// [`STEPS`] + 1; empty for a box.
    reached: Vec<f32>,
    /// What samples of each step count, 1 on average; empty where the filter is nowhere below 0.
    weights: Vec<f32>,
    /// The filter at the steps' edges from its middle to its radius, and once more there; empty for
    /// a box.
    values: Vec<f32>,
}

impl Axis {
    fn new(profile: Profile, radius: f64) -> Self {
        if profile == Profile::Box {
            return Self { radius, reached: Vec::new(), weights: Vec::new(), values: Vec::new() };
        }
        let cells = 16 * STEPS;
        let edge = |i: usize| radius * (2.0 * i as f64 / cells as f64 - 1.0);
        // Integrals from the left edge, of the filter and of its magnitude.
        let mut sums = vec![[0.0; 2]];
        let (mut sum, mut signed) = ([0.0; 2], false);
        for i in 0..cells {
            let value = profile.at((edge(i) + edge(i + 1)) / 2.0, radius);
            signed |= value < 0.0;
            sum = [sum[0] + value, sum[1] + value.abs()];
            sums.push(sum);
        }
        // By share of the magnitude: the place, and the integral of the filter to there.
        let mut cell = 0;
        let reached: Vec<[f64; 2]> = (0..=STEPS)
            .map(|i| {
                let goal = sum[1] * i as f64 / STEPS as f64;
                while cell + 1 < cells && sums[cell + 1][1] < goal {
                    cell += 1;
                }
                let width = sums[cell + 1][1] - sums[cell][1];
                let within = if width > 0.0 { (goal - sums[cell][1]) / width } else { 0.0 };
                let within = within.clamp(0.0, 1.0);
                let between = |a: f64, b: f64| a + within * (b - a);
                [between(edge(cell), edge(cell + 1)), between(sums[cell][0], sums[cell + 1][0])]
            })
            .collect();
        let share = |step: &[[f64; 2]]| ((step[1][1] - step[0][1]) / sum[0] * STEPS as f64) as f32;
        let weights = if signed { reached.windows(2).map(share).collect() } else { Vec::new() };
        let value = |i: usize| {
            let distance = radius * i.min(STEPS) as f64 / STEPS as f64;
            profile.at(distance, radius) as f32
        };
        let values = (0..STEPS + 2).map(value).collect();
        Self { radius, reached: reached.iter().map(|at| at[0] as f32).collect(), weights, values }
    }

    /// Multiplies numbers by the filter at places along the axis, from the pixel's centre.
    fn multiply(&self, places: &[f32], numbers: &mut [f32]) {
        let radius = self.radius as f32;
        if self.values.is_empty() {
            for (number, place) in numbers.iter_mut().zip(places) {
                *number = if place.abs() <= radius { *number } else { 0.0 };
            }
            return;
        }
        let per_step = STEPS as f32 / radius;
        for (number, place) in numbers.iter_mut().zip(places) {
            // Not for what is no number either.
            *number = if place.abs() <= radius {
                let scaled = place.abs() * per_step;
                let step = (scaled as usize).min(STEPS);
                let [low, high] = [self.values[step], self.values[step + 1]];
                *number * (scaled - step as f32).mul_add(high - low, low)
            } else {
                0.0
            };
        }
    }

    /// The place, from the pixel's centre, that a number in [0, 1) chooses.
    #[inline(always)]
    fn place(&self, u: f32) -> f32 {
        if self.reached.is_empty() {
            return (2.0 * u - 1.0) * self.radius as f32;
        }
        let (step, scaled) = (step(u), u * STEPS as f32);
        let [low, high] = [self.reached[step], self.reached[step + 1]];
        (scaled - step as f32).mul_add(high - low, low)
    }

    fn weight(&self, u: f32) -> f32 {
        self.weights.get(step(u)).copied().unwrap_or(1.0)
    }
}

/// The step of the tables that a number in [0, 1) falls into.
#[inline(always)]
fn step(u: f32) -> usize {
    ((u * STEPS as f32) as usize).min(STEPS - 1)
}

/// The filter of a picture's pixels: a product of one function of x and one of y.
#[derive(Clone, Debug)]
pub struct Filter {
    axes: [Axis; 2],
}

impl Default for Filter {
    /// The pixel itself.
    fn default() -> Self {
        Self::new(Profile::Box, [0.5; 2])
    }
}

impl Filter {
    /// The same function along both axes, with a radius each, pixels.
    pub fn new(profile: Profile, radius: [f64; 2]) -> Self {
        Self { axes: radius.map(|radius| Axis::new(profile, radius)) }
    }

    /// How far beyond the edges of their pixel samples lie at most, pixels.
    pub fn reach(&self) -> [f64; 2] {
        self.axes.each_ref().map(|axis| (axis.radius - 0.5).max(0.0))
    }

    /// Whether samples may count different from 1.
    pub fn signed(&self) -> bool {
        self.axes.iter().any(|axis| !axis.weights.is_empty())
    }

    /// Moves numbers in [0, 1) to places along an axis, from the middle of the pixel.
    pub fn place(&self, axis: usize, u: &mut [f32]) {
        for u in u {
            *u = self.axes[axis].place(*u);
        }
    }

    /// Multiplies numbers by the filter, up to a factor, at places from the middle of the pixel.
    pub fn multiply(&self, places: [&[f32]; 2], numbers: &mut [f32]) {
        for (axis, places) in self.axes.iter().zip(places) {
            axis.multiply(places, numbers);
        }
    }

    /// What the sample counts whose place these numbers choose; 1 on average.
    pub fn weight(&self, u: [f32; 2]) -> f32 {
        self.axes[0].weight(u[0]) * self.axes[1].weight(u[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PROFILES: [(Profile, f64); 5] = [
        (Profile::Box, 0.5),
        (Profile::Triangle, 2.0),
        (Profile::Gaussian { sigma: 0.5 }, 1.5),
        (Profile::Mitchell { b: 1.0 / 3.0, c: 1.0 / 3.0 }, 2.0),
        (Profile::Sinc { tau: 3.0 }, 4.0),
    ];

    #[test]
    fn samples_are_weighted_as_the_filter_says() {
        for (profile, radius) in PROFILES {
            let filter = Filter::new(profile, [radius, 1.0]);
            // Moments by samples and by integration.
            let (mut sampled, mut whole) = ([0.0; 2], [0.0; 2]);
            let count = 200_000;
            for i in 0..count {
                let at = (f64::from(i) + 0.5) / f64::from(count);
                let x = filter.axes[0].place(at as f32);
                assert!(f64::from(x.abs()) <= radius, "{profile:?}: {x}");
                let weight = f64::from(filter.axes[0].weight(at as f32));
                let there = radius * (2.0 * at - 1.0);
                let value = profile.at(there, radius);
                for (power, moments) in [0, 1].into_iter().zip(sampled.iter_mut().zip(&mut whole)) {
                    *moments.0 += weight * f64::from(x).powi(2 * power) / f64::from(count);
                    *moments.1 += value * there.powi(2 * power);
                }
            }
            let scale = whole[0];
            for (found, expected) in sampled.iter().zip(whole.map(|moment| moment / scale)) {
                let off = (found - expected).abs();
                assert!(off < 4e-3 * expected.abs().max(0.1), "{profile:?}: {sampled:?} {whole:?}");
            }
        }
    }

    #[test]
    fn values_are_the_profile_inside_the_radius_and_nothing_beyond() {
        for (profile, radius) in PROFILES {
            let filter = Filter::new(profile, [radius, 0.5 * radius]);
            for i in -1300..1300i16 {
                let [x, y] = [f64::from(i) * 1e-3 * radius, f64::from(i) * 0.3e-3 * radius];
                let mut found = [2.0];
                filter.multiply([&[x as f32], &[y as f32]], &mut found);
                let inside = x.abs() <= radius && y.abs() <= 0.5 * radius;
                let product = 2.0 * profile.at(x, radius) * profile.at(y, 0.5 * radius);
                let expected = if inside { product } else { 0.0 };
                let off = (f64::from(found[0]) - expected).abs();
                assert!(off < 2e-5 * 2.0 * profile.at(0.0, radius).powi(2), "{profile:?} {x} {y}");
            }
            let mut none = [1.0];
            filter.multiply([&[f32::NAN], &[0.0]], &mut none);
            assert_eq!(none, [0.0], "{profile:?}");
        }
    }

    #[test]
    fn only_filters_that_go_below_zero_are_signed() {
        let signed = PROFILES.map(|(profile, radius)| Filter::new(profile, [radius; 2]).signed());
        assert_eq!(signed, [false, false, false, true, true]);
    }

    #[test]
    fn a_pixel_is_its_own_filter_by_default() {
        let mut places = [0.0, 0.25, 0.75];
        Filter::default().place(0, &mut places);
        assert_eq!(places, [-0.5, -0.25, 0.25]);
    }
}
