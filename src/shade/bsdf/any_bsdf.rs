//! BSDF of any kind, for one lane.

use super::{
    Bsdf, BsdfSample, Coated, Conductor, Dielectric, Diffuse, DiffuseTransmission, Hair,
    MetallicRoughness, ThinDielectric,
};

/// A BSDF of any kind, for one lane.
#[derive(Clone, Copy, Debug)]
pub enum AnyBsdf {
    /// Lambertian reflection.
    Diffuse(Diffuse<f32>),
    /// Lambertian reflection and transmission.
    DiffuseTransmission(DiffuseTransmission<f32>),
    /// A metal.
    Conductor(Conductor<f32>),
    /// The interface of glass, water or another clear medium.
    Dielectric(Dielectric<f32>),
    /// A thin sheet of glass.
    ThinDielectric(ThinDielectric<f32>),
    /// A metal or a plastic of glTF.
    MetallicRoughness(MetallicRoughness<f32>),
    /// A hair.
    Hair(Hair<f32>),
    /// A diffuse surface under a coat.
    CoatedDiffuse(Coated<f32, Diffuse<f32>>),
    /// A metal under a coat.
    CoatedConductor(Coated<f32, Conductor<f32>>),
}

impl AnyBsdf {
    /// Returns f |cos wi| by colour channel, and the density with which [`Self::sample`] samples
    /// `wi`; see [`Bsdf::evaluate`]. Only coats use the seed, see [`Coated::evaluate`].
    pub fn evaluate(&self, wo: [f32; 3], wi: [f32; 3], seed: u32) -> ([f32; 3], f32) {
        match self {
            Self::Diffuse(bsdf) => bsdf.evaluate(wo, wi),
            Self::DiffuseTransmission(bsdf) => bsdf.evaluate(wo, wi),
            Self::Conductor(bsdf) => bsdf.evaluate(wo, wi),
            Self::Dielectric(bsdf) => bsdf.evaluate(wo, wi),
            Self::ThinDielectric(bsdf) => bsdf.evaluate(wo, wi),
            Self::MetallicRoughness(bsdf) => bsdf.evaluate(wo, wi),
            Self::Hair(bsdf) => bsdf.evaluate(wo, wi),
            Self::CoatedDiffuse(bsdf) => bsdf.evaluate(wo, wi, seed),
            Self::CoatedConductor(bsdf) => bsdf.evaluate(wo, wi, seed),
        }
    }

    /// Samples a direction; see [`Bsdf::sample`]. Only coats use the seed, see [`Coated::sample`].
    pub fn sample(&self, wo: [f32; 3], u: [f32; 2], choice: f32, seed: u32) -> BsdfSample<f32> {
        match self {
            Self::Diffuse(bsdf) => bsdf.sample(wo, u, choice),
            Self::DiffuseTransmission(bsdf) => bsdf.sample(wo, u, choice),
            Self::Conductor(bsdf) => bsdf.sample(wo, u, choice),
            Self::Dielectric(bsdf) => bsdf.sample(wo, u, choice),
            Self::ThinDielectric(bsdf) => bsdf.sample(wo, u, choice),
            Self::MetallicRoughness(bsdf) => bsdf.sample(wo, u, choice),
            Self::Hair(bsdf) => bsdf.sample(wo, u, choice),
            Self::CoatedDiffuse(bsdf) => bsdf.sample(wo, u, choice, seed),
            Self::CoatedConductor(bsdf) => bsdf.sample(wo, u, choice, seed),
        }
    }

    /// Returns whether [`Self::evaluate`] is 0 for all directions, so that lights need not be
    /// sampled.
    pub fn is_singular(&self) -> bool {
        match self {
            Self::Diffuse(bsdf) => bsdf.singular(),
            Self::DiffuseTransmission(bsdf) => bsdf.singular(),
            Self::Conductor(bsdf) => bsdf.singular(),
            Self::Dielectric(bsdf) => bsdf.singular(),
            Self::ThinDielectric(bsdf) => bsdf.singular(),
            Self::MetallicRoughness(bsdf) => bsdf.singular(),
            Self::Hair(bsdf) => bsdf.singular(),
            Self::CoatedDiffuse(bsdf) => bsdf.is_singular(),
            Self::CoatedConductor(bsdf) => bsdf.is_singular(),
        }
    }
}
