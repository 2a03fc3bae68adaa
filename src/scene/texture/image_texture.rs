//! Images on surfaces, filtered.

use std::sync::{Arc, OnceLock};

use glam::Vec2;

use super::{Filter, Mapping, Pyramid, TexturePoint, Wrap};

/// A picture that may still be on its way from its file; black until then.
#[derive(Clone, Debug, Default)]
pub struct Awaited(Arc<OnceLock<Pyramid>>);

impl Awaited {
    /// Hands in the picture; the first one stays.
    pub fn arrive(&self, pyramid: Pyramid) {
        self.0.get_or_init(|| pyramid);
    }

    /// The picture, once it is here.
    pub fn get(&self) -> Option<&Pyramid> {
        self.0.get()
    }
}

impl From<Pyramid> for Awaited {
    fn from(pyramid: Pyramid) -> Self {
        Self(Arc::new(OnceLock::from(pyramid)))
    }
}

/// An image on a surface.
#[derive(Clone, Debug)]
pub struct ImageTexture {
    /// Its pixels.
    pub picture: Awaited,
    /// How surfaces become the image.
    pub mapping: Mapping,
    /// What lies beyond its edge.
    pub wrap: Wrap,
    /// Which texels make a colour.
    pub filter: Filter,
    /// Whether t = 0 is the top of the image (pbrt-v2) or the bottom (pbrt-v4).
    pub top_down: bool,
    /// What its colours are multiplied by.
    pub scale: f32,
    /// Whether 1 - colour is meant, the scale counted in and nothing below 0.
    pub invert: bool,
}

impl ImageTexture {
    /// The colour of the image at a point of a surface; linear RGB.
    pub fn colour(&self, at: &TexturePoint) -> [f32; 3] {
        let [r, g, b, _] = self.look_up(at);
        [r, g, b].map(|v| self.finished(v))
    }

    /// The number that the image means at a point of a surface: its alpha if it has one, the mean
    /// of its channels otherwise.
    pub fn number(&self, at: &TexturePoint) -> f32 {
        let [r, g, b, alpha] = self.look_up(at);
        let with_alpha = self.picture.get().is_some_and(|picture| picture.channels() == 4);
        self.finished(if with_alpha { alpha } else { (r + g + b) / 3.0 })
    }

    fn finished(&self, v: f32) -> f32 {
        let v = self.scale * v;
        if self.invert { (1.0 - v).max(0.0) } else { v }
    }

    fn look_up(&self, at: &TexturePoint) -> [f32; 4] {
        let Some(picture) = self.picture.get() else { return [0.0; 4] };
        let (st, reach) = self.mapping.at(at);
        let t = if self.top_down { st.y } else { 1.0 - st.y };
        picture.look_up(Vec2::new(st.x, t), reach, self.wrap, self.filter)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{Picture, Raster, Samples};

    fn texture(picture: impl Into<Awaited>) -> ImageTexture {
        ImageTexture {
            picture: picture.into(),
            mapping: Mapping::default(),
            wrap: Wrap::Clamp,
            filter: Filter::Bilinear,
            top_down: true,
            scale: 1.0,
            invert: false,
        }
    }

    fn pixel(channels: usize, floats: &[f32]) -> ImageTexture {
        let samples = Samples::Floats(floats.to_vec());
        texture(Pyramid::new(Raster { size: [1, 1], channels, samples }))
    }

    #[test]
    fn a_number_is_the_mean_or_the_alpha() {
        let at = TexturePoint::default();
        assert!((pixel(3, &[0.1, 0.2, 0.6]).number(&at) - 0.3).abs() < 1e-6);
        assert_eq!(pixel(4, &[0.1, 0.2, 0.6, 0.75]).number(&at), 0.75);
        assert_eq!(pixel(1, &[0.4]).number(&at), 0.4);
        assert_eq!(pixel(4, &[0.1, 0.2, 0.6, 0.75]).colour(&at), [0.1, 0.2, 0.6]);
    }

    #[test]
    fn the_scale_comes_before_the_inversion() {
        let at = TexturePoint::default();
        let image = ImageTexture { scale: 2.0, invert: true, ..pixel(3, &[0.125, 0.25, 0.75]) };
        assert_eq!(image.colour(&at), [0.75, 0.5, 0.0]);
    }

    #[test]
    fn up_is_where_the_dialect_says() {
        let picture = Picture { size: [1, 2], pixels: vec![[1.0; 3], [0.0; 3]] };
        let down = texture(Pyramid::from(&picture));
        let up = ImageTexture { top_down: false, ..down.clone() };
        let high = TexturePoint { uv: Vec2::new(0.5, 0.75), ..TexturePoint::default() };
        assert_eq!([down.number(&high), up.number(&high)], [0.0, 1.0]);
    }

    #[test]
    fn a_picture_that_is_not_here_yet_is_black() {
        let image = texture(Awaited::default());
        let at = TexturePoint::default();
        assert_eq!(image.colour(&at), [0.0; 3]);
        image.picture.arrive(Pyramid::from(&Picture { size: [1, 1], pixels: vec![[0.5; 3]] }));
        assert_eq!(image.colour(&at), [0.5; 3]);
    }
}
