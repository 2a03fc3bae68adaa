//! Accuracy against time: one scene, photographed by a ladder of camera models, each with a ladder
//! of sample counts, measured against the richest model within a time budget.
//!
//! # Method
//!
//! The error of a picture has two parts: noise, which falls as samples rise, and the error of the
//! model, which stays. [`Point::error`] is both, against a [`Reference`] of the richest model that
//! has seeds of its own and most of the time. [`Point::noise`] is the first part and
//! [`Point::bias`] the second; four independent quarters of the samples tell them apart ([`Bias`]).
//! All rungs take the same seeds, so differences between their pictures are mostly those between
//! their models.
//!
//! Diffraction and the sensor work on the finished picture and are left out of all rungs.

mod bias;
mod frontier;
mod ladder;
mod machine;
mod monitor;
mod point;
mod relative_time;
mod run;
mod runner;
mod split_picture;

pub use bias::{Bias, bias};
pub use frontier::frontier;
pub use ladder::{Ladder, Rung};
pub use machine::Machine;
pub use monitor::RunMonitor;
pub use point::{Point, Reference};
pub use relative_time::RelativeTime;
pub use run::{Budget, LadderError, LadderRun, RunEnd, run_ladder};
pub use split_picture::{QUARTERS, SplitPicture};
