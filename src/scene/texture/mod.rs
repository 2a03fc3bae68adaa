//! Textures: colours and numbers that change over a surface.

mod bilinear;
mod checkerboard;
mod image_map;
mod image_texture;
mod mapping;
mod pyramid;
mod wrap;

use std::sync::Arc;

use glam::{Vec2, Vec3};

pub use checkerboard::Board;
pub use image_map::ImageMap;
pub use image_texture::{Awaited, ImageTexture};
pub use mapping::Mapping;
pub use pyramid::{Filter, Pyramid};
pub use wrap::Wrap;

/// Where a texture is looked up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TexturePoint {
    /// Texture coordinates of the surface.
    pub uv: Vec2,
    /// The point itself, world space.
    pub position: Vec3,
    /// Unit normal of the surface itself, world space, on either side.
    pub normal: Vec3,
    /// About how far the sample reaches along each of u and v; 0 is a point.
    pub footprint: f32,
}

/// A colour, linear RGB, or a number for every point of a surface.
#[derive(Clone, Debug)]
pub enum Texture {
    /// The same everywhere.
    Constant([f32; 3]),
    /// An image.
    Image(Arc<ImageTexture>),
    /// A number instead of a colour: grey.
    Number(Arc<Texture>),
    /// Two textures in turn.
    Checkerboard {
        /// Where which.
        board: Arc<Board>,
        /// The textures.
        textures: [Arc<Texture>; 2],
    },
    /// The product of two.
    Scale(Arc<Texture>, Arc<Texture>),
    /// Some of one and the rest of another.
    Mix {
        /// The share of the second, a number.
        amount: Arc<Texture>,
        /// The textures.
        textures: [Arc<Texture>; 2],
    },
    /// The first where the surface faces along a direction or against it, the second where it is
    /// edge on.
    DirectionMix {
        /// The direction, world space, of unit length.
        direction: Vec3,
        /// The textures.
        textures: [Arc<Texture>; 2],
    },
    /// Between four colours, and beyond them.
    Bilerp {
        /// Where between.
        mapping: Arc<Mapping>,
        /// At (0, 0), (1, 0), (0, 1) and (1, 1).
        corners: [[f32; 3]; 4],
    },
}

/// What a texture can be evaluated to.
trait Value: Copy {
    fn constant(colour: [f32; 3]) -> Self;
    fn image(image: &ImageTexture, at: &TexturePoint) -> Self;
    fn zip(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self;
}

impl Value for [f32; 3] {
    fn constant(colour: [f32; 3]) -> Self {
        colour
    }
    fn image(image: &ImageTexture, at: &TexturePoint) -> Self {
        image.colour(at)
    }
    fn zip(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        [0, 1, 2].map(|i| f(self[i], other[i]))
    }
}

impl Value for f32 {
    fn constant([r, g, b]: [f32; 3]) -> Self {
        if r == g && g == b { r } else { (r + g + b) / 3.0 }
    }
    fn image(image: &ImageTexture, at: &TexturePoint) -> Self {
        image.number(at)
    }
    fn zip(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        f(self, other)
    }
}

impl Texture {
    /// How many textures are looked at for one colour, at most.
    pub fn parts(&self) -> usize {
        match self {
            Self::Constant(_) | Self::Image(_) | Self::Bilerp { .. } => 1,
            Self::Number(texture) => 1 + texture.parts(),
            Self::Scale(one, other)
            | Self::Checkerboard { textures: [one, other], .. }
            | Self::DirectionMix { textures: [one, other], .. } => 1 + one.parts() + other.parts(),
            Self::Mix { amount, textures: [one, other] } => {
                1 + amount.parts() + one.parts() + other.parts()
            }
        }
    }

    /// Whether it is averaged over a footprint.
    pub fn is_filtered(&self) -> bool {
        match self {
            Self::Constant(_) | Self::Bilerp { .. } => false,
            Self::Image(_) | Self::Checkerboard { .. } => true,
            Self::Number(texture) => texture.is_filtered(),
            Self::Scale(one, other) | Self::DirectionMix { textures: [one, other], .. } => {
                one.is_filtered() || other.is_filtered()
            }
            Self::Mix { amount, textures: [one, other] } => {
                amount.is_filtered() || one.is_filtered() || other.is_filtered()
            }
        }
    }

    /// The number at a point. Of an image, it is the alpha if there is one and the mean of the
    /// channels otherwise, as pbrt-v4 has it.
    pub fn number(&self, at: &TexturePoint) -> f32 {
        self.value(at)
    }

    /// The colour at a point.
    pub fn at(&self, at: &TexturePoint) -> [f32; 3] {
        self.value(at)
    }

    fn value<V: Value>(&self, at: &TexturePoint) -> V {
        match self {
            Self::Constant(colour) => V::constant(*colour),
            Self::Image(image) => V::image(image, at),
            Self::Number(texture) => V::constant([texture.number(at); 3]),
            Self::Checkerboard { board, textures } => blend(textures, board.share(at), at),
            Self::Scale(one, other) => one.value::<V>(at).zip(other.value(at), |a, b| a * b),
            Self::Mix { amount, textures } => blend(textures, amount.number(at), at),
            Self::DirectionMix { direction, textures } => {
                blend(textures, 1.0 - at.normal.dot(*direction).abs(), at)
            }
            Self::Bilerp { mapping, corners } => {
                let (Vec2 { x, y }, _) = mapping.at(at);
                let weights = [(1.0 - x) * (1.0 - y), x * (1.0 - y), (1.0 - x) * y, x * y];
                let colour = |i: usize| (0..4).map(|j| weights[j] * corners[j][i]).sum();
                V::constant([0, 1, 2].map(colour))
            }
        }
    }
}

/// Some of the second texture and the rest of the first, which is not looked at where there is
/// none of it.
fn blend<V: Value>(textures: &[Arc<Texture>; 2], share: f32, at: &TexturePoint) -> V {
    if share == 0.0 {
        return textures[0].value(at);
    }
    if share == 1.0 {
        return textures[1].value(at);
    }
    let (one, other): (V, V) = (textures[0].value(at), textures[1].value(at));
    one.zip(other, |a, b| (1.0 - share) * a + share * b)
}

#[cfg(test)]
mod tests {
    use super::*;

    const RED: [f32; 3] = [0.8, 0.1, 0.0];
    const BLUE: [f32; 3] = [0.0, 0.3, 0.6];

    fn pair() -> [Arc<Texture>; 2] {
        [RED, BLUE].map(|colour| Arc::new(Texture::Constant(colour)))
    }

    fn assert_near(found: [f32; 3], expected: [f32; 3]) {
        let off = (0..3).map(|i| (found[i] - expected[i]).abs()).fold(0.0, f32::max);
        assert!(off < 1e-6, "{found:?}, expected {expected:?}");
    }

    #[test]
    fn a_mixture_has_the_amount_of_the_second() {
        let amount = Arc::new(Texture::Constant([0.25; 3]));
        let mix = Texture::Mix { amount, textures: pair() };
        assert_near(mix.at(&TexturePoint::default()), [0.6, 0.15, 0.15]);
        assert!((mix.number(&TexturePoint::default()) - 0.3).abs() < 1e-6);
        assert_eq!(mix.parts(), 4);
    }

    #[test]
    fn a_mixture_by_direction_is_the_first_where_the_surface_faces_it() {
        let mix = Texture::DirectionMix { direction: Vec3::Y, textures: pair() };
        let facing = |normal: Vec3| mix.at(&TexturePoint { normal, ..TexturePoint::default() });
        assert_near(facing(Vec3::Y), RED);
        assert_near(facing(Vec3::NEG_Y), RED);
        assert_near(facing(Vec3::X), BLUE);
        assert_near(facing(Vec3::new(0.0, 0.5, 0.75f32.sqrt())), [0.4, 0.2, 0.3]);
    }

    #[test]
    fn four_corners_are_interpolated() {
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 1.0]];
        let texture = Texture::Bilerp { mapping: Arc::default(), corners };
        let at = |u: f32, v: f32| {
            texture.at(&TexturePoint { uv: Vec2::new(u, v), ..TexturePoint::default() })
        };
        assert_near(at(1.0, 0.0), [1.0, 0.0, 0.0]);
        assert_near(at(0.25, 0.5), [0.25, 0.5, 0.125]);
    }

    #[test]
    fn products_are_by_channel_and_numbers_are_grey() {
        let [red, blue] = pair();
        let product = Texture::Scale(red, Arc::new(Texture::Number(blue)));
        assert_near(product.at(&TexturePoint::default()), [0.24, 0.03, 0.0]);
    }
}
