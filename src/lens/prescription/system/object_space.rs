//! Object inside a medium: immersed objectives, eyepieces that are stated from the eye, cover glasses.
//!
//! The space before the first row of a prescription is air. An object inside a medium is read as
//! standing in air at a plane window, behind which the medium begins. The window has no power, so that
//! focal length, pupils and magnifications are those of the file. A near object touches the window:
//! rays leave the window from the object point itself, and no aberration is added. Directions before
//! the window obey the law of refraction, as field angles do.

use super::{MediumBehind, SequentialSystem, SystemSurface};
use crate::prescription::Row;
use crate::prescription::design::FieldKind;
use crate::prescription::limits::INFINITE;

/// Distance of a near object from its window, in units of that of the object: it shifts images by a
/// millionth of the object distance at most.
const GAP: f64 = 1e-6;

/// Distance of the window before a lens whose object is distant, if the lens states no diameter (mm).
const WINDOW: f64 = 10.0;

impl SequentialSystem {
    /// Puts a window before the medium of the object, unless that is air.
    pub(super) fn put_window_before_object_medium(&mut self) {
        let nm = self.design.primary_wavelength();
        let index = match &self.object_medium {
            MediumBehind::Air | MediumBehind::Same | MediumBehind::Mirror => return,
            MediumBehind::Index(index) => *index,
            MediumBehind::Glass(glass) => glass.nearest_index(1.0, nm),
        };
        let Some(first) = self.surfaces.first() else { return };
        let near = self.design.object_distance.filter(|at| *at > 0.0 && *at < INFINITE);
        let (thickness, object) = match near {
            Some(distance) => (distance * (1.0 - GAP), distance * GAP),
            None => (first.semi_diameter.map_or(WINDOW, |semi| 2.0 * semi), f64::INFINITY),
        };
        self.design.object_distance = Some(object);
        let mut note = format!(
            "the object stands in a medium of index {index:.4}; it is read as standing in air, at a \
             plane window before the medium"
        );
        if let Some(fields) = &mut self.design.fields
            && fields.kind == FieldKind::Angle
        {
            let count = fields.points.len();
            fields.points =
                fields.points.iter().filter_map(|angle| in_air(*angle, index)).collect();
            note += ", and its field angles are those in air";
            if fields.points.len() < count {
                note += "; those that the window reflects totally are left out";
            }
        }
        self.design.notes.push(note);
        let heights =
            self.design.fields.iter().filter(|fields| fields.kind == FieldKind::ObjectHeight);
        let heights = heights.flat_map(|fields| &fields.points).map(|[x, y]| x.hypot(*y));
        let highest = heights.fold(0.0, f64::max);
        let window = SystemSurface {
            line: first.line,
            row: Row { thickness, ..Row::default() },
            medium: self.object_medium.clone(),
            semi_diameter: (near.is_some() && highest > 0.0).then_some(1.02 * highest),
            ..SystemSurface::default()
        };
        self.surfaces.insert(0, window);
        for configuration in &mut self.design.configurations {
            configuration.settings.iter_mut().for_each(|setting| setting.row += 1);
        }
    }
}

/// Returns the field angle in air (degrees along x and y) of a direction inside a medium; `None` if a
/// plane window reflects it totally.
fn in_air(angle: [f64; 2], index: f64) -> Option<[f64; 2]> {
    let [x, y] = angle.map(|degrees| degrees.to_radians().tan());
    let length = x.hypot(y).hypot(1.0);
    let sines = [x, y].map(|along| index * along / length);
    let cosine = 1.0 - sines[0].powi(2) - sines[1].powi(2);
    (cosine > 0.0).then(|| sines.map(|sine| (sine / cosine.sqrt()).atan().to_degrees()))
}
