//! Pictures and pages for people: SVG drawings, plots, contact sheets, reports of lenses, of accuracy and of
//! measurements.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod accuracy;
pub mod contact_sheet;
pub mod date;
pub mod lens_drawing;
pub mod lens_report;
pub mod measurement;
pub mod number;
mod page;
pub mod plot;
pub mod svg;
