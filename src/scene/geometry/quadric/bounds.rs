//! Boxes around transformed quadrics.

use glam::{DAffine3, DVec3};

use super::QuadricForm;

/// Returns the least box around a transformed quadric of a full turn: lowest and highest corner.
pub(super) fn transformed(form: &QuadricForm, matrix: &DAffine3) -> [DVec3; 2] {
    let (mut low, mut high) = (matrix.translation, matrix.translation);
    for axis in 0..3 {
        let row = matrix.matrix3.row(axis);
        low[axis] -= farthest(form, -row);
        high[axis] += farthest(form, row);
    }
    [low, high]
}

/// Returns the largest dot product of a vector and a point of a quadric.
fn farthest(form: &QuadricForm, v: DVec3) -> f64 {
    // On a circle of radius 1 about the z axis.
    let across = v.x.hypot(v.y);
    match *form {
        QuadricForm::Sphere { radius, z } => {
            let length = v.length();
            let pole = if length > 0.0 { radius * v.z / length } else { 0.0 };
            let z = pole.max(z[0]).min(z[1]);
            v.z * z + across * (radius * radius - z * z).max(0.0).sqrt()
        }
        QuadricForm::Cylinder { radius, z } => across * radius + (v.z * z[0]).max(v.z * z[1]),
        QuadricForm::Disk { radius, height, .. } => across * radius + v.z * height,
        QuadricForm::Cone { radius, height } => (across * radius).max(v.z * height),
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::Quadric;

    #[test]
    fn a_box_touches_its_quadric_on_all_sides() {
        let forms = [
            QuadricForm::Sphere { radius: 1.5, z: [-1.5, 1.5] },
            QuadricForm::Sphere { radius: 1.5, z: [-0.5, 1.2] },
            QuadricForm::Cylinder { radius: 0.5, z: [-1.0, 2.0] },
            QuadricForm::Disk { radius: 2.0, inner: 1.0, height: 0.7 },
            QuadricForm::Cone { radius: 0.5, height: 2.0 },
            QuadricForm::Cone { radius: 1.0, height: -0.5 },
        ];
        let mut place = DAffine3::from_rotation_x(0.9) * DAffine3::from_rotation_z(0.4);
        place = DAffine3::from_scale(DVec3::new(1.0, -2.0, 0.7)) * place;
        place.translation = DVec3::new(3.0, -1.0, 0.2);
        for (form, place) in
            forms.iter().flat_map(|form| [(form, DAffine3::IDENTITY), (form, place)])
        {
            let quadric = Quadric::new(*form, TAU, place, false).unwrap();
            let [low, high] = quadric.bounds();
            let (mut least, mut most) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
            for i in 0..400 {
                for j in 0..=400 {
                    // The ends of the second number are the rims, the poles and the apex.
                    let u = [i as f32 / 400.0, (j as f32 / 400.0).min(1.0 - f32::EPSILON)];
                    let p = quadric.sample(u).0.position.as_dvec3();
                    (least, most) = (least.min(p), most.max(p));
                }
            }
            let slack = 1e-5 * high.abs().max(low.abs()).max_element();
            assert!((low - slack).cmple(least).all(), "{form:?}: {low} {least}");
            assert!((high + slack).cmpge(most).all(), "{form:?}: {high} {most}");
            // The grid of samples comes this close to the extremes.
            let grid = 0.02 * (high - low).max_element();
            assert!((low + grid).cmpge(least).all(), "{form:?}: {low} {least}");
            assert!((high - grid).cmple(most).all(), "{form:?}: {high} {most}");
        }
    }
}
