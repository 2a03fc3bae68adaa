//! Scenes of arrays: reads the values of Python, and assembles the scene.

use numpy::{
    PyArrayDescrMethods, PyArrayDyn, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods,
};
use petzval::{Description, ReadContext};
use petzval_scene_formats::pbrt::{KindSpec, MeshSpec, ParameterValue, SceneAssembly, ViewSpec};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyMapping, PyString};

use crate::argument::{about, refused};
use crate::array;
use crate::error::{read_error, scene_error, value_error};
use crate::lens_source::LensFile;
use crate::settings::LensSetting;
use crate::worker;

/// Most vertices or faces of a mesh. A broadcast view states far more than there is memory for.
const MOST: usize = 1 << 28;

/// A scene of arrays, of which `Scene` is made.
#[pyclass(frozen, module = "petzval._petzval")]
pub struct ArrayScene {
    pub description: Description,
}

/// A `petzval.Mesh`.
#[derive(FromPyObject)]
pub struct MeshArrays<'py> {
    vertices: Bound<'py, PyAny>,
    faces: Bound<'py, PyAny>,
    normals: Option<Bound<'py, PyAny>>,
    uv: Option<Bound<'py, PyAny>>,
    material: Bound<'py, PyAny>,
    emission: Option<Bound<'py, PyAny>>,
}

/// Returns the scene of some meshes and lights, before the camera of a lens. `view` is resolution, look-at,
/// diagonal, focus, samples a pixel and largest depth, which are checked already. Ctrl-C ends the wait.
#[pyfunction]
pub fn scene_of_arrays(
    py: Python<'_>,
    meshes: Vec<MeshArrays<'_>>,
    lights: Vec<Bound<'_, PyAny>>,
    lens: Bound<'_, PyAny>,
    view: ([u32; 2], [[f64; 3]; 3], f64, f64, u32, u32),
) -> PyResult<ArrayScene> {
    let (resolution, look_at, diagonal, focus, spp, max_depth) = view;
    let file = lens.extract::<LensSetting<'_>>();
    let file = file.map_err(|error| refused("lens", &lens, LensSetting::EXPECTED, error))?;
    let (file, context) = (file.into_file(), ReadContext::default());
    // The lens is that of now, even if its file changes.
    let context = match &file {
        LensFile::Table(_) => file.attach(context),
        LensFile::Path(path) => {
            let content = context.bytes(path).map_err(|error| read_error(&error))?;
            context.with_lens(path.clone(), content)
        }
    };
    let lens = file.path().to_owned();
    let view = ViewSpec { lens, look_at, focus, resolution, diagonal, spp, max_depth };
    let lights = lights.iter().enumerate().map(|(i, light)| {
        let name = format!("light {i}");
        kind(&name, light).map(|light| (name, light))
    });
    let lights = lights.collect::<PyResult<Vec<_>>>()?;
    let meshes = meshes.into_iter().enumerate().map(|(i, arrays)| {
        let name = format!("mesh {i}");
        mesh(&name, arrays).map(|mesh| (name, mesh))
    });
    let meshes = meshes.collect::<PyResult<Vec<_>>>()?;
    let shared = context.clone();
    let work = move || {
        let mut scene = SceneAssembly::new(&view, &shared)?;
        lights.into_iter().for_each(|(name, light)| scene.add_light(&name, light));
        meshes.into_iter().for_each(|(name, mesh)| scene.add_mesh(&name, mesh));
        scene.finish()
    };
    let description = worker::run_or_abandon(py, || context.stop(), work)?;
    let description = description.map_err(|errors| scene_error(&errors))?;
    Ok(ArrayScene { description })
}

fn mesh(what: &str, arrays: MeshArrays<'_>) -> PyResult<MeshSpec> {
    let MeshArrays { vertices, faces, normals, uv, material, emission } = arrays;
    Ok(MeshSpec {
        vertices: rows(what, "vertices", &vertices)?,
        normals: normals.map(|normals| rows(what, "normals", &normals)).transpose()?,
        uv: uv.map(|uv| rows(what, "uv", &uv)).transpose()?,
        faces: triangles(what, &faces)?,
        material: kind(&format!("the material of {what}"), &material)?,
        emission: emission.map(|emission| radiance(what, &emission)).transpose()?,
    })
}

/// Returns the rows of an array of real numbers.
fn rows<const N: usize>(
    what: &str,
    name: &str,
    value: &Bound<'_, PyAny>,
) -> PyResult<Vec<[f32; N]>> {
    let array = limited(what, name, value)?;
    let floats = array::floats(&format!("{what}: {name}"), &array)?;
    if array.ndim() != 2 || array.shape()[1] != N {
        let found = array.getattr("shape")?;
        let problem = format!("{what}: {name} have the shape {found}; expected N x {N}");
        return Err(value_error(problem));
    }
    Ok(floats.as_slice()?.as_chunks().0.to_vec())
}

/// Returns the rows of an array of indices. One that no vertex can have becomes the largest number.
fn triangles(what: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<[u32; 3]>> {
    let array = limited(what, "faces", value)?;
    let (dtype, shape) = (array.getattr("dtype")?, array.getattr("shape")?);
    let kind: String = dtype.getattr("kind")?.extract()?;
    if array.ndim() != 2 || array.shape()[1] != 3 || !["i", "u"].contains(&kind.as_str()) {
        return Err(value_error(format!(
            "{what}: faces are {dtype} of the shape {shape}; expected integers, F x 3"
        )));
    }
    let numpy = value.py().import("numpy")?;
    let indices = numpy.call_method1("require", (array, "int64", ["C", "A"]))?;
    let indices = indices.cast_into::<PyArrayDyn<i64>>()?;
    let indices =
        indices.try_readonly().map_err(|error| value_error(format!("{what}: faces: {error}")))?;
    let index = |&index: &i64| u32::try_from(index).unwrap_or(u32::MAX);
    Ok(indices
        .as_slice()?
        .as_chunks::<3>()
        .0
        .iter()
        .map(|face| face.each_ref().map(index))
        .collect())
}

/// Returns an array whose number of rows is checked before any of them is looked at.
fn limited<'py>(
    what: &str,
    name: &str,
    value: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyUntypedArray>> {
    let array = value.py().import("numpy")?.call_method1("asarray", (value,))?;
    let array = array.cast_into::<PyUntypedArray>()?;
    match array.shape().first() {
        Some(&count) if count > MOST => {
            Err(value_error(format!("{what}: {count} {name}; expected at most {MOST}")))
        }
        _ => Ok(array),
    }
}

/// Reads a dictionary with a kind and its parameters.
fn kind(what: &str, value: &Bound<'_, PyAny>) -> PyResult<KindSpec> {
    let Ok(given) = value.cast::<PyMapping>() else {
        let found = value.get_type().name()?;
        return Err(PyTypeError::new_err(format!(
            "{what}: expected a dictionary with \"type\", not {found}"
        )));
    };
    let (mut kind, mut parameters) = (None, Vec::new());
    for item in given.items()? {
        let (name, value): (Bound<'_, PyAny>, Bound<'_, PyAny>) = item.extract()?;
        let name = name.str()?.to_string();
        match name.as_str() {
            "type" => kind = value.extract().ok(),
            _ => {
                let value = parameter(&format!("{what}: {name}"), &name, &value)?;
                parameters.push((name, value));
            }
        }
    }
    match kind {
        Some(kind) => Ok(KindSpec { kind, parameters }),
        None => Err(value_error(format!("{what} has no \"type\""))),
    }
}

/// Reads a parameter; `what` names it in messages.
fn parameter(what: &str, name: &str, value: &Bound<'_, PyAny>) -> PyResult<ParameterValue> {
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(ParameterValue::Text(text.to_string()));
    }
    if let Ok(flag) = value.cast::<PyBool>() {
        return Ok(ParameterValue::Flag(flag.is_true()));
    }
    if let Ok(array) = value.cast::<PyUntypedArray>()
        && let [_, _, channels] = *array.shape()
    {
        let (dtype, shape) = (array.dtype(), array.getattr("shape")?);
        if channels != 3 || dtype.kind() != b'f' {
            return Err(value_error(format!(
                "{what} is an array of {dtype} of the shape {shape}; expected floats of linear \
                 light, height x width x 3"
            )));
        }
        return array::picture(what, value).map(|(picture, _)| ParameterValue::Picture(picture));
    }
    match shape(value)?[..] {
        [] => number(what, value).map(ParameterValue::Number),
        // Positions of lights are points, not colours.
        [3] if ["from", "to"].contains(&name) => triple(what, value).map(ParameterValue::Point),
        [3] => triple(what, value).map(ParameterValue::Colour),
        _ => Err(value_error(format!(
            "{what}: expected a number, three numbers, a text or a texture"
        ))),
    }
}

fn radiance(what: &str, value: &Bound<'_, PyAny>) -> PyResult<[f64; 3]> {
    let name = format!("{what}: emission");
    match shape(value)?[..] {
        [3] => triple(&name, value),
        _ => {
            let expected = "expected (r, g, b)";
            let message = about(&name, value, expected);
            Err(value_error(message.unwrap_or_else(|| format!("{name}: {expected}"))))
        }
    }
}

/// Returns the shape of an array, or of what would become one.
fn shape(value: &Bound<'_, PyAny>) -> PyResult<Vec<usize>> {
    value.py().import("numpy")?.call_method1("shape", (value,))?.extract()
}

fn triple(what: &str, values: &Bound<'_, PyAny>) -> PyResult<[f64; 3]> {
    let mut triple = [0.0; 3];
    for (number_of, value) in triple.iter_mut().zip(values.try_iter()?) {
        *number_of = number(what, &value?)?;
    }
    Ok(triple)
}

fn number(what: &str, value: &Bound<'_, PyAny>) -> PyResult<f64> {
    let number: f64 = value.extract().map_err(|error| refused(what, value, "a number", error))?;
    match number.is_finite() {
        true => Ok(number),
        false => Err(value_error(format!("{what}={value}: expected a finite number"))),
    }
}
