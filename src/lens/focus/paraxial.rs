//! Gaussian optics: the paraxial properties of a lens.
//!
//! A ray is (y, n u): height and index times slope. Light travels from the scene to the film, and a
//! lens is the product of its refractions and transfers, of determinant 1 (Born & Wolf, "Principles
//! of Optics", 4.4). Tilt and decentre of elements are ignored.

use std::ops::Range;

use crate::prescription::{Prescription, Row, TransverseAxis};

/// A ray transfer matrix: y' = a y + b nu, nu' = c y + d nu. Lengths in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayTransferMatrix {
    /// y from y.
    pub a: f64,
    /// y from nu.
    pub b: f64,
    /// nu from y.
    pub c: f64,
    /// nu from nu.
    pub d: f64,
}

impl RayTransferMatrix {
    /// No surface and no gap.
    pub const IDENTITY: Self = Self { a: 1.0, b: 0.0, c: 0.0, d: 1.0 };

    pub(crate) fn refract(self, curvature: f64, n: f64, n_after: f64) -> Self {
        let power = (n_after - n) * curvature;
        Self { c: self.c - power * self.a, d: self.d - power * self.b, ..self }
    }

    /// Returns this matrix followed by row `i` of a lens, for rays in the plane of an axis.
    pub(crate) fn through_row(self, lens: &Prescription, i: usize, plane: TransverseAxis) -> Self {
        self.through(&lens.rows[i], lens.signed_indices(i), plane)
    }

    /// Returns this matrix followed by a row between media of these indices, which are negative where
    /// light travels along -z, for rays in the plane of an axis.
    pub fn through(self, row: &Row, [n, n_after]: [f64; 2], plane: TransverseAxis) -> Self {
        match row.ideal {
            Some(ideal) => self.then(ideal[plane as usize]),
            None => self.refract(row.curvatures()[plane as usize], n, n_after),
        }
    }

    /// Returns this matrix followed by some rows, each with the transfer to the next.
    pub(crate) fn through_rows(
        self,
        lens: &Prescription,
        rows: Range<usize>,
        plane: TransverseAxis,
    ) -> Self {
        // The direction is followed from row to row: a count of the mirrors before each would make
        // the time quadratic.
        let mut travel = lens.travel_before(rows.start);
        rows.fold(self, |m, i| {
            let (row, [before, behind]) = (&lens.rows[i], lens.indices(i));
            let n = travel * before;
            travel = if row.mirror { -travel } else { travel };
            let n_after = travel * behind;
            m.through(row, [n, n_after], plane).transfer(row.thickness, n_after)
        })
    }

    /// Returns this matrix followed by another.
    pub(crate) fn then(self, next: Self) -> Self {
        Self {
            a: next.a * self.a + next.b * self.c,
            b: next.a * self.b + next.b * self.d,
            c: next.c * self.a + next.d * self.c,
            d: next.c * self.b + next.d * self.d,
        }
    }

    pub(crate) fn transfer(self, distance: f64, n: f64) -> Self {
        let reduced = distance / n;
        Self { a: self.a + reduced * self.c, b: self.b + reduced * self.d, ..self }
    }
}

/// A pupil: its position on the axis and its diameter, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pupil {
    /// Distance towards the film: from the front vertex for the entrance pupil, from the rear
    /// vertex for the exit pupil; infinite if the lens is telecentric.
    pub position: f64,
    /// Diameter.
    pub diameter: f64,
}

/// First-order properties of a lens. Lengths in mm.
#[derive(Clone, Copy, Debug)]
pub struct Paraxial {
    /// The matrix from the front vertex to the rear vertex.
    pub whole: RayTransferMatrix,
    /// Refractive index of the medium before the film.
    pub film_index: f64,
    /// Distance from the front vertex to the rear vertex.
    pub length: f64,
    /// Direction of travel behind the lens: -1 after an odd number of mirrors, otherwise 1.
    pub travel: f64,
    /// Effective focal length: the inverse of the power, whatever medium the film stands in. A distant
    /// object of angular size w has an image of f tan w.
    pub focal_length: f64,
    /// Distance from the rear vertex to the rear focal point.
    pub back_focal_distance: f64,
    /// The image of the stop as seen from the scene.
    pub entrance_pupil: Pupil,
    /// The image of the stop as seen from the film.
    pub exit_pupil: Pupil,
}

/// Why a lens cannot be focused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FocusError {
    /// The best focus of real rays is not behind the lens.
    #[error(
        "real rays are sharpest {:.4} mm {} the rear vertex, where no film can stand; if the last \
         surface of the file is the film, leave it out",
        at.abs(),
        if *at > 0.0 { "behind" } else { "before" }
    )]
    NotBehindLens {
        /// Position of the best focus behind the rear vertex, mm.
        at: f64,
    },
    /// No ray comes through.
    #[error(
        "no ray from a point on the axis comes through the lens: it ends at a rim or by total \
         reflection; check diameters and the signs of radii"
    )]
    NoRays,
    /// The focus distance is below the nearest of the lens; both in mm from the film plane.
    #[error(
        "the lens cannot focus at {asked:.4} mm from the film; the nearest it can is \
         {nearest:.4} mm"
    )]
    TooNear {
        /// The requested distance.
        asked: f64,
        /// The nearest distance that has a film position.
        nearest: f64,
    },
    /// The lens forms no real image.
    #[error(
        "the lens forms no real image behind it ({}); if the last surface of the file is the film, \
         leave it out",
        power(*focal_length, *back_focal_distance)
    )]
    NoImage {
        /// Focal length, mm.
        focal_length: f64,
        /// Rear vertex to the rear focal point, mm.
        back_focal_distance: f64,
    },
}

/// Describes the power of a lens for an error message.
fn power(focal_length: f64, back_focal_distance: f64) -> String {
    match focal_length.abs() < Paraxial::AFOCAL && back_focal_distance.is_finite() {
        true => format!(
            "focal length {focal_length:.4} mm, back focal distance {back_focal_distance:.4} mm"
        ),
        false => "it is afocal".to_owned(),
    }
}

impl Paraxial {
    /// Computes the properties of a lens, in the plane of x if it is not round.
    pub fn new(lens: &Prescription) -> Self {
        Self::in_plane(lens, TransverseAxis::X)
    }

    /// Computes the properties of a lens for rays in the plane of one axis.
    pub fn in_plane(lens: &Prescription, plane: TransverseAxis) -> Self {
        let stop = lens.stop();
        let part = |rows| RayTransferMatrix::IDENTITY.through_rows(lens, rows, plane);
        let last = lens.rows.len() - 1;
        let to_rear_vertex = |m: RayTransferMatrix| m.through_row(lens, last, plane);
        let whole = to_rear_vertex(part(0..last));
        let front = part(0..stop);
        let behind = if stop == last {
            RayTransferMatrix::IDENTITY
        } else {
            to_rear_vertex(part(stop..last))
        };
        let film_index = lens.rear().index;
        let opening = lens.rows[stop].diameter;
        Self {
            whole,
            film_index,
            length: lens.length(),
            travel: lens.travel_before(lens.rows.len()),
            focal_length: -1.0 / whole.c,
            back_focal_distance: -whole.a * film_index / whole.c,
            entrance_pupil: Pupil {
                position: front.b / front.a,
                diameter: (opening / front.a).abs(),
            },
            exit_pupil: Pupil {
                position: -behind.b * film_index / behind.d,
                diameter: (opening / behind.d).abs(),
            },
        }
    }

    /// Focal length from which a lens counts as afocal, mm: a millionth of the power of the weakest
    /// lens in use.
    pub const AFOCAL: f64 = 1e9;

    /// Returns whether the lens is afocal.
    pub fn is_afocal(&self) -> bool {
        self.focal_length.is_nan() || self.focal_length.abs() >= Self::AFOCAL
    }

    /// Returns the distance of the rear focal point from the rear principal plane (mm): the focal
    /// length times the index of the medium before the film.
    pub fn rear_focal_length(&self) -> f64 {
        self.focal_length * self.film_index
    }

    /// Returns the focal length over the diameter of the entrance pupil: 1 / (2 NA) of a distant point
    /// on the axis by first-order optics, whatever medium the film stands in.
    pub fn f_number(&self) -> f64 {
        self.focal_length.abs() / self.entrance_pupil.diameter
    }

    /// Returns the object distance before the front vertex (mm) that is in focus on a film
    /// `distance` mm behind the rear vertex; infinite, or negative if nothing real is in focus.
    pub fn object_distance(&self, distance: f64) -> f64 {
        let RayTransferMatrix { a, b, c, d } = self.whole;
        let reduced = distance / self.film_index;
        -(b + reduced * d) / (a + reduced * c)
    }

    /// Returns the image distance behind the rear vertex (mm) of an axis point `object` mm (or
    /// infinitely far) before the front vertex; negative if the image is virtual.
    pub fn image_distance(&self, object: f64) -> f64 {
        let RayTransferMatrix { a, b, c, d } = self.whole;
        let reduced =
            if object.is_infinite() { -a / c } else { -(a * object + b) / (c * object + d) };
        reduced * self.film_index
    }

    /// Returns the transverse magnification of an object `object` mm (or infinitely far) before the
    /// front vertex.
    pub fn magnification(&self, object: f64) -> f64 {
        if object.is_infinite() {
            return 0.0;
        }
        self.whole.a + self.whole.c * self.image_distance(object) / self.film_index
    }

    /// Returns the slope in the scene, per mm of image height, of the chief ray [1/mm]: the ray
    /// through the centre of the entrance pupil, at `pupil` mm behind the front vertex, to a film
    /// `distance` mm behind the rear vertex.
    ///
    /// This is the chief ray of first-order optics, in closed form;
    /// [`ChiefRayFinder`](crate::ChiefRayFinder) finds that of real rays.
    pub fn chief_slope(&self, pupil: f64, distance: f64) -> f64 {
        let RayTransferMatrix { a, b, c, d } = self.whole;
        let reduced = distance / self.film_index;
        1.0 / (b - a * pupil + reduced * (d - c * pupil))
    }

    /// Returns the distance of the film behind the rear vertex (mm) that focuses on objects `focus`
    /// mm (or infinitely far) before the film plane.
    ///
    /// # Errors
    /// Returns an error if the lens cannot focus so near, or forms no image.
    pub fn film_for_focus(&self, focus: f64) -> Result<f64, FocusError> {
        let (focal_length, back_focal_distance) = (self.focal_length, self.back_focal_distance);
        // Behind an intermediate image the focal length is negative, and the image is real.
        if self.is_afocal() || (focal_length <= 0.0 && back_focal_distance <= 0.0) {
            return Err(FocusError::NoImage { focal_length, back_focal_distance });
        }
        let real = |film: f64| match film > 0.0 {
            true => Ok(film),
            false => Err(FocusError::NoImage { focal_length, back_focal_distance }),
        };
        if focus.is_infinite() {
            return real(back_focal_distance);
        }
        // With the object at s = focus - length - p x before the front vertex, p the direction of
        // travel behind the lens, and the reduced film distance x: x (c s + d) + a s + b = 0, a
        // quadratic in x. The root next to the focal point belongs to distant objects.
        let RayTransferMatrix { a, b, c, d } = self.whole;
        let n = self.film_index;
        let signed = self.travel * n;
        let half = |k: f64| (c * k + d - a * signed) / 2.0;
        let discriminant = |k: f64| half(k) * half(k) + c * signed * (a * k + b);
        let k = focus - self.length;
        let roots = discriminant(k);
        // discriminant(k) is a parabola in k with its larger zero at the nearest focus.
        let free = d - a * signed;
        let (p, q) = (c * c / 4.0, c * free / 2.0 + c * signed * a);
        let r = free * free / 4.0 + c * signed * b;
        let nearest = (-q + (q * q - 4.0 * p * r).max(0.0).sqrt()) / (2.0 * p);
        // With the film on the scene side of a mirror any distance may be in focus.
        let too_near = self.travel > 0.0 && focal_length > 0.0 && k < nearest;
        if roots < 0.0 || too_near {
            return Err(FocusError::TooNear { asked: focus, nearest: nearest + self.length });
        }
        let root = roots.sqrt();
        let near = |sign: f64| (half(k) + sign * root) / (c * signed) * n;
        let film = |x: f64| (x - self.back_focal_distance).abs();
        let (one, other) = (near(1.0), near(-1.0));
        real(if film(one) < film(other) { one } else { other })
    }
}
