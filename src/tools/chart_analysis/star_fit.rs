//! Fit of sinusoids to the rings of a star, and of its centre.

use std::f64::consts::{FRAC_PI_4, TAU};

use petzval_base::least_squares::least_squares;

/// Segments of a ring, each of which has a phase of its own.
pub(super) const SEGMENTS: usize = 8;

/// A pixel of a ring.
#[derive(Clone, Copy)]
struct RingPixel {
    angle: f64,
    /// Distance from the middle of the ring (pixels), outwards.
    out: f64,
    value: f64,
}

/// A star about its centre.
pub(super) struct StarFit {
    values: Vec<f64>,
    width: usize,
    centre: [f64; 2],
    cycles: f64,
}

/// Fit of a sinusoid to the pixels of a segment.
#[derive(Clone, Copy)]
pub(super) struct Wave {
    mean: f64,
    /// Factors of cosine and sine.
    cos: f64,
    sin: f64,
    /// Square of the amplitude that noise adds.
    noise: f64,
}

impl Wave {
    /// Returns the amplitude over the mean, without the noise.
    pub fn modulation(&self) -> f64 {
        let square = self.cos * self.cos + self.sin * self.sin - self.noise;
        if self.mean > 0.0 { square.max(0.0).sqrt() / self.mean } else { 0.0 }
    }
}

impl StarFit {
    /// Finds the centre of a star in the values of a region, by rings below the largest radius (pixels).
    pub fn new(values: Vec<f64>, [width, height]: [usize; 2], cycles: f64, largest: f64) -> Self {
        let centre = [width, height].map(|n| (n as f64 - 1.0) / 2.0);
        let mut star = Self { values, width, centre, cycles };
        star.find_centre(largest);
        star
    }

    /// Returns the centre (pixels, that of the first pixel at 0).
    pub fn centre(&self) -> [f64; 2] {
        self.centre
    }

    /// Returns the number of pixels of a ring.
    pub fn pixel_count(&self, radius: f64) -> usize {
        self.pixels(self.centre, radius).len()
    }

    /// Returns the pixels of a ring about a centre.
    fn pixels(&self, centre: [f64; 2], radius: f64) -> Vec<RingPixel> {
        let half = (0.01 * radius).max(0.75);
        let height = self.values.len() / self.width;
        let clip = |at: f64, n: usize| at.clamp(0.0, n as f64) as usize;
        let reach = radius + half;
        let rows = clip((centre[1] - reach).ceil(), height)..clip(centre[1] + reach + 1.0, height);
        let mut pixels = Vec::new();
        for y in rows {
            let dy = y as f64 - centre[1];
            // A row crosses the ring on both sides of its hole.
            let [outer, hole] =
                [reach, (radius - half).max(0.0)].map(|r| (r * r - dy * dy).max(0.0).sqrt());
            let last_left = clip((centre[0] - hole + 1.0).floor(), self.width);
            let first_right = clip((centre[0] + hole).floor(), self.width).max(last_left);
            let left = clip((centre[0] - outer).ceil(), self.width)..last_left;
            let right = first_right..clip(centre[0] + outer + 1.0, self.width);
            for x in left.chain(right) {
                let dx = x as f64 - centre[0];
                let out = dx.hypot(dy) - radius;
                if out.abs() <= half {
                    let angle = dy.atan2(dx).rem_euclid(TAU);
                    pixels.push(RingPixel { angle, out, value: self.values[y * self.width + x] });
                }
            }
        }
        pixels
    }

    /// Returns the agreement of the phases of the segments of a ring: 1 if all are the same.
    pub fn coherence(&self, radius: f64) -> f64 {
        let waves = self.ring(radius);
        let [cos, sin] = sum_of(&waves);
        cos.hypot(sin) / waves.iter().map(|wave| wave.cos.hypot(wave.sin)).sum::<f64>()
    }

    /// Returns the fits of all segments of a ring.
    pub fn ring(&self, radius: f64) -> [Wave; SEGMENTS] {
        let mut segments: [Vec<RingPixel>; SEGMENTS] = Default::default();
        for pixel in self.pixels(self.centre, radius) {
            segments[(pixel.angle / FRAC_PI_4) as usize % SEGMENTS].push(pixel);
        }
        segments.map(|pixels| self.wave(&pixels))
    }

    fn wave(&self, pixels: &[RingPixel]) -> Wave {
        let basis = |pixel: &RingPixel| {
            let (sin, cos) = (self.cycles * pixel.angle).sin_cos();
            [1.0, cos, sin, pixel.out * cos, pixel.out * sin]
        };
        let columns = (0..5).map(|i| pixels.iter().map(|pixel| basis(pixel)[i]).collect());
        let values = pixels.iter().map(|pixel| pixel.value).collect();
        let fit = &least_squares(columns.collect(), vec![values])[0];
        let rest = pixels.iter().map(|pixel| {
            let fitted: f64 = basis(pixel).iter().zip(fit).map(|(b, f)| b * f).sum();
            (pixel.value - fitted).powi(2)
        });
        let count = pixels.len() as f64;
        let variance = rest.sum::<f64>() / (count - 5.0).max(1.0);
        Wave { mean: fit[0], cos: fit[1], sin: fit[2], noise: 4.0 * variance / count }
    }

    /// Moves the centre to that of the star: first to where a sinusoid around the whole of a ring is largest, then to where
    /// all of its segments have one phase.
    fn find_centre(&mut self, radius: f64) {
        let step = radius / self.cycles;
        let start = self.centre;
        let mut best = [0.0, start[0], start[1]];
        for (i, j) in (-6..=6).flat_map(|i| (-6..=6).map(move |j| (i, j))) {
            let centre = [start[0] + step * f64::from(i), start[1] + step * f64::from(j)];
            let pixels = self.pixels(centre, 0.9 * radius);
            let [cos, sin] = [f64::cos, f64::sin].map(|of| {
                pixels.iter().map(|pixel| of(self.cycles * pixel.angle) * pixel.value).sum::<f64>()
            });
            let amplitude = cos.hypot(sin) / pixels.len().max(1) as f64;
            if amplitude > best[0] {
                best = [amplitude, centre[0], centre[1]];
            }
        }
        self.centre = [best[1], best[2]];
        for _ in 0..4 {
            let waves = self.ring(0.9 * radius);
            let [cos, sin] = sum_of(&waves);
            let middle = sin.atan2(cos);
            let mut shift = [0.0; 2];
            for (i, wave) in waves.iter().enumerate() {
                let phase = wave.sin.atan2(wave.cos) - middle;
                let phase = phase.sin().atan2(phase.cos());
                let (s, c) = ((i as f64 + 0.5) * FRAC_PI_4).sin_cos();
                // A centre that is off by d changes the angles by (s dx - c dy) / radius.
                let by = phase / self.cycles * 0.9 * radius * 2.0 / SEGMENTS as f64;
                shift = [shift[0] - s * by, shift[1] + c * by];
            }
            self.centre = [0, 1].map(|i| self.centre[i] + shift[i]);
        }
    }
}

/// Returns the sums of the factors of cosine and sine.
fn sum_of(waves: &[Wave]) -> [f64; 2] {
    waves.iter().fold([0.0; 2], |[cos, sin], wave| [cos + wave.cos, sin + wave.sin])
}
