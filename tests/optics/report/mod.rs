//! Image quality by real rays: against formulas, against naive traces, and the report's files.

mod against_formulas;
mod against_naive_rays;
mod command;

use petzval_lens::{Prescription, Row};
use petzval_optics::{ConditionChoices, ImageQuality, ImagingConditions, ImagingGrid};

/// Reads a lens of the repository.
fn lens(file: &str) -> Prescription {
    petzval_lens_formats::read(&crate::support::root().join("lenses").join(file)).expect("a lens")
}

/// Conditions of a lens for a distant object and this largest image height (mm).
fn conditions(lens: &Prescription, image_height: f64) -> ImagingConditions {
    let choices = ConditionChoices { image_height: Some(image_height), ..Default::default() };
    ImagingConditions::new(lens, choices).expect("a lens that can be focused")
}

fn traced(lens: &Prescription, conditions: ImagingConditions, fields: usize) -> ImageQuality {
    let grid = ImagingGrid { fields, pupil: 64, threads: 1 };
    ImageQuality::new(lens, conditions, grid).expect("glasses with data")
}

/// A paraboloid of f = 100 mm: perfect on the axis.
fn paraboloid() -> (Prescription, ImagingConditions) {
    let mirror = Row {
        radius: -200.0,
        conic: -1.0,
        diameter: 40.0,
        mirror: true,
        stop: true,
        ..Row::default()
    };
    let lens = Prescription::new("paraboloid", vec![mirror]).expect("one stop");
    let mut conditions = conditions(&lens, 1.0);
    conditions.film_distance = 100.0;
    (lens, conditions)
}
