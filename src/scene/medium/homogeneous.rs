//! Homogeneous media: collisions and transmittance in closed form, over lanes.

use super::colours::MediumColours;
use petzval_base::lanes::Real;
use petzval_base::lanes::math::{exp_negative, ln};

/// A medium that is the same everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Homogeneous {
    /// Absorption coefficient.
    pub absorption: [f32; 3],
    /// Scattering coefficient.
    pub scattering: [f32; 3],
    /// Emitted radiance, which counts in proportion to the absorption.
    pub emission: [f32; 3],
}

/// Outcome of a ray's way to the next surface, lane by lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Passage<R: Real> {
    /// Lanes in which the ray scatters before it reaches the surface.
    pub scatters: R::Mask,
    /// Distance to the point where it scatters; the length of the way if it does not.
    pub distance: R,
    /// Throughput there.
    pub throughput: [R; 3],
    /// Radiance that the way contributes.
    pub emitted: [R; 3],
}

impl Homogeneous {
    /// The medium of these coefficients, in RGB.
    pub fn of(colours: &MediumColours) -> Self {
        let MediumColours { absorption, scattering, emission } = colours;
        let [absorption, scattering, emission] = [absorption, scattering, emission].map(|c| c.rgb);
        Self { absorption, scattering, emission }
    }

    /// Returns the extinction coefficient.
    #[inline(always)]
    fn extinction<R: Real<Scalar = f32>>(&self, channel: usize) -> R {
        R::splat(self.absorption[channel] + self.scattering[channel])
    }

    /// Samples the first collision on a way of this length, in world units.
    ///
    /// `u` are numbers in [0, 1). The first selects the channel that determines the distance, in
    /// proportion to the throughput; the sum of the densities of all channels divides the result
    /// (the balance heuristic for one sample; Veach 1997, section 9.2.2). So no throughput exceeds the
    /// sum of the channels before.
    #[inline(always)]
    pub(super) fn sample<R: Real<Scalar = f32>>(
        &self,
        length: R,
        throughput: [R; 3],
        u: [R; 2],
    ) -> Passage<R> {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let length = finite(length);
        let sum = throughput[0] + throughput[1] + throughput[2];
        let inverse = R::select(zero.lt(sum), one / sum, zero);
        let mut share = [zero; 3];
        for channel in 0..3 {
            share[channel] = throughput[channel] * inverse;
        }
        let (first, second) = (share[0], share[0] + share[1]);
        let of = |channel| self.extinction::<R>(channel);
        let last = R::select(u[0].lt(second), of(1), of(2));
        let chosen = R::select(u[0].lt(first), of(0), last);
        let depth = -ln(one - u[1]);
        let distance = R::select(zero.lt(chosen), finite(depth / chosen), R::splat(f32::MAX));
        let scatters = distance.lt(length) & zero.lt(sum);
        let distance = R::select(scatters, distance, length);
        let (mut weight, mut density) = ([zero; 3], zero);
        for channel in 0..3 {
            let extinction = of(channel);
            let transmittance = exp_negative(-finite(extinction * distance));
            let scattering = R::splat(self.scattering[channel]);
            weight[channel] = R::select(scatters, scattering, one) * transmittance;
            density =
                density + share[channel] * transmittance * R::select(scatters, extinction, one);
        }
        let inverse = R::select(zero.lt(density), one / density, zero);
        let (mut after, mut emitted) = ([zero; 3], [zero; 3]);
        for channel in 0..3 {
            after[channel] = throughput[channel] * weight[channel] * inverse;
            emitted[channel] = throughput[channel] * self.emitted::<R>(length, channel);
        }
        Passage { scatters, distance, throughput: after, emitted }
    }

    /// Returns the transmittance of a way of this length.
    #[inline(always)]
    pub(super) fn transmittance<R: Real<Scalar = f32>>(&self, length: R) -> [R; 3] {
        let mut transmittance = [R::splat(1.0); 3];
        for channel in 0..3 {
            let depth = finite(self.extinction::<R>(channel) * finite(length));
            transmittance[channel] = exp_negative(-depth);
        }
        transmittance
    }

    /// Returns the radiance that a way of this length emits towards its start: the integral of
    /// absorption, emission and transmittance.
    #[inline(always)]
    fn emitted<R: Real<Scalar = f32>>(&self, length: R, channel: usize) -> R {
        let source = self.absorption[channel] * self.emission[channel];
        if source <= 0.0 {
            return R::splat(0.0);
        }
        let one = R::splat(1.0);
        let extinction = self.extinction::<R>(channel);
        let depth = finite(extinction * length);
        let all = (one - exp_negative(-depth)) / extinction;
        // 1 - e^-x cancels where x is small; there its series has two terms.
        let thin = length * (one - R::splat(0.5) * depth);
        R::splat(source) * R::select(depth.lt(R::splat(1e-3)), thin, all)
    }
}

/// Returns a number >= 0 that is not infinite, so that its product with 0 is 0.
#[inline(always)]
pub(super) fn finite<R: Real<Scalar = f32>>(x: R) -> R {
    x.min(R::splat(f32::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Light of each channel goes a different distance.
    const AMBER: Homogeneous = Homogeneous {
        absorption: [0.1, 0.5, 1.5],
        scattering: [1.8, 1.0, 0.2],
        emission: [0.0; 3],
    };
    const BEFORE: [f32; 3] = [0.2, 1.0, 0.5];
    const LENGTHS: [f32; 3] = [0.3, 1.0, 4.0];

    /// Returns the outcomes for random numbers that cover the square evenly.
    fn passages(length: f32) -> impl Iterator<Item = Passage<f32>> {
        const N: usize = 300;
        (0..N * N).map(move |i| {
            let u = [i % N, i / N].map(|i| (i as f32 + 0.5) / N as f32);
            AMBER.sample(length, BEFORE, u)
        })
    }

    /// Distances that one channel alone decides would weight the others by ratios without a bound.
    #[test]
    fn no_throughput_exceeds_the_sum_of_the_channels_before() {
        let bound = BEFORE.iter().sum::<f32>() * (1.0 + 1e-5);
        for length in LENGTHS {
            for passage in passages(length) {
                assert!(passage.throughput.iter().all(|t| *t <= bound), "{passage:?}");
            }
        }
    }

    #[test]
    fn light_passes_and_scatters_as_in_closed_form() {
        for length in LENGTHS {
            let (mut passed, mut scattered, mut count) = ([0.0; 3], [0.0; 3], 0.0);
            for passage in passages(length) {
                let sum = if passage.scatters { &mut scattered } else { &mut passed };
                (0..3).for_each(|c| sum[c] += f64::from(passage.throughput[c]));
                count += 1.0;
            }
            for c in 0..3 {
                let extinction = f64::from(AMBER.absorption[c] + AMBER.scattering[c]);
                let before = f64::from(BEFORE[c]);
                let share = (-extinction * f64::from(length)).exp();
                let albedo = f64::from(AMBER.scattering[c]) / extinction;
                let expected = [share, (1.0 - share) * albedo].map(|part| part * before);
                for (found, expected) in [passed[c], scattered[c]].into_iter().zip(expected) {
                    let off = found / count - expected;
                    assert!(off.abs() < 4e-3 * before, "{c} over {length}: {off} off {expected}");
                }
            }
        }
    }
}
