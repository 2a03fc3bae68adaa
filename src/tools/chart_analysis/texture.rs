//! Texture: the spatial frequency response that a camera has to a chart of fine random detail.

use std::f64::consts::TAU;

use petzval_base::sinc::sinc;
use petzval_image::Picture;
use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

/// Bins of frequency up to Nyquist.
const BINS: usize = 25;
/// Least width and height of a region (pixels).
const LEAST: usize = 64;

/// Error of a texture that cannot be measured.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TextureError {
    /// The region is small.
    #[error("{width} x {height} pixels; expected at least {LEAST} x {LEAST}")]
    Small {
        /// Width (pixels).
        width: usize,
        /// Height (pixels).
        height: usize,
    },
    /// The chart has fewer samples than the region.
    #[error("the chart has {width} x {height} samples; expected more than the region has pixels")]
    Coarse {
        /// Width (samples).
        width: usize,
        /// Height (samples).
        height: usize,
    },
    /// A picture is dark or not finite.
    #[error("the mean is {0}; expected light")]
    Dark(f64),
}

/// Response of a camera to texture.
///
/// The power of the picture over that of the chart, both in rings of equal frequency and of the same part
/// of the chart, is the square of the modulation transfer (McElvain et al. 2010; Kirk et al. 2014 compare with
/// the chart itself too). As only powers are compared, the places of the details may be off by some pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureResponse {
    /// Frequencies (cycles/pixel) and the response there, that of the pixel included.
    pub response: Vec<[f64; 2]>,
}

impl TextureResponse {
    /// Measures a region of a picture that shows a chart and nothing else. `value` is the channel. With a second
    /// picture of other noise, the noise of neither counts; without one, it counts as texture.
    ///
    /// # Errors
    /// Returns an error if the region is too small, or the chart too coarse or dark.
    pub fn measure(
        [picture, second]: [&Picture; 2],
        [low, high]: [[usize; 2]; 2],
        chart: &Picture,
        value: impl Fn([f32; 3]) -> f64,
    ) -> Result<Self, TextureError> {
        let [width, height] = [0, 1].map(|i| high[i] - low[i]);
        if width.min(height) < LEAST {
            return Err(TextureError::Small { width, height });
        }
        if chart.size[0] < width || chart.size[1] < height {
            let [width, height] = chart.size;
            return Err(TextureError::Coarse { width, height });
        }
        let cut = |picture: &Picture| -> Vec<f64> {
            let row = |y: usize| &picture.pixels[y * picture.size[0]..][low[0]..high[0]];
            (low[1]..high[1]).flat_map(row).map(|pixel| value(*pixel)).collect()
        };
        let size = [width, height];
        let known = spectrum(box_averages(chart, size, &value), size)?;
        let first = spectrum(cut(picture), size)?;
        let second = spectrum(cut(second), size)?;
        let mut rings = vec![Ring::default(); BINS + 1];
        for (i, ((first, second), known)) in first.iter().zip(&second).zip(&known).enumerate() {
            let frequency = |i: usize, n: usize| i.min(n - i) as f64 / n as f64;
            let [u, v] = [frequency(i % width, width), frequency(i / width, height)];
            let bin = (u.hypot(v) * 2.0 * BINS as f64).round() as usize;
            if let (true, Some(ring)) = (bin > 0, rings.get_mut(bin)) {
                ring.power += (first * second.conj()).re;
                ring.known += known.norm_sqr();
                ring.pixel += sinc(u) * sinc(v);
                ring.count += 1.0;
            }
        }
        let response = rings.iter().enumerate().skip(1).map(|(bin, ring)| {
            let share = (ring.power / ring.known).max(0.0).sqrt();
            [bin as f64 / (2.0 * BINS as f64), share * ring.pixel / ring.count]
        });
        Ok(Self { response: response.collect() })
    }
}

/// Sums over a ring of frequencies.
#[derive(Clone, Copy, Default)]
struct Ring {
    /// Power of the picture, and of the chart as pixels see it.
    power: f64,
    known: f64,
    /// Response of pixels, and the number of frequencies.
    pixel: f64,
    count: f64,
}

/// Returns the means of a picture over the cells of a grid of this size.
fn box_averages(
    picture: &Picture,
    [width, height]: [usize; 2],
    value: &impl Fn([f32; 3]) -> f64,
) -> Vec<f64> {
    // Weights of the samples that a cell covers, at its ends in part.
    let weights = |cells: usize, samples: usize| -> Vec<Vec<(usize, f64)>> {
        let step = samples as f64 / cells as f64;
        let cell = |i: usize| {
            let [start, end] = [i, i + 1].map(|i| i as f64 * step);
            let overlap =
                |j: usize| (end.min(j as f64 + 1.0) - start.max(j as f64)).max(0.0) / step;
            let last = (end.ceil() as usize).min(samples);
            (start.floor() as usize..last).map(|j| (j, overlap(j))).collect()
        };
        (0..cells).map(cell).collect()
    };
    let [columns, rows] = [weights(width, picture.size[0]), weights(height, picture.size[1])];
    let mut means = Vec::with_capacity(width * height);
    for row in &rows {
        let at = |x: usize| -> f64 {
            let samples = row.iter();
            samples.map(|&(y, w)| w * value(picture.pixels[y * picture.size[0] + x])).sum()
        };
        let line: Vec<f64> = (0..picture.size[0]).map(at).collect();
        means
            .extend(columns.iter().map(|cell| cell.iter().map(|&(x, w)| w * line[x]).sum::<f64>()));
    }
    means
}

/// Returns the Fourier transform of values relative to their mean, under a Hann window.
fn spectrum(
    values: Vec<f64>,
    [width, height]: [usize; 2],
) -> Result<Vec<Complex<f64>>, TextureError> {
    let hann = |i: usize, n: usize| 0.5 - 0.5 * (TAU * (i as f64 + 0.5) / n as f64).cos();
    let window = |i: usize| hann(i % width, width) * hann(i / width, height);
    // Power counts by the square of the window, and so does the light that falls off to the corners.
    let (mut sum, mut weights) = (0.0, 0.0);
    for (i, value) in values.iter().enumerate() {
        let weight = window(i) * window(i);
        (sum, weights) = (sum + weight * value, weights + weight);
    }
    let mean = sum / weights;
    if !(mean > 0.0 && mean.is_finite()) {
        return Err(TextureError::Dark(mean));
    }
    let windowed = values.iter().enumerate();
    let windowed = windowed.map(|(i, value)| Complex::new((value / mean - 1.0) * window(i), 0.0));
    let mut rows: Vec<Complex<f64>> = windowed.collect();
    let mut planner = FftPlanner::new();
    planner.plan_fft_forward(width).process(&mut rows);
    let mut columns: Vec<Complex<f64>> =
        (0..width * height).map(|i| rows[i % height * width + i / height]).collect();
    planner.plan_fft_forward(height).process(&mut columns);
    Ok((0..width * height).map(|i| columns[i % width * height + i / width]).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::charts::leaves::leaves;
    use petzval_base::sampler::hash;

    const SIDE: usize = 160;

    /// Returns a picture of leaves that are blurred by a Gaussian (pixels), in light that falls off, with noise of a seed.
    fn photograph(chart: &Picture, sigma: f64, noise: f64, seed: u32) -> Picture {
        let sharp = box_averages(chart, [SIDE; 2], &|pixel| f64::from(pixel[1]));
        let reach = (4.0 * sigma).ceil() as i64;
        let weight =
            |d: i64| if sigma > 0.0 { (-0.5 * (d as f64 / sigma).powi(2)).exp() } else { 1.0 };
        let total: f64 = (-reach..=reach).map(weight).sum();
        let blurred = |values: &[f64], step: [usize; 2]| -> Vec<f64> {
            let at = |i: usize| {
                let [x, y] = [i % SIDE, i / SIDE];
                let place = |d: i64| {
                    let moved = |at: usize, step: usize| {
                        (at as i64 + d * step as i64).rem_euclid(SIDE as i64) as usize
                    };
                    values[moved(y, step[1]) * SIDE + moved(x, step[0])]
                };
                (-reach..=reach).map(|d| weight(d) / total * place(d)).sum()
            };
            (0..SIDE * SIDE).map(at).collect()
        };
        let blurred = blurred(&blurred(&sharp, [1, 0]), [0, 1]);
        let pixel = |(i, value): (usize, f64)| {
            let [x, y] = [i % SIDE, i / SIDE].map(|at| (at as f64 / SIDE as f64 - 0.5).powi(2));
            let random = f64::from(hash(i as u32 ^ hash(seed))) / 4_294_967_296.0 - 0.5;
            let light = value * (1.0 - 0.1 * (x + y)) + noise * random * 12.0_f64.sqrt();
            [light as f32; 3]
        };
        let pixels = blurred.into_iter().enumerate().map(pixel).collect();
        Picture { size: [SIDE; 2], pixels }
    }

    /// Returns the response of the sampled Gaussian at a frequency (cycles/pixel).
    fn kernel(sigma: f64, frequency: f64) -> f64 {
        let reach = (4.0 * sigma).ceil() as i64;
        let weight =
            |d: i64| if sigma > 0.0 { (-0.5 * (d as f64 / sigma).powi(2)).exp() } else { 1.0 };
        let (mut sum, mut total) = (0.0, 0.0);
        for d in -reach..=reach {
            sum += weight(d) * (TAU * frequency * d as f64).cos();
            total += weight(d);
        }
        sum / total
    }

    fn response(pictures: [&Picture; 2], chart: &Picture) -> Vec<[f64; 2]> {
        let region = [[0, 0], [SIDE; 2]];
        let found = TextureResponse::measure(pictures, region, chart, |pixel| f64::from(pixel[1]));
        found.expect("a response").response
    }

    #[test]
    fn the_response_is_that_of_the_blur_and_the_pixel() {
        let chart = leaves(SIDE, 3);
        for sigma in [0.0, 0.4, 0.8] {
            let picture = photograph(&chart, sigma, 0.0, 1);
            for [f, found] in response([&picture; 2], &chart) {
                // Power is averaged over all directions, and so is the response of the pixel.
                let [mut blur, mut pixel] = [0.0; 2];
                for i in 0..64 {
                    let (sin, cos) = (f64::from(i) * TAU / 64.0).sin_cos();
                    blur += (kernel(sigma, f * sin) * kernel(sigma, f * cos)).powi(2) / 64.0;
                    pixel += sinc(f * sin) * sinc(f * cos) / 64.0;
                }
                let expected = pixel * blur.sqrt();
                assert!((found - expected).abs() < 0.012, "{sigma} {f}: {found}, not {expected}");
            }
        }
    }

    #[test]
    fn noise_counts_as_texture_without_a_second_picture() {
        let chart = leaves(SIDE, 3);
        let clean = photograph(&chart, 0.8, 0.0, 1);
        let noisy = [1, 2].map(|seed| photograph(&chart, 0.8, 0.003, seed));
        let expected = response([&clean; 2], &chart);
        let [alone, both] =
            [response([&noisy[0]; 2], &chart), response([&noisy[0], &noisy[1]], &chart)];
        let last = expected.len() - 1;
        assert!(
            alone[last][1] > expected[last][1] + 0.04,
            "{:?} {:?}",
            alone[last],
            expected[last]
        );
        for (found, expected) in both.iter().zip(&expected) {
            assert!((found[1] - expected[1]).abs() < 0.03, "{found:?}, not {expected:?}");
        }
    }

    #[test]
    fn unsuitable_pictures_are_refused() {
        let chart = leaves(70, 1);
        let black = Picture { size: [100; 2], pixels: vec![[0.0; 3]; 10_000] };
        let measure = |region, chart: &Picture| {
            TextureResponse::measure([&black; 2], region, chart, |pixel| f64::from(pixel[1]))
        };
        let small = measure([[0, 0], [63, 90]], &chart);
        assert_eq!(small, Err(TextureError::Small { width: 63, height: 90 }));
        assert_eq!(measure([[0, 0], [90, 90]], &chart), Err(TextureError::Dark(0.0)));
        let few = measure([[0, 0], [100, 100]], &Picture { size: [99, 200], ..chart.clone() });
        assert_eq!(few, Err(TextureError::Coarse { width: 99, height: 200 }));
    }
}
