//! Projection of points in camera space onto the film.

use glam::{DAffine3, DVec3, Vec3};

use petzval_base::rays::{RayBatch, SampleBatch};
use petzval_base::stats::LensStats;
use petzval_lens::{Camera, LensColumns, LensModel, SphericalMapping};

/// Points from the middle of the film to its corner from which rays are traced.
const POINTS: usize = 24;

/// Mapping from directions to film points. For a real lens it is measured by chief rays, so it includes
/// distortion and fisheye projections.
pub(super) struct FilmProjection {
    projection: Projection,
    /// The width and height of the film.
    film: [f64; 2],
    /// The width and height of a pixel.
    pitch: [f64; 2],
}

enum Projection {
    /// Perspective: the middle of the picture in the plane z = 1.
    Plane([f64; 2]),
    /// Parallel rays: the middle of the picture in the plane z = 0.
    Parallel([f64; 2]),
    /// All directions.
    Sphere(SphericalMapping),
    /// Measured mapping.
    Angles {
        /// The depth of the entrance pupil.
        pupil: f64,
        /// Angles from the axis (radians), ascending, and distances from the middle of the film
        /// (mm).
        table: Vec<[f64; 2]>,
    },
}

impl FilmProjection {
    pub(super) fn of(camera: &Camera, resolution: [u32; 2]) -> Self {
        let projection = match &camera.model {
            LensModel::Thin(lens) => Projection::Plane(lens.middle),
            LensModel::Orthographic(parallel) => Projection::Parallel(parallel.middle),
            LensModel::Spherical(mapping) => Projection::Sphere(*mapping),
            LensModel::Real(lens) => {
                let pupil =
                    lens.front_depth - lens.paraxial.entrance_pupil.position * lens.units_per_mm;
                let mut angles = traced(camera);
                if angles.len() < 2 {
                    // First-order optics replace the measurement.
                    angles = vec![[0.0, 0.0], [0.01, 0.01 * lens.paraxial.focal_length.abs()]];
                }
                Projection::Angles { pupil, table: angles }
            }
        };
        let pitch = [0, 1].map(|i| camera.film[i] / f64::from(resolution[i]));
        Self { projection, film: camera.film, pitch }
    }

    /// Returns the position of a point's image [pixels from the middle of the film], and whether it is
    /// on the film; `None` for points behind the camera.
    pub(super) fn pixel(&self, p: DVec3) -> Option<([f64; 2], bool)> {
        let film = match &self.projection {
            Projection::Plane(_) | Projection::Parallel(_) if p.z <= 0.0 => return None,
            Projection::Plane([x, y]) => [p.x / p.z - x, p.y / p.z - y],
            Projection::Parallel([x, y]) => [p.x - x, p.y - y],
            Projection::Sphere(mapping) => {
                let at = mapping.point(p.as_vec3().normalize_or(Vec3::Z)).as_dvec2();
                [at.x - 0.5, 0.5 - at.y]
            }
            Projection::Angles { pupil, table } => {
                let to = p - DVec3::Z * pupil;
                let across = to.x.hypot(to.y);
                let radius = look_up(table, across.atan2(to.z));
                let scale = if across > 0.0 { radius / across } else { 0.0 };
                [to.x * scale, to.y * scale]
            }
        };
        let inside = (0..2).all(|i| film[i].abs() <= self.film[i] / 2.0);
        Some(([0, 1].map(|i| film[i] / self.pitch[i]), inside))
    }
}

/// Traces chief rays from film points at growing distances from the middle. Returns the angle and the
/// distance of those that leave the lens.
fn traced(camera: &Camera) -> Vec<[f64; 2]> {
    let camera = Camera { world_from_camera: DAffine3::IDENTITY, ..camera.clone() };
    let mut samples = SampleBatch { len: POINTS, ..SampleBatch::default() };
    let step = camera.half_diagonal() / (POINTS - 1) as f64;
    for i in 0..POINTS {
        samples.film[0][i] = (step * i as f64) as f32;
        // This pupil point is the middle of the pupil.
        samples.pupil[0][i] = 0.5;
    }
    let mut rays = RayBatch::default();
    let mut stats = LensStats::default();
    camera.generate_rays::<f32>(&samples, &mut LensColumns::default(), &mut rays, &mut stats);
    let mut table: Vec<[f64; 2]> = Vec::with_capacity(rays.len);
    for i in 0..rays.len {
        let [x, y, z] = rays.ray(i).direction.map(f64::from);
        let angle = x.hypot(y).atan2(z);
        if table.last().is_none_or(|[last, _]| angle > *last) {
            table.push([angle, step * f64::from(rays.slot[i])]);
        }
    }
    table
}

/// Returns the distance for an angle by linear interpolation and extrapolation.
fn look_up(table: &[[f64; 2]], angle: f64) -> f64 {
    let next = table.partition_point(|[known, _]| *known <= angle).clamp(1, table.len() - 1);
    let ([a, from], [b, to]) = (table[next - 1], table[next]);
    from + (to - from) * (angle - a) / (b - a)
}
