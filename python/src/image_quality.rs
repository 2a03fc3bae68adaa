//! Image quality of a lens: spots, modulation transfer and point images of its fields.

use numpy::{PyArray1, PyArray2, PyArrayMethods, ToPyArray};
use petzval::Prescription;
use petzval_lens::{FieldKind, SpectralLine};
use petzval_optics::{
    ConditionChoices, FieldCurvePoint, FieldRays, FrequencyAxis, ImagingConditions, ImagingGrid,
    SpotDiagram, TransferMethod,
};
use petzval_spectrum::bands;
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::argument::{Listed, refused};
use crate::error::value_error;
use crate::lens::WAVELENGTHS;
use crate::worker;

/// Real rays of a lens, traced once for all analyses.
#[pyclass(frozen, module = "petzval")]
pub struct ImageQuality {
    quality: petzval_optics::ImageQuality,
    /// The lens, to trace in other light.
    lens: Prescription,
    /// Rays across the pupil.
    pupil: usize,
}

/// Modulation by field and frequency: tangential and sagittal.
type Modulations<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>);

/// A point image and its data.
type PointImage<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyDict>);

/// Largest numbers of fields and of rays across the pupil.
const MOST: [i64; 2] = [1000, 512];
/// Largest number of rays of all fields, for each wavelength; each takes about a hundred bytes.
const MOST_RAYS: i64 = 1 << 23;
/// Channels of a picture.
const CHANNELS: [&str; 3] = ["R", "G", "B"];
/// Largest number of frequencies.
const MOST_FREQUENCIES: usize = 10_000;

impl ImageQuality {
    /// Traces a lens for an object at a distance from the film (mm).
    pub fn new(
        py: Python<'_>,
        lens: &Prescription,
        distance: f64,
        film_distance: Option<f64>,
        image_height: Option<f64>,
        [fields, pupil]: [i64; 2],
    ) -> PyResult<Self> {
        if !(2..=MOST[0]).contains(&fields) || !(4..=MOST[1]).contains(&pupil) {
            return Err(value_error(format!(
                "fields={fields}, rays={pupil}: expected 2 to {} fields and 4 to {} rays",
                MOST[0], MOST[1]
            )));
        }
        if fields * pupil * pupil > MOST_RAYS {
            return Err(value_error(format!(
                "fields={fields}, rays={pupil}: expected fields x rays x rays up to {MOST_RAYS}"
            )));
        }
        let [fields, pupil] = [fields, pupil].map(|count| count as usize);
        let lengths = [Some(distance), film_distance, image_height];
        if lengths.iter().flatten().any(|length| length.is_nan() || *length <= 0.0) {
            return Err(value_error(
                "distance, film_distance and image_height: expected mm above 0",
            ));
        }
        let choices = ConditionChoices { focus: Some(distance), film_distance, image_height };
        let conditions = ImagingConditions::new(lens, choices).map_err(value_error)?;
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let grid = ImagingGrid { fields, pupil, threads };
        let traced =
            worker::run_whole(py, || petzval_optics::ImageQuality::new(lens, conditions, grid))?;
        Ok(Self { quality: traced.map_err(value_error)?, lens: lens.clone(), pupil })
    }

    /// Returns a field by its index.
    fn field(&self, index: i64) -> PyResult<&FieldRays> {
        let count = self.quality.fields.len();
        let problem = || PyIndexError::new_err(format!("field {index}: there are {count}, from 0"));
        let index = usize::try_from(index).map_err(|_| problem())?;
        self.quality.fields.get(index).ok_or_else(problem)
    }

    /// Traces a field in other light.
    fn in_light(
        &self,
        py: Python<'_>,
        field: &FieldRays,
        light: &[SpectralLine],
    ) -> PyResult<FieldRays> {
        let trace = || self.quality.trace_field_in(&self.lens, light, field.field, self.pupil);
        let traced = worker::run_whole(py, trace)?.map_err(value_error)?;
        traced.ok_or_else(|| value_error(NO_LIGHT))
    }
}

/// Why a field has no image.
const NO_LIGHT: &str = "no light reaches the film from this field";

/// Returns the light that a point image is asked for in; `None` is that of the analysis.
fn light(wavelength: Option<f64>, channel: Option<&str>) -> PyResult<Option<Vec<SpectralLine>>> {
    match (wavelength, channel) {
        (None, None) => Ok(None),
        (Some(nm), None) if WAVELENGTHS.contains(&nm) => {
            Ok(Some(vec![SpectralLine { nm, weight: 1.0 }]))
        }
        (Some(nm), None) => {
            let [low, high] = [WAVELENGTHS.start(), WAVELENGTHS.end()];
            Err(value_error(format!("wavelength={nm}: expected nm, from {low} to {high}")))
        }
        (None, Some(name)) => {
            let Some(channel) = CHANNELS.iter().position(|known| *known == name) else {
                let known = CHANNELS.map(|known| format!("{known:?}")).join(", ");
                return Err(value_error(format!("channel={name:?}: expected one of {known}")));
            };
            let lines = bands()
                .into_iter()
                .map(|band| SpectralLine { nm: band.wavelength, weight: band.response[channel] });
            Ok(Some(lines.filter(|line| line.weight > 0.0).collect()))
        }
        (Some(_), Some(_)) => {
            Err(value_error("wavelength and channel: expected one of them, not both"))
        }
    }
}

#[pymethods]
impl ImageQuality {
    /// Fields from the axis to the edge: degrees, or mm, see `field_kind`. Fields that have no chief
    /// ray are left out.
    #[getter]
    fn fields<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let fields: Vec<f64> = self.quality.fields.iter().map(|field| field.field).collect();
        fields.to_pyarray(py)
    }

    /// Meaning of the fields: "angle" (degrees), "object_height" or "image_height" (mm).
    #[getter]
    fn field_kind(&self) -> &'static str {
        match self.quality.conditions.field_kind {
            FieldKind::Angle => "angle",
            FieldKind::ObjectHeight => "object_height",
            FieldKind::ImageHeight => "image_height",
        }
    }

    /// Heights on the film at which the chief rays of the fields arrive (mm).
    #[getter]
    fn image_heights<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let heights = self.quality.fields.iter().map(|field| field.reference.point[1]);
        heights.collect::<Vec<f64>>().to_pyarray(py)
    }

    /// Wavelengths (nm).
    #[getter]
    fn wavelengths(&self) -> Vec<f64> {
        self.quality.conditions.wavelengths.iter().map(|line| line.nm).collect()
    }

    /// Distance of the film from the rear vertex (mm).
    #[getter]
    fn film_distance(&self) -> f64 {
        self.quality.conditions.film_distance
    }

    /// Returns the distortion of the primary wavelength, in `count` steps from the axis to the edge: a
    /// dictionary of arrays with height (mm), distortion and f_theta, which are relative excesses of
    /// the image height over the tangent of the field angle and over the angle; NaN on the axis.
    #[pyo3(signature = (count = 20))]
    fn distortion<'py>(&self, py: Python<'py>, count: i64) -> PyResult<Bound<'py, PyDict>> {
        if !(1..=10_000).contains(&count) {
            return Err(value_error(format!("count={count}: expected 1 to 10000")));
        }
        let primary = self.quality.conditions.primary;
        let curve = worker::run_whole(py, || self.quality.field_curve(primary, count as u32))?;
        let column = |of: &dyn Fn(&FieldCurvePoint) -> f64| {
            curve.iter().map(of).collect::<Vec<f64>>().to_pyarray(py)
        };
        let data = PyDict::new(py);
        data.set_item("height", column(&|point| point.height))?;
        data.set_item("distortion", column(&|point| point.distortion().unwrap_or(f64::NAN)))?;
        data.set_item("f_theta", column(&|point| point.f_theta_distortion().unwrap_or(f64::NAN)))?;
        Ok(data)
    }

    /// Returns the modulation transfer at these frequencies (cycles/mm): two arrays of fields x
    /// frequencies, tangential and sagittal, NaN without light.
    ///
    /// `method` is "diffraction", "geometric" or "limit" (the same pupil without aberrations);
    /// `defocus` moves the film away from the lens (mm).
    #[pyo3(signature = (frequencies, method = "diffraction", defocus = 0.0))]
    fn mtf<'py>(
        &self,
        py: Python<'py>,
        frequencies: &Bound<'py, PyAny>,
        method: &str,
        defocus: f64,
    ) -> PyResult<Modulations<'py>> {
        let method = match method {
            "diffraction" => TransferMethod::Diffraction,
            "geometric" => TransferMethod::Geometric,
            "limit" => TransferMethod::Limit,
            _ => {
                let expected = "expected \"diffraction\", \"geometric\" or \"limit\"";
                return Err(value_error(format!("method={method:?}: {expected}")));
            }
        };
        let expected = "a list of numbers (cycles/mm)";
        let wrong = |error| refused("frequencies", frequencies, expected, error);
        let Listed(frequencies): Listed<f64> = frequencies.extract().map_err(wrong)?;
        if frequencies.len() > MOST_FREQUENCIES {
            let count = frequencies.len();
            return Err(value_error(format!(
                "frequencies: there are {count}; expected {MOST_FREQUENCIES} at most"
            )));
        }
        if !defocus.is_finite() || !frequencies.iter().all(|f| (0.0..1e9).contains(f)) {
            return Err(value_error(
                "expected frequencies from 0 to 1e9 cycles/mm and a finite defocus",
            ));
        }
        let shape = [self.quality.fields.len(), frequencies.len()];
        let [tangential, sagittal] = worker::run_whole(py, || {
            [FrequencyAxis::Y, FrequencyAxis::X].map(|axis| {
                let of_field =
                    |field: &FieldRays| field.modulations(&frequencies, axis, method, defocus);
                let values = self.quality.fields.iter().flat_map(of_field);
                values.map(|value| value.unwrap_or(f64::NAN)).collect::<Vec<f64>>()
            })
        })?;
        Ok((
            PyArray1::from_vec(py, tangential).reshape(shape)?,
            PyArray1::from_vec(py, sagittal).reshape(shape)?,
        ))
    }

    /// Returns the spot of a field, by its index: a dictionary of points (um, N x 2, relative to the
    /// chief ray), light and wavelength (nm) of each ray, centroid, rms and largest radius (um), and
    /// the radius of the Airy disc (um).
    #[pyo3(signature = (field, defocus = 0.0))]
    fn spot<'py>(&self, py: Python<'py>, field: i64, defocus: f64) -> PyResult<Bound<'py, PyDict>> {
        if !defocus.is_finite() {
            return Err(value_error(format!("defocus={defocus}: expected mm")));
        }
        let field = self.field(field)?;
        let spot: SpotDiagram = field.spot();
        let lines = &self.quality.conditions.wavelengths;
        let points: Vec<f64> = spot
            .rays
            .iter()
            .flat_map(|ray| [0, 1].map(|i| 1e3 * (ray.point[i] + defocus * ray.slope[i])))
            .collect();
        let light: Vec<f64> = spot.rays.iter().map(|ray| ray.light).collect();
        let wavelengths: Vec<f64> = spot.rays.iter().map(|ray| lines[ray.wavelength].nm).collect();
        let data = PyDict::new(py);
        data.set_item("points", PyArray1::from_vec(py, points).reshape([light.len(), 2])?)?;
        data.set_item("light", light.to_pyarray(py))?;
        data.set_item("wavelength", wavelengths.to_pyarray(py))?;
        let airy = field.open_grids().next().map(|grid| 1e3 * grid.airy_radius());
        data.set_item("airy_radius", airy)?;
        if let Some(size) = spot.size(defocus, None) {
            data.set_item("centroid", size.centroid.map(|mm| 1e3 * mm))?;
            data.set_item("rms", 1e3 * size.rms)?;
            data.set_item("largest", 1e3 * size.largest)?;
        }
        Ok(data)
    }

    /// Returns the image of a point of a field, by its index, with diffraction: an array of `size` x
    /// `size`, the share of the light per sample, y upwards, and a dictionary of pitch (um), centre
    /// (um, relative to the chief ray) and strehl. `width` is that of the array (um); by default
    /// what the traced rays resolve, at most 100 um.
    ///
    /// The light is that of all `wavelengths`, by their weights. `wavelength` (nm) takes another, alone,
    /// and `channel` that of "R", "G" or "B" of a picture of white light, in bands of 9.5 nm. The film
    /// and the chief ray stay, so that `centre` shows lateral colour; widths of the array are best given
    /// if images are compared. Raises `ValueError` if a glass has no data at a wavelength, or no light
    /// passes.
    #[pyo3(signature = (field, size = 64, width = None, wavelength = None, channel = None))]
    fn psf<'py>(
        &self,
        py: Python<'py>,
        field: i64,
        size: i64,
        width: Option<f64>,
        wavelength: Option<f64>,
        channel: Option<&str>,
    ) -> PyResult<PointImage<'py>> {
        let of_analysis = self.field(field)?;
        let in_other_light;
        let field = match light(wavelength, channel)? {
            None => of_analysis,
            Some(light) => {
                in_other_light = self.in_light(py, of_analysis, &light)?;
                &in_other_light
            }
        };
        if field.open_grids().next().is_none() {
            return Err(value_error(NO_LIGHT));
        }
        let widest = 1e3 * field.resolved_width();
        let width = width.unwrap_or(widest.min(100.0));
        if !((2..=1024).contains(&size) && width > 0.0 && width <= widest) {
            return Err(value_error(format!(
                "size={size}, width={width}: expected 2 to 1024 samples, and a width above 0 up to \
                 {widest:.1} um, which these rays resolve"
            )));
        }
        let size = size as usize;
        let image = worker::run_whole(py, || field.point_image(size, 1e-3 * width))?;
        let image = image.ok_or_else(|| value_error(NO_LIGHT))?;
        let data = PyDict::new(py);
        data.set_item("pitch", 1e3 * image.pitch)?;
        data.set_item("centre", image.centre.map(|mm| 1e3 * mm))?;
        data.set_item("strehl", image.strehl)?;
        Ok((PyArray1::from_vec(py, image.values).reshape([size, size])?, data))
    }
}
