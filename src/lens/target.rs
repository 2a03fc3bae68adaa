//! Where single samples aim, as rows that are looked up in one piece.

use super::fan::{Fan, TRIANGLES, Triangle};
use crate::rays::Column;

/// How a sample finds its point of the pupil, `centre + sqrt(v) (corner + t side)`: u and v of
/// the centre, of the corner and of the side, mm; the density of the samples that come from
/// elsewhere, mm^-2, or 0 where the film sees no light; and 1 for a sample that is drawn from no
/// triangle. One row for a sample, because it is looked up in one piece.
pub(super) type Target = [f32; 8];

/// The target of a lane that is not in use.
pub(super) const LIT: Target = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0];

/// The targets of a wave.
pub(super) type Targets = Column<Target>;

/// The triangles of the fans as rows to look up, without the density.
#[derive(Clone, Debug)]
pub(super) struct Rows(pub(super) Vec<[Target; TRIANGLES]>);

impl Rows {
    pub(super) fn of(fans: &[Fan]) -> Self {
        let row = |fan: &Fan, k: usize| {
            let Triangle { centre: [u, v], corners: [[au, av], [bu, bv]] } = fan.triangle(k);
            [u, v, au, av, bu - au, bv - av, 0.0, 0.0]
        };
        Self(fans.iter().map(|fan| std::array::from_fn(|k| row(fan, k))).collect())
    }
}

/// The triangles of a line of fans: a row, and what the next fan's adds to it, side by side because
/// they are looked up together.
#[derive(Clone, Debug)]
pub(super) struct Steps(pub(super) Vec<[Target; 2]>);

impl Steps {
    pub(super) fn of(fans: &[Fan]) -> Self {
        let Rows(rows) = Rows::of(fans);
        let step = |near: &Target, far: &Target| std::array::from_fn(|k| far[k] - near[k]);
        let pairs = rows.as_flattened().iter().zip(rows.as_flattened().iter().skip(TRIANGLES));
        Self(pairs.map(|(near, far)| [*near, step(near, far)]).collect())
    }
}

/// A sample that is drawn from no triangle.
pub(super) fn lone([u, v]: [f32; 2], base: f32) -> Target {
    [u, v, 0.0, 0.0, 0.0, 0.0, base, 1.0]
}
