//! Rotations and translations that optical-design programs state.

use glam::{DAffine3, DMat3, DVec3};

/// Returns a decentre followed by right-handed rotations about x, the tilted y and the tilted z
/// (degrees): position and directions of the new axes in the old ones.
pub(crate) fn decentre_then_tilt(decentre: [f64; 3], tilt: [f64; 3]) -> DAffine3 {
    let [x, y, z] = tilt.map(f64::to_radians);
    let rotation =
        DMat3::from_rotation_x(x) * DMat3::from_rotation_y(y) * DMat3::from_rotation_z(z);
    DAffine3::from_mat3_translation(rotation, DVec3::from_array(decentre))
}

/// Returns right-handed rotations about z, the tilted y and the tilted x (degrees), followed by a
/// decentre along the tilted axes. With all signs changed it undoes [`decentre_then_tilt`].
pub(crate) fn tilt_then_decentre(decentre: [f64; 3], tilt: [f64; 3]) -> DAffine3 {
    decentre_then_tilt(decentre.map(|v| -v), tilt.map(|v| -v)).inverse()
}

/// Returns the angles about x and the tilted y (degrees) of the plane z = x tan_x + y tan_y.
pub(crate) fn tangents_to_angles([tan_x, tan_y]: [f64; 2]) -> [f64; 2] {
    let about_x = tan_y.atan();
    [about_x, (-tan_x * about_x.cos()).atan()].map(f64::to_degrees)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_second_order_undoes_the_first_with_signs_changed() {
        let (decentre, tilt) = ([1.0, -2.0, 3.0], [10.0, 20.0, -30.0]);
        let back = tilt_then_decentre(decentre.map(|v| -v), tilt.map(|v| -v));
        let both = decentre_then_tilt(decentre, tilt) * back;
        assert!(both.abs_diff_eq(DAffine3::IDENTITY, 1e-14));
    }

    #[test]
    fn tangents_give_the_angles_of_their_plane() {
        for [tan_x, tan_y] in [[0.0, 0.5], [0.3, 0.0], [0.3, -0.7], [-2.0, 1.0]] {
            let [x, y] = tangents_to_angles([tan_x, tan_y]);
            let plane = decentre_then_tilt([0.0; 3], [x, y, 0.0]);
            for side in [DVec3::X, DVec3::Y] {
                let point = plane.transform_vector3(side);
                assert!((point.z - tan_x * point.x - tan_y * point.y).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn a_tilt_about_x_moves_the_top_towards_the_film() {
        let top = decentre_then_tilt([0.0; 3], [30.0, 0.0, 0.0]).transform_point3(DVec3::Y);
        assert!(top.z > 0.0, "{top}");
    }
}
