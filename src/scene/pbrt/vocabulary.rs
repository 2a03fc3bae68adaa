//! The table of what the reader knows: every kind of every directive, with the parameters it
//! reads, those it knows but leaves out, and what it does instead of what it cannot do yet.
//! To teach the reader something, add to the table.

use super::SceneError;
use super::params::{Param, Params};
use crate::source::hint;

/// One kind of a directive, such as `Shape "sphere"`.
pub(super) struct Entry {
    pub(super) directive: &'static str,
    pub(super) name: &'static str,
    /// Parameters that are read.
    reads: &'static [&'static str],
    /// Parameters that are known and left out, with what happens instead.
    leaves: &'static [(&'static str, &'static str)],
    /// What is done in place of the whole thing, where it is known but not supported.
    pub(super) instead: Option<&'static str>,
}

const fn known(
    directive: &'static str,
    name: &'static str,
    reads: &'static [&'static str],
    leaves: &'static [(&'static str, &'static str)],
) -> Entry {
    Entry { directive, name, reads, leaves, instead: None }
}

/// What is read as the kind nearest to it, with a notice that says so.
const fn near(
    directive: &'static str,
    name: &'static str,
    reads: &'static [&'static str],
    leaves: &'static [(&'static str, &'static str)],
    instead: &'static str,
) -> Entry {
    Entry { directive, name, reads, leaves, instead: Some(instead) }
}

const fn later(directive: &'static str, name: &'static str, instead: &'static str) -> Entry {
    Entry { directive, name, reads: &[], leaves: &[], instead: Some(instead) }
}

/// Said of what cannot change the mean of any pixel, and of what pbrt-v4 replaces by the same when it
/// upgrades a scene: nothing.
pub(super) const QUIET: &str = "";
const PATH_INSTEAD: &str = "path is used";
const SHAPE_LATER: &str = "the shape is left out";
const TEXTURE_LATER: &str = "the constant 0.5 is used";
const MATERIAL_LATER: &str =
    "a diffuse surface of its reflectance, Kd or color, or of 0.5, is used";

const UNSHADED: &str = "the surface is left as it is";
const OWN_ORDER: &str = "samples are Owen-scrambled Sobol points";

const FILM: &[&str] = &[
    "xresolution",
    "yresolution",
    "filename",
    "diagonal",
    "cropwindow",
    "pixelbounds",
    "iso",
    "maxcomponentvalue",
    "whitebalance",
];
const FILM_LEAVES: &[(&str, &str)] = &[
    ("sensor", "the sensor is ideal: pixels are linear RGB"),
    ("savefp16", QUIET),
    ("display", QUIET),
    ("scale", "the picture is not scaled"),
    ("coordinatesystem", "layers of geometry are in the camera's frame"),
    ("nbuckets", QUIET),
    ("lambdamin", QUIET),
    ("lambdamax", QUIET),
    ("buckets", QUIET),
];
const SAMPLER: &[&str] = &["pixelsamples", "xsamples", "ysamples", "seed"];
const SAMPLER_LEAVES: &[(&str, &str)] =
    &[("randomization", QUIET), ("jitter", QUIET), ("scramble", QUIET), ("dimensions", QUIET)];
const DEPTH: &[&str] = &["maxdepth", "regularize"];
const FILTER: &[&str] = &["xradius", "yradius", "xwidth", "ywidth"];
const PATH_LEAVES: &[(&str, &str)] = &[
    ("lightsampler", QUIET),
    ("lightsamplestrategy", QUIET),
    ("rrthreshold", QUIET),
    ("strategy", QUIET),
    ("samplebsdf", QUIET),
    ("samplelights", QUIET),
    ("visualizestrategies", QUIET),
    ("visualizeweights", QUIET),
    ("bootstrapsamples", QUIET),
    ("chains", QUIET),
    ("mutationsperpixel", "pixelsamples alone decides"),
    ("largestepprobability", QUIET),
    ("sigma", QUIET),
    ("photonsperiteration", QUIET),
    ("radius", QUIET),
    ("seed", QUIET),
    ("iterations", QUIET),
    ("imagewritefrequency", QUIET),
];
const SHADOW_ALPHA: (&str, &str) = ("shadowalpha", "alpha alone decides");
const MESH_LEAVES: &[(&str, &str)] = &[
    ("S", "tangents follow the texture coordinates"),
    ("faceIndices", QUIET),
    ("emissionfilename", "the light is of one colour"),
    SHADOW_ALPHA,
    ("discarddegenerateUVs", QUIET),
    ("displacement", UNSHADED),
    ("edgelength", UNSHADED),
    ("displacement.edgelength", UNSHADED),
];
const CURVE: &[&str] = &["P", "N", "basis", "degree", "type", "width", "width0", "width1"];
const CURVE_LEAVES: &[(&str, &str)] = &[SHADOW_ALPHA, ("splitdepth", QUIET)];
const LOOP_LEAVES: &[(&str, &str)] = &[SHADOW_ALPHA, ("scheme", QUIET)];
const LAMBERT: &[(&str, &str)] = &[("sigma", "the surface is Lambertian")];
const CONDUCTOR: &[&str] =
    &["eta", "k", "reflectance", "roughness", "uroughness", "vroughness", "remaproughness"];
const DIELECTRIC: &[&str] = &["eta", "roughness", "uroughness", "vroughness", "remaproughness"];
const COATED_DIFFUSE: &[&str] = &[
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
];
const COATED_CONDUCTOR: &[&str] = &[
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
];
const OLD_COATED: &[&str] =
    &["Kd", "roughness", "uroughness", "vroughness", "remaproughness", "eta", "index"];
const OLD_GLASS: &[&str] =
    &["eta", "index", "roughness", "uroughness", "vroughness", "remaproughness"];
const OLD_METAL: &[&str] = &["Kr", "roughness", "uroughness", "vroughness", "remaproughness"];
const OLD_LEAF: &[&str] = &["Kd", "reflect", "transmit"];
/// Parameters of surfaces of pbrt-v2 and v3 that have no place in the surface nearest to them.
const OLD_LEAVES: &[(&str, &str)] = &[
    ("Ks", QUIET),
    ("Kr", QUIET),
    ("Kt", QUIET),
    ("roughness", QUIET),
    ("remaproughness", QUIET),
    ("opacity", "the surface is opaque"),
];

/// Everything the reader knows.
pub(super) const VOCABULARY: &[Entry] = &[
    known("Film", "image", FILM, FILM_LEAVES),
    known("Film", "rgb", FILM, FILM_LEAVES),
    known("Film", "gbuffer", FILM, FILM_LEAVES),
    near("Film", "spectral", FILM, FILM_LEAVES, "film rgb is used"),
    known("Sampler", "lowdiscrepancy", SAMPLER, SAMPLER_LEAVES),
    known("Sampler", "halton", SAMPLER, SAMPLER_LEAVES),
    known("Sampler", "sobol", SAMPLER, SAMPLER_LEAVES),
    known("Sampler", "paddedsobol", SAMPLER, SAMPLER_LEAVES),
    known("Sampler", "zsobol", SAMPLER, SAMPLER_LEAVES),
    known("Sampler", "02sequence", SAMPLER, SAMPLER_LEAVES),
    known("Sampler", "zerotwosequence", SAMPLER, SAMPLER_LEAVES),
    known("Sampler", "pmj02bn", SAMPLER, SAMPLER_LEAVES),
    known("Sampler", "maxmindist", SAMPLER, SAMPLER_LEAVES),
    known("Sampler", "random", SAMPLER, SAMPLER_LEAVES),
    known("Sampler", "independent", SAMPLER, SAMPLER_LEAVES),
    known("Sampler", "stratified", SAMPLER, SAMPLER_LEAVES),
    later("Sampler", "adaptive", OWN_ORDER),
    known("Sampler", "bestcandidate", SAMPLER, SAMPLER_LEAVES),
    known("PixelFilter", "box", FILTER, &[]),
    known(
        "PixelFilter",
        "gaussian",
        &["xradius", "yradius", "xwidth", "ywidth", "sigma", "alpha"],
        &[],
    ),
    known("PixelFilter", "mitchell", &["xradius", "yradius", "xwidth", "ywidth", "B", "C"], &[]),
    known("PixelFilter", "sinc", &["xradius", "yradius", "xwidth", "ywidth", "tau"], &[]),
    known("PixelFilter", "triangle", FILTER, &[]),
    known(
        "Camera",
        "realistic",
        &[
            "specfile",
            "filmdistance",
            "aperture_diameter",
            "filmdiag",
            "hither",
            "yon",
            "shutteropen",
            "shutterclose",
            "shutterramp",
            "shuttercurve",
            "rollingshutter",
            "rollingdirection",
            "lensfile",
            "aperturediameter",
            "focusdistance",
            "aperture",
            "filmshift",
            "filmtilt",
        ],
        &[("simpleweighting", "exposure is always A cos^4 / Z^2")],
    ),
    known(
        "Camera",
        "perspective",
        &[
            "fov",
            "frameaspectratio",
            "screenwindow",
            "lensradius",
            "focaldistance",
            "hither",
            "yon",
            "shutteropen",
            "shutterclose",
            "shutterramp",
            "shuttercurve",
            "rollingshutter",
            "rollingdirection",
        ],
        &[],
    ),
    later("Camera", "orthographic", "a perspective camera of 90 degrees is used"),
    later("Camera", "environment", "a perspective camera of 90 degrees is used"),
    later("Camera", "spherical", "a perspective camera of 90 degrees is used"),
    known("Integrator", "directlighting", DEPTH, PATH_LEAVES),
    known("Integrator", "path", DEPTH, PATH_LEAVES),
    known("Integrator", "volpath", DEPTH, PATH_LEAVES),
    known("Integrator", "simplepath", DEPTH, PATH_LEAVES),
    known("Integrator", "simplevolpath", DEPTH, PATH_LEAVES),
    known("Integrator", "randomwalk", DEPTH, PATH_LEAVES),
    near("Integrator", "lightpath", DEPTH, PATH_LEAVES, PATH_INSTEAD),
    near("Integrator", "bdpt", DEPTH, PATH_LEAVES, PATH_INSTEAD),
    near("Integrator", "mlt", DEPTH, PATH_LEAVES, PATH_INSTEAD),
    near("Integrator", "sppm", DEPTH, PATH_LEAVES, PATH_INSTEAD),
    later("Integrator", "whitted", PATH_INSTEAD),
    later("Integrator", "function", PATH_INSTEAD),
    later("Integrator", "photonmap", PATH_INSTEAD),
    later("Integrator", "exphotonmap", PATH_INSTEAD),
    later("Integrator", "irradiancecache", PATH_INSTEAD),
    later("Integrator", "igi", PATH_INSTEAD),
    later("Integrator", "ambientocclusion", PATH_INSTEAD),
    later("Integrator", "ao", PATH_INSTEAD),
    later("VolumeIntegrator", "emission", QUIET),
    later("VolumeIntegrator", "single", QUIET),
    later("Renderer", "sampler", QUIET),
    later("Renderer", "metropolis", "there is one renderer"),
    later("Accelerator", "bvh", QUIET),
    later("Accelerator", "kdtree", QUIET),
    later("Accelerator", "grid", QUIET),
    known(
        "LightSource",
        "infinite",
        &["L", "scale", "filename", "mapname", "illuminance"],
        &[("nsamples", QUIET), ("samples", QUIET), ("portal", "the whole sky shines")],
    ),
    known("LightSource", "distant", &["L", "from", "to", "scale", "illuminance"], &[]),
    known("LightSource", "point", &["I", "from", "scale", "power"], &[]),
    known(
        "LightSource",
        "spot",
        &["I", "from", "to", "coneangle", "conedeltaangle", "scale", "power"],
        &[],
    ),
    known("LightSource", "goniometric", &["I", "filename", "mapname", "scale", "power"], &[]),
    known("LightSource", "projection", &["I", "filename", "mapname", "fov", "scale", "power"], &[]),
    known("AreaLightSource", "area", AREA, AREA_LEAVES),
    known("AreaLightSource", "diffuse", AREA, AREA_LEAVES),
    known("Texture", "constant", &["value"], &[]),
    known("Texture", "scale", &["tex1", "tex2", "tex", "scale"], &[]),
    known("Texture", "mix", &["tex1", "tex2", "amount"], &[]),
    known("Texture", "directionmix", &["tex1", "tex2", "dir"], &[]),
    known(
        "Texture",
        "bilerp",
        &[
            "v00", "v01", "v10", "v11", "mapping", "uscale", "vscale", "udelta", "vdelta", "v1",
            "v2",
        ],
        &[],
    ),
    known(
        "Texture",
        "checkerboard",
        &[
            "tex1",
            "tex2",
            "dimension",
            "mapping",
            "uscale",
            "vscale",
            "udelta",
            "vdelta",
            "v1",
            "v2",
        ],
        &[("aamode", QUIET)],
    ),
    known(
        "Texture",
        "imagemap",
        &[
            "filename",
            "wrap",
            "filter",
            "trilinear",
            "encoding",
            "gamma",
            "scale",
            "invert",
            "mapping",
            "uscale",
            "vscale",
            "udelta",
            "vdelta",
            "v1",
            "v2",
        ],
        &[("maxanisotropy", "samples are as wide as they are long")],
    ),
    later("Texture", "uv", TEXTURE_LATER),
    later("Texture", "dots", TEXTURE_LATER),
    later("Texture", "fbm", TEXTURE_LATER),
    later("Texture", "wrinkled", TEXTURE_LATER),
    later("Texture", "windy", TEXTURE_LATER),
    later("Texture", "marble", TEXTURE_LATER),
    later("Texture", "ptex", TEXTURE_LATER),
    known("Material", "", &[], &[]),
    known("Material", "none", &[], &[]),
    known("Material", "interface", &[], &[]),
    known("Material", "diffuse", &["reflectance"], LAMBERT),
    known("Material", "coateddiffuse", COATED_DIFFUSE, &[("twosided", QUIET)]),
    known("Material", "conductor", CONDUCTOR, &[]),
    known("Material", "coatedconductor", COATED_CONDUCTOR, &[]),
    known("Material", "dielectric", DIELECTRIC, &[]),
    known("Material", "thindielectric", &["eta"], &[]),
    known("Material", "diffusetransmission", &["reflectance", "transmittance", "scale"], LAMBERT),
    known("Material", "mix", &["materials", "amount"], &[]),
    later("Material", "subsurface", MATERIAL_LATER),
    later("Material", "hair", MATERIAL_LATER),
    later("Material", "measured", MATERIAL_LATER),
    known("Material", "matte", &["Kd"], LAMBERT),
    known("Material", "plastic", OLD_COATED, OLD_LEAVES),
    known("Material", "uber", OLD_COATED, OLD_LEAVES),
    known("Material", "substrate", OLD_COATED, OLD_LEAVES),
    known("Material", "glass", OLD_GLASS, OLD_LEAVES),
    known("Material", "metal", CONDUCTOR, OLD_LEAVES),
    known("Material", "mirror", &["Kr"], OLD_LEAVES),
    known("Material", "shinymetal", OLD_METAL, OLD_LEAVES),
    known("Material", "translucent", OLD_LEAF, OLD_LEAVES),
    later("Material", "disney", MATERIAL_LATER),
    later("Material", "fourier", MATERIAL_LATER),
    later("Material", "kdsubsurface", MATERIAL_LATER),
    known("Shape", "trianglemesh", &["P", "indices", "N", "uv", "st"], MESH_LEAVES),
    known("Shape", "plymesh", &["filename"], MESH_LEAVES),
    known("Shape", "sphere", &["radius", "zmin", "zmax", "phimax"], &[SHADOW_ALPHA]),
    known("Shape", "disk", &["height", "radius", "innerradius", "phimax"], &[SHADOW_ALPHA]),
    known("Shape", "cone", &["height", "radius", "phimax"], &[SHADOW_ALPHA]),
    known("Shape", "cylinder", &["radius", "zmin", "zmax", "phimax"], &[SHADOW_ALPHA]),
    later("Shape", "paraboloid", SHAPE_LATER),
    later("Shape", "hyperboloid", SHAPE_LATER),
    known("Shape", "bilinearmesh", &["P", "indices", "N", "uv"], MESH_LEAVES),
    known("Shape", "loopsubdiv", &["P", "indices", "levels", "nlevels"], LOOP_LEAVES),
    near("Shape", "curve", CURVE, CURVE_LEAVES, "it is a tube of six sides, or a strip"),
    later("Shape", "nurbs", SHAPE_LATER),
    later("Shape", "heightfield", SHAPE_LATER),
];

const AREA: &[&str] = &["L", "scale", "twosided", "power", "filename"];
const AREA_LEAVES: &[(&str, &str)] = &[("nsamples", QUIET), ("samples", QUIET)];

/// The entry for a kind of a directive.
pub(super) fn entry(
    directive: &'static str,
    name: &str,
    params: &Params,
) -> Result<&'static Entry, SceneError> {
    let of_directive = || VOCABULARY.iter().filter(|entry| entry.directive == directive);
    of_directive().find(|entry| entry.name == name).ok_or_else(|| {
        let names: Vec<&str> = of_directive().map(|entry| entry.name).collect();
        let hint = match hint(name, names.iter().copied()) {
            none if none.is_empty() => format!("; known are {}", names.join(", ")),
            hint => hint,
        };
        SceneError::at(params.at.clone(), format!("unknown {directive} \"{name}\"{hint}"), "")
    })
}

impl Entry {
    /// Whether anything is done with the parameters.
    pub(super) fn supported(&self) -> bool {
        self.instead.is_none() || !self.reads.is_empty()
    }

    /// Every parameter that is read: this kind's own, and those of every kind of the directive.
    pub(super) fn names(&self) -> impl Iterator<Item = &'static str> {
        let shared: &[&str] = match self.directive {
            "Material" => &["displacement", "bumpmap", "normalmap"],
            "Shape" => &["alpha"],
            _ => &[],
        };
        self.reads.iter().chain(shared).copied()
    }

    /// Checks every parameter: `leave` hears of those that are known and left out.
    pub(super) fn check(
        &self,
        params: &Params,
        mut leave: impl FnMut(&Param, &'static str),
    ) -> Result<(), SceneError> {
        for param in &params.all {
            let name = param.name.as_str();
            if self.names().any(|known| known == name) {
                continue;
            }
            if let Some((_, instead)) = self.leaves.iter().find(|(left, _)| *left == name) {
                if *instead != QUIET {
                    leave(param, instead);
                }
                continue;
            }
            let names = self.names().chain(self.leaves.iter().map(|(name, _)| *name));
            let hint = match hint(name, names) {
                none if none.is_empty() => {
                    let names: Vec<&str> = self.names().collect();
                    format!("; it reads {}", names.join(", "))
                }
                hint => hint,
            };
            let found = format!(
                "unknown parameter \"{name}\" of {} \"{}\"{hint}",
                self.directive, self.name
            );
            return Err(SceneError::at(param.at.clone(), found, ""));
        }
        Ok(())
    }
}
