//! Pictures as arrays.

use std::path::PathBuf;

use numpy::{
    IntoPyArray, Ix3, PyArray1, PyArray3, PyArrayDyn, PyArrayMethods, PyUntypedArrayMethods,
    ToPyArray,
};
use petzval::{DisplayExposure, EncodingOptions, Picture};
use petzval_base::io::{FileLog, OutputFile, ReadContext};
use petzval_image::{
    BitDepth, ImageFormat, ImageLayer, Notes, PictureLayers, PictureWindow, RawFormat,
    SPECTRAL_LAYER, channel_wavelength,
};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::argument::{Listed, refused};
use crate::array;
use crate::error::{image_error, value_error};

/// A rendered picture, in linear sRGB.
#[pyclass(frozen, module = "petzval")]
pub struct Image {
    /// Pixels: an array of float32, height x width x 3, row 0 at the top. The mosaic of a sensor is
    /// height x width: one reading for each pixel.
    #[pyo3(get)]
    pixels: Py<PyArrayDyn<f32>>,
    /// Layers by name: arrays of float32, height x width x channels.
    #[pyo3(get)]
    layers: Py<PyDict>,
    /// Names of the channels of each layer.
    #[pyo3(get)]
    channels: Py<PyDict>,
    /// Lens, focus, exposure and the like, by name.
    #[pyo3(get)]
    metadata: Py<PyDict>,
    notes: Notes,
    window: PictureWindow,
    /// The sensor of a mosaic.
    raw: Option<RawFormat>,
    /// The files that the picture was rendered from, which it must not replace.
    inputs: FileLog,
}

/// Exposure of formats for display: stops, or `"auto"`.
pub enum ExposureSetting {
    /// Stops.
    Stops(f64),
    /// `"auto"`.
    Word(String),
}

impl<'py> FromPyObject<'_, 'py> for ExposureSetting {
    type Error = PyErr;

    fn extract(value: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        if let Ok(word) = value.extract() {
            return Ok(Self::Word(word));
        }
        let expected = "stops or \"auto\"";
        let stops = value.extract().map_err(|error| refused("exposure", &value, expected, error));
        stops.map(Self::Stops)
    }
}

impl ExposureSetting {
    pub fn exposure(&self) -> PyResult<DisplayExposure> {
        let text = match self {
            Self::Stops(stops) => stops.to_string(),
            Self::Word(word) => word.clone(),
        };
        text.parse().map_err(|problem| value_error(format!("exposure={text:?}: {problem}")))
    }
}

/// Returns the bits of a channel.
pub fn bits_of(bits: u32) -> PyResult<BitDepth> {
    match bits {
        8 => Ok(BitDepth::Eight),
        16 => Ok(BitDepth::Sixteen),
        _ => Err(value_error(format!("bit_depth={bits}: expected 8 or 16"))),
    }
}

/// Arrays of layers by name, height x width x channels, and the names of their channels.
type LayerArrays<'py> = (Bound<'py, PyDict>, Bound<'py, PyDict>);

/// Makes arrays of the layers of a picture of this size.
fn layer_arrays<'py>(
    py: Python<'py>,
    [width, height]: [usize; 2],
    layers: Vec<ImageLayer>,
) -> PyResult<LayerArrays<'py>> {
    let (by_name, channels) = (PyDict::new(py), PyDict::new(py));
    for ImageLayer { name, channels: columns, .. } in layers {
        let count = columns.len();
        let mut values = vec![0.0; width * height * count];
        for (k, (_, column)) in columns.iter().enumerate() {
            for (value, from) in values.iter_mut().skip(k).step_by(count).zip(column) {
                *value = *from;
            }
        }
        by_name.set_item(&name, values.to_pyarray(py).reshape([height, width, count])?)?;
        let names: Vec<&str> = columns.iter().map(|(name, _)| name.as_str()).collect();
        channels.set_item(&name, names)?;
    }
    Ok((by_name, channels))
}

/// Column and row of the first pixel in the whole frame.
type Corner = (i32, i32);
/// Width and height.
type Size = (usize, usize);

/// Reads the layers of an OpenEXR file: arrays by name and names of channels; column and row of the first pixel in the whole
/// frame; width and height.
#[pyfunction]
pub fn read_layers(py: Python<'_>, path: PathBuf) -> PyResult<(LayerArrays<'_>, Corner, Size)> {
    let read = py.detach(|| PictureLayers::read(&path, &ReadContext::default()));
    let found = read.map_err(|error| image_error(&error))?;
    let (origin, size) = (found.origin.into(), found.size.into());
    Ok((layer_arrays(py, found.size, found.layers)?, origin, size))
}

impl Image {
    /// Makes arrays of a picture and its layers. The channels of a mosaic are equal.
    #[expect(clippy::too_many_arguments, reason = "one for each field")]
    pub fn new(
        py: Python<'_>,
        picture: &Picture,
        raw: Option<RawFormat>,
        layers: Vec<ImageLayer>,
        metadata: Py<PyDict>,
        notes: Notes,
        window: PictureWindow,
        inputs: FileLog,
    ) -> PyResult<Self> {
        let [width, height] = picture.size;
        let pixels = array::of_picture(py, picture, raw.is_some())?;
        let (by_name, channels) = layer_arrays(py, [width, height], layers)?;
        Ok(Self {
            pixels: pixels.unbind(),
            layers: by_name.unbind(),
            channels: channels.unbind(),
            metadata,
            notes,
            window,
            raw,
            inputs,
        })
    }

    /// Returns the picture as it is now in the array, and whether it is grey.
    fn picture(&self, py: Python<'_>) -> PyResult<(Picture, bool)> {
        array::picture("pixels", self.pixels.bind(py).as_any())
    }

    /// Returns the layers as they are now in their arrays.
    fn image_layers(&self, py: Python<'_>) -> PyResult<Vec<ImageLayer>> {
        let (layers, names) = (self.layers.bind(py), self.channels.bind(py));
        let mut result = Vec::new();
        for (name, array) in layers.iter() {
            let name: String = name
                .extract()
                .map_err(|_| PyTypeError::new_err("layers: the name of a layer is no text"))?;
            let what = format!("layers: {name:?}");
            let array = array::floats(&what, &array)?;
            let names: Vec<String> = match names.get_item(&name)? {
                Some(names) => names.extract().map(|Listed(names)| names).map_err(|_: PyErr| {
                    PyTypeError::new_err(format!("channels: {name:?}: expected a list of names"))
                })?,
                None => {
                    return Err(value_error(format!("layers: {name:?} has no names in channels")));
                }
            };
            let view = array.as_array();
            let (of_picture, of_layer) = (self.pixels.bind(py).shape(), view.shape());
            if of_layer.len() != 3 || of_layer[..2] != of_picture[..2] {
                return Err(value_error(format!(
                    "{what}: the array is {}; expected {} x {} x channels",
                    array::shown(of_layer),
                    of_picture[0],
                    of_picture[1]
                )));
            }
            let view = view.into_dimensionality::<Ix3>().map_err(value_error)?;
            if names.len() != view.dim().2 {
                return Err(value_error(format!(
                    "layers: {name:?} has {} channels, and names for {}",
                    view.dim().2,
                    names.len()
                )));
            }
            let column = |k: usize| view.rows().into_iter().map(|row| row[k]).collect();
            let channels = names.into_iter().enumerate().map(|(k, name)| (name, column(k)));
            result.push(ImageLayer::new(&name, channels.collect()));
        }
        Ok(result)
    }
}

#[pymethods]
impl Image {
    /// Width and height in pixels.
    #[getter]
    fn size(&self, py: Python<'_>) -> (usize, usize) {
        let shape = self.pixels.bind(py).shape();
        (shape[1], shape[0])
    }

    /// Spectral radiance of a film with buckets of wavelength: an array of float32, height x width x
    /// buckets, the layer "S0"; None for other films.
    #[getter]
    fn spectrum<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.layers.bind(py).get_item(SPECTRAL_LAYER)
    }

    /// Wavelengths in the middle of the buckets (nm), an array of float64; None for other films.
    #[getter]
    fn wavelengths<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray1<f64>>>> {
        let Some(names) = self.channels.bind(py).get_item(SPECTRAL_LAYER)? else { return Ok(None) };
        let names: Vec<String> = names.extract()?;
        let wavelengths: Option<Vec<f64>> =
            names.iter().map(|name| channel_wavelength(name)).collect();
        let problem = "channels: those of \"S0\" are called by wavelengths, such as \"500,000nm\"";
        Ok(Some(wavelengths.ok_or_else(|| value_error(problem))?.into_pyarray(py)))
    }

    /// Writes the picture: .exr (linear, with all layers), .png or .tif (with the layer alpha), .jpg, the codes
    /// of a mosaic, .dng, or the spectrum, or else the pixels, as an array, .npy.
    ///
    /// `exposure` is the brightness of PNG, JPEG and TIFF in stops, or "auto". `half` writes 16-bit floats
    /// to EXR, `multipart` a part for each layer. `bit_depth` is that of PNG, 8 by default, or 16. A mosaic makes a file of one channel, `Y` in EXR. A file is replaced as a whole or not at all. Raises `ValueError` for a file of the scene
    /// or the lens.
    #[pyo3(signature = (path, exposure = ExposureSetting::Stops(0.0), half = false, bit_depth = None, multipart = false))]
    fn save(
        &self,
        py: Python<'_>,
        path: PathBuf,
        exposure: ExposureSetting,
        half: bool,
        bit_depth: Option<u32>,
        multipart: bool,
    ) -> PyResult<()> {
        let exposure = exposure.exposure()?;
        let bit_depth = bit_depth.map(bits_of).transpose()?;
        let (picture, grey) = self.picture(py)?;
        let raw = self.raw;
        let encoding = EncodingOptions {
            exposure,
            half,
            multipart,
            bit_depth,
            grey,
            raw,
            ..EncodingOptions::default()
        };
        let format = ImageFormat::of(&path).ok();
        let mut layers = match format {
            Some(ImageFormat::Exr | ImageFormat::Png | ImageFormat::Tiff | ImageFormat::Npy) => {
                self.image_layers(py)?
            }
            _ => Vec::new(),
        };
        layers.retain(|layer| format.is_some_and(|format| format.holds(&layer.name)));
        let file = OutputFile::new(path, &self.inputs).map_err(value_error)?;
        py.detach(|| picture.write_with_layers(&layers, &file, self.window, encoding, &self.notes))
            .map_err(|error| image_error(&error))
    }

    /// Returns the picture without noise, by Open Image Denoise (`pip install pyoidn`).
    ///
    /// The layers albedo and normal keep textures and edges, if the picture has them. The noisy
    /// picture becomes the layer "noisy", unless there is one from an earlier call.
    fn denoise(&self, py: Python<'_>) -> PyResult<Self> {
        if self.pixels.bind(py).ndim() != 3 {
            return Err(value_error(
                "a mosaic cannot be denoised: denoise the picture without the sensor's mosaic",
            ));
        }
        let layers = self.layers.bind(py).copy()?;
        let channels = self.channels.bind(py).copy()?;
        let arguments = (&self.pixels, layers.get_item("albedo")?, layers.get_item("normal")?);
        let denoised = py.import("petzval.denoise")?.call_method1("denoised", arguments)?;
        if !layers.contains("noisy")? {
            layers.set_item("noisy", &self.pixels)?;
            channels.set_item("noisy", ["R", "G", "B"])?;
        }
        Ok(Self {
            pixels: denoised.extract::<Bound<'_, PyArray3<f32>>>()?.to_dyn().clone().unbind(),
            layers: layers.unbind(),
            channels: channels.unbind(),
            metadata: self.metadata.clone_ref(py),
            notes: self.notes.clone(),
            window: self.window,
            raw: self.raw,
            inputs: self.inputs.clone(),
        })
    }

    /// Returns the picture as a PNG file; notebooks show it.
    fn _repr_png_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let (picture, _) = self.picture(py)?;
        let file = py.detach(|| picture.png(DisplayExposure::Auto.factor(&picture)))?;
        Ok(PyBytes::new(py, &file))
    }

    /// The pixels, for NumPy's functions.
    #[pyo3(signature = (dtype = None, copy = None))]
    fn __array__<'py>(
        &self,
        py: Python<'py>,
        dtype: Option<Bound<'py, PyAny>>,
        copy: Option<bool>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let pixels = self.pixels.bind(py).as_any();
        let array = match dtype {
            Some(dtype) => pixels.call_method1("astype", (dtype,))?,
            None => pixels.clone(),
        };
        if copy == Some(true) { array.call_method0("copy") } else { Ok(array) }
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let (width, height) = self.size(py);
        format!("<petzval.Image of {width} x {height} pixels>")
    }
}
