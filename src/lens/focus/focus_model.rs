//! Choice of the focusing method: sharpest image, or the thick lens of pbrt-v4.

use super::paraxial::{FocusError, Paraxial};
use crate::focus::real_ray::RealRayFocus;
use crate::prescription::Prescription;
use crate::trace::kernel::LensRay;
use crate::trace::sequence::{Side, sequence};
use crate::trace::trace_one;

/// Method that finds the film distance for a distance in focus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum FocusModel {
    /// The smallest spot of rays through the whole opening ([`RealRayFocus`]).
    #[default]
    Sharpest,
    /// The film distance of pbrt-v4: by a thick lens with the cardinal points of two rays near the
    /// axis (`RealisticCamera::FocusThickLens`). It ignores aberrations and the stop.
    Pbrt,
}

/// Height of pbrt-v4's two rays, which are parallel to the axis, over the film diagonal.
const HEIGHT: f64 = 1e-3;

impl FocusModel {
    /// Returns the distance of a film of this diagonal behind the rear vertex at which objects at
    /// `focus` before the film, possibly infinite, are in focus; all in mm.
    ///
    /// # Errors
    /// Returns an error if the lens cannot focus so near, or forms no image.
    pub fn film(
        self,
        lens: &Prescription,
        focus: f64,
        film_diagonal: f64,
    ) -> Result<f64, FocusError> {
        match self {
            Self::Sharpest => RealRayFocus::new(lens).film_distance(focus),
            Self::Pbrt => {
                let Paraxial { focal_length, back_focal_distance, .. } = Paraxial::new(lens);
                let no_image = FocusError::NoImage { focal_length, back_focal_distance };
                ThickLens::new(lens, HEIGHT * film_diagonal)
                    .ok_or(no_image)?
                    .film_distance(focus, no_image)
            }
        }
    }
}

/// A thick lens; positions in mm from the rear vertex along the axis, towards the film.
struct ThickLens {
    focal_length: f64,
    /// Principal planes of light to the film and of light from it.
    principal: [f64; 2],
}

impl ThickLens {
    /// Traces a ray from either side at this height; `None` if one is blocked or stays parallel to
    /// the axis.
    fn new(lens: &Prescription, height: f64) -> Option<Self> {
        let mut lens = lens.centred();
        let widest = lens.rows.iter().map(|row| row.diameter).fold(4.0 * height, f64::max);
        for row in &mut lens.rows {
            row.open_all();
            if row.stop {
                row.diameter = widest;
            }
        }
        // Distances from the last vertex, along the way of the ray, at which the emerging line
        // reaches the axis and its first height.
        let cardinal = |from: Side, index: f64| {
            let ray = LensRay::new([height, 0.0, 0.0], [0.0, 0.0, index]);
            let ray = trace_one::<f64>(ray, &sequence::<f64>(&lens, from)).ok()?;
            let at = |x: f64| ray.p[2] + (x - ray.p[0]) * ray.t[2] / ray.t[0];
            Some([at(0.0), at(height)]).filter(|points| points.iter().all(|z| z.is_finite()))
        };
        let front = &lens.rows[0];
        let start = 2.0 * front.sag(front.diameter / 2.0).abs() + front.diameter;
        let rear = lens.rear();
        let behind = 2.0 * rear.sag(rear.diameter / 2.0).abs() + rear.diameter;
        let [focal_point, to_film] = cardinal(Side::Scene(start), 1.0)?;
        let [_, to_scene] = cardinal(Side::Film(behind), rear.index)?;
        let principal = [to_film, -lens.length() - to_scene];
        Some(Self { focal_length: focal_point - to_film, principal })
    }

    /// Solves the formula of pbrt-v4 for the film distance, in a form that includes infinity.
    fn film_distance(&self, focus: f64, no_image: FocusError) -> Result<f64, FocusError> {
        let Self { focal_length, principal: [to_film, to_scene] } = *self;
        if !(focal_length > 0.0 && focal_length < 1e9) {
            return Err(no_image);
        }
        // Distance from object to film less that between the principal planes.
        let apart = focus + to_scene - to_film;
        let rest = 1.0 - 4.0 * focal_length / apart;
        if apart <= 0.0 || rest < 0.0 {
            let nearest = 4.0 * focal_length + to_film - to_scene;
            return Err(FocusError::TooNear { asked: focus, nearest });
        }
        let film = to_film + 2.0 * focal_length / (1.0 + rest.sqrt());
        if film > 0.0 { Ok(film) } else { Err(no_image) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prescription::Row;

    /// Returns a biconvex lens of radii 100 mm, 8 mm thick, with a stop of this diameter behind it.
    fn singlet(stop: f64) -> Prescription {
        let row = |radius: f64, thickness: f64, index: f64, diameter: f64| Row {
            radius,
            thickness,
            index,
            diameter,
            ..Row::default()
        };
        let rows = vec![
            row(100.0, 8.0, 1.5, 20.0),
            row(-100.0, 2.0, 1.0, 20.0),
            Row { stop: true, ..row(f64::INFINITY, 0.0, 1.0, stop) },
        ];
        Prescription::new("singlet", rows).expect("one stop")
    }

    #[test]
    fn the_thick_lens_near_the_axis_agrees_with_first_order_optics() {
        let lens = singlet(10.0);
        for focus in [f64::INFINITY, 1e6, 5000.0, 450.0] {
            let film = FocusModel::Pbrt.film(&lens, focus, 1e-3).expect("a film");
            let expected = Paraxial::new(&lens).film_for_focus(focus).expect("a film");
            assert!((film / expected - 1.0).abs() < 1e-7, "{focus}: {film}, not {expected}");
        }
    }

    #[test]
    fn the_thick_lens_ignores_the_stop() {
        let film = |stop: f64| FocusModel::Pbrt.film(&singlet(stop), 3000.0, 43.0).expect("a film");
        assert!((film(18.0) - film(1e-3)).abs() < 1e-12);
        let sharpest = FocusModel::Sharpest.film(&singlet(18.0), 3000.0, 43.0).expect("a film");
        assert!(film(18.0) - sharpest > 0.1, "{} and {sharpest}", film(18.0));
    }

    #[test]
    fn the_thick_lens_refuses_objects_that_are_too_near() {
        let film = |focus: f64| FocusModel::Pbrt.film(&singlet(10.0), focus, 43.0);
        let Err(FocusError::TooNear { nearest, .. }) = film(100.0) else { panic!("too near") };
        assert!(film(nearest * 1.000_001).is_ok() && film(nearest * 0.999_999).is_err());
        let mut hollow = singlet(10.0);
        (hollow.rows[0].radius, hollow.rows[1].radius) = (-100.0, 100.0);
        let refused = FocusModel::Pbrt.film(&hollow, 1e3, 43.0);
        assert!(matches!(refused, Err(FocusError::NoImage { .. })), "{refused:?}");
    }
}
