//! Types of texture values: colours and scalars.

use super::{ImageTexture, TexturePoint};
use petzval_base::lanes::Real;
use petzval_base::lanes::vector::splat;

/// Type of a texture's value: a colour or a scalar.
pub(super) trait Value<R>: Copy {
    fn constant(colour: [f32; 3]) -> Self;
    fn scalar(value: R) -> Self;
    fn colour(colour: [R; 3]) -> Self;
    fn image(image: &ImageTexture, at: &TexturePoint<R>) -> Self;
    fn product(self, other: Self) -> Self;
    /// Returns a colour times a matrix; a scalar stays as it is.
    fn transformed(self, matrix: &[[f32; 3]; 3]) -> Self;
    /// Returns the blend of two values. `weight` is that of the second; a value of weight 0 does
    /// not count even if it is infinite or NaN.
    fn blend(self, other: Self, weight: R) -> Self;
}

impl<R: Real<Scalar = f32>> Value<R> for [R; 3] {
    #[inline(always)]
    fn constant(colour: [f32; 3]) -> Self {
        splat(colour)
    }
    #[inline(always)]
    fn scalar(value: R) -> Self {
        [value; 3]
    }
    #[inline(always)]
    fn colour(colour: [R; 3]) -> Self {
        colour
    }
    #[inline(always)]
    fn image(image: &ImageTexture, at: &TexturePoint<R>) -> Self {
        image.colour(at)
    }
    #[inline(always)]
    fn product(self, other: Self) -> Self {
        [self[0] * other[0], self[1] * other[1], self[2] * other[2]]
    }
    #[inline(always)]
    fn transformed(self, matrix: &[[f32; 3]; 3]) -> Self {
        let row = |[r, g, b]: [f32; 3]| {
            R::splat(r) * self[0] + R::splat(g) * self[1] + R::splat(b) * self[2]
        };
        [row(matrix[0]), row(matrix[1]), row(matrix[2])]
    }
    #[inline(always)]
    fn blend(self, other: Self, weight: R) -> Self {
        [
            self[0].blend(other[0], weight),
            self[1].blend(other[1], weight),
            self[2].blend(other[2], weight),
        ]
    }
}

impl<R: Real<Scalar = f32>> Value<R> for R {
    #[inline(always)]
    fn transformed(self, _: &[[f32; 3]; 3]) -> Self {
        self
    }
    #[inline(always)]
    fn constant([r, g, b]: [f32; 3]) -> Self {
        R::splat(if r == g && g == b { r } else { (r + g + b) / 3.0 })
    }
    #[inline(always)]
    fn scalar(value: R) -> Self {
        value
    }
    #[inline(always)]
    fn colour([r, g, b]: [R; 3]) -> Self {
        let grey = r.equals(g) & g.equals(b);
        R::select(grey, r, (r + g + b) / R::splat(3.0))
    }
    #[inline(always)]
    fn image(image: &ImageTexture, at: &TexturePoint<R>) -> Self {
        image.scalar(at)
    }
    #[inline(always)]
    fn product(self, other: Self) -> Self {
        self * other
    }
    #[inline(always)]
    fn blend(self, other: Self, weight: R) -> Self {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let both = (one - weight) * self + weight * other;
        R::select(weight.equals(zero), self, R::select(weight.equals(one), other, both))
    }
}
