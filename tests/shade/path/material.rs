//! Naive BSDFs from textbooks, in f64. Directions are in the shading frame; values include the
//! cosine of `wi`.

use std::f64::consts::PI;

use glam::DVec3;
use petzval_render::shade::bsdf::{CoatLayer, Coated, Dielectric, Diffuse, MisWeights};

use super::matter::Matter;
use crate::support::Random;

pub type Colour = [f64; 3];

/// Material of a shape.
#[derive(Clone, Debug)]
pub enum NaiveMaterial {
    Diffuse(Colour),
    /// Diffuse, in two colours of a checkerboard with squares of 1/4 in u and v; the first colour
    /// is at (0, 0).
    Checkerboard(Colour, Colour),
    /// Reflectance and transmittance.
    DiffuseTransmission(Colour, Colour),
    Metal {
        alpha: f64,
        eta: Colour,
        k: Colour,
    },
    Glass {
        alpha: f64,
        eta: f64,
    },
    ThinSheet(f64),
    /// Diffuse under a clear coat of index 1.5.
    Coated {
        alpha: f64,
        reflectance: Colour,
    },
    /// A mixture, of which the second has this probability.
    Mix(f64, Box<[NaiveMaterial; 2]>),
    /// Separates media and does nothing else.
    Interface,
    /// Smooth glass of this index over a medium, of which the inside of the surface reflects diffusely.
    Below(f64, Box<Matter>),
    /// Bump mapped with a height that is linear in u and v, with these slopes.
    Bumped([f64; 2], Box<NaiveMaterial>),
}

pub fn by(colour: Colour, factor: f64) -> Colour {
    colour.map(|c| c * factor)
}

pub fn cosine(random: &mut Random) -> DVec3 {
    let (r, phi) = (random.next().sqrt(), 2.0 * PI * random.next());
    DVec3::new(r * phi.cos(), r * phi.sin(), (1.0 - r * r).max(0.0).sqrt())
}

/// Returns the Fresnel reflectance for unpolarised light; `eta` is the index beyond over that
/// before.
pub fn fresnel(cos: f64, eta: f64) -> f64 {
    let sin2 = (1.0 - cos * cos) / (eta * eta);
    if sin2 >= 1.0 {
        return 1.0;
    }
    let beyond = (1.0 - sin2).sqrt();
    let s = (cos - eta * beyond) / (cos + eta * beyond);
    let p = (eta * cos - beyond) / (eta * cos + beyond);
    (s * s + p * p) / 2.0
}

/// Returns the Fresnel reflectance of a metal of index eta + i k, by complex arithmetic.
fn fresnel_metal(cos: f64, eta: f64, k: f64) -> f64 {
    type C = (f64, f64);
    let mul = |a: C, b: C| (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0);
    let sub = |a: C, b: C| (a.0 - b.0, a.1 - b.1);
    let add = |a: C, b: C| (a.0 + b.0, a.1 + b.1);
    let norm = |a: C| a.0 * a.0 + a.1 * a.1;
    let n = (eta, k);
    let (n2, sin2) = (mul(n, n), 1.0 - cos * cos);
    // n cos t = sqrt(n^2 - sin^2).
    let square = (n2.0 - sin2, n2.1);
    let size = norm(square).sqrt().sqrt();
    let angle = square.1.atan2(square.0) / 2.0;
    let root = (size * angle.cos(), size * angle.sin());
    let s = norm(sub((cos, 0.0), root)) / norm(add((cos, 0.0), root));
    let dense = (n2.0 * cos, n2.1 * cos);
    let p = norm(sub(dense, root)) / norm(add(dense, root));
    (s + p) / 2.0
}

/// Returns D of Trowbridge & Reitz.
fn distribution(alpha: f64, m: DVec3) -> f64 {
    let a2 = alpha * alpha;
    let cos2 = m.z * m.z;
    a2 / (PI * (cos2 * (a2 - 1.0) + 1.0).powi(2))
}

/// Returns Smith's Lambda.
fn lambda(alpha: f64, w: DVec3) -> f64 {
    let tan2 = (1.0 - w.z * w.z) / (w.z * w.z);
    ((1.0 + alpha * alpha * tan2).sqrt() - 1.0) / 2.0
}

fn shadowing(alpha: f64, wo: DVec3, wi: DVec3) -> f64 {
    1.0 / (1.0 + lambda(alpha, wo) + lambda(alpha, wi))
}

/// Returns f |cos wi| of rough glass for radiance (Walter et al. 2007, eqs. 20 and 21).
fn rough_glass(alpha: f64, eta: f64, wo: DVec3, wi: DVec3) -> f64 {
    let (before, beyond) = if wo.z > 0.0 { (1.0, eta) } else { (eta, 1.0) };
    let g = shadowing(alpha, wo, wi);
    if wo.z * wi.z > 0.0 {
        let m = (wo + wi).normalize();
        let f = fresnel(wo.dot(m).abs(), beyond / before);
        return distribution(alpha, m) * g * f / (4.0 * wo.z.abs());
    }
    let m = (wo * before + wi * beyond).normalize();
    let m = if m.dot(wo) < 0.0 { -m } else { m };
    let (o, i) = (wo.dot(m), wi.dot(m));
    if i >= 0.0 || m.z * wo.z <= 0.0 {
        return 0.0;
    }
    let passed = 1.0 - fresnel(o, beyond / before);
    let bent = (beyond * i + before * o).powi(2);
    i.abs() * o * before * before * passed * g * distribution(alpha, m) / (wo.z.abs() * bent)
}

fn coated(alpha: f64, reflectance: Colour) -> Coated<f32, Diffuse<f32>> {
    let layer = CoatLayer {
        interface: Dielectric::new([alpha as f32; 2], 1.5),
        thickness: 0.01,
        albedo: [0.0; 3],
        g: 0.0,
        max_depth: 10.0,
        samples: 1.0,
        weights: MisWeights::default(),
    };
    Coated::new(layer, Diffuse { reflectance: reflectance.map(|c| c as f32) })
}

impl NaiveMaterial {
    /// Returns f |cos wi|, without singular lobes.
    pub fn value(&self, wo: DVec3, wi: DVec3, random: &mut Random) -> Colour {
        let same = wo.z * wi.z > 0.0;
        match self {
            Self::Diffuse(r) if same => by(*r, wi.z.abs() / PI),
            Self::DiffuseTransmission(r, t) => by(if same { *r } else { *t }, wi.z.abs() / PI),
            Self::Metal { alpha, eta, k } if same && *alpha > 0.0 => {
                let m = (wo + wi).normalize();
                let facets = distribution(*alpha, m) * shadowing(*alpha, wo, wi);
                let cos = wo.dot(m).abs();
                [0, 1, 2].map(|c| facets * fresnel_metal(cos, eta[c], k[c]) / (4.0 * wo.z.abs()))
            }
            Self::Glass { alpha, eta } if *alpha > 0.0 => [rough_glass(*alpha, *eta, wo, wi); 3],
            Self::Coated { alpha, reflectance } if same => {
                let seed = (random.next() * 4e9) as u32;
                let to_f32 = |w: DVec3| w.as_vec3().normalize().to_array();
                let value = coated(*alpha, *reflectance).value(to_f32(wo), to_f32(wi), seed);
                value.map(f64::from)
            }
            _ => [0.0; 3],
        }
    }

    /// Samples a direction and returns it with its weight. Only glass is importance sampled.
    pub fn sample(&self, wo: DVec3, random: &mut Random) -> Option<(DVec3, Colour)> {
        let side = wo.z.signum();
        let mirrored = DVec3::new(-wo.x, -wo.y, wo.z);
        let scattered = |both: bool, random: &mut Random| {
            let w = cosine(random);
            let side = if both && random.next() < 0.5 { -side } else { side };
            let wi = DVec3::new(w.x, w.y, w.z * side);
            let area = if both { 2.0 * PI } else { PI };
            (wi, by(self.value(wo, wi, random), area / w.z.max(1e-12)))
        };
        Some(match self {
            Self::Metal { alpha, eta, k } if *alpha == 0.0 => {
                (mirrored, [0, 1, 2].map(|c| fresnel_metal(wo.z.abs(), eta[c], k[c])))
            }
            Self::Glass { alpha, eta } => {
                // Walter et al. 2007, eqs. 35, 36, 39, 40 and 41; m is the normal if alpha = 0.
                let (share, phi) = (random.next(), 2.0 * PI * random.next());
                let tan = alpha * (share / (1.0 - share)).sqrt();
                let m = DVec3::new(tan * phi.cos(), tan * phi.sin(), 1.0).normalize() * side;
                let cos = wo.dot(m);
                if cos <= 0.0 {
                    return None;
                }
                let ratio = if wo.z > 0.0 { *eta } else { 1.0 / eta };
                let (wi, radiance_scale) = if random.next() < fresnel(cos, ratio) {
                    (m * (2.0 * cos) - wo, 1.0)
                } else {
                    let across = (m * cos - wo) / ratio;
                    let along = (1.0 - across.length_squared()).max(0.0).sqrt();
                    (across - m * along, ratio * ratio)
                };
                let reflects = wi.dot(m) > 0.0;
                if reflects != (wi.z * wo.z > 0.0) {
                    return None;
                }
                let weight = shadowing(*alpha, wo, wi) * cos / (wo.z * m.z).abs();
                (wi, [weight / radiance_scale; 3])
            }
            Self::ThinSheet(eta) => {
                // Sum over the first twenty reflections between the two sides.
                let once = fresnel(wo.z.abs(), *eta);
                let inside = (0..20).map(|n| (1.0 - once).powi(2) * once.powi(2 * n + 1));
                let back = once + inside.sum::<f64>();
                (if random.next() < back { mirrored } else { -wo }, [1.0; 3])
            }
            Self::Coated { alpha, .. } if *alpha == 0.0 => {
                if random.next() < 0.5 {
                    (mirrored, [2.0 * fresnel(wo.z.abs(), 1.5); 3])
                } else {
                    let (wi, weight) = scattered(false, random);
                    (wi, by(weight, 2.0))
                }
            }
            Self::DiffuseTransmission(..) => scattered(true, random),
            _ => scattered(false, random),
        })
    }
}
