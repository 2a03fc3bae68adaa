//! Lookup rows of the pupil table: one row per sample.

use super::fan::{Fan, TRIANGLES, Triangle};
use petzval_base::rays::Column;

/// One row of the pupil table: the lanes from which a sample computes its pupil point `centre +
/// sqrt(v) (corner + t side)`. The lanes are u and v of the centre, of the corner and of the side,
/// mm; the density of samples that are not drawn from the fan, mm^-2, or 0 if the film point is
/// dark; and 1 if the sample is not drawn from a triangle.
pub(crate) type PupilTarget = [f32; 8];

/// Lane of the density of samples that are not drawn from the fan.
pub(super) const DENSITY: usize = 6;

/// The target of an unused lane.
pub(crate) const UNUSED_LANE: PupilTarget = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0];

/// The targets of a wave.
pub(crate) type PupilTargets = Column<PupilTarget>;

/// The triangles of fans as lookup rows, without the density.
#[derive(Clone, Debug)]
pub(crate) struct TriangleRows(pub(crate) Vec<[PupilTarget; TRIANGLES]>);

impl TriangleRows {
    pub(crate) fn of(fans: &[Fan]) -> Self {
        let row = |fan: &Fan, k: usize| {
            let Triangle { centre: [u, v], corners: [[au, av], [bu, bv]] } = fan.triangle(k);
            [u, v, au, av, bu - au, bv - av, 0.0, 0.0]
        };
        Self(fans.iter().map(|fan| std::array::from_fn(|k| row(fan, k))).collect())
    }
}

/// The triangles of a line of fans: for each a row and its difference to the row of the next fan,
/// adjacent because they are looked up together.
#[derive(Clone, Debug)]
pub(crate) struct TriangleSteps(pub(crate) Vec<[PupilTarget; 2]>);

impl TriangleSteps {
    pub(crate) fn of(fans: &[Fan]) -> Self {
        let TriangleRows(rows) = TriangleRows::of(fans);
        let step =
            |near: &PupilTarget, far: &PupilTarget| std::array::from_fn(|k| far[k] - near[k]);
        let pairs = rows.as_flattened().iter().zip(rows.as_flattened().iter().skip(TRIANGLES));
        Self(pairs.map(|(near, far)| [*near, step(near, far)]).collect())
    }

    /// Sets the density between each fan and the next.
    pub(super) fn set_density(&mut self, density: impl Fn(usize) -> f32) {
        for (i, [near, step]) in self.0.iter_mut().enumerate() {
            near[DENSITY] = density(i / TRIANGLES);
            step[DENSITY] = 0.0;
        }
    }
}

/// Returns the target of a sample that is not drawn from a triangle.
pub(crate) fn point_target([u, v]: [f32; 2], base: f32) -> PupilTarget {
    [u, v, 0.0, 0.0, 0.0, 0.0, base, 1.0]
}
