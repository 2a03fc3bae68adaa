//! Interpolation between two transforms.

use glam::{DAffine3, DMat3, DQuat, DVec3};

use super::polar_decomposition::polar_decomposition;

/// Interpolates translation, rotation and stretch at once.
///
/// By Rodrigues' formula a rotation by an angle a t is C + cos (a t) A + sin (a t) B, so the whole
/// transform at time t is C0 + t C1 + cos (a t) (A0 + t A1) + sin (a t) (B0 + t B1), each term a
/// matrix of three rows and four columns. Multiplication by a constant transform, from either side,
/// keeps this form.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Interpolation {
    /// Rotation from time 0 to time 1, radians.
    pub(super) angle: f64,
    /// C, A and B: for each the constant term and the one that is multiplied by time.
    pub(super) terms: [[DAffine3; 2]; 3],
    /// Whether the stretch changes; otherwise only the translation grows linearly with time.
    stretches: bool,
}

impl Interpolation {
    /// Returns the interpolation between two transforms; `None` if one of them is singular.
    pub(super) fn between(start: &DAffine3, end: &DAffine3) -> Option<Self> {
        let (first, stretch) = polar_decomposition(start.matrix3)?;
        let (last, stretched) = polar_decomposition(end.matrix3)?;
        let (axis, angle) = axis_and_angle(first.inverse() * last);
        // Rodrigues' three parts: along the axis, across it, and around it.
        let along = DMat3::from_cols(axis * axis.x, axis * axis.y, axis * axis.z);
        let around =
            DMat3::from_cols(axis.cross(DVec3::X), axis.cross(DVec3::Y), axis.cross(DVec3::Z));
        let rotations = [along, DMat3::IDENTITY - along, around];
        let stretches = [stretch, stretched - stretch];
        let first = DMat3::from_quat(first);
        let mut terms = rotations.map(|rotation| {
            stretches.map(|stretch| DAffine3 {
                matrix3: first * rotation * stretch,
                translation: DVec3::ZERO,
            })
        });
        terms[0][0].translation = start.translation;
        terms[0][1].translation = end.translation - start.translation;
        let change = (stretched - stretch).to_cols_array().into_iter();
        let change = change.fold(0.0, |most: f64, v| most.max(v.abs()));
        let size = stretch.to_cols_array().into_iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        // Decompositions of the same stretch differ by rounding.
        let stretches = change > 1e-13 * size;
        if !stretches {
            for term in &mut terms {
                term[1].matrix3 = DMat3::ZERO;
            }
        }
        Some(Self { angle, terms, stretches })
    }

    /// Returns `outer * self`.
    pub(super) fn precompose(&self, outer: &DAffine3) -> Self {
        let mut result = self.clone();
        for term in result.terms.as_flattened_mut() {
            term.matrix3 = outer.matrix3 * term.matrix3;
            term.translation = outer.matrix3 * term.translation;
        }
        result.terms[0][0].translation += outer.translation;
        result
    }

    /// Returns `self * inner`.
    pub(super) fn postcompose(&self, inner: &DAffine3) -> Self {
        let mut result = self.clone();
        for term in result.terms.as_flattened_mut() {
            term.translation += term.matrix3 * inner.translation;
            term.matrix3 *= inner.matrix3;
        }
        result
    }

    /// Returns the transform at a time.
    #[inline]
    pub(super) fn at(&self, time: f64) -> DAffine3 {
        let (sin, cos) = (self.angle * time).sin_cos();
        let [[c, c1], [a, a1], [b, b1]] = &self.terms;
        let mut sum = DAffine3 {
            matrix3: c.matrix3 + a.matrix3 * cos + b.matrix3 * sin,
            translation: c.translation
                + a.translation * cos
                + b.translation * sin
                + c1.translation * time,
        };
        if self.stretches {
            let grown = [c1, a1, b1].map(|term| term.matrix3);
            sum.matrix3 += (grown[0] + grown[1] * cos + grown[2] * sin) * time;
            sum.translation += (a1.translation * cos + b1.translation * sin) * time;
        }
        sum
    }
}

/// Returns axis and angle of a rotation; the angle is at most pi.
fn axis_and_angle(rotation: DQuat) -> (DVec3, f64) {
    let rotation = if rotation.w < 0.0 { -rotation } else { rotation };
    let sine = rotation.xyz();
    let angle = 2.0 * sine.length().atan2(rotation.w);
    (sine.try_normalize().unwrap_or(DVec3::Z), angle)
}
