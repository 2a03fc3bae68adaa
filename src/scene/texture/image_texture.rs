//! Filtered images on surfaces.

use std::sync::{Arc, OnceLock};

use super::{Mapping, MipMap, TextureFilter, TexturePoint, Wrap};
use petzval_base::lanes::Real;

/// An image that may still have to be read from its file; black until then.
#[derive(Clone, Debug, Default)]
pub struct PendingImage(Arc<OnceLock<MipMap>>);

impl PendingImage {
    /// Sets the image; only the first call has an effect.
    pub fn set(&self, mipmap: MipMap) {
        self.0.get_or_init(|| mipmap);
    }

    /// Returns the image, if it is set.
    pub fn get(&self) -> Option<&MipMap> {
        self.0.get()
    }
}

impl From<MipMap> for PendingImage {
    fn from(mipmap: MipMap) -> Self {
        Self(Arc::new(OnceLock::from(mipmap)))
    }
}

/// An image on a surface.
#[derive(Clone, Debug)]
pub struct ImageTexture {
    /// Image at every scale.
    pub picture: PendingImage,
    /// Mapping from points of a surface to image coordinates.
    pub mapping: Mapping,
    /// Wrap mode beyond the edges.
    pub wrap: Wrap,
    /// Filter, unless `max_anisotropy` is given.
    pub filter: TextureFilter,
    /// Largest ratio of the axes of the ellipse over which the image is averaged, at least 1: the
    /// filter EWA.
    pub max_anisotropy: Option<f32>,
    /// Whether t = 0 is the top of the image (pbrt-v2) or the bottom (pbrt-v4).
    pub top_down: bool,
    /// Factor of the colours.
    pub scale: f32,
    /// Whether to return 1 - colour, after the scale and clamped to at least 0.
    pub invert: bool,
}

impl ImageTexture {
    /// Returns the colour at a point of a surface, linear RGB.
    #[inline(never)]
    pub fn colour<R: Real<Scalar = f32>>(&self, at: &TexturePoint<R>) -> [R; 3] {
        let [r, g, b, _] = self.sample(at);
        [self.apply_scale(r), self.apply_scale(g), self.apply_scale(b)]
    }

    /// Returns the scalar at a point of a surface: the alpha if the image has one, otherwise the
    /// mean of its channels.
    #[inline(never)]
    pub fn scalar<R: Real<Scalar = f32>>(&self, at: &TexturePoint<R>) -> R {
        let [r, g, b, alpha] = self.sample(at);
        let with_alpha = self.picture.get().is_some_and(|picture| picture.channels() == 4);
        self.apply_scale(if with_alpha { alpha } else { (r + g + b) / R::splat(3.0) })
    }

    #[inline(always)]
    fn apply_scale<R: Real<Scalar = f32>>(&self, v: R) -> R {
        let v = R::splat(self.scale) * v;
        if self.invert { (R::splat(1.0) - v).max(R::splat(0.0)) } else { v }
    }

    #[inline(always)]
    fn sample<R: Real<Scalar = f32>>(&self, at: &TexturePoint<R>) -> [R; 4] {
        let Some(picture) = self.picture.get() else { return [R::splat(0.0); 4] };
        let ([s, t], radius) = self.mapping.at(at);
        let t = if self.top_down { t } else { R::splat(1.0) - t };
        let Some(max_anisotropy) = self.max_anisotropy else {
            return picture.sample([s, t], radius, self.wrap, self.filter);
        };
        // pbrt-v4 leaves out the sign: its slanted ellipses are mirrored.
        let sign = R::splat(if self.top_down { 1.0 } else { -1.0 });
        let steps = self.mapping.steps(at).map(|[s, t]| [s, sign * t]);
        picture.sample_ellipse([s, t], steps, self.wrap, max_anisotropy)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use petzval_image::{ImageSamples, Picture, Raster};

    fn texture(picture: impl Into<PendingImage>) -> ImageTexture {
        ImageTexture {
            picture: picture.into(),
            mapping: Mapping::default(),
            wrap: Wrap::Clamp,
            filter: TextureFilter::Bilinear,
            max_anisotropy: None,
            top_down: true,
            scale: 1.0,
            invert: false,
        }
    }

    fn pixel(channels: usize, floats: &[f32]) -> ImageTexture {
        let samples = ImageSamples::Floats(floats.to_vec());
        texture(MipMap::new(Raster { size: [1, 1], channels, samples }))
    }

    #[test]
    fn a_scalar_is_the_alpha_or_the_mean_of_the_channels() {
        let at = TexturePoint::<f32>::default();
        assert!((pixel(3, &[0.1, 0.2, 0.6]).scalar(&at) - 0.3).abs() < 1e-6);
        assert_eq!(pixel(4, &[0.1, 0.2, 0.6, 0.75]).scalar(&at), 0.75);
        assert_eq!(pixel(1, &[0.4]).scalar(&at), 0.4);
        assert_eq!(pixel(4, &[0.1, 0.2, 0.6, 0.75]).colour(&at), [0.1, 0.2, 0.6]);
    }

    #[test]
    fn the_scale_applies_before_the_inversion() {
        let at = TexturePoint::<f32>::default();
        let image = ImageTexture { scale: 2.0, invert: true, ..pixel(3, &[0.125, 0.25, 0.75]) };
        assert_eq!(image.colour(&at), [0.75, 0.5, 0.0]);
    }

    #[test]
    fn the_dialect_decides_which_row_is_at_the_top() {
        let picture = Picture { size: [1, 2], pixels: vec![[1.0; 3], [0.0; 3]] };
        let down = texture(MipMap::from(&picture));
        let up = ImageTexture { top_down: false, ..down.clone() };
        let high = TexturePoint { uv: [0.5, 0.75], ..TexturePoint::<f32>::default() };
        assert_eq!([down.scalar(&high), up.scalar(&high)], [0.0, 1.0]);
    }

    #[test]
    fn a_pending_image_is_black() {
        let image = texture(PendingImage::default());
        let at = TexturePoint::<f32>::default();
        assert_eq!(image.colour(&at), [0.0; 3]);
        image.picture.set(MipMap::from(&Picture { size: [1, 1], pixels: vec![[0.5; 3]] }));
        assert_eq!(image.colour(&at), [0.5; 3]);
    }
}
