//! Kinds of BSDFs, whose vertices are shaded together, and the choice of a material in mixtures.

use super::bsdf::Microfacets;
use super::shading_context::ShadingContext;
use crate::scene::{MaterialModel, Scene};

/// Kind of a surface's BSDF. Vertices of one kind are shaded together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum BsdfKind {
    Diffuse,
    DiffuseTransmission,
    Conductor,
    Dielectric,
    ThinDielectric,
    CoatedDiffuse,
    CoatedConductor,
    /// Not shaded: rays pass straight through.
    Interface,
}

/// Number of kinds that are shaded.
pub(super) const KIND_COUNT: usize = BsdfKind::Interface as usize;

impl BsdfKind {
    /// The kinds that are shaded, in the order of their discriminants.
    pub(super) const ALL: [Self; KIND_COUNT] = [
        Self::Diffuse,
        Self::DiffuseTransmission,
        Self::Conductor,
        Self::Dielectric,
        Self::ThinDielectric,
        Self::CoatedDiffuse,
        Self::CoatedConductor,
    ];

    /// Returns the name of the material in pbrt-v4.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Diffuse => "diffuse",
            Self::DiffuseTransmission => "diffusetransmission",
            Self::Conductor => "conductor",
            Self::Dielectric => "dielectric",
            Self::ThinDielectric => "thindielectric",
            Self::CoatedDiffuse => "coateddiffuse",
            Self::CoatedConductor => "coatedconductor",
            Self::Interface => "interface",
        }
    }

    /// Returns whether the BSDF is a random walk, which is evaluated for one lane at a time.
    pub(super) fn is_coated(self) -> bool {
        matches!(self, Self::CoatedDiffuse | Self::CoatedConductor)
    }

    /// Returns whether the BSDF is known to scatter no light from sampled lights. `alpha` holds the
    /// first two parameters of the surface.
    pub(super) fn is_singular(self, alpha: [f32; 2]) -> bool {
        match self {
            Self::ThinDielectric => true,
            Self::Conductor | Self::Dielectric => Microfacets::new(alpha).smooth,
            _ => false,
        }
    }

    /// Returns the kind of a material model, or `None` for a mixture.
    fn of(model: &MaterialModel) -> Option<Self> {
        Some(match model {
            MaterialModel::Interface => Self::Interface,
            MaterialModel::Diffuse { .. } => Self::Diffuse,
            MaterialModel::DiffuseTransmission { .. } => Self::DiffuseTransmission,
            MaterialModel::Conductor { .. } => Self::Conductor,
            MaterialModel::Dielectric { .. } => Self::Dielectric,
            MaterialModel::ThinDielectric { .. } => Self::ThinDielectric,
            MaterialModel::CoatedDiffuse { .. } => Self::CoatedDiffuse,
            MaterialModel::CoatedConductor { .. } => Self::CoatedConductor,
            MaterialModel::Mix { .. } => return None,
        })
    }
}

/// Chooses the material of a surface if `material` is a mixture, and returns its index and kind.
/// `context` is called for mixtures only.
pub(super) fn resolve_mixture<'a>(
    scene: &'a Scene,
    material: u32,
    context: impl Fn() -> ShadingContext<'a>,
) -> (u32, BsdfKind) {
    let mut index = material;
    // A mixture consists of materials defined before it, so the loop ends.
    loop {
        let model = &scene.materials[index as usize].model;
        if let Some(kind) = BsdfKind::of(model) {
            return (index, kind);
        }
        if let MaterialModel::Mix { materials, amount } = model {
            let context = context();
            let second = context.hashed_number(index) < context.number(amount);
            index = materials[usize::from(second)];
        }
    }
}
