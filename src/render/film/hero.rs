//! Hero wavelengths: the colours of rays that several bands of light share.

use super::Frame;
use petzval_base::rays::{Column, RayBatch, ReprojectionBatch, SampleBatch};
use petzval_lens::FilmMap;
use petzval_scene::filter::PixelFilter;

/// Sums over the bands that share the rays of a wave.
///
/// Band h, the hero, sends a ray into the world from a film point p_h. In each band k that shares
/// the ray, its light arrives at another film point p_k, with the lens's transmission tau_k. Let f
/// be the pixel's filter and r_k the response of a channel to band k. The ray's weight for the
/// channel is multiplied by
///
/// ```text
/// R = sum_k r_k f(p_k) tau_k / sum_k |f(p_k)| tau_k      times the sign of f(p_h)
/// ```
///
/// This is the balance heuristic (Veach & Guibas 1995) over the bands that could have sent the ray,
/// without the densities of their pupil samples. Let g_k = f(p_k) tau_k. A lens preserves etendue
/// at every wavelength, so the light of the bands is a mean of the integrals of r_k g_k L dG over
/// all rays G of the world. The hero's rays have the density |f(p_h)| / W, with the weight W that
/// the lens stage knows, so each of them contributes W tau_h / |g_h| times the integrand. Any
/// weights that add up to 1 for every ray are unbiased. The weight |g_h| / sum |g_k| needs no
/// density of another band, cancels with the first factor, and is 0 for a band that could not have
/// sent the ray. The product is W tau_h, which the ray carries anyway, times R.
///
/// If the colours arrive at the same point, R is the mean of four responses far apart in the
/// spectrum, nearly white. If they arrive pixels apart, R is the response of the hero.
///
/// This assumes that the pupil samples of a film point include every ray by which a band's light
/// can arrive there. The pupil bounds enclose the first and the last band, and some samples cover
/// the whole rear element.
#[derive(Clone, Debug, Default)]
pub struct HeroWeights {
    /// Numerator of R for each channel.
    sums: [Column<f32>; 3],
    /// Denominator of R.
    total: Column<f32>,
    /// Film point of the band that is being added, relative to the pixel's centre (pixels).
    position: [Column<f32>; 2],
    /// f(p_k) tau_k of that band.
    value: Column<f32>,
}

impl HeroWeights {
    /// Starts a wave with the hero, given the lens's transmission of its rays.
    pub fn start(
        &mut self,
        filter: &PixelFilter,
        samples: &SampleBatch,
        transmission: &Column<f32>,
        response: [f64; 3],
    ) {
        let len = samples.len;
        self.sums.iter_mut().for_each(|sum| sum[..len].fill(0.0));
        self.total[..len].fill(0.0);
        for axis in 0..2 {
            self.position[axis][..len].copy_from_slice(&samples.offset[axis][..len]);
        }
        self.add_at_position(filter, transmission, len, response);
    }

    /// Adds another band, given where its light arrives on the film.
    pub fn add_band(
        &mut self,
        filter: &PixelFilter,
        (frame, film): (&Frame, [f64; 2]),
        samples: &SampleBatch,
        landing: &ReprojectionBatch,
        response: [f64; 3],
    ) {
        let len = samples.len;
        let per_mm = [0, 1].map(|axis| {
            let along = f64::from(FilmMap::DIRECTIONS[axis]);
            (along * f64::from(frame.resolution[axis]) / film[axis]) as f32
        });
        for axis in 0..2 {
            let to = &mut self.position[axis][..len];
            let (own, film) = (&samples.offset[axis][..len], &samples.film[axis][..len]);
            let landed = &landing.film[axis][..len];
            for i in 0..len {
                to[i] = own[i] + (landed[i] - film[i]) * per_mm[axis];
            }
        }
        self.add_at_position(filter, &landing.transmission, len, response);
    }

    /// Adds a band whose light arrives at [`Self::position`].
    fn add_at_position(
        &mut self,
        filter: &PixelFilter,
        transmission: &Column<f32>,
        len: usize,
        response: [f64; 3],
    ) {
        let Self { sums, total, position, value } = self;
        let value = &mut value[..len];
        value.copy_from_slice(&transmission[..len]);
        filter.multiply([&position[0][..len], &position[1][..len]], value);
        for (total, value) in total.iter_mut().zip(&*value) {
            *total += value.abs();
        }
        for (sum, response) in sums.iter_mut().zip(response.map(|r| r as f32)) {
            for (sum, value) in sum.iter_mut().zip(&*value) {
                *sum += value * response;
            }
        }
    }

    /// Sets the throughput of rays to `factor` times the exposure of their sample times R.
    pub fn apply(
        &self,
        filter: &PixelFilter,
        samples: &SampleBatch,
        exposure: &Column<f32>,
        factor: f64,
        rays: &mut RayBatch,
    ) {
        let (factor, signed) = (factor as f32, filter.is_signed());
        for i in 0..rays.len {
            let slot = rays.slot[i] as usize;
            // A sample at the very edge of its filter, where all f are 0, keeps its hero's colour.
            if self.total[slot] <= 0.0 {
                continue;
            }
            let sign = if signed && samples.weight[slot] < 0.0 { -1.0 } else { 1.0 };
            let per_total = sign * factor * exposure[slot] / self.total[slot];
            for (throughput, sum) in rays.throughput.iter_mut().zip(&self.sums) {
                throughput[i] = sum[slot] * per_total;
            }
        }
    }
}
