//! Sampler: Owen-scrambled Sobol points in pairs of dimensions.
//!
//! A point is a pure function of pixel, sample index, dimension and seed, so that a picture does
//! not depend on threads, tiles or the order of work. Every pair of dimensions is a shuffled and
//! scrambled (0,2)-sequence of its own (Burley 2020, "Practical Hash-based Owen Scrambling", JCGT
//! 9(4)), with the mixing constants of Vegdahl (2021). The compiler vectorises the loops over
//! columns.

pub mod mis;
mod random_stream;

pub use random_stream::RandomStream;

use crate::lanes::{Real, Word};

/// Pair of dimensions of a sample. No two random decisions share one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// Point of the pixel.
    Film,
    /// Point of the pupil.
    Pupil,
    /// Point of the light, at a given bounce.
    Light(u32),
    /// Choice of the light and of its triangle, at a given bounce.
    LightChoice(u32),
    /// Direction of the next ray of the path, at a given bounce.
    Bounce(u32),
    /// Russian roulette, at a given bounce.
    Roulette(u32),
    /// Choice of a channel and of the distance to a collision in a medium, at a given bounce.
    Medium(u32),
    /// Wavelength.
    Wavelength,
    /// Time.
    Time,
}

impl Dimension {
    /// Returns the number that separates its random numbers from those of other dimensions.
    #[inline(always)]
    fn salt(self) -> u32 {
        let index = match self {
            Self::Film => 0,
            Self::Pupil => 1,
            Self::Light(bounce) => 2 + 4 * bounce,
            Self::LightChoice(bounce) => 3 + 4 * bounce,
            Self::Bounce(bounce) => 4 + 4 * bounce,
            Self::Roulette(bounce) => 5 + 4 * bounce,
            // Bounces count up from 0: those above never reach these, and these never the others.
            Self::Medium(bounce) => (1 << 31) + bounce,
            Self::Wavelength => u32::MAX,
            Self::Time => u32::MAX - 1,
        };
        index.wrapping_mul(0x9e37_79b9)
    }
}

/// Returns the key of the samples of a pixel.
#[inline(always)]
pub fn pixel_key(x: u32, y: u32, seed: u32) -> u32 {
    hash(x ^ hash(y ^ hash(seed)))
}

/// Returns two numbers in [0, 1) for one sample of one pixel.
#[inline(always)]
pub fn sample_2d(key: u32, sample: u32, dimension: Dimension) -> [f32; 2] {
    point(key, sample, dimension.salt())
}

/// Fills two columns with [`sample_2d`] for columns of keys and sample indices.
pub fn fill_2d(keys: &[u32], samples: &[u32], dimension: Dimension, x: &mut [f32], y: &mut [f32]) {
    let len = keys.len();
    let (samples, x, y) = (&samples[..len], &mut x[..len], &mut y[..len]);
    let salt = dimension.salt();
    for i in 0..len {
        [x[i], y[i]] = point(keys[i], samples[i], salt);
    }
}

/// Fills a column with the first number of [`sample_2d`] for columns of keys and sample indices.
pub fn fill_1d(keys: &[u32], samples: &[u32], dimension: Dimension, x: &mut [f32]) {
    let len = keys.len();
    let (samples, x) = (&samples[..len], &mut x[..len]);
    let salt = dimension.salt();
    for i in 0..len {
        [x[i], _] = point(keys[i], samples[i], salt);
    }
}

#[inline(always)]
fn point(key: u32, sample: u32, salt: u32) -> [f32; 2] {
    let key = hash(key ^ salt);
    let index = scramble(sample.reverse_bits(), key).reverse_bits();
    let x = scramble(index, hash(key ^ 0xa511_e9b3)).reverse_bits();
    let y = scramble(pascal(index), hash(key ^ 0x63d8_3595)).reverse_bits();
    [unit(x), unit(y)]
}

/// Returns the top 24 bits as a number in [0, 1).
#[inline(always)]
fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// Hashes 32 bits by a permutation (Wellons 2018, "lowbias32").
#[inline(always)]
pub fn hash<W: Word>(x: W) -> W {
    let x = (x ^ x.shift_down(16)).wrapping_mul(W::splat(0x7feb_352d));
    let x = (x ^ x.shift_down(15)).wrapping_mul(W::splat(0x846c_a68b));
    x ^ x.shift_down(16)
}

/// Owen-scrambles a number with reversed bits: every bit depends on the bits below it only.
#[inline(always)]
fn scramble(mut x: u32, seed: u32) -> u32 {
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// Multiplies by Pascal's triangle modulo 2, the generator of Sobol's second dimension.
///
/// By the theorem of Lucas binomial (k, m) is odd if and only if m is a submask of k. The product
/// is therefore a sum over supersets, and takes five steps instead of thirty-two.
#[inline(always)]
fn pascal(mut x: u32) -> u32 {
    x ^= (x >> 1) & 0x5555_5555;
    x ^= (x >> 2) & 0x3333_3333;
    x ^= (x >> 4) & 0x0f0f_0f0f;
    x ^= (x >> 8) & 0x00ff_00ff;
    x ^ (x >> 16)
}

/// Maps the unit square to the unit disk concentrically (Shirley & Chiu 1997), with sine and cosine
/// by polynomials on [-pi/4, pi/4] whose errors are below 4e-7.
#[inline(always)]
pub fn concentric_disk<R: Real>(u: R, v: R) -> [R; 2] {
    let (one, two) = (R::constant(1.0), R::constant(2.0));
    let (a, b) = (u.mul_add(two, -one), v.mul_add(two, -one));
    let wide = b.abs().lt(a.abs());
    let (radius, other) = (R::select(wide, a, b), R::select(wide, b, a));
    let at_centre = radius.abs().lt(R::constant(1e-30));
    let ratio = other / R::select(at_centre, one, radius);
    let angle = ratio * R::constant(std::f64::consts::FRAC_PI_4);
    let t2 = angle * angle;
    let horner = |coefficients: [f64; 4]| {
        // `map` is not always inlined.
        let [c0, c1, c2, c3] = coefficients;
        let high = t2.mul_add(R::constant(c3), R::constant(c2));
        t2.mul_add(t2.mul_add(high, R::constant(c1)), R::constant(c0))
    };
    let sin = angle * horner([1.0, -1.0 / 6.0, 1.0 / 120.0, -1.0 / 5040.0]);
    let cos = t2.mul_add(horner([-0.5, 1.0 / 24.0, -1.0 / 720.0, 1.0 / 40320.0]), one);
    [radius * R::select(wide, cos, sin), radius * R::select(wide, sin, cos)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_second_dimension_is_that_of_sobol() {
        // Direction numbers of the second dimension: v_0 = 1/2, v_k = v_(k-1) ^ (v_(k-1) >> 1).
        let mut direction = 1u32 << 31;
        for k in 0..32 {
            assert_eq!(pascal(1 << k).reverse_bits(), direction, "bit {k}");
            direction ^= direction >> 1;
        }
    }

    #[test]
    fn sixteen_samples_fill_every_elementary_interval() {
        for pixel in 0..50 {
            let key = pixel_key(pixel, 7, 3);
            let points: Vec<_> = (0..16).map(|s| sample_2d(key, s, Dimension::Pupil)).collect();
            for log in 0..=4 {
                let (columns, rows) = (1 << log, 1 << (4 - log));
                let mut seen = [0; 16];
                for [x, y] in &points {
                    let cell = (x * columns as f32) as usize * rows + (y * rows as f32) as usize;
                    seen[cell] += 1;
                }
                assert_eq!(seen, [1; 16], "pixel {pixel}, {columns} x {rows}");
            }
        }
    }

    #[test]
    fn samples_are_uniform_and_dimensions_independent() {
        // The tolerance is five standard errors.
        let n = 1_000_000u32;
        let (mut sum, mut cross) = ([0.0f64; 2], 0.0f64);
        for i in 0..n {
            let key = pixel_key(i % 1000, i / 1000, 0);
            let [a, _] = sample_2d(key, 0, Dimension::Film);
            let [b, _] = sample_2d(key, 0, Dimension::Pupil);
            sum[0] += f64::from(a);
            sum[1] += f64::from(b);
            cross += (f64::from(a) - 0.5) * (f64::from(b) - 0.5);
        }
        let n = f64::from(n);
        let standard_error = (1.0 / 12.0f64 / n).sqrt();
        assert!((sum[0] / n - 0.5).abs() < 5.0 * standard_error);
        assert!((sum[1] / n - 0.5).abs() < 5.0 * standard_error);
        assert!((cross / n).abs() < 5.0 / 12.0 / n.sqrt());
    }
}
