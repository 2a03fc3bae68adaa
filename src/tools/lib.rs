//! Measurements with the renderer: camera models against each other, pictures, data sets and rates.
//!
//! [`accuracy`] renders a scene with a ladder of camera models and measures error and time of each.
//! [`metric`] compares two pictures. [`dataset`] renders pairs of pictures for training. [`mod@bench`]
//! measures the rates of the stages. [`chart_analysis`] measures photographed test charts, [`sensor_analysis`] readings
//! of uniform fields. [`charts`] draws test charts for a camera.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod accuracy;
pub mod bench;
pub mod chart_analysis;
pub mod charts;
pub mod dataset;
pub mod metric;
pub mod sensor_analysis;
