//! The Sampler, Integrator and Option directives, and the directives of pbrt that have no effect
//! here.

use super::directive_kinds::{Directive, Ignored, SILENT, Selected, known, similar, unsupported};
use super::params::Params;
use super::reader::SceneReader;
use super::{SceneError, suggestion_or};
use petzval_base::io::hint;
use petzval_scene::PathLimits;

const SAMPLER_READS: &[&str] = &["pixelsamples", "xsamples", "ysamples", "seed"];
const SAMPLER_IGNORES: &[Ignored] = &[
    ("randomization", SILENT),
    ("jitter", SILENT),
    ("scramble", SILENT),
    ("dimensions", SILENT),
    ("samplepixelcenter", SILENT),
];

static SAMPLER: Directive<()> = Directive {
    name: "Sampler",
    target: None,
    shared: &[],
    kinds: &[
        known("lowdiscrepancy", (), SAMPLER_READS, SAMPLER_IGNORES),
        known("halton", (), SAMPLER_READS, SAMPLER_IGNORES),
        known("sobol", (), SAMPLER_READS, SAMPLER_IGNORES),
        known("paddedsobol", (), SAMPLER_READS, SAMPLER_IGNORES),
        known("zsobol", (), SAMPLER_READS, SAMPLER_IGNORES),
        known("02sequence", (), SAMPLER_READS, SAMPLER_IGNORES),
        known("zerotwosequence", (), SAMPLER_READS, SAMPLER_IGNORES),
        known("pmj02bn", (), SAMPLER_READS, SAMPLER_IGNORES),
        known("maxmindist", (), SAMPLER_READS, SAMPLER_IGNORES),
        known("random", (), SAMPLER_READS, SAMPLER_IGNORES),
        known("independent", (), SAMPLER_READS, SAMPLER_IGNORES),
        known("stratified", (), SAMPLER_READS, SAMPLER_IGNORES),
        known(
            "adaptive",
            (),
            &["minsamples", "maxsamples", "seed"],
            &[("pixelsamples", SILENT), ("method", SILENT)],
        ),
        known("bestcandidate", (), SAMPLER_READS, SAMPLER_IGNORES),
    ],
};

/// The light that an integrator computes.
#[derive(Clone, Copy, PartialEq)]
enum IntegratorKind {
    DirectLighting,
    Path,
    /// Paths that scatter in media.
    VolumePath,
    /// The share of the hemisphere that each point sees.
    AmbientOcclusion,
}

const PATH_READS: &[&str] = &["maxdepth", "regularize"];
const PATH_IGNORES: &[Ignored] = &[
    ("lightsampler", SILENT),
    ("lightsamplestrategy", SILENT),
    ("rrthreshold", SILENT),
    ("strategy", SILENT),
    ("samplebsdf", SILENT),
    ("samplelights", SILENT),
    ("visualizestrategies", SILENT),
    ("visualizeweights", SILENT),
    ("bootstrapsamples", SILENT),
    ("chains", SILENT),
    ("mutationsperpixel", "pixelsamples alone decides"),
    ("largestepprobability", SILENT),
    ("sigma", SILENT),
    ("photonsperiteration", SILENT),
    ("radius", SILENT),
    ("seed", SILENT),
    ("iterations", SILENT),
    ("numiterations", SILENT),
    ("pixelbounds", "the whole picture is rendered"),
    ("imagewritefrequency", SILENT),
];
const PATH_INSTEAD: &str = "path is used";
const AO_IGNORES: &[Ignored] = &[
    ("cossample", SILENT),
    ("nsamples", SILENT),
    ("maxdist", "the distance has no limit"),
    ("maxdistance", "the distance has no limit"),
    ("pixelbounds", "the whole picture is rendered"),
];
const AO_INSTEAD: &str =
    "white surfaces under a white sky have the same picture, before a white background";

static INTEGRATOR: Directive<IntegratorKind> = Directive {
    name: "Integrator",
    target: None,
    shared: &[],
    kinds: &[
        known("directlighting", IntegratorKind::DirectLighting, PATH_READS, PATH_IGNORES),
        known("path", IntegratorKind::Path, PATH_READS, PATH_IGNORES),
        known("volpath", IntegratorKind::VolumePath, PATH_READS, PATH_IGNORES),
        known("simplepath", IntegratorKind::Path, PATH_READS, PATH_IGNORES),
        known("simplevolpath", IntegratorKind::VolumePath, PATH_READS, PATH_IGNORES),
        known("randomwalk", IntegratorKind::Path, PATH_READS, PATH_IGNORES),
        similar("lightpath", IntegratorKind::Path, PATH_READS, PATH_IGNORES, PATH_INSTEAD),
        similar("bdpt", IntegratorKind::VolumePath, PATH_READS, PATH_IGNORES, PATH_INSTEAD),
        similar("mlt", IntegratorKind::VolumePath, PATH_READS, PATH_IGNORES, PATH_INSTEAD),
        similar("sppm", IntegratorKind::Path, PATH_READS, PATH_IGNORES, PATH_INSTEAD),
        unsupported("whitted", PATH_INSTEAD),
        unsupported("function", PATH_INSTEAD),
        unsupported("photonmap", PATH_INSTEAD),
        unsupported("exphotonmap", PATH_INSTEAD),
        unsupported("irradiancecache", PATH_INSTEAD),
        unsupported("igi", PATH_INSTEAD),
        similar("ambientocclusion", IntegratorKind::AmbientOcclusion, &[], AO_IGNORES, AO_INSTEAD),
        similar("ao", IntegratorKind::AmbientOcclusion, &[], AO_IGNORES, AO_INSTEAD),
    ],
};

pub(super) static VOLUME_INTEGRATOR: Directive<()> = Directive {
    name: "VolumeIntegrator",
    target: None,
    shared: &[],
    kinds: &[unsupported("emission", SILENT), unsupported("single", SILENT)],
};

pub(super) static RENDERER: Directive<()> = Directive {
    name: "Renderer",
    target: None,
    shared: &[],
    kinds: &[unsupported("sampler", SILENT), unsupported("metropolis", "there is one renderer")],
};

pub(super) static ACCELERATOR: Directive<()> = Directive {
    name: "Accelerator",
    target: None,
    shared: &[],
    kinds: &[
        unsupported("bvh", SILENT),
        unsupported("kdtree", SILENT),
        unsupported("grid", SILENT),
    ],
};

/// Options of pbrt-v4 that cannot change the mean of any pixel here.
const OPTIONS_WITHOUT_EFFECT: &[&str] = &[
    "rendercoordsys",
    "msereferenceimage",
    "msereferenceout",
    "pixelstats",
    "wavefront",
    "disablewavelengthjitter",
];

/// Options of pbrt-v4 that would change pixels but are not supported, and the consequence.
const UNSUPPORTED_OPTIONS: &[(&str, &str)] = &[
    ("disablepixeljitter", "samples are spread over their pixels"),
    ("disabletexturefiltering", "textures are filtered"),
    ("forcediffuse", "surfaces keep their materials"),
];

impl SceneReader {
    pub(super) fn sampler(&mut self) -> Result<(), SceneError> {
        self.require_before_world("Sampler")?;
        let (name, params) = (self.string()?, self.params()?);
        self.set_sampler(&name, params)
    }

    pub(super) fn set_sampler(&mut self, name: &str, params: Params) -> Result<(), SceneError> {
        let selected = self.check_kind(&SAMPLER, name, params)?;
        let (params, Some(())) = (selected.params, selected.kind) else { return Ok(()) };
        let strata = match (params.count("xsamples", 1 << 15)?, params.count("ysamples", 1 << 15)?)
        {
            (None, None) => None,
            (x, y) => Some(x.unwrap_or(4) * y.unwrap_or(4)),
        };
        // The sampler `adaptive` of pbrt-v2 takes up to `maxsamples`.
        let most = params.count("maxsamples", 1 << 30)?;
        self.samples = params.count("pixelsamples", 1 << 30)?.or(strata).or(most);
        self.sampler_seed = params.seed("seed")?;
        Ok(())
    }

    pub(super) fn integrator(&mut self) -> Result<(), SceneError> {
        self.require_before_world("Integrator")?;
        let selected = self.select_or(&INTEGRATOR, PATH_INSTEAD)?;
        self.set_integrator(selected)
    }

    pub(super) fn set_path_integrator(&mut self, params: Params) -> Result<(), SceneError> {
        let selected = self.check_kind(&INTEGRATOR, "path", params)?;
        self.set_integrator(selected)
    }

    fn set_integrator(&mut self, selected: Selected<IntegratorKind>) -> Result<(), SceneError> {
        let params = selected.params;
        let supported = selected.kind.is_some();
        self.ignores_media =
            matches!(selected.kind, Some(IntegratorKind::Path | IntegratorKind::DirectLighting));
        let given = if supported { params.maybe_float("maxdepth")? } else { None };
        let regularize = supported && params.boolean("regularize")?.unwrap_or(false);
        let depth = given.unwrap_or(5.0);
        if !(0.0..=1e6).contains(&depth) || depth.fract() != 0.0 {
            let found = format!("\"maxdepth\" is {depth}");
            let expected = "expected a whole number from 0 to 1000000";
            return Err(params.refuse("maxdepth", found, expected));
        }
        self.ambient_occlusion = selected.kind == Some(IntegratorKind::AmbientOcclusion);
        if self.ambient_occlusion {
            let limits = PathLimits { max_depth: 1, direct_only: true, regularize: false };
            self.path_limits = Some(limits);
            return Ok(());
        }
        let direct_only = selected.kind == Some(IntegratorKind::DirectLighting);
        self.path_limits = Some(PathLimits { max_depth: depth as u32, direct_only, regularize });
        Ok(())
    }

    pub(super) fn option(&mut self) -> Result<(), SceneError> {
        let mut params = self.option_params()?;
        for param in &mut params.all {
            // As in pbrt-v4, "disable-pixel-jitter" and "disablePixelJitter" are one option.
            param.name = param.name.to_lowercase().replace(['-', '_'], "");
        }
        for param in &params.all {
            let name = param.name.as_str();
            let unsupported = UNSUPPORTED_OPTIONS.iter().find(|(known, _)| *known == name);
            if name == "seed" {
                self.option_seed = params.seed(name)?;
            } else if name == "displacementedgescale" {
                self.displacement_edge_scale = params.positive(name, 1.0)?;
            } else if let Some((_, instead)) = unsupported {
                if params.boolean(name)? == Some(true) {
                    let feature = format!("the option \"{name}\"");
                    self.warnings.unsupported(&param.at, &feature, instead);
                }
            } else if !OPTIONS_WITHOUT_EFFECT.contains(&name) {
                let unsupported = UNSUPPORTED_OPTIONS.iter().map(|(known, _)| *known);
                let names = OPTIONS_WITHOUT_EFFECT.iter().copied().chain(unsupported);
                let names: Vec<&str> = names.chain(["seed", "displacementedgescale"]).collect();
                let hint = hint(name, names.iter().copied());
                let behind = suggestion_or(hint, &format!("known are {}", names.join(", ")));
                let found = format!("unknown option \"{name}\"{behind}");
                return Err(SceneError::at(param.at.clone(), found, ""));
            }
        }
        Ok(())
    }
}
