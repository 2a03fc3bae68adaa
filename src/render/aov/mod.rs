//! AOV layers: per-pixel outputs besides colour (arbitrary output variables).
//!
//! A layer costs time only if it is requested.

mod circle_of_confusion;
mod convert;
mod coverage;
mod cryptomatte;
mod dual_pixel;
mod feature_film;
mod features;
mod motion_vectors;
mod vignetting;

pub use circle_of_confusion::CircleOfConfusion;
pub use convert::{convert_colours, to_camera};
pub(crate) use dual_pixel::{HALVES, half_layers};
pub use feature_film::FeatureFilm;
pub(crate) use feature_film::FeatureSums;
pub use features::TileFeatures;
pub use motion_vectors::MotionVectors;
pub use vignetting::vignetting;

use std::str::FromStr;
use std::sync::Arc;

use crate::film::{FilmSums, Frame};
use crate::timing::Timing;
use petzval_image::ImageLayer;
use petzval_lens::{Camera, LensModel};
use petzval_scene::Scene;

/// A layer that can be requested.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Aov {
    /// `depth.Z`: the mean depth of the surfaces that a pixel sees, along the axis from the
    /// camera's origin, in scene units; `depth.coverage`: the share of its light paths that meet a
    /// surface.
    Depth,
    /// Mean position of these surfaces, world space.
    Position,
    /// Mean of their unit shading normals, world space.
    Normal,
    /// Mean of their albedo: the share of light that they reflect or transmit.
    Albedo,
    /// `object.shape` and `object.instance`: indices, in the order of the scene file, of what the
    /// first path of the pixel meets; -1 for none.
    Object,
    /// Index of the material that the first path of the pixel meets; -1 for none.
    Material,
    /// Variance of the pixel's value, by channel: the square of its standard error.
    Variance,
    /// `samples.taken` and `samples.passed`: the number of samples of the pixel, and of those that
    /// passed the lens.
    Samples,
    /// Mean diameter on the film of the circle of confusion of all that a pixel sees, to first order
    /// (um): of surfaces, of points in media that scatter, and of infinity.
    Coc,
    /// The share of the light that each surface of the lens blocks.
    Vignetting,
    /// The share of a pixel's background that surfaces and media cover: 1 minus the light that reaches
    /// the pixel from beyond the scene, over that without a scene. Where no path passes the lens, it
    /// is 1. A picture with this layer has no light of a sky that the camera sees directly, so that
    /// its colours are premultiplied by it.
    Alpha,
    /// `left` and `right`: the pictures of the light that passes the left and the right half of the exit
    /// pupil, as seen from behind the camera. Together they are the picture.
    DualPixel,
    /// Cryptomatte: names of the objects, materials and assets that a pixel sees, as hashes, and the share of the
    /// pixel's light paths that meet each.
    Cryptomatte,
    /// Mean displacement across the picture of the surfaces that a pixel sees while it is exposed, by their motion and that of
    /// the camera (pixels, x to the right and y down); of the sky where it sees no surface.
    Motion,
}

impl FromStr for Aov {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|aov| aov.name() == name).ok_or_else(|| {
            let known = Self::ALL.map(Self::name).join(", ");
            format!("no layer \"{name}\"; expected one of {known}")
        })
    }
}

impl Aov {
    /// All layers.
    pub const ALL: [Self; 14] = [
        Self::Depth,
        Self::Position,
        Self::Normal,
        Self::Albedo,
        Self::Object,
        Self::Material,
        Self::Variance,
        Self::Samples,
        Self::Coc,
        Self::Vignetting,
        Self::Alpha,
        Self::DualPixel,
        Self::Cryptomatte,
        Self::Motion,
    ];

    /// Returns a description in one line.
    pub fn description(self) -> &'static str {
        match self {
            Self::Depth => "Depth of the surfaces, and the share of the pixel that they cover",
            Self::Position => "Position of the surfaces, world space",
            Self::Normal => "Shading normals of the surfaces, world space",
            Self::Albedo => "Share of light that the surfaces reflect or transmit",
            Self::Object => "Index of the shape, and of its instance",
            Self::Material => "Index of the material",
            Self::Variance => "Square of the pixel's standard error",
            Self::Samples => "Number of samples taken, and of those that passed the lens",
            Self::Coc => "Diameter of the circle of confusion, um",
            Self::Vignetting => "Share of the light that each surface of the lens blocks",
            Self::DualPixel => "Pictures of both halves of the pupil, left and right",
            Self::Cryptomatte => "Mattes by object, material and asset, for compositors",
            Self::Motion => "Motion across the picture during the exposure, pixels",
            Self::Alpha => "Opacity for compositing, also in PNG; the sky behind is left out",
        }
    }

    /// Returns the layer's name, as `--aov` takes it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Depth => "depth",
            Self::Position => "position",
            Self::Normal => "normal",
            Self::Albedo => "albedo",
            Self::Object => "object",
            Self::Material => "material",
            Self::Variance => "variance",
            Self::Samples => "samples",
            Self::Coc => "coc",
            Self::Vignetting => "vignetting",
            Self::Alpha => "alpha",
            Self::DualPixel => "dual_pixel",
            Self::Cryptomatte => "cryptomatte",
            Self::Motion => "motion",
        }
    }

    /// Returns whether the layer requires a real lens.
    pub fn needs_lens(self) -> bool {
        matches!(self, Self::Coc | Self::Vignetting | Self::DualPixel)
    }
}

/// Layers of a picture, and the parts of its job that they depend on.
#[derive(Clone, Copy, Debug)]
pub struct LayerRequest<'a> {
    /// The layers to compute.
    pub layers: &'a [Aov],
    /// The scene.
    pub scene: &'a Scene,
    /// The camera.
    pub camera: &'a Camera,
    /// The pixels of the picture.
    pub frame: &'a Frame,
    /// The times of the samples, if anything moves.
    pub timing: Option<&'a Timing>,
    /// The motion of all points, if a layer needs it.
    pub motion_vectors: Option<&'a Arc<MotionVectors>>,
}

/// Returns the largest possible number of channels of all requested layers.
pub fn channels(request: &LayerRequest<'_>) -> usize {
    let channels = |aov: &Aov| match (aov, &request.camera.model) {
        (Aov::Depth | Aov::Object | Aov::Samples | Aov::Motion, _) => 2,
        (Aov::Position | Aov::Normal | Aov::Albedo | Aov::Variance, _) => 3,
        (Aov::DualPixel, _) => 6,
        (Aov::Cryptomatte, _) => cryptomatte::KINDS * cryptomatte::CHANNELS,
        (Aov::Vignetting, LensModel::Real(lens)) => lens.prescription.rows.len() + 1,
        (Aov::Material | Aov::Coc | Aov::Vignetting | Aov::Alpha, _) => 1,
    };
    request.layers.iter().map(channels).sum()
}

/// Returns the requested layers of a finished render, without those of a dual pixel, which are read out with the
/// picture.
pub fn layers(
    request: &LayerRequest<'_>,
    samples: u32,
    film: &FilmSums,
    features: Option<&FeatureFilm>,
) -> Vec<ImageLayer> {
    let layers = |aov: &Aov| match (aov, &request.camera.model) {
        (Aov::Vignetting, LensModel::Real(lens)) => {
            vec![vignetting(lens, request.camera.film, request.frame)]
        }
        (Aov::Variance, _) => {
            let variance = film.variance(samples);
            variance.iter().map(|variance| colour_layer("variance", variance)).collect()
        }
        (Aov::Cryptomatte, _) => {
            features.map(|film| film.mattes(request.scene)).unwrap_or_default()
        }
        (aov, _) => features.and_then(|film| film.layer(*aov)).into_iter().collect(),
    };
    request.layers.iter().flat_map(layers).collect()
}

/// Returns a layer of red, green and blue, with a value for each pixel.
fn colour_layer(name: &str, pixels: &[[f32; 3]]) -> ImageLayer {
    let channel = |c: usize| pixels.iter().map(|pixel| pixel[c]).collect();
    let channels = ["R", "G", "B"].into_iter().enumerate();
    ImageLayer::new(name, channels.map(|(c, name)| (name.to_owned(), channel(c))).collect())
}
