//! Gradient noise and its sums of octaves.
//!
//! The noise is that of Perlin, "Improving noise" (2002), with pbrt-v4's choice of the sixteen
//! gradients. The sums are those of Perlin, "An image synthesizer" (1985), limited to the octaves that
//! samples resolve (Pharr, Jakob & Humphreys, "Physically based rendering", 3rd edition, 2016,
//! section 10.6). Points are evaluated one by one, also those of packets.

use glam::Vec3;

/// Permutation of Perlin (2002).
#[rustfmt::skip]
const PERMUTATION: [u8; 256] = [
    151, 160, 137, 91, 90, 15, 131, 13, 201, 95, 96, 53, 194, 233, 7, 225, 140, 36, 103, 30, 69,
    142, 8, 99, 37, 240, 21, 10, 23, 190, 6, 148, 247, 120, 234, 75, 0, 26, 197, 62, 94, 252, 219,
    203, 117, 35, 11, 32, 57, 177, 33, 88, 237, 149, 56, 87, 174, 20, 125, 136, 171, 168, 68, 175,
    74, 165, 71, 134, 139, 48, 27, 166, 77, 146, 158, 231, 83, 111, 229, 122, 60, 211, 133, 230,
    220, 105, 92, 41, 55, 46, 245, 40, 244, 102, 143, 54, 65, 25, 63, 161, 1, 216, 80, 73, 209, 76,
    132, 187, 208, 89, 18, 169, 200, 196, 135, 130, 116, 188, 159, 86, 164, 100, 109, 198, 173, 186,
    3, 64, 52, 217, 226, 250, 124, 123, 5, 202, 38, 147, 118, 126, 255, 82, 85, 212, 207, 206, 59,
    227, 47, 16, 58, 17, 182, 189, 28, 42, 223, 183, 170, 213, 119, 248, 152, 2, 44, 154, 163, 70,
    221, 153, 101, 155, 167, 43, 172, 9, 129, 22, 39, 253, 19, 98, 108, 110, 79, 113, 224, 232, 178,
    185, 112, 104, 218, 246, 97, 228, 251, 34, 242, 193, 238, 210, 144, 12, 191, 179, 162, 241, 81,
    51, 145, 235, 249, 14, 239, 107, 49, 192, 214, 31, 181, 199, 106, 157, 184, 84, 204, 176, 115,
    121, 50, 45, 127, 4, 150, 254, 138, 236, 205, 93, 222, 114, 67, 29, 24, 72, 243, 141, 128, 195,
    78, 66, 215, 61, 156, 180,
];

/// Gradients: the edges of a cube, four of them twice.
const GRADIENTS: [Vec3; 16] = [
    Vec3::new(1.0, 1.0, 0.0),
    Vec3::new(-1.0, 1.0, 0.0),
    Vec3::new(1.0, -1.0, 0.0),
    Vec3::new(-1.0, -1.0, 0.0),
    Vec3::new(1.0, 0.0, 1.0),
    Vec3::new(-1.0, 0.0, 1.0),
    Vec3::new(1.0, 0.0, -1.0),
    Vec3::new(-1.0, 0.0, -1.0),
    Vec3::new(0.0, 1.0, 1.0),
    Vec3::new(0.0, -1.0, 1.0),
    Vec3::new(0.0, 1.0, -1.0),
    Vec3::new(0.0, -1.0, -1.0),
    Vec3::new(1.0, 1.0, 0.0),
    Vec3::new(-1.0, 1.0, 0.0),
    Vec3::new(0.0, 1.0, -1.0),
    Vec3::new(0.0, -1.0, -1.0),
];

/// Coordinates repeat at this distance, so that cell numbers fit in 32 bits.
const REPEAT: f32 = (1 << 30) as f32;

/// Ratio of the frequencies of successive octaves. It is not 2, so that the zeros of the octaves,
/// which are at integers, do not coincide.
const LACUNARITY: f32 = 1.99;

/// Mean of the absolute value of the noise, which replaces octaves that are too fine.
const MEAN_ABSOLUTE: f32 = 0.2;

/// Returns the noise at a point: -1 to 1, and 0 at points with integer coordinates.
pub(crate) fn noise(at: Vec3) -> f32 {
    let at = Vec3::new(at.x % REPEAT, at.y % REPEAT, at.z % REPEAT);
    let whole = at.floor();
    let [x, y, z] = whole.to_array().map(|v| v as i32);
    let offset = at - whole;
    let corner = |i: i32, j: i32, k: i32| {
        let gradient = GRADIENTS[hash(x + i, y + j, z + k) & 15];
        gradient.dot(offset - Vec3::new(i as f32, j as f32, k as f32))
    };
    let [u, v, w] = offset.to_array().map(fade);
    let along_x = |j, k| lerp(u, corner(0, j, k), corner(1, j, k));
    let in_plane = |k| lerp(v, along_x(0, k), along_x(1, k));
    lerp(w, in_plane(0), in_plane(1))
}

fn hash(x: i32, y: i32, z: i32) -> usize {
    let permute = |i: usize| usize::from(PERMUTATION[i & 255]);
    // The low eight bits of a negative number are those of its remainder by 256.
    let [x, y, z] = [x, y, z].map(|v| (v & 255) as usize);
    permute(permute(permute(x) + y) + z)
}

/// Returns the weight of the far corner: a polynomial whose first two derivatives are 0 at both
/// ends (Perlin 2002).
fn fade(t: f32) -> f32 {
    t * t * t * (10.0 + t * (6.0 * t - 15.0))
}

fn lerp(t: f32, a: f32, b: f32) -> f32 {
    (1.0 - t) * a + t * b
}

/// Octaves of a sum of noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Octaves {
    /// Most octaves; at most [`Octaves::MAX`].
    pub count: u32,
    /// Amplitude of an octave over that of the one before.
    pub roughness: f32,
}

impl Octaves {
    /// Limit of the number of octaves. The frequency of the last one stays in the range of f32.
    pub const MAX: u32 = 64;

    /// Returns the fractional Brownian motion at a point: the sum of the octaves. `steps` are the
    /// changes of the point to the neighbouring samples; octaves that they cannot resolve are left
    /// out.
    pub(super) fn motion(self, at: Vec3, steps: [Vec3; 2]) -> f32 {
        let (whole, share) = self.resolved(steps);
        let (mut sum, mut frequency, mut amplitude) = (0.0, 1.0, 1.0);
        for _ in 0..whole {
            sum += amplitude * noise(frequency * at);
            frequency *= LACUNARITY;
            amplitude *= self.roughness;
        }
        sum + amplitude * share * noise(frequency * at)
    }

    /// Returns the turbulence at a point: the sum of the absolute values of the octaves. Those that
    /// `steps` cannot resolve count by their mean.
    pub(super) fn turbulence(self, at: Vec3, steps: [Vec3; 2]) -> f32 {
        let (whole, share) = self.resolved(steps);
        let (mut sum, mut frequency, mut amplitude) = (0.0, 1.0, 1.0);
        for _ in 0..whole {
            sum += amplitude * noise(frequency * at).abs();
            frequency *= LACUNARITY;
            amplitude *= self.roughness;
        }
        // As in pbrt-v4, the octave that is faded out counts a second time among the rest.
        sum += amplitude * lerp(share, MEAN_ABSOLUTE, noise(frequency * at).abs());
        for _ in whole..self.count {
            sum += amplitude * MEAN_ABSOLUTE;
            amplitude *= self.roughness;
        }
        sum
    }

    /// Returns the number of octaves that the distance between samples resolves, and the share of
    /// the next one, which is faded out.
    fn resolved(self, steps: [Vec3; 2]) -> (u32, f32) {
        // A step that is not a number counts as none.
        let widest = steps[0].length_squared().max(steps[1].length_squared());
        let resolved = if widest.is_nan() { f32::INFINITY } else { -1.0 - 0.5 * widest.log2() };
        let resolved = resolved.clamp(0.0, self.count as f32);
        let t = ((resolved.fract() - 0.3) / 0.4).clamp(0.0, 1.0);
        (resolved as u32, t * t * (3.0 - 2.0 * t))
    }
}

/// Points and steps to the neighbouring samples, for the tests of all patterns.
#[cfg(test)]
pub(super) mod samples {
    use glam::Vec3;

    /// Far, negative and near points, and one beyond the range in which cells have numbers of 32
    /// bits.
    pub(in crate::texture) const POINTS: [Vec3; 5] = [
        Vec3::new(0.3, 0.6, 0.1),
        Vec3::new(-1.7, 2.25, -0.4),
        Vec3::new(13.37, -7.77, 4.2),
        Vec3::new(-300.5, 255.9, 1000.1),
        Vec3::new(2e9, 0.5, 0.25),
    ];
    /// Steps that resolve about five octaves.
    pub(in crate::texture) const STEPS: [Vec3; 2] =
        [Vec3::new(0.01, 0.003, 0.0), Vec3::new(0.0, 0.02, 0.005)];
    /// Rounding of the sums in another order, and of the weights of corners.
    pub(in crate::texture) const ROUNDING: f32 = 3e-6;
}

#[cfg(test)]
mod tests {
    use super::samples::{POINTS, ROUNDING, STEPS};
    use super::*;

    const WIDE_STEPS: [Vec3; 2] = [Vec3::new(0.3, 0.0, 0.1), Vec3::new(0.0, 0.1, 0.0)];

    fn assert_near(found: f32, expected: f32) {
        assert!((found - expected).abs() < ROUNDING, "{found}, expected {expected}");
    }

    /// The numbers of this and the following two tests are printed by pbrt-v4.
    #[test]
    fn noise_equals_pbrts() {
        let expected = [-0.109_583_244, -0.335_233_48, -0.490_295_53, 0.298_363_66, -0.060_302_734];
        for (at, expected) in POINTS.into_iter().zip(expected) {
            assert_near(noise(at), expected);
        }
    }

    #[test]
    fn motion_equals_pbrts_for_narrow_and_wide_footprints() {
        let expected = [
            [0.107_113_086, 0.215_939_28, -0.106_656],
            [-0.114_360_15, -0.027_903_587, -0.326_278_54],
            [-0.568_812_7, -0.543_464_6, -0.477_198_48],
            [0.115_459_725, 0.049_183_205, 0.290_393_6],
            [0.035_376_117, 0.058_404_83, -0.058_691_897],
        ];
        for (at, expected) in POINTS.into_iter().zip(expected) {
            let octaves = |roughness| Octaves { count: 8, roughness };
            assert_near(octaves(0.5).motion(at, [Vec3::ZERO; 2]), expected[0]);
            assert_near(octaves(0.6).motion(at, STEPS), expected[1]);
            assert_near(octaves(0.5).motion(at, WIDE_STEPS), expected[2]);
        }
    }

    #[test]
    fn turbulence_equals_pbrts_for_narrow_and_wide_footprints() {
        let expected = [
            [0.343_385_37, 0.495_548_58, 0.510_436],
            [0.566_971_5, 0.704_144_5, 0.730_058_55],
            [0.832_432_57, 0.991_424_8, 0.880_978_5],
            [0.520_931_8, 0.647_755_27, 0.694_173_63],
            [0.212_311_85, 0.294_711_83, 0.462_471_9],
        ];
        for (at, expected) in POINTS.into_iter().zip(expected) {
            let octaves = |roughness| Octaves { count: 8, roughness };
            assert_near(octaves(0.5).turbulence(at, [Vec3::ZERO; 2]), expected[0]);
            assert_near(octaves(0.6).turbulence(at, STEPS), expected[1]);
            assert_near(octaves(0.5).turbulence(at, WIDE_STEPS), expected[2]);
        }
    }

    #[test]
    fn steps_without_an_end_resolve_no_octave_and_those_that_are_no_numbers_all() {
        let (octaves, at) = (Octaves { count: 8, roughness: 0.5 }, POINTS[0]);
        assert_eq!(octaves.motion(at, [Vec3::INFINITY, Vec3::ZERO]), 0.0);
        let point = octaves.motion(at, [Vec3::ZERO; 2]);
        assert_eq!(octaves.motion(at, [Vec3::NAN; 2]), point);
        assert_eq!(octaves.motion(at, [Vec3::NAN, Vec3::ZERO]), point);
    }

    #[test]
    fn no_point_and_no_number_of_octaves_leaves_the_range() {
        let octaves = Octaves { count: Octaves::MAX, roughness: 0.9 };
        for far in [1e-30f32, 1.0, 1e9, 1e18, -1e18] {
            let found = octaves.turbulence(Vec3::new(far, 0.3 * far, -far), [Vec3::ZERO; 2]);
            assert!((0.0..20.0).contains(&found), "{far}: {found}");
        }
    }
}
