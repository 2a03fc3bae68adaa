//! Settings of a picture, as Python gives them.

use std::path::PathBuf;
use std::time::Duration;

use petzval::aov::Aov;
use petzval::lens::{Coating, MAX_DECENTRE, MAX_TILT};
use petzval::prepare::Viewpoint;
use petzval::{Changes, FocusOn, StopCriteria};
use pyo3::prelude::*;

use crate::error::value_error;
use crate::lens::Lens;

/// A lens: a file, or one that was read.
#[derive(FromPyObject)]
pub enum LensSetting<'py> {
    /// The lens of a [`Lens`]: its file.
    Read(PyRef<'py, Lens>),
    /// A lens file.
    File(PathBuf),
}

/// A focus: metres from the film, or `"auto"`.
#[derive(FromPyObject)]
pub enum FocusSetting {
    /// Metres from the film.
    Distance(f64),
    /// The surface that a pixel sees.
    Pixel([u32; 2]),
    /// `"auto"`: the surface in the middle of the picture.
    Word(String),
}

/// Settings of a picture; `None` keeps what the scene says.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Settings<'py> {
    lens: Option<LensSetting<'py>>,
    focus: Option<FocusSetting>,
    fstop: Option<f64>,
    look_at: Option<[f64; 9]>,
    film_shift: Option<[f64; 2]>,
    film_tilt: Option<[f64; 2]>,
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
        checked("time", self.time, |v| v > 0.0 && v < 1e9, "seconds above 0")?;
        if self.spp == Some(0) {
            return Err(value_error("spp=0: expected 1 or more"));
        }
        if self.resolution.is_some_and(|size| size.contains(&0) || size.iter().any(|&n| n > 65_536))
        {
            return Err(value_error("resolution: expected 1 to 65536 pixels in width and height"));
        }
        let focus = match &self.focus {
            None => None,
            Some(FocusSetting::Distance(metres)) if *metres > 0.0 => {
                Some(FocusOn::Distance(*metres))
            }
            Some(FocusSetting::Pixel(pixel)) => Some(FocusOn::Pixel(Some(*pixel))),
            Some(FocusSetting::Word(word)) if word == "auto" => Some(FocusOn::Pixel(None)),
            Some(_) => {
                let expected = "focus: expected metres above 0, a pixel (x, y), or \"auto\"";
                return Err(value_error(expected));
            }
        };
        let lens = match &self.lens {
            None => None,
            Some(LensSetting::File(path)) => Some(path.clone()),
            Some(LensSetting::Read(lens)) => Some(lens.file().to_owned()),
        };
        let viewpoint = match self.look_at {
            None => None,
            Some(numbers) => {
                let text: Vec<String> = numbers.iter().map(f64::to_string).collect();
                let parsed = text.join(",").parse::<Viewpoint>();
                Some(parsed.map_err(|problem| value_error(format!("look_at: {problem}")))?)
            }
        };
        let coating = match self.coating.as_deref() {
            None => None,
            Some(name) => Some(Coating::named(name).ok_or_else(|| {
                let known = Coating::NAMES.join(", ");
                value_error(format!("coating={name:?}: expected one of {known}"))
            })?),
        };
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
        let effects = self.effects.parse();
        let effects =
            effects.map_err(|problem: String| value_error(format!("effects: {problem}")))?;
        Ok(Changes {
            lens,
            focus,
            f_number: self.fstop,
            viewpoint,
            film_shift: self.film_shift,
            film_tilt: self.film_tilt,
            coating,
            resolution: self.resolution,
            crop: self.crop.map(|[left, top, right, bottom]| [[left, top], [right, bottom]]),
            samples: self.spp,
            seed: self.seed,
            effects,
            light_paths: self.light_paths,
            layers: self.aov.iter().map(|name| layer(name)).collect::<PyResult<_>>()?,
            holds_layers: true,
            stop_criteria: StopCriteria {
                noise: self.noise,
                time: self.time.map(Duration::from_secs_f64),
            },
            ..Changes::default()
        })
    }
}
