//! Kinds of materials: the parameters that each reads, and their defaults, as in pbrt-v4. Each kind
//! of pbrt-v2 and v3 becomes the most similar kind of v4.

use std::sync::Arc;

use super::SceneError;
use super::attributes::Target;
use super::directive_kinds::{Directive, Ignored, SILENT, known, unsupported};
use super::material_builder::{KD_SUBSURFACE, MaterialBuilder, SUBSURFACE};
use MaterialKind::{Mix, Model};
use petzval_scene::{MaterialModel, Metal, Roughness, Texture};

/// How a kind of material is read.
#[derive(Clone, Copy)]
pub(super) enum MaterialKind {
    /// By its parameters.
    Model(fn(&mut MaterialBuilder) -> Result<MaterialModel, SceneError>),
    /// As a choice between two other materials.
    Mix,
}

const UNSUPPORTED: &str = "a diffuse surface of its reflectance, Kd or color, or of 0.5, is used";
const LAMBERTIAN: &[Ignored] = &[("sigma", "the surface is Lambertian")];
const ROUGH_METAL: &[&str] =
    &["eta", "k", "reflectance", "roughness", "uroughness", "vroughness", "remaproughness"];
/// Parameters of pbrt-v2 and v3 that the most similar kind of v4 does not have.
const OLD_IGNORES: &[Ignored] = &[
    ("Ks", SILENT),
    ("Kr", SILENT),
    ("Kt", SILENT),
    ("roughness", SILENT),
    ("remaproughness", SILENT),
    ("opacity", "the surface is opaque"),
];
const PLASTIC: &[&str] =
    &["Kd", "roughness", "uroughness", "vroughness", "remaproughness", "eta", "index"];

pub(super) static MATERIAL: Directive<MaterialKind> = Directive {
    name: "Material",
    target: Some(Target::Material),
    shared: &["displacement", "bumpmap", "normalmap"],
    kinds: &[
        known("", Model(|_| Ok(MaterialModel::Interface)), &[], &[]),
        known("none", Model(|_| Ok(MaterialModel::Interface)), &[], &[]),
        known("interface", Model(|_| Ok(MaterialModel::Interface)), &[], &[]),
        known(
            "diffuse",
            Model(|read| diffuse(read, "reflectance", 0.5)),
            &["reflectance"],
            LAMBERTIAN,
        ),
        known(
            "coateddiffuse",
            Model(|read| coated_diffuse(read, "reflectance", 0.5, &["eta"], 0.0)),
            &[
                "reflectance",
                "roughness",
                "uroughness",
                "vroughness",
                "remaproughness",
                "thickness",
                "eta",
                "albedo",
                "g",
                "maxdepth",
                "nsamples",
            ],
            &[("twosided", SILENT)],
        ),
        known("conductor", Model(|read| metal(read, 0.0)), ROUGH_METAL, &[]),
        known(
            "coatedconductor",
            Model(coated_conductor),
            &[
                "interface.roughness",
                "interface.uroughness",
                "interface.vroughness",
                "interface.eta",
                "thickness",
                "albedo",
                "g",
                "conductor.eta",
                "conductor.k",
                "reflectance",
                "conductor.roughness",
                "conductor.uroughness",
                "conductor.vroughness",
                "remaproughness",
                "maxdepth",
                "nsamples",
            ],
            &[],
        ),
        known(
            "dielectric",
            Model(|read| dielectric(read, &["eta"])),
            &["eta", "roughness", "uroughness", "vroughness", "remaproughness"],
            &[],
        ),
        known("thindielectric", Model(thin_dielectric), &["eta"], &[]),
        known(
            "diffusetransmission",
            Model(diffuse_transmission),
            &["reflectance", "transmittance", "scale"],
            LAMBERTIAN,
        ),
        known("mix", Mix, &["materials", "namedmaterial1", "namedmaterial2", "amount"], &[]),
        known(
            "subsurface",
            Model(|read| read.subsurface(SUBSURFACE)),
            &[
                "sigma_a",
                "sigma_s",
                "reflectance",
                "mfp",
                "name",
                "scale",
                "g",
                "eta",
                "roughness",
                "uroughness",
                "vroughness",
                "remaproughness",
            ],
            &[],
        ),
        known(
            "hair",
            Model(|read| Ok(MaterialModel::Hair(Box::new(read.hair()?)))),
            &[
                "sigma_a",
                "reflectance",
                "color",
                "eumelanin",
                "pheomelanin",
                "eta",
                "beta_m",
                "beta_n",
                "alpha",
            ],
            &[],
        ),
        known("measured", Model(|read| read.measured()), &["filename"], &[]),
        known("matte", Model(|read| diffuse(read, "Kd", 0.5)), &["Kd"], LAMBERTIAN),
        known("plastic", Model(plastic), PLASTIC, OLD_IGNORES),
        known("uber", Model(plastic), PLASTIC, OLD_IGNORES),
        known(
            "substrate",
            Model(|read| coated_diffuse(read, "Kd", 0.5, &[], 0.1)),
            PLASTIC,
            OLD_IGNORES,
        ),
        known(
            "glass",
            Model(|read| dielectric(read, &["eta", "index"])),
            &["eta", "index", "roughness", "uroughness", "vroughness", "remaproughness"],
            OLD_IGNORES,
        ),
        known("metal", Model(|read| metal(read, 0.01)), ROUGH_METAL, OLD_IGNORES),
        known("mirror", Model(mirror), &["Kr"], OLD_IGNORES),
        known(
            "shinymetal",
            Model(shiny_metal),
            &["Kr", "roughness", "uroughness", "vroughness", "remaproughness"],
            OLD_IGNORES,
        ),
        known("translucent", Model(translucent), &["Kd", "reflect", "transmit"], OLD_IGNORES),
        unsupported("disney", UNSUPPORTED),
        unsupported("fourier", UNSUPPORTED),
        known(
            "kdsubsurface",
            Model(|read| read.subsurface(KD_SUBSURFACE)),
            &[
                "Kd",
                "mfp",
                "meanfreepath",
                "scale",
                "g",
                "eta",
                "index",
                "roughness",
                "uroughness",
                "vroughness",
                "remaproughness",
            ],
            OLD_IGNORES,
        ),
    ],
};

type Read = Result<MaterialModel, SceneError>;

fn diffuse(read: &mut MaterialBuilder, name: &str, default: f32) -> Read {
    Ok(MaterialModel::Diffuse { reflectance: read.colour(name, default)? })
}

fn diffuse_transmission(read: &mut MaterialBuilder) -> Read {
    Ok(MaterialModel::DiffuseTransmission {
        reflectance: read.colour("reflectance", 0.25)?,
        transmittance: read.colour("transmittance", 0.25)?,
        scale: read.params.float("scale", 1.0)? as f32,
    })
}

fn translucent(read: &mut MaterialBuilder) -> Read {
    let kd = Arc::new(read.colour("Kd", 0.25)?);
    let mut fraction = |name: &str| {
        let fraction = Arc::new(read.colour(name, 0.5)?);
        Ok::<_, SceneError>(Texture::Scale(kd.clone(), fraction))
    };
    Ok(MaterialModel::DiffuseTransmission {
        reflectance: fraction("reflect")?,
        transmittance: fraction("transmit")?,
        scale: 1.0,
    })
}

/// Reads a metal, whose roughness has a default.
fn metal(read: &mut MaterialBuilder, roughness: f32) -> Read {
    let metal = read.metal("eta", "k")?;
    Ok(MaterialModel::Conductor { metal, roughness: read.roughness("", roughness)? })
}

fn mirror(read: &mut MaterialBuilder) -> Read {
    let metal = Metal::Reflectance(read.colour("Kr", 0.9)?);
    Ok(MaterialModel::Conductor { metal, roughness: Roughness::smooth() })
}

fn shiny_metal(read: &mut MaterialBuilder) -> Read {
    let metal = Metal::Reflectance(read.colour("Kr", 1.0)?);
    Ok(MaterialModel::Conductor { metal, roughness: read.roughness("", 0.1)? })
}

/// Reads an interface, whose refractive index has one of these names.
fn dielectric(read: &mut MaterialBuilder, eta: &[&str]) -> Read {
    let (eta, dispersion) = read.index(eta)?;
    Ok(MaterialModel::Dielectric { eta, dispersion, roughness: read.roughness("", 0.0)? })
}

fn thin_dielectric(read: &mut MaterialBuilder) -> Read {
    let tint = Texture::Constant([1.0; 3]);
    let (eta, dispersion) = read.index(&["eta"])?;
    Ok(MaterialModel::ThinDielectric { eta: [eta; 3], dispersion, tint })
}

/// Reads a coated surface, given the name and the default of its reflectance, the names of the
/// refractive index of the coat, and the default of its roughness.
fn coated_diffuse(
    read: &mut MaterialBuilder,
    name: &str,
    default: f32,
    eta: &[&str],
    roughness: f32,
) -> Read {
    let reflectance = read.colour(name, default)?;
    Ok(MaterialModel::CoatedDiffuse { reflectance, coat: read.coat("", eta, roughness)? })
}

fn plastic(read: &mut MaterialBuilder) -> Read {
    match read.is_black("Ks") {
        true => diffuse(read, "Kd", 0.25),
        false => coated_diffuse(read, "Kd", 0.25, &["eta", "index"], 0.1),
    }
}

fn coated_conductor(read: &mut MaterialBuilder) -> Read {
    Ok(MaterialModel::CoatedConductor {
        metal: read.metal("conductor.eta", "conductor.k")?,
        roughness: read.roughness("conductor.", 0.0)?,
        coat: read.coat("interface.", &["interface.eta"], 0.0)?,
    })
}
