//! Materials as scene files describe them: a scattering model with textures as parameters.
//!
//! The shading stage evaluates the textures at a point and makes a BSDF of the model.
//! [`MaterialModel`] is the list of all models.

use std::sync::Arc;

use super::Dispersion;
use super::hair::HairFibre;
use super::measured::MeasuredSurface;
use super::medium::Subsurface;
use super::texture::{ImageMap, Texture};

/// Scattering model of a surface, and changes of its shading normal.
#[derive(Clone, Debug)]
pub struct Material {
    /// Scattering model.
    pub model: MaterialModel,
    /// Height above the surface [world units], whose slopes tilt the shading normal.
    pub bump: Option<Texture>,
    /// Normals in the frame (u, v, normal); a colour c stands for the vector 2 c - 1.
    pub normal_map: Option<ImageMap>,
    /// The channel that alone goes on, three times as strong, because the material refracts all others
    /// into other directions. Each of the three is as probable.
    pub only_channel: Option<usize>,
    /// Matrix of the colours of a measured surface, if paths carry other channels than RGB.
    pub measured_uplift: Option<[[f32; 3]; 3]>,
}

/// Scattering models, named and defined as in pbrt-v4 unless they say otherwise.
#[derive(Clone, Debug)]
pub enum MaterialModel {
    /// No scattering: light passes straight through.
    Interface,
    /// Lambert's reflection.
    Diffuse {
        /// Fraction of the light that is reflected.
        reflectance: Texture,
    },
    /// Lambert's reflection and transmission.
    DiffuseTransmission {
        /// Fraction of the light that is reflected.
        reflectance: Texture,
        /// Fraction of the light that is transmitted.
        transmittance: Texture,
        /// Factor of both fractions.
        scale: f32,
    },
    /// A dielectric interface over a medium in which light scatters.
    Subsurface {
        /// The medium.
        interior: Subsurface,
        /// Roughness of the interface.
        roughness: Roughness,
    },
    /// A metal.
    Conductor {
        /// Refractive index.
        metal: Metal,
        /// Roughness.
        roughness: Roughness,
    },
    /// The interface of a transparent medium, such as glass or water.
    Dielectric {
        /// Refractive index inside over that outside, at the d line.
        eta: f32,
        /// The same by wavelength; `None` if it is constant.
        dispersion: Dispersion,
        /// Roughness.
        roughness: Roughness,
    },
    /// The interface of a transparent medium that tints the light that passes through it, as in
    /// glTF.
    TintedDielectric {
        /// Refractive index inside over that outside.
        eta: f32,
        /// Roughness.
        roughness: Roughness,
        /// Fraction of the transmitted light that is kept.
        tint: Texture,
    },
    /// A sheet of glass of zero thickness.
    ThinDielectric {
        /// Refractive index, by colour channel.
        eta: [f32; 3],
        /// The same by wavelength; `None` if it is constant.
        dispersion: Dispersion,
        /// Fraction of the transmitted light that is kept.
        tint: Texture,
    },
    /// A diffuse surface under a coat.
    CoatedDiffuse {
        /// Fraction of the light that the surface under the coat reflects.
        reflectance: Texture,
        /// Coat.
        coat: Box<DielectricCoat>,
    },
    /// A metal under a coat.
    CoatedConductor {
        /// Refractive index of the metal.
        metal: Metal,
        /// Roughness of the metal.
        roughness: Roughness,
        /// Coat.
        coat: Box<DielectricCoat>,
    },
    /// A metal, a plastic or a blend of both, as glTF defines it.
    MetallicRoughness(Box<MetallicRoughnessSurface>),
    /// A measured surface.
    Measured(Arc<MeasuredSurface>),
    /// A hair or fur.
    Hair(Box<HairFibre>),
    /// One of two materials, chosen at random at every point.
    Mix {
        /// Indices of the materials.
        materials: [u32; 2],
        /// Probability of the second material.
        amount: Texture,
    },
}

/// Complex refractive index of a metal, by colour channel.
#[derive(Clone, Debug)]
pub enum Metal {
    /// The index eta + i k.
    Index {
        /// Real part.
        eta: Texture,
        /// Imaginary part.
        k: Texture,
        /// Factor of the Fresnel reflectance at normal incidence; above 1 if a metal's colour is
        /// more saturated than the primaries; a constant.
        tint: Texture,
    },
    /// The index 1 + i k that reflects this fraction of the light at normal incidence.
    Reflectance(Texture),
}

/// Roughness from which on a surface is never shaded as perfectly smooth.
const SMOOTHEST: f32 = 0.01;

/// Roughness of a microfacet surface along u and v (Trowbridge & Reitz 1975, "GGX").
#[derive(Clone, Debug)]
pub struct Roughness {
    /// Roughness along u and v; only the first channel counts.
    pub uv: [Texture; 2],
    /// Whether the microfacet alpha is the square root of the roughness instead of the roughness.
    pub remap: bool,
}

/// A metal, a plastic or a blend of both, below a clear coat of index 1.5 (glTF 2.0, section 3.9.2,
/// and KHR_materials_clearcoat). Roughness is the same along u and v.
#[derive(Clone, Debug)]
pub struct MetallicRoughnessSurface {
    /// Reflectance of a metal at normal incidence, and that of the base of a plastic.
    pub base_colour: Texture,
    /// Share of metal.
    pub metallic: Texture,
    /// Roughness.
    pub roughness: Roughness,
    /// Refractive index of the plastic.
    pub eta: f32,
    /// Strength of the reflection of the plastic (KHR_materials_specular), 1 for a real one.
    pub specular: Texture,
    /// Colour of that reflection at normal incidence.
    pub specular_colour: Texture,
    /// Share of the surface that the coat covers.
    pub coat_coverage: Texture,
    /// Roughness of the coat.
    pub coat_roughness: Roughness,
}

/// A clear or hazy dielectric layer over a surface, evaluated by random walks (Guo, Hasan & Zhao
/// 2018).
#[derive(Clone, Debug)]
pub struct DielectricCoat {
    /// Refractive index of the layer over that outside, at the d line.
    pub eta: f32,
    /// The same by wavelength; `None` if it is constant.
    pub dispersion: Dispersion,
    /// Roughness of the outer interface.
    pub roughness: Roughness,
    /// Thickness [mean free paths of a medium of density 1].
    pub thickness: Texture,
    /// Single-scattering albedo of the medium in the layer; 0 is a clear layer.
    pub albedo: Texture,
    /// Asymmetry of the phase function (Henyey & Greenstein 1941).
    pub g: Texture,
    /// Most events of a random walk inside the layer.
    pub max_depth: u32,
    /// Random walks of each evaluation.
    pub samples: u32,
}

impl Material {
    /// Returns a material with unchanged normals.
    pub fn new(scatters: MaterialModel) -> Self {
        Self {
            model: scatters,
            bump: None,
            normal_map: None,
            only_channel: None,
            measured_uplift: None,
        }
    }

    /// Returns whether a texture of the material is filtered over the footprint of a pixel.
    pub fn is_textured(&self) -> bool {
        self.bump.is_some()
            || self.model.textures().into_iter().any(|texture| texture.is_filtered())
    }

    /// Returns whether a texture of the material is solid.
    pub fn has_solid_texture(&self) -> bool {
        self.model.textures().into_iter().chain(&self.bump).any(|texture| texture.is_solid())
    }

    /// Returns whether a texture of the material has the colours of vertices.
    pub fn has_vertex_colours(&self) -> bool {
        self.model.textures().into_iter().any(Texture::has_vertex_colours)
    }

    /// Returns whether the material needs texture coordinates and surface derivatives.
    pub fn needs_derivatives(&self) -> bool {
        let constant = |texture: &&Texture| texture.constant().is_some();
        self.bump.is_some()
            || self.normal_map.is_some()
            || self.is_anisotropic()
            || matches!(self.model, MaterialModel::Hair(_))
            || !self.model.textures().iter().all(constant)
    }

    /// Returns whether the direction of the shading frame matters: to bump maps, normal maps or
    /// scattering.
    #[inline]
    pub fn needs_shading_tangent(&self) -> bool {
        self.bump.is_some() || self.normal_map.is_some() || self.is_anisotropic()
    }

    /// Returns whether scattering depends on the direction of u and v, so that the shading frame
    /// must follow the texture coordinates.
    #[inline]
    pub fn is_anisotropic(&self) -> bool {
        matches!(self.model, MaterialModel::Measured(_) | MaterialModel::Hair(_))
            || self.model.roughnesses().into_iter().flatten().any(Roughness::is_anisotropic)
    }

    /// Returns a Lambertian surface of one colour.
    pub fn diffuse(reflectance: [f32; 3]) -> Self {
        Self::new(MaterialModel::Diffuse { reflectance: Texture::Constant(reflectance) })
    }
}

impl MaterialModel {
    /// Returns whether the surface may reflect or refract a ray into one direction; `false` for a
    /// mixture, which its materials decide.
    #[inline]
    pub fn may_be_specular(&self) -> bool {
        match self {
            Self::ThinDielectric { .. } => true,
            // Light leaves from below the surface.
            Self::Subsurface { .. } => false,
            _ => self.roughnesses().into_iter().flatten().any(Roughness::may_be_smooth),
        }
    }

    /// Returns the number of textures in all expressions of the model.
    pub(super) fn texture_nodes(&self) -> usize {
        self.textures().into_iter().map(Texture::node_count).sum()
    }

    /// Returns all textures of the model.
    fn textures(&self) -> Vec<&Texture> {
        let own = match self {
            Self::Interface
            | Self::Measured(_)
            | Self::Dielectric { .. }
            | Self::Subsurface { .. } => Vec::new(),
            Self::ThinDielectric { tint, .. } | Self::TintedDielectric { tint, .. } => vec![tint],
            Self::Diffuse { reflectance } => vec![reflectance],
            Self::DiffuseTransmission { reflectance, transmittance, .. } => {
                vec![reflectance, transmittance]
            }
            Self::Conductor { metal, .. } => metal.textures(),
            Self::CoatedDiffuse { reflectance, coat } => {
                coat.textures().into_iter().chain([reflectance]).collect()
            }
            Self::CoatedConductor { metal, coat, .. } => {
                coat.textures().into_iter().chain(metal.textures()).collect()
            }
            Self::MetallicRoughness(surface) => {
                let MetallicRoughnessSurface { base_colour, metallic, coat_coverage, .. } =
                    &**surface;
                let MetallicRoughnessSurface { specular, specular_colour, .. } = &**surface;
                vec![base_colour, metallic, coat_coverage, specular, specular_colour]
            }
            Self::Hair(fibre) => fibre.textures(),
            Self::Mix { amount, .. } => vec![amount],
        };
        let roughnesses = self.roughnesses().into_iter().flatten();
        own.into_iter().chain(roughnesses.flat_map(|roughness| &roughness.uv)).collect()
    }

    /// Returns the roughness of every rough interface of the model: two at most.
    fn roughnesses(&self) -> [Option<&Roughness>; 2] {
        match self {
            Self::Interface
            | Self::Diffuse { .. }
            | Self::DiffuseTransmission { .. }
            | Self::Measured(_)
            | Self::ThinDielectric { .. }
            | Self::Hair(_)
            | Self::Mix { .. } => [None, None],
            Self::Conductor { roughness, .. }
            | Self::Dielectric { roughness, .. }
            | Self::TintedDielectric { roughness, .. }
            | Self::Subsurface { roughness, .. } => [Some(roughness), None],
            Self::MetallicRoughness(surface) => {
                [Some(&surface.roughness), Some(&surface.coat_roughness)]
            }
            Self::CoatedDiffuse { coat, .. } => [Some(&coat.roughness), None],
            Self::CoatedConductor { roughness, coat, .. } => {
                [Some(roughness), Some(&coat.roughness)]
            }
        }
    }
}

impl Metal {
    fn textures(&self) -> Vec<&Texture> {
        match self {
            Self::Index { eta, k, .. } => vec![eta, k],
            Self::Reflectance(reflectance) => vec![reflectance],
        }
    }
}

impl DielectricCoat {
    /// Returns the textures of the medium in the layer.
    fn textures(&self) -> [&Texture; 3] {
        [&self.thickness, &self.albedo, &self.g]
    }
}

impl Roughness {
    /// Returns whether the surface may be perfectly smooth somewhere.
    fn may_be_smooth(&self) -> bool {
        self.uv.iter().all(|texture| match texture {
            Texture::Constant([roughness, ..]) => *roughness < SMOOTHEST,
            _ => true,
        })
    }

    /// Returns the roughness of a perfectly smooth surface.
    pub fn smooth() -> Self {
        Self { uv: [Texture::Constant([0.0; 3]), Texture::Constant([0.0; 3])], remap: true }
    }

    /// Returns whether the roughness along u and v may differ.
    fn is_anisotropic(&self) -> bool {
        let [along, across] = &self.uv;
        !matches!((along, across), (Texture::Constant(a), Texture::Constant(b)) if a == b)
    }
}
