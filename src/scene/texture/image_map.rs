//! Images as they are, whole and in floats: skies, lamps, bent normals.

use std::sync::Arc;

use glam::Vec2;

use super::bilinear::{bilinear, place};
use super::{Mapping, TexturePoint, Wrap};
use crate::image::Picture;

/// An image of which every pixel may be asked for.
#[derive(Clone, Debug)]
pub struct ImageMap {
    /// Its pixels, row 0 at the top.
    pub picture: Arc<Picture>,
    /// How surface coordinates become image coordinates.
    pub mapping: Mapping,
    /// What lies beyond its edge.
    pub wrap: Wrap,
    /// Whether t = 0 is the top of the image or the bottom.
    pub top_down: bool,
    /// What its colours are multiplied by.
    pub scale: f32,
    /// Whether 1 - colour is meant.
    pub invert: bool,
}

impl ImageMap {
    /// The colour of the image at these surface coordinates, between its texels.
    pub fn at(&self, uv: Vec2) -> [f32; 3] {
        let (st, _) = self.mapping.at(&TexturePoint { uv, ..TexturePoint::default() });
        let t = if self.top_down { st.y } else { 1.0 - st.y };
        let size = self.picture.size;
        let at = place(Vec2::new(st.x, t), size, self.wrap);
        let colour = bilinear(at, |x, y| self.texel(x, y)).map(|c| c * self.scale);
        if self.invert { colour.map(|c| 1.0 - c) } else { colour }
    }

    fn texel(&self, x: i64, y: i64) -> [f32; 3] {
        let [width, height] = self.picture.size;
        match self.wrap.place([x, y], [width as i64, height as i64]) {
            Some([x, y]) => self.picture.pixels[y as usize * width + x as usize],
            None => [0.0; 3],
        }
    }
}
