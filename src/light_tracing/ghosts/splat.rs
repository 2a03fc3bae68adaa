//! Light paths of ghosts: from a light by two reflections to the film, and their splats.

use super::{GhostPair, Ghosts};
use crate::film::Frame;
use crate::lanes::Real;
use crate::lens::RealLens;
use crate::light_tracing::light_paths::{
    LightPathInput, LightPaths, PathCount, Splat, film_pixels,
};
use crate::rays::LensBatch;
use crate::sampler::{Dimension, pixel_key, sample_2d};

/// Samples of the picture per light path. Ghosts are unsharp and need few paths.
const SAMPLES_PER_PATH: u64 = 4;

/// A path in one band that arrives on the film.
#[derive(Clone, Copy)]
struct Arrival {
    /// Its index in the wave.
    slot: u32,
    pixel: [u32; 2],
    /// Factor from its flux to the value of the pixel, by channel.
    share: [f32; 3],
}

impl Ghosts {
    /// Largest number of bands in which one path is traced.
    pub(crate) const BANDS_PER_PATH: usize = 4;

    /// Returns the number of light paths per sample number.
    pub(crate) fn path_count(&self, frame: &Frame) -> PathCount {
        PathCount::new(frame.resolution, SAMPLES_PER_PATH)
    }

    /// Traces a wave of a sample number through one pair and returns its splats. Every path is traced in
    /// several evenly spaced bands, so that few paths already have nearly the right hue.
    ///
    /// A path is added to the pixel that it hits; a filter would not change an unsharp image.
    pub(crate) fn trace<R: Real<Scalar = f32>>(
        &self,
        input: &LightPathInput<'_>,
        lens: &RealLens,
        wave_paths: &mut LightPaths,
        [wave, sample]: [u32; 2],
    ) -> Vec<Splat> {
        // A low-discrepancy sequence distributes the waves of a sample index over pairs and bands.
        let of_sample = pixel_key(sample, u32::MAX - 1, input.seed);
        let [u, v] = sample_2d(of_sample, wave, Dimension::Wavelength);
        let Some(GhostPair { share, entry, bands, .. }) = self.choose(f64::from(u)) else {
            return Vec::new();
        };
        wave_paths.sample(input, lens, pixel_key(wave, sample, of_sample), Some(entry));
        let traced_bands = bands.len().min(Self::BANDS_PER_PATH);
        let scale = self.path_count(input.frame).splat_scale(input);
        let factor = scale / (share * traced_bands as f64);
        let stride = bands.len() / traced_bands;
        let first = (v * stride as f32) as usize;
        let mut arrivals: Vec<Arrival> = Vec::new();
        for (surfaces, response) in bands.iter().skip(first).step_by(stride) {
            if !wave_paths.trace::<R>(lens, surfaces) {
                continue;
            }
            let LensBatch { x, y, weight, .. } = wave_paths.film_hits();
            for i in 0..wave_paths.len() {
                if let Some(pixel) = film_pixel(input, [x[i], y[i]]) {
                    let exposure = input.row_exposure(wave_paths.arrival_time(i), pixel);
                    let share =
                        response.map(|r| (f64::from(weight[i]) * r * factor * exposure) as f32);
                    arrivals.push(Arrival { slot: i as u32, pixel, share });
                }
            }
        }
        wave_paths.connect::<R>(input, arrivals.iter().map(|arrival| arrival.slot));
        let splat = |&Arrival { slot, pixel, share }: &Arrival| {
            let flux = wave_paths.flux(slot as usize);
            let light = [0, 1, 2].map(|c| flux[c] * share[c]);
            let is_lit = light != [0.0; 3] && light.iter().all(|c| c.is_finite());
            is_lit.then_some(Splat { pixel, light })
        };
        arrivals.iter().filter_map(splat).collect()
    }

    /// Returns the pair that a number in [0, 1) selects.
    fn choose(&self, u: f64) -> Option<&GhostPair> {
        let mut sum = 0.0;
        let found = self.pairs.iter().find(|pair| {
            sum += pair.share;
            u < sum
        });
        found.or(self.pairs.last())
    }
}

/// Returns the rendered pixel that contains a film point (mm).
fn film_pixel(input: &LightPathInput<'_>, point: [f32; 2]) -> Option<[u32; 2]> {
    let frame = &input.frame;
    let pixel = film_pixels(input, point.map(f64::from)).map(f64::floor);
    let inside =
        (0..2).all(|i| pixel[i] >= f64::from(frame.low[i]) && pixel[i] < f64::from(frame.high[i]));
    inside.then(|| pixel.map(|p| p as u32))
}
