//! What rays that several bands share count in red, green and blue: a stage.

use super::{Filter, Frame};
use crate::rays::{Column, LandingBatch, RayBatch, SampleBatch};

/// The bands that share the rays of a wave, added up.
///
/// The h-th band, the hero, has sent a ray into the world from a film point p_h. The light of that
/// ray comes in each band k of those that share it to a film point p_k of its own, with a share
/// tau_k of it; f is the pixel's filter, r_k the response. Of each unit that the hero's ray counts,
/// the pixel then has for a channel
///
/// ```text
/// R = sum_k r_k f(p_k) tau_k / sum_k |f(p_k)| tau_k      times the sign of f(p_h)
/// ```
///
/// This is the balance heuristic (Veach & Guibas 1995) over the bands that could have sent the ray,
/// with the pupil's densities left out of it. Let g_k = f(p_k) tau_k; a lens keeps etendue whatever
/// the colour, so over all rays G of the world the light of the bands is a mean of the integrals of
/// r_k g_k L dG. The hero's rays have the density |f(p_h)| / W with the weight W that the lens stage
/// knows, so one of them gives W tau_h / |g_h| times whatever is integrated. Any weights serve that
/// add up to 1 at every ray: |g_h| / sum |g_k| needs no density of the other bands, cancels with the
/// first factor, and is 0 for a band that could not have sent the ray. What is left is W tau_h,
/// which the ray carries anyway, times R.
///
/// Where colours land on the same point, R is the mean of four responses far apart in the spectrum,
/// nearly white; where they land pixels apart, it is that of the hero.
///
/// One thing is taken for granted: that a film point from which a band's light could come is one
/// that samples the pupil there. Bounds of the pupil hold the first and the last band, and some
/// samples go to the whole rear element.
#[derive(Clone, Debug, Default)]
pub struct Colours {
    sums: [Column<f32>; 3],
    whole: Column<f32>,
    place: [Column<f32>; 2],
    value: Column<f32>,
}

impl Colours {
    /// Begins a wave with the hero, by what the lens let through of it.
    pub fn begin(
        &mut self,
        filter: &Filter,
        samples: &SampleBatch,
        share: &Column<f32>,
        response: [f64; 3],
    ) {
        let len = samples.len;
        self.sums.iter_mut().for_each(|sum| sum[..len].fill(0.0));
        self.whole[..len].fill(0.0);
        for axis in 0..2 {
            self.place[axis][..len].copy_from_slice(&samples.offset[axis][..len]);
        }
        self.sum(filter, share, len, response);
    }

    /// Adds another band.
    pub fn add(
        &mut self,
        filter: &Filter,
        (frame, film): (&Frame, [f64; 2]),
        samples: &SampleBatch,
        landing: &LandingBatch,
        response: [f64; 3],
    ) {
        let len = samples.len;
        // The picture on the film is mirrored in x.
        let per_mm = [0, 1].map(|axis| {
            let sign = if axis == 0 { -1.0 } else { 1.0 };
            (sign * f64::from(frame.resolution[axis]) / film[axis]) as f32
        });
        for axis in 0..2 {
            let to = &mut self.place[axis][..len];
            let (own, film) = (&samples.offset[axis][..len], &samples.film[axis][..len]);
            let landed = &landing.film[axis][..len];
            for i in 0..len {
                to[i] = own[i] + (landed[i] - film[i]) * per_mm[axis];
            }
        }
        self.sum(filter, &landing.share, len, response);
    }

    /// Adds what comes to [`Self::place`].
    fn sum(&mut self, filter: &Filter, share: &Column<f32>, len: usize, response: [f64; 3]) {
        let Self { sums, whole, place, value } = self;
        let value = &mut value[..len];
        value.copy_from_slice(&share[..len]);
        filter.multiply([&place[0][..len], &place[1][..len]], value);
        for (whole, value) in whole.iter_mut().zip(&*value) {
            *whole += value.abs();
        }
        for (sum, response) in sums.iter_mut().zip(response.map(|r| r as f32)) {
            for (sum, value) in sum.iter_mut().zip(&*value) {
                *sum += value * response;
            }
        }
    }

    /// Gives rays the colours of their samples: they carry this factor times their exposure, by
    /// sample, times R.
    pub fn tint(
        &self,
        filter: &Filter,
        samples: &SampleBatch,
        exposure: &Column<f32>,
        factor: f64,
        rays: &mut RayBatch,
    ) {
        let (factor, signed) = (factor as f32, filter.signed());
        for i in 0..rays.len {
            let slot = rays.slot[i] as usize;
            // A sample at the very edge of a filter that ends there is of its hero alone.
            if self.whole[slot] <= 0.0 {
                continue;
            }
            let sign = if signed && samples.weight[slot] < 0.0 { -1.0 } else { 1.0 };
            let per_whole = sign * factor * exposure[slot] / self.whole[slot];
            for (carried, sum) in rays.carried.iter_mut().zip(&self.sums) {
                carried[i] = sum[slot] * per_whole;
            }
        }
    }
}
