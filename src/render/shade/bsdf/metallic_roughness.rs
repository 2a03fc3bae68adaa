//! The metallic-roughness surface of glTF: a metal or a plastic, below a clear coat.

use super::gloss::mean;
use super::schlick_interface::SchlickInterface;
use super::{
    Bsdf, BsdfSample, CoatWalks, Gloss, SurfaceTextures, VertexParameters, clamp_to_unit, columns,
};
use petzval_base::lanes::Real;
use petzval_base::lanes::vector::{max_component, scale, select};
use petzval_base::sampler::concentric_disk;
use petzval_scene::MaterialModel;

/// Share of light that a clear coat reflects at normal incidence: that of an index of 1.5.
const COAT_F0: f32 = 0.04;

/// A metal, a Lambertian base below a dielectric interface, or a blend of both, below a clear coat;
/// the same from both sides (glTF 2.0, appendix B, KHR_materials_specular and
/// KHR_materials_clearcoat).
///
/// glTF leaves open what light an interface keeps from what is below. Here the base reflects
/// rho / pi (1 - E(wo)) (1 - E(wi)) / (1 - E_mean), where E is the albedo of the interface
/// (Kelemen & Szirmay-Kalos 2001, eq. 8): values are reciprocal, and a white base loses no light.
/// A coat of coverage c passes the share 1 - c E of the direction in which E is larger.
#[derive(Clone, Copy, Debug)]
pub struct MetallicRoughness<R: Real> {
    interface: SchlickInterface<R>,
    /// Share of light that the interface reflects at normal incidence, by colour channel.
    f0: [R; 3],
    /// That at grazing incidence.
    f90: R,
    /// Largest channel of the dielectric part at normal incidence, over its share at grazing
    /// incidence.
    dielectric_f0: R,
    /// Share that the dielectric part reflects at grazing incidence.
    specular: R,
    /// Share of light that the base reflects, by colour channel.
    reflectance: [R; 3],
    /// 1 / (1 - the mean albedo of the dielectric part).
    scale: R,
    coat: SchlickInterface<R>,
    coverage: R,
}

columns! {
    /// Parameters of a [`MetallicRoughness`].
    #[derive(Clone, Copy, Debug)]
    pub struct MetallicRoughnessParameters<R> {
        /// Width alpha of the microfacets.
        pub alpha: R,
        /// Base colour.
        pub base: [R; 3],
        /// Share of metal.
        pub metallic: R,
        /// Share of light that the dielectric reflects at normal incidence, over `specular`, by colour
        /// channel; see [`dielectric_f0`].
        pub f0: [R; 3],
        /// Strength of the reflection of the dielectric (KHR_materials_specular), 1 for a real one.
        pub specular: R,
        /// Width alpha of the microfacets of the coat.
        pub coat_alpha: R,
        /// Share of the surface that the coat covers.
        pub coverage: R,
    }
}

/// Returns the share of light that a dielectric of this index reflects at normal incidence.
#[inline(always)]
pub fn dielectric_f0<R: Real<Scalar = f32>>(eta: R) -> R {
    let one = R::splat(1.0);
    ((eta - one) / (eta + one)).square().min(one)
}

impl<R: Real<Scalar = f32>> VertexParameters<R> for MetallicRoughnessParameters<R> {
    type Bsdf = MetallicRoughness<R>;
    const NAME: &'static str = "metallicroughness";
    const ONE_SIDED: bool = true;
    const CATCHES_CAUSTICS: bool = true;

    #[inline(always)]
    fn of(model: &MaterialModel, textures: &impl SurfaceTextures<R>) -> Option<Self> {
        let MaterialModel::MetallicRoughness(surface) = model else { return None };
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let share = |texture| textures.number(texture).max(zero).min(one);
        let [alpha, _] = textures.alpha(&surface.roughness);
        let [coat_alpha, _] = textures.alpha(&surface.coat_roughness);
        let f0 = dielectric_f0(R::splat(surface.eta));
        Some(Self {
            alpha,
            base: textures.share(&surface.base_colour),
            metallic: share(&surface.metallic),
            // A colour above 1 reflects more, up to all light.
            f0: clamp_to_unit(scale(textures.colour(&surface.specular_colour), f0)),
            specular: share(&surface.specular),
            coat_alpha,
            coverage: share(&surface.coat_coverage),
        })
    }

    fn albedo(model: &MaterialModel, textures: &impl SurfaceTextures<R>) -> Option<[R; 3]> {
        let MaterialModel::MetallicRoughness(surface) = model else { return None };
        Some(textures.share(&surface.base_colour))
    }

    #[inline(always)]
    fn bsdf(self, _: CoatWalks<R>) -> MetallicRoughness<R> {
        MetallicRoughness::new(self)
    }

    #[inline(always)]
    fn for_each_width(&mut self, mut change: impl FnMut(&mut R)) {
        change(&mut self.alpha);
        change(&mut self.coat_alpha);
    }

    #[inline(always)]
    fn gloss(&self, _: R) -> Option<Gloss<R>> {
        let Self { alpha, base, metallic, f0, specular, .. } = *self;
        let base = mean(base);
        let interface = specular * mean(f0);
        let glossy = interface + metallic * (base - interface);
        Some(Gloss { alpha: [alpha; 2], glossy, wide: (R::splat(1.0) - metallic) * base })
    }
}

/// What evaluation and sampling need to know about a direction `wo`.
#[derive(Clone, Copy)]
struct Lobes<R> {
    /// Probabilities of sampling the coat, and the coat or the interface.
    choices: [R; 2],
    /// Albedo of the dielectric part of the interface, and of the coat times its coverage.
    albedo: R,
    coat_albedo: R,
}

impl<R: Real<Scalar = f32>> MetallicRoughness<R> {
    /// A surface of these parameters.
    #[inline(always)]
    pub fn new(parameters: MetallicRoughnessParameters<R>) -> Self {
        let MetallicRoughnessParameters { alpha, base, metallic, f0: dielectric, .. } = parameters;
        let MetallicRoughnessParameters { specular, coat_alpha, coverage, .. } = parameters;
        let one = R::splat(1.0);
        let below = one - metallic;
        let interface = SchlickInterface::new(alpha);
        let mut f0 = [one; 3];
        let mut reflectance = [one; 3];
        for channel in 0..3 {
            f0[channel] = metallic.mul_add(base[channel], below * (specular * dielectric[channel]));
            reflectance[channel] = below * base[channel];
        }
        let dielectric_f0 = max_component(dielectric);
        Self {
            interface,
            f0,
            f90: one - below * (one - specular),
            dielectric_f0,
            specular,
            reflectance,
            scale: one / (one - specular * interface.mean_albedo(dielectric_f0)),
            coat: SchlickInterface::new(coat_alpha),
            coverage,
        }
    }

    /// Returns the albedo of the dielectric part, that of the channel that reflects the most: the
    /// base takes its colour from what is left of white light.
    #[inline(always)]
    fn dielectric_albedo(&self, cos: R) -> R {
        self.specular * self.interface.albedo(cos, self.dielectric_f0)
    }

    #[inline(always)]
    fn lobes(&self, wo: [R; 3]) -> Lobes<R> {
        let one = R::splat(1.0);
        let cos = wo[2].abs();
        let albedo = self.dielectric_albedo(cos);
        let mirrored = self.interface.albedo(cos, max_component(self.f0));
        let base = (one - albedo) * max_component(self.reflectance);
        let coat_albedo = self.coverage * self.coat.albedo(cos, R::splat(COAT_F0));
        let below = (one - coat_albedo) * (mirrored + base);
        let sum = coat_albedo + below;
        let coat = coat_albedo / sum;
        let interface = (one - coat_albedo).mul_add(mirrored, coat_albedo) / sum;
        Lobes { choices: [coat, interface], albedo, coat_albedo }
    }

    /// Returns the share of light that the coat passes on its way from `wi` to `wo`.
    #[inline(always)]
    fn passed(&self, lobes: &Lobes<R>, wi: [R; 3]) -> R {
        let other = self.coverage * self.coat.albedo(wi[2].abs(), R::splat(COAT_F0));
        R::splat(1.0) - lobes.coat_albedo.max(other)
    }

    /// Returns f |cos wi| and the density of [`Bsdf::sample`].
    #[inline(always)]
    fn evaluate_lobes(&self, lobes: &Lobes<R>, wo: [R; 3], wi: [R; 3]) -> ([R; 3], R) {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let mirrored = self.interface.reflection(wo, wi);
        let coat = self.coat.reflection(wo, wi);
        let cosine = wi[2].abs() * R::constant(std::f64::consts::FRAC_1_PI);
        let cosine = R::select(zero.lt(wo[2] * wi[2]), cosine, zero);
        let through =
            (one - lobes.albedo) * (one - self.dielectric_albedo(wi[2].abs())) * self.scale;
        let passed = self.passed(lobes, wi);
        let glint = self.coverage * coat.value(R::splat(COAT_F0), one);
        let mut value = [zero; 3];
        for channel in 0..3 {
            let base = self.reflectance[channel] * (through * cosine);
            value[channel] =
                passed.mul_add(mirrored.value(self.f0[channel], self.f90) + base, glint);
        }
        let [first, second] = lobes.choices;
        let pdf = first
            .mul_add(coat.pdf, (second - first).mul_add(mirrored.pdf, (one - second) * cosine));
        (value, pdf)
    }
}

impl<R: Real<Scalar = f32>> Bsdf<R> for MetallicRoughness<R> {
    #[inline(always)]
    fn evaluate(&self, wo: [R; 3], wi: [R; 3]) -> ([R; 3], R) {
        self.evaluate_lobes(&self.lobes(wo), wo, wi)
    }

    #[inline(always)]
    fn sample(&self, wo: [R; 3], u: [R; 2], choice: R) -> BsdfSample<R> {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let lobes = self.lobes(wo);
        let coat = choice.lt(lobes.choices[0]);
        let interface = choice.lt(lobes.choices[1]) & !coat;
        let [x, y] = concentric_disk(u[0], u[1]);
        let z = (one - x.mul_add(x, y * y)).max(zero).sqrt();
        let diffuse = [x, y, R::select(wo[2].lt(zero), -z, z)];
        let mirrored = select(interface, self.interface.sample(wo, u), diffuse);
        let wi = select(coat, self.coat.sample(wo, u), mirrored);
        let coat_glint = coat & self.coat.smooth();
        let interface_glint = interface & self.interface.smooth();
        let singular = coat_glint | interface_glint;
        let (value, pdf) = self.evaluate_lobes(&lobes, wo, wi);
        let valid = zero.lt(wo[2] * wi[2]) & (singular | zero.lt(pdf));
        let inverse = one / R::select(zero.lt(pdf), pdf, one);
        let cos = wo[2].abs();
        let [first, second] = lobes.choices;
        let coat_share = self.coverage * SchlickInterface::fresnel(cos, R::splat(COAT_F0), one)
            / R::select(coat, first, one);
        let inner = self.passed(&lobes, wi) / R::select(interface, second - first, one);
        let mut weight = [zero; 3];
        for channel in 0..3 {
            let inner = inner * SchlickInterface::fresnel(cos, self.f0[channel], self.f90);
            let glint = R::select(coat_glint, coat_share, inner);
            weight[channel] = R::select(singular, glint, value[channel] * inverse);
        }
        BsdfSample { wi, weight, pdf: R::select(singular, zero, pdf), singular, valid, eta2: one }
            .only(valid)
    }

    #[inline(always)]
    fn singular(&self) -> R::Mask {
        let zero = R::splat(0.0);
        let no_base = max_component(self.reflectance).le(zero);
        let no_rough_coat = self.coat.smooth() | self.coverage.le(zero);
        self.interface.smooth() & no_rough_coat & no_base
    }
}
