//! Inputs of all analyses of a report: the lens, its traced fields, and names for both.

use std::sync::OnceLock;

use petzval_lens::{FieldKind, Prescription};
use petzval_optics::{FieldRays, ImageQuality};

use super::curves::FieldCurves;
use super::fans::Fans;
use super::wave::PointImages;
use crate::number::rounded;
use crate::plot::colour;

/// A lens with its traced fields.
pub(super) struct ReportInputs {
    /// The lens at its primary wavelength.
    pub lens: Prescription,
    pub quality: ImageQuality,
    /// Fields that are shown one by one.
    pub shown: Vec<FieldRays>,
    /// Fields that have no chief ray, in ascending order.
    pub left_out: Vec<f64>,
    /// Largest frequency of the MTF that the user asks for (cycles / mm).
    pub frequency: Option<f64>,
    fans: OnceLock<Fans>,
    field_curves: OnceLock<FieldCurves>,
    point_images: OnceLock<PointImages>,
}

impl ReportInputs {
    pub fn new(
        lens: Prescription,
        quality: ImageQuality,
        (shown, left_out): (Vec<FieldRays>, Vec<f64>),
        frequency: Option<f64>,
    ) -> Self {
        let (fans, field_curves, point_images) = Default::default();
        Self { lens, quality, shown, left_out, frequency, fans, field_curves, point_images }
    }

    /// Returns the fans of the shown fields.
    pub fn fans(&self) -> &Fans {
        self.fans.get_or_init(|| Fans::new(self))
    }

    /// Returns the imagery next to the chief rays.
    pub fn field_curves(&self) -> &FieldCurves {
        self.field_curves.get_or_init(|| FieldCurves::new(self))
    }

    /// Returns the point images of the shown fields.
    pub fn point_images(&self) -> &PointImages {
        self.point_images.get_or_init(|| PointImages::new(self))
    }

    /// Returns the rays of a field, if it is shown or one of the even fields and has a chief ray.
    pub fn traced(&self, field: f64) -> Option<&FieldRays> {
        self.shown.iter().chain(&self.quality.fields).find(|rays| rays.field == field)
    }

    /// Returns the name of a field, such as "14 mm" or "20°".
    pub fn field_name(&self, field: f64) -> String {
        format!("{} {}", rounded(field), self.field_unit())
    }

    /// Returns the name of a field with the angle of its chief ray, such as "14 mm (15.6°)"; for an
    /// angle with the image height.
    pub fn field_title(&self, field: f64) -> String {
        let name = self.field_name(field).replace(" deg", "°");
        if field == 0.0 {
            return "on axis".to_owned();
        }
        let Some(rays) = self.traced(field) else { return name };
        let chief = rays.chief(self.quality.conditions.primary);
        let angle = chief.map_or(f64::NAN, |chief| chief.angle().to_degrees());
        match self.quality.conditions.field_kind {
            FieldKind::Angle => format!("{name} ({:.2} mm)", rays.reference.point[1] + 0.0),
            _ if angle.is_finite() => format!("{name} ({:.1}°)", angle.abs()),
            _ => name,
        }
    }

    pub fn field_unit(&self) -> &'static str {
        match self.quality.conditions.field_kind {
            FieldKind::Angle => "deg",
            FieldKind::ObjectHeight | FieldKind::ImageHeight => "mm",
        }
    }

    /// Returns the name of the field axis.
    pub fn field_axis(&self) -> String {
        let what = match self.quality.conditions.field_kind {
            FieldKind::Angle => "field angle",
            FieldKind::ObjectHeight => "object height",
            FieldKind::ImageHeight => "image height",
        };
        format!("{what} ({})", self.field_unit())
    }

    /// Returns the name of the column of the field.
    pub fn field_column(&self) -> &'static str {
        match self.quality.conditions.field_kind {
            FieldKind::Angle => "field_deg",
            FieldKind::ObjectHeight | FieldKind::ImageHeight => "field_mm",
        }
    }

    /// Returns the name of a wavelength.
    pub fn wavelength_name(&self, wavelength: usize) -> String {
        format!("{} nm", rounded(self.quality.conditions.wavelengths[wavelength].nm))
    }

    /// Returns the colour of a wavelength.
    pub fn wavelength_colour(&self, wavelength: usize) -> usize {
        let lines = &self.quality.conditions.wavelengths;
        let nm = lines[wavelength].nm;
        colour(lines.iter().filter(|line| line.nm < nm).count(), lines.len())
    }

    pub fn wavelengths(&self) -> std::ops::Range<usize> {
        0..self.quality.conditions.wavelengths.len()
    }

    pub fn nm(&self, wavelength: usize) -> f64 {
        self.quality.conditions.wavelengths[wavelength].nm
    }

    /// Returns the colour of a shown field.
    pub fn field_colour(&self, i: usize) -> usize {
        colour(i, self.shown.len())
    }
}
