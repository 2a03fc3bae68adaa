//! Seidel sums by surface, and first-order chromatic sums.
//!
//! A marginal and a chief ray of first-order optics give the five sums of each surface (Welford,
//! "Aberrations of Optical Systems", 1986, 8.2 to 8.4). Mirrors have an index of the other sign
//! behind them. The part of a figured surface follows its terms of fourth order.

use super::conditions::ImagingConditions;
use super::image_quality::ImageQuality;
use petzval_lens::{Paraxial, RayTransferMatrix};
use petzval_lens::{Prescription, TransverseAxis};
use petzval_spectrum::IndexRangeError;

/// Sums of a surface, or of all (mm).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SeidelSums {
    /// S_I to S_V: spherical aberration, coma, astigmatism, Petzval curvature, distortion.
    pub monochromatic: [f64; 5],
    /// C_L and C_T: axial and lateral colour between the ends of the spectrum.
    pub chromatic: [f64; 2],
}

/// Seidel aberrations of a lens at the primary wavelength.
#[derive(Clone, Debug, PartialEq)]
pub struct Seidel {
    /// Sums of each row.
    pub rows: Vec<SeidelSums>,
    /// Sums of the lens.
    pub total: SeidelSums,
    /// Lagrange invariant (mm).
    pub invariant: f64,
    /// Radius of the Petzval surface (mm), negative if it is hollow towards the lens.
    pub petzval_radius: f64,
}

impl SeidelSums {
    fn add(&mut self, other: &Self) {
        for (sum, term) in self.monochromatic.iter_mut().zip(other.monochromatic) {
            *sum += term;
        }
        for (sum, term) in self.chromatic.iter_mut().zip(other.chromatic) {
            *sum += term;
        }
    }

    /// Returns the wavefront coefficients W040, W131, W222, W220 (Petzval), W311, W020 and W111
    /// (mm).
    pub fn wavefront(&self) -> [f64; 7] {
        let [s1, s2, s3, s4, s5] = self.monochromatic;
        let [cl, ct] = self.chromatic;
        [s1 / 8.0, s2 / 2.0, s3 / 2.0, s4 / 4.0, s5 / 2.0, cl / 2.0, ct]
    }
}

/// A ray of first-order optics: height and slope times index.
#[derive(Clone, Copy)]
struct ParaxialRay {
    y: f64,
    nu: f64,
}

impl ParaxialRay {
    fn through(self, m: RayTransferMatrix) -> Self {
        Self { y: m.a * self.y + m.b * self.nu, nu: m.c * self.y + m.d * self.nu }
    }
}

impl ImageQuality {
    /// Returns the Seidel sums of the lens, for the largest field and the full stop. Tilt and
    /// decentre are ignored, and sections differ only by their curvature along y.
    ///
    /// # Errors
    /// Returns an error if a glass has no data at a wavelength.
    pub fn seidel(&self, lens: &Prescription) -> Result<Seidel, IndexRangeError> {
        let conditions = &self.conditions;
        let lens = lens.at_wavelength(conditions.primary_line().nm)?;
        let [short, long] = conditions.spectral_ends();
        let dispersion = |i: usize| -> Result<Prescription, IndexRangeError> {
            lens.at_wavelength(conditions.wavelengths[i].nm)
        };
        let ends = [dispersion(short)?, dispersion(long)?];
        let plane = TransverseAxis::Y;
        let paraxial = Paraxial::in_plane(&lens, plane);
        let [mut marginal, mut chief] = self.paraxial_rays(&paraxial, conditions);
        let invariant = marginal.y * chief.nu - marginal.nu * chief.y;
        let media = lens.all_signed_indices();
        let media_at_ends = [ends[0].all_signed_indices(), ends[1].all_signed_indices()];
        let mut rows = Vec::with_capacity(lens.rows.len());
        let mut total = SeidelSums::default();
        for (i, row) in lens.rows.iter().enumerate() {
            let after = |ray: ParaxialRay| {
                ray.through(RayTransferMatrix::IDENTITY.through(row, media[i], plane))
            };
            let [n, n_after] = media[i];
            let c = row.curvatures()[1];
            let (m, k) = (after(marginal), after(chief));
            // Refraction invariants n i = n u + n c y.
            let [a, b] = [marginal.nu + n * c * marginal.y, chief.nu + n * c * chief.y];
            let y = marginal.y;
            let step = m.nu / (n_after * n_after) - marginal.nu / (n * n);
            let inverse = 1.0 / n_after - 1.0 / n;
            let inverse2 = 1.0 / (n_after * n_after) - 1.0 / (n * n);
            let h = invariant;
            let mut sums = [
                -a * a * y * step,
                -a * b * y * step,
                -b * b * y * step,
                -h * h * c * inverse,
                // (b / a) (S_III + S_IV), without the division (Hopkins 1950).
                -b * (b * b * y * inverse2 - (h + b * y) * chief.y * c * inverse),
            ];
            let figure = fourth_order(row) * (n_after - n) * y.powi(4);
            let ratio = if y == 0.0 { 0.0 } else { chief.y / y };
            for (sum, power) in sums.iter_mut().zip([0, 1, 2]) {
                *sum += figure * ratio.powi(power);
            }
            sums[4] += figure * ratio.powi(3);
            // Dispersion over index, negative indices behind mirrors included.
            let spread = |side: usize| {
                let [short, long] = [0, 1].map(|end: usize| media_at_ends[end][i][side]);
                (short - long) / [n, n_after][side]
            };
            let colour = spread(0) - spread(1);
            let sums =
                SeidelSums { monochromatic: sums, chromatic: [a * y * colour, b * y * colour] };
            total.add(&sums);
            rows.push(sums);
            let on = |ray: ParaxialRay| ParaxialRay {
                y: ray.y + row.thickness * ray.nu / n_after,
                ..ray
            };
            (marginal, chief) = (on(m), on(k));
        }
        let petzval: f64 = lens
            .rows
            .iter()
            .enumerate()
            .map(|(i, row)| {
                let [n, n_after] = media[i];
                row.curvatures()[1] * (1.0 / n_after - 1.0 / n)
            })
            .sum();
        let image_index = media[media.len() - 1][1];
        Ok(Seidel { rows, total, invariant, petzval_radius: 1.0 / (image_index * petzval) })
    }

    /// Returns the marginal and the chief ray at the front vertex.
    fn paraxial_rays(
        &self,
        paraxial: &Paraxial,
        conditions: &ImagingConditions,
    ) -> [ParaxialRay; 2] {
        let pupil = paraxial.entrance_pupil;
        let object = conditions.object_distance;
        let reach = object + pupil.position;
        let slope = pupil.diameter / 2.0 / reach;
        let marginal = match object.is_finite() {
            true => ParaxialRay { y: slope * object, nu: slope },
            false => ParaxialRay { y: pupil.diameter / 2.0, nu: 0.0 },
        };
        // The image height of the edge of the field by first-order optics.
        let height = self.largest_image_height();
        let film = conditions.film_distance;
        let slope = height * paraxial.chief_slope(pupil.position, film);
        [marginal, ParaxialRay { y: -slope * pupil.position, nu: slope }]
    }

    /// Returns the image height of the largest field that the lens images (mm).
    pub fn largest_image_height(&self) -> f64 {
        let heights = self.fields.iter().map(|field| field.reference.point[1].abs());
        heights.fold(0.0, f64::max)
    }
}

/// Returns 8 times the coefficient of h^4 of a surface, minus that of the sphere of its curvature.
pub fn fourth_order(row: &petzval_lens::Row) -> f64 {
    let term =
        |power: u32| row.asphere.iter().filter(|(p, _)| *p == power).map(|(_, a)| a).sum::<f64>();
    let conic = row.radius.recip();
    let vertex = row.curvature();
    8.0 * term(4) + (1.0 + row.conic) * conic.powi(3) - vertex.powi(3)
}
