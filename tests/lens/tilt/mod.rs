//! Tilted and shifted film and elements: against the oracle, against the optics of view cameras and
//! misaligned lenses, and through the command.

mod command;
mod elements;
mod exposure;
mod film;

use glam::DAffine3;
use petzval_lens::{Camera, FilmPlane, LensModel, Pose, Prescription, PupilSampling, RealLens};

/// Returns a camera in a world of millimetres with the front vertex at z = 0.
fn camera(lens: Prescription, distance: f64, pose: Pose, film: [f64; 2]) -> Camera {
    let (radius, half) = (film[0].hypot(film[1]) / 2.0, film.map(|side| side / 2.0));
    let plane = FilmPlane { distance, pose, radius, half };
    Camera {
        model: LensModel::Real(Box::new(RealLens::with_film(
            lens,
            &plane,
            PupilSampling::Pupil,
            1.0,
            0.0,
        ))),
        film,
        world_from_camera: DAffine3::IDENTITY,
        imaging_ratio: 1.0,
        depth: [0.0, f64::INFINITY],
    }
}
