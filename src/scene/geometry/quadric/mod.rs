//! Quadrics: spheres, cylinders, disks and cones, intersected in f64 in their own space.

mod sampling;

use std::f64::consts::TAU;

use glam::{DAffine3, DVec3, Vec2};

use super::surface_point::{SurfaceDerivatives, SurfacePoint, gamma};

/// Least distance from the axis at which derivatives are evaluated, relative to the radius: on the
/// axis itself, u has no direction.
const CLOSE_BY: f64 = 1e-5;

/// Kind of a quadric and its size, in its own space, as pbrt defines it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum QuadricForm {
    /// A sphere about the origin, clipped at two heights.
    Sphere {
        /// Radius.
        radius: f64,
        /// Lowest and highest z.
        z: [f64; 2],
    },
    /// The lateral surface of a cylinder about the z axis.
    Cylinder {
        /// Radius.
        radius: f64,
        /// Lowest and highest z.
        z: [f64; 2],
    },
    /// A disk at a height on the z axis.
    Disk {
        /// Outer radius.
        radius: f64,
        /// Radius of the hole.
        inner: f64,
        /// Height, z.
        height: f64,
    },
    /// The lateral surface of a cone with its base at z = 0.
    Cone {
        /// Radius of the base.
        radius: f64,
        /// z of the apex.
        height: f64,
    },
}

/// A quadric in the space of the object that it belongs to.
#[derive(Clone, Debug, PartialEq)]
pub struct Quadric {
    form: QuadricForm,
    phi_max: f64,
    object_from_form: DAffine3,
    form_from_object: DAffine3,
    /// -1 if the scene file reverses the orientation, otherwise 1.
    side: f64,
    /// Factor by which `object_from_form` scales volumes.
    volume_scale: f64,
}

/// A whole sphere, in the space of the object that it belongs to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Centre.
    pub centre: DVec3,
    /// Radius.
    pub radius: f64,
    /// 1 if the normals point outwards, -1 if they point inwards.
    pub side: f64,
}

impl Quadric {
    /// Returns pbrt's name of the kind.
    pub fn name(&self) -> &'static str {
        match self.form {
            QuadricForm::Sphere { .. } => "sphere",
            QuadricForm::Cylinder { .. } => "cylinder",
            QuadricForm::Disk { .. } => "disk",
            QuadricForm::Cone { .. } => "cone",
        }
    }

    /// Places a quadric. It extends from angle 0 to `phi_max` (rad) about z. Returns `None` if the
    /// transform cannot be inverted.
    pub fn new(
        form: QuadricForm,
        phi_max: f64,
        object_from_form: DAffine3,
        reversed: bool,
    ) -> Option<Self> {
        let inverse = object_from_form.inverse();
        (inverse.is_finite() && object_from_form.is_finite()).then_some(Self {
            form,
            phi_max,
            object_from_form,
            form_from_object: inverse,
            side: if reversed { -1.0 } else { 1.0 },
            volume_scale: object_from_form.matrix3.determinant().abs(),
        })
    }

    /// Returns a box around it: lowest and highest corner, object space.
    pub fn bounds(&self) -> [DVec3; 2] {
        let (radius, z) = match self.form {
            QuadricForm::Sphere { radius, z } | QuadricForm::Cylinder { radius, z } => (radius, z),
            QuadricForm::Disk { radius, height, .. } => (radius, [height, height]),
            QuadricForm::Cone { radius, height } => (radius, [height.min(0.0), height.max(0.0)]),
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

    /// Returns the distance to the first intersection of a ray with 0 < t < `t_max`.
    pub fn intersect(&self, origin: DVec3, direction: DVec3, t_max: f64) -> Option<f64> {
        let o = self.form_from_object.transform_point3(origin);
        let d = self.form_from_object.transform_vector3(direction);
        let meets = |t: f64| t > 0.0 && t < t_max && self.contains(o + d * t);
        let roots = match self.form {
            QuadricForm::Disk { height, .. } => [(height - o.z) / d.z, f64::NAN],
            QuadricForm::Sphere { radius, .. } => {
                // The discriminant from the point nearest to the centre does not cancel (Haines et
                // al. 2019, "Precision improvements for ray/sphere intersection").
                let a = d.length_squared();
                let half_b = -o.dot(d);
                let nearest = o + d * (half_b / a);
                quadratic(a, half_b, o.length_squared() - radius * radius, {
                    a * (radius * radius - nearest.length_squared())
                })
            }
            QuadricForm::Cylinder { radius, .. } => {
                // The discriminant from the point nearest to the axis, as for the sphere.
                let (o, d) = (o.truncate(), d.truncate());
                let a = d.length_squared();
                let half_b = -o.dot(d);
                let nearest = o + d * (half_b / a);
                quadratic(a, half_b, o.length_squared() - radius * radius, {
                    a * (radius * radius - nearest.length_squared())
                })
            }
            QuadricForm::Cone { radius, height } => {
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

    /// Returns whether a point of the unclipped surface is within the clipping limits.
    fn contains(&self, p: DVec3) -> bool {
        let inside = match self.form {
            QuadricForm::Sphere { radius, z } => {
                let whole = z == [-radius, radius];
                whole || (p.z >= z[0] && p.z <= z[1])
            }
            QuadricForm::Cylinder { z, .. } => p.z >= z[0] && p.z <= z[1],
            QuadricForm::Disk { radius, inner, .. } => {
                let r2 = p.x * p.x + p.y * p.y;
                r2 <= radius * radius && r2 >= inner * inner
            }
            QuadricForm::Cone { height, .. } => {
                p.z * height.signum() >= 0.0 && p.z.abs() <= height.abs()
            }
        };
        inside && (self.phi_max >= TAU || phi(p) <= self.phi_max)
    }

    /// Returns the surface point at a point of object space that is on the surface to rounding.
    pub fn point(&self, near: DVec3) -> SurfacePoint {
        let p = self.form_from_object.transform_point3(near);
        let (p, normal) = match self.form {
            QuadricForm::Sphere { radius, .. } => {
                let normal = p.normalize();
                (normal * radius, normal)
            }
            QuadricForm::Cylinder { radius, .. } => {
                let away = direction(p.x, p.y, p.x * p.x + p.y * p.y);
                (away * radius + DVec3::Z * p.z, away)
            }
            QuadricForm::Disk { height, .. } => (DVec3::new(p.x, p.y, height), DVec3::Z),
            QuadricForm::Cone { radius, height } => {
                let away = direction(p.x, p.y, p.x * p.x + p.y * p.y);
                let r = radius * (1.0 - p.z / height).max(0.0);
                (away * r + DVec3::Z * p.z, cone_normal(away, radius, height))
            }
        };
        self.place_point(p, self.transform_normal(normal).normalize())
    }

    /// Returns the texture coordinates of a point in the quadric's own space, as pbrt defines them.
    fn uv(&self, p: DVec3) -> Vec2 {
        let v = match self.form {
            QuadricForm::Sphere { radius, z } => {
                let theta = |z: f64| (z / radius).clamp(-1.0, 1.0).acos();
                (theta(p.z) - theta(z[0])) / (theta(z[1]) - theta(z[0]))
            }
            QuadricForm::Cylinder { z, .. } => (p.z - z[0]) / (z[1] - z[0]),
            QuadricForm::Disk { radius, inner, .. } => (radius - p.x.hypot(p.y)) / (radius - inner),
            QuadricForm::Cone { height, .. } => p.z / height,
        };
        Vec2::new((phi(p) / self.phi_max) as f32, v as f32)
    }

    /// Returns the texture coordinates at a point of object space, and the derivatives with respect
    /// to them.
    ///
    /// At a pole, an apex or the centre of a disk, where u is undefined, the derivatives are those
    /// of a point close by.
    pub fn derivatives(&self, near: DVec3) -> SurfaceDerivatives {
        let p = self.form_from_object.transform_point3(near);
        let away = direction(p.x, p.y, p.x * p.x + p.y * p.y);
        let around = DVec3::new(-away.y, away.x, 0.0) * self.phi_max;
        let r = |radius: f64| p.x.hypot(p.y).max(CLOSE_BY * radius);
        // Derivatives of the position, and of the unit normal in the quadric's own space.
        let (dp, normal, dn) = match self.form {
            QuadricForm::Sphere { radius, z } => {
                let theta = |z: f64| (z / radius).clamp(-1.0, 1.0).acos();
                let sweep = theta(z[1]) - theta(z[0]);
                let r = r(radius);
                let dp = [around * r, (away * p.z - DVec3::Z * r) * sweep];
                (dp, p.normalize(), dp.map(|d| d / radius))
            }
            QuadricForm::Cylinder { radius, z } => {
                let dp = [around * radius, DVec3::Z * (z[1] - z[0])];
                (dp, away, [around, DVec3::ZERO])
            }
            QuadricForm::Disk { radius, inner, .. } => {
                ([around * r(radius), away * (inner - radius)], DVec3::Z, [DVec3::ZERO; 2])
            }
            QuadricForm::Cone { radius, height } => {
                let dp = [around * r(radius), DVec3::Z * height - away * radius];
                let slope = height.abs() / radius.hypot(height);
                (dp, cone_normal(away, radius, height), [around * slope, DVec3::ZERO])
            }
        };
        let normal = self.transform_normal(normal);
        let (length, unit) = (normal.length(), normal.normalize());
        let turned = |dn: DVec3| {
            let dn = self.transform_normal(dn) * (self.side / length);
            (dn - unit * unit.dot(dn)).as_vec3()
        };
        SurfaceDerivatives {
            uv: self.uv(p),
            dp: dp.map(|d| self.object_from_form.transform_vector3(d).as_vec3()),
            dn: dn.map(turned),
        }
    }

    /// Transforms a normal to object space. Its length becomes the ratio of an area element in
    /// object space to the same element in the quadric's own space, divided by the determinant.
    fn transform_normal(&self, normal: DVec3) -> DVec3 {
        self.form_from_object.matrix3.transpose() * normal
    }

    /// Makes a surface point of a point in the quadric's own space and a unit normal in object
    /// space.
    fn place_point(&self, p: DVec3, normal: DVec3) -> SurfacePoint {
        let position = self.object_from_form.transform_point3(p).as_vec3();
        let normal = (normal * self.side).as_vec3();
        // The point is exact in f64, so its rounding to f32 and one more rounding are the only
        // errors.
        let error = position.abs() * gamma(3) + f32::MIN_POSITIVE;
        SurfacePoint { position, error, normal, shading_normal: normal }
    }

    /// Returns the sphere in object space, if the quadric is a whole, undistorted sphere.
    pub fn whole_sphere(&self) -> Option<Sphere> {
        let QuadricForm::Sphere { radius, z } = self.form else { return None };
        let [x, y, w] = self.object_from_form.matrix3.to_cols_array_2d().map(DVec3::from_array);
        let scale2 = x.length_squared();
        let same = |a: f64, b: f64| (a - b).abs() < 1e-6 * scale2;
        let similar = same(y.length_squared(), scale2)
            && same(w.length_squared(), scale2)
            && [x.dot(y), y.dot(w), w.dot(x)].into_iter().all(|dot| same(dot, 0.0));
        let whole = z == [-radius, radius] && self.phi_max >= TAU;
        (similar && whole).then(|| Sphere {
            centre: self.object_from_form.translation,
            radius: radius * scale2.sqrt(),
            side: self.side,
        })
    }

    /// Returns the unit normal of a disk, object space; `None` for curved quadrics.
    pub fn flat_normal(&self) -> Option<DVec3> {
        let flat = matches!(self.form, QuadricForm::Disk { .. });
        flat.then(|| (self.transform_normal(DVec3::Z) * self.side).normalize())
    }
}

/// Returns the unit vector from the z axis towards (x, y), whose squared length is given.
fn direction(x: f64, y: f64, r2: f64) -> DVec3 {
    if r2 > 0.0 { DVec3::new(x, y, 0.0) / r2.sqrt() } else { DVec3::X }
}

/// Returns the unit normal of a cone in the direction `away` from its axis.
fn cone_normal(away: DVec3, radius: f64, height: f64) -> DVec3 {
    (away * height.abs() + DVec3::Z * (radius * height.signum())).normalize()
}

/// Returns the angle about z, in [0, 2 pi).
fn phi(p: DVec3) -> f64 {
    let angle = p.y.atan2(p.x);
    if angle < 0.0 { angle + TAU } else { angle }
}

/// Returns the roots of a t^2 - 2 b t + c in ascending order, without cancellation, with b =
/// `half_b`; NaN if there are none. The caller computes `discriminant` = b^2 - a c as exactly as it
/// can.
fn quadratic(a: f64, half_b: f64, c: f64, discriminant: f64) -> [f64; 2] {
    let root = discriminant.sqrt();
    let q = if half_b < 0.0 { half_b - root } else { half_b + root };
    let (one, other) = (c / q, q / a);
    if one < other { [one, other] } else { [other, one] }
}
