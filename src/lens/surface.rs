//! Surfaces made ready for tracing in one direction.

use super::prescription::Prescription;
use crate::lanes::Real;

/// Which formula takes a ray to a surface and through it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A plane that only clips.
    Stop,
    /// A sphere or plane, met with T.N > 0 on the way to its vertex: s = F / (G + xi).
    Sphere,
    /// A sphere met from so far behind its vertex that G may be negative, where the other
    /// form cancels (a ball lens): s = (G - xi) / (c n^2).
    FarSphere,
}

/// One surface as a ray meets it: +z is the direction of travel, lengths in mm.
#[derive(Clone, Copy, Debug)]
pub struct Surface<T> {
    /// Which formula applies.
    pub kind: Kind,
    /// Distance from the vertex crossed before to this one.
    pub advance: T,
    /// Curvature, positive where the centre lies ahead.
    pub curvature: T,
    /// Curvature times the square of the index on the side where rays come from.
    pub curvature_n2: T,
    /// n'^2 - n^2, what refraction adds to the square of the normal component.
    pub n2_step: T,
    /// Square of half the clear diameter.
    pub aperture2: T,
}

/// From which side rays come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum From {
    /// From a film at this distance, mm, behind the rear vertex: rays go out to the scene.
    Film(f64),
    /// From a plane at this distance, mm, before the front vertex: rays go to the film.
    Scene(f64),
}

/// The surfaces of a lens in the order in which rays from that side meet them.
pub fn sequence<R: Real>(lens: &Prescription, from: From) -> Vec<Surface<R::Scalar>> {
    let rows = &lens.rows;
    let surface = |i: usize, advance: f64, sign: f64, n: f64, n_after: f64| {
        let row = &rows[i];
        let curvature = sign * row.curvature();
        // A start more than half a radius before a surface that is concave to the ray (its
        // centre behind the vertex) can lie beyond the centre: there G changes sign.
        let far = curvature * advance < -0.5;
        Surface {
            kind: match row.stop {
                true => Kind::Stop,
                false if far => Kind::FarSphere,
                false => Kind::Sphere,
            },
            advance: R::scalar(advance),
            curvature: R::scalar(curvature),
            curvature_n2: R::scalar(curvature * n * n),
            n2_step: R::scalar(n_after * n_after - n * n),
            aperture2: R::scalar(row.diameter * row.diameter / 4.0),
        }
    };
    match from {
        From::Film(distance) => (0..rows.len())
            .rev()
            .map(|i| {
                let advance = if i + 1 == rows.len() { distance } else { rows[i].thickness };
                surface(i, advance, -1.0, rows[i].index, lens.index_before(i))
            })
            .collect(),
        From::Scene(distance) => (0..rows.len())
            .map(|i| {
                let advance = if i == 0 { distance } else { rows[i - 1].thickness };
                surface(i, advance, 1.0, lens.index_before(i), rows[i].index)
            })
            .collect(),
    }
}
