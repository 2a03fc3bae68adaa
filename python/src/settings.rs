//! Settings of a picture, as Python gives them.

use petzval::{Changes, Description};
use petzval_render::prepare::settings::{SETTINGS, SettingError, SettingValue};
use pyo3::exceptions::{PyOverflowError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use std::collections::BTreeMap;
use std::path::PathBuf;

use crate::argument::{Listed, about, setting};
use crate::lens::Lens;
use crate::lens_source::{CatalogueSetting, LensFile};

/// The lens of a picture: a file, or one that was read.
#[derive(FromPyObject)]
pub enum LensSetting<'py> {
    /// The lens of a [`Lens`].
    Read(PyRef<'py, Lens>),
    /// A lens file.
    File(PathBuf),
}

impl LensSetting<'_> {
    /// Expected of the argument.
    pub const EXPECTED: &'static str = "a petzval.Lens or the path of a lens file";

    pub fn into_file(self) -> LensFile {
        match self {
            Self::Read(lens) => lens.file().clone(),
            Self::File(path) => LensFile::Path(path),
        }
    }
}

/// Settings whose default is not `None`, so that `None` is a value of another type.
const NEVER_NONE: [&str; 3] = ["aov", "assume_vd", "effects"];

/// Deepest list in a value: that of poses, lists of points.
const MAX_DEPTH: usize = 2;

/// Settings whose outcome is recorded in place of their values.
const BY_OUTCOME: [&str; 5] = ["aov", "crop", "resolution", "seed", "spp"];

/// Settings of a picture.
pub struct Settings {
    /// The changes to the scene.
    pub changes: Changes,
    /// The file of the lens, if one is given.
    lens: Option<LensFile>,
    /// The settings that were given, as texts, by name: they tell one picture from another.
    pub recorded: BTreeMap<String, String>,
}

impl<'py> FromPyObject<'_, 'py> for Settings {
    type Error = PyErr;

    /// Reads a dictionary with all settings; `None` keeps what the scene says.
    fn extract(settings: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let settings = settings.cast::<PyDict>()?;
        let mut assignments = Vec::new();
        for row in SETTINGS.iter() {
            let Some(value) = settings.get_item(row.name)? else { continue };
            if value.is_none() && !NEVER_NONE.contains(&row.name) {
                continue;
            }
            let read = row.read(&setting_value(&value, MAX_DEPTH)?);
            let assignment = read.map_err(|error| {
                let problem = error.to_string();
                let message = about(row.name, &value, &problem).unwrap_or(problem);
                match error {
                    SettingError::Type(_) => PyTypeError::new_err(message),
                    _ => PyValueError::new_err(message),
                }
            })?;
            assignments.push(assignment);
        }
        let mut changes =
            Changes { holds_layers: true, holds_spectra: true, ..Changes::of(&assignments) };
        let catalogue: Option<CatalogueSetting> =
            setting(&settings, "catalogue", CatalogueSetting::EXPECTED)?;
        let lens: Option<LensSetting<'py>> = setting(&settings, "lens", LensSetting::EXPECTED)?;
        let catalogues = &mut changes.lens_options.catalogues;
        catalogues.extend(catalogue.iter().flat_map(CatalogueSetting::paths));
        if let Some(LensSetting::Read(lens)) = &lens {
            catalogues.extend_from_slice(lens.catalogues());
        }
        let lens = lens.map(LensSetting::into_file);
        changes.lens = lens.as_ref().map(|file| file.path().to_owned());
        let recorded = assignments.iter().filter(|given| !BY_OUTCOME.contains(&given.name()));
        let recorded = recorded.map(|given| (given.name().to_owned(), given.value().to_string()));
        Ok(Self { recorded: recorded.collect(), lens, changes })
    }
}

impl Settings {
    /// Returns the description of a scene from which a job with these settings can be prepared.
    pub fn describe(&self, scene: &Description) -> Description {
        let mut description = scene.clone();
        if let Some(lens) = &self.lens {
            description.context = lens.attach(description.context);
        }
        description
    }
}

/// Returns an object as a value of a setting. Exceptions of the object itself come through.
fn setting_value(object: &Bound<'_, PyAny>, depth: usize) -> PyResult<SettingValue> {
    let py = object.py();
    if let Ok(text) = object.cast::<PyString>() {
        return Ok(SettingValue::Text(text.to_string()));
    }
    if let Ok(flag) = object.extract() {
        return Ok(SettingValue::Flag(flag));
    }
    match object.extract() {
        Ok(number) => return Ok(SettingValue::Whole(number)),
        // Further from 0 than any setting goes.
        Err(error) if error.is_instance_of::<PyOverflowError>(py) => {
            let is_positive = object.gt(0)?;
            return Ok(SettingValue::Whole(if is_positive { i64::MAX } else { i64::MIN }));
        }
        Err(error) if !error.is_instance_of::<PyTypeError>(py) => return Err(error),
        Err(_) => {}
    }
    match object.extract() {
        Ok(number) => return Ok(SettingValue::Number(number)),
        Err(error) if !error.is_instance_of::<PyTypeError>(py) => return Err(error),
        Err(_) => {}
    }
    match object.extract::<Listed<Bound<'_, PyAny>>>() {
        Ok(Listed(items)) if depth > 0 => {
            let items = items.iter().map(|item| setting_value(item, depth - 1));
            items.collect::<PyResult<_>>().map(SettingValue::List)
        }
        Err(error) if !error.is_instance_of::<PyTypeError>(py) => Err(error),
        _ => Ok(SettingValue::Other),
    }
}
