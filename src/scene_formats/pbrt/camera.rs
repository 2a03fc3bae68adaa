//! The Camera directive.

use std::path::Path;
use std::sync::Arc;

use glam::DAffine3;

use super::description::{CameraSpec, IrisSpec, RealisticSpec, SphericalSpec, ThinSpec};
use super::directive_kinds::{Directive, Ignored, SILENT, Selected, known};
use super::params::Params;
use super::reader::SceneReader;
use super::shutter::shutter;
use super::{Dialect, SceneError, resolve};
use petzval_base::io::{Location, ReadContext};
use petzval_lens::{MAX_DECENTRE, MAX_TILT, Pose, SphericalMapping};
use petzval_scene::VACUUM;
use petzval_scene::motion::Motion;
use petzval_scene::shutter::Shutter;
use petzval_spectrum::ColourSpace;

/// The kinds of cameras.
#[derive(Clone, Copy)]
pub(super) enum CameraKind {
    /// A lens file.
    Realistic,
    /// A pinhole or a thin lens.
    Perspective,
    /// Parallel rays.
    Orthographic,
    /// All directions.
    Spherical,
    /// All directions in pbrt-v3, which has one mapping only.
    Environment,
}

/// Parameters that pbrt-v4 reads without a use.
const NO_SCREEN: &[Ignored] = &[
    ("frameaspectratio", SILENT),
    ("screenwindow", SILENT),
    ("lensradius", SILENT),
    ("focaldistance", SILENT),
];

/// Parameters of the shutter, which every camera has.
const SHUTTER: &[&str] = &[
    "shutteropen",
    "shutterclose",
    "shutterramp",
    "shuttercurve",
    "rollingshutter",
    "rollingdirection",
];

static CAMERA: Directive<CameraKind> = Directive {
    name: "Camera",
    target: None,
    shared: SHUTTER,
    kinds: &[
        known(
            "realistic",
            CameraKind::Realistic,
            &[
                "specfile",
                "filmdistance",
                "aperture_diameter",
                "filmdiag",
                "hither",
                "yon",
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
            "perspective",
            CameraKind::Perspective,
            &[
                "fov",
                "halffov",
                "frameaspectratio",
                "screenwindow",
                "lensradius",
                "focaldistance",
                "hither",
                "yon",
            ],
            &[],
        ),
        known(
            "orthographic",
            CameraKind::Orthographic,
            &["frameaspectratio", "screenwindow", "lensradius", "focaldistance", "hither", "yon"],
            &[],
        ),
        known("spherical", CameraKind::Spherical, &["mapping"], NO_SCREEN),
        known("environment", CameraKind::Environment, &[], NO_SCREEN),
    ],
};

/// Limit of the camera's distance from the origin along each axis. Beyond it, coordinates times the
/// inverse of a direction leave the range of f32.
const MAX_COORDINATE: f64 = 1e18;

/// A Camera directive, whose parameters are read at the end of the scene file.
pub(super) struct CameraDirective {
    kind: CameraKind,
    pub(super) params: Params,
    /// Camera space to world space.
    pub(super) motion: Motion,
}

impl CameraDirective {
    /// Returns the camera of a scene that names none, as in pbrt-v4.
    pub(super) fn default_at(at: Location, folder: Arc<Path>, context: ReadContext) -> Self {
        let space = ColourSpace::default();
        let params = Params { all: Vec::new(), at, space, folder, context };
        let motion = Motion::still(DAffine3::IDENTITY);
        Self { kind: CameraKind::Perspective, params, motion }
    }

    pub(super) fn spec(&self, dialect: Dialect) -> Result<CameraSpec, SceneError> {
        let params = &self.params;
        let exposure_time = || exposure_time(params, dialect);
        match self.kind {
            CameraKind::Realistic => realistic(params, exposure_time),
            CameraKind::Perspective => thin(params, Some(fov(params)?), exposure_time()?),
            CameraKind::Orthographic => thin(params, None, exposure_time()?),
            CameraKind::Spherical => Ok(CameraSpec::Spherical(SphericalSpec {
                mapping: mapping(params)?,
                exposure_time: exposure_time()?,
            })),
            CameraKind::Environment => Ok(CameraSpec::Spherical(SphericalSpec {
                mapping: SphericalMapping::Equirectangular,
                exposure_time: exposure_time()?,
            })),
        }
    }

    pub(super) fn shutter(&self, dialect: Dialect) -> Result<Shutter, SceneError> {
        shutter(&self.params, dialect)
    }
}

impl SceneReader {
    pub(super) fn camera(&mut self) -> Result<(), SceneError> {
        self.require_before_world("Camera")?;
        let (name, params) = (self.string()?, self.params()?);
        self.set_camera(&name, params)
    }

    /// Sets the camera, at the current transform.
    pub(super) fn set_camera(&mut self, name: &str, params: Params) -> Result<(), SceneError> {
        let Selected { kind, params, .. } = self.check_kind(&CAMERA, name, params)?;
        let kind = kind.unwrap_or(CameraKind::Perspective);
        let world_from_camera = self.state.ctm.map(|ctm| ctm.inverse());
        let Some(motion) = Motion::between(world_from_camera)
            .filter(|motion| motion.at(0.0).is_finite() && motion.at(1.0).is_finite())
        else {
            return self.refuse(
                "a camera transform that cannot be inverted",
                "check the transforms before it: one flattens space",
            );
        };
        let farthest = [0.0, 1.0].map(|time| motion.at(time).translation.abs().max_element());
        if let Some(far) = farthest.into_iter().find(|&far| far > MAX_COORDINATE) {
            let found = format!("a camera at a distance of {far:e} from the origin");
            return self.refuse(found, "expected at most 1e18: check its transform and its scale");
        }
        if matches!(kind, CameraKind::Realistic) && params.find("specfile").is_some() {
            self.dialect = Dialect::V2;
        }
        self.coordinate_systems.insert("camera".to_owned(), world_from_camera);
        if self.state.media.outside != VACUUM {
            self.builder.set_camera_medium(self.state.media.outside);
        }
        self.camera = CameraDirective { kind, params, motion };
        Ok(())
    }
}

fn realistic(
    params: &Params,
    exposure_time: impl FnOnce() -> Result<f64, SceneError>,
) -> Result<CameraSpec, SceneError> {
    if let Some(file) = params.text("specfile")? {
        return Ok(CameraSpec::Realistic(RealisticSpec::V2 {
            lens: resolve(&params.folder, file),
            lens_at: params.location("specfile"),
            aperture: params.positive("aperture_diameter", 1.0)?,
            film_distance: params.positive("filmdistance", 70.0)?,
            film_diagonal: params.positive("filmdiag", 35.0)?,
            depth: depth_range(params, [0.001, 1e30])?,
            film_pose: film_pose(params)?,
        }));
    }
    let Some(file) = params.text("lensfile")? else {
        return Err(params.refuse(
            "lensfile",
            "a realistic camera without a lens",
            "expected \"string lensfile\" (pbrt-v4) or \"string specfile\" (pbrt-v2)",
        ));
    };
    Ok(CameraSpec::Realistic(RealisticSpec::V4 {
        lens: resolve(&params.folder, file),
        lens_at: params.location("lensfile"),
        aperture: params.positive("aperturediameter", 1.0)?,
        iris: params
            .text("aperture")?
            .filter(|name| !name.is_empty())
            .map(|name| IrisSpec { path: resolve(&params.folder, name), name: name.to_owned() }),
        focus: params.positive("focusdistance", 10.0)?,
        exposure_time: exposure_time()?,
        film_pose: film_pose(params)?,
    }))
}

/// Reads two parameters that pbrt does not have: `filmshift` [mm, to the right and up in the
/// picture as displayed] and `filmtilt` (degrees).
fn film_pose(params: &Params) -> Result<Pose, SceneError> {
    let within = |name: &str, most: f64, unit: &str| -> Result<[f64; 2], SceneError> {
        let Some(numbers) = params.numbers(name, &["point2", "vector2", "float"])? else {
            return Ok([0.0; 2]);
        };
        match *numbers {
            [x, y] if x.abs() <= most && y.abs() <= most => Ok([x, y]),
            [x, y] => {
                let expected = format!("expected two numbers, each from -{most} to {most} {unit}");
                Err(params.refuse(name, format!("\"{name}\" is [{x} {y}]"), expected))
            }
            _ => Err(params.wrong_count(name, numbers.len(), "two numbers")),
        }
    };
    let shift = within("filmshift", MAX_DECENTRE, "mm")?;
    Ok(Pose::of_film(shift, within("filmtilt", MAX_TILT, "degrees")?))
}

impl Default for ThinSpec {
    fn default() -> Self {
        Self {
            fov: Some(90.0),
            aspect: None,
            window: None,
            lens_radius: 0.0,
            focal_distance: 1e6,
            depth: [0.0, f64::INFINITY],
            exposure_time: 1.0,
            takes_lens: false,
        }
    }
}

fn fov(params: &Params) -> Result<f64, SceneError> {
    // pbrt-v3 has the angle from the axis, too.
    let fov = match params.find("halffov") {
        Some(_) => 2.0 * params.positive("halffov", 45.0)?,
        None => params.positive("fov", 90.0)?,
    };
    if fov >= 180.0 {
        let found = format!("a field of view of {fov}");
        return Err(params.refuse("fov", found, "expected below 180 degrees"));
    }
    Ok(fov)
}

fn mapping(params: &Params) -> Result<SphericalMapping, SceneError> {
    match params.text("mapping")? {
        None | Some("equalarea") => Ok(SphericalMapping::EqualArea),
        Some("equirectangular") => Ok(SphericalMapping::Equirectangular),
        Some(other) => {
            let found = format!("the mapping \"{other}\"");
            Err(params.refuse("mapping", found, "expected equalarea or equirectangular"))
        }
    }
}

/// Returns a camera with a field of view, or with parallel rays.
fn thin(params: &Params, fov: Option<f64>, exposure_time: f64) -> Result<CameraSpec, SceneError> {
    let default = ThinSpec::default();
    let window = match params.numbers("screenwindow", &["float"])? {
        None => None,
        Some(&[x0, x1, y0, y1]) if x0 < x1 && y0 < y1 => Some([x0, x1, y0, y1]),
        Some(window) => {
            let found = format!("a window of {window:?}");
            return Err(params.refuse("screenwindow", found, "expected x0 x1 y0 y1, ascending"));
        }
    };
    let lens_radius = params.float("lensradius", default.lens_radius)?;
    if lens_radius < 0.0 {
        let found = format!("a lens radius of {lens_radius}");
        return Err(params.refuse("lensradius", found, "expected 0 or more"));
    }
    let aspect = match params.find("frameaspectratio") {
        Some(_) => Some(params.positive("frameaspectratio", 1.0)?),
        None => None,
    };
    Ok(CameraSpec::Thin(ThinSpec {
        takes_lens: false,
        fov,
        aspect,
        window,
        lens_radius,
        focal_distance: params.positive("focaldistance", default.focal_distance)?,
        depth: depth_range(params, default.depth)?,
        exposure_time,
    }))
}

fn depth_range(params: &Params, default: [f64; 2]) -> Result<[f64; 2], SceneError> {
    let [near, far] = [params.float("hither", default[0])?, params.float("yon", default[1])?];
    if near < 0.0 || near >= far {
        let found = format!("hither {near} and yon {far}");
        return Err(params.refuse("hither", found, "expected 0 or more, and less than yon"));
    }
    Ok([near, far])
}

fn exposure_time(params: &Params, dialect: Dialect) -> Result<f64, SceneError> {
    let time = params.float("shutterclose", 1.0)? - params.float("shutteropen", 0.0)?;
    if time > 0.0 {
        return Ok(time);
    }
    // Before pbrt-v4, a picture does not depend on the time, and 0 s is a still picture.
    if time == 0.0 && dialect.is_older() {
        return Ok(1.0);
    }
    let found = format!("a shutter that is open for {time} s");
    Err(params.refuse("shutterclose", found, "expected shutterclose after shutteropen"))
}
