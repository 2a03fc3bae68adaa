//! What surfaces are made of, as the scene file says it: textures still to be looked up. The
//! shading stage turns a material and a point into a scattering function.

use super::texture::{ImageMap, Texture};

/// What a surface does to light, and how its normals are bent.
#[derive(Clone, Debug)]
pub struct Material {
    /// How it scatters.
    pub scatters: Scatters,
    /// A height over the surface, world units, whose slopes bend the shading normal.
    pub bump: Option<Texture>,
    /// An image of normals about (u, v, normal), stored as 2 c - 1.
    pub normal_map: Option<ImageMap>,
}

/// The kinds of surfaces, named and defined as in pbrt-v4.
#[derive(Clone, Debug)]
pub enum Scatters {
    /// Nothing: light goes straight on.
    Interface,
    /// Lambert's reflection.
    Diffuse {
        /// Share of the light that comes back.
        reflectance: Texture,
    },
    /// Lambert's reflection and transmission.
    DiffuseTransmission {
        /// Share of the light that comes back.
        reflectance: Texture,
        /// Share of the light that goes through.
        transmittance: Texture,
        /// Factor of both.
        scale: f32,
    },
    /// A metal.
    Conductor {
        /// Its refractive index.
        metal: Metal,
        /// Its smoothness.
        roughness: Roughness,
    },
    /// The border of glass, water and the like.
    Dielectric {
        /// Refractive index inside over outside.
        eta: f32,
        /// Its smoothness.
        roughness: Roughness,
    },
    /// A sheet of glass without thickness.
    ThinDielectric {
        /// Refractive index.
        eta: f32,
    },
    /// A varnished diffuse surface.
    CoatedDiffuse {
        /// Share of the light that comes back from under the coat.
        reflectance: Texture,
        /// The varnish.
        coat: Box<Coat>,
    },
    /// A varnished metal.
    CoatedConductor {
        /// Its refractive index.
        metal: Metal,
        /// The smoothness of the metal.
        roughness: Roughness,
        /// The varnish.
        coat: Box<Coat>,
    },
    /// One of two materials, by chance at every point.
    Mix {
        /// Which.
        materials: [u32; 2],
        /// Probability of the second.
        amount: Texture,
    },
}

/// The complex refractive index of a metal by colour channel.
#[derive(Clone, Debug)]
pub enum Metal {
    /// eta + i k.
    Index {
        /// Real part.
        eta: Texture,
        /// Imaginary part.
        k: Texture,
        /// What Fresnel's reflectance is multiplied by at normal incidence; above 1 where a
        /// metal's colour is more saturated than the primaries.
        tint: [f32; 3],
    },
    /// Whatever reflects this share at normal incidence, with eta = 1.
    Reflectance(Texture),
}

/// How rough a surface of microfacets (Trowbridge & Reitz 1975, "GGX") is along u and v.
#[derive(Clone, Debug)]
pub struct Roughness {
    /// Roughness by direction; only the first channel counts.
    pub uv: [Texture; 2],
    /// Whether alpha is the square root of the roughness rather than the roughness itself.
    pub remap: bool,
}

/// A clear or hazy layer over a surface, traversed at random (Guo, Hasan & Zhao 2018).
#[derive(Clone, Debug)]
pub struct Coat {
    /// Refractive index of the layer over that of the outside.
    pub eta: f32,
    /// The smoothness of its outer side.
    pub roughness: Roughness,
    /// Thickness in mean free paths of a medium of density 1.
    pub thickness: Texture,
    /// Single-scattering albedo of the medium in the layer; 0 is clear.
    pub albedo: Texture,
    /// Asymmetry of its scattering (Henyey & Greenstein 1941).
    pub g: Texture,
    /// Most events inside the layer.
    pub max_depth: u32,
    /// Random walks for each evaluation.
    pub samples: u32,
}

impl Material {
    /// A material without bent normals.
    pub fn new(scatters: Scatters) -> Self {
        Self { scatters, bump: None, normal_map: None }
    }

    /// Whether it looks textures up over the footprint of a pixel.
    pub fn is_textured(&self) -> bool {
        self.bump.is_some()
            || self.scatters.textures().into_iter().any(|texture| texture.is_filtered())
    }

    /// A Lambertian surface of one colour.
    pub fn diffuse(reflectance: [f32; 3]) -> Self {
        Self::new(Scatters::Diffuse { reflectance: Texture::Constant(reflectance) })
    }
}

impl Scatters {
    /// All textures that are looked up for it.
    fn textures(&self) -> Vec<&Texture> {
        match self {
            Self::Interface | Self::ThinDielectric { .. } => Vec::new(),
            Self::Diffuse { reflectance } => vec![reflectance],
            Self::DiffuseTransmission { reflectance, transmittance, .. } => {
                vec![reflectance, transmittance]
            }
            Self::Conductor { metal, roughness } => {
                metal.textures().into_iter().chain(&roughness.uv).collect()
            }
            Self::Dielectric { roughness, .. } => roughness.uv.iter().collect(),
            Self::CoatedDiffuse { reflectance, coat } => {
                coat.textures().chain([reflectance]).collect()
            }
            Self::CoatedConductor { metal, roughness, coat } => {
                coat.textures().chain(metal.textures()).chain(&roughness.uv).collect()
            }
            Self::Mix { amount, .. } => vec![amount],
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

impl Coat {
    fn textures(&self) -> impl Iterator<Item = &Texture> {
        [&self.thickness, &self.albedo, &self.g].into_iter().chain(&self.roughness.uv)
    }
}

impl Roughness {
    /// A perfectly smooth surface.
    pub fn smooth() -> Self {
        Self { uv: [Texture::Constant([0.0; 3]), Texture::Constant([0.0; 3])], remap: true }
    }
}
