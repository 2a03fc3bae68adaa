//! Textures: colours that change over a surface.

use std::sync::Arc;

use glam::{Vec2, Vec3};

use crate::image::Picture;

/// What lies beyond the edge of an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The image again.
    #[default]
    Repeat,
    /// Its outermost pixels.
    Clamp,
    /// Nothing.
    Black,
}

/// Where a texture is looked up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TexturePoint {
    /// Texture coordinates of the surface.
    pub uv: Vec2,
    /// The point itself, world space.
    pub position: Vec3,
    /// About how far the sample reaches along each of u and v; 0 is a point.
    pub footprint: f32,
}

/// A colour for every texture coordinate; linear RGB.
#[derive(Clone, Debug)]
pub enum Texture {
    /// The same everywhere.
    Constant([f32; 3]),
    /// An image, interpolated between pixels.
    Image(ImageMap),
    /// Two textures in turn over squares of one unit.
    Checkerboard {
        /// How coordinates become squares.
        mapping: Mapping,
        /// The textures.
        squares: [Arc<Texture>; 2],
    },
    /// The product of two.
    Scale(Arc<Texture>, Arc<Texture>),
}

/// Texture coordinates from surface coordinates: scale, then offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mapping {
    /// Factors of u and v.
    pub scale: Vec2,
    /// What is added to them.
    pub offset: Vec2,
}

impl Default for Mapping {
    fn default() -> Self {
        Self { scale: Vec2::ONE, offset: Vec2::ZERO }
    }
}

impl Mapping {
    fn apply(&self, uv: Vec2) -> Vec2 {
        uv * self.scale + self.offset
    }
}

/// An image on a surface.
#[derive(Clone, Debug)]
pub struct ImageMap {
    /// Its pixels, row 0 at the top.
    pub picture: Arc<Picture>,
    /// How surface coordinates become image coordinates.
    pub mapping: Mapping,
    /// What lies beyond its edge.
    pub wrap: Wrap,
    /// Whether t = 0 is the top of the image (pbrt-v2) or the bottom (pbrt-v4).
    pub top_down: bool,
    /// What its colours are multiplied by.
    pub scale: f32,
    /// Whether 1 - colour is meant.
    pub invert: bool,
}

impl Texture {
    /// How many textures are looked at for one colour, at most.
    pub fn parts(&self) -> usize {
        match self {
            Self::Constant(_) | Self::Image(_) => 1,
            Self::Checkerboard { squares: [one, other], .. } | Self::Scale(one, other) => {
                1 + one.parts() + other.parts()
            }
        }
    }

    /// A number at a point: the mean of the colour, as pbrt reads images.
    pub fn number(&self, at: &TexturePoint) -> f32 {
        let [r, g, b] = self.at(at);
        (r + g + b) / 3.0
    }

    /// The colour at a point.
    pub fn at(&self, at: &TexturePoint) -> [f32; 3] {
        match self {
            Self::Constant(colour) => *colour,
            Self::Image(map) => map.at(at.uv),
            Self::Checkerboard { mapping, squares } => {
                let square = mapping.apply(at.uv).floor();
                let odd = (square.x + square.y).rem_euclid(2.0) == 1.0;
                squares[usize::from(odd)].at(at)
            }
            Self::Scale(one, other) => {
                let (one, other) = (one.at(at), other.at(at));
                [0, 1, 2].map(|i| one[i] * other[i])
            }
        }
    }
}

impl ImageMap {
    /// The colour of the image at these surface coordinates.
    pub fn at(&self, uv: Vec2) -> [f32; 3] {
        let st = self.mapping.apply(uv);
        let t = if self.top_down { st.y } else { 1.0 - st.y };
        let [width, height] = self.picture.size.map(|n| n as i32);
        // Whole turns are taken off before the texel is found, so that far repeats stay sharp.
        let fold = |x: f32| if self.wrap == Wrap::Repeat { x - x.floor() } else { x };
        let x = fold(st.x) * width as f32 - 0.5;
        let y = fold(t) * height as f32 - 0.5;
        let (x0, y0) = (x.floor(), y.floor());
        let (fx, fy) = (x - x0, y - y0);
        let (x0, y0) = (x0 as i32, y0 as i32);
        let (x1, y1) = (x0.saturating_add(1), y0.saturating_add(1));
        let corners = [
            (self.texel(x0, y0), (1.0 - fx) * (1.0 - fy)),
            (self.texel(x1, y0), fx * (1.0 - fy)),
            (self.texel(x0, y1), (1.0 - fx) * fy),
            (self.texel(x1, y1), fx * fy),
        ];
        let colour =
            [0, 1, 2].map(|i| self.scale * corners.iter().map(|(c, w)| c[i] * w).sum::<f32>());
        if self.invert { colour.map(|c| 1.0 - c) } else { colour }
    }

    fn texel(&self, x: i32, y: i32) -> [f32; 3] {
        let [width, height] = self.picture.size.map(|n| n as i32);
        let place = |i: i32, n: i32| match self.wrap {
            Wrap::Repeat => Some(i.rem_euclid(n)),
            Wrap::Clamp => Some(i.clamp(0, n - 1)),
            Wrap::Black => (0..n).contains(&i).then_some(i),
        };
        match (place(x, width), place(y, height)) {
            (Some(x), Some(y)) => self.picture.pixels[y as usize * width as usize + x as usize],
            _ => [0.0; 3],
        }
    }
}
