//! First-order optics has its focus elsewhere than real rays: a lens without aberrations is sharp on
//! another film.

use super::thin::{in_focus, middle_of_pupil};
use crate::lens::camera::RealLens;
use crate::lens::paraxial::Paraxial;
use crate::lens::pose::{FilmPlane, Pose};
use crate::lens::prescription::Axis;

/// The film on which first-order optics has in focus what real rays have on the lens's own, and by how
/// much it is larger, along x and y, to take in the same near the axis.
pub(super) fn refocused(lens: &RealLens) -> (FilmPlane, [f64; 2]) {
    let planes = [Axis::X, Axis::Y].map(|axis| Paraxial::in_plane(&lens.prescription, axis));
    let distance = planes[0].image_of(in_focus(lens));
    let usable = distance > 0.0 && (distance - lens.film_distance).abs() < 0.1 * lens.film_distance;
    if !usable {
        return (lens.film, [1.0; 2]);
    }
    let scale = planes.map(|plane| {
        let slope = |distance| plane.chief_slope(middle_of_pupil(&plane), distance);
        slope(lens.film_distance) / slope(distance)
    });
    let FilmPlane { pose: Pose { decentre, tilt }, radius, half, .. } = lens.film;
    let scaled = |v: [f64; 2]| [0, 1].map(|i| v[i] * scale[i]);
    let film = FilmPlane {
        distance,
        pose: Pose { decentre: scaled(decentre), tilt },
        radius: radius * scale[0].max(scale[1]),
        half: scaled(half),
    };
    (film, scale)
}
