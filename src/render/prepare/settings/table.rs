//! Table of the settings of a picture.

use std::fmt;
use std::sync::{Arc, LazyLock};

use super::read;
use super::value::{SettingError, SettingValue};
use crate::plan::VisibilityThreshold;
use crate::prepare::Changes;
use crate::sensor::SensorSettings;

/// All settings of a picture but the names of files. If two are given that touch the same change, the
/// later row counts, see [`Changes::of`].
pub static SETTINGS: LazyLock<Vec<PictureSetting>> = LazyLock::new(|| {
    vec![
        row("spp", read::samples, |changes, n| changes.samples = Some(n)),
        row("seed", read::seed, |changes, seed| changes.seed = Some(seed)),
        row("resolution", read::resolution, |changes, size| changes.resolution = Some(size)),
        row("crop", read::crop, |changes, crop| changes.crop = Some(crop)),
        row("noise", read::noise, |changes, noise| changes.stop_criteria.noise = Some(noise)),
        row("time", read::time, |changes, time| changes.stop_criteria.time = Some(time)),
        row("aov", read::layers, |changes, layers| changes.layers = layers),
        row("look_at", read::look_at, |changes, view| changes.viewpoint = Some(view)),
        row("focus", read::focus, |changes, focus| changes.focus = Some(focus)),
        row("focus_model", read::focus_model, |changes, model| changes.focus_model = model),
        row("fstop", read::f_number, |changes, n| changes.f_number = Some(n)),
        row("zoom", read::zoom, |changes, zoom| changes.lens_options.zoom = Some(zoom)),
        row("film_diagonal", read::film_diagonal, |changes, mm| changes.film_diagonal = Some(mm)),
        row("film_shift", read::film_shift, |changes, mm| changes.film_shift = Some(mm)),
        row("film_tilt", read::film_tilt, |changes, angles| changes.film_tilt = Some(angles)),
        row("coating", read::coating, |changes, coating| changes.coating = Some(coating)),
        row("assume_vd", read::flag, |changes, on| changes.assume_vd = on),
        row("passband", read::passband, |changes, band| changes.passband = Some(band)),
        row("buckets", read::buckets, |changes, buckets| changes.buckets = Some(buckets)),
        row(
            "effects",
            |value| {
                let expected =
                    "\"auto\", \"all\", \"none\", or a text such as \"+dispersion,-iris\"";
                read::text(value, expected, str::parse)
            },
            |changes, effects| changes.effects = effects,
        ),
        row("light_paths", read::light_paths, |changes, on| changes.light_paths = on),
        row(
            "visible",
            |value| {
                read::text(value, "a text such as \"0.5px\"", str::parse::<VisibilityThreshold>)
            },
            |changes, threshold| changes.threshold = threshold,
        ),
        row(
            "shutter",
            |value| read::text(value, "a text such as \"time=1/100\"", str::parse),
            |changes, shutter| changes.shutter = Some(shutter),
        ),
        row(
            "rolling_shutter",
            |value| read::text(value, "a text such as \"20ms\"", str::parse),
            |changes, rolling| changes.rolling = Some(rolling),
        ),
        row(
            "sensor",
            |value| read::text(value, "a text such as \"iso=800\"", str::parse::<SensorSettings>),
            |changes, sensor| changes.sensor = Some(sensor),
        ),
        // A mosaic implies a sensor.
        row(
            "bayer",
            |value| read::text(value, "a text such as \"rggb\"", str::parse),
            |changes, bayer| changes.sensor.get_or_insert_default().bayer = Some(bayer),
        ),
    ]
});

type Reader = dyn Fn(&SettingValue) -> Result<Assignment, SettingError> + Send + Sync;

/// A setting of a picture.
pub struct PictureSetting {
    /// The name, as messages of the library quote it.
    pub name: &'static str,
    read: Box<Reader>,
}

/// A setting with a value that it takes.
#[derive(Clone)]
pub struct Assignment {
    name: &'static str,
    value: SettingValue,
    apply: Arc<dyn Fn(&mut Changes) + Send + Sync>,
}

/// Returns a row of the table: a name, the reader of its values, and what a value changes.
fn row<T: Clone + Send + Sync + 'static>(
    name: &'static str,
    read: fn(&SettingValue) -> Result<T, SettingError>,
    apply: fn(&mut Changes, T),
) -> PictureSetting {
    let read = move |value: &SettingValue| {
        let read = read(value)?;
        let apply = Arc::new(move |changes: &mut Changes| apply(changes, read.clone()));
        Ok(Assignment { name, value: value.clone(), apply })
    };
    PictureSetting { name, read: Box::new(read) }
}

impl PictureSetting {
    /// Returns the setting of a name.
    pub fn named(name: &str) -> Option<&'static Self> {
        SETTINGS.iter().find(|setting| setting.name == name)
    }

    /// Reads a value.
    ///
    /// # Errors
    /// Returns an error if the setting does not take the value.
    pub fn read(&self, value: &SettingValue) -> Result<Assignment, SettingError> {
        (self.read)(value)
    }
}

impl Assignment {
    /// Returns the name of the setting.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// Returns the value as it was given.
    pub fn value(&self) -> &SettingValue {
        &self.value
    }

    /// Changes what the setting changes.
    pub fn apply(&self, changes: &mut Changes) {
        (self.apply)(changes);
    }
}

impl Changes {
    /// Returns the changes of some settings. Their order does not matter.
    pub fn of<'a>(assignments: impl IntoIterator<Item = &'a Assignment>) -> Self {
        let mut all: Vec<&Assignment> = assignments.into_iter().collect();
        all.sort_by_key(|one| SETTINGS.iter().position(|setting| setting.name == one.name));
        let mut changes = Self::default();
        all.iter().for_each(|assignment| assignment.apply(&mut changes));
        changes
    }
}

impl fmt::Debug for Assignment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} = {:?}", self.name, self.value)
    }
}
