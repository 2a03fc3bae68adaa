//! Sensors: readings of arrays.

use std::path::{Path, PathBuf};

use numpy::{IxDyn, PyArrayDyn, PyArrayMethods, ToPyArray};
use petzval::Picture;
use petzval_render::sensor::SensorSettings;
use pyo3::prelude::*;
use pyo3::types::PyType;

use crate::array;
use crate::error::value_error;
use crate::worker;

/// A sensor at one speed, which reads arrays of light out as `petzval render --sensor` does.
///
/// `settings` are those of `sensor=`, such as "iso=800,read=2.5,bayer=rggb" or "camera.toml,iso=800". `iso`, `pitch` (um)
/// and `seconds` are those of film and shutter, which the settings replace.
#[pyclass(frozen, eq, module = "petzval")]
#[derive(PartialEq)]
pub struct Sensor {
    sensor: petzval_render::sensor::Sensor,
}

/// A sensor reading as an array: values, and whether they are of one channel.
struct Reading {
    picture: Picture,
    grey: bool,
}

impl Sensor {
    fn read(&self, py: Python<'_>, pixels: &Bound<'_, PyAny>, seed: u32) -> PyResult<Reading> {
        let (picture, grey) = array::picture("pixels", pixels)?;
        let read = || self.sensor.read_out(picture, [0, 0], seed);
        let picture = worker::caught(py, read)?;
        Ok(Reading { picture, grey: grey || self.sensor.bayer.is_some() })
    }

    /// Returns the codes from black to the value 1.
    fn code_span(&self) -> f64 {
        f64::from(self.sensor.max_code() - self.sensor.black_level)
    }
}

#[pymethods]
impl Sensor {
    #[new]
    #[pyo3(signature = (settings = PathBuf::new(), *, iso = 100.0, pitch = 6.0, seconds = 0.01))]
    fn new(settings: PathBuf, iso: f64, pitch: f64, seconds: f64) -> PyResult<Self> {
        // The path of a sensor file is settings too.
        let settings = &*settings.to_string_lossy();
        let parsed = SensorSettings::parse_in(Path::new(""), settings)
            .map_err(|problem| value_error(format!("settings={settings:?}: {problem}")))?;
        for (name, value, low, high) in
            [("iso", iso, 1.0, 1e7), ("pitch", pitch, 0.1, 1e4), ("seconds", seconds, 0.0, 1e9)]
        {
            if !(low..=high).contains(&value) {
                return Err(value_error(format!("{name}={value}: expected {low} to {high}")));
            }
        }
        if parsed.microlenses.is_some() {
            let problem = "microlens loses light by the angle behind a lens; expected it in 'sensor' of a render";
            return Err(value_error(format!("settings={settings:?}: {problem}")));
        }
        Ok(Self { sensor: parsed.sensor(iso, pitch, seconds) })
    }

    /// The settings that readings depend on, in the form of `settings`.
    #[getter]
    fn settings(&self) -> String {
        self.sensor.to_string()
    }

    /// ISO speed.
    #[getter]
    fn iso(&self) -> f64 {
        self.sensor.iso
    }

    /// Full well of a pixel (electrons).
    #[getter]
    fn full_well(&self) -> f64 {
        self.sensor.full_well
    }

    /// Electrons that the value 1 stands for.
    #[getter]
    fn white_electrons(&self) -> f64 {
        self.sensor.white_electrons()
    }

    /// System gain (codes per electron).
    #[getter]
    fn gain(&self) -> f64 {
        self.code_span() / self.sensor.white_electrons()
    }

    /// Read noise of a pixel (electrons).
    #[getter]
    fn read_noise(&self) -> f64 {
        self.sensor.read_noise.pixel
    }

    /// Dark current of a pixel (electrons a second).
    #[getter]
    fn dark_current(&self) -> f64 {
        self.sensor.dark_current
    }

    /// Sensitivity relative to that of a second photosite; 1 without one.
    #[getter]
    fn hdr(&self) -> f64 {
        self.sensor.hdr
    }

    /// Bits of a code.
    #[getter]
    fn bits(&self) -> u32 {
        self.sensor.bits
    }

    /// Code of no light.
    #[getter]
    fn black_level(&self) -> u32 {
        self.sensor.black_level
    }

    /// Pattern of the mosaic; None without one.
    #[getter]
    fn bayer(&self) -> Option<String> {
        self.sensor.bayer.map(|bayer| bayer.to_string())
    }

    /// Reads light out, relative to white: float32 of height x width x 3, of height x width for light of one channel and for a
    /// mosaic. The noise follows `seed`, fixed patterns follow the setting `pattern`.
    #[pyo3(signature = (pixels, seed = 0))]
    fn read_out<'py>(
        &self,
        py: Python<'py>,
        pixels: &Bound<'py, PyAny>,
        seed: u32,
    ) -> PyResult<Bound<'py, PyArrayDyn<f32>>> {
        let Reading { picture, grey } = self.read(py, pixels, seed)?;
        array::of_picture(py, &picture, grey)
    }

    /// Reads light out as codes (DN): uint32 of the same shape as `read_out`.
    #[pyo3(signature = (pixels, seed = 0))]
    fn codes<'py>(
        &self,
        py: Python<'py>,
        pixels: &Bound<'py, PyAny>,
        seed: u32,
    ) -> PyResult<Bound<'py, PyArrayDyn<u32>>> {
        let Reading { picture, grey } = self.read(py, pixels, seed)?;
        let code = |value: f32| {
            let code = f64::from(self.sensor.black_level) + f64::from(value) * self.code_span();
            // Values are those of whole codes, but for rounding.
            code.round() as u32
        };
        let [width, height] = picture.size;
        let pixels = picture.pixels.iter();
        let (codes, shape): (Vec<u32>, _) = match grey {
            true => (pixels.map(|[value, ..]| code(*value)).collect(), vec![height, width]),
            false => (pixels.flatten().map(|value| code(*value)).collect(), vec![height, width, 3]),
        };
        codes.to_pyarray(py).reshape(IxDyn(&shape))
    }

    /// Returns the noise of grey of a value, % of the signal: 100 / SNR.
    fn relative_noise(&self, value: f64) -> f64 {
        self.sensor.relative_noise(value)
    }

    /// The same sensor, for copies in other processes.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> (Bound<'py, PyType>, (String,)) {
        (slf.get_type(), (slf.get().sensor.to_string(),))
    }

    fn __repr__(&self) -> String {
        format!("<petzval.Sensor {}>", self.sensor)
    }
}
