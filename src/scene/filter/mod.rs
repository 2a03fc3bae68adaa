//! Pixel filters: the positions of samples about their pixel, and their weights.
//!
//! Positions are sampled in proportion to the magnitude of the filter (Ernst, Stamminger & Greiner
//! 2006, "Filter importance sampling"). A sample belongs to one pixel, and all samples have the
//! same weight, except for filters with negative lobes, where the weight has the filter's sign.

mod axis;

use std::f64::consts::PI;

use axis::FilterAxis;

/// Filter function of the distance from the pixel's centre (pixels), 0 beyond a radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Profile {
    /// Constant.
    Box,
    /// radius - |x|.
    Triangle,
    /// A normal density minus its value at the radius, clamped to >= 0.
    Gaussian {
        /// Standard deviation (pixels).
        sigma: f64,
    },
    /// The cubic of Mitchell & Netravali 1988, "Reconstruction filters in computer graphics",
    /// scaled from its radius of 2.
    Mitchell {
        /// Parameter B of the cubic.
        b: f64,
        /// Parameter C of the cubic.
        c: f64,
    },
    /// Lanczos' windowed sinc(x) sinc(x / tau), with sinc(x) = sin(pi x) / (pi x).
    Sinc {
        /// Radius of the window (lobes).
        tau: f64,
    },
}

impl Profile {
    /// Returns the unnormalised value at a distance within the radius.
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

/// Filter of a picture's pixels: the product of a function of x and one of y.
#[derive(Clone, Debug)]
pub struct PixelFilter {
    axes: [FilterAxis; 2],
}

impl Default for PixelFilter {
    /// The box of one pixel.
    fn default() -> Self {
        Self::new(Profile::Box, [0.5; 2])
    }
}

impl PixelFilter {
    /// The same function along both axes, with a radius (pixels) for each.
    pub fn new(profile: Profile, radius: [f64; 2]) -> Self {
        Self { axes: radius.map(|radius| FilterAxis::new(profile, radius)) }
    }

    /// Returns the largest distance of samples beyond the edges of their pixel (pixels).
    pub fn margin(&self) -> [f64; 2] {
        self.axes.each_ref().map(|axis| (axis.radius - 0.5).max(0.0))
    }

    /// Returns whether the filter has negative lobes, so that samples have weights other than 1.
    pub fn is_signed(&self) -> bool {
        self.axes.iter().any(|axis| !axis.weights.is_empty())
    }

    /// Replaces random numbers in [0, 1) by positions along an axis, relative to the pixel's
    /// centre.
    pub fn place(&self, axis: usize, u: &mut [f32]) {
        for u in u {
            *u = self.axes[axis].place(*u);
        }
    }

    /// Multiplies each value by the unnormalised filter at a position relative to the pixel's
    /// centre.
    pub fn multiply(&self, positions: [&[f32]; 2], values: &mut [f32]) {
        for (axis, positions) in self.axes.iter().zip(positions) {
            axis.multiply(positions, values);
        }
    }

    /// Calls `add` with each pixel whose filter contains a point of the picture [pixels from its top
    /// left], and with the value of the filter there. The integral of the filter over the picture is
    /// 1.
    pub fn pixels_at(&self, at: [f64; 2], mut add: impl FnMut([i64; 2], f64)) {
        let [columns, rows] = [0, 1].map(|i| {
            let (middle, radius) = (at[i] - 0.5, self.axes[i].radius);
            (middle - radius).ceil() as i64..=(middle + radius).floor() as i64
        });
        // Filter along an axis at the centres of eight pixels.
        let values = |axis: usize, first: i64| {
            let axis_filter = &self.axes[axis];
            let position = |i: i64| (at[axis] - 0.5 - (first + i) as f64) as f32;
            let values = axis_filter.values_at(&[0, 1, 2, 3, 4, 5, 6, 7].map(position));
            values.map(|value| f64::from(value) / axis_filter.integral)
        };
        for first_row in rows.clone().step_by(8) {
            let along_y = values(1, first_row);
            for first_column in columns.clone().step_by(8) {
                let along_x = values(0, first_column);
                for (row, y) in (first_row..=*rows.end()).zip(along_y) {
                    for (column, x) in (first_column..=*columns.end()).zip(along_x) {
                        add([column, row], y * x);
                    }
                }
            }
        }
    }

    /// Returns the weight of the sample whose position these random numbers choose; 1 on average.
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
    fn weighted_samples_have_the_moments_of_the_filter() {
        for (profile, radius) in PROFILES {
            let filter = PixelFilter::new(profile, [radius, 1.0]);
            // Moments from samples and from integration.
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
    fn values_are_the_profile_inside_the_radius_and_zero_beyond() {
        for (profile, radius) in PROFILES {
            let filter = PixelFilter::new(profile, [radius, 0.5 * radius]);
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
            let mut none = [1.0, f32::INFINITY];
            filter.multiply([&[f32::NAN, 0.0], &[0.0, f32::INFINITY]], &mut none);
            assert_eq!(none, [0.0; 2], "{profile:?}");
        }
    }

    #[test]
    fn many_values_are_multiplied_as_one_is() {
        for (profile, radius) in PROFILES {
            let filter = PixelFilter::new(profile, [radius, 0.7 * radius]);
            for count in [0, 1, 7, 8, 9, 19, 64] {
                let position = |i: u8| 0.13 * f32::from(i) - 2.0;
                let x: Vec<f32> = (0..count).map(position).collect();
                let y: Vec<f32> = x.iter().map(|x| 0.3 - 0.5 * x).collect();
                let mut together: Vec<f32> = (0..count).map(|i| f32::from(i) + 1.0).collect();
                let alone = |(i, value): (usize, &f32)| {
                    let mut value = [*value];
                    filter.multiply([&x[i..=i], &y[i..=i]], &mut value);
                    value[0]
                };
                let alone: Vec<f32> = together.iter().enumerate().map(alone).collect();
                filter.multiply([&x, &y], &mut together);
                assert_eq!(together, alone, "{profile:?}");
            }
        }
    }

    #[test]
    fn a_wide_filter_reaches_all_its_pixels_once() {
        let radius = 9.65;
        let filter = PixelFilter::new(Profile::Triangle, [radius; 2]);
        let at = [103.2, 40.9];
        let (mut seen, mut sum) = (Vec::new(), 0.0);
        filter.pixels_at(at, |pixel, share| {
            let along = |i: usize| radius - (at[i] - 0.5 - pixel[i] as f64).abs();
            let expected = along(0) * along(1) / radius.powi(4);
            assert!((share - expected).abs() < 1e-4 * expected.max(1e-2), "{pixel:?}: {share}");
            seen.push(pixel);
            sum += share;
        });
        seen.sort_unstable();
        seen.dedup();
        let inside = |i: usize| {
            let near = |pixel: &i32| (at[i] - 0.5 - f64::from(*pixel)).abs() <= radius;
            (0..200).filter(near).count()
        };
        assert_eq!(seen.len(), inside(0) * inside(1));
        assert!((sum - 1.0).abs() < 0.01, "{sum}");
    }

    #[test]
    fn the_pixels_at_random_points_share_their_light_as_samples_of_the_pixels_do() {
        for (profile, radius) in PROFILES {
            let filter = PixelFilter::new(profile, [radius, 0.7 * radius]);
            // The sum over points that are uniform over the picture is 1 in every pixel.
            let (mut sum, side) = (0.0, 600);
            for i in 0..side * side {
                let at =
                    [i % side, i / side].map(|k| 11.0 * (f64::from(k) + 0.5) / f64::from(side));
                filter.pixels_at(at, |pixel, share| {
                    if pixel == [5, 5] {
                        sum += share * (11.0 / f64::from(side)).powi(2);
                    }
                });
            }
            assert!((sum - 1.0).abs() < 3e-2, "{profile:?}: {sum}");
        }
    }

    #[test]
    fn only_filters_with_negative_lobes_are_signed() {
        let signed =
            PROFILES.map(|(profile, radius)| PixelFilter::new(profile, [radius; 2]).is_signed());
        assert_eq!(signed, [false, false, false, true, true]);
    }

    #[test]
    fn the_default_filter_is_the_box_of_one_pixel() {
        let mut places = [0.0, 0.25, 0.75];
        PixelFilter::default().place(0, &mut places);
        assert_eq!(places, [-0.5, -0.25, 0.25]);
    }
}
