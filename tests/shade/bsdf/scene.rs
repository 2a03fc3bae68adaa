//! Shared test data: random numbers, directions, and one surface of each kind.

use petzval_base::lanes::{Real, f32x8};
use petzval_render::shade::bsdf::{
    Bsdf, Conductor, Dielectric, Diffuse, DiffuseTransmission, Hair, HairParameters,
    MetallicRoughness, MetallicRoughnessParameters, ThinDielectric, TintedDielectric,
    dielectric_f0,
};

/// The PCG of O'Neill 2014, a different generator from the program's.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(2_862_933_555_777_941_757).wrapping_add(3_037_000_493))
    }

    pub fn bits(&mut self) -> u32 {
        let old = self.0;
        self.0 =
            old.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let word = (((old >> 18) ^ old) >> 27) as u32;
        word.rotate_right((old >> 59) as u32)
    }

    /// Returns a number in [0, 1).
    pub fn number(&mut self) -> f32 {
        (self.bits() >> 8) as f32 / 16_777_216.0
    }

    pub fn eight(&mut self) -> f32x8 {
        f32x8::load(&[(); 8].map(|()| self.number()))
    }

    /// Returns a direction of the upper hemisphere, uniform by solid angle.
    pub fn direction(&mut self) -> [f32; 3] {
        let cos = f64::from(self.number()).max(1e-3);
        direction(cos, 2.0 * std::f64::consts::PI * f64::from(self.number()))
    }
}

/// Returns the unit vector with this cosine and azimuth (rad).
pub fn direction(cos: f64, phi: f64) -> [f32; 3] {
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    [(sin * phi.cos()) as f32, (sin * phi.sin()) as f32, cos as f32]
}

pub fn splat<R: Real<Scalar = f32>, const N: usize>(v: [f32; N]) -> [R; N] {
    v.map(R::splat)
}

/// A kind of surface.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    Diffuse,
    DiffuseTransmission,
    /// Alphas along x and y.
    Conductor([f32; 2]),
    /// A perfect mirror, which loses light by shadowing only.
    Mirror([f32; 2]),
    /// Alphas along x and y, and refractive index.
    Dielectric([f32; 2], f32),
    /// Refractive index and tint.
    Thin(f32, [f32; 3]),
    /// Base colour, alpha, and refractive index.
    Plastic([f32; 3], f32, f32),
    /// Base colour, alpha, share of metal, and alpha and coverage of the coat.
    Coated([f32; 3], f32, f32, f32, f32),
    Hair(HairParameters<f32>),
    /// Alpha, share of metal, and strength and colour of the plastic's reflection.
    Specular(f32, f32, f32, [f32; 3]),
    /// Alpha, refractive index and tint.
    Tinted(f32, f32, [f32; 3]),
}

pub const REFLECTANCE: [f32; 3] = [0.2, 0.5, 0.8];
pub const TRANSMITTANCE: [f32; 3] = [0.3, 0.1, 0.05];
/// Approximate index of copper at 630, 532 and 465 nm.
pub const ETA: [f32; 3] = [0.2, 1.12, 1.16];
pub const K: [f32; 3] = [3.58, 2.59, 2.42];

/// Returns a surface of alpha, share of metal, index, and alpha and coverage of the coat.
fn metallic_roughness<R: Real<Scalar = f32>>(
    base: [f32; 3],
    numbers: [f32; 5],
) -> Box<dyn Bsdf<R>> {
    specular_surface(base, numbers, 1.0, [1.0; 3])
}

/// As [`metallic_roughness`], with the strength and the colour of the plastic's reflection.
fn specular_surface<R: Real<Scalar = f32>>(
    base: [f32; 3],
    numbers: [f32; 5],
    specular: f32,
    colour: [f32; 3],
) -> Box<dyn Bsdf<R>> {
    let [alpha, metallic, eta, coat_alpha, coverage] = numbers.map(R::splat);
    let (base, specular) = (splat(base), R::splat(specular));
    let f0 = splat(colour).map(|channel: R| channel * dielectric_f0(eta));
    let parameters =
        MetallicRoughnessParameters { alpha, base, metallic, f0, specular, coat_alpha, coverage };
    Box::new(MetallicRoughness::new(parameters))
}

impl Kind {
    pub fn build<R: Real<Scalar = f32>>(self) -> Box<dyn Bsdf<R>> {
        match self {
            Self::Diffuse => Box::new(Diffuse { reflectance: splat(REFLECTANCE) }),
            Self::DiffuseTransmission => Box::new(DiffuseTransmission {
                reflectance: splat(REFLECTANCE),
                transmittance: splat(TRANSMITTANCE),
            }),
            Self::Conductor(alpha) => Box::new(Conductor::new(splat(alpha), splat(ETA), splat(K))),
            Self::Mirror(alpha) => {
                Box::new(Conductor::new(splat(alpha), splat([1.0; 3]), splat([1e7; 3])))
            }
            Self::Dielectric(alpha, eta) => Box::new(Dielectric::new(splat(alpha), R::splat(eta))),
            Self::Thin(eta, tint) => {
                Box::new(ThinDielectric::new(splat([eta; 3])).tinted(splat(tint)))
            }
            Self::Plastic(base, alpha, eta) => {
                metallic_roughness(base, [alpha, 0.0, eta, 0.0, 0.0])
            }
            Self::Coated(base, alpha, metallic, coat_alpha, coverage) => {
                metallic_roughness(base, [alpha, metallic, 1.5, coat_alpha, coverage])
            }
            Self::Specular(alpha, metallic, strength, colour) => {
                let numbers = [alpha, metallic, 1.5, 0.0, 0.0];
                specular_surface(REFLECTANCE, numbers, strength, colour)
            }
            Self::Tinted(alpha, eta, tint) => Box::new(TintedDielectric {
                interface: Dielectric::new(splat([alpha; 2]), R::splat(eta)),
                tint: splat(tint),
            }),
            Self::Hair(hair) => Box::new(Hair::new(HairParameters {
                absorption: splat(hair.absorption),
                eta: R::splat(hair.eta),
                beta_m: R::splat(hair.beta_m),
                beta_n: R::splat(hair.beta_n),
                tilt: R::splat(hair.tilt),
                offset: R::splat(hair.offset),
            })),
        }
    }

    /// Returns the index beyond the surface over that on the side of `wo`.
    pub fn ratio(self, wo: [f32; 3]) -> f32 {
        match self {
            Self::Dielectric(_, eta) if wo[2] < 0.0 => 1.0 / eta,
            Self::Dielectric(_, eta) => eta,
            Self::Tinted(_, eta, _) if wo[2] < 0.0 => 1.0 / eta,
            Self::Tinted(_, eta, _) => eta,
            _ => 1.0,
        }
    }
}
