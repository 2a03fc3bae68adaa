//! Film and elements that do not stand square: against the oracle, against what is known of view
//! cameras and of misaligned lenses, and through the command.

#[path = "../support/mod.rs"]
mod support;

mod command;
mod elements;
mod exposure;
mod film;

use glam::DAffine3;
use petzval::lens::{Aim, Camera, FilmPlane, Model, Pose, Prescription, RealLens};

/// A camera in the origin of a world of millimetres, the front vertex at z = 0.
fn camera(lens: Prescription, distance: f64, pose: Pose, film: [f64; 2]) -> Camera {
    let (radius, half) = (film[0].hypot(film[1]) / 2.0, film.map(|side| side / 2.0));
    let plane = FilmPlane { distance, pose, radius, half };
    Camera {
        model: Model::Real(Box::new(RealLens::posed(lens, &plane, Aim::Pupil, 1.0, 0.0))),
        film,
        world_from_camera: DAffine3::IDENTITY,
        imaging_ratio: 1.0,
        depth: [0.0, f64::INFINITY],
    }
}
