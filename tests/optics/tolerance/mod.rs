//! Tolerances and optimization of lenses: against direct traces, formulas, and the commands.

mod command;
mod optimization;
mod tolerances;

use petzval_lens::{Prescription, Row};
use petzval_optics::{ConditionChoices, ImagingConditions};

/// Conditions of a lens for a distant object and this largest image height (mm).
fn conditions(lens: &Prescription, image_height: f64) -> ImagingConditions {
    let choices = ConditionChoices { image_height: Some(image_height), ..Default::default() };
    ImagingConditions::new(lens, choices).expect("a lens that can be focused")
}

/// Reads a lens of the repository.
fn lens(file: &str) -> Prescription {
    petzval_lens_formats::read(&crate::support::root().join("lenses").join(file)).expect("a lens")
}

/// A thin lens of these curvatures (1/mm) and index 1.5, with the stop at its front.
fn singlet(curvatures: [f64; 2], diameter: f64) -> Prescription {
    let rows = vec![
        Row {
            radius: curvatures[0].recip(),
            thickness: 0.5,
            index: 1.5,
            diameter,
            stop: true,
            ..Row::default()
        },
        Row { radius: curvatures[1].recip(), diameter: diameter * 1.2, ..Row::default() },
    ];
    Prescription::new("singlet", rows).expect("one stop")
}
