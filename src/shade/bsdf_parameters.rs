//! BSDF parameters of a surface point, from its material and textures.

use super::bsdf::{
    Bsdf, CoatLayer, Coated, Conductor, Dielectric, Diffuse, DiffuseTransmission, MisWeights,
    ThinDielectric, conductor_reflectance,
};
use super::bsdf_kind::resolve_mixture;
use super::footprint::PixelFootprint;
use super::shading_context::ShadingContext;
use crate::lanes::Real;
use crate::rays::{Hit, Ray};
use crate::scene::{
    DielectricCoat, Material, MaterialModel, Metal, Roughness, Scene, SurfacePoint,
};
use crate::spectrum::ChannelMetal;

/// Largest number of parameters of a BSDF without a coat.
pub(super) const PARAMETER_COUNT: usize = 11;

/// Returns the parameters of a surface without a coat, in the order of
/// [`FromParameters::from_parameters`].
pub(super) fn bsdf_parameters(
    material: &Material,
    context: &ShadingContext,
) -> [f32; PARAMETER_COUNT] {
    let mut parameters = [0.0; PARAMETER_COUNT];
    let mut put = |first: usize, values: &[f32]| {
        parameters[first..first + values.len()].copy_from_slice(values);
    };
    match &material.model {
        MaterialModel::Diffuse { reflectance } => {
            put(0, &clamp_to_unit(context.colour(reflectance)));
        }
        MaterialModel::DiffuseTransmission { reflectance, transmittance, scale } => {
            put(0, &clamp_to_unit(context.colour(reflectance).map(|c| c * scale)));
            put(3, &clamp_to_unit(context.colour(transmittance).map(|c| c * scale)));
        }
        MaterialModel::Conductor { metal, roughness } => {
            put(0, &alpha(roughness, context));
            let ChannelMetal { eta, k, tint } = complex_index(metal, context);
            put(2, &eta);
            put(5, &k);
            put(8, &tint);
        }
        MaterialModel::Dielectric { eta, roughness } => {
            put(0, &alpha(roughness, context));
            put(2, &[*eta]);
        }
        MaterialModel::ThinDielectric { eta } => put(0, &[*eta]),
        MaterialModel::CoatedDiffuse { .. }
        | MaterialModel::CoatedConductor { .. }
        | MaterialModel::Interface
        | MaterialModel::Mix { .. } => {}
    }
    parameters
}

/// Returns the BSDF of a coated diffuse surface, or `None` for other materials.
pub(super) fn coated_diffuse(
    material: &Material,
    context: &ShadingContext,
) -> Option<Coated<Diffuse<f32>>> {
    let MaterialModel::CoatedDiffuse { reflectance, coat } = &material.model else { return None };
    let base = Diffuse { reflectance: clamp_to_unit(context.colour(reflectance)) };
    Some(Coated::new(coat_layer(coat, context), base))
}

/// Returns the BSDF of a coated conductor, or `None` for other materials.
pub(super) fn coated_conductor(
    material: &Material,
    context: &ShadingContext,
) -> Option<Coated<Conductor<f32>>> {
    let MaterialModel::CoatedConductor { metal, roughness, coat } = &material.model else {
        return None;
    };
    let relative_to_coat = |index: [f32; 3]| index.map(|n| n / coat.eta);
    let ChannelMetal { eta, k, tint } = complex_index(metal, context);
    let (eta, k) = (relative_to_coat(eta), relative_to_coat(k));
    let base = Conductor::new(alpha(roughness, context), eta, k).tinted(tint);
    Some(Coated::new(coat_layer(coat, context), base))
}

fn coat_layer(coat: &DielectricCoat, context: &ShadingContext) -> CoatLayer {
    CoatLayer {
        interface: Dielectric::new(alpha(&coat.roughness, context), coat.eta),
        thickness: context.number(&coat.thickness),
        albedo: clamp_to_unit(context.colour(&coat.albedo)),
        g: context.number(&coat.g).clamp(-1.0, 1.0),
        max_depth: coat.max_depth,
        samples: coat.samples,
        weights: MisWeights::default(),
    }
}

/// Clamps shares of light to [0, 1].
fn clamp_to_unit(colour: [f32; 3]) -> [f32; 3] {
    colour.map(|c| c.clamp(0.0, 1.0))
}

/// Returns the GGX width alpha along u and v.
fn alpha(roughness: &Roughness, context: &ShadingContext) -> [f32; 2] {
    [0, 1].map(|axis| {
        let value = context.number(&roughness.uv[axis]).max(0.0);
        if roughness.remap { value.sqrt() } else { value }
    })
}

/// Returns the complex refractive index of a metal at a point, and its tint.
fn complex_index(metal: &Metal, context: &ShadingContext) -> ChannelMetal {
    match metal {
        Metal::Index { eta, k, tint } => {
            ChannelMetal { eta: context.colour(eta), k: context.colour(k), tint: *tint }
        }
        Metal::Reflectance(reflectance) => {
            // An index 1 + i k reflects k^2 / (4 + k^2) at normal incidence.
            let k = |r: f32| 2.0 * (r / (1.0 - r)).sqrt();
            let k = context.colour(reflectance).map(|r| k(r.clamp(0.0, 0.9999)));
            ChannelMetal { eta: [1.0; 3], k, tint: [1.0; 3] }
        }
    }
}

/// A BSDF that is built from its parameters, lane by lane.
pub(super) trait FromParameters<R: Real<Scalar = f32>>: Bsdf<R> {
    /// Builds the BSDF from the parameters that [`bsdf_parameters`] returns.
    fn from_parameters(parameters: [R; PARAMETER_COUNT]) -> Self;
}

impl<R: Real<Scalar = f32>> FromParameters<R> for Diffuse<R> {
    #[inline(always)]
    fn from_parameters([r, g, b, ..]: [R; PARAMETER_COUNT]) -> Self {
        Self { reflectance: [r, g, b] }
    }
}

impl<R: Real<Scalar = f32>> FromParameters<R> for DiffuseTransmission<R> {
    #[inline(always)]
    fn from_parameters([r, g, b, tr, tg, tb, ..]: [R; PARAMETER_COUNT]) -> Self {
        Self { reflectance: [r, g, b], transmittance: [tr, tg, tb] }
    }
}

impl<R: Real<Scalar = f32>> FromParameters<R> for Conductor<R> {
    #[inline(always)]
    fn from_parameters(
        [along, across, r, g, b, kr, kg, kb, tint @ ..]: [R; PARAMETER_COUNT],
    ) -> Self {
        Self::new([along, across], [r, g, b], [kr, kg, kb]).tinted(tint)
    }
}

impl<R: Real<Scalar = f32>> FromParameters<R> for Dielectric<R> {
    #[inline(always)]
    fn from_parameters([along, across, eta, ..]: [R; PARAMETER_COUNT]) -> Self {
        Self::new([along, across], eta)
    }
}

impl<R: Real<Scalar = f32>> FromParameters<R> for ThinDielectric<R> {
    #[inline(always)]
    fn from_parameters([eta, ..]: [R; PARAMETER_COUNT]) -> Self {
        Self::new(eta)
    }
}

/// Returns the approximate share of light that a surface reflects or transmits, by channel.
pub fn albedo(
    scene: &Scene,
    footprint: &PixelFootprint,
    ray: Ray,
    hit: Hit,
    point: SurfacePoint,
) -> [f32; 3] {
    let context = || ShadingContext::new(scene, footprint, ray, hit, point);
    let shape = &scene.shapes[hit.shape as usize];
    let (material, _) = resolve_mixture(scene, shape.material, context);
    let context = context();
    match &scene.materials[material as usize].model {
        MaterialModel::Diffuse { reflectance }
        | MaterialModel::CoatedDiffuse { reflectance, .. } => {
            clamp_to_unit(context.colour(reflectance))
        }
        MaterialModel::DiffuseTransmission { reflectance, transmittance, scale } => {
            let [r, t] = [reflectance, transmittance].map(|texture| context.colour(texture));
            clamp_to_unit([0, 1, 2].map(|c| (r[c] + t[c]) * scale))
        }
        MaterialModel::Conductor { metal, .. } | MaterialModel::CoatedConductor { metal, .. } => {
            let ChannelMetal { eta, k, tint } = complex_index(metal, &context);
            [0, 1, 2].map(|c| conductor_reflectance(1.0, eta[c], k[c]) * tint[c])
        }
        MaterialModel::Dielectric { .. }
        | MaterialModel::ThinDielectric { .. }
        | MaterialModel::Interface
        | MaterialModel::Mix { .. } => [1.0; 3],
    }
}
