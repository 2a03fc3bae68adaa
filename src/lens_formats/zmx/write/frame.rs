//! Coordinate breaks between the surfaces of a lens.

use glam::{DAffine3, DMat3, DVec3};

use petzval_lens::Prescription;

/// Largest entry of a transform that counts as rounding (mm; sine of an angle).
const NONE: f64 = 1e-13;

/// Longest space that stands for a shift along the axis at a small tilt (mm).
const LONGEST: f64 = 1e5;

/// A coordinate break and the spaces around it: a shift along the old axis, decentres, tilts about
/// x, the tilted y and the tilted z, and a shift along the new axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct AxisChange {
    /// Space before the break (mm).
    pub before: f64,
    /// Decentres along x and y (mm).
    pub decentre: [f64; 2],
    /// Tilts (degrees).
    pub tilt: [f64; 3],
    /// Space behind the break (mm).
    pub behind: f64,
}

/// Returns the changes of the axis before each row and before the film, for a film at a signed
/// distance behind the rear vertex (mm).
pub(super) fn axis_changes(lens: &Prescription, film: f64) -> Vec<Option<AxisChange>> {
    let count = lens.rows.len();
    let along = |z: f64| DAffine3::from_translation(DVec3::new(0.0, 0.0, z));
    let gap = |i: usize| match i {
        0 => 0.0,
        i if i == count => film,
        i => lens.rows[i - 1].thickness,
    };
    let posed =
        !lens.tilt_decenters.is_empty() || lens.rows.iter().any(|row| !row.pose.is_aligned());
    let mut frames = vec![DAffine3::IDENTITY];
    if posed {
        frames.extend(lens.surface_transforms());
        frames.push(lens.film_axis() * along(film));
    }
    (0..=count)
        .map(|i| {
            let transform = match posed {
                true => along(-gap(i)) * frames[i].inverse() * frames[i + 1],
                false => {
                    let here = lens.breaks.iter().filter(|axis| axis.row == i);
                    here.fold(DAffine3::IDENTITY, |all, axis| all * axis.transform)
                }
            };
            let still = transform.abs_diff_eq(DAffine3::IDENTITY, NONE);
            (!still).then(|| AxisChange::new(transform, gap(i)))
        })
        .collect()
}

impl AxisChange {
    /// Writes a transform at the end of a gap as spaces, decentres and tilts.
    ///
    /// With the rotation R and the translation t, `before` + `behind` R z = gap z + t; the sum of
    /// both spaces is the gap wherever the axes differ.
    fn new(transform: DAffine3, gap: f64) -> Self {
        let (rotation, shift) = (transform.matrix3, transform.translation);
        let axis = rotation.z_axis;
        let lost = axis.z - 1.0;
        let mut behind = if shift.z.abs() <= NONE { 0.0 } else { shift.z / lost };
        let mut before = gap - behind;
        if behind.is_nan() || behind.abs() > LONGEST {
            (before, behind) = (gap + shift.z, 0.0);
        }
        let decentre = [shift.x - behind * axis.x, shift.y - behind * axis.y];
        Self { before, decentre, tilt: angles(rotation), behind }
    }
}

/// Returns the angles (degrees) of Rx(a) Ry(b) Rz(c).
fn angles(rotation: DMat3) -> [f64; 3] {
    let [x, y, z] = [rotation.x_axis, rotation.y_axis, rotation.z_axis];
    let level = x.x.hypot(y.x);
    let angles = match level > 1e-9 {
        true => [(-z.y).atan2(z.z), z.x.atan2(level), (-y.x).atan2(x.x)],
        // Both other rotations are about one axis.
        false => [y.z.atan2(y.y), z.x.atan2(level), 0.0],
    };
    angles.map(|angle| angle.to_degrees() + 0.0)
}

#[cfg(test)]
mod tests {
    use super::super::super::super::axis::decentre_then_tilt;
    use super::*;

    #[test]
    fn a_transform_is_met_by_spaces_decentres_and_tilts() {
        let along = |z: f64| DAffine3::from_translation(DVec3::new(0.0, 0.0, z));
        for tilt in [[45.0, 0.0, 0.0], [10.0, 20.0, -30.0], [0.0, 90.0, 0.0], [170.0, 3.0, 80.0]] {
            for shift in [[0.0, 0.0, 0.0], [1.0, -2.0, 0.0], [0.5, 3.0, -4.0]] {
                let expected = decentre_then_tilt(shift, tilt);
                let axis = AxisChange::new(expected, 7.0);
                let [x, y] = axis.decentre;
                let found = along(axis.before - 7.0)
                    * decentre_then_tilt([x, y, 0.0], axis.tilt)
                    * along(axis.behind);
                assert!(found.abs_diff_eq(expected, 1e-12), "{tilt:?} {shift:?}: {axis:?}");
                assert!((axis.before + axis.behind - 7.0).abs() < 1e-12, "{axis:?}");
            }
        }
        let shift = AxisChange::new(along(2.0), 7.0);
        assert_eq!((shift.before, shift.behind), (9.0, 0.0));
    }
}
