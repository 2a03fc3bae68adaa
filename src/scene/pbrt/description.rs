//! What a scene file asks for, before it meets a lens file and the command line.

use std::path::PathBuf;

use glam::DAffine3;

use crate::film::filter::Profile;
use crate::lens::Pose;
use crate::motion::Motion;
use crate::scene::Scene;
use crate::shade::Reach;
use crate::shutter::Shutter;
use crate::source::{Files, Location, Warning};

/// A scene file, read. Clones share all that is large, so that one may become many jobs.
#[derive(Clone, Debug)]
pub struct Description {
    /// What is seen.
    pub scene: Scene,
    /// Through what.
    pub camera: CameraSpec,
    /// The camera's place when motions begin: camera space to world space.
    pub world_from_camera: DAffine3,
    /// Where it goes from there.
    pub camera_motion: Motion,
    /// Where the camera stands in the file.
    pub camera_at: Location,
    /// Onto what.
    pub film: FilmSpec,
    /// Samples a pixel.
    pub samples: u32,
    /// Seed of the random numbers.
    pub seed: u32,
    /// How samples are weighted about their pixel.
    pub filter: FilterSpec,
    /// How far paths go.
    pub reach: Reach,
    /// When the film is exposed.
    pub shutter: Shutter,
    /// When motions begin and end, s.
    pub transform_times: [f64; 2],
    /// Whether rough surfaces should be made rougher behind diffuse ones, which is not done.
    pub regularize: bool,
    /// What was noticed on the way.
    pub warnings: Vec<Warning>,
    /// What it was read from.
    pub files: Files,
}

/// The film.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmSpec {
    /// Width and height, pixels.
    pub resolution: [u32; 2],
    /// Diagonal, mm.
    pub diagonal: f64,
    /// First pixel, and first pixel not, that is rendered.
    pub bounds: [[u32; 2]; 2],
    /// Name of the picture.
    pub filename: Option<PathBuf>,
    /// Sensitivity.
    pub iso: f64,
    /// The largest X, Y or Z of a sample; brighter ones are scaled down to it.
    pub brightest: Option<f64>,
    /// Colour temperature, K, of the daylight that is to look white.
    pub white_balance: Option<f64>,
    /// Whether the file asks for layers of geometry beside the picture.
    pub gbuffer: bool,
}

/// The pixel filter: a product of one function of x and one of y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilterSpec {
    /// The function.
    pub profile: Profile,
    /// Radii along x and y, pixels.
    pub radius: [f64; 2],
}

/// The camera.
#[derive(Clone, Debug, PartialEq)]
pub enum CameraSpec {
    /// Through a lens file.
    Realistic(RealisticSpec),
    /// Through a pinhole or a thin lens.
    Thin(ThinSpec),
}

/// A camera with a real lens, in one of two dialects.
#[derive(Clone, Debug, PartialEq)]
pub enum RealisticSpec {
    /// pbrt-v4: units of metres, the origin at the film's centre, focused by a distance.
    V4 {
        /// The lens file.
        lens: PathBuf,
        /// Where the scene names it.
        lens_at: Location,
        /// Diameter of the stop, mm.
        aperture: f64,
        /// The shape of the stop, if the scene names one.
        iris: Option<IrisSpec>,
        /// What is in focus, metres from the film.
        focus: f64,
        /// How long the shutter is open, seconds.
        exposure_time: f64,
        /// How the film stands.
        film_pose: Pose,
    },
    /// The course of 2016 on pbrt-v2: units of mm, the origin at the front vertex.
    V2 {
        /// The lens file.
        lens: PathBuf,
        /// Where the scene names it.
        lens_at: Location,
        /// Diameter of the stop, mm.
        aperture: f64,
        /// Rear vertex to film, mm.
        film_distance: f64,
        /// Diagonal of the film, mm.
        film_diagonal: f64,
        /// Nearest and farthest depth that is seen, mm.
        depth: [f64; 2],
        /// How the film stands.
        film_pose: Pose,
    },
}

/// The shape of a stop.
#[derive(Clone, Debug, PartialEq)]
pub struct IrisSpec {
    /// A name of pbrt's, or of a picture.
    pub name: String,
    /// Where the picture would be.
    pub path: PathBuf,
}

/// A pinhole or a thin lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinSpec {
    /// Field of view of the shorter side, degrees.
    pub fov: f64,
    /// Width over height of the picture, if it is not that of its pixels.
    pub aspect: Option<f64>,
    /// What is seen, x0 x1 y0 y1 in units in which the field of view is from -1 to 1, y
    /// upwards; if it is not the middle.
    pub window: Option<[f64; 4]>,
    /// Radius of the lens, camera units.
    pub lens_radius: f64,
    /// Depth in focus, camera units.
    pub focal_distance: f64,
    /// Nearest and farthest depth that is seen, camera units.
    pub depth: [f64; 2],
    /// How long the shutter is open, seconds.
    pub exposure_time: f64,
}
