//! Directives before the world: film, sampler, integrator and camera.

use std::path::{Path, PathBuf};

use super::description::{CameraSpec, FilmSpec, FilterSpec, IrisSpec, RealisticSpec, ThinSpec};
use super::params::Params;
use super::reader::Reader;
use super::{Dialect, SceneError, resolve};
use crate::film::filter::Profile;
use crate::lens::{MOST_DECENTRE, MOST_TILT, Pose};
use crate::motion::Motion;
use crate::shade::Reach;

/// Pixels on one side of a picture.
const MOST_PIXELS: u32 = 1 << 16;

/// How far from the origin a camera may stand on any axis: beyond that, coordinates times the inverse of
/// a direction leave the range of f32.
const FARTHEST: f64 = 1e18;

impl Reader {
    pub(super) fn film(&mut self) -> Result<(), SceneError> {
        self.before_world("Film")?;
        let (_, name, params, _) = self.kind("Film")?;
        self.film = Some((name, params));
        Ok(())
    }

    pub(super) fn sampler(&mut self) -> Result<(), SceneError> {
        self.before_world("Sampler")?;
        let (_, _, params, supported) = self.kind("Sampler")?;
        if !supported {
            return Ok(());
        }
        let most = 1 << 30;
        let strata =
            match (params.count_of("xsamples", 1 << 15)?, params.count_of("ysamples", 1 << 15)?) {
                (None, None) => None,
                (x, y) => Some(x.unwrap_or(4) * y.unwrap_or(4)),
            };
        self.samples = params.count_of("pixelsamples", most)?.or(strata);
        self.seeds[0] = params.seed("seed")?;
        Ok(())
    }

    pub(super) fn filter(&mut self) -> Result<(), SceneError> {
        self.before_world("PixelFilter")?;
        let (_, name, params, _) = self.kind("PixelFilter")?;
        self.filter = Some(filter_spec(&name, &params)?);
        Ok(())
    }

    pub(super) fn integrator(&mut self) -> Result<(), SceneError> {
        self.before_world("Integrator")?;
        let (_, name, params, supported) = self.kind("Integrator")?;
        let asked = if supported { params.maybe_float("maxdepth")? } else { None };
        if supported && params.truth("regularize")?.unwrap_or(false) {
            self.regularize = true;
            self.warn_here("regularize", "every surface is as smooth as the scene says");
        }
        let depth = asked.unwrap_or(5.0);
        if !(0.0..=1e6).contains(&depth) || depth.fract() != 0.0 {
            let found = format!("\"maxdepth\" is {depth}");
            return Err(params.refuse("maxdepth", found, "expected a whole number from 0"));
        }
        self.reach = Some(Reach { max_depth: depth as u32, direct: name == "directlighting" });
        Ok(())
    }

    pub(super) fn camera(&mut self) -> Result<(), SceneError> {
        self.before_world("Camera")?;
        let (_, name, params, _) = self.kind("Camera")?;
        let Some(motion) = Motion::between(self.state.ctm.map(|ctm| ctm.inverse()))
            .filter(|motion| motion.at(0.0).is_finite() && motion.at(1.0).is_finite())
        else {
            return self.refuse("a camera transform that cannot be inverted", "");
        };
        let farthest = [0.0, 1.0].map(|share| motion.at(share).translation.abs().max_element());
        if let Some(far) = farthest.into_iter().find(|&far| far > FARTHEST) {
            let found = format!("a camera at a distance of {far:e} from the origin");
            return self.refuse(found, "expected at most 1e18: check its transform and its scale");
        }
        if name == "realistic" && params.find("specfile").is_some() {
            self.dialect = Dialect::V2;
        }
        let system = self.state.ctm.map(|ctm| ctm.inverse());
        self.systems.insert("camera".to_owned(), system);
        self.camera = (name, params, motion);
        Ok(())
    }
}

/// Radii and parameters as in pbrt-v4; pbrt-v2 says width for radius, and gives a Gaussian by
/// alpha = 1 / (2 sigma^2).
fn filter_spec(name: &str, params: &Params) -> Result<FilterSpec, SceneError> {
    let radius = |default: f64| -> Result<[f64; 2], SceneError> {
        let of = |radius: &str, width: &str| {
            params.positive(if params.find(radius).is_some() { radius } else { width }, default)
        };
        Ok([of("xradius", "xwidth")?, of("yradius", "ywidth")?])
    };
    let (profile, default) = match name {
        "box" => (Profile::Box, 0.5),
        "triangle" => (Profile::Triangle, 2.0),
        "gaussian" => {
            let sigma = match params.find("alpha") {
                Some(_) => (2.0 * params.positive("alpha", 2.0)?).sqrt().recip(),
                None => params.positive("sigma", 0.5)?,
            };
            (Profile::Gaussian { sigma }, 1.5)
        }
        "mitchell" => {
            let [b, c] = [params.float("B", 1.0 / 3.0)?, params.float("C", 1.0 / 3.0)?];
            (Profile::Mitchell { b, c }, 2.0)
        }
        _ => (Profile::Sinc { tau: params.positive("tau", 3.0)? }, 4.0),
    };
    Ok(FilterSpec { profile, radius: radius(default)? })
}

pub(super) fn film_spec(params: Option<&Params>) -> Result<FilmSpec, SceneError> {
    let Some(params) = params else {
        let resolution = [1280, 720];
        let bounds = [[0, 0], resolution];
        return Ok(FilmSpec {
            resolution,
            diagonal: 35.0,
            bounds,
            filename: None,
            iso: 100.0,
            brightest: None,
            white_balance: None,
            gbuffer: false,
        });
    };
    let resolution = [
        params.count_of("xresolution", MOST_PIXELS)?.unwrap_or(1280),
        params.count_of("yresolution", MOST_PIXELS)?.unwrap_or(720),
    ];
    let mut bounds = [[0, 0], resolution];
    // Both give x0 x1 y0 y1: one in shares of the picture, one in pixels.
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
        diagonal: params.positive("diagonal", 35.0)?,
        bounds,
        filename: params.text("filename")?.map(PathBuf::from),
        iso: params.positive("iso", 100.0)?,
        brightest: match params.find("maxcomponentvalue") {
            Some(_) => Some(params.positive("maxcomponentvalue", f64::INFINITY)?),
            None => None,
        },
        // As in pbrt-v4, 0 is none.
        white_balance: params.maybe_float("whitebalance")?.filter(|&kelvin| kelvin != 0.0),
        gbuffer: false,
    })
}

pub(super) fn realistic(params: &Params, folder: &Path) -> Result<CameraSpec, SceneError> {
    if let Some(file) = params.text("specfile")? {
        return Ok(CameraSpec::Realistic(RealisticSpec::V2 {
            lens: resolve(folder, file),
            lens_at: params.place("specfile"),
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
        lens: resolve(folder, file),
        lens_at: params.place("lensfile"),
        aperture: params.positive("aperturediameter", 1.0)?,
        iris: params
            .text("aperture")?
            .map(|name| IrisSpec { path: resolve(folder, name), name: name.to_owned() }),
        focus: params.positive("focusdistance", 10.0)?,
        exposure_time: exposure_time(params)?,
        film_pose: film_pose(params)?,
    }))
}

/// Our own `filmshift` (mm, to the right and up in the picture as seen) and `filmtilt` (degrees).
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
    let shift = within("filmshift", MOST_DECENTRE, "mm")?;
    Ok(Pose::of_film(shift, within("filmtilt", MOST_TILT, "degrees")?))
}

pub(super) fn thin(params: &Params) -> Result<CameraSpec, SceneError> {
    let fov = params.positive("fov", 90.0)?;
    if fov >= 180.0 {
        return Err(params.refuse(
            "fov",
            format!("a field of view of {fov}"),
            "expected below 180",
        ));
    }
    let window = match params.numbers("screenwindow", &["float"])? {
        None => None,
        Some(&[x0, x1, y0, y1]) if x0 < x1 && y0 < y1 => Some([x0, x1, y0, y1]),
        Some(window) => {
            let found = format!("a window of {window:?}");
            return Err(params.refuse("screenwindow", found, "expected x0 x1 y0 y1, ascending"));
        }
    };
    let lens_radius = params.float("lensradius", 0.0)?;
    if lens_radius < 0.0 {
        let found = format!("a lens radius of {lens_radius}");
        return Err(params.refuse("lensradius", found, "expected 0 or more"));
    }
    let aspect = match params.find("frameaspectratio") {
        Some(_) => Some(params.positive("frameaspectratio", 1.0)?),
        None => None,
    };
    Ok(CameraSpec::Thin(ThinSpec {
        fov,
        aspect,
        window,
        lens_radius,
        focal_distance: params.positive("focaldistance", 1e6)?,
        depth: depth_range(params, [0.0, f64::INFINITY])?,
        exposure_time: exposure_time(params)?,
    }))
}

pub(super) fn depth_range(params: &Params, default: [f64; 2]) -> Result<[f64; 2], SceneError> {
    let [near, far] = [params.float("hither", default[0])?, params.float("yon", default[1])?];
    if near < 0.0 || near >= far {
        let found = format!("hither {near} and yon {far}");
        return Err(params.refuse("hither", found, "expected 0 or more, and less than yon"));
    }
    Ok([near, far])
}

pub(super) fn exposure_time(params: &Params) -> Result<f64, SceneError> {
    let time = params.float("shutterclose", 1.0)? - params.float("shutteropen", 0.0)?;
    if time > 0.0 {
        return Ok(time);
    }
    let found = format!("a shutter that is open for {time} s");
    Err(params.refuse("shutterclose", found, "expected shutterclose after shutteropen"))
}
