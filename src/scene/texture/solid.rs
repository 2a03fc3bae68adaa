//! Solid textures: patterns of noise that fill space (Perlin 1985; Pharr, Jakob & Humphreys 2016,
//! section 10.6).

use glam::{Affine3A, Vec3};

use super::TexturePoint;
use super::noise::Octaves;
use super::value::Value;
use petzval_base::lanes::Real;

/// A pattern of noise in a texture space. It is evaluated lane by lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolidTexture {
    /// World space to texture space.
    pub texture_from_world: Affine3A,
    /// Pattern.
    pub pattern: SolidPattern,
}

/// The patterns of solid textures, as in pbrt-v4.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum SolidPattern {
    /// Fractional Brownian motion: a scalar.
    Fbm(Octaves),
    /// Turbulence: a scalar.
    Wrinkled(Octaves),
    /// Heights of waves of water under gusts of wind: a scalar.
    Windy,
    /// Marble with veins across the y axis: a colour.
    Marble {
        /// Octaves that bend the veins.
        octaves: Octaves,
        /// Factor of the coordinates.
        scale: f32,
        /// Amplitude of the bends.
        variation: f32,
    },
}

/// Octaves of the waves, and of the strength of the wind.
const WAVES: Octaves = Octaves { count: 6, roughness: 0.5 };
const GUSTS: Octaves = Octaves { count: 3, roughness: 0.5 };

/// Control points of the colours of marble across a vein, linear RGB before the factor
/// [`MARBLE_SCALE`]. Four successive ones are those of a cubic Bezier curve. The numbers are
/// pbrt-v4's.
const MARBLE: [Vec3; 9] = {
    let [pale, grey, warm] =
        [Vec3::new(0.58, 0.58, 0.6), Vec3::splat(0.5), Vec3::new(0.6, 0.59, 0.58)];
    [pale, pale, pale, grey, warm, pale, pale, Vec3::new(0.2, 0.2, 0.33), pale]
};
const MARBLE_SCALE: f32 = 1.5;

impl SolidTexture {
    /// Returns the value at points of surfaces.
    #[inline(never)]
    pub(super) fn value<R: Real<Scalar = f32>, V: Value<R>>(&self, at: &TexturePoint<R>) -> V {
        let [points, first, second] =
            [&at.position, &at.position_steps[0], &at.position_steps[1]].map(lanes);
        let mut colours = [[0.0; 8]; 3];
        for lane in 0..R::LANES {
            let vector = |from: &[[f32; 8]; 3]| Vec3::from(from.map(|axis| axis[lane]));
            let colour = self.at(vector(&points), [vector(&first), vector(&second)]);
            for channel in 0..3 {
                colours[channel][lane] = colour[channel];
            }
        }
        match self.pattern {
            SolidPattern::Marble { .. } => V::colour(colours.map(|channel| R::load(&channel))),
            _ => V::scalar(R::load(&colours[0])),
        }
    }

    /// Returns the colour at a position, world space; of a scalar, the first channel is the value.
    fn at(&self, position: Vec3, steps: [Vec3; 2]) -> Vec3 {
        let at = self.texture_from_world.transform_point3(position);
        let steps = steps.map(|step| self.texture_from_world.transform_vector3(step));
        let scaled = |factor: f32| (factor * at, steps.map(|step| factor * step));
        let value = match self.pattern {
            SolidPattern::Fbm(octaves) => octaves.motion(at, steps),
            SolidPattern::Wrinkled(octaves) => octaves.turbulence(at, steps),
            SolidPattern::Windy => {
                let (wide, wide_steps) = scaled(0.1);
                GUSTS.motion(wide, wide_steps).abs() * WAVES.motion(at, steps)
            }
            SolidPattern::Marble { octaves, scale, variation } => {
                let (at, steps) = scaled(scale);
                return marble(at.y + variation * octaves.motion(at, steps));
            }
        };
        Vec3::new(value, 0.0, 0.0)
    }
}

/// Returns the colour of marble at a phase; veins are 2 pi apart.
fn marble(phase: f32) -> Vec3 {
    let curves = MARBLE.len() - 3;
    let t = (0.5 + 0.5 * phase.sin()) * curves as f32;
    let first = (t as usize).min(curves - 1);
    let t = t - first as f32;
    // De Casteljau's algorithm.
    let mut points = [0, 1, 2, 3].map(|i| MARBLE[first + i]);
    for count in (1..4).rev() {
        for i in 0..count {
            points[i] = (1.0 - t) * points[i] + t * points[i + 1];
        }
    }
    MARBLE_SCALE * points[0]
}

/// Returns the lanes of a vector.
fn lanes<R: Real<Scalar = f32>>(from: &[R; 3]) -> [[f32; 8]; 3] {
    from.map(|axis| {
        let mut lanes = [0.0; 8];
        axis.store(&mut lanes);
        lanes
    })
}

#[cfg(test)]
mod tests {
    use super::super::Texture;
    use super::super::noise::samples::{POINTS, ROUNDING, STEPS};
    use super::*;
    use petzval_base::lanes::f32x8;

    fn texture(texture_from_world: Affine3A, pattern: SolidPattern) -> Texture {
        Texture::Solid(SolidTexture { texture_from_world, pattern }.into())
    }

    fn point(position: Vec3, steps: [Vec3; 2]) -> TexturePoint {
        TexturePoint {
            position: position.to_array(),
            position_steps: steps.map(|step| step.to_array()),
            ..TexturePoint::default()
        }
    }

    const BENT: SolidPattern = SolidPattern::Marble {
        octaves: Octaves { count: 6, roughness: 0.7 },
        scale: 2.5,
        variation: 1.5,
    };

    /// The numbers of both tests are printed by pbrt-v4.
    #[test]
    fn windy_equals_pbrts() {
        let windy = texture(Affine3A::IDENTITY, SolidPattern::Windy);
        let expected =
            [0.008_712_111, -0.045_951_486, -0.303_851_8, 0.056_666_404, 0.003_845_562_5];
        for (at, expected) in POINTS.into_iter().zip(expected) {
            let found = windy.scalar(&point(at, STEPS));
            assert!((found - expected).abs() < ROUNDING, "{found}, expected {expected}");
        }
    }

    #[test]
    fn marble_equals_pbrts() {
        let expected = [
            [0.620_661_74, 0.620_661_74, 0.722_838_64],
            [0.852_171_24, 0.852_171_24, 0.877_714_1],
            [0.846_930_86, 0.840_265_45, 0.841_169_2],
            [0.869_993_57, 0.869_993_57, 0.899_992],
            [0.618_516_45, 0.618_516_45, 0.721_314_3],
        ];
        for (at, expected) in POINTS.into_iter().zip(expected) {
            let found = texture(Affine3A::IDENTITY, BENT).colour(&point(at, STEPS));
            let off = Vec3::from(found).distance(expected.into());
            // The phase of a far point is rounded: it is large.
            assert!(off < 3.0 * ROUNDING + 1e-7 * at.y.abs(), "{found:?}, expected {expected:?}");
        }
    }

    #[test]
    fn positions_and_steps_are_taken_to_texture_space() {
        let octaves = Octaves { count: 8, roughness: 0.6 };
        let from_world = Affine3A::from_scale_rotation_translation(
            Vec3::new(0.5, 2.0, 1.0),
            glam::Quat::from_rotation_x(0.7),
            Vec3::new(3.0, -1.0, 0.25),
        );
        for at in POINTS.into_iter().take(3) {
            let back = from_world.inverse();
            let seen = point(back.transform_point3(at), STEPS.map(|s| back.transform_vector3(s)));
            let found = texture(from_world, SolidPattern::Fbm(octaves)).scalar(&seen);
            let expected = octaves.motion(at, STEPS);
            // The highest frequency, 1.99^5, times the rounding of positions.
            assert!((found - expected).abs() < 1e-4, "{found}, expected {expected}");
        }
    }

    #[test]
    fn eight_lanes_and_one_lane_agree() {
        let patterns = [
            SolidPattern::Fbm(Octaves { count: 5, roughness: 0.5 }),
            SolidPattern::Wrinkled(Octaves { count: 5, roughness: 0.5 }),
            SolidPattern::Windy,
            BENT,
        ];
        let points = [0, 1, 2, 3, 4, 0, 1, 2].map(|i| POINTS[i]);
        let column = |axis: usize| f32x8::load(&points.map(|at| at[axis]));
        let step = |i: usize| [0, 1, 2].map(|axis| f32x8::splat(STEPS[i][axis]));
        let packet = TexturePoint {
            position: [column(0), column(1), column(2)],
            position_steps: [step(0), step(1)],
            ..TexturePoint::default()
        };
        for pattern in patterns {
            let texture = texture(Affine3A::from_scale(Vec3::new(1.5, 1.0, -2.0)), pattern);
            let colours = texture.colour(&packet).map(|channel| channel.to_array());
            let scalars = texture.scalar(&packet).to_array();
            for lane in 0..8 {
                let at = point(points[lane], STEPS);
                assert_eq!(texture.colour(&at), colours.map(|channel| channel[lane]));
                assert_eq!(texture.scalar(&at), scalars[lane]);
            }
        }
    }
}
