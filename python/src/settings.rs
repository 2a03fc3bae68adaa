//! Settings of a picture, as Python gives them.

use std::fmt::Display;
use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

use petzval::{Changes, FocusOn, StopCriteria};
use petzval_lens::{Coating, FocusModel, MAX_DECENTRE, MAX_TILT, Zoom};
use petzval_lens_formats::LensOptions;
use petzval_render::aov::Aov;
use petzval_render::prepare::Viewpoint;
use petzval_render::sensor::SensorSettings;
use petzval_spectrum::{BAND_RANGE, Passband};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::argument::{Listed, setting};
use crate::error::value_error;
use crate::lens::Lens;
use crate::lens_source::CatalogueSetting;

/// A lens: a file, or one that was read.
#[derive(FromPyObject)]
pub enum LensSetting<'py> {
    /// The lens of a [`Lens`]: its file.
    Read(PyRef<'py, Lens>),
    /// A lens file.
    File(PathBuf),
}

/// Expected of a focus.
const FOCUS: &str = "metres above 0, a pixel (x, y), or \"auto\"";

/// A focus: metres from the film, or `"auto"`.
#[derive(FromPyObject)]
pub enum FocusSetting {
    /// Metres from the film.
    Distance(f64),
    /// The surface that a pixel sees.
    Pixel([i64; 2]),
    /// `"auto"`: the surface in the middle of the picture.
    Word(String),
}

/// Settings of a picture; `None` keeps what the scene says.
pub struct Settings<'py> {
    lens: Option<LensSetting<'py>>,
    focus: Option<FocusSetting>,
    fstop: Option<f64>,
    look_at: Option<[f64; 9]>,
    film_shift: Option<[f64; 2]>,
    film_tilt: Option<[f64; 2]>,
    film_diagonal: Option<f64>,
    coating: Option<String>,
    resolution: Option<[u32; 2]>,
    crop: Option<[u32; 4]>,
    spp: Option<u32>,
    seed: Option<u32>,
    effects: String,
    light_paths: Option<bool>,
    aov: Vec<String>,
    noise: Option<f64>,
    time: Option<f64>,
    shutter: Option<String>,
    rolling_shutter: Option<String>,
    sensor: Option<String>,
    bayer: Option<String>,
    passband: Option<[f64; 2]>,
    zoom: Option<ZoomSetting>,
    focus_model: Option<String>,
    assume_vd: bool,
    catalogue: Option<CatalogueSetting>,
}

impl<'py> FromPyObject<'_, 'py> for Settings<'py> {
    type Error = PyErr;

    fn extract(settings: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let settings = settings.cast::<PyDict>()?;
        let pixels = "two whole numbers of pixels, width and height";
        let name = "a name, as a text";
        Ok(Self {
            lens: setting(&settings, "lens", "a petzval.Lens or the path of a lens file")?,
            focus: setting(&settings, "focus", FOCUS)?,
            fstop: setting(&settings, "fstop", "a number")?,
            look_at: setting(&settings, "look_at", "nine numbers")?,
            film_shift: setting(&settings, "film_shift", "two numbers (mm)")?,
            film_tilt: setting(&settings, "film_tilt", "two numbers (degrees)")?,
            film_diagonal: setting(&settings, "film_diagonal", "a number (mm)")?,
            coating: setting(&settings, "coating", name)?,
            resolution: setting(&settings, "resolution", pixels)?,
            crop: setting(&settings, "crop", "four whole numbers: left, top, right, bottom")?,
            spp: setting(&settings, "spp", "a whole number")?,
            seed: setting(&settings, "seed", "a whole number")?,
            effects: setting(
                &settings,
                "effects",
                "\"auto\", \"all\", \"none\", or a text such as \"+dispersion,-iris\"",
            )?,
            light_paths: setting(&settings, "light_paths", "True, False or None")?,
            aov: setting::<Listed<_>>(
                &settings,
                "aov",
                "names of layers, such as [\"depth\", \"normal\"]",
            )?
            .0,
            noise: setting(&settings, "noise", "a number between 0 and 1")?,
            time: setting(&settings, "time", "a number (s)")?,
            shutter: setting(&settings, "shutter", "a text such as \"time=1/100\"")?,
            rolling_shutter: setting(&settings, "rolling_shutter", "a text such as \"20ms\"")?,
            sensor: setting(&settings, "sensor", "a text such as \"iso=800\"")?,
            bayer: setting(&settings, "bayer", "a text such as \"rggb\"")?,
            passband: setting(&settings, "passband", "two wavelengths (nm)")?,
            zoom: setting(&settings, "zoom", "a focal length (mm) or the name of a state")?,
            focus_model: setting(&settings, "focus_model", name)?,
            assume_vd: setting(&settings, "assume_vd", "True or False")?,
            catalogue: setting(&settings, "catalogue", CatalogueSetting::EXPECTED)?,
        })
    }
}

/// A zoom setting: a focal length (mm), or the name of a state.
#[derive(FromPyObject)]
enum ZoomSetting {
    FocalLength(f64),
    State(String),
}

/// Parses the words of an option of the command.
fn parsed<T: FromStr<Err: Display>>(name: &str, text: Option<&String>) -> PyResult<Option<T>> {
    let parsed = text.map(|text| text.parse()).transpose();
    parsed.map_err(|problem: T::Err| value_error(format!("{name}: {problem}")))
}

/// Checks that a number is in a range, as the command does.
fn checked(
    name: &str,
    value: Option<f64>,
    fits: impl Fn(f64) -> bool,
    expected: &str,
) -> PyResult<()> {
    match value {
        Some(value) if !fits(value) => {
            Err(value_error(format!("{name}={value}: expected {expected}")))
        }
        _ => Ok(()),
    }
}

/// Returns the layer of this name.
fn layer(name: &str) -> PyResult<Aov> {
    let found = Aov::ALL.into_iter().find(|aov| aov.name() == name);
    found.ok_or_else(|| {
        let known: Vec<&str> = Aov::ALL.iter().map(|aov| aov.name()).collect();
        value_error(format!("aov: no layer {name:?}; known are {}", known.join(", ")))
    })
}

impl Settings<'_> {
    /// Returns these settings as changes to a scene.
    pub fn changes(&self) -> PyResult<Changes> {
        let positive = |v: f64| v > 0.0 && v.is_finite();
        checked("fstop", self.fstop, positive, "a number above 0")?;
        checked("noise", self.noise, |v| v > 0.0 && v < 1.0, "a number between 0 and 1")?;
        let film = |mm: f64| (1e-3..=1e4).contains(&mm);
        checked("film_diagonal", self.film_diagonal, film, "0.001 to 10000 mm")?;
        checked("time", self.time, |v| v > 0.0 && v < 1e9, "seconds above 0")?;
        if self.spp == Some(0) {
            return Err(value_error("spp=0: expected 1 or more"));
        }
        let sides = 1..=65_536;
        if self.resolution.is_some_and(|size| !size.iter().all(|side| sides.contains(side))) {
            let expected = "resolution: expected 1 to 65536 pixels in width and height";
            return Err(value_error(expected));
        }
        for (name, pair, most, unit) in [
            ("film_shift", self.film_shift, MAX_DECENTRE, "mm"),
            ("film_tilt", self.film_tilt, MAX_TILT, "degrees"),
        ] {
            if pair.is_some_and(|pair| !pair.iter().all(|v| v.abs() <= most)) {
                return Err(value_error(format!(
                    "{name}: expected two numbers from -{most} to {most} {unit}"
                )));
            }
        }
        Ok(Changes {
            lens: self.lens_file(),
            lens_options: LensOptions {
                zoom: self.zoom()?,
                catalogues: self.catalogues(),
                ..LensOptions::default()
            },
            focus: self.focus()?,
            focus_model: self.focus_model()?,
            f_number: self.fstop,
            viewpoint: self.viewpoint()?,
            film_shift: self.film_shift,
            film_tilt: self.film_tilt,
            film_diagonal: self.film_diagonal,
            coating: self.coating()?,
            assume_vd: self.assume_vd,
            passband: self.passband()?,
            resolution: self.resolution,
            crop: self.crop.map(|[left, top, right, bottom]| [[left, top], [right, bottom]]),
            samples: self.spp,
            seed: self.seed,
            effects: parsed("effects", Some(&self.effects))?.unwrap_or_default(),
            light_paths: self.light_paths,
            layers: self.aov.iter().map(|name| layer(name)).collect::<PyResult<_>>()?,
            holds_layers: true,
            stop_criteria: StopCriteria {
                noise: self.noise,
                time: self.time.map(Duration::from_secs_f64),
            },
            shutter: parsed("shutter", self.shutter.as_ref())?,
            rolling: parsed("rolling_shutter", self.rolling_shutter.as_ref())?,
            sensor: self.sensor()?,
            ..Changes::default()
        })
    }

    fn lens_file(&self) -> Option<PathBuf> {
        self.lens.as_ref().map(|lens| match lens {
            LensSetting::File(path) => path.clone(),
            LensSetting::Read(lens) => lens.file().to_owned(),
        })
    }

    /// Returns the glass catalogues of the settings, then those of the lens.
    fn catalogues(&self) -> Vec<PathBuf> {
        let mut all = self.catalogue.as_ref().map_or_else(Vec::new, CatalogueSetting::paths);
        if let Some(LensSetting::Read(lens)) = &self.lens {
            all.extend_from_slice(lens.catalogues());
        }
        all
    }

    fn focus(&self) -> PyResult<Option<FocusOn>> {
        match &self.focus {
            None => Ok(None),
            Some(FocusSetting::Distance(metres)) if *metres > 0.0 => {
                Ok(Some(FocusOn::Distance(*metres)))
            }
            Some(FocusSetting::Pixel(pixel)) => match pixel.map(u32::try_from) {
                [Ok(x), Ok(y)] => Ok(Some(FocusOn::Pixel(Some([x, y])))),
                _ => Err(value_error(format!("focus={pixel:?}: expected {FOCUS}"))),
            },
            Some(FocusSetting::Word(word)) if word == "auto" => Ok(Some(FocusOn::Pixel(None))),
            Some(FocusSetting::Distance(metres)) => {
                Err(value_error(format!("focus={metres}: expected {FOCUS}")))
            }
            Some(FocusSetting::Word(word)) => {
                Err(value_error(format!("focus={word:?}: expected {FOCUS}")))
            }
        }
    }

    fn focus_model(&self) -> PyResult<FocusModel> {
        match self.focus_model.as_deref() {
            None | Some("sharpest") => Ok(FocusModel::Sharpest),
            Some("pbrt") => Ok(FocusModel::Pbrt),
            Some(name) => {
                let expected = "expected \"sharpest\" or \"pbrt\"";
                Err(value_error(format!("focus_model={name:?}: {expected}")))
            }
        }
    }

    fn zoom(&self) -> PyResult<Option<Zoom>> {
        match &self.zoom {
            None => Ok(None),
            Some(ZoomSetting::FocalLength(mm)) if *mm > 0.0 && mm.is_finite() => {
                Ok(Some(Zoom::FocalLength(*mm)))
            }
            Some(ZoomSetting::FocalLength(mm)) => {
                Err(value_error(format!("zoom={mm}: expected a focal length above 0")))
            }
            Some(ZoomSetting::State(state)) => Ok(Some(Zoom::State(state.clone()))),
        }
    }

    fn viewpoint(&self) -> PyResult<Option<Viewpoint>> {
        let text = self.look_at.map(|numbers| numbers.map(|number| number.to_string()).join(","));
        parsed("look_at", text.as_ref())
    }

    fn coating(&self) -> PyResult<Option<Coating>> {
        let Some(name) = self.coating.as_deref() else { return Ok(None) };
        let known = || format!("coating={name:?}: expected one of {}", Coating::NAMES.join(", "));
        Coating::named(name).map(Some).ok_or_else(|| value_error(known()))
    }

    fn passband(&self) -> PyResult<Option<Passband>> {
        let Some(range) = self.passband else { return Ok(None) };
        let ([low, high], [lowest, highest]) = (range, BAND_RANGE);
        match lowest <= low && low < high && high <= highest {
            true => Ok(Some(Passband { range })),
            false => Err(value_error(format!(
                "passband: expected two wavelengths from {lowest} to {highest} nm"
            ))),
        }
    }

    /// Returns the sensor; a mosaic implies one.
    fn sensor(&self) -> PyResult<Option<SensorSettings>> {
        let sensor = parsed::<SensorSettings>("sensor", self.sensor.as_ref())?;
        let Some(bayer) = parsed("bayer", self.bayer.as_ref())? else { return Ok(sensor) };
        Ok(Some(SensorSettings { bayer: Some(bayer), ..sensor.unwrap_or_default() }))
    }
}
