//! Kinds of materials: the parameters that each reads, and their defaults, as in pbrt-v4. Each kind
//! of pbrt-v2 and v3 becomes the most similar kind of v4.

use super::attributes::Target;
use super::directive_kinds::{Directive, Ignored, SILENT, known, unsupported};

/// The kinds of materials.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum MaterialKind {
    Interface,
    Diffuse,
    DiffuseTransmission,
    Conductor,
    Dielectric,
    Subsurface,
    ThinDielectric,
    CoatedDiffuse,
    CoatedConductor,
    Measured,
    Hair,
    Mix,
    // Kinds of pbrt-v2 and v3.
    Matte,
    Plastic,
    Substrate,
    Glass,
    Metal,
    Mirror,
    ShinyMetal,
    Translucent,
    KdSubsurface,
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
        known("", MaterialKind::Interface, &[], &[]),
        known("none", MaterialKind::Interface, &[], &[]),
        known("interface", MaterialKind::Interface, &[], &[]),
        known("diffuse", MaterialKind::Diffuse, &["reflectance"], LAMBERTIAN),
        known(
            "coateddiffuse",
            MaterialKind::CoatedDiffuse,
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
        known("conductor", MaterialKind::Conductor, ROUGH_METAL, &[]),
        known(
            "coatedconductor",
            MaterialKind::CoatedConductor,
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
            MaterialKind::Dielectric,
            &["eta", "roughness", "uroughness", "vroughness", "remaproughness"],
            &[],
        ),
        known("thindielectric", MaterialKind::ThinDielectric, &["eta"], &[]),
        known(
            "diffusetransmission",
            MaterialKind::DiffuseTransmission,
            &["reflectance", "transmittance", "scale"],
            LAMBERTIAN,
        ),
        known(
            "mix",
            MaterialKind::Mix,
            &["materials", "namedmaterial1", "namedmaterial2", "amount"],
            &[],
        ),
        known(
            "subsurface",
            MaterialKind::Subsurface,
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
            MaterialKind::Hair,
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
        known("measured", MaterialKind::Measured, &["filename"], &[]),
        known("matte", MaterialKind::Matte, &["Kd"], LAMBERTIAN),
        known("plastic", MaterialKind::Plastic, PLASTIC, OLD_IGNORES),
        known("uber", MaterialKind::Plastic, PLASTIC, OLD_IGNORES),
        known("substrate", MaterialKind::Substrate, PLASTIC, OLD_IGNORES),
        known(
            "glass",
            MaterialKind::Glass,
            &["eta", "index", "roughness", "uroughness", "vroughness", "remaproughness"],
            OLD_IGNORES,
        ),
        known("metal", MaterialKind::Metal, ROUGH_METAL, OLD_IGNORES),
        known("mirror", MaterialKind::Mirror, &["Kr"], OLD_IGNORES),
        known(
            "shinymetal",
            MaterialKind::ShinyMetal,
            &["Kr", "roughness", "uroughness", "vroughness", "remaproughness"],
            OLD_IGNORES,
        ),
        known(
            "translucent",
            MaterialKind::Translucent,
            &["Kd", "reflect", "transmit"],
            OLD_IGNORES,
        ),
        unsupported("disney", UNSUPPORTED),
        unsupported("fourier", UNSUPPORTED),
        known(
            "kdsubsurface",
            MaterialKind::KdSubsurface,
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
