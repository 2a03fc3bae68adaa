//! Textures of a material at points of its surface.

use petzval_base::lanes::Real;
use petzval_scene::{Roughness, Texture};

/// Textures of a material at points of its surface, one point per lane. BSDF parameters are made of
/// them.
pub(in crate::shade) trait SurfaceTextures<R: Real<Scalar = f32>> {
    /// Returns the colour of a texture.
    fn colour(&self, texture: &Texture) -> [R; 3];

    /// Returns the value of a scalar texture.
    fn number(&self, texture: &Texture) -> R;

    /// Returns the texture coordinates.
    fn uv(&self) -> [R; 2];

    /// Returns the share of light that a texture stands for, by colour channel.
    #[inline(always)]
    fn share(&self, texture: &Texture) -> [R; 3] {
        clamp_to_unit(self.colour(texture))
    }

    /// Returns the width alpha of microfacets along u and v.
    #[inline(always)]
    fn alpha(&self, roughness: &Roughness) -> [R; 2] {
        let one_axis = |texture: &Texture| {
            let value = self.number(texture).max(R::splat(0.0));
            if roughness.remap { value.sqrt() } else { value }
        };
        [one_axis(&roughness.uv[0]), one_axis(&roughness.uv[1])]
    }
}

/// Clamps shares of light to [0, 1]; NaN becomes 0.
#[inline(always)]
pub(in crate::shade) fn clamp_to_unit<R: Real<Scalar = f32>>([r, g, b]: [R; 3]) -> [R; 3] {
    let (zero, one) = (R::splat(0.0), R::splat(1.0));
    [r.max(zero).min(one), g.max(zero).min(one), b.max(zero).min(one)]
}
