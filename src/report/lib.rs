//! Pictures and pages for people: SVG drawings, plots, contact sheets and the accuracy report.

pub mod accuracy;
pub mod contact_sheet;
pub mod date;
pub mod lens_drawing;
pub mod svg;
