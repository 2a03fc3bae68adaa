//! Diffraction at the stop: point spread functions against theory, pictures, and the plan.

mod aberrations;
mod pictures;
mod plan;
mod point_spread;

use crate::support::lens;
use petzval_lens::{Iris, PupilSampling, RealLens, RealRayFocus};

/// A wavelength, um.
const GREEN: f64 = 0.55;

/// Returns the course's double Gauss, focused at infinity, at an f-number.
fn dgauss(f_number: f64, iris: Iris) -> RealLens {
    let mut lens = lens("dgauss.50mm");
    let paraxial = petzval_lens::Paraxial::new(&lens);
    let stop = lens.stop();
    let diameter = lens.rows[stop].diameter * paraxial.f_number() / f_number;
    lens.stop_down(diameter);
    lens.rows[stop].iris = iris;
    let film = RealRayFocus::new(&lens).film_distance(f64::INFINITY).expect("a film");
    RealLens::new(lens, film, 21.6, PupilSampling::Pupil, 1e-3, 0.1)
}

fn blades(count: u32, rotation: f64) -> Iris {
    Iris::Blades { count, rotation, curvature: 0.0 }
}

/// Returns the first minimum of a function between 0 and `end`.
fn first_minimum(end: f64, f: impl Fn(f64) -> f64) -> f64 {
    let steps = 4000;
    let at = |i: usize| end * i as f64 / steps as f64;
    let values: Vec<f64> = (0..=steps).map(|i| f(at(i))).collect();
    let lowest = (1..steps).find(|&i| values[i] < values[i - 1] && values[i] <= values[i + 1]);
    at(lowest.expect("a minimum"))
}
