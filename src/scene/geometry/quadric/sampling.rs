//! Sampling of quadrics by area, for area lights.

use glam::DVec3;

use super::{Quadric, QuadricForm, SurfacePoint, TAU, cone_normal, direction};
use crate::geometry::{SurfacePacket, gamma};
use petzval_base::lanes::Real;
use petzval_base::lanes::vector::{abs, add, scale, scale_add};
use petzval_base::sampler::concentric_disk;

/// A whole disk in every lane, or an ellipse.
#[derive(Clone, Copy, Debug)]
pub struct DiskPacket<R> {
    /// Centre.
    pub centre: [R; 3],
    /// Perpendicular radii of the circle, or conjugate ones of the ellipse.
    pub radii: [[R; 3]; 2],
    /// Unit normal.
    pub normal: [R; 3],
    /// Density of a point sampled uniformly by area.
    pub density: R,
}

impl<R: Real<Scalar = f32>> DiskPacket<R> {
    /// Samples points uniformly by area.
    #[inline(always)]
    pub fn sample(&self, u: [R; 2]) -> SurfacePacket<R> {
        let [x, y] = concentric_disk(u[0], u[1]);
        let [a, b] = self.radii;
        let position = scale_add(a, x, scale_add(b, y, self.centre));
        let size = add(abs(self.centre), add(abs(a), abs(b)));
        let error = scale(size, R::splat(gamma(5)));
        SurfacePacket { position, error, normal: self.normal, shading_normal: self.normal }
    }
}

impl Quadric {
    /// Returns the disk in object space, if the quadric is a whole one without a hole.
    pub fn whole_disk(&self) -> Option<DiskPacket<f32>> {
        let QuadricForm::Disk { radius, inner, height } = self.form else { return None };
        let (_, density) = self.sample([0.5; 2]);
        let matrix = self.object_from_form.matrix3;
        let whole = inner == 0.0 && self.phi_max >= TAU;
        whole.then(|| DiskPacket {
            centre: self.object_from_form.transform_point3(DVec3::Z * height).as_vec3().into(),
            radii: [matrix.x_axis, matrix.y_axis].map(|axis| (axis * radius).as_vec3().into()),
            normal: ((self.transform_normal(DVec3::Z) * self.side).normalize()).as_vec3().into(),
            density,
        })
    }

    /// Samples a point uniformly by area in the quadric's own space. Returns it and its density by
    /// area in object space.
    pub fn sample(&self, u: [f32; 2]) -> (SurfacePoint, f32) {
        // A point of the unit disk, or of its sector if the angle is limited.
        let [x, y] = if self.phi_max < TAU {
            let (sin, cos) = (f64::from(u[0]) * self.phi_max).sin_cos();
            [cos, sin].map(|v| v * f64::from(u[1]).sqrt())
        } else {
            concentric_disk(u[0], u[1]).map(f64::from)
        };
        let r2 = (x * x + y * y).min(1.0);
        let (p, normal, area) = match self.form {
            QuadricForm::Sphere { radius, z } => {
                // Equal heights have equal areas (Archimedes).
                let height = z[0] + (z[1] - z[0]) * r2;
                let r = (radius * radius - height * height).max(0.0).sqrt();
                let p = direction(x, y, r2) * r + DVec3::Z * height;
                (p, p / radius, self.phi_max * radius * (z[1] - z[0]))
            }
            QuadricForm::Cylinder { radius, z } => {
                let normal = direction(x, y, r2);
                let height = z[1] - z[0];
                let p = normal * radius + DVec3::Z * (z[0] + height * r2);
                (p, normal, self.phi_max * radius * height)
            }
            QuadricForm::Disk { radius, inner, height } => {
                let ring = radius * radius - inner * inner;
                let p = match inner {
                    0.0 => DVec3::new(x, y, 0.0) * radius,
                    _ => direction(x, y, r2) * (inner * inner + ring * r2).sqrt(),
                };
                (p + DVec3::Z * height, DVec3::Z, self.phi_max / 2.0 * ring)
            }
            QuadricForm::Cone { radius, height } => {
                // The area element of the lateral surface is proportional to r, like that of a
                // disk.
                let p = DVec3::new(x * radius, y * radius, height * (1.0 - r2.sqrt()));
                let normal = cone_normal(direction(x, y, r2), radius, height);
                (p, normal, self.phi_max / 2.0 * radius * radius.hypot(height))
            }
        };
        let normal = self.transform_normal(normal);
        let length = normal.length();
        let stretch = self.volume_scale * length;
        (self.place_point(p, normal / length), (1.0 / (area * stretch)) as f32)
    }

    /// Returns the density of [`Self::sample`] by area, at a point of the surface, object space.
    pub fn density(&self, near: DVec3) -> f32 {
        let p = self.form_from_object.transform_point3(near);
        let (normal, area) = match self.form {
            QuadricForm::Sphere { radius, z } => {
                (p.normalize(), self.phi_max * radius * (z[1] - z[0]))
            }
            QuadricForm::Cylinder { radius, z } => {
                let away = direction(p.x, p.y, p.x * p.x + p.y * p.y);
                (away, self.phi_max * radius * (z[1] - z[0]))
            }
            QuadricForm::Disk { radius, inner, .. } => {
                (DVec3::Z, self.phi_max / 2.0 * (radius * radius - inner * inner))
            }
            QuadricForm::Cone { radius, height } => {
                let away = direction(p.x, p.y, p.x * p.x + p.y * p.y);
                let area = self.phi_max / 2.0 * radius * radius.hypot(height);
                (cone_normal(away, radius, height), area)
            }
        };
        (1.0 / (area * self.volume_scale * self.transform_normal(normal).length())) as f32
    }

    /// Returns the area in object space, by the midpoint rule over the parameters of
    /// [`Self::sample`].
    pub fn area(&self) -> f64 {
        let steps = 32;
        let middle = |i: i32| (i as f32 + 0.5) / steps as f32;
        let total: f64 = (0..steps * steps)
            .map(|i| f64::from(1.0 / self.sample([middle(i / steps), middle(i % steps)]).1))
            .sum();
        total / f64::from(steps * steps)
    }
}
