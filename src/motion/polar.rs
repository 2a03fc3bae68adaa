//! The polar decomposition of a matrix: a rotation and what is left.

use glam::{DMat3, DQuat};

/// More steps than any matrix takes whose inverse is of any use: far from the rotation each
/// halves the distance, near it each squares it.
const MOST_STEPS: usize = 200;

/// The rotation q and the stretch s of m = q s, by the average of a matrix and its inverse
/// transpose (Higham 1986, "Computing the polar decomposition"). Of a matrix that mirrors the
/// stretch does. `None` where the matrix flattens space.
pub(super) fn polar(m: DMat3) -> Option<(DQuat, DMat3)> {
    let mut rotation = m;
    for _ in 0..MOST_STEPS {
        let other = rotation.inverse().transpose();
        if !other.is_finite() {
            return None;
        }
        let next = (rotation + other) * 0.5;
        let step = largest(next - rotation);
        rotation = next;
        if step <= 4.0 * f64::EPSILON {
            break;
        }
    }
    if rotation.determinant() < 0.0 {
        rotation = -rotation;
    }
    rotation.is_finite().then(|| {
        let turn = DQuat::from_mat3(&rotation).normalize();
        (turn, DMat3::from_quat(turn).transpose() * m)
    })
}

fn largest(m: DMat3) -> f64 {
    m.to_cols_array().iter().fold(0.0, |most: f64, v| most.max(v.abs()))
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn a_matrix_is_its_rotation_after_its_symmetric_stretch() {
        let turn = DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 2.0);
        let shear =
            DMat3::from_cols(DVec3::new(2.0, 0.3, -0.1), DVec3::Y, DVec3::new(0.5, 0.0, 1e-3));
        for m in [DMat3::from_quat(turn) * shear, -shear, DMat3::from_diagonal(DVec3::splat(1e9))] {
            let (rotation, stretch) = polar(m).unwrap();
            let size = largest(m);
            assert!(largest(DMat3::from_quat(rotation) * stretch - m) < 1e-14 * size);
            assert!(largest(stretch - stretch.transpose()) < 1e-14 * size, "{stretch}");
        }
    }
}
