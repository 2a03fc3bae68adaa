//! The lens of textbooks in place of a real one: a point, or a disk that focuses on one plane.

use glam::{DAffine3, DVec3};

use crate::lens::camera::{Camera, Model, RealLens};
use crate::lens::focus::Focus;
use crate::lens::paraxial::Paraxial;
use crate::lens::prescription::Axis;
use crate::lens::thin::ThinLens;

/// The farthest that an entrance pupil is put from the front vertex, in focal lengths: that of a
/// lens that is telecentric on the side of the scene is at infinity.
const FARTHEST: f64 = 1e4;

/// A camera with its centre of perspective in the middle of the lens's entrance pupil, and a film
/// that takes in what the real one does near the axis. `exposed` is the light that the middle of
/// the real film gets; here every point gets it. A shift of the film is kept; a tilt, and elements
/// that stand askew, are not known to this lens.
pub(super) fn thin(camera: &Camera, lens: &RealLens, open: bool, exposed: f64) -> Camera {
    let planes = [Axis::X, Axis::Y].map(|axis| Paraxial::in_plane(&lens.prescription, axis));
    let pupils = planes.map(|plane| (middle_of_pupil(&plane), plane.entrance_pupil.diameter));
    // Those of a lens that is not round may stand apart.
    let behind = (pupils[0].0 + pupils[1].0) / 2.0;
    let radius = match (pupils[0].1 * pupils[1].1).sqrt() / 2.0 {
        radius if open && radius.is_finite() => radius * lens.unit,
        _ => 0.0,
    };
    // From here on in mm before the front vertex.
    let object = in_focus(lens);
    let slopes = [0, 1].map(|i| {
        let slope = planes[i].chief_slope(pupils[i].0, lens.film_distance);
        // As seen from the common centre.
        if object.is_finite() { slope * (object + pupils[i].0) / (object + behind) } else { slope }
    });
    let depth = lens.front - behind * lens.unit;
    let centre = DAffine3::from_translation(DVec3::new(0.0, 0.0, depth));
    let focus = ((object + behind) * lens.unit).clamp(f64::MIN_POSITIVE, FARTHEST_FOCUS);
    let shift = lens.film_pose.decentre;
    let middle = [0, 1].map(|i| -shift[i] * slopes[i]);
    // Rays of the real lens count their depth from its front.
    let depth_from_centre = |depth: f64| match depth == 0.0 {
        true => 0.0,
        false => (depth + behind * lens.unit).max(0.0),
    };
    Camera {
        model: Model::Thin(ThinLens { radius, focus, middle }),
        film: [0, 1].map(|i| camera.film[i] * slopes[i]),
        world_from_camera: camera.world_from_camera * centre,
        imaging_ratio: camera.imaging_ratio * exposed,
        depth: camera.depth.map(depth_from_centre),
    }
}

/// As good as infinitely far, camera units: products with it stay numbers in f32.
const FARTHEST_FOCUS: f64 = 1e9;

/// The distance before the front vertex, mm, that is in focus by real rays; infinite where nothing
/// real is.
pub(super) fn in_focus(lens: &RealLens) -> f64 {
    let object = Focus::of(&lens.prescription).object(lens.film_distance);
    object.filter(|distance| *distance > 0.0).unwrap_or(f64::INFINITY)
}

/// Where behind the front vertex the entrance pupil stands, mm.
pub(super) fn middle_of_pupil(plane: &Paraxial) -> f64 {
    let most = FARTHEST * plane.focal_length.abs();
    let position = plane.entrance_pupil.position;
    if position.is_nan() { most } else { position.clamp(-most, most) }
}
