//! Textures: colours and scalars that vary over a surface.

mod checkerboard;
mod dots;
mod ewa;
mod filter;
mod image_map;
mod image_texture;
mod mapping;
mod mipmap;
mod noise;
mod solid;
mod texel;
mod value;

use std::sync::Arc;

use glam::Vec3;

pub use checkerboard::CheckerPattern;
pub use dots::DotPattern;
pub use image_map::ImageMap;
pub use image_texture::{ImageTexture, PendingImage};
pub use mapping::Mapping;
pub use mipmap::{MipMap, TextureFilter};
pub use noise::Octaves;
pub(super) use noise::noise;
pub use solid::{SolidPattern, SolidTexture};
pub use texel::Wrap;

use petzval_base::lanes::Real;
use petzval_base::lanes::vector::{dot, splat};
use petzval_spectrum::Colour;
use value::Value;

/// Point of a surface at which a texture is evaluated, in every lane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TexturePoint<R = f32> {
    /// Texture coordinates.
    pub uv: [R; 2],
    /// Position, world space.
    pub position: [R; 3],
    /// Unit geometric normal, world space, on either side.
    pub normal: [R; 3],
    /// Approximate radius of the pixel's footprint in u and v; 0 is a point.
    pub footprint: R,
    /// Change of u and v to each of the two neighbouring samples; 0 is a point.
    pub uv_steps: [[R; 2]; 2],
    /// Change of the position to each of the two neighbouring samples, world space; 0 is a point.
    /// It is set only in scenes with a [`SolidTexture`].
    pub position_steps: [[R; 3]; 2],
    /// Colour of the mesh's vertices, linear RGB and opacity; `None` is opaque white. It is set only
    /// for materials with [`Texture::VertexColour`] and for alpha.
    pub vertex_colour: Option<[R; 4]>,
}

/// A colour (linear RGB) or a scalar for every point of a surface.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum Texture {
    /// A constant.
    Constant([f32; 3]),
    /// A constant of a known spectrum. `SceneBuilder::build` replaces it by its RGB in the materials that
    /// are shaded.
    Spectrum(Arc<Colour>),
    /// An image.
    Image(Arc<ImageTexture>),
    /// The colour of the vertices of a mesh; white without one.
    VertexColour,
    /// The opacity of the vertices of a mesh; 1 without one.
    VertexOpacity,
    /// The scalar of a texture as a grey colour.
    Scalar(Arc<Texture>),
    /// Two textures that alternate.
    Checkerboard {
        /// Pattern that selects one.
        pattern: Arc<CheckerPattern>,
        /// First and second texture.
        textures: [Arc<Texture>; 2],
    },
    /// Dots of a texture on another one.
    Dots {
        /// Pattern that selects one.
        pattern: Arc<DotPattern>,
        /// Textures outside and inside the dots.
        textures: [Arc<Texture>; 2],
    },
    /// A pattern of noise that fills space.
    Solid(Arc<SolidTexture>),
    /// The product of two textures.
    Scale(Arc<Texture>, Arc<Texture>),
    /// A linear blend of two textures.
    Mix {
        /// Weight of the second texture, a scalar.
        amount: Arc<Texture>,
        /// First and second texture.
        textures: [Arc<Texture>; 2],
    },
    /// A blend of two textures, whose second weight is 1 - |cos| of the angle between the normal
    /// and a direction.
    DirectionMix {
        /// Unit vector, world space.
        direction: Vec3,
        /// First and second texture.
        textures: [Arc<Texture>; 2],
    },
    /// A texture whose colours are RGB, in the channels that paths carry.
    Uplifted {
        /// Texture.
        texture: Arc<Texture>,
        /// Matrix from linear RGB.
        matrix: Arc<[[f32; 3]; 3]>,
    },
    /// Bilinear interpolation and extrapolation of four colours.
    Bilerp {
        /// Mapping to (s, t).
        mapping: Arc<Mapping>,
        /// Colours at (s, t) = (0, 0), (1, 0), (0, 1) and (1, 1).
        corners: [[f32; 3]; 4],
    },
}

impl From<Colour> for Texture {
    fn from(colour: Colour) -> Self {
        match colour.has_spectrum() {
            false => Self::Constant(colour.rgb),
            true => Self::Spectrum(Arc::new(colour)),
        }
    }
}

impl Texture {
    /// Returns the number of textures in the expression: an upper bound on the lookups of one
    /// value.
    pub fn node_count(&self) -> usize {
        1 + self.operands().map(Self::node_count).sum::<usize>()
    }

    /// Returns the linear RGB of a constant.
    pub fn constant(&self) -> Option<[f32; 3]> {
        match self {
            Self::Constant(colour) => Some(*colour),
            Self::Spectrum(colour) => Some(colour.rgb),
            _ => None,
        }
    }

    /// Returns the colour of a constant, with its spectrum if that is known.
    pub fn constant_colour(&self) -> Option<Colour> {
        match self {
            Self::Spectrum(colour) => Some(Colour::clone(colour)),
            other => other.constant().map(Colour::from),
        }
    }

    /// Returns the expression with other leaves: constants, images, colours of vertices, corners and
    /// patterns of noise. Scalars stay as they are.
    pub(super) fn with_leaves(&self, leaf: &mut dyn FnMut(&Self) -> Self) -> Self {
        let mut pair = |textures: &[Arc<Self>; 2]| {
            textures.each_ref().map(|texture| Arc::new(texture.with_leaves(leaf)))
        };
        match self {
            Self::Constant(_)
            | Self::Spectrum(_)
            | Self::Image(_)
            | Self::VertexColour
            | Self::Bilerp { .. }
            | Self::Solid(_) => leaf(self),
            Self::VertexOpacity | Self::Scalar(_) | Self::Uplifted { .. } => self.clone(),
            Self::Checkerboard { pattern, textures } => {
                Self::Checkerboard { pattern: pattern.clone(), textures: pair(textures) }
            }
            Self::Dots { pattern, textures } => {
                Self::Dots { pattern: pattern.clone(), textures: pair(textures) }
            }
            Self::Scale(one, other) => {
                let [one, other] = pair(&[one.clone(), other.clone()]);
                Self::Scale(one, other)
            }
            Self::Mix { amount, textures } => {
                Self::Mix { amount: amount.clone(), textures: pair(textures) }
            }
            Self::DirectionMix { direction, textures } => {
                Self::DirectionMix { direction: *direction, textures: pair(textures) }
            }
        }
    }

    /// Returns whether the texture is averaged over the footprint.
    pub fn is_filtered(&self) -> bool {
        matches!(self, Self::Image(_) | Self::Checkerboard { .. } | Self::Solid(_))
            || self.operands().any(Self::is_filtered)
    }

    /// Returns whether the expression has a [`SolidTexture`].
    pub fn is_solid(&self) -> bool {
        matches!(self, Self::Solid(_)) || self.operands().any(Self::is_solid)
    }

    /// Returns whether the expression has colours of vertices.
    pub fn has_vertex_colours(&self) -> bool {
        matches!(self, Self::VertexColour | Self::VertexOpacity)
            || self.operands().any(Self::has_vertex_colours)
    }

    /// Returns the textures that the texture combines.
    fn operands(&self) -> impl Iterator<Item = &Texture> {
        let operands = match self {
            Self::Constant(_)
            | Self::Spectrum(_)
            | Self::Image(_)
            | Self::VertexColour
            | Self::VertexOpacity
            | Self::Bilerp { .. }
            | Self::Solid(_) => [None; 3],
            Self::Scalar(texture) | Self::Uplifted { texture, .. } => [Some(texture), None, None],
            Self::Scale(one, other)
            | Self::Checkerboard { textures: [one, other], .. }
            | Self::Dots { textures: [one, other], .. }
            | Self::DirectionMix { textures: [one, other], .. } => [Some(one), Some(other), None],
            Self::Mix { amount, textures: [one, other] } => [Some(amount), Some(one), Some(other)],
        };
        operands.into_iter().flatten().map(|texture| &**texture)
    }

    /// Returns the scalar at a point. For an image, it is the alpha if there is one, otherwise the
    /// mean of the channels, as in pbrt-v4.
    pub fn scalar<R: Real<Scalar = f32>>(&self, at: &TexturePoint<R>) -> R {
        self.value(at)
    }

    /// Returns the colour at a point, linear RGB.
    pub fn colour<R: Real<Scalar = f32>>(&self, at: &TexturePoint<R>) -> [R; 3] {
        self.value(at)
    }

    fn value<R: Real<Scalar = f32>, V: Value<R>>(&self, at: &TexturePoint<R>) -> V {
        match self {
            Self::Constant(colour) => V::constant(*colour),
            Self::Spectrum(colour) => V::constant(colour.rgb),
            Self::Image(image) => V::image(image, at),
            Self::VertexColour => match at.vertex_colour {
                Some([r, g, b, _]) => V::colour([r, g, b]),
                None => V::constant([1.0; 3]),
            },
            Self::VertexOpacity => match at.vertex_colour {
                Some([.., opacity]) => V::scalar(opacity),
                None => V::constant([1.0; 3]),
            },
            Self::Scalar(texture) => V::scalar(texture.scalar(at)),
            Self::Uplifted { texture, matrix } => texture.value::<R, V>(at).transformed(matrix),
            Self::Checkerboard { pattern, textures } => {
                blend(textures, pattern.second_weight(at), at)
            }
            Self::Dots { pattern, textures } => blend(textures, pattern.inside(at), at),
            Self::Solid(solid) => solid.value(at),
            Self::Scale(one, other) => one.value::<R, V>(at).product(other.value(at)),
            Self::Mix { amount, textures } => blend(textures, amount.scalar(at), at),
            Self::DirectionMix { direction, textures } => {
                let cos = dot(at.normal, splat(direction.to_array())).abs();
                blend(textures, R::splat(1.0) - cos, at)
            }
            Self::Bilerp { mapping, corners } => {
                let ([x, y], _) = mapping.at(at);
                let one = R::splat(1.0);
                let weights = [(one - x) * (one - y), x * (one - y), (one - x) * y, x * y];
                let mut colour = [R::splat(0.0); 3];
                for channel in 0..3 {
                    for corner in 0..4 {
                        colour[channel] =
                            colour[channel] + weights[corner] * R::splat(corners[corner][channel]);
                    }
                }
                V::colour(colour)
            }
        }
    }
}

/// Returns the blend of two textures. `weight` is that of the second; a texture whose weight is 0
/// in all lanes is not evaluated.
fn blend<R: Real<Scalar = f32>, V: Value<R>>(
    textures: &[Arc<Texture>; 2],
    weight: R,
    at: &TexturePoint<R>,
) -> V {
    let all = (1 << R::LANES) - 1;
    if R::bits(weight.equals(R::splat(0.0))) == all {
        return textures[0].value(at);
    }
    if R::bits(weight.equals(R::splat(1.0))) == all {
        return textures[1].value(at);
    }
    let (one, other): (V, V) = (textures[0].value(at), textures[1].value(at));
    one.blend(other, weight)
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
    fn the_amount_of_a_mix_is_the_weight_of_the_second_texture() {
        let amount = Arc::new(Texture::Constant([0.25; 3]));
        let mix = Texture::Mix { amount, textures: pair() };
        assert_near(mix.colour(&TexturePoint::<f32>::default()), [0.6, 0.15, 0.15]);
        assert!((mix.scalar(&TexturePoint::<f32>::default()) - 0.3).abs() < 1e-6);
        assert_eq!(mix.node_count(), 4);
    }

    #[test]
    fn a_direction_mix_is_the_first_texture_for_a_surface_that_faces_the_direction() {
        let mix = Texture::DirectionMix { direction: Vec3::Y, textures: pair() };
        let facing = |normal: Vec3| {
            mix.colour(&TexturePoint { normal: normal.into(), ..TexturePoint::default() })
        };
        assert_near(facing(Vec3::Y), RED);
        assert_near(facing(Vec3::NEG_Y), RED);
        assert_near(facing(Vec3::X), BLUE);
        assert_near(facing(Vec3::new(0.0, 0.5, 0.75f32.sqrt())), [0.4, 0.2, 0.3]);
    }

    #[test]
    fn bilerp_interpolates_four_corners() {
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 1.0]];
        let texture = Texture::Bilerp { mapping: Arc::default(), corners };
        let at = |u: f32, v: f32| {
            texture.colour(&TexturePoint { uv: [u, v], ..TexturePoint::default() })
        };
        assert_near(at(1.0, 0.0), [1.0, 0.0, 0.0]);
        assert_near(at(0.25, 0.5), [0.25, 0.5, 0.125]);
    }

    #[test]
    fn products_are_by_channel_and_scalars_are_grey() {
        let [red, blue] = pair();
        let product = Texture::Scale(red, Arc::new(Texture::Scalar(blue)));
        assert_near(product.colour(&TexturePoint::<f32>::default()), [0.24, 0.03, 0.0]);
    }
}
