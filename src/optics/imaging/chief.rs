//! Chief rays of field and object points.

use super::conditions::ImagingConditions;
use super::lens_at_wavelength::{LensAtWavelength, SceneRay};
use super::vector::{along, cross, dot, unit};
use petzval_lens::FieldKind;
use petzval_lens::StopRay;

/// A point of the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ObjectPoint {
    /// At infinity; its light travels in this direction (frame of the front vertex).
    Distant([f64; 3]),
    /// A point (mm, frame of the front vertex).
    Near([f64; 3]),
}

/// The chief ray of an object point: through the vertex of the stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChiefRay {
    /// The object point that it comes from.
    pub object: ObjectPoint,
    /// The ray before the lens.
    pub scene: SceneRay,
    /// Its point on the film (mm).
    pub film: [f64; 2],
    /// Its direction cosines across the axis at the stop.
    pub(super) cosines: [f64; 2],
}

impl ChiefRay {
    /// Returns the unit vectors across the ray before the lens: close to x and to y.
    pub(super) fn across(&self) -> [[f64; 3]; 2] {
        let k = self.scene.direction;
        let x = unit(along([1.0, 0.0, 0.0], -k[0], k));
        [x, cross(k, x)]
    }
}

/// Condition that a chief ray fulfils.
#[derive(Clone, Copy)]
enum Target {
    Field(FieldKind, [f64; 2]),
    Object(ObjectPoint),
}

impl Target {
    /// Returns the difference of a chief ray from the condition, and the scale of that difference.
    fn miss(self, lens: &LensAtWavelength, ray: &StopRay, share: f64) -> ([f64; 2], f64) {
        let differ = |a: [f64; 2], b: [f64; 2]| {
            ([0, 1].map(|i| a[i] - share * b[i]), b[0].abs().max(b[1].abs()).max(1.0))
        };
        let angles = |d: [f64; 3]| [d[0].atan2(d[2]), d[1].atan2(d[2])];
        let film = || ray.film_point(lens.film_distance);
        let ray = lens.before_lens(ray);
        match self {
            Self::Field(FieldKind::ImageHeight, field) => differ(film(), field),
            Self::Field(FieldKind::Angle, field) => {
                differ(angles(ray.direction), field.map(f64::to_radians))
            }
            Self::Field(FieldKind::ObjectHeight, field) => {
                differ(at_object(lens, ray).map_or([f64::NAN; 2], |p| [p[0], p[1]]), field)
            }
            Self::Object(ObjectPoint::Distant(direction)) => {
                differ(angles(ray.direction), angles(direction))
            }
            Self::Object(ObjectPoint::Near(point)) => differ(near_miss(ray, point), [0.0; 2]),
        }
    }
}

/// Returns how far a ray passes from a point, along x and y of the object plane where it meets it.
fn near_miss(ray: SceneRay, point: [f64; 3]) -> [f64; 2] {
    let s = (point[2] - ray.point[2]) / ray.direction[2];
    [0, 1].map(|i| ray.point[i] + s * ray.direction[i] - point[i])
}

/// Returns the point of a ray in the plane of a near object.
fn at_object(lens: &LensAtWavelength, ray: SceneRay) -> Option<[f64; 3]> {
    let s = (-lens.object_distance - ray.point[2]) / ray.direction[2];
    s.is_finite().then(|| along(ray.point, s, ray.direction))
}

impl LensAtWavelength {
    /// Returns the chief ray of a field point; `None` if no ray through the vertex of the stop
    /// belongs to it.
    pub(super) fn chief_of_field(
        &self,
        conditions: &ImagingConditions,
        field: [f64; 2],
    ) -> Option<ChiefRay> {
        let target = Target::Field(conditions.field_kind, field);
        let ray = self.chief_rays.follow(|ray, share| target.miss(self, ray, share))?;
        let scene = self.before_lens(&ray);
        let object = match self.object_distance.is_finite() {
            true => ObjectPoint::Near(at_object(self, scene)?),
            false => ObjectPoint::Distant(scene.direction),
        };
        Some(self.chief_ray(object, &ray))
    }

    /// Returns the chief ray of an object point, next to the one of another wavelength.
    pub(super) fn chief_of_object(&self, like: &ChiefRay) -> Option<ChiefRay> {
        let target = Target::Object(like.object);
        let ray = self.chief_rays.near(like.cosines, |ray| target.miss(self, ray, 1.0))?;
        Some(self.chief_ray(like.object, &ray))
    }

    fn chief_ray(&self, object: ObjectPoint, ray: &StopRay) -> ChiefRay {
        let film = ray.film_point(self.film_distance);
        ChiefRay { object, scene: self.before_lens(ray), film, cosines: ray.cosines }
    }

    /// Returns the part of a chief ray before the lens, towards the film.
    fn before_lens(&self, ray: &StopRay) -> SceneRay {
        let [x, y, z] = ray.scene.p;
        let [tx, ty, tz] = ray.scene.t.map(|t| t / self.scene_index());
        SceneRay { point: [x, y, -z], direction: [-tx, -ty, tz] }
    }

    /// Returns the start and direction of the ray from the object point of a chief ray with these
    /// pupil coordinates, and the optical path that lies before the start.
    ///
    /// For a distant object the coordinates are the offset from the chief ray across it (mm); for a
    /// near one they are the direction cosines across it.
    pub(super) fn scene_ray(
        &self,
        chief: &ChiefRay,
        [u, v]: [f64; 2],
    ) -> Option<([f64; 3], [f64; 3], f64)> {
        let k = chief.scene.direction;
        let [x, y] = chief.across();
        match chief.object {
            ObjectPoint::Distant(_) => {
                let start = along(along(chief.scene.point, u, x), v, y);
                Some((along(start, -self.run_up, k), k, 0.0))
            }
            ObjectPoint::Near(point) => {
                let w2 = 1.0 - u * u - v * v;
                if w2 <= 0.0 {
                    return None;
                }
                let direction = along(along(k.map(|k| k * w2.sqrt()), u, x), v, y);
                // The start is in the plane across the chief ray, before the lens.
                let to_lens = dot([0, 1, 2].map(|i| chief.scene.point[i] - point[i]), k);
                let run = (to_lens - self.run_up).max(0.0) / w2.sqrt();
                Some((along(point, run, direction), direction, run * self.scene_index()))
            }
        }
    }
}
