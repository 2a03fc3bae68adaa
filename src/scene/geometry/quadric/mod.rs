//! Quadrics: spheres, cylinders, disks and cones, evaluated in f64 in their own space.

mod bounds;
mod intersect;
mod points;
mod sampling;

pub(crate) use intersect::QuadricSurface;
pub use sampling::DiskPacket;

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

    /// Returns the least box around it, apart from a limit of its angle: lowest and highest corner,
    /// object space.
    pub fn bounds(&self) -> [DVec3; 2] {
        bounds::transformed(&self.form, &self.object_from_form)
    }

    /// Returns the distance to the first intersection of a ray with 0 < t < `t_max`.
    pub fn intersect(&self, origin: DVec3, direction: DVec3, t_max: f64) -> Option<f64> {
        let [origin, direction] = [origin, direction].map(|v| v.to_array());
        let t = self.surface().intersect::<f64>(origin, direction, t_max);
        (!t.is_nan()).then_some(t)
    }

    /// Returns the surface point at a point of object space that is on the surface to rounding.
    pub fn point(&self, near: DVec3) -> SurfacePoint {
        self.points::<f32>(near.to_array()).into()
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
        Vec2::new((phi(p.x, p.y) / self.phi_max) as f32, v as f32)
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

/// Returns the angle of (x, y) about z, in [0, 2 pi).
fn phi(x: f64, y: f64) -> f64 {
    let angle = y.atan2(x);
    if angle < 0.0 { angle + TAU } else { angle }
}
