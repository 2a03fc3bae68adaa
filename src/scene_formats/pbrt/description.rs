//! Contents of a scene file, before they are combined with a lens file and the command line.

use std::path::PathBuf;

use glam::DAffine3;

use petzval_base::io::{FileLog, Location, ReadContext, Warning};
use petzval_lens::{Pose, SphericalMapping};
use petzval_scene::filter::Profile;
use petzval_scene::motion::Motion;
use petzval_scene::shutter::Shutter;
use petzval_scene::{PathLimits, Scene};
use petzval_spectrum::{Buckets, CameraSensor, ColourSpace};

/// The contents of a scene file. Clones share all large data, so that one may become many jobs.
#[derive(Clone, Debug)]
pub struct Description {
    /// Shapes, materials and lights.
    pub scene: Scene,
    /// The camera.
    pub camera: CameraSpec,
    /// The pose of the camera at the start of motions: camera space to world space.
    pub world_from_camera: DAffine3,
    /// The pose of the camera over time.
    pub camera_motion: Motion,
    /// The location of the Camera directive.
    pub camera_at: Location,
    /// The film.
    pub film: FilmSpec,
    /// Samples a pixel.
    pub samples: u32,
    /// Seed of the random numbers.
    pub seed: u32,
    /// The pixel filter.
    pub filter: FilterSpec,
    /// The limits of paths.
    pub path_limits: PathLimits,
    /// The shutter.
    pub shutter: Shutter,
    /// The times at which motions begin and end (s).
    pub transform_times: [f64; 2],
    /// The warnings of the reader.
    pub warnings: Vec<Warning>,
    /// The files that were read.
    pub files: FileLog,
    /// The memory budget of the readers.
    pub context: ReadContext,
}

/// The parameters of the film.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmSpec {
    /// Width and height (pixels).
    pub resolution: [u32; 2],
    /// Diagonal (mm).
    pub diagonal: f64,
    /// The rendered pixels: x and y of the first, and of the end, which is not rendered.
    pub bounds: [[u32; 2]; 2],
    /// File name of the picture.
    pub filename: Option<PathBuf>,
    /// Sensitivity (ISO).
    pub iso: f64,
    /// The largest X, Y or Z of a sample; brighter samples are scaled down to it.
    pub max_component: Option<f64>,
    /// Colour temperature (K) of the daylight that becomes white.
    pub white_balance: Option<f64>,
    /// The camera whose sensor is simulated; `None` is an ideal sensor.
    pub camera_sensor: Option<CameraSensor>,
    /// The colour space of the picture.
    pub colour_space: ColourSpace,
    /// Whether the file asks for 16-bit floats.
    pub half: bool,
    /// Whether the file asks for layers of geometry beside the picture.
    pub gbuffer: bool,
    /// Whether these layers are in camera space instead of world space.
    pub camera_layers: bool,
    /// The buckets of wavelength that the file asks for beside the picture.
    pub buckets: Option<Buckets>,
}

/// The pixel filter: a product of one function of x and one of y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilterSpec {
    /// The function of each axis.
    pub profile: Profile,
    /// Radii along x and y (pixels).
    pub radius: [f64; 2],
}

/// The parameters of the camera.
#[derive(Clone, Debug, PartialEq)]
pub enum CameraSpec {
    /// A real lens.
    Realistic(RealisticSpec),
    /// A pinhole, a thin lens or parallel rays.
    Thin(ThinSpec),
    /// A picture of all directions.
    Spherical(SphericalSpec),
}

/// A camera with a real lens, in one of two dialects.
#[derive(Clone, Debug, PartialEq)]
pub enum RealisticSpec {
    /// pbrt-v4: scene units of metres, the origin at the film's centre, focused by a distance.
    V4 {
        /// The lens file.
        lens: PathBuf,
        /// The location of the parameter that names it.
        lens_at: Location,
        /// Diameter of the stop (mm).
        aperture: f64,
        /// The shape of the stop, if the scene names one.
        iris: Option<IrisSpec>,
        /// Distance from the film to the plane in focus (m).
        focus: f64,
        /// Exposure time (s).
        exposure_time: f64,
        /// Shift and tilt of the film.
        film_pose: Pose,
    },
    /// The course of 2016 on pbrt-v2: scene units of mm, the origin at the front vertex.
    V2 {
        /// The lens file.
        lens: PathBuf,
        /// The location of the parameter that names it.
        lens_at: Location,
        /// Diameter of the stop (mm).
        aperture: f64,
        /// Distance from the rear vertex to the film (mm).
        film_distance: f64,
        /// Diagonal of the film (mm).
        film_diagonal: f64,
        /// Nearest and farthest visible depth (mm).
        depth: [f64; 2],
        /// Shift and tilt of the film.
        film_pose: Pose,
    },
}

/// The shape of a stop.
#[derive(Clone, Debug, PartialEq)]
pub struct IrisSpec {
    /// The name of a shape of pbrt's, or of an image file.
    pub name: String,
    /// The path of the image file, if the name means one.
    pub path: PathBuf,
}

/// A pinhole, a thin lens or parallel rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinSpec {
    /// Field of view of the shorter side (degrees); `None` if rays are parallel without a lens.
    pub fov: Option<f64>,
    /// Width over height of the picture, unless it is that of its pixels.
    pub aspect: Option<f64>,
    /// The visible window x0 x1 y0 y1, y upwards, in units in which the field of view is from -1 to
    /// 1, or in camera units if rays are parallel; `None` if it is centred.
    pub window: Option<[f64; 4]>,
    /// Radius of the lens [camera units].
    pub lens_radius: f64,
    /// Depth in focus [camera units].
    pub focal_distance: f64,
    /// Nearest and farthest visible depth [camera units].
    pub depth: [f64; 2],
    /// Exposure time (s).
    pub exposure_time: f64,
    /// Whether the user may mount a real lens in its place.
    pub takes_lens: bool,
}

/// A picture of all directions, seen from one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphericalSpec {
    /// The mapping from points of the picture to directions.
    pub mapping: SphericalMapping,
    /// Exposure time (s).
    pub exposure_time: f64,
}
