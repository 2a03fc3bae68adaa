//! Material of hairs and fur.

use super::texture::Texture;

/// Properties of hairs (Chiang, Bitterli, Tappan & Burley 2016), defined as in pbrt-v4.
#[derive(Clone, Debug)]
pub struct HairFibre {
    /// Colour.
    pub colour: HairColour,
    /// Refractive index.
    pub eta: Texture,
    /// Longitudinal roughness, 0 to 1.
    pub beta_m: Texture,
    /// Azimuthal roughness, 0 to 1.
    pub beta_n: Texture,
    /// Angle of the scales (degrees).
    pub alpha: Texture,
}

/// Colour of hairs.
#[derive(Clone, Debug)]
pub enum HairColour {
    /// Absorption inside [per radius].
    Absorption(Texture),
    /// Reflectance of many hairs.
    Reflectance(Texture),
    /// Concentrations of pigments.
    Melanin {
        /// Concentration of the brown pigment.
        eumelanin: Texture,
        /// Concentration of the red pigment.
        pheomelanin: Texture,
        /// Absorption of both pigments at concentration 1 [per radius].
        absorption: [[f32; 3]; 2],
    },
}

impl HairColour {
    /// The colour of these concentrations of pigments (d'Eon et al. 2011, "An energy-conserving hair
    /// reflectance model").
    pub fn melanin(eumelanin: Texture, pheomelanin: Texture) -> Self {
        let absorption = [[0.419, 0.697, 1.37], [0.187, 0.4, 1.05]];
        Self::Melanin { eumelanin, pheomelanin, absorption }
    }
}

impl HairFibre {
    /// Returns all textures.
    pub(super) fn textures(&self) -> Vec<&Texture> {
        let Self { colour, eta, beta_m, beta_n, alpha } = self;
        let mut all = vec![eta, beta_m, beta_n, alpha];
        match colour {
            HairColour::Absorption(texture) | HairColour::Reflectance(texture) => all.push(texture),
            HairColour::Melanin { eumelanin, pheomelanin, .. } => {
                all.extend([eumelanin, pheomelanin]);
            }
        }
        all
    }
}
