//! Conversions of matrices and boxes between f32 and f64.

use glam::{Affine3A, DAffine3, DMat3, DVec3, Vec3};

pub(super) fn to_f32(matrix: &DAffine3) -> Affine3A {
    Affine3A::from_cols_array(&matrix.to_cols_array().map(|v| v as f32))
}

pub(super) fn to_f64(matrix: &Affine3A) -> DAffine3 {
    DAffine3::from_cols_array(&matrix.to_cols_array().map(f64::from))
}

/// Returns a box in f32 around a box in f64.
pub(super) fn round_outward([low, high]: [DVec3; 2]) -> [Vec3; 2] {
    let outward = |v: DVec3, away: f64| {
        let slack = v.abs().max_element() * f64::from(f32::EPSILON) * away;
        (v + slack).as_vec3()
    };
    [outward(low, -1.0), outward(high, 1.0)]
}

/// Returns a box around a transformed box, with slack for rays that are transformed in f32.
pub(super) fn transform_box([low, high]: [DVec3; 2], matrix: &DAffine3) -> [Vec3; 2] {
    let (mut least, mut most) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for corner in 0..8 {
        let pick = |bit: usize, axis: usize| {
            if corner >> bit & 1 == 0 { low[axis] } else { high[axis] }
        };
        let p = matrix.transform_point3(DVec3::new(pick(0, 0), pick(1, 1), pick(2, 2)));
        (least, most) = (least.min(p), most.max(p));
    }
    round_outward([least, most])
}

/// Returns the rotation from a camera's space (x to the right, y up, +z forward) to the world, or
/// `None` if `up` is parallel to `forward`, which has length 1.
pub fn look_at_rotation(forward: DVec3, up: DVec3) -> Option<DMat3> {
    let right = up.cross(forward).try_normalize()?;
    Some(DMat3::from_cols(right, forward.cross(right), forward))
}
