//! Field curvature, astigmatism, distortion and lateral colour.

use super::chief::ChiefRay;
use super::conditions::ImagingConditions;
use super::image_quality::ImageQuality;
use super::lens_at_wavelength::{FilmRay, LensAtWavelength};
use petzval_lens::FieldKind;

/// Displacement of the neighbours of a chief ray, relative to the entrance pupil.
const NEAR: f64 = 1e-3;
/// Share of the field at which the linear image scale is measured.
const PARAXIAL: f64 = 1e-3;

/// Imagery of a field point at one wavelength, next to its chief ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldCurvePoint {
    /// Field coordinate.
    pub field: f64,
    /// Angle of the chief ray to the axis before the lens (degrees).
    pub angle: f64,
    /// Sagittal and tangential focus behind the film (mm, along the axis).
    pub foci: [f64; 2],
    /// Image height of the chief ray (mm).
    pub height: f64,
    /// Image height without distortion: linear in the tangent of the field angle, or in the height
    /// of the object (mm).
    pub linear_height: f64,
    /// Image height of a lens that images angles linearly (mm).
    pub f_theta_height: f64,
}

impl FieldCurvePoint {
    /// A field without a chief ray.
    const DARK: Self = Self {
        field: f64::NAN,
        angle: f64::NAN,
        foci: [f64::NAN; 2],
        height: f64::NAN,
        linear_height: f64::NAN,
        f_theta_height: f64::NAN,
    };

    /// Returns the distortion: relative excess of the image height; `None` on the axis and beyond
    /// 90 degrees.
    pub fn distortion(&self) -> Option<f64> {
        relative(self.height, self.linear_height).filter(|_| self.angle.abs() < 90.0)
    }

    /// Returns the distortion relative to f theta; `None` on the axis.
    pub fn f_theta_distortion(&self) -> Option<f64> {
        relative(self.height, self.f_theta_height)
    }
}

fn relative(height: f64, ideal: f64) -> Option<f64> {
    (ideal != 0.0).then(|| (height - ideal) / ideal)
}

impl LensAtWavelength {
    /// Returns the sagittal and the tangential focus behind the film (mm), by rays next to the
    /// chief ray.
    fn foci(&self, chief: &ChiefRay) -> Option<[f64; 2]> {
        let unit = NEAR * self.pupil_unit(chief);
        let ray = |at: [f64; 2]| self.traced(chief, at);
        let focus = |d: [f64; 2], axis: usize| -> Option<f64> {
            let (a, b) = (ray(d)?, ray(d.map(|d| -d))?);
            let slope = |ray: &FilmRay| ray.t[axis] / ray.t[2];
            Some(-(a.point[axis] - b.point[axis]) / (slope(&a) - slope(&b)))
        };
        Some([focus([unit, 0.0], 0)?, focus([0.0, unit], 1)?])
    }
}

impl ImageQuality {
    /// Returns the imagery next to the chief rays at a wavelength, from the axis to the edge of the
    /// field in `count` steps. A field without a chief ray has NaN for all numbers but itself.
    pub fn field_curve(&self, wavelength: usize, count: u32) -> Vec<FieldCurvePoint> {
        let lens = &self.lenses[wavelength];
        let scale = self.linear_scale(wavelength);
        self.even_fields(count)
            .map(|field| {
                let Some(chief) = self.chief_at(wavelength, field) else {
                    return FieldCurvePoint { field, ..FieldCurvePoint::DARK };
                };
                let [linear, theta] = scale.heights(&chief, &self.conditions);
                FieldCurvePoint {
                    field,
                    angle: chief.angle().to_degrees(),
                    foci: lens.foci(&chief).unwrap_or([f64::NAN; 2]),
                    height: chief.film[1],
                    linear_height: linear,
                    f_theta_height: theta,
                }
            })
            .collect()
    }

    /// Returns the fields from the axis to the edge in `count` steps.
    fn even_fields(&self, count: u32) -> impl Iterator<Item = f64> {
        let largest = self.conditions.largest_field;
        (0..=count).map(move |i| largest * f64::from(i) / f64::from(count))
    }

    /// Returns the chief ray at a wavelength of the object point that the primary wavelength
    /// images to a field.
    pub fn chief_at(&self, wavelength: usize, field: f64) -> Option<ChiefRay> {
        let primary = self.primary().chief_of_field(&self.conditions, [0.0, field])?;
        match wavelength == self.conditions.primary {
            true => Some(primary),
            false => self.lenses[wavelength].chief_of_object(&primary),
        }
    }

    /// Returns the distance on the film (mm) of the chief ray of each wavelength from that of the
    /// primary one, for fields from the axis to the edge in `count` steps, with the field. It is
    /// `None` at a wavelength without a chief ray, and at all of them if the primary one has none.
    pub fn lateral_colour(&self, count: u32) -> Vec<(f64, Vec<Option<f64>>)> {
        self.even_fields(count)
            .map(|field| {
                let primary = self.primary().chief_of_field(&self.conditions, [0.0, field]);
                let shift = |lens: &LensAtWavelength| {
                    let primary = primary.as_ref()?;
                    Some(lens.chief_of_object(primary)?.film[1] - primary.film[1])
                };
                (field, self.lenses.iter().map(shift).collect())
            })
            .collect()
    }

    /// Returns the image scale at the axis.
    fn linear_scale(&self, wavelength: usize) -> LinearScale {
        let field = PARAXIAL * self.conditions.largest_field;
        let chief = self.chief_at(wavelength, field);
        chief.map_or(LinearScale([f64::NAN; 3]), |chief| {
            LinearScale([
                chief.film[1] / chief.angle().tan(),
                chief.film[1] / object_height(&chief, &self.conditions).unwrap_or(f64::NAN),
                chief.film[1] / chief.angle(),
            ])
        })
    }
}

/// Image height per tangent, per mm of object height and per radian, at the axis.
struct LinearScale([f64; 3]);

impl LinearScale {
    /// Returns the image heights of a linear lens and of an f-theta lens.
    fn heights(&self, chief: &ChiefRay, conditions: &ImagingConditions) -> [f64; 2] {
        let by_angle = self.0[0] * chief.angle().tan();
        let linear = match conditions.field_kind {
            // Seen from the entrance pupil, angles are linear with heights at no distance.
            _ if conditions.object_distance.is_infinite() => by_angle,
            FieldKind::Angle => by_angle,
            _ => object_height(chief, conditions).map_or(by_angle, |height| self.0[1] * height),
        };
        [linear, self.0[2] * chief.angle()]
    }
}

/// Returns the height of a near object point.
fn object_height(chief: &ChiefRay, conditions: &ImagingConditions) -> Option<f64> {
    let s = (-conditions.object_distance - chief.scene.point[2]) / chief.scene.direction[2];
    s.is_finite().then(|| chief.scene.point[1] + s * chief.scene.direction[1])
}

impl ChiefRay {
    /// Returns the signed angle to the axis before the lens, in the plane of y (rad).
    pub fn angle(&self) -> f64 {
        self.scene.direction[1].atan2(self.scene.direction[2])
    }
}
