//! The kinds of surfaces that are shaded together, and the numbers that each needs.

use glam::Vec3;

use super::bsdf::{
    Bsdf, Coated, Conductor, Dielectric, Diffuse, DiffuseTransmission, Layer, Microfacets, Weights,
    conductor_reflectance,
};
use super::footprint::Beam;
use super::look::Look;
use crate::lanes::Real;
use crate::rays::{Hit, Ray};
use crate::scene::{Coat, Material, Metal, Roughness, Scatters, Scene, SurfacePoint};
use crate::spectrum::ChannelMetal;

/// Surfaces of one kind are shaded together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum Kind {
    Diffuse,
    DiffuseTransmission,
    Conductor,
    Dielectric,
    ThinDielectric,
    CoatedDiffuse,
    CoatedConductor,
    /// Not shaded at all.
    Interface,
}

/// How many kinds are shaded.
pub(super) const KINDS: usize = Kind::Interface as usize;

impl Kind {
    pub(super) const ALL: [Self; KINDS] = [
        Self::Diffuse,
        Self::DiffuseTransmission,
        Self::Conductor,
        Self::Dielectric,
        Self::ThinDielectric,
        Self::CoatedDiffuse,
        Self::CoatedConductor,
    ];

    /// Whether it is a random walk, for one lane.
    pub(super) fn coated(self) -> bool {
        matches!(self, Self::CoatedDiffuse | Self::CoatedConductor)
    }

    /// Whether light from a light can never be scattered, by the first numbers of a surface.
    pub(super) fn singular(self, alpha: [f32; 2]) -> bool {
        match self {
            Self::ThinDielectric => true,
            Self::Conductor | Self::Dielectric => Microfacets::new(alpha).smooth,
            _ => false,
        }
    }

    fn of(scatters: &Scatters) -> Option<Self> {
        Some(match scatters {
            Scatters::Interface => Self::Interface,
            Scatters::Diffuse { .. } => Self::Diffuse,
            Scatters::DiffuseTransmission { .. } => Self::DiffuseTransmission,
            Scatters::Conductor { .. } => Self::Conductor,
            Scatters::Dielectric { .. } => Self::Dielectric,
            Scatters::ThinDielectric { .. } => Self::ThinDielectric,
            Scatters::CoatedDiffuse { .. } => Self::CoatedDiffuse,
            Scatters::CoatedConductor { .. } => Self::CoatedConductor,
            Scatters::Mix { .. } => return None,
        })
    }
}

/// The material of a surface, after the dice of mixtures have been thrown, and its kind. `look`
/// is asked for only where there is a mixture.
pub(super) fn resolve<'a>(
    scene: &'a Scene,
    material: u32,
    look: impl Fn() -> Look<'a>,
) -> (u32, Kind) {
    let mut index = material;
    // Mixtures are made of materials made before them, so this ends.
    loop {
        let scatters = &scene.materials[index as usize].scatters;
        if let Some(kind) = Kind::of(scatters) {
            return (index, kind);
        }
        if let Scatters::Mix { materials, amount } = scatters {
            let look = look();
            let second = look.chance(index) < look.number(amount);
            index = materials[usize::from(second)];
        }
    }
}

/// Most numbers that a kind without a coat needs.
pub(super) const NUMBERS: usize = 11;

/// The numbers of a surface without a coat.
pub(super) fn numbers(material: &Material, look: &Look) -> [f32; NUMBERS] {
    let mut numbers = [0.0; NUMBERS];
    let mut put = |place: usize, values: &[f32]| {
        numbers[place..place + values.len()].copy_from_slice(values);
    };
    match &material.scatters {
        Scatters::Diffuse { reflectance } => put(0, &share(look.colour(reflectance))),
        Scatters::DiffuseTransmission { reflectance, transmittance, scale } => {
            put(0, &share(look.colour(reflectance).map(|c| c * scale)));
            put(3, &share(look.colour(transmittance).map(|c| c * scale)));
        }
        Scatters::Conductor { metal, roughness } => {
            put(0, &alpha(roughness, look));
            let ChannelMetal { eta, k, tint } = index(metal, look);
            put(2, &eta);
            put(5, &k);
            put(8, &tint);
        }
        Scatters::Dielectric { eta, roughness } => {
            put(0, &alpha(roughness, look));
            put(2, &[*eta]);
        }
        Scatters::ThinDielectric { eta } => put(0, &[*eta]),
        _ => {}
    }
    numbers
}

/// A varnished diffuse surface.
pub(super) fn coated_diffuse(material: &Material, look: &Look) -> Option<Coated<Diffuse<f32>>> {
    let Scatters::CoatedDiffuse { reflectance, coat } = &material.scatters else { return None };
    let base = Diffuse { reflectance: share(look.colour(reflectance)) };
    Some(Coated::new(layer(coat, look), base))
}

/// A varnished metal.
pub(super) fn coated_conductor(material: &Material, look: &Look) -> Option<Coated<Conductor<f32>>> {
    let Scatters::CoatedConductor { metal, roughness, coat } = &material.scatters else {
        return None;
    };
    let under = |index: [f32; 3]| index.map(|n| n / coat.eta);
    let ChannelMetal { eta, k, tint } = index(metal, look);
    let base = Conductor::new(alpha(roughness, look), under(eta), under(k)).tinted(tint);
    Some(Coated::new(layer(coat, look), base))
}

fn layer(coat: &Coat, look: &Look) -> Layer {
    Layer {
        border: Dielectric::new(alpha(&coat.roughness, look), coat.eta),
        thickness: look.number(&coat.thickness),
        albedo: share(look.colour(&coat.albedo)),
        g: look.number(&coat.g).clamp(-1.0, 1.0),
        max_depth: coat.max_depth,
        samples: coat.samples,
        weights: Weights::default(),
    }
}

/// Shares of light are from 0 to 1.
fn share(colour: [f32; 3]) -> [f32; 3] {
    colour.map(|c| c.clamp(0.0, 1.0))
}

/// The width of the distribution of slopes along u and v.
fn alpha(roughness: &Roughness, look: &Look) -> [f32; 2] {
    [0, 1].map(|axis| {
        let value = look.number(&roughness.uv[axis]).max(0.0);
        if roughness.remap { value.sqrt() } else { value }
    })
}

/// A metal's numbers at a point.
fn index(metal: &Metal, look: &Look) -> ChannelMetal {
    match metal {
        Metal::Index { eta, k, tint } => {
            ChannelMetal { eta: look.colour(eta), k: look.colour(k), tint: *tint }
        }
        Metal::Reflectance(reflectance) => {
            // Of an index 1 + i k the reflectance at normal incidence is k^2 / (4 + k^2).
            let k = |r: f32| 2.0 * (r / (1.0 - r)).sqrt();
            let k = look.colour(reflectance).map(|r| k(r.clamp(0.0, 0.9999)));
            ChannelMetal { eta: [1.0; 3], k, tint: [1.0; 3] }
        }
    }
}

/// A scattering function from the columns of its numbers.
pub(super) trait FromNumbers<R: Real<Scalar = f32>>: Bsdf<R> {
    fn from_numbers(numbers: [R; NUMBERS]) -> Self;
}

impl<R: Real<Scalar = f32>> FromNumbers<R> for Diffuse<R> {
    #[inline(always)]
    fn from_numbers([r, g, b, ..]: [R; NUMBERS]) -> Self {
        Self { reflectance: [r, g, b] }
    }
}

impl<R: Real<Scalar = f32>> FromNumbers<R> for DiffuseTransmission<R> {
    #[inline(always)]
    fn from_numbers([r, g, b, x, y, z, ..]: [R; NUMBERS]) -> Self {
        Self { reflectance: [r, g, b], transmittance: [x, y, z] }
    }
}

impl<R: Real<Scalar = f32>> FromNumbers<R> for Conductor<R> {
    #[inline(always)]
    fn from_numbers([along, across, r, g, b, x, y, z, tint @ ..]: [R; NUMBERS]) -> Self {
        Self::new([along, across], [r, g, b], [x, y, z]).tinted(tint)
    }
}

impl<R: Real<Scalar = f32>> FromNumbers<R> for Dielectric<R> {
    #[inline(always)]
    fn from_numbers([along, across, eta, ..]: [R; NUMBERS]) -> Self {
        Self::new([along, across], eta)
    }
}

impl<R: Real<Scalar = f32>> FromNumbers<R> for super::bsdf::ThinDielectric<R> {
    #[inline(always)]
    fn from_numbers([eta, ..]: [R; NUMBERS]) -> Self {
        Self::new(eta)
    }
}

/// About which share of light a surface sends back or lets through, by channel.
pub fn albedo(scene: &Scene, beam: &Beam, ray: Ray, hit: Hit, point: SurfacePoint) -> [f32; 3] {
    let look = || Look::at(scene, beam, ray, hit, point);
    let shape = &scene.shapes[hit.shape as usize];
    let (material, _) = resolve(scene, shape.material, look);
    let look = look();
    match &scene.materials[material as usize].scatters {
        Scatters::Diffuse { reflectance } | Scatters::CoatedDiffuse { reflectance, .. } => {
            share(look.colour(reflectance))
        }
        Scatters::DiffuseTransmission { reflectance, transmittance, scale } => {
            let [back, through] = [reflectance, transmittance].map(|t| look.colour(t));
            share([0, 1, 2].map(|c| (back[c] + through[c]) * scale))
        }
        Scatters::Conductor { metal, .. } | Scatters::CoatedConductor { metal, .. } => {
            let ChannelMetal { eta, k, tint } = index(metal, &look);
            [0, 1, 2].map(|c| conductor_reflectance(1.0, eta[c], k[c]) * tint[c])
        }
        _ => [1.0; 3],
    }
}

/// Whether a surface scatters differently along u and across it, so that its frame must follow
/// the texture coordinates.
pub(super) fn turns(material: &Material) -> bool {
    let turns = |roughness: &Roughness| {
        let [along, across] = &roughness.uv;
        !matches!(
            (along, across),
            (crate::scene::Texture::Constant(a), crate::scene::Texture::Constant(b)) if a == b
        )
    };
    match &material.scatters {
        Scatters::Conductor { roughness, .. } | Scatters::Dielectric { roughness, .. } => {
            turns(roughness)
        }
        Scatters::CoatedDiffuse { coat, .. } => turns(&coat.roughness),
        Scatters::CoatedConductor { roughness, coat, .. } => {
            turns(roughness) || turns(&coat.roughness)
        }
        _ => false,
    }
}

/// A frame about a normal where nothing depends on the direction of its tangents.
pub(super) fn any_tangent(normal: Vec3) -> Vec3 {
    normal.any_orthonormal_vector()
}
