//! Pictures and pages for people: SVG drawings, plots, contact sheets, reports of lenses and of accuracy.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod accuracy;
pub mod contact_sheet;
pub mod date;
pub mod lens_drawing;
pub mod lens_report;
pub mod number;
pub mod svg;
