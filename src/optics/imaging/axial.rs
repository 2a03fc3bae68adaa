//! Longitudinal aberration and chromatic focal shift on the axis.

use super::image_quality::ImageQuality;

/// Focus on the axis of a zone of the pupil.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ZoneFocus {
    /// Height in the stop, relative to its radius.
    pub zone: f64,
    /// Where the ray crosses the axis, behind the film (mm).
    pub focus: f64,
}

impl ImageQuality {
    /// Returns the longitudinal aberration at a wavelength in `count` zones; the first is the
    /// paraxial focus. Zones without a ray are left out.
    pub fn longitudinal_aberration(&self, wavelength: usize, count: u32) -> Vec<ZoneFocus> {
        let lens = &self.lenses[wavelength];
        let Some(chief) = self.chief_at(wavelength, 0.0) else { return Vec::new() };
        (0..=count)
            .filter_map(|i| {
                let zone = f64::from(i) / f64::from(count);
                if i == 0 {
                    return Some(ZoneFocus { zone, focus: self.paraxial_focus(wavelength) });
                }
                let ray = lens.aim(&chief, [0.0, zone])?;
                Some(ZoneFocus { zone, focus: -ray.point[1] * ray.t[2] / ray.t[1] })
            })
            .collect()
    }

    /// Returns the paraxial focus at a wavelength, behind the film (mm).
    pub fn paraxial_focus(&self, wavelength: usize) -> f64 {
        let paraxial = &self.lenses[wavelength].paraxial;
        let image = paraxial.image_distance(self.conditions.object_distance);
        image * paraxial.travel - self.conditions.film_distance
    }
}
