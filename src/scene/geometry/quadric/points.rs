//! Surface points of a quadric, one or eight at a time, in f64.

use glam::DAffine3;

use super::{Quadric, QuadricForm};
use crate::geometry::{SurfacePacket, gamma};
use petzval_base::lanes::vector::{abs, add, dot, scale, splat, transform};
use petzval_base::lanes::{Real, narrow};

/// Transforms points.
#[inline(always)]
fn transform_points<D: Real<Scalar = f64>>(matrix: &DAffine3, points: [D; 3]) -> [D; 3] {
    let columns = matrix.matrix3.to_cols_array_2d().map(splat);
    add(transform(&columns, points), splat(matrix.translation.to_array()))
}

/// Returns unit vectors; lanes without a length are NaN.
#[inline(always)]
fn unit<D: Real<Scalar = f64>>(v: [D; 3]) -> [D; 3] {
    scale(v, D::splat(1.0) / dot(v, v).sqrt())
}

impl Quadric {
    /// Returns the surface points at points of object space that are on the surface to rounding.
    #[inline(always)]
    pub fn points<R: Real<Scalar = f32>>(&self, near: [R::Double; 3]) -> SurfacePacket<R> {
        let p = transform_points(&self.form_from_object, near);
        let (p, normal) = self.project(p);
        let position = transform_points(&self.object_from_form, p);
        let columns = self.form_from_object.matrix3.transpose().to_cols_array_2d().map(splat);
        let normal = unit(transform(&columns, normal));
        let side = R::Double::splat(self.side);
        let (mut position32, mut normal32) = ([R::splat(0.0); 3], [R::splat(0.0); 3]);
        for axis in 0..3 {
            position32[axis] = narrow::<R>(position[axis]);
            normal32[axis] = narrow::<R>(normal[axis] * side);
        }
        // The points are exact in f64, so their rounding to f32 and one more rounding are the only
        // errors.
        let (relative, least) = (R::splat(gamma(3)), R::splat(f32::MIN_POSITIVE));
        let size = abs(position32);
        let error = [
            size[0].mul_add(relative, least),
            size[1].mul_add(relative, least),
            size[2].mul_add(relative, least),
        ];
        SurfacePacket { position: position32, error, normal: normal32, shading_normal: normal32 }
    }

    /// Returns the points of the surface next to points, and vectors along its normals there, in
    /// the quadric's own space.
    #[inline(always)]
    fn project<D: Real<Scalar = f64>>(&self, p: [D; 3]) -> ([D; 3], [D; 3]) {
        let (zero, one) = (D::splat(0.0), D::splat(1.0));
        let [x, y, z] = p;
        // The unit vector from the z axis; on the axis itself, that along x.
        let r2 = x * x + y * y;
        let inverse = one / r2.sqrt();
        let off_axis = zero.lt(r2);
        let (ax, ay) =
            (D::select(off_axis, x * inverse, one), D::select(off_axis, y * inverse, zero));
        match self.form {
            QuadricForm::Sphere { radius, .. } => {
                let normal = unit(p);
                (scale(normal, D::splat(radius)), normal)
            }
            QuadricForm::Cylinder { radius, .. } => {
                let radius = D::splat(radius);
                ([ax * radius, ay * radius, z], [ax, ay, zero])
            }
            QuadricForm::Disk { height, .. } => ([x, y, D::splat(height)], [zero, zero, one]),
            QuadricForm::Cone { radius, height } => {
                let r = D::splat(radius) * (one - z / D::splat(height)).max(zero);
                let steep = D::splat(height.abs());
                let normal = [ax * steep, ay * steep, D::splat(radius * height.signum())];
                ([ax * r, ay * r, z], normal)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec3};

    use super::*;
    use petzval_base::lanes::f32x8;

    #[test]
    fn eight_points_equal_those_of_single_lanes() {
        let matrix = DAffine3::from_scale_rotation_translation(
            DVec3::new(1.0, 2.0, 0.5),
            glam::DQuat::from_rotation_x(0.7),
            DVec3::new(3.0, -1.0, 2.0),
        );
        let forms = [
            QuadricForm::Sphere { radius: 1.5, z: [-1.5, 1.5] },
            QuadricForm::Cylinder { radius: 0.5, z: [-1.0, 2.0] },
            QuadricForm::Disk { radius: 2.0, inner: 0.0, height: 0.3 },
            QuadricForm::Cone { radius: 0.5, height: 2.0 },
        ];
        for form in forms {
            let quadric = Quadric::new(form, std::f64::consts::TAU, matrix, true).expect("a form");
            // The last lane is on the axis.
            let near = |lane: usize| {
                let angle = lane as f64;
                let own = DVec3::new(angle.sin(), angle.cos(), 0.2 * angle - 0.5);
                matrix.transform_point3(if lane == 7 { DVec3::Z } else { own })
            };
            let column = |axis: usize| {
                petzval_base::lanes::f64x8::new(std::array::from_fn(|lane| near(lane)[axis]))
            };
            let points = quadric.points::<f32x8>([column(0), column(1), column(2)]);
            for lane in 0..8 {
                let one = quadric.point(near(lane));
                let lane_of = |v: [f32x8; 3]| Vec3::from(v.map(|v| v.to_array()[lane]));
                assert_eq!(lane_of(points.position), one.position, "{form:?} {lane}");
                assert_eq!(lane_of(points.normal), one.normal, "{form:?} {lane}");
                assert_eq!(lane_of(points.error), one.error, "{form:?} {lane}");
                assert!((one.normal.length() - 1.0).abs() < 1e-6, "{form:?} {lane}");
            }
        }
    }
}
