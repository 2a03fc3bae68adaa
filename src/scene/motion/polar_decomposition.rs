//! Polar decomposition of a matrix into a rotation and a stretch.

use glam::{DMat3, DQuat};

/// More iterations than any usefully invertible matrix takes: far from the rotation each halves the
/// distance, near it each squares it.
const MAX_ITERATIONS: usize = 200;

/// Returns the rotation q and the stretch s of m = q s, by averaging a matrix with its inverse
/// transpose (Higham 1986, "Computing the polar decomposition"). The stretch takes a reflection.
/// `None` if the matrix is singular.
pub(super) fn polar_decomposition(m: DMat3) -> Option<(DQuat, DMat3)> {
    let mut rotation = m;
    for _ in 0..MAX_ITERATIONS {
        let other = rotation.inverse().transpose();
        if !other.is_finite() {
            return None;
        }
        let next = (rotation + other) * 0.5;
        let step = max_abs(next - rotation);
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

fn max_abs(m: DMat3) -> f64 {
    m.to_cols_array().iter().fold(0.0, |most: f64, v| most.max(v.abs()))
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn a_matrix_is_a_rotation_times_a_symmetric_stretch() {
        let turn = DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 2.0);
        let shear =
            DMat3::from_cols(DVec3::new(2.0, 0.3, -0.1), DVec3::Y, DVec3::new(0.5, 0.0, 1e-3));
        for m in [DMat3::from_quat(turn) * shear, -shear, DMat3::from_diagonal(DVec3::splat(1e9))] {
            let (rotation, stretch) = polar_decomposition(m).unwrap();
            let size = max_abs(m);
            assert!(max_abs(DMat3::from_quat(rotation) * stretch - m) < 1e-14 * size);
            assert!(max_abs(stretch - stretch.transpose()) < 1e-14 * size, "{stretch}");
        }
    }
}
