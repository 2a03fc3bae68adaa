//! What each kind of material reads, and what it takes where nothing is given: the names and
//! defaults of pbrt-v4. Kinds of pbrt-v2 and v3 become the nearest kind of v4.

use std::sync::Arc;

use super::colour::Meaning;
use super::params::Params;
use super::textures::Library;
use super::{Notices, SceneError};
use crate::scene::{Coat, Metal, Roughness, Scatters, Texture};

/// What a material is made from.
pub(super) struct Recipe<'a> {
    pub(super) params: &'a Params,
    pub(super) library: &'a Library,
    pub(super) notices: &'a mut Notices,
}

/// The same number in every channel.
pub(super) fn grey(value: f32) -> Texture {
    Texture::Constant([value; 3])
}

impl Recipe<'_> {
    /// How a kind of material scatters.
    pub(super) fn scatters(&mut self, kind: &str) -> Result<Scatters, SceneError> {
        Ok(match kind {
            "" | "none" | "interface" => Scatters::Interface,
            "diffuse" => Scatters::Diffuse { reflectance: self.colour("reflectance", 0.5)? },
            "matte" => Scatters::Diffuse { reflectance: self.colour("Kd", 0.5)? },
            "diffusetransmission" => Scatters::DiffuseTransmission {
                reflectance: self.colour("reflectance", 0.25)?,
                transmittance: self.colour("transmittance", 0.25)?,
                scale: self.params.float("scale", 1.0)? as f32,
            },
            "translucent" => {
                let kd = Arc::new(self.colour("Kd", 0.25)?);
                let mut share = |name: &str| {
                    let share = Arc::new(self.colour(name, 0.5)?);
                    Ok::<_, SceneError>(Texture::Scale(kd.clone(), share))
                };
                Scatters::DiffuseTransmission {
                    reflectance: share("reflect")?,
                    transmittance: share("transmit")?,
                    scale: 1.0,
                }
            }
            "conductor" => Scatters::Conductor {
                metal: self.metal("eta", "k")?,
                roughness: self.roughness("", 0.0)?,
            },
            "metal" => Scatters::Conductor {
                metal: self.metal("eta", "k")?,
                roughness: self.roughness("", 0.01)?,
            },
            "mirror" => Scatters::Conductor {
                metal: Metal::Reflectance(self.colour("Kr", 0.9)?),
                roughness: Roughness::smooth(),
            },
            "shinymetal" => Scatters::Conductor {
                metal: Metal::Reflectance(self.colour("Kr", 1.0)?),
                roughness: self.roughness("", 0.1)?,
            },
            "dielectric" => Scatters::Dielectric {
                eta: self.index(&["eta"])?,
                roughness: self.roughness("", 0.0)?,
            },
            "glass" => Scatters::Dielectric {
                eta: self.index(&["eta", "index"])?,
                roughness: self.roughness("", 0.0)?,
            },
            "thindielectric" => Scatters::ThinDielectric { eta: self.index(&["eta"])? },
            "coateddiffuse" => Scatters::CoatedDiffuse {
                reflectance: self.colour("reflectance", 0.5)?,
                coat: self.coat("", &["eta"], 0.0)?,
            },
            "substrate" => Scatters::CoatedDiffuse {
                reflectance: self.colour("Kd", 0.5)?,
                coat: self.coat("", &[], 0.1)?,
            },
            "plastic" | "uber" => Scatters::CoatedDiffuse {
                reflectance: self.colour("Kd", 0.25)?,
                coat: self.coat("", &["eta", "index"], 0.1)?,
            },
            _ => Scatters::CoatedConductor {
                metal: self.metal("conductor.eta", "conductor.k")?,
                roughness: self.roughness("conductor.", 0.0)?,
                coat: self.coat("interface.", &["interface.eta"], 0.0)?,
            },
        })
    }

    /// The layer over a coated surface; `prefix` is that of its roughness.
    fn coat(
        &mut self,
        prefix: &str,
        eta: &[&str],
        roughness: f32,
    ) -> Result<Box<Coat>, SceneError> {
        Ok(Box::new(Coat {
            eta: self.index(eta)?,
            roughness: self.roughness(prefix, roughness)?,
            thickness: self.number("thickness", 0.01)?,
            albedo: self.colour("albedo", 0.0)?,
            g: self.number("g", 0.0)?,
            max_depth: self.params.count_of("maxdepth", 10_000)?.unwrap_or(10),
            samples: self.params.count_of("nsamples", 10_000)?.unwrap_or(1),
        }))
    }

    fn roughness(&mut self, prefix: &str, default: f32) -> Result<Roughness, SceneError> {
        let both = self.number(&format!("{prefix}roughness"), default)?;
        let mut along = |axis: &str| -> Result<Texture, SceneError> {
            let own = self.maybe_number(&format!("{prefix}{axis}roughness"))?;
            Ok(own.unwrap_or_else(|| both.clone()))
        };
        let uv = [along("u")?, along("v")?];
        Ok(Roughness { uv, remap: self.params.truth("remaproughness")?.unwrap_or(true) })
    }

    /// A colour or a texture of colours.
    pub(super) fn colour(&mut self, name: &str, default: f32) -> Result<Texture, SceneError> {
        let found = self.library.colour_or_texture(self.params, name, Meaning::Albedo)?;
        Ok(found.unwrap_or_else(|| grey(default)))
    }

    /// A number or a texture of numbers.
    pub(super) fn number(&mut self, name: &str, default: f32) -> Result<Texture, SceneError> {
        Ok(self.maybe_number(name)?.unwrap_or_else(|| grey(default)))
    }

    /// A number or a texture of numbers, if one is given.
    pub(super) fn maybe_number(&mut self, name: &str) -> Result<Option<Texture>, SceneError> {
        self.library.number_or_texture(self.params, name)
    }
}
