//! Unfiltered images in floats, for skies, area lights and normal maps.

use std::sync::Arc;

use glam::Vec2;

use super::texel::{bilinear, texel_coordinates};
use super::{Mapping, TexturePoint, Wrap};
use petzval_image::Picture;

/// An image that is interpolated between texels, without a mipmap.
#[derive(Clone, Debug)]
pub struct ImageMap {
    /// Pixels, row 0 at the top.
    pub picture: Arc<Picture>,
    /// Mapping from points of a surface to image coordinates.
    pub mapping: Mapping,
    /// Wrap mode beyond the edges.
    pub wrap: Wrap,
    /// Whether t = 0 is the top of the image instead of the bottom.
    pub top_down: bool,
    /// Factor of the colours.
    pub scale: f32,
    /// Whether to return 1 - colour.
    pub invert: bool,
}

impl ImageMap {
    /// Returns the colour at texture coordinates of a surface, by bilinear interpolation.
    pub fn colour(&self, uv: Vec2) -> [f32; 3] {
        let at = TexturePoint { uv: uv.to_array(), ..TexturePoint::default() };
        let ([s, t], _) = self.mapping.at(&at);
        let t = if self.top_down { t } else { 1.0 - t };
        let size = self.picture.size;
        let at = texel_coordinates(Vec2::new(s, t), size, self.wrap);
        let colour = bilinear(at, |x, y| self.texel(x, y)).map(|c| c * self.scale);
        if self.invert { colour.map(|c| 1.0 - c) } else { colour }
    }

    fn texel(&self, x: i64, y: i64) -> [f32; 3] {
        let [width, height] = self.picture.size;
        match self.wrap.resolve([x, y], [width as i64, height as i64]) {
            Some([x, y]) => self.picture.pixels[y as usize * width + x as usize],
            None => [0.0; 3],
        }
    }
}
