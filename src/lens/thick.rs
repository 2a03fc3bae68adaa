//! Focus by pbrt-v4's thick lens, for pictures that are to equal pbrt's.

use super::focus::Focus;
use super::iris::Iris;
use super::paraxial::{FocusError, Paraxial};
use super::prescription::Prescription;
use super::refract::LensRay;
use super::surface::{From, sequence};
use super::trace::trace_one;

/// Where the film stands for a distance in focus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FocusModel {
    /// Where the rays of the whole opening make the smallest spot ([`Focus`]).
    #[default]
    Sharpest,
    /// Where pbrt-v4 puts it: by a thick lens of the cardinal points that two rays near the axis find
    /// (`RealisticCamera::FocusThickLens`). Aberrations do not count, nor does the stop.
    Pbrt,
}

/// pbrt-v4's rays run parallel to the axis at this share of the film's diagonal.
const HEIGHT: f64 = 1e-3;

impl FocusModel {
    /// The distance of a film of this diagonal behind the rear vertex at which what is `focus` (or
    /// infinitely far) before the film is in focus; all in mm.
    ///
    /// # Errors
    /// Where the lens cannot focus so near, or forms no image.
    pub fn film(
        self,
        lens: &Prescription,
        focus: f64,
        film_diagonal: f64,
    ) -> Result<f64, FocusError> {
        match self {
            Self::Sharpest => Focus::of(lens).film(focus),
            Self::Pbrt => {
                let Paraxial { focal_length, back_focal_distance, .. } = Paraxial::of(lens);
                let no_image = FocusError::NoImage { focal_length, back_focal_distance };
                ThickLens::of(lens, HEIGHT * film_diagonal).ok_or(no_image)?.film(focus, no_image)
            }
        }
    }
}

/// A thick lens; mm, along the axis towards the film from the rear vertex.
struct ThickLens {
    focal_length: f64,
    /// The principal plane of light that goes to the film, and that of light that comes from it.
    principal: [f64; 2],
}

impl ThickLens {
    /// That of a lens, by a ray from either side at this height; none where one does not come through
    /// or stays parallel to the axis.
    fn of(lens: &Prescription, height: f64) -> Option<Self> {
        let mut lens = lens.centred();
        let widest = lens.rows.iter().map(|row| row.diameter).fold(4.0 * height, f64::max);
        for row in &mut lens.rows {
            (row.iris, row.obstruction) = (Iris::Round, 0.0);
            if row.stop {
                row.diameter = widest;
            }
        }
        // Where the ray reaches the axis and, prolonged, its first height, along its way and from the
        // last vertex.
        let cardinal = |from: From, index: f64| {
            let ray = LensRay::new([height, 0.0, 0.0], [0.0, 0.0, index]);
            let ray = trace_one::<f64>(ray, &sequence::<f64>(&lens, from)).ok()?;
            let at = |x: f64| ray.p[2] + (x - ray.p[0]) * ray.t[2] / ray.t[0];
            Some([at(0.0), at(height)]).filter(|points| points.iter().all(|z| z.is_finite()))
        };
        let front = &lens.rows[0];
        let start = 2.0 * front.sag(front.diameter / 2.0).abs() + front.diameter;
        let rear = lens.rear();
        let behind = 2.0 * rear.sag(rear.diameter / 2.0).abs() + rear.diameter;
        let [focal_point, to_film] = cardinal(From::Scene(start), 1.0)?;
        let [_, to_scene] = cardinal(From::Film(behind), rear.index)?;
        let principal = [to_film, -lens.length() - to_scene];
        Some(Self { focal_length: focal_point - to_film, principal })
    }

    /// pbrt-v4's formula, solved for the film's distance in a form that holds for infinity too.
    fn film(&self, focus: f64, no_image: FocusError) -> Result<f64, FocusError> {
        let Self { focal_length, principal: [to_film, to_scene] } = *self;
        if !(focal_length > 0.0 && focal_length < 1e9) {
            return Err(no_image);
        }
        // From the object to the film without what lies between the principal planes.
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
    use crate::lens::prescription::Row;

    /// A biconvex lens of 100 mm, 8 mm thick, of this stop behind it.
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
        Prescription { rows, ..Prescription::default() }
    }

    #[test]
    fn near_the_axis_the_thick_lens_is_that_of_first_order_optics() {
        let lens = singlet(10.0);
        for focus in [f64::INFINITY, 1e6, 5000.0, 450.0] {
            let film = FocusModel::Pbrt.film(&lens, focus, 1e-3).expect("a film");
            let expected = Paraxial::of(&lens).film_for_focus(focus).expect("a film");
            assert!((film / expected - 1.0).abs() < 1e-7, "{focus}: {film}, not {expected}");
        }
    }

    #[test]
    fn the_stop_does_not_count_for_the_thick_lens() {
        let film = |stop: f64| FocusModel::Pbrt.film(&singlet(stop), 3000.0, 43.0).expect("a film");
        assert!((film(18.0) - film(1e-3)).abs() < 1e-12);
        let sharpest = FocusModel::Sharpest.film(&singlet(18.0), 3000.0, 43.0).expect("a film");
        assert!(film(18.0) - sharpest > 0.1, "{} and {sharpest}", film(18.0));
    }

    #[test]
    fn what_is_too_near_for_the_thick_lens_is_refused() {
        let film = |focus: f64| FocusModel::Pbrt.film(&singlet(10.0), focus, 43.0);
        let Err(FocusError::TooNear { nearest, .. }) = film(100.0) else { panic!("too near") };
        assert!(film(nearest * 1.000_001).is_ok() && film(nearest * 0.999_999).is_err());
        let mut hollow = singlet(10.0);
        (hollow.rows[0].radius, hollow.rows[1].radius) = (-100.0, 100.0);
        let refused = FocusModel::Pbrt.film(&hollow, 1e3, 43.0);
        assert!(matches!(refused, Err(FocusError::NoImage { .. })), "{refused:?}");
    }
}
