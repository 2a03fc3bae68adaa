//! One motion between two transforms.

use glam::{DAffine3, DMat3, DQuat, DVec3};

use super::polar::polar;

/// Moves, turns and stretches at once.
///
/// By Rodrigues' formula a rotation by an angle a t is C + cos (a t) A + sin (a t) B, so at a
/// share t the whole transform is C0 + t C1 + cos (a t) (A0 + t A1) + sin (a t) (B0 + t B1),
/// every letter three rows and four columns. That form stays the same within another transform
/// and around one.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Turn {
    /// Radians from share 0 to share 1.
    pub(super) angle: f64,
    /// C, A and B; each the term without the share and the one with it.
    pub(super) terms: [[DAffine3; 2]; 3],
    /// Whether the stretch changes: if not, all that grows with the share is a translation.
    stretches: bool,
}

impl Turn {
    pub(super) fn between(start: &DAffine3, end: &DAffine3) -> Option<Self> {
        let (first, stretch) = polar(start.matrix3)?;
        let (last, stretched) = polar(end.matrix3)?;
        let (axis, angle) = shorter(first.inverse() * last);
        // Rodrigues: along the axis, across it, and around it.
        let along = DMat3::from_cols(axis * axis.x, axis * axis.y, axis * axis.z);
        let around =
            DMat3::from_cols(axis.cross(DVec3::X), axis.cross(DVec3::Y), axis.cross(DVec3::Z));
        let turns = [along, DMat3::IDENTITY - along, around];
        let stretches = [stretch, stretched - stretch];
        let first = DMat3::from_quat(first);
        let mut terms = turns.map(|turn| {
            stretches.map(|stretch| DAffine3 {
                matrix3: first * turn * stretch,
                translation: DVec3::ZERO,
            })
        });
        terms[0][0].translation = start.translation;
        terms[0][1].translation = end.translation - start.translation;
        let change = (stretched - stretch).to_cols_array().into_iter();
        let change = change.fold(0.0, |most: f64, v| most.max(v.abs()));
        let size = stretch.to_cols_array().into_iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        // Two decompositions of one shape differ by roundings.
        let stretches = change > 1e-13 * size;
        if !stretches {
            for term in &mut terms {
                term[1].matrix3 = DMat3::ZERO;
            }
        }
        Some(Self { angle, terms, stretches })
    }

    /// Within something that stands still.
    pub(super) fn within(&self, outer: &DAffine3) -> Self {
        let mut turn = self.clone();
        for term in turn.terms.as_flattened_mut() {
            term.matrix3 = outer.matrix3 * term.matrix3;
            term.translation = outer.matrix3 * term.translation;
        }
        turn.terms[0][0].translation += outer.translation;
        turn
    }

    /// Around something that stands still.
    pub(super) fn around(&self, inner: &DAffine3) -> Self {
        let mut turn = self.clone();
        for term in turn.terms.as_flattened_mut() {
            term.translation += term.matrix3 * inner.translation;
            term.matrix3 *= inner.matrix3;
        }
        turn
    }

    /// The transform at a share of the way.
    #[inline]
    pub(super) fn at(&self, share: f64) -> DAffine3 {
        let (sin, cos) = (self.angle * share).sin_cos();
        let [[c, c1], [a, a1], [b, b1]] = &self.terms;
        let mut sum = DAffine3 {
            matrix3: c.matrix3 + a.matrix3 * cos + b.matrix3 * sin,
            translation: c.translation
                + a.translation * cos
                + b.translation * sin
                + c1.translation * share,
        };
        if self.stretches {
            let grown = [c1, a1, b1].map(|term| term.matrix3);
            sum.matrix3 += (grown[0] + grown[1] * cos + grown[2] * sin) * share;
            sum.translation += (a1.translation * cos + b1.translation * sin) * share;
        }
        sum
    }
}

/// Axis and angle of a rotation, by no more than half a turn.
fn shorter(rotation: DQuat) -> (DVec3, f64) {
    let rotation = if rotation.w < 0.0 { -rotation } else { rotation };
    let sine = rotation.xyz();
    let angle = 2.0 * sine.length().atan2(rotation.w);
    (sine.try_normalize().unwrap_or(DVec3::Z), angle)
}
