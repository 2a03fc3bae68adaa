//! Optics: analysis, calibration, tolerances and models of lenses.

#[path = "../support/mod.rs"]
mod support;

mod calibrate;
mod charts;
mod draw;
mod edge_response;
mod exposure;
mod fidelity;
mod limits;
mod report;
mod tolerance;
mod vignetting;
