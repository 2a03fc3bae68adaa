//! Lines in the scene and their offsets.

use glam::DVec3;

use petzval_base::rays::LensBatch;

/// A line in the scene: mm from the front vertex of the reference, z to the scene.
#[derive(Clone, Copy)]
pub(super) struct SceneLine {
    pub start: DVec3,
    pub direction: DVec3,
}

impl SceneLine {
    /// Returns the line of a ray that left the lens; `None` if it is blocked.
    pub fn of_ray(batch: &LensBatch<f32>, i: usize) -> Option<Self> {
        let [x, y, z] = [batch.x[i], batch.y[i], batch.z[i]].map(f64::from);
        let [tx, ty, tz] = [batch.tx[i], batch.ty[i], batch.tz[i]].map(f64::from);
        let line =
            Self { start: DVec3::new(x, y, z), direction: DVec3::new(tx, ty, tz).normalize() };
        (!x.is_nan()).then_some(line)
    }

    /// Returns the offset by which this line misses a point of `line`, in the plane perpendicular
    /// to `line`: mm, or a slope if the point is at infinity. `None` if the lines point in opposite
    /// directions.
    pub fn offset_from(&self, line: &Self, distance: f64) -> Option<DVec3> {
        let along = self.direction.dot(line.direction);
        if along <= 0.0 {
            return None;
        }
        if distance.is_infinite() {
            return Some(self.direction / along - line.direction);
        }
        let point = line.start + distance * line.direction;
        let ahead = (point - self.start).dot(line.direction) / along;
        Some(self.start + ahead * self.direction - point)
    }
}

/// Returns the squared film displacement [mm^2] that moves the ray by `offset`, given its
/// displacements `x` and `y` per mm along either axis: by least squares.
pub(super) fn squared_film_displacement(offset: DVec3, x: DVec3, y: DVec3) -> Option<f64> {
    let (xx, xy, yy) = (x.dot(x), x.dot(y), y.dot(y));
    let (bx, by) = (offset.dot(x), offset.dot(y));
    let determinant = xx * yy - xy * xy;
    let [u, v] = [bx * yy - by * xy, by * xx - bx * xy].map(|v| v / determinant);
    let error2 = u * u + v * v;
    error2.is_finite().then_some(error2)
}
