//! The ladder of camera models.

mod support;

use glam::DAffine3;
use petzval::lens::{Aim, Camera, Fidelity, Focus, Model, RealLens, film_error};
use support::{LENSES, lens};

/// A camera with a lens of the repository, in focus at 2 m, its film 36 x 24 mm.
fn camera(name: &str) -> Camera {
    let prescription = lens(name);
    let film = Focus::of(&prescription).film(5000.0).expect("a place for the film");
    let front = (film + prescription.length()) * 1e-3;
    let lens = RealLens::new(prescription, film, 21.7, Aim::Pupil, 1e-3, front);
    Camera {
        model: Model::Real(Box::new(lens)),
        film: [36.0, 24.0],
        world_from_camera: DAffine3::IDENTITY,
        imaging_ratio: 1.0,
        depth: [0.0, f64::INFINITY],
    }
}

#[test]
fn a_table() {
    for (name, _) in LENSES {
        let camera = camera(name);
        let reference = camera.simulated(Fidelity::Double);
        for fidelity in Fidelity::ALL {
            let start = std::time::Instant::now();
            let model = camera.simulated(fidelity);
            let made = start.elapsed().as_secs_f64();
            let error = film_error(&model, &reference, |_| 5.0);
            println!("{name:14} {:10} {made:.4} s {error:.4?}", fidelity.name());
        }
    }
}
