//! Cameras: perspective and orthographic, and the camera of a scene that has none.

use glam::{DAffine3, DMat3, DVec3, Vec3};

use super::document::Document;
use crate::pbrt::{CameraSpec, FilmSpec, SceneError, ThinSpec};
use petzval_base::io::Location;

/// Height of the picture (pixels).
const HEIGHT: u32 = 720;
/// Width over height of the picture of a camera that does not say.
const ASPECT: f64 = 16.0 / 9.0;
/// Largest ratio of the sides of a picture.
const MAX_ASPECT: f64 = 20.0;
/// Diagonal of the film behind a real lens: that of 36 mm x 24 mm.
const FILM_DIAGONAL: f64 = 43.266_615;
/// Field of view of the camera of a scene that has none (degrees).
const DEFAULT_FIELD: f64 = 40.0;
/// Limit of the camera's coordinates, as in pbrt's language.
const MAX_COORDINATE: f64 = 1e18;

/// A camera with its pose in the world.
pub(super) struct PlacedCamera {
    pub spec: CameraSpec,
    pub film: FilmSpec,
    /// Camera space (+z to the scene) to world space.
    pub world_from_camera: DAffine3,
    pub at: Option<Location>,
}

impl PlacedCamera {
    /// Returns a camera that looks along -z at a box, a little from above.
    pub fn in_front_of([low, high]: [Vec3; 2]) -> Self {
        let (low, high) = (low.as_dvec3(), high.as_dvec3());
        let middle = (low + high) / 2.0;
        let radius = ((high - low).length() / 2.0).max(1e-6);
        let distance = radius / (DEFAULT_FIELD / 2.0).to_radians().sin();
        let away = DVec3::new(0.0, 0.25, 1.0).normalize();
        let view = perspective(DEFAULT_FIELD.to_radians(), ASPECT);
        let matrix3 = DMat3::from_cols(DVec3::X, away.cross(DVec3::X), away);
        let world_from_node = DAffine3 { matrix3, translation: middle + away * distance };
        Self {
            spec: CameraSpec::Thin(view),
            film: film(ASPECT),
            world_from_camera: pose(&world_from_node),
            at: None,
        }
    }
}

/// Returns a pinhole camera, given the vertical field of view (rad) and width over height.
fn perspective(yfov: f64, aspect: f64) -> ThinSpec {
    let tangent = (yfov / 2.0).tan();
    // The specification counts the field of view of the shorter side.
    let shorter = 2.0 * (tangent * aspect.min(1.0)).atan();
    ThinSpec { fov: Some(shorter.to_degrees()), takes_lens: true, ..ThinSpec::default() }
}

fn film(aspect: f64) -> FilmSpec {
    let width = (f64::from(HEIGHT) * aspect).round().max(1.0) as u32;
    let resolution = [width, HEIGHT];
    let bounds = [[0, 0], resolution];
    FilmSpec { resolution, bounds, diagonal: FILM_DIAGONAL, ..FilmSpec::default() }
}

/// Returns the transform from camera space, whose z points to the scene, given that of a node,
/// whose z points away from it. The scale of the node does not count.
fn pose(world_from_node: &DAffine3) -> DAffine3 {
    let z = world_from_node.matrix3.z_axis.normalize_or(DVec3::Z);
    let y = world_from_node.matrix3.y_axis;
    let y = (y - z * y.dot(z)).try_normalize().unwrap_or_else(|| z.any_orthonormal_vector());
    let matrix3 = DMat3::from_cols(y.cross(z), y, -z);
    DAffine3 { matrix3, translation: world_from_node.translation }
}

/// Reads a camera at a node.
pub(super) fn read_camera(
    document: &Document,
    index: usize,
    world_from_node: &DAffine3,
    named_at: &str,
) -> Result<PlacedCamera, SceneError> {
    let camera = document.entry(&document.root.cameras, index, "cameras", named_at)?;
    let element = format!("cameras/{index}");
    let refuse = |found: String, expected: &str| Err(document.error(&element, found, expected));
    let (spec, aspect) = match (&camera.kind[..], &camera.perspective, &camera.orthographic) {
        ("perspective", Some(view), _) => {
            let yfov = f64::from(view.yfov);
            if !(yfov > 0.0 && yfov < std::f64::consts::PI) {
                let found = format!("a field of view of {yfov}");
                return refuse(found, "expected more than 0 and less than pi (rad)");
            }
            let aspect = view.aspect_ratio.map_or(ASPECT, f64::from);
            (perspective(yfov, aspect), aspect)
        }
        ("orthographic", _, Some(view)) => {
            let [x, y] = [view.xmag, view.ymag].map(f64::from);
            if !(x > 0.0 && y > 0.0 && x.is_finite() && y.is_finite()) {
                let found = format!("magnifications of {x} and {y}");
                return refuse(found, "expected more than 0");
            }
            let window = Some([-x, x, -y, y]);
            (ThinSpec { fov: None, window, ..ThinSpec::default() }, x / y)
        }
        _ => {
            let expected = "expected \"perspective\" or \"orthographic\", as its type says";
            return refuse("a camera without a projection".to_owned(), expected);
        }
    };
    if !(1.0 / MAX_ASPECT..=MAX_ASPECT).contains(&aspect) {
        let found = format!("a picture {aspect} times as wide as it is high");
        return refuse(found, "expected 1/20 to 20");
    }
    let world_from_camera = pose(world_from_node);
    let far = world_from_camera.translation.abs().max_element();
    if far > MAX_COORDINATE || far.is_nan() {
        return refuse(format!("a camera at a distance of {far:e}"), "expected at most 1e18");
    }
    Ok(PlacedCamera {
        spec: CameraSpec::Thin(spec),
        film: film(aspect),
        world_from_camera,
        at: Some(document.location(&element)),
    })
}
