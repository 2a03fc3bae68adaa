//! Pinhole or thin lens in place of a real lens.

use glam::{DAffine3, DVec3};

use crate::camera::thin_lens::ThinLens;
use crate::camera::{Camera, LensModel, RealLens};
use crate::focus::paraxial::Paraxial;
use crate::focus::real_ray::RealRayFocus;
use crate::prescription::TransverseAxis;

/// Largest distance of an entrance pupil from the front vertex, in focal lengths. A lens that is
/// telecentric in object space has its entrance pupil at infinity.
const MAX_PUPIL_DISTANCE: f64 = 1e4;

/// Returns a camera with its centre of perspective in the centre of the entrance pupil, and a film
/// that covers the same field near the axis. `irradiance` is that of the middle of the real film;
/// here every point gets it. The shift of the film is kept; its tilt, and tilts and decentres of
/// elements, are ignored. Without an aperture the camera is a pinhole.
pub(super) fn thin(
    camera: &Camera,
    lens: &RealLens,
    has_aperture: bool,
    irradiance: f64,
) -> Camera {
    let planes = [TransverseAxis::X, TransverseAxis::Y]
        .map(|axis| Paraxial::in_plane(&lens.prescription, axis));
    let pupils = planes.map(|plane| (pupil_position(&plane), plane.entrance_pupil.diameter));
    // A lens that is not round may have different pupil positions along x and y.
    let behind = (pupils[0].0 + pupils[1].0) / 2.0;
    let radius = match (pupils[0].1 * pupils[1].1).sqrt() / 2.0 {
        radius if has_aperture && radius.is_finite() => radius * lens.units_per_mm,
        _ => 0.0,
    };
    // Distances below are in mm before the front vertex.
    let object = in_focus(lens);
    let slopes = [0, 1].map(|i| {
        let slope = planes[i].chief_slope(pupils[i].0, lens.film_distance);
        // Converted to the common centre of perspective.
        if object.is_finite() { slope * (object + pupils[i].0) / (object + behind) } else { slope }
    });
    let depth = lens.front_depth - behind * lens.units_per_mm;
    let centre = DAffine3::from_translation(DVec3::new(0.0, 0.0, depth));
    let focus = ((object + behind) * lens.units_per_mm).clamp(f64::MIN_POSITIVE, MAX_FOCUS);
    let shift = lens.film_pose.decentre;
    let middle = [0, 1].map(|i| -shift[i] * slopes[i]);
    // The real lens measures depth from its front vertex.
    let depth_from_centre = |depth: f64| match depth == 0.0 {
        true => 0.0,
        false => (depth + behind * lens.units_per_mm).max(0.0),
    };
    Camera {
        model: LensModel::Thin(ThinLens { radius, focus, middle }),
        film: [0, 1].map(|i| camera.film[i] * slopes[i]),
        world_from_camera: camera.world_from_camera * centre,
        imaging_ratio: camera.imaging_ratio * irradiance,
        depth: camera.depth.map(depth_from_centre),
    }
}

/// Depth that stands for infinity [camera units]: products with it stay finite in f32.
const MAX_FOCUS: f64 = 1e9;

/// Returns the distance before the front vertex that is in focus by real rays (mm); infinite if no
/// real object is.
pub(super) fn in_focus(lens: &RealLens) -> f64 {
    let object = RealRayFocus::new(&lens.prescription).object_distance(lens.film_distance);
    object.filter(|distance| *distance > 0.0).unwrap_or(f64::INFINITY)
}

/// Returns the position of the entrance pupil behind the front vertex (mm), limited to a finite
/// distance.
pub(super) fn pupil_position(plane: &Paraxial) -> f64 {
    let most = MAX_PUPIL_DISTANCE * plane.focal_length.abs();
    let position = plane.entrance_pupil.position;
    if position.is_nan() { most } else { position.clamp(-most, most) }
}
