//! Colours of materials: replaces those of a model, for other channels than RGB.

use super::hair::{HairColour, HairFibre};
use super::{MaterialModel, Metal, Texture};

/// Quantity that a colour of a material describes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Quantity {
    /// A fraction of light.
    Reflectance,
    /// A number without an upper limit, such as a refractive index.
    Unbounded,
}

impl MaterialModel {
    /// Returns the model with other textures of colours. `map` gets what each colour describes.
    pub(super) fn with_colours(&self, map: &mut dyn FnMut(&Texture, Quantity) -> Texture) -> Self {
        let mut share = |texture: &Texture| map(texture, Quantity::Reflectance);
        let mut model = self.clone();
        match &mut model {
            Self::Interface
            | Self::Measured(_)
            | Self::Dielectric { .. }
            | Self::Subsurface { .. }
            | Self::Mix { .. } => (),
            Self::ThinDielectric { tint, .. } | Self::TintedDielectric { tint, .. } => {
                *tint = share(tint);
            }
            Self::Diffuse { reflectance } => *reflectance = share(reflectance),
            Self::DiffuseTransmission { reflectance, transmittance, .. } => {
                (*reflectance, *transmittance) = (share(reflectance), share(transmittance));
            }
            Self::Conductor { metal, .. } => metal.map_colours(map),
            Self::CoatedDiffuse { reflectance, coat } => {
                (*reflectance, coat.albedo) = (share(reflectance), share(&coat.albedo));
            }
            Self::CoatedConductor { metal, coat, .. } => {
                coat.albedo = share(&coat.albedo);
                metal.map_colours(map);
            }
            Self::MetallicRoughness(surface) => {
                surface.base_colour = share(&surface.base_colour);
                surface.specular_colour = share(&surface.specular_colour);
            }
            Self::Hair(fibre) => fibre.map_colours(map),
        }
        model
    }
}

impl Metal {
    fn map_colours(&mut self, map: &mut dyn FnMut(&Texture, Quantity) -> Texture) {
        match self {
            Self::Index { eta, k, tint } => {
                for texture in [eta, k, tint] {
                    *texture = map(texture, Quantity::Unbounded);
                }
            }
            Self::Reflectance(colour) => *colour = map(colour, Quantity::Reflectance),
        }
    }
}

impl HairFibre {
    fn map_colours(&mut self, map: &mut dyn FnMut(&Texture, Quantity) -> Texture) {
        match &mut self.colour {
            HairColour::Absorption(texture) => *texture = map(texture, Quantity::Unbounded),
            HairColour::Reflectance(texture) => *texture = map(texture, Quantity::Reflectance),
            HairColour::Melanin { absorption, .. } => {
                for pigment in absorption {
                    let other = map(&Texture::Constant(*pigment), Quantity::Unbounded);
                    *pigment = other.constant().unwrap_or(*pigment);
                }
            }
        }
    }
}
