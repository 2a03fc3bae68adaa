//! Specification of a data set: a TOML file.

use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use serde::{Deserialize, Deserializer};
use toml::Spanned;

use super::DatasetError;
use super::trajectory::Trajectory;
use petzval_base::io::{FileLog, Location, ReadContext};
use petzval_image::ToneCurve;
use petzval_render::aov::Aov;
use petzval_render::plan::EffectSelection;
use petzval_render::sensor::SensorSettings;
use petzval_scene::shutter::{RollingShutter, ShutterSettings};

/// A data set, as its file describes it. Paths are relative to that file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct DatasetSpec {
    /// The number of pairs.
    pub pairs: u32,
    /// The seed of all draws and pictures.
    #[serde(default)]
    pub seed: u32,
    /// The size of the pictures (pixels).
    #[serde(default = "default_resolution", deserialize_with = "exactly")]
    pub resolution: [u32; 2],
    /// The samples per pixel of either picture.
    #[serde(default = "default_samples")]
    pub spp: u32,
    /// The layers of the pictures.
    #[serde(default, deserialize_with = "layers")]
    pub layers: Vec<Aov>,
    /// Whether the pictures have 16-bit floats.
    #[serde(default)]
    pub half: bool,
    /// Whether each pair has the point spreads of its lens.
    #[serde(default)]
    pub psf: bool,
    /// The exposure, in stops above that of the scene.
    #[serde(default)]
    pub exposure: f64,
    /// The parameters that are drawn for each pair.
    pub draw: DrawSpec,
    /// The clean pictures.
    #[serde(default)]
    pub clean: CleanSpec,
    /// The degraded pictures.
    #[serde(default)]
    pub degraded: DegradedSpec,
    /// The digest of all but the number of pairs, by which the folder of a data set knows its own.
    #[serde(skip)]
    pub digest: String,
}

/// The parameters that are drawn for each pair. Those not given are the scene's.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct DrawSpec {
    /// The scene file.
    pub scene: DrawnFrom<PathBuf>,
    /// The lens file.
    pub lens: Option<DrawnFrom<PathBuf>>,
    /// The distance in focus from the film (m), or "auto" for the surface in the middle.
    pub focus: Option<DrawnFrom<FocusValue>>,
    /// The f-number.
    pub fstop: Option<DrawnFrom<f64>>,
    /// The light on the sensor, in stops above that of its base speed, mostly negative.
    pub light: Option<DrawnFrom<f64>>,
    /// Largest moves of the camera along its axes (m): right, up and forward.
    #[serde(rename = "move")]
    pub shift: Option<Reach>,
    /// Largest turns of the camera (degrees): pan, tilt and roll.
    pub turn: Option<Reach>,
    /// The cameras of a rig, which take each view one after another; none is one camera.
    #[serde(default, deserialize_with = "rig")]
    pub rig: Vec<RigPlace>,
    /// The file of poses of the camera, a line for each view.
    pub trajectory: Option<Trajectory>,
}

/// Place of a camera in a rig, along and about the axes of the view.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RigPlace {
    /// Moves to the right, up and forward (m).
    pub shift: [f64; 3],
    /// Pan, tilt and roll (degrees).
    pub turn: [f64; 3],
}

/// The camera of the clean pictures.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum CleanCamera {
    /// A pinhole in the entrance pupil: all in focus, no distortion.
    #[default]
    Pinhole,
    /// The lens stopped down: all in focus, with its distortion.
    Deep,
    /// The lens at the same focus and stop.
    Lens,
}

/// How clean pictures are taken.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct CleanSpec {
    /// The camera.
    #[serde(default)]
    pub camera: CleanCamera,
    /// The effects; none but fog and smoke, if not given.
    #[serde(default, deserialize_with = "parsed")]
    pub effects: Option<EffectSelection>,
}

/// How degraded pictures are taken.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct DegradedSpec {
    /// The effects; those that are visible, if not given.
    #[serde(default, deserialize_with = "parsed")]
    pub effects: Option<EffectSelection>,
    /// The sensor that reads the picture out, into a file of its own.
    #[serde(skip)]
    pub sensor: Option<SensorSettings>,
    /// The tone curve of a picture that is developed from the mosaic of the sensor, if there is one.
    #[serde(default, deserialize_with = "parsed")]
    pub develop: Option<ToneCurve>,
    /// Its text, which may name a file.
    #[serde(default, rename = "sensor")]
    sensor_text: Option<Spanned<String>>,
    /// The shutter.
    #[serde(default, deserialize_with = "parsed")]
    pub shutter: Option<ShutterSettings>,
    /// The rolling shutter.
    #[serde(default, deserialize_with = "parsed")]
    pub rolling_shutter: Option<RollingShutter>,
}

/// The values that a parameter is drawn from.
#[derive(Clone, Debug, Deserialize)]
#[serde(
    untagged,
    expecting = "expected a value, a list of values, or a range of numbers such as { from = 0.5, to = 4.0 }"
)]
pub enum DrawnFrom<T> {
    /// All numbers between two.
    Range(Range),
    /// A list, each value equally often.
    List(Vec<T>),
    /// One value.
    One(T),
}

/// A range of numbers.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Range {
    /// The lower end.
    pub from: f64,
    /// The upper end.
    pub to: f64,
    /// Whether equal factors are equally likely, not equal differences.
    #[serde(default)]
    pub log: bool,
}

/// A distance in focus.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged, expecting = "expected a distance in m, inf, or \"auto\"")]
pub enum FocusValue {
    /// From the film (m).
    Metres(f64),
    /// "auto".
    Word(String),
}

/// Largest deviations along three axes; one number stands for all.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(untagged, expecting = "expected a number, or three in brackets")]
pub enum Reach {
    /// The same along all axes.
    Same(f64),
    /// One for each axis.
    Each(#[serde(deserialize_with = "exactly")] [f64; 3]),
}

impl Reach {
    /// Returns the deviations along the three axes.
    pub fn axes(self) -> [f64; 3] {
        match self {
            Self::Same(reach) => [reach; 3],
            Self::Each(reach) => reach,
        }
    }
}

fn default_resolution() -> [u32; 2] {
    [512, 512]
}

fn default_samples() -> u32 {
    32
}

/// Reads a list of N numbers. By itself, the reader of arrays ignores all that follow.
fn exactly<'de, D, T, const N: usize>(from: D) -> Result<[T; N], D::Error>
where
    D: Deserializer<'de>,
    T: Deserialize<'de>,
{
    let numbers = Vec::<T>::deserialize(from)?;
    let found = numbers.len();
    let expected = format!("expected {N} numbers, found {found}");
    numbers.try_into().map_err(|_| serde::de::Error::custom(expected))
}

/// Reads a text and parses it.
fn parsed<'de, D, T>(from: D) -> Result<Option<T>, D::Error>
where
    D: Deserializer<'de>,
    T: FromStr<Err: Display>,
{
    let text = String::deserialize(from)?;
    text.parse().map(Some).map_err(serde::de::Error::custom)
}

/// Reads the places of the cameras of a rig: three numbers each, or six.
fn rig<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<RigPlace>, D::Error> {
    let place = |numbers: Vec<f64>| match numbers[..] {
        [x, y, z] => Ok(RigPlace { shift: [x, y, z], turn: [0.0; 3] }),
        [x, y, z, pan, tilt, roll] => Ok(RigPlace { shift: [x, y, z], turn: [pan, tilt, roll] }),
        _ => {
            let found = numbers.len();
            let expected = "expected [right, up, forward] in m for each camera, and [..., pan, tilt, roll] in degrees";
            Err(serde::de::Error::custom(format!("{expected}, found {found} numbers")))
        }
    };
    Vec::<Vec<f64>>::deserialize(from)?.into_iter().map(place).collect()
}

fn layers<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<Aov>, D::Error> {
    let names = Vec::<String>::deserialize(from)?;
    let layers = names.iter().map(|name| name.parse());
    layers.collect::<Result<_, String>>().map_err(serde::de::Error::custom)
}

impl DatasetSpec {
    /// Reads a specification.
    ///
    /// # Errors
    /// Returns an error with its place if the file cannot be read or is not sound.
    pub fn read(path: &Path, context: &ReadContext) -> Result<Self, DatasetError> {
        let problem = |problem: String| DatasetError::Spec { path: path.to_owned(), problem };
        let bytes = context.bytes(path)?;
        let text =
            String::from_utf8(bytes).map_err(|_| problem("expected text in UTF-8".into()))?;
        let mut spec: Self =
            toml::from_str(&text).map_err(|error| problem(error.to_string().trim_end().into()))?;
        let folder = path.parent().unwrap_or(Path::new(""));
        if let Some(sensor) = spec.degraded.sensor_text.take() {
            let at = Location::in_text(path, &text, sensor.span().start);
            let place =
                |fault: String| problem(format!("line {}, column {}: {fault}", at.line, at.column));
            let settings = SensorSettings::parse_in(folder, sensor.get_ref());
            spec.degraded.sensor = Some(settings.map_err(place)?);
        }
        if let Some(trajectory) = &mut spec.draw.trajectory {
            let read = trajectory.read(folder, context);
            read.map_err(|fault| problem(format!("draw.trajectory: {fault}")))?;
        }
        spec.check().map_err(problem)?;
        let alike = Self { pairs: 0, ..spec.clone() };
        spec.digest = blake3::hash(format!("{alike:?}").as_bytes()).to_hex()[..16].to_owned();
        let resolve = |values: &mut DrawnFrom<PathBuf>| match values {
            DrawnFrom::One(path) => *path = folder.join(&*path),
            DrawnFrom::List(paths) => paths.iter_mut().for_each(|path| *path = folder.join(&*path)),
            DrawnFrom::Range(_) => {}
        };
        resolve(&mut spec.draw.scene);
        spec.draw.lens.as_mut().map(resolve);
        if let Some(trajectory) = &mut spec.draw.trajectory {
            trajectory.path = folder.join(&trajectory.path);
        }
        Ok(spec)
    }

    /// Returns the scenes, the lenses and the trajectory that pairs may draw.
    pub fn named_files(&self) -> FileLog {
        let mut files = FileLog::default();
        if let Some(trajectory) = &self.draw.trajectory {
            files.add(&trajectory.path, None);
        }
        for drawn in std::iter::once(&self.draw.scene).chain(&self.draw.lens) {
            match drawn {
                DrawnFrom::One(path) => files.add(path, None),
                DrawnFrom::List(paths) => paths.iter().for_each(|path| files.add(path, None)),
                DrawnFrom::Range(_) => {}
            }
        }
        files
    }
}
