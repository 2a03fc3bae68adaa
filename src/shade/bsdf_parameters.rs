//! BSDF parameters of a surface point, from its material and textures.

use super::bsdf::{
    Bsdf, CoatLayer, Coated, Conductor, Dielectric, Diffuse, DiffuseTransmission, Hair,
    HairParameters, Measured, MediumScattering, MetallicRoughness, MetallicRoughnessParameters,
    MisWeights, SubsurfaceExit, ThinDielectric, TintedDielectric, conductor_reflectance,
    dielectric_f0,
};
use super::bsdf_kind::resolve_mixture;
use super::footprint::PixelFootprint;
use super::hair_parameters::{hair_albedo, hair_parameters};
use super::shading_context::ShadingContext;
use crate::lanes::Real;
use crate::lanes::vector::{scale, splat};
use crate::rays::{Hit, Ray};
use crate::scene::{DielectricCoat, Material, MaterialModel, Metal, Roughness, Scene, Texture};

/// Largest number of parameters of a BSDF: those of a coat follow those of its base.
pub(super) const PARAMETER_COUNT: usize = BASE_PARAMETER_COUNT + COAT_PARAMETER_COUNT;
/// Largest number of parameters of a BSDF without a coat.
pub(super) const BASE_PARAMETER_COUNT: usize = 11;
/// Number of parameters of a coat.
pub(super) const COAT_PARAMETER_COUNT: usize = 10;

/// Returns the parameters of the surfaces of a material, in the order of
/// [`FromParameters::from_parameters`]. The context matters only for materials for which
/// [`Scene::needs_derivatives`] holds.
#[inline(always)]
pub(super) fn bsdf_parameters<R: Real<Scalar = f32>>(
    material: &Material,
    context: &ShadingContext<R>,
) -> [R; PARAMETER_COUNT] {
    let mut parameters = [R::splat(0.0); PARAMETER_COUNT];
    let mut put = |first: usize, values: &[R]| {
        parameters[first..first + values.len()].copy_from_slice(values);
    };
    match &material.model {
        MaterialModel::Diffuse { reflectance } => {
            put(0, &clamp_to_unit(context.colour(reflectance)));
        }
        MaterialModel::DiffuseTransmission { reflectance, transmittance, scale: factor } => {
            let factor = R::splat(*factor);
            put(0, &clamp_to_unit(scale(context.colour(reflectance), factor)));
            put(3, &clamp_to_unit(scale(context.colour(transmittance), factor)));
        }
        MaterialModel::Conductor { metal, roughness } => {
            put(0, &conductor(metal, roughness, context));
        }
        MaterialModel::Dielectric { eta, roughness } => {
            put(0, &alpha(roughness, context));
            put(2, &[*eta, 1.0, 1.0, 1.0].map(R::splat));
        }
        MaterialModel::Subsurface { interior, roughness } => {
            put(0, &alpha(roughness, context));
            put(2, &[interior.eta, 1.0, 1.0, 1.0].map(R::splat));
        }
        MaterialModel::TintedDielectric { eta, roughness, tint } => {
            put(0, &alpha(roughness, context));
            put(2, &[R::splat(*eta)]);
            put(3, &clamp_to_unit(context.colour(tint)));
        }
        MaterialModel::ThinDielectric { eta, tint } => {
            put(0, &[R::splat(*eta)]);
            put(1, &clamp_to_unit(context.colour(tint)));
        }
        MaterialModel::CoatedDiffuse { reflectance, coat } => {
            put(0, &clamp_to_unit(context.colour(reflectance)));
            put(BASE_PARAMETER_COUNT, &coat_parameters(coat, context));
        }
        MaterialModel::CoatedConductor { metal, roughness, coat } => {
            let mut base = conductor(metal, roughness, context);
            // The refractive index relative to that of the coat.
            for index in &mut base[2..8] {
                *index = *index / R::splat(coat.eta);
            }
            put(0, &base);
            put(BASE_PARAMETER_COUNT, &coat_parameters(coat, context));
        }
        MaterialModel::MetallicRoughness(surface) => {
            let [along, _] = alpha(&surface.roughness, context);
            let [r, g, b] = clamp_to_unit(context.colour(&surface.base_colour));
            let [metallic, coverage, _] = clamp_to_unit([
                context.number(&surface.metallic),
                context.number(&surface.coat_coverage),
                R::splat(0.0),
            ]);
            let [coat, _] = alpha(&surface.coat_roughness, context);
            let (zero, one) = (R::splat(0.0), R::splat(1.0));
            let specular = context.number(&surface.specular).max(zero).min(one);
            let f0 = dielectric_f0(R::splat(surface.eta));
            // A colour above 1 reflects more, up to all light.
            let [fr, fg, fb] = clamp_to_unit(scale(context.colour(&surface.specular_colour), f0));
            put(0, &[along, r, g, b, metallic, specular, coat, coverage, fr, fg, fb]);
        }
        MaterialModel::Hair(fibre) => put(0, &hair_parameters(fibre, context)),
        MaterialModel::Measured(_) | MaterialModel::Interface | MaterialModel::Mix { .. } => {}
    }
    parameters
}

/// Returns the parameters of a metal: roughness, real and imaginary part of the refractive index,
/// tint.
fn conductor<R: Real<Scalar = f32>>(
    metal: &Metal,
    roughness: &Roughness,
    context: &ShadingContext<R>,
) -> [R; BASE_PARAMETER_COUNT] {
    let [along, across] = alpha(roughness, context);
    let ([r, g, b], [kr, kg, kb], tint) = match metal {
        Metal::Index { eta, k, tint } => (context.colour(eta), context.colour(k), *tint),
        Metal::Reflectance(reflectance) => {
            // An index 1 + i k reflects k^2 / (4 + k^2) at normal incidence.
            let (zero, one) = (R::splat(0.0), R::splat(1.0));
            let k = |r: R| {
                let r = r.max(zero).min(R::splat(0.9999));
                R::splat(2.0) * (r / (one - r)).sqrt()
            };
            let [r, g, b] = context.colour(reflectance);
            ([one; 3], [k(r), k(g), k(b)], [1.0; 3])
        }
    };
    let [tr, tg, tb] = splat(tint);
    [along, across, r, g, b, kr, kg, kb, tr, tg, tb]
}

fn coat_parameters<R: Real<Scalar = f32>>(
    coat: &DielectricCoat,
    context: &ShadingContext<R>,
) -> [R; COAT_PARAMETER_COUNT] {
    let [along, across] = alpha(&coat.roughness, context);
    let [r, g, b] = clamp_to_unit(context.colour(&coat.albedo));
    let one = R::splat(1.0);
    [
        along,
        across,
        R::splat(coat.eta),
        context.number(&coat.thickness),
        r,
        g,
        b,
        context.number(&coat.g).max(-one).min(one),
        R::splat(coat.max_depth as f32),
        R::splat(coat.samples as f32),
    ]
}

/// Clamps shares of light to [0, 1]; NaN becomes 0.
#[inline(always)]
fn clamp_to_unit<R: Real<Scalar = f32>>([r, g, b]: [R; 3]) -> [R; 3] {
    let (zero, one) = (R::splat(0.0), R::splat(1.0));
    [r.max(zero).min(one), g.max(zero).min(one), b.max(zero).min(one)]
}

/// Returns the GGX width alpha along u and v.
#[inline(always)]
fn alpha<R: Real<Scalar = f32>>(roughness: &Roughness, context: &ShadingContext<R>) -> [R; 2] {
    let one_axis = |texture: &Texture| {
        let value = context.number(texture).max(R::splat(0.0));
        if roughness.remap { value.sqrt() } else { value }
    };
    [one_axis(&roughness.uv[0]), one_axis(&roughness.uv[1])]
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
        [along, across, r, g, b, kr, kg, kb, tr, tg, tb, ..]: [R; PARAMETER_COUNT],
    ) -> Self {
        Self::new([along, across], [r, g, b], [kr, kg, kb]).tinted([tr, tg, tb])
    }
}

impl<R: Real<Scalar = f32>> FromParameters<R> for MediumScattering<R> {
    #[inline(always)]
    fn from_parameters([g, ..]: [R; PARAMETER_COUNT]) -> Self {
        Self { g }
    }
}

impl<R: Real<Scalar = f32>> FromParameters<R> for SubsurfaceExit<R> {
    #[inline(always)]
    fn from_parameters([eta, entering, ..]: [R; PARAMETER_COUNT]) -> Self {
        Self { eta, entering }
    }
}

impl<R: Real<Scalar = f32>> FromParameters<R> for ThinDielectric<R> {
    #[inline(always)]
    fn from_parameters([eta, r, g, b, ..]: [R; PARAMETER_COUNT]) -> Self {
        Self::new(eta).tinted([r, g, b])
    }
}

impl<R: Real<Scalar = f32>> FromParameters<R> for TintedDielectric<R> {
    #[inline(always)]
    fn from_parameters([along, across, eta, r, g, b, ..]: [R; PARAMETER_COUNT]) -> Self {
        Self { interface: Dielectric::new([along, across], eta), tint: [r, g, b] }
    }
}

impl<R: Real<Scalar = f32>> FromParameters<R> for MetallicRoughness<R> {
    #[inline(always)]
    fn from_parameters(
        [alpha, r, g, b, metallic, specular, coat_alpha, coverage, fr, fg, fb, ..]:
            [R; PARAMETER_COUNT],
    ) -> Self {
        let (base, f0) = ([r, g, b], [fr, fg, fb]);
        Self::new(MetallicRoughnessParameters {
            alpha,
            base,
            metallic,
            f0,
            specular,
            coat_alpha,
            coverage,
        })
    }
}

impl<R: Real<Scalar = f32>> FromParameters<R> for Hair<R> {
    #[inline(always)]
    fn from_parameters(
        [r, g, b, eta, beta_m, beta_n, tilt, offset, ..]: [R; PARAMETER_COUNT],
    ) -> Self {
        Self::new(HairParameters { absorption: [r, g, b], eta, beta_m, beta_n, tilt, offset })
    }
}

/// Builds the BSDF of coated surfaces from their parameters, with the weights of its walks.
#[inline(always)]
pub(super) fn coated<R: Real<Scalar = f32>, B: FromParameters<R>>(
    parameters: [R; PARAMETER_COUNT],
    weights: MisWeights,
) -> Coated<R, B> {
    let mut coat = [R::splat(0.0); COAT_PARAMETER_COUNT];
    coat.copy_from_slice(&parameters[BASE_PARAMETER_COUNT..]);
    let [along, across, eta, thickness, r, g, b, asymmetry, max_depth, samples] = coat;
    let layer = CoatLayer {
        interface: Dielectric::new([along, across], eta),
        thickness,
        albedo: [r, g, b],
        g: asymmetry,
        max_depth,
        samples,
        weights,
    };
    Coated::new(layer, B::from_parameters(parameters))
}

/// Returns the approximate share of light that a surface reflects or transmits, by channel.
pub fn albedo(scene: &Scene, footprint: &PixelFootprint, ray: Ray, hit: Hit) -> [f32; 3] {
    let context = ShadingContext::of_hit(scene, footprint, &ray, &hit);
    let shape = &scene.shapes[hit.shape as usize];
    let again = || ShadingContext::of_hit(scene, footprint, &ray, &hit);
    let (material, _) = resolve_mixture(scene, shape.material, || ray, again);
    match &scene.materials[material as usize].model {
        MaterialModel::Diffuse { reflectance }
        | MaterialModel::CoatedDiffuse { reflectance, .. } => {
            clamp_to_unit(context.colour(reflectance))
        }
        MaterialModel::MetallicRoughness(surface) => {
            clamp_to_unit(context.colour(&surface.base_colour))
        }
        MaterialModel::DiffuseTransmission { reflectance, transmittance, scale } => {
            let [r, t] = [reflectance, transmittance].map(|texture| context.colour(texture));
            clamp_to_unit([0, 1, 2].map(|c| (r[c] + t[c]) * scale))
        }
        MaterialModel::Conductor { metal, roughness }
        | MaterialModel::CoatedConductor { metal, roughness, .. } => {
            let [_, _, r, g, b, kr, kg, kb, tr, tg, tb] = conductor(metal, roughness, &context);
            let (eta, k, tint) = ([r, g, b], [kr, kg, kb], [tr, tg, tb]);
            [0, 1, 2].map(|c| conductor_reflectance(1.0, eta[c], k[c]) * tint[c])
        }
        MaterialModel::Measured(surface) => clamp_to_unit(Measured { surface }.albedo()),
        MaterialModel::Hair(fibre) => hair_albedo(fibre, &context),
        MaterialModel::ThinDielectric { tint, .. }
        | MaterialModel::TintedDielectric { tint, .. } => clamp_to_unit(context.colour(tint)),
        MaterialModel::Subsurface { .. }
        | MaterialModel::Dielectric { .. }
        | MaterialModel::Interface
        | MaterialModel::Mix { .. } => [1.0; 3],
    }
}
