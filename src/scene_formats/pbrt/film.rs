//! The Film and PixelFilter directives.

use std::path::PathBuf;

use super::description::{FilmSpec, FilterSpec};
use super::directive_kinds::{Directive, Ignored, SILENT, Selected, known};
use super::params::Params;
use super::reader::SceneReader;
use super::{Dialect, SceneError};
use petzval_scene::filter::Profile;
use petzval_spectrum::{Buckets, ColourSpace};

/// The kinds of films.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum FilmKind {
    Rgb,
    /// A picture and layers of geometry.
    Gbuffer,
    /// A picture and buckets of wavelength.
    Spectral,
}

const FILM_READS: &[&str] = &[
    "xresolution",
    "yresolution",
    "filename",
    "diagonal",
    "cropwindow",
    "pixelbounds",
    "iso",
    "maxcomponentvalue",
    "whitebalance",
    "sensor",
    "savefp16",
    "coordinatesystem",
    // Parameters of pbrt-v3.
    "scale",
    "maxsampleluminance",
];
/// Parameters of the spectral film alone.
const BUCKET_READS: &[&str] = &["nbuckets", "lambdamin", "lambdamax"];
const FILM_IGNORES: &[Ignored] = &[
    ("display", SILENT),
    ("nbuckets", SILENT),
    ("lambdamin", SILENT),
    ("lambdamax", SILENT),
    ("buckets", SILENT),
];

static FILM: Directive<FilmKind> = Directive {
    name: "Film",
    target: None,
    shared: FILM_READS,
    kinds: &[
        known("image", FilmKind::Rgb, &[], FILM_IGNORES),
        known("rgb", FilmKind::Rgb, &[], FILM_IGNORES),
        known("gbuffer", FilmKind::Gbuffer, &[], FILM_IGNORES),
        known("spectral", FilmKind::Spectral, BUCKET_READS, FILM_IGNORES),
    ],
};

/// The kinds of pixel filters.
#[derive(Clone, Copy, PartialEq)]
enum FilterKind {
    Box,
    Gaussian,
    Mitchell,
    Sinc,
    Triangle,
}

static PIXEL_FILTER: Directive<FilterKind> = Directive {
    name: "PixelFilter",
    target: None,
    shared: &["xradius", "yradius", "xwidth", "ywidth"],
    kinds: &[
        known("box", FilterKind::Box, &[], &[]),
        known("gaussian", FilterKind::Gaussian, &["sigma", "alpha"], &[]),
        known("mitchell", FilterKind::Mitchell, &["B", "C"], &[]),
        known("sinc", FilterKind::Sinc, &["tau"], &[]),
        known("triangle", FilterKind::Triangle, &[], &[]),
    ],
};

/// Limit of the pixels on one side of a picture.
const MAX_RESOLUTION: u32 = 1 << 16;

impl SceneReader {
    pub(super) fn film(&mut self) -> Result<(), SceneError> {
        self.require_before_world("Film")?;
        let name = self.string()?;
        let params = self.params()?;
        // Only before pbrt-v4 is a film an image.
        if name == "image" && self.dialect == Dialect::V4 {
            self.dialect = Dialect::V3;
        }
        self.set_film(&name, params)
    }

    pub(super) fn set_film(&mut self, name: &str, params: Params) -> Result<(), SceneError> {
        let Selected { kind, params, .. } = self.check_kind(&FILM, name, params)?;
        self.film = kind.map(|kind| (kind, params));
        Ok(())
    }

    pub(super) fn pixel_filter(&mut self) -> Result<(), SceneError> {
        self.require_before_world("PixelFilter")?;
        let Selected { kind, params, .. } = self.select(&PIXEL_FILTER)?;
        if let Some(kind) = kind {
            self.filter = Some(filter_spec(kind, &params)?);
        }
        Ok(())
    }
}

/// Reads radii and parameters as in pbrt-v4. pbrt-v2 gives a radius as a width, and a Gaussian by
/// alpha = 1 / (2 sigma^2).
fn filter_spec(kind: FilterKind, params: &Params) -> Result<FilterSpec, SceneError> {
    let radius = |default: f64| -> Result<[f64; 2], SceneError> {
        let either = |radius: &str, width: &str| {
            params.positive(if params.find(radius).is_some() { radius } else { width }, default)
        };
        Ok([either("xradius", "xwidth")?, either("yradius", "ywidth")?])
    };
    let (profile, default) = match kind {
        FilterKind::Box => (Profile::Box, 0.5),
        FilterKind::Triangle => (Profile::Triangle, 2.0),
        FilterKind::Gaussian => {
            let sigma = match params.find("alpha") {
                Some(_) => (2.0 * params.positive("alpha", 2.0)?).sqrt().recip(),
                None => params.positive("sigma", 0.5)?,
            };
            (Profile::Gaussian { sigma }, 1.5)
        }
        FilterKind::Mitchell => {
            let [b, c] = [params.float("B", 1.0 / 3.0)?, params.float("C", 1.0 / 3.0)?];
            (Profile::Mitchell { b, c }, 2.0)
        }
        FilterKind::Sinc => (Profile::Sinc { tau: params.positive("tau", 3.0)? }, 4.0),
    };
    Ok(FilterSpec { profile, radius: radius(default)? })
}

impl Default for FilmSpec {
    fn default() -> Self {
        let resolution = [1280, 720];
        Self {
            resolution,
            diagonal: 35.0,
            bounds: [[0, 0], resolution],
            filename: None,
            iso: 100.0,
            max_component: None,
            white_balance: None,
            camera_sensor: None,
            colour_space: ColourSpace::default(),
            half: false,
            gbuffer: false,
            camera_layers: false,
            buckets: None,
        }
    }
}

/// Reads the largest component of a sample, by its name in pbrt-v4 or v3.
fn max_component(params: &Params) -> Result<Option<f64>, SceneError> {
    let names = ["maxcomponentvalue", "maxsampleluminance"];
    match names.into_iter().find(|name| params.find(name).is_some()) {
        Some(name) => params.positive(name, f64::INFINITY).map(Some),
        None => Ok(None),
    }
}

/// Reads whether layers of geometry are in camera space, the default of pbrt-v4.
fn camera_layers(params: &Params) -> Result<bool, SceneError> {
    match params.text("coordinatesystem")? {
        None | Some("camera") => Ok(true),
        Some("world") => Ok(false),
        Some(other) => {
            let found = format!("the coordinate system \"{other}\"");
            Err(params.refuse("coordinatesystem", found, "expected camera or world"))
        }
    }
}

/// Reads the buckets of a spectral film.
fn buckets(params: &Params) -> Result<Buckets, SceneError> {
    let default = Buckets::DEFAULT;
    let count = params.count("nbuckets", Buckets::MOST)?.unwrap_or(default.count() as u32);
    let [first, last] = default.range();
    let range = [params.float("lambdamin", first)?, params.float("lambdamax", last)?];
    Buckets::new(count, range).map_err(|expected| {
        let named = ["lambdamin", "lambdamax"].into_iter().find(|name| params.find(name).is_some());
        let found = format!("buckets from {} to {} nm", range[0], range[1]);
        params.refuse(named.unwrap_or("nbuckets"), found, expected)
    })
}

pub(super) fn film_spec(kind: FilmKind, params: &Params) -> Result<FilmSpec, SceneError> {
    let default = FilmSpec::default();
    let resolution = [
        params.count("xresolution", MAX_RESOLUTION)?.unwrap_or(default.resolution[0]),
        params.count("yresolution", MAX_RESOLUTION)?.unwrap_or(default.resolution[1]),
    ];
    let mut bounds = [[0, 0], resolution];
    // Both give x0 x1 y0 y1: the first as fractions of the picture, the second in pixels.
    for (name, kind, unit) in
        [("cropwindow", "float", resolution.map(f64::from)), ("pixelbounds", "integer", [1.0, 1.0])]
    {
        let Some(window) = params.numbers(name, &[kind])? else { continue };
        let [x0, x1, y0, y1] = *window else {
            let found = format!("{} numbers", window.len());
            return Err(params.refuse(name, found, "expected x0 x1 y0 y1"));
        };
        let pixel = |v: f64, axis: usize| {
            (v * unit[axis]).ceil().clamp(0.0, f64::from(resolution[axis])) as u32
        };
        bounds = [[pixel(x0, 0), pixel(y0, 1)], [pixel(x1, 0), pixel(y1, 1)]];
        if bounds[0][0] >= bounds[1][0] || bounds[0][1] >= bounds[1][1] {
            return Err(params.refuse(name, "a window without pixels", "expected x0 x1 y0 y1"));
        }
    }
    Ok(FilmSpec {
        resolution,
        diagonal: params.positive("diagonal", default.diagonal)?,
        bounds,
        filename: params.text("filename")?.map(PathBuf::from),
        // pbrt-v4 upgrades the `scale` of pbrt-v3 to 100 times that ISO.
        iso: match params.find("scale") {
            Some(_) => default.iso * params.positive("scale", 1.0)?,
            None => params.positive("iso", default.iso)?,
        },
        max_component: max_component(params)?,
        // As in pbrt-v4, 0 is none.
        white_balance: params.maybe_float("whitebalance")?.filter(|&kelvin| kelvin != 0.0),
        camera_sensor: params.camera_sensor()?,
        colour_space: params.space,
        half: params.boolean("savefp16")?.unwrap_or(false),
        gbuffer: kind == FilmKind::Gbuffer,
        camera_layers: kind == FilmKind::Gbuffer && camera_layers(params)?,
        buckets: (kind == FilmKind::Spectral).then(|| buckets(params)).transpose()?,
    })
}
