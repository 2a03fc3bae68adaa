//! Whichever scattering function a surface has.

use super::{
    Bsdf, Coated, Conductor, Dielectric, Diffuse, DiffuseTransmission, Drawn, ThinDielectric,
};

/// A scattering function for one lane.
#[derive(Clone, Copy, Debug)]
pub enum AnyBsdf {
    /// Lambert's reflection.
    Diffuse(Diffuse<f32>),
    /// Lambert's reflection and transmission.
    DiffuseTransmission(DiffuseTransmission<f32>),
    /// A metal.
    Conductor(Conductor<f32>),
    /// The border of glass and the like.
    Dielectric(Dielectric<f32>),
    /// A pane of glass.
    ThinDielectric(ThinDielectric<f32>),
    /// A varnished diffuse surface.
    CoatedDiffuse(Coated<Diffuse<f32>>),
    /// A varnished metal.
    CoatedConductor(Coated<Conductor<f32>>),
}

impl AnyBsdf {
    /// f |cos wi| by colour channel, and the density with which [`Self::draw`] draws `wi`; see
    /// [`Bsdf::evaluate`]. Only coats use the seed, see [`Coated::evaluate`].
    pub fn evaluate(&self, wo: [f32; 3], wi: [f32; 3], seed: u32) -> ([f32; 3], f32) {
        match self {
            Self::Diffuse(bsdf) => bsdf.evaluate(wo, wi),
            Self::DiffuseTransmission(bsdf) => bsdf.evaluate(wo, wi),
            Self::Conductor(bsdf) => bsdf.evaluate(wo, wi),
            Self::Dielectric(bsdf) => bsdf.evaluate(wo, wi),
            Self::ThinDielectric(bsdf) => bsdf.evaluate(wo, wi),
            Self::CoatedDiffuse(bsdf) => bsdf.evaluate(wo, wi, seed),
            Self::CoatedConductor(bsdf) => bsdf.evaluate(wo, wi, seed),
        }
    }

    /// Draws a direction; see [`Bsdf::draw`]. Only coats use the seed, see [`Coated::draw`].
    pub fn draw(&self, wo: [f32; 3], u: [f32; 2], choice: f32, seed: u32) -> Drawn<f32> {
        match self {
            Self::Diffuse(bsdf) => bsdf.draw(wo, u, choice),
            Self::DiffuseTransmission(bsdf) => bsdf.draw(wo, u, choice),
            Self::Conductor(bsdf) => bsdf.draw(wo, u, choice),
            Self::Dielectric(bsdf) => bsdf.draw(wo, u, choice),
            Self::ThinDielectric(bsdf) => bsdf.draw(wo, u, choice),
            Self::CoatedDiffuse(bsdf) => bsdf.draw(wo, u, choice, seed),
            Self::CoatedConductor(bsdf) => bsdf.draw(wo, u, choice, seed),
        }
    }

    /// Whether [`Self::evaluate`] is 0 for all directions, so that lights need not be sampled.
    pub fn is_singular(&self) -> bool {
        match self {
            Self::Diffuse(bsdf) => bsdf.singular(),
            Self::DiffuseTransmission(bsdf) => bsdf.singular(),
            Self::Conductor(bsdf) => bsdf.singular(),
            Self::Dielectric(bsdf) => bsdf.singular(),
            Self::ThinDielectric(bsdf) => bsdf.singular(),
            Self::CoatedDiffuse(bsdf) => bsdf.singular(),
            Self::CoatedConductor(bsdf) => bsdf.singular(),
        }
    }
}
