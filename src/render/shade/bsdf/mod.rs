//! BSDFs: bidirectional scattering distribution functions, with pbrt-v4's definitions.
//!
//! Directions are unit vectors [x, y, z] in the shading frame: x and y are the tangents, z is the
//! shading normal ([`ShadingFrame`]). `wo` points to where a path came from, `wi` to where light
//! comes from. Light is reflected if their z have the same sign, else transmitted. BSDFs transport
//! radiance: light that is refracted on its way to `wo` is divided by the squared ratio of the
//! refractive indices.
//!
//! All BSDFs are kernels over lanes, whose results are the same bit for bit for one lane and for
//! eight. All but coats are without branches. A coat is a random walk ([`Coated`]); the lanes of a
//! packet walk in step.
//!
//! The file of a BSDF also holds its parameters as columns of a wave's vertices, and how they follow
//! from a material (`VertexParameters`). The list of `BsdfKind` names all of them.

mod coat;
mod columns;
mod conductor;
mod dielectric;
mod diffuse;
mod diffuse_transmission;
mod fresnel;
mod gloss;
mod hair;
mod lobe_choice;
mod measured;
mod metallic_roughness;
mod microfacet;
mod phase_function;
mod schlick_interface;
mod shading_frame;
mod subsurface_exit;
mod surface_textures;
mod thin_dielectric;
mod tinted_dielectric;
mod vertex_parameters;

pub use coat::{CoatLayer, Coated, MisWeights, SeededCoat};
pub use conductor::Conductor;
pub use dielectric::Dielectric;
pub use diffuse::Diffuse;
pub use diffuse_transmission::DiffuseTransmission;
pub use fresnel::{Refraction, conductor_reflectance};
pub use hair::{Hair, HairParameters};
pub use measured::Measured;
pub use metallic_roughness::{MetallicRoughness, MetallicRoughnessParameters, dielectric_f0};
pub use microfacet::Microfacets;
pub use phase_function::{MediumScattering, sample_henyey_greenstein};
pub use shading_frame::ShadingFrame;
pub use subsurface_exit::SubsurfaceExit;
pub use thin_dielectric::ThinDielectric;
pub use tinted_dielectric::TintedDielectric;

pub(super) use coat::CoatWalks;
pub(super) use columns::Columns;
pub(super) use gloss::Gloss;
pub(super) use surface_textures::{SurfaceTextures, clamp_to_unit};
pub(super) use vertex_parameters::{ParametersVisitor, VertexParameters};

use coat::{CoatedConductorParameters, CoatedDiffuseParameters};
use columns::columns;
use conductor::ConductorParameters;
use petzval_base::lanes::Real;
use petzval_scene::MaterialModel;
use tinted_dielectric::TintedDielectricParameters;
use vertex_parameters::bsdf_kinds;

// A new material adds its BSDF here: `Kind: Parameters = pattern of its models`.
bsdf_kinds! {
    Diffuse: Diffuse = MaterialModel::Diffuse { .. },
    DiffuseTransmission: DiffuseTransmission = MaterialModel::DiffuseTransmission { .. },
    Conductor: ConductorParameters = MaterialModel::Conductor { .. },
    Dielectric: TintedDielectricParameters = MaterialModel::Dielectric { .. }
        | MaterialModel::TintedDielectric { .. }
        | MaterialModel::Subsurface { .. },
    ThinDielectric: ThinDielectric = MaterialModel::ThinDielectric { .. },
    CoatedDiffuse: CoatedDiffuseParameters = MaterialModel::CoatedDiffuse { .. },
    CoatedConductor: CoatedConductorParameters = MaterialModel::CoatedConductor { .. },
    MetallicRoughness: MetallicRoughnessParameters = MaterialModel::MetallicRoughness(_),
    // Its tables have no kernel over lanes: `MeasuredStage` works on it.
    Measured = MaterialModel::Measured(_),
    Hair: HairParameters = MaterialModel::Hair(_),
    // Scattering in a medium.
    Medium: MediumScattering,
    // The surface through which a path leaves a medium that it has walked through.
    SubsurfaceExit: SubsurfaceExit,
    // Not shaded: rays pass straight through.
    Interface = MaterialModel::Interface,
}

/// A BSDF, lane by lane.
pub trait Bsdf<R: Real<Scalar = f32>> {
    /// Returns f |cos wi| by colour channel, and the density by solid angle with which
    /// [`Self::sample`] samples `wi`. Singular lobes contribute to neither.
    fn evaluate(&self, wo: [R; 3], wi: [R; 3]) -> ([R; 3], R);

    /// Samples a direction. The numbers are in [0, 1): `u` chooses a direction of a lobe, `choice`
    /// the lobe.
    fn sample(&self, wo: [R; 3], u: [R; 2], choice: R) -> BsdfSample<R>;

    /// Returns the lanes in which [`Self::evaluate`] is 0 for all directions, so that lights need
    /// not be sampled.
    fn singular(&self) -> R::Mask;
}

/// A direction sampled from a BSDF.
#[derive(Clone, Copy, Debug)]
pub struct BsdfSample<R: Real> {
    /// The direction; the normal if nothing was sampled.
    pub wi: [R; 3],
    /// f |cos wi| / pdf by colour channel. For a singular lobe, its share of light over its
    /// probability. 0 if nothing was sampled.
    pub weight: [R; 3],
    /// Density by solid angle, as returned by [`Bsdf::evaluate`]; 0 for a singular lobe.
    pub pdf: R,
    /// Whether the lobe is singular (specular): no other technique can sample its direction.
    pub singular: R::Mask,
    /// Whether a direction was sampled.
    pub valid: R::Mask,
    /// Factor of the throughput for Russian roulette, which takes back the change of radiance by
    /// refraction: the squared refractive index beyond the surface over that before it if light was
    /// refracted, else 1.
    pub eta2: R,
}

impl<R: Real<Scalar = f32>> BsdfSample<R> {
    /// The same sample, with nothing sampled outside of the mask.
    #[inline(always)]
    fn only(self, mask: R::Mask) -> Self {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let valid = self.valid & mask;
        let [x, y, z] = self.wi;
        let [r, g, b] = self.weight;
        Self {
            wi: [R::select(valid, x, zero), R::select(valid, y, zero), R::select(valid, z, one)],
            weight: [
                R::select(valid, r, zero),
                R::select(valid, g, zero),
                R::select(valid, b, zero),
            ],
            pdf: R::select(valid, self.pdf, zero),
            singular: self.singular,
            valid,
            eta2: R::select(valid, self.eta2, one),
        }
    }
}
