//! Spheres, cylinders, disks and cones: intersected in f64 in their own space.

use std::f64::consts::TAU;

use glam::{DAffine3, DVec3, Vec2};

use super::light::Ball;
use super::point::{Patch, SurfacePoint, gamma};
use crate::sampler::disk;

/// How far from the axis a point on it is moved for want of a direction, in radii.
const CLOSE_BY: f64 = 1e-5;

/// A form in its own space, as pbrt defines it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// A sphere about the origin, cut at two heights.
    Sphere {
        /// Its radius.
        radius: f64,
        /// Lowest and highest z that belong to it.
        z: [f64; 2],
    },
    /// The mantle of a cylinder about the z axis.
    Cylinder {
        /// Its radius.
        radius: f64,
        /// Lowest and highest z.
        z: [f64; 2],
    },
    /// A disk at a height on the z axis.
    Disk {
        /// Its outer radius.
        radius: f64,
        /// Radius of the hole.
        inner: f64,
        /// Its height.
        height: f64,
    },
    /// The mantle of a cone with its base at z = 0.
    Cone {
        /// Radius of the base.
        radius: f64,
        /// z of the apex.
        height: f64,
    },
}

/// A form placed in the space of the object it belongs to.
#[derive(Clone, Debug, PartialEq)]
pub struct Quadric {
    form: Form,
    phi_max: f64,
    object_from_form: DAffine3,
    form_from_object: DAffine3,
    /// -1 where the scene file reversed the orientation.
    side: f64,
    /// By how much the placement stretches volumes.
    volume: f64,
}

impl Quadric {
    /// What its form is called.
    pub fn name(&self) -> &'static str {
        match self.form {
            Form::Sphere { .. } => "sphere",
            Form::Cylinder { .. } => "cylinder",
            Form::Disk { .. } => "disk",
            Form::Cone { .. } => "cone",
        }
    }

    /// Places a form; `phi_max` in radians cuts a piece out of it around z. `None` where the
    /// transform flattens it to nothing.
    pub fn new(form: Form, phi_max: f64, place: DAffine3, reversed: bool) -> Option<Self> {
        let inverse = place.inverse();
        (inverse.is_finite() && place.is_finite()).then_some(Self {
            form,
            phi_max,
            object_from_form: place,
            form_from_object: inverse,
            side: if reversed { -1.0 } else { 1.0 },
            volume: place.matrix3.determinant().abs(),
        })
    }

    /// A box around it: lowest and highest corner.
    pub fn bounds(&self) -> [DVec3; 2] {
        let (radius, z) = match self.form {
            Form::Sphere { radius, z } | Form::Cylinder { radius, z } => (radius, z),
            Form::Disk { radius, height, .. } => (radius, [height, height]),
            Form::Cone { radius, height } => (radius, [height.min(0.0), height.max(0.0)]),
        };
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for corner in 0..8 {
            let pick = |bit: u32| if corner >> bit & 1 == 0 { -radius } else { radius };
            let p = DVec3::new(pick(0), pick(1), z[corner >> 2 & 1]);
            let p = self.object_from_form.transform_point3(p);
            (low, high) = (low.min(p), high.max(p));
        }
        [low, high]
    }

    /// Distance to the first point that a ray meets with 0 < t < `t_max`.
    pub fn intersect(&self, origin: DVec3, direction: DVec3, t_max: f64) -> Option<f64> {
        let o = self.form_from_object.transform_point3(origin);
        let d = self.form_from_object.transform_vector3(direction);
        let meets = |t: f64| t > 0.0 && t < t_max && self.holds(o + d * t);
        let roots = match self.form {
            Form::Disk { height, .. } => [(height - o.z) / d.z, f64::NAN],
            Form::Sphere { radius, .. } => {
                // About the point nearest to the centre, where nothing cancels (Haines et al.
                // 2019, "Precision improvements for ray/sphere intersection").
                let a = d.length_squared();
                let half_b = -o.dot(d);
                let nearest = o + d * (half_b / a);
                quadratic(a, half_b, o.length_squared() - radius * radius, {
                    a * (radius * radius - nearest.length_squared())
                })
            }
            Form::Cylinder { radius, .. } => {
                // About the point nearest to the axis, as for the sphere.
                let (o, d) = (o.truncate(), d.truncate());
                let a = d.length_squared();
                let half_b = -o.dot(d);
                let nearest = o + d * (half_b / a);
                quadratic(a, half_b, o.length_squared() - radius * radius, {
                    a * (radius * radius - nearest.length_squared())
                })
            }
            Form::Cone { radius, height } => {
                let k = (radius / height).powi(2);
                let rise = o.z - height;
                let a = d.x * d.x + d.y * d.y - k * d.z * d.z;
                let half_b = -(o.x * d.x + o.y * d.y - k * rise * d.z);
                let c = o.x * o.x + o.y * o.y - k * rise * rise;
                quadratic(a, half_b, c, half_b * half_b - a * c)
            }
        };
        roots.into_iter().find(|&t| meets(t))
    }

    /// Whether a point of the infinite form belongs to its part.
    fn holds(&self, p: DVec3) -> bool {
        let inside = match self.form {
            Form::Sphere { radius, z } => {
                let whole = z == [-radius, radius];
                whole || (p.z >= z[0] && p.z <= z[1])
            }
            Form::Cylinder { z, .. } => p.z >= z[0] && p.z <= z[1],
            Form::Disk { radius, inner, .. } => {
                let r2 = p.x * p.x + p.y * p.y;
                r2 <= radius * radius && r2 >= inner * inner
            }
            Form::Cone { height, .. } => p.z * height.signum() >= 0.0 && p.z.abs() <= height.abs(),
        };
        inside && (self.phi_max >= TAU || phi(p) <= self.phi_max)
    }

    /// The point of the surface at (or, after rounding, next to) a point of object space.
    pub fn point(&self, near: DVec3) -> SurfacePoint {
        let p = self.form_from_object.transform_point3(near);
        let (p, normal) = match self.form {
            Form::Sphere { radius, .. } => {
                let normal = p.normalize();
                (normal * radius, normal)
            }
            Form::Cylinder { radius, .. } => {
                let away = direction(p.x, p.y, p.x * p.x + p.y * p.y);
                (away * radius + DVec3::Z * p.z, away)
            }
            Form::Disk { height, .. } => (DVec3::new(p.x, p.y, height), DVec3::Z),
            Form::Cone { radius, height } => {
                let away = direction(p.x, p.y, p.x * p.x + p.y * p.y);
                let r = radius * (1.0 - p.z / height).max(0.0);
                (away * r + DVec3::Z * p.z, cone_normal(away, radius, height))
            }
        };
        self.placed(p, self.outwards(normal).normalize())
    }

    /// Texture coordinates of a point of the form, as pbrt defines them.
    fn uv(&self, p: DVec3) -> Vec2 {
        let v = match self.form {
            Form::Sphere { radius, z } => {
                let theta = |z: f64| (z / radius).clamp(-1.0, 1.0).acos();
                (theta(p.z) - theta(z[0])) / (theta(z[1]) - theta(z[0]))
            }
            Form::Cylinder { z, .. } => (p.z - z[0]) / (z[1] - z[0]),
            Form::Disk { radius, inner, .. } => (radius - p.x.hypot(p.y)) / (radius - inner),
            Form::Cone { height, .. } => p.z / height,
        };
        Vec2::new((phi(p) / self.phi_max) as f32, v as f32)
    }

    /// How the surface is laid out in texture coordinates about a point of object space.
    ///
    /// Where all u meet, at a pole, an apex or the middle of a disk, it is that of a point
    /// close by.
    pub fn patch(&self, near: DVec3) -> Patch {
        let p = self.form_from_object.transform_point3(near);
        let away = direction(p.x, p.y, p.x * p.x + p.y * p.y);
        let around = DVec3::new(-away.y, away.x, 0.0) * self.phi_max;
        let r = |radius: f64| p.x.hypot(p.y).max(CLOSE_BY * radius);
        // Changes of the position, and of the unit normal in the form's own space.
        let (dp, normal, dn) = match self.form {
            Form::Sphere { radius, z } => {
                let theta = |z: f64| (z / radius).clamp(-1.0, 1.0).acos();
                let sweep = theta(z[1]) - theta(z[0]);
                let r = r(radius);
                let dp = [around * r, (away * p.z - DVec3::Z * r) * sweep];
                (dp, p.normalize(), dp.map(|d| d / radius))
            }
            Form::Cylinder { radius, z } => {
                let dp = [around * radius, DVec3::Z * (z[1] - z[0])];
                (dp, away, [around, DVec3::ZERO])
            }
            Form::Disk { radius, inner, .. } => {
                ([around * r(radius), away * (inner - radius)], DVec3::Z, [DVec3::ZERO; 2])
            }
            Form::Cone { radius, height } => {
                let dp = [around * r(radius), DVec3::Z * height - away * radius];
                let slope = height.abs() / radius.hypot(height);
                (dp, cone_normal(away, radius, height), [around * slope, DVec3::ZERO])
            }
        };
        let normal = self.outwards(normal);
        let (length, unit) = (normal.length(), normal.normalize());
        let turned = |dn: DVec3| {
            let dn = self.outwards(dn) * (self.side / length);
            (dn - unit * unit.dot(dn)).as_vec3()
        };
        Patch {
            uv: self.uv(p),
            dp: dp.map(|d| self.object_from_form.transform_vector3(d).as_vec3()),
            dn: dn.map(turned),
        }
    }

    /// A normal of the form as a vector of object space. Its length is the ratio of a small
    /// area in the form's space to the same area in object space, times the determinant.
    fn outwards(&self, normal: DVec3) -> DVec3 {
        self.form_from_object.matrix3.transpose() * normal
    }

    fn placed(&self, p: DVec3, normal: DVec3) -> SurfacePoint {
        let position = self.object_from_form.transform_point3(p).as_vec3();
        let normal = (normal * self.side).as_vec3();
        // The point is exact in f64; rounding it to f32, and once more, are the only errors.
        let error = position.abs() * gamma(3) + f32::MIN_POSITIVE;
        SurfacePoint { position, error, normal, shading: normal }
    }

    /// A point chosen uniformly by area in the form's own space, and its density by area in
    /// object space.
    pub fn sample(&self, u: [f32; 2]) -> (SurfacePoint, f32) {
        // A point of the unit disk; where a piece is cut out, its angle is squeezed.
        let [x, y] = if self.phi_max < TAU {
            let (sin, cos) = (f64::from(u[0]) * self.phi_max).sin_cos();
            [cos, sin].map(|v| v * f64::from(u[1]).sqrt())
        } else {
            disk(u[0], u[1]).map(f64::from)
        };
        let r2 = (x * x + y * y).min(1.0);
        let (p, normal, area) = match self.form {
            Form::Sphere { radius, z } => {
                // Equal heights have equal areas (Archimedes).
                let height = z[0] + (z[1] - z[0]) * r2;
                let r = (radius * radius - height * height).max(0.0).sqrt();
                let p = direction(x, y, r2) * r + DVec3::Z * height;
                (p, p / radius, self.phi_max * radius * (z[1] - z[0]))
            }
            Form::Cylinder { radius, z } => {
                let normal = direction(x, y, r2);
                let height = z[1] - z[0];
                let p = normal * radius + DVec3::Z * (z[0] + height * r2);
                (p, normal, self.phi_max * radius * height)
            }
            Form::Disk { radius, inner, height } => {
                let ring = radius * radius - inner * inner;
                let p = match inner {
                    0.0 => DVec3::new(x, y, 0.0) * radius,
                    _ => direction(x, y, r2) * (inner * inner + ring * r2).sqrt(),
                };
                (p + DVec3::Z * height, DVec3::Z, self.phi_max / 2.0 * ring)
            }
            Form::Cone { radius, height } => {
                // The mantle unrolls to a sector: its density falls with r like a disk's.
                let p = DVec3::new(x * radius, y * radius, height * (1.0 - r2.sqrt()));
                let normal = cone_normal(direction(x, y, r2), radius, height);
                (p, normal, self.phi_max / 2.0 * radius * radius.hypot(height))
            }
        };
        let normal = self.outwards(normal);
        let length = normal.length();
        let stretch = self.volume * length;
        (self.placed(p, normal / length), (1.0 / (area * stretch)) as f32)
    }

    /// The density by area in object space of [`Self::sample`] at a point of object space.
    pub fn density(&self, near: DVec3) -> f32 {
        let p = self.form_from_object.transform_point3(near);
        let (normal, area) = match self.form {
            Form::Sphere { radius, z } => (p.normalize(), self.phi_max * radius * (z[1] - z[0])),
            Form::Cylinder { radius, z } => {
                let away = direction(p.x, p.y, p.x * p.x + p.y * p.y);
                (away, self.phi_max * radius * (z[1] - z[0]))
            }
            Form::Disk { radius, inner, .. } => {
                (DVec3::Z, self.phi_max / 2.0 * (radius * radius - inner * inner))
            }
            Form::Cone { radius, height } => {
                let away = direction(p.x, p.y, p.x * p.x + p.y * p.y);
                let area = self.phi_max / 2.0 * radius * radius.hypot(height);
                (cone_normal(away, radius, height), area)
            }
        };
        (1.0 / (area * self.volume * self.outwards(normal).length())) as f32
    }

    /// The sphere of object space that it is, if it is a whole one.
    pub fn ball(&self) -> Option<Ball> {
        let Form::Sphere { radius, z } = self.form else { return None };
        let [x, y, w] = self.object_from_form.matrix3.to_cols_array_2d().map(DVec3::from_array);
        let scale2 = x.length_squared();
        let same = |a: f64, b: f64| (a - b).abs() < 1e-6 * scale2;
        let similar = same(y.length_squared(), scale2)
            && same(w.length_squared(), scale2)
            && [x.dot(y), y.dot(w), w.dot(x)].into_iter().all(|dot| same(dot, 0.0));
        let whole = z == [-radius, radius] && self.phi_max >= TAU;
        (similar && whole).then(|| Ball {
            centre: self.object_from_form.translation,
            radius: radius * scale2.sqrt(),
            side: self.side,
        })
    }

    /// The unit normal of a flat form, in object space.
    pub fn flat_normal(&self) -> Option<DVec3> {
        let flat = matches!(self.form, Form::Disk { .. });
        flat.then(|| (self.outwards(DVec3::Z) * self.side).normalize())
    }

    /// Its area in object space, by the midpoint rule over its parameters.
    pub fn area(&self) -> f64 {
        let steps = 32;
        let middle = |i: i32| (i as f32 + 0.5) / steps as f32;
        let total: f64 = (0..steps * steps)
            .map(|i| f64::from(1.0 / self.sample([middle(i / steps), middle(i % steps)]).1))
            .sum();
        total / f64::from(steps * steps)
    }
}

/// The unit vector away from the z axis through (x, y), whose square length is given.
fn direction(x: f64, y: f64, r2: f64) -> DVec3 {
    if r2 > 0.0 { DVec3::new(x, y, 0.0) / r2.sqrt() } else { DVec3::X }
}

/// Unit normal of a cone where it is this far around.
fn cone_normal(away: DVec3, radius: f64, height: f64) -> DVec3 {
    (away * height.abs() + DVec3::Z * (radius * height.signum())).normalize()
}

/// Angle about z in [0, 2 pi).
fn phi(p: DVec3) -> f64 {
    let angle = p.y.atan2(p.x);
    if angle < 0.0 { angle + TAU } else { angle }
}

/// The roots of a t^2 - 2 b t + c in ascending order, without cancellation; NaN where there
/// are none. `discriminant` is b^2 - a c, computed as exactly as the caller can.
fn quadratic(a: f64, half_b: f64, c: f64, discriminant: f64) -> [f64; 2] {
    let root = discriminant.sqrt();
    let q = if half_b < 0.0 { half_b - root } else { half_b + root };
    let (one, other) = (c / q, q / a);
    if one < other { [one, other] } else { [other, one] }
}
