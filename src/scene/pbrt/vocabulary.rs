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

const fn later(directive: &'static str, name: &'static str, instead: &'static str) -> Entry {
    Entry { directive, name, reads: &[], leaves: &[], instead: Some(instead) }
}

const BOX_INSTEAD: &str = "a box of one pixel is used";
const PATH_INSTEAD: &str = "path is used";
const SHAPE_LATER: &str = "the shape is left out";
const LIGHT_LATER: &str = "the light is left out";
const TEXTURE_LATER: &str = "the constant 0.5 is used";
const MATERIAL_LATER: &str = "a diffuse surface of its Kd or reflectance, or of 0.5, is used";
const ONE_LIGHT_SAMPLE: &str = "every camera sample takes one light sample; raise --spp instead";
const UNSHADED: &str = "the surface is left as it is";
const OPAQUE: &str = "the shape is opaque";
const OWN_ORDER: &str = "samples are Owen-scrambled Sobol points";

const FILM: &[&str] =
    &["xresolution", "yresolution", "filename", "diagonal", "cropwindow", "pixelbounds", "iso"];
const FILM_LEAVES: &[(&str, &str)] = &[
    ("sensor", "the sensor is ideal: pixels are linear RGB"),
    ("whitebalance", "the sensor is ideal: pixels are linear RGB"),
    ("maxcomponentvalue", "nothing is clamped"),
    ("savefp16", "pixels are 32-bit floats; --half writes 16-bit ones"),
    ("display", "no window is opened"),
    ("scale", "the picture is not scaled"),
];
const SAMPLER: &[&str] = &["pixelsamples", "xsamples", "ysamples", "seed"];
const SAMPLER_LEAVES: &[(&str, &str)] =
    &[("randomization", OWN_ORDER), ("jitter", OWN_ORDER), ("scramble", OWN_ORDER)];
const DEPTH: &[&str] = &["maxdepth"];
const PATH_LEAVES: &[(&str, &str)] = &[
    ("lightsampler", "lights are chosen by their power"),
    ("lightsamplestrategy", "lights are chosen by their power"),
    ("regularize", "nothing is regularised"),
    ("rrthreshold", "Russian roulette begins at the third surface"),
    ("strategy", "lights are chosen by their power, one a sample"),
];
const PHI_CLIPPED: &[(&str, &str)] = &[("alpha", OPAQUE)];
const MESH_LEAVES: &[(&str, &str)] = &[
    ("S", "tangents are not needed by diffuse surfaces"),
    ("faceIndices", "there are no per-face textures"),
    ("alpha", OPAQUE),
    ("shadowalpha", OPAQUE),
    ("discarddegenerateUVs", "texture coordinates are left as they are"),
    ("displacement", UNSHADED),
    ("edgelength", UNSHADED),
    ("displacement.edgelength", UNSHADED),
];
const SURFACE_LEAVES: &[(&str, &str)] = &[
    ("sigma", "the surface is Lambertian"),
    ("bumpmap", UNSHADED),
    ("displacement", UNSHADED),
    ("normalmap", UNSHADED),
];

/// Everything the reader knows.
pub(super) const VOCABULARY: &[Entry] = &[
    known("Film", "image", FILM, FILM_LEAVES),
    known("Film", "rgb", FILM, FILM_LEAVES),
    later("Film", "gbuffer", "film rgb is used"),
    later("Film", "spectral", "film rgb is used"),
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
    later("Sampler", "bestcandidate", OWN_ORDER),
    known("PixelFilter", "box", &["xwidth", "ywidth", "xradius", "yradius"], &[]),
    later("PixelFilter", "gaussian", BOX_INSTEAD),
    later("PixelFilter", "mitchell", BOX_INSTEAD),
    later("PixelFilter", "sinc", BOX_INSTEAD),
    later("PixelFilter", "triangle", BOX_INSTEAD),
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
            "lensfile",
            "aperturediameter",
            "focusdistance",
            "aperture",
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
        ],
        &[],
    ),
    later("Camera", "orthographic", "a perspective camera of 90 degrees is used"),
    later("Camera", "environment", "a perspective camera of 90 degrees is used"),
    later("Camera", "spherical", "a perspective camera of 90 degrees is used"),
    known("Integrator", "directlighting", DEPTH, PATH_LEAVES),
    known("Integrator", "path", DEPTH, PATH_LEAVES),
    known(
        "Integrator",
        "simplepath",
        DEPTH,
        &[
            ("samplebsdf", "both directions are sampled"),
            ("samplelights", "lights are always sampled"),
        ],
    ),
    later("Integrator", "volpath", PATH_INSTEAD),
    later("Integrator", "simplevolpath", PATH_INSTEAD),
    later("Integrator", "randomwalk", PATH_INSTEAD),
    later("Integrator", "whitted", PATH_INSTEAD),
    later("Integrator", "lightpath", PATH_INSTEAD),
    later("Integrator", "bdpt", PATH_INSTEAD),
    later("Integrator", "mlt", PATH_INSTEAD),
    later("Integrator", "sppm", PATH_INSTEAD),
    later("Integrator", "photonmap", PATH_INSTEAD),
    later("Integrator", "exphotonmap", PATH_INSTEAD),
    later("Integrator", "irradiancecache", PATH_INSTEAD),
    later("Integrator", "igi", PATH_INSTEAD),
    later("Integrator", "ambientocclusion", PATH_INSTEAD),
    later("Integrator", "ao", PATH_INSTEAD),
    later("VolumeIntegrator", "emission", "there are no volumes"),
    later("VolumeIntegrator", "single", "there are no volumes"),
    later("Renderer", "sampler", "there is one renderer"),
    later("Renderer", "metropolis", "there is one renderer"),
    later("Accelerator", "bvh", "there is one tree"),
    later("Accelerator", "kdtree", "there is one tree"),
    later("Accelerator", "grid", "there is one tree"),
    known(
        "LightSource",
        "infinite",
        &["L", "scale", "filename", "mapname"],
        &[
            ("nsamples", ONE_LIGHT_SAMPLE),
            ("samples", ONE_LIGHT_SAMPLE),
            ("illuminance", "L and scale are used as they are"),
            ("portal", "the whole sky is sampled"),
        ],
    ),
    known(
        "LightSource",
        "distant",
        &["L", "from", "to", "scale"],
        &[("illuminance", "L and scale are used as they are")],
    ),
    known(
        "LightSource",
        "point",
        &["I", "from", "scale"],
        &[("power", "I and scale are used as they are")],
    ),
    later("LightSource", "spot", LIGHT_LATER),
    later("LightSource", "goniometric", LIGHT_LATER),
    later("LightSource", "projection", LIGHT_LATER),
    known("AreaLightSource", "area", &["L", "scale", "twosided"], AREA_LEAVES),
    known("AreaLightSource", "diffuse", &["L", "scale", "twosided"], AREA_LEAVES),
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
        &[("aamode", "edges are antialiased by the samples")],
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
    known("Material", "matte", &["Kd"], SURFACE_LEAVES),
    known("Material", "diffuse", &["reflectance"], SURFACE_LEAVES),
    later("Material", "coateddiffuse", MATERIAL_LATER),
    later("Material", "conductor", MATERIAL_LATER),
    later("Material", "coatedconductor", MATERIAL_LATER),
    later("Material", "dielectric", MATERIAL_LATER),
    later("Material", "thindielectric", MATERIAL_LATER),
    later("Material", "diffusetransmission", MATERIAL_LATER),
    later("Material", "subsurface", MATERIAL_LATER),
    later("Material", "hair", MATERIAL_LATER),
    later("Material", "measured", MATERIAL_LATER),
    later("Material", "interface", MATERIAL_LATER),
    later("Material", "none", MATERIAL_LATER),
    later("Material", "", MATERIAL_LATER),
    later("Material", "mix", MATERIAL_LATER),
    later("Material", "plastic", MATERIAL_LATER),
    later("Material", "glass", MATERIAL_LATER),
    later("Material", "metal", MATERIAL_LATER),
    later("Material", "mirror", MATERIAL_LATER),
    later("Material", "shinymetal", MATERIAL_LATER),
    later("Material", "substrate", MATERIAL_LATER),
    later("Material", "translucent", MATERIAL_LATER),
    later("Material", "uber", MATERIAL_LATER),
    later("Material", "disney", MATERIAL_LATER),
    later("Material", "fourier", MATERIAL_LATER),
    later("Material", "kdsubsurface", MATERIAL_LATER),
    known("Shape", "trianglemesh", &["P", "indices", "N", "uv", "st"], MESH_LEAVES),
    known("Shape", "plymesh", &["filename"], MESH_LEAVES),
    known("Shape", "sphere", &["radius", "zmin", "zmax", "phimax"], PHI_CLIPPED),
    known("Shape", "disk", &["height", "radius", "innerradius", "phimax"], PHI_CLIPPED),
    known("Shape", "cone", &["height", "radius", "phimax"], PHI_CLIPPED),
    later("Shape", "cylinder", SHAPE_LATER),
    later("Shape", "paraboloid", SHAPE_LATER),
    later("Shape", "hyperboloid", SHAPE_LATER),
    later("Shape", "bilinearmesh", SHAPE_LATER),
    later("Shape", "loopsubdiv", SHAPE_LATER),
    later("Shape", "curve", SHAPE_LATER),
    later("Shape", "nurbs", SHAPE_LATER),
    later("Shape", "heightfield", SHAPE_LATER),
];

const AREA_LEAVES: &[(&str, &str)] = &[
    ("nsamples", ONE_LIGHT_SAMPLE),
    ("samples", ONE_LIGHT_SAMPLE),
    ("power", "L and scale are used as they are"),
    ("filename", "the light is of one colour"),
];

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
    /// Checks every parameter: `leave` hears of those that are known and left out.
    pub(super) fn check(
        &self,
        params: &Params,
        mut leave: impl FnMut(&Param, &'static str),
    ) -> Result<(), SceneError> {
        for param in &params.all {
            let name = param.name.as_str();
            if self.reads.contains(&name) {
                continue;
            }
            if let Some((_, instead)) = self.leaves.iter().find(|(left, _)| *left == name) {
                leave(param, instead);
                continue;
            }
            let names = self.reads.iter().copied().chain(self.leaves.iter().map(|(name, _)| *name));
            let hint = match hint(name, names) {
                none if none.is_empty() => format!("; it reads {}", self.reads.join(", ")),
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
