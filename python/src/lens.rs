//! Lenses.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use glam::DVec3;
use numpy::{
    BorrowError, PyArray1, PyArray2, PyArray3, PyArrayMethods, PyUntypedArrayMethods, ToPyArray,
};
use petzval::{Paraxial, Prescription, ReadContext, RealRayFocus};
use petzval_lens::Pose;
use petzval_lens_formats::read_with;
use petzval_optics::{Calibration, CalibrationSetup, DistortionModel, FieldRay, PixelGrid};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use rayon::prelude::*;

use crate::argument::Listed;
use crate::array;
use crate::error::{lens_error, table_error, value_error};
use crate::image_quality::ImageQuality;
use crate::lens_source::{CatalogueSetting, LensFile, LensSource, TableRow};
use crate::trace::{TracedRays, TravelFrom, kernel_seconds, trace};
use crate::worker;

/// Rays behind a lens: points, directions and the surface that blocked each, or 0.
type RayArrays<'py> =
    (Bound<'py, PyArray2<f32>>, Bound<'py, PyArray2<f32>>, Bound<'py, PyArray1<u16>>);

/// A lens: surfaces along an axis, from the scene to the film. Lengths are in mm.
#[pyclass(frozen, module = "petzval")]
pub struct Lens {
    lens: Prescription,
    file: LensFile,
    catalogues: Vec<PathBuf>,
}

/// Largest number of pixels of a map, which is that of a render.
const MOST_PIXELS: i64 = 1 << 27;
/// Range of wavelengths (nm); it catches those that are given in um or m.
pub const WAVELENGTHS: std::ops::RangeInclusive<f64> = 100.0..=1e6;

impl Lens {
    /// Returns its surfaces.
    pub fn prescription(&self) -> &Prescription {
        &self.lens
    }

    /// Returns its file.
    pub fn file(&self) -> &LensFile {
        &self.file
    }

    /// Returns the glass catalogues that it was read with.
    pub fn catalogues(&self) -> &[PathBuf] {
        &self.catalogues
    }
}

impl Lens {
    /// Calibrates the lens on a film of some pixels and of a width (mm).
    fn calibration(
        &self,
        py: Python<'_>,
        [columns, rows]: [i64; 2],
        width: f64,
        distance: f64,
    ) -> PyResult<Calibration> {
        let fits = |side: i64| (1..=MOST_PIXELS).contains(&side);
        if !(fits(columns) && fits(rows) && columns * rows <= MOST_PIXELS) {
            return Err(value_error(format!(
                "resolution=({columns}, {rows}): expected width and height above 0, and \
                 {MOST_PIXELS} pixels at most"
            )));
        }
        if !(width > 0.0 && width.is_finite()) {
            return Err(value_error(format!("width={width}: expected mm above 0")));
        }
        // They are below MOST_PIXELS.
        let resolution = [columns, rows].map(|side| side as u32);
        let setup = CalibrationSetup {
            lens: &self.lens,
            film_distance: self.focus(distance)?,
            film_pose: Pose::ALIGNED,
            pixels: PixelGrid::new(resolution, width),
            ray: FieldRay::default(),
        };
        worker::run_whole(py, || setup.calibrate())?.map_err(value_error)
    }
}

/// Returns the place of every pixel in the other picture, row after row; `None` if no pinhole
/// describes the lens. If `stop` is set, it ends soon, with places missing.
fn calibration_map(
    calibration: &Calibration,
    redistort: bool,
    stop: &AtomicBool,
) -> Option<Vec<[f32; 2]>> {
    let matrix = calibration.pinhole_matrix()?;
    let fit = calibration.suggested();
    let place = |pixel: [f64; 2]| {
        if redistort {
            return calibration.undistorted(&matrix, pixel);
        }
        let [x, y] = [0, 1].map(|i| (pixel[i] - matrix.centre[i]) / matrix.focal[i]);
        let estimate = fit?.project(DVec3::new(x, y, 1.0))?;
        calibration.distorted(&matrix, pixel, estimate)
    };
    let [columns, rows] = calibration.pixels.resolution.map(|side| side as usize);
    let found = (0..rows * columns).into_par_iter().map(|i| {
        if stop.load(Ordering::Relaxed) {
            return [f32::NAN; 2];
        }
        let pixel = [i % columns, i / columns].map(|k| k as f64);
        place(pixel).map_or([f32::NAN; 2], |place| place.map(|x| x as f32))
    });
    Some(found.collect())
}

#[pymethods]
impl Lens {
    /// Reads a lens file, of any format that `petzval lens` reads, or takes rows as `from_table` does.
    ///
    /// `catalogue` is a glass catalogue, an AGF file (Zemax), a folder of them, or a list of these: the
    /// first that has a glass gives it. Renders with the lens use them too.
    #[new]
    #[pyo3(signature = (path, catalogue = CatalogueSetting::default()))]
    fn new(py: Python<'_>, path: LensSource, catalogue: CatalogueSetting) -> PyResult<Self> {
        let path = match path {
            LensSource::File(path) => path,
            LensSource::Table(rows) => return Self::from_table(Listed(rows), "table"),
        };
        let catalogues = catalogue.paths();
        let context = ReadContext::default().with_catalogues(catalogues.iter().cloned());
        let lens = py.detach(|| read_with(&path, &context)).map_err(|error| lens_error(&error))?;
        Ok(Self { lens, file: LensFile::Path(path), catalogues })
    }

    /// Makes a lens of rows (radius, thickness, index, diameter), from the scene to the film, as in
    /// pbrt's tables: a plane has radius 0, and the stop has radius 0 and index 0.
    #[staticmethod]
    #[pyo3(signature = (rows, name = "table"))]
    fn from_table(rows: Listed<TableRow>, name: &str) -> PyResult<Self> {
        if name.contains(['\n', '\r']) {
            return Err(value_error("name: expected one line"));
        }
        let mut text = format!("# {name}\n");
        for row in &rows.0 {
            text.push_str(&row.map(|number| format!("{number:?}")).join(" "));
            text.push('\n');
        }
        let file = LensFile::Table(text.into_bytes().into());
        let read = read_with(file.path(), &file.attach(ReadContext::default()));
        let mut lens = read.map_err(|error| table_error(&error, file.path()))?;
        lens.name = name.to_owned();
        Ok(Self { lens, file, catalogues: Vec::new() })
    }

    /// Its name.
    #[getter]
    fn name(&self) -> &str {
        &self.lens.name
    }

    /// Its file; `None` if it was given as a table.
    #[getter]
    fn path(&self) -> Option<&Path> {
        match &self.file {
            LensFile::Path(path) => Some(path),
            LensFile::Table(_) => None,
        }
    }

    /// Effective focal length (mm).
    #[getter]
    fn efl(&self) -> f64 {
        Paraxial::new(&self.lens).focal_length
    }

    /// Back focal distance: from the rear vertex to the rear focal point (mm).
    #[getter]
    fn bfd(&self) -> f64 {
        Paraxial::new(&self.lens).back_focal_distance
    }

    /// f-number of the marginal ray of an object at infinity, or `None` if no ray passes.
    #[getter]
    fn fno(&self) -> Option<f64> {
        RealRayFocus::new(&self.lens).f_number()
    }

    /// Index of the stop among the surfaces, from 0.
    #[getter]
    fn stop(&self) -> usize {
        self.lens.stop()
    }

    /// Surfaces: a list of dictionaries with radius (inf: plane), conic, asphere, thickness, index,
    /// diameter and stop.
    #[getter]
    fn surfaces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let surfaces = PyList::empty(py);
        for row in self.lens.rows.iter() {
            let data = PyDict::new(py);
            data.set_item("radius", if row.is_plane() { f64::INFINITY } else { row.radius })?;
            data.set_item("conic", row.conic)?;
            data.set_item("asphere", row.asphere.clone())?;
            data.set_item("thickness", row.thickness)?;
            data.set_item("index", row.index)?;
            data.set_item("diameter", row.diameter)?;
            data.set_item("stop", row.stop)?;
            surfaces.append(data)?;
        }
        Ok(surfaces)
    }

    /// Returns the distance of the film from the rear vertex (mm) at which an object is sharpest.
    /// `distance` is that of the object from the film (mm).
    #[pyo3(signature = (distance = f64::INFINITY))]
    fn focus(&self, distance: f64) -> PyResult<f64> {
        if distance.is_nan() {
            return Err(value_error("distance=NaN: expected mm"));
        }
        RealRayFocus::new(&self.lens).film_distance(distance).map_err(value_error)
    }

    /// Traces rays through the lens: eight at a time, on all cores.
    ///
    /// `points` (mm) and `directions` have the shape 3 x N; float32 arrays in C order are read
    /// without a copy. From `side` "scene", points are relative to the front vertex, and +z leads
    /// to the film; from "film", they are relative to the rear vertex, and +z leads to the scene.
    /// Rays start before the lens, at z <= 0.
    ///
    /// Returns points and unit directions behind the last surface, relative to its vertex, in the
    /// same frame, and the status: 0 for rays that pass, otherwise the number of the surface that
    /// ended them, counted from 1 at the scene; their points and directions are NaN.
    ///
    /// `wavelength` is in nm; by default the d line. `out`, the three arrays of an earlier call, takes
    /// the result: new memory can cost as much time as the rays.
    #[pyo3(signature = (points, directions, wavelength = None, side = "scene", out = None))]
    fn trace<'py>(
        &self,
        py: Python<'py>,
        points: &Bound<'py, PyAny>,
        directions: &Bound<'py, PyAny>,
        wavelength: Option<f64>,
        side: &str,
        out: Option<Bound<'py, PyAny>>,
    ) -> PyResult<RayArrays<'py>> {
        let from = TravelFrom::named(side)?;
        let coloured;
        let lens = match wavelength {
            None => &self.lens,
            Some(nm) if !WAVELENGTHS.contains(&nm) => {
                let [low, high] = [WAVELENGTHS.start(), WAVELENGTHS.end()];
                return Err(value_error(format!(
                    "wavelength={nm}: expected nm, from {low} to {high}"
                )));
            }
            Some(nm) => {
                coloured = self.lens.at_wavelength(nm).map_err(value_error)?;
                &coloured
            }
        };
        let [points, directions] =
            [array::floats("points", points)?, array::floats("directions", directions)?];
        let count = array::columns("points", &points)?;
        let other = array::columns("directions", &directions)?;
        if count != other {
            return Err(value_error(format!("{count} points but {other} directions")));
        }
        let (points, directions) = (points.as_slice()?, directions.as_slice()?);
        let expected = format!(
            "expected arrays in C order: float32 of 3 x {count}, twice, and uint16 of {count}"
        );
        let arrays: RayArrays<'py> = match out {
            Some(out) => {
                let wrong = |_| PyTypeError::new_err(format!("out: {expected}"));
                out.extract().map_err(wrong)?
            }
            None => (
                PyArray2::zeros(py, [3, count], false),
                PyArray2::zeros(py, [3, count], false),
                PyArray1::zeros(py, count, false),
            ),
        };
        let fits = |array: &Bound<'py, PyArray2<f32>>| {
            array.shape() == [3, count] && array.is_c_contiguous()
        };
        let status = arrays.2.shape() == [count] && arrays.2.is_c_contiguous();
        if !(fits(&arrays.0) && fits(&arrays.1) && status) {
            return Err(value_error(format!("out: {expected}")));
        }
        let refused = |error: BorrowError| value_error(format!("out: {error}"));
        let mut to_points = arrays.0.try_readwrite().map_err(refused)?;
        let mut to_directions = arrays.1.try_readwrite().map_err(refused)?;
        let mut to_status = arrays.2.try_readwrite().map_err(refused)?;
        let traced = TracedRays {
            points: to_points.as_slice_mut()?,
            directions: to_directions.as_slice_mut()?,
            status: to_status.as_slice_mut()?,
        };
        worker::caught(py, || trace(lens, from, points, directions, traced))?;
        drop((to_points, to_directions, to_status));
        Ok(arrays)
    }

    /// Returns the time (s) that the kernel of `trace` takes for these rays on one thread, for benchmarks.
    fn _kernel_seconds(
        &self,
        py: Python<'_>,
        points: &Bound<'_, PyAny>,
        directions: &Bound<'_, PyAny>,
    ) -> PyResult<f64> {
        let [points, directions] =
            [array::floats("points", points)?, array::floats("directions", directions)?];
        if array::columns("points", &points)? != array::columns("directions", &directions)? {
            return Err(value_error("expected as many directions as points"));
        }
        let (points, directions) = (points.as_slice()?, directions.as_slice()?);
        worker::caught(py, || kernel_seconds(&self.lens, points, directions))
    }

    /// Fits a camera model to the lens on a film.
    ///
    /// `resolution` is in pixels, `width` that of the film (mm), and `distance` that of the plane
    /// in focus from the film (mm). `model` is one of radtan, brown-conrady, rational, thin-prism
    /// and kannala-brandt; by default the simplest that fits.
    ///
    /// Returns a dictionary: model, matrix (3 x 3, pixels; the centre of the first pixel is 0, 0),
    /// distortion with its names, in OpenCV's order, and rms and max error in pixels.
    #[pyo3(signature = (resolution, width, distance = f64::INFINITY, model = None))]
    fn intrinsics<'py>(
        &self,
        py: Python<'py>,
        resolution: [i64; 2],
        width: f64,
        distance: f64,
        model: Option<&str>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let named = |model: DistortionModel| model.name();
        let model = match model {
            None => None,
            Some(name) => {
                let found = DistortionModel::ALL.into_iter().find(|&model| named(model) == name);
                let known = DistortionModel::ALL.map(named).join(", ");
                let problem = format!("model={name:?}: expected one of {known}");
                Some(found.ok_or_else(|| value_error(problem))?)
            }
        };
        let calibration = self.calibration(py, resolution, width, distance)?;
        let fit = match model {
            None => calibration.suggested(),
            Some(model) => {
                let tried = calibration.models.iter().find(|(tried, _)| *tried == model);
                if let Some((_, Err(misfit))) = tried {
                    return Err(value_error(format!("{}: {misfit}", model.name())));
                }
                calibration.fitted(model)
            }
        };
        let fit = fit.ok_or_else(|| value_error("no camera model describes this lens"))?;
        let data = PyDict::new(py);
        data.set_item("model", fit.model.name())?;
        let matrix = fit.matrix.rows().map(|row| row.to_vec()).to_vec();
        data.set_item("matrix", PyArray2::from_vec2(py, &matrix)?)?;
        data.set_item("distortion", fit.coefficients.to_pyarray(py))?;
        data.set_item("names", fit.model.coefficient_names())?;
        data.set_item("rms", fit.residual.rms)?;
        data.set_item("max", fit.residual.max)?;
        Ok(data)
    }

    /// Maps pixels of a photograph to those of a pinhole camera of the same middle, or back.
    ///
    /// Returns an array of float32, height x width x 2: for each pixel of the straight picture, the
    /// place (x, y) in the photograph from which to take its colour, as `cv2.remap` reads it; with
    /// `redistort`, for each pixel of the photograph its place in the straight picture. Pixels
    /// without a place are NaN. Arguments are those of `intrinsics`.
    #[pyo3(signature = (resolution, width, distance = f64::INFINITY, redistort = false))]
    fn st_map<'py>(
        &self,
        py: Python<'py>,
        resolution: [i64; 2],
        width: f64,
        distance: f64,
        redistort: bool,
    ) -> PyResult<Bound<'py, PyArray3<f32>>> {
        let calibration = self.calibration(py, resolution, width, distance)?;
        let stop = AtomicBool::new(false);
        let work = || calibration_map(&calibration, redistort, &stop);
        let places = worker::run(py, &stop, |_| Ok(()), work)?;
        let places = places.ok_or_else(|| value_error("no pinhole describes this lens"))?;
        let [columns, rows] = resolution.map(|side| side as usize);
        places.as_flattened().to_pyarray(py).reshape([rows, columns, 2])
    }

    /// Returns the modulation transfer by field and frequency (cycles/mm), tangential and sagittal, as
    /// `ImageQuality.mtf` does; `conditions` are the arguments of `image_quality`.
    #[pyo3(signature = (frequencies, **conditions))]
    fn mtf<'py>(
        slf: &Bound<'py, Self>,
        frequencies: &Bound<'py, PyAny>,
        conditions: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        slf.call_method("image_quality", (), conditions)?.call_method1("mtf", (frequencies,))
    }

    /// Returns the distortion by image height, in `count` steps, as `ImageQuality.distortion` does;
    /// `conditions` are the arguments of `image_quality`.
    #[pyo3(signature = (count = 20, **conditions))]
    fn distortion<'py>(
        slf: &Bound<'py, Self>,
        count: i64,
        conditions: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        slf.call_method("image_quality", (), conditions)?.call_method1("distortion", (count,))
    }

    /// Returns the point image of a field, from 0 on the axis, and its data, as `ImageQuality.psf`
    /// does, in the light of a `wavelength` (nm) or of a `channel` ("R", "G" or "B") if one is given;
    /// `conditions` are the arguments of `image_quality`.
    #[pyo3(signature = (field = 0, size = 64, wavelength = None, channel = None, **conditions))]
    fn psf<'py>(
        slf: &Bound<'py, Self>,
        field: i64,
        size: i64,
        wavelength: Option<f64>,
        channel: Option<&str>,
        conditions: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let quality = slf.call_method("image_quality", (), conditions)?;
        let arguments = (field, size, None::<f64>, wavelength, channel);
        quality.call_method1("psf", arguments)
    }

    /// Traces the lens for an object at a distance from the film (mm): spots, MTF and point images.
    ///
    /// `film_distance` is that of the film from the rear vertex (mm), by default the sharpest;
    /// `image_height` the largest (mm), by default the field of the lens file or of the lens;
    /// `fields` the number of fields from the axis to the edge, and `rays` that across the pupil.
    #[pyo3(signature = (distance = f64::INFINITY, film_distance = None, image_height = None, fields = 5, rays = 64))]
    fn image_quality(
        &self,
        py: Python<'_>,
        distance: f64,
        film_distance: Option<f64>,
        image_height: Option<f64>,
        fields: i64,
        rays: i64,
    ) -> PyResult<ImageQuality> {
        ImageQuality::new(py, &self.lens, distance, film_distance, image_height, [fields, rays])
    }

    /// Returns first-order data, spots (rms, um), modulation transfer and distortion by field, as a
    /// dictionary that JSON can hold. `conditions` are `frequencies` (cycles/mm) and the arguments of
    /// `image_quality`.
    #[pyo3(signature = (**conditions))]
    fn report<'py>(
        slf: &Bound<'py, Self>,
        conditions: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("petzval.report")?.call_method("report", (slf,), conditions)
    }

    /// Draws the section with rays from infinity, by matplotlib. Returns the axes.
    ///
    /// `ax` are axes of matplotlib, by default new ones; `rays` is the number of rays, and
    /// `film_distance` the distance of the film from the rear vertex (mm), by default in focus.
    #[pyo3(signature = (ax = None, rays = 9, film_distance = None))]
    fn draw<'py>(
        slf: &Bound<'py, Self>,
        ax: Option<Bound<'py, PyAny>>,
        rays: i64,
        film_distance: Option<f64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let module = slf.py().import("petzval.drawing")?;
        module.call_method1("draw", (slf, ax, rays, film_distance))
    }

    /// Returns the drawing of the section with rays as the text of an SVG file; arguments are those of
    /// `draw`. It needs no matplotlib.
    #[pyo3(signature = (rays = 9, film_distance = None))]
    fn svg<'py>(
        slf: &Bound<'py, Self>,
        rays: i64,
        film_distance: Option<f64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("petzval.drawing")?.call_method1("svg", (slf, rays, film_distance))
    }

    /// Returns the drawing as SVG; notebooks show it.
    fn _repr_svg_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        Self::svg(slf, 9, None)
    }

    fn __repr__(&self) -> String {
        format!(
            "<petzval.Lens {:?}: {} surfaces, {:.4} mm>",
            self.lens.name,
            self.lens.rows.len(),
            self.efl()
        )
    }
}
