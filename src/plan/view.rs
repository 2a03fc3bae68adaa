//! Where on the film a point of the scene is seen.

use glam::{DAffine3, DVec3};

use crate::lens::{Camera, LensColumns, Model};
use crate::rays::{RayBatch, SampleBatch};
use crate::stats::LensStats;

/// Places from the middle of the film to its corner from which rays are traced.
const PLACES: usize = 24;

/// What a camera makes of angles, by tracing a ray from every place through the middle of its
/// pupil: fisheyes and distortion are what they are.
pub(super) struct View {
    projection: Projection,
    /// Width and height of the film, and of a pixel.
    film: [f64; 2],
    pitch: [f64; 2],
}

enum Projection {
    /// The middle of what is seen, in the plane z = 1.
    Plane([f64; 2]),
    /// Depth of the pupil; angles from the axis, radians, ascending, and how far from the middle
    /// of the film they are pictured, mm.
    Angles(f64, Vec<[f64; 2]>),
}

impl View {
    pub(super) fn of(camera: &Camera, resolution: [u32; 2]) -> Self {
        let projection = match &camera.model {
            Model::Thin(lens) => Projection::Plane(lens.middle),
            Model::Real(lens) => {
                let pupil = lens.front - lens.paraxial.entrance_pupil.position * lens.unit;
                let mut angles = traced(camera, lens.prescription.rows.len());
                if angles.len() < 2 {
                    // By first-order optics.
                    angles = vec![[0.0, 0.0], [0.01, 0.01 * lens.paraxial.focal_length.abs()]];
                }
                Projection::Angles(pupil, angles)
            }
        };
        let pitch = [0, 1].map(|i| camera.film[i] / f64::from(resolution[i]));
        Self { projection, film: camera.film, pitch }
    }

    /// Where a point of camera space is seen, pixels from the middle of the film, and whether
    /// that is on the film; `None` behind the camera.
    pub(super) fn pixel(&self, p: DVec3) -> Option<([f64; 2], bool)> {
        let film = match &self.projection {
            Projection::Plane(_) if p.z <= 0.0 => return None,
            Projection::Plane([x, y]) => [p.x / p.z - x, p.y / p.z - y],
            Projection::Angles(pupil, table) => {
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

/// Angles of rays that leave the film at growing distances from its middle, as far as light
/// comes through.
fn traced(camera: &Camera, rows: usize) -> Vec<[f64; 2]> {
    let camera = Camera { world_from_camera: DAffine3::IDENTITY, ..camera.clone() };
    let mut samples = SampleBatch { len: PLACES, ..SampleBatch::default() };
    let step = camera.half_diagonal() / (PLACES - 1) as f64;
    for i in 0..PLACES {
        samples.film[0][i] = (step * i as f64) as f32;
        // The middle of the pupil.
        samples.pupil[0][i] = 0.5;
    }
    let mut rays = RayBatch::default();
    let mut stats = LensStats { blocked: vec![0; rows], ..LensStats::default() };
    camera.expose::<f32>(&samples, &mut LensColumns::default(), &mut rays, &mut stats);
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

/// The radius of an angle, straight between those that are known and on beyond them.
fn look_up(table: &[[f64; 2]], angle: f64) -> f64 {
    let next = table.partition_point(|[known, _]| *known <= angle).clamp(1, table.len() - 1);
    let ([a, from], [b, to]) = (table[next - 1], table[next]);
    from + (to - from) * (angle - a) / (b - a)
}
