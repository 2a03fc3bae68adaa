//! Kinds of BSDFs, whose vertices are shaded together, and the choice of a material in mixtures.

use super::bsdf::Microfacets;
use super::bsdf_parameters::{COAT_PARAMETER_COUNT, PARAMETER_COUNT};
use super::shading_context::ShadingContext;
use crate::lanes::Real;
use crate::lanes::vector::{dot, negate, select};
use crate::rays::Ray;
use crate::sampler::hash;
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
    MetallicRoughness,
    Measured,
    Hair,
    /// Scattering in a medium.
    Medium,
    /// The surface through which a path leaves a medium that it has walked through.
    SubsurfaceExit,
    /// Not shaded: rays pass straight through.
    Interface,
}

/// Number of kinds.
pub(super) const KIND_COUNT: usize = BsdfKind::Interface as usize + 1;

impl BsdfKind {
    /// All kinds, in the order of their discriminants.
    pub(super) const ALL: [Self; KIND_COUNT] = [
        Self::Diffuse,
        Self::DiffuseTransmission,
        Self::Conductor,
        Self::Dielectric,
        Self::ThinDielectric,
        Self::CoatedDiffuse,
        Self::CoatedConductor,
        Self::MetallicRoughness,
        Self::Measured,
        Self::Hair,
        Self::Medium,
        Self::SubsurfaceExit,
        Self::Interface,
    ];

    /// Returns the name of the material, as in pbrt-v4 if that has it.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Diffuse => "diffuse",
            Self::DiffuseTransmission => "diffusetransmission",
            Self::Conductor => "conductor",
            Self::Dielectric => "dielectric",
            Self::ThinDielectric => "thindielectric",
            Self::CoatedDiffuse => "coateddiffuse",
            Self::CoatedConductor => "coatedconductor",
            Self::MetallicRoughness => "metallicroughness",
            Self::Measured => "measured",
            Self::Hair => "hair",
            Self::Medium => "medium",
            Self::SubsurfaceExit => "subsurface",
            Self::Interface => "interface",
        }
    }

    /// Returns the number of its BSDF's parameters.
    pub(super) fn parameter_count(self) -> usize {
        match self {
            Self::Measured | Self::Interface => 0,
            Self::Medium => 1,
            Self::SubsurfaceExit => 2,
            Self::Diffuse => 3,
            Self::MetallicRoughness => 11,
            Self::ThinDielectric => 4,
            Self::DiffuseTransmission | Self::Dielectric => 6,
            Self::Hair => 8,
            Self::Conductor => PARAMETER_COUNT - COAT_PARAMETER_COUNT,
            Self::CoatedDiffuse | Self::CoatedConductor => PARAMETER_COUNT,
        }
    }

    /// Returns the indices of the parameters that are the width alpha of microfacets.
    pub(super) fn widths(self) -> &'static [usize] {
        const COAT: usize = PARAMETER_COUNT - COAT_PARAMETER_COUNT;
        match self {
            Self::Conductor | Self::Dielectric => &[0, 1],
            Self::MetallicRoughness => &[0, 6],
            Self::CoatedDiffuse => &[COAT, COAT + 1],
            Self::CoatedConductor => &[0, 1, COAT, COAT + 1],
            _ => &[],
        }
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

    /// Returns the unit normal on the side from which light counts, that of `wo`; 0 if light counts
    /// from both sides.
    #[inline(always)]
    pub(super) fn facing<R: Real<Scalar = f32>>(self, normal: [R; 3], wo: [R; 3]) -> [R; 3] {
        match self {
            Self::Diffuse
            | Self::Conductor
            | Self::CoatedDiffuse
            | Self::CoatedConductor
            | Self::MetallicRoughness
            | Self::Measured => {
                let back = dot(normal, wo).lt(R::splat(0.0));
                select(back, negate(normal), normal)
            }
            Self::DiffuseTransmission
            | Self::Dielectric
            | Self::ThinDielectric
            | Self::Hair
            | Self::Medium
            | Self::SubsurfaceExit
            | Self::Interface => [R::splat(0.0); 3],
        }
    }

    /// Returns the kind of a material model, or `None` for a mixture.
    #[inline(always)]
    fn of(model: &MaterialModel) -> Option<Self> {
        Some(match model {
            MaterialModel::Interface => Self::Interface,
            MaterialModel::Diffuse { .. } => Self::Diffuse,
            MaterialModel::DiffuseTransmission { .. } => Self::DiffuseTransmission,
            MaterialModel::Conductor { .. } => Self::Conductor,
            MaterialModel::Dielectric { .. }
            | MaterialModel::TintedDielectric { .. }
            | MaterialModel::Subsurface { .. } => Self::Dielectric,
            MaterialModel::ThinDielectric { .. } => Self::ThinDielectric,
            MaterialModel::CoatedDiffuse { .. } => Self::CoatedDiffuse,
            MaterialModel::CoatedConductor { .. } => Self::CoatedConductor,
            MaterialModel::MetallicRoughness(_) => Self::MetallicRoughness,
            MaterialModel::Measured(_) => Self::Measured,
            MaterialModel::Hair(_) => Self::Hair,
            MaterialModel::Mix { .. } => return None,
        })
    }
}

/// Chooses the material of a surface that a ray hit if `material` is a mixture, and returns its
/// index and kind. `context` is called for mixtures only.
#[inline(always)]
pub(super) fn resolve_mixture(
    scene: &Scene,
    material: u32,
    ray: impl Fn() -> Ray,
    context: impl Fn() -> ShadingContext,
) -> (u32, BsdfKind) {
    match BsdfKind::of(&scene.materials[material as usize].model) {
        Some(kind) => (material, kind),
        None => choose_material(scene, material, &ray(), &context()),
    }
}

/// Chooses one of the materials of a mixture.
#[cold]
#[inline(never)]
fn choose_material(
    scene: &Scene,
    mixture: u32,
    ray: &Ray,
    context: &ShadingContext,
) -> (u32, BsdfKind) {
    let mut index = mixture;
    // A mixture consists of materials defined before it, so the loop ends.
    loop {
        let model = &scene.materials[index as usize].model;
        if let Some(kind) = BsdfKind::of(model) {
            return (index, kind);
        }
        if let MaterialModel::Mix { materials, amount } = model {
            let number = hashed_number(index, context.points.position, ray.direction);
            index = materials[usize::from(number < context.number(amount))];
        }
    }
}

/// Returns a random number in [0, 1) that depends only on a point, the direction of a ray and
/// `salt`.
fn hashed_number(salt: u32, point: [f32; 3], direction: [f32; 3]) -> f32 {
    let bits = point.into_iter().chain(direction);
    let mixed = bits.fold(salt, |h, value| hash(h ^ value.to_bits()));
    (mixed >> 8) as f32 / 16_777_216.0
}
