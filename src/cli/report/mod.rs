//! Pictures and pages for people: SVG drawings, plots, contact sheets and the accuracy report.

pub(super) mod accuracy;
pub(super) mod contact_sheet;
pub(super) mod date;
pub(super) mod lens_drawing;
pub(in crate::cli) mod svg;
